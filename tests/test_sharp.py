"""Laws that change within a small speed: nothing of them is stepped over, and a motion that misses it says so.

Their motions are compared with an independent solver in test_sharp_powers.py.
"""

import functools

import numpy as np
import pytest

import vibrocap as vc
from plain_kernels import kernel_of, running_on
from thinned import exhaustive_but, slow_but
from vibrocap.laboratory.driven import driven_equations
from vibrocap.motion.recording.equations import equations
from vibrocap.numerics.codegen.resolution import system_sharpness, visible_speed
from vibrocap.physics.friction.wrappers import smoothed

pytestmark = pytest.mark.plain


def oscillator(**given):
    return vc.Oscillator(mass=1, stiffness=1, normal_load=1, **given)


DIP = vc.System(
    oscillator(damping=0.05, belt_speed=0.38586482190399185),
    vc.Stribeck(
        coulomb_coefficient=0.15,
        static_coefficient=0.45,
        stribeck_velocity=0.001,
        stribeck_exponent=2,
        viscous_damping=0,
    ),
    vc.Harmonic(amplitude=0.4581420135847618, frequency=0.31840840659290537),
)
DIP_START = {"position": 0.26819494181804693, "sliding_velocity": 0.003696111015576209}
# By DOP853 from event to event (independent.py), with steps of at most 0.01 at a tolerance of 1e-13.
DIP_EVENTS = (
    ("stick", 0.17533400607752953),
    ("slip_back", 1.4778605400671239),
    ("stick", 12.709914981661978),
    ("slip_back", 15.23051481410349),
    ("stick", 33.164962506811314),
    ("slip_back", 34.49738473314487),
)


def dip(tolerance=1e-9):
    return vc.simulate(DIP, periods=8, initial=DIP_START, tolerance=tolerance)


@pytest.mark.parametrize(("tolerance", "within"), slow_but([0], [(1e-9, 1e-7), (1e-12, 1e-8)]))
def test_a_dip_of_the_speed_is_not_stepped_over(tolerance, within):
    """At 1e-9 the worst event, after a glancing approach to rest, is 2e-8 off."""
    motion = dip(tolerance)
    assert [event.kind for event in motion.events] == [kind for kind, _ in DIP_EVENTS]
    assert [event.time for event in motion.events] == pytest.approx([time for _, time in DIP_EVENTS], abs=within)
    assert motion.certificate.ok


def test_without_the_proof_the_dip_is_missed_and_the_certificate_says_so():
    """The planted fault: no step is cut. The status says `not certified` as soon as the certificate is asked for."""
    with running_on(kernel_of(DIP), resolved=lambda real, lane, h: True):
        motion = dip()
        times = [event.time for event in motion.events]
        assert (
            len(times) != len(DIP_EVENTS)
            or max(abs(t - time) for t, (_, time) in zip(times, DIP_EVENTS, strict=True)) > 1e-5
        )
        assert motion.status is vc.Status.FINISHED
        certificate = motion.certificate
    assert not certificate.ok
    assert certificate.defect > 1e3 * motion.tolerance
    assert "equations" in certificate.failures[0]
    assert motion.status is vc.Status.NOT_CERTIFIED
    assert not motion.status.ok


@functools.cache
def stepped(law, tolerance):
    """A motion whose steps far from rest are long against the law's own speeds."""
    drive = vc.Harmonic(amplitude=1.8, frequency=1.0)
    return vc.simulate(vc.System(oscillator(damping=0.05, belt_speed=0.3), law, drive), periods=3, tolerance=tolerance)


# each law at one of two tolerances, in turn: another order of the series, another kernel
@pytest.mark.parametrize(
    ("law", "tolerance"),
    slow_but(
        [],
        exhaustive_but(
            range(0, 10, 4),
            [
                (vc.BoucWen(knee_exponent=20.0), 1e-6),
                (vc.BoucWen(knee_exponent=2.5), 1e-9),
                (vc.Dahl(shape_exponent=1.5), 1e-6),
                (vc.Stribeck(stribeck_velocity=2e-3, stribeck_exponent=1.7, viscous_damping=0.0), 1e-9),
                (vc.ElastoPlastic(stribeck_velocity=2e-3), 1e-6),
                (vc.MaxwellSlip(stribeck_velocity=2e-3), 1e-9),
                (vc.RateAndStateAgeing(direct_effect=0.01), 1e-6),
                (vc.anisotropic(vc.Stribeck)(stribeck_velocity=2e-3, viscous_damping=0.0, back_ratio=2.0), 1e-9),
                (vc.backlash(vc.LuGre)(stribeck_velocity=2e-3, gap=0.01), 1e-6),
                (smoothed(vc.Exponential)(decay_rate=300.0, smoothing_velocity=1e-3), 1e-9),
            ],
        ),
    ),
    ids=lambda value: getattr(value, "name", None),
)
def test_every_law_keeps_the_equations_within_every_step(law, tolerance):
    motion = stepped(law, tolerance)
    assert motion.run_status.ok, (
        motion.run_status
    )  # an error within the tolerance made a contact near rest turn for ever
    assert motion.certificate.ok, motion.certificate.failures


def test_sharp_functions_are_found_in_the_recorded_graph():
    """Those of the contact velocity or of an internal state of the law; none of the machine, whatever its functions."""

    def found(law):
        recorded = equations(vc.System(vc.PendulumCapsule(), law, vc.Harmonic()))
        sharp, _ = system_sharpness(recorded)
        return [recorded.graph.nodes[node][0] for node in sharp.nodes], sharp.internal

    assert found(vc.Coulomb()) == ([], False)
    assert found(vc.Exponential()) == (["exp"], False)
    assert found(vc.LuGre()) == (["exp", "div"], False)
    assert found(vc.BoucWen(knee_exponent=2.0)) == ([], False)
    assert found(vc.BoucWen(knee_exponent=20.0)) == (["power"], True)
    assert found(vc.SmoothedTanh()) == (["tanh", "exp"], False)


@pytest.mark.parametrize(
    ("law", "speed"),
    [
        (vc.LuGre(stribeck_velocity=0.01, stribeck_exponent=2.0), 0.05),
        (vc.LuGre(stribeck_velocity=0.01, stribeck_exponent=1.0), 0.25),
        (vc.ElastoPlastic(stribeck_velocity=0.02, stribeck_exponent=1.5), 0.02 * 25.0 ** (1.0 / 1.5)),
        (vc.Dahl(), 0.0),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_visible_speed_of_driven_laws(law, speed):
    """Where the exponential of |v/v_s|^alpha is e^-25, found from the graph; 0 where friction knows no speed."""
    recorded = driven_equations(law, ())
    values = np.array([[float(getattr(law, name) or 0.1) for name in recorded.parameter_names]])
    assert visible_speed(recorded.sharp, recorded.states, values, 1.0) == pytest.approx([speed], rel=1e-3)
