"""A lane of an ensemble is the motion alone: every measure of systems of every kind, one table for all machines."""

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.measures.standard import undefined_measures

LEVELS = vc.Exponential(coulomb_coefficient=0.1, static_coefficient=0.2)
UNEVEN = vc.anisotropic(vc.Coulomb)(0.1, 0.1, back_ratio=2.0)
LINKAGE = vc.LinkageCrawler(mass_ratio_2=1.7, stiffness=4.0)
STRUCK = vc.RigidStopCapsule(gap=0.3, restitution=0.6, actuation="external", normal_load=0.4, mass_ratio=5.0)
TWO_SIDED = vc.RigidStopCapsule(gap=0.3, back_gap=0.4, restitution=0.8)
WALLS = vc.OscillatorWithStops(damping=0.05, gap=0.8, back_gap=0.8, restitution=0.7)
DYNAMIC = vc.PendulumCapsule(normal_load="dynamic", mass_ratio=4.0)
ROTOR = vc.RotorCapsule(4.0, 0.75)
AROUND = vc.Environment(inclination=-0.11, linear_drag=0.15, quadratic_drag=0.3, force=0.07)
LIMITS = vc.Actuator(time_constant=0.5, limit=1.2, command_limit=1.5)
SAMPLED = vc.SampledPositionPID(3.0, 4.0, 6.0, sample_time=0.02, delay=0.01)
SHAKEN = vc.Biharmonic(amplitude=1.0, frequency=0.4, second_amplitude=0.5, second_phase=0.4)

# system, what varies, its values, start, periods
SYSTEMS = {
    "corners behind a limited actuator": (
        vc.System(vc.PendulumCapsule(), LEVELS, vc.Square(1.8, 1.3, duty=0.4), actuator=LIMITS),
        "drive.duty", [0.3, 0.4, 0.55], {"angle": 0.3}, 4,
    ),
    "load, slope and drag": (
        vc.System(DYNAMIC, LEVELS, vc.Harmonic(1.8), environment=AROUND),
        "environment.inclination", [-0.05, 0.0, 0.1], {"angle": 0.2}, 4,
    ),
    "two laws, one of bristles": (
        vc.System(
            vc.TwoBodyWorm(mass_2=1.5, normal_load_2=1.2), [UNEVEN, vc.LuGre()], vc.Triangle(amplitude=0.5, rise=0.3)
        ),
        "drive.amplitude", [0.45, 0.5, 0.55], {}, 3,
    ),
    "rigid stop": (
        vc.System(STRUCK, vc.Coulomb(0.3, 0.4), vc.Harmonic(1.6, 0.95)), "drive.frequency", [0.8, 0.9, 1.2], {}, 4,
    ),
    "sampled controller": (
        vc.System(vc.Oscillator(stiffness=0.0), vc.Coulomb(1.0, 1.5), vc.Constant(), controller=SAMPLED),
        "controller.sample_time", [0.02, 0.05], {"position": -1.0}, 6,
    ),
    "elastic link": (
        vc.System(
            vc.TwoBodyCrawler(mass_2=2.4, damping=0.05, normal_load_2=1.2), vc.Coulomb(0.06, 0.09), SHAKEN
        ),
        "drive.amplitude", [0.9, 1.0, 1.1], {}, 3,
    ),
    "linkage": (
        vc.System(LINKAGE, vc.Coulomb(0.1, 0.1), vc.Biharmonic(0.5, 1.3, 0.15, 0.5)),
        "drive.amplitude", [0.45, 0.5, 0.55], {}, 3,
    ),
    "two rigid stops and bristles": (
        vc.System(TWO_SIDED, vc.LuGre(), vc.Harmonic(1.6, 0.95)), "drive.frequency", [0.8, 0.95, 1.2], {}, 4,
    ),
    "walls on the ground": (
        vc.System(WALLS, vc.Coulomb(), vc.Harmonic(1.0)), "machine.restitution", [0.6, 0.75, 0.9], {}, 4,
    ),
    "elastic stop": (
        vc.System(vc.VibroImpactCapsule(gap=0.02), vc.Coulomb(0.3, 0.4), vc.Harmonic(1.0, 0.95)),
        "machine.gap", [0.02, 0.1, 0.3], {}, 4,
    ),
    "switch over the end of a period": (
        vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.OnOff(3.0, -1.5, duty=0.35)),
        "drive.phase", [0.0, 0.3, 0.9], {"angle": 0.5}, 4,
    ),
    "turning angle": (
        vc.System(ROTOR, vc.Coulomb(0.1, 0.15), vc.Square(1.6, 0.7, duty=0.8)),
        "drive.amplitude", [0.8, 1.6, 2.4], {"angle": 0.1}, 4,
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but([2, 3], [*SYSTEMS]))
def test_every_measure_of_a_lane_is_that_of_the_motion_alone(name):
    """Works add up in each of them, those of impacts, of drag and of further contacts among them."""
    system, path, values, start, periods = SYSTEMS[name]
    travels = system.machine.cyclic is not None
    measures = [each for each in vc.measure_table(system) if travels or each not in undefined_measures(system)]
    options = {"initial": start, "periods": periods, "tolerance": 1e-11}
    results = vc.ensemble(system, {path: values}, measures=measures, window=periods, **options)
    assert not results["status"].any()
    for i, value in enumerate(values):
        motion = vc.simulate(system.with_parameters({path: value}), **options)
        assert motion.certificate.ok, motion.certificate.failures
        assert len(motion.events) > 3
        alone = vc.measured(motion, measures, window=periods)
        for measure in measures:
            result, wanted = results[measure][i], alone[measure]
            close = (
                result == wanted
                if isinstance(wanted, str)
                else result == pytest.approx(wanted, 1e-8, 1e-9, nan_ok=True)
            )
            assert close, (measure, result, wanted)
    assert np.ptp(results["contact_sliding_work"]) > 1e-3
