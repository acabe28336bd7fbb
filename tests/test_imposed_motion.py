"""Machines whose inner motion is imposed: the classical crawlers against their closed forms."""

import dataclasses
import math
from typing import ClassVar

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but, slow_but
from vibrocap.arguments import ArgumentError
from vibrocap.mechanics import (
    Contact,
    Damper,
    Machine,
    Mass,
    Number,
    Potential,
    Spring,
    Stop,
    coordinate,
    parameter,
    parameters,
)
from vibrocap.physics.catalogue import law as law_of

pytestmark = pytest.mark.plain


def rubbing(forward, back, total):
    """Coulomb friction that slows a body of this mass by `forward` and `back`, at rest too."""
    if forward == back:
        return vc.Coulomb(forward * total, forward * total)
    return law_of("anisotropic-coulomb")(
        coulomb_coefficient=total, static_coefficient=total, forward_ratio=forward, back_ratio=back
    )


def crawler(share, forward, back, drive):
    """The crawler whose inner mass is this share of both."""
    return vc.System(vc.TwoMassCrawler(mass_ratio=1.0 / share - 1.0), rubbing(forward, back, 1.0 / share), drive)


def two_phases(stroke, first, second):
    """Relative velocity stroke/first, then -stroke/second."""
    period = first + second
    return vc.Triangle(amplitude=0.5 * stroke, frequency=2.0 * math.pi / period, rise=first / period)


def two_phase_velocity(share, stroke, first, second, forward, back):
    """Mean velocity of the two-phase crawler (Chernousko 2002), in both of its cases."""
    jump = share * stroke * (1.0 / first + 1.0 / second)
    if forward * second <= jump:
        assert forward * second / back <= first
        value = jump * second - 0.5 * forward * second**2 - (forward * second) ** 2 / (2.0 * back)
    else:
        assert jump / back <= first
        value = jump**2 * (1.0 / forward + -1.0 / back) / 2.0
    return value / (first + second)


# share, stroke, durations, friction forward and back; the last ones stop within the second phase
TWO_PHASES = [
    (0.5, 0.1, 0.4, 0.1, 0.5, 0.5),
    (0.3, 0.05, 0.5, 0.05, 1.0, 1.0),
    (0.4, 0.1, 0.5, 0.2, 0.3, 0.6),
    (0.2, 0.1, 0.6, 0.4, 0.9, 1.4),
]


@pytest.mark.slow
@pytest.mark.parametrize("given", exhaustive_but([0], [pytest.param(phase) for phase in TWO_PHASES]))
def test_two_phases(given):
    share, stroke, first, second, forward, back = given
    expected = two_phase_velocity(*given)
    if given == TWO_PHASES[0]:
        assert expected == pytest.approx(0.115, abs=1e-15)
    if given == TWO_PHASES[1]:
        assert expected == pytest.approx(0.0254545454545, abs=1e-13)
    orbit = vc.orbit(crawler(share, forward, back, two_phases(stroke, first, second)))
    assert orbit.mean_velocity == pytest.approx(expected, abs=1e-13)
    assert orbit.stable
    assert not orbit.continuum
    motion = orbit.motion()
    assert motion.certificate.ok, motion.certificate.failures
    assert motion.certificate.energy_residual <= 1e-14


@pytest.mark.slow
def test_an_even_two_phase_motion_is_one_of_a_continuum():
    """Isotropic and t1 = t2: one multiplier is exactly 1, and every velocity between the phases is kept."""
    system = crawler(0.5, 0.1, 0.1, two_phases(0.4, 0.5, 0.5))
    orbit = vc.orbit(system)
    assert orbit.continuum
    assert not orbit.stable
    assert np.max(np.abs(orbit.multipliers - 1.0)) <= 1e-12
    assert "continuum" in str(orbit)
    other = vc.orbit(system, initial={"centre_velocity": 0.05})
    assert other.continuum
    assert other.drift != pytest.approx(orbit.drift, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("forward", "back", "expected"),
    exhaustive_but([1], [(0.1, 0.2, 0.485158081300), (0.3, 0.6, 0.345848422333), (0.5, 1.0, 0.201452203334)]),
)
def test_harmonic_inner_motion_on_anisotropic_ground(forward, back, expected):
    """X'' = cos(t) - p sgn X': the independent values, and the closed form where back friction holds (p- >= 1)."""
    orbit = vc.orbit(crawler(0.5, forward, back, vc.Harmonic(amplitude=2.0)))
    assert orbit.mean_velocity == pytest.approx(expected, abs=2e-12)


SLOPE = vc.Environment(inclination=0.15, linear_drag=0.3, quadratic_drag=0.2, force=0.1, gravity=1.7)


@pytest.mark.parametrize("environment", slow_but([1], [None, SLOPE]), ids=["level", "slope"])
def test_the_force_of_the_actuator_is_that_of_newton(environment):
    """F = m (X' + z')' + m g_t from the motion itself, by differences within a piece, and its power F z'."""
    drive = vc.Trapezoid(amplitude=0.7, frequency=1.3, rise=0.3, hold=0.2, fall=0.15)
    system = dataclasses.replace(crawler(0.4, 0.2, 0.3, drive), environment=environment)
    weight = 0.0 if environment is None else environment.gravity * math.sin(environment.inclination)
    motion = vc.simulate(system, periods=2, initial={"centre_velocity": 0.1}, tolerance=1e-12)
    index = np.flatnonzero(motion.piece_length > 1e-2)
    middle = 0.5 * motion.piece_length[index]
    (force, power), h = motion.piece_observables(("actuator_force", "actuator_power"), index, middle), 1e-4
    speeds = []
    for s in (middle - h, middle + h):
        (own,) = motion.piece_observables(("contact_velocity",), index, s)
        slope = np.array([drive.slope(t) for t in motion.drive_at(index, s)[0]])
        speeds.append(own + slope)
    assert force == pytest.approx((speeds[1] - speeds[0]) / (2 * h) + weight, abs=1e-8)
    assert power == pytest.approx(force * slope, abs=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("motion", exhaustive_but([1], ["angle", "displacement"]))
def test_the_torque_of_the_pendulum_drives_a_pendulum_capsule(motion):
    """The torque that the imposed motion takes, given to the free machine, makes that motion again: both equations."""
    imposed = vc.System(vc.PendulumCrawler(motion=motion), vc.Exponential(), vc.Harmonic(amplitude=0.6, frequency=1.2))
    free = vc.PendulumCapsule()
    run = vc.simulate(imposed, periods=1, tolerance=1e-12)
    for t in (0.3, 1.1, 2.9, 4.4):
        value, slope = imposed.drive.value(t), imposed.drive.slope(t)
        sine = math.sin(value) if motion == "angle" else value
        angle = math.asin(sine)
        rate = slope if motion == "angle" else slope / math.cos(angle)
        velocity = run.at([t], "contact_velocity")[0]
        torque, force = run.at([t], "actuator_torque")[0], run.at([t], "friction")[0]
        rates = free.rates(t, (angle, rate, 0.0, velocity), torque, (force,))
        h = 1e-4
        around = run.at([t - h, t + h], "contact_velocity")
        assert rates[3] == pytest.approx((around[1] - around[0]) / (2 * h), abs=1e-6)
        curvature = imposed.drive.curvature(t)
        if motion == "displacement":
            curvature = (curvature + sine * rate**2) / math.cos(angle)
        assert rates[1] == pytest.approx(curvature, abs=1e-9)


@pytest.mark.slow
def test_an_imposed_velocity_is_known_to_the_tolerance():
    """Between two states of the contact it decides, and is no state: its series bounds the step as theirs do.

    Where it did not, this motion passed rest by 77 tolerances and ended 300 off.
    """
    drive = vc.Biharmonic(amplitude=0.712, frequency=1.231, second_amplitude=0.253)
    system = vc.System(vc.PendulumCrawler(), vc.Coulomb(0.1, 0.2), drive)
    fine = vc.simulate(system, periods=10, tolerance=1e-12)
    for tolerance in (1e-4, 1e-6, 1e-8):
        motion = vc.simulate(system, periods=10, tolerance=tolerance)
        assert motion.certificate.ok, motion.certificate.failures
        assert motion.certificate.least_velocity > -0.2 * tolerance  # 0.07 at most in 240 random motions
        assert motion.state["position"] == pytest.approx(fine.state["position"], abs=10 * tolerance)


def test_what_cannot_be_imposed_is_refused_by_name():
    with pytest.raises(ArgumentError, match="drive: the waveform square jumps, while the two-mass-crawler takes it"):
        vc.System(vc.TwoMassCrawler(), vc.Coulomb(), vc.Square())
    with pytest.raises(ArgumentError, match="drive: the waveform ramp imposes a motion on the two-mass-crawler, but"):
        vc.System(vc.TwoMassCrawler(), vc.Coulomb(), vc.Ramp())


def test_measures_of_what_an_imposed_motion_takes():
    """The largest |force| and power of z = h cos(omega t) where the body is held: m z'' and m z'' z'."""
    amplitude, frequency, inner = 0.4, 1.7, 1.0
    held = vc.System(vc.TwoMassCrawler(mass_ratio=2.0), vc.Coulomb(9.0, 9.0), vc.Harmonic(amplitude, frequency))
    names = ("peak_actuator_force", "largest_actuator_force", "least_actuator_force")
    names += ("peak_actuator_power", "mean_actuator_power")
    values = vc.measured(vc.simulate(held, periods=2, tolerance=1e-12), names, window=1)
    force = inner * amplitude * frequency**2
    assert [values[name] for name in names[:3]] == pytest.approx([force, force, -force], rel=1e-9)
    assert values["peak_actuator_power"] == pytest.approx(0.5 * force * amplitude * frequency, rel=1e-9)
    assert values["mean_actuator_power"] == pytest.approx(0.0, abs=100 * 1e-12)  # as all works are held to
    assert {*names} < {*vc.measure_table(held)}
    assert not {*names} & {*vc.measure_table(vc.System(vc.PendulumCapsule(), vc.Coulomb(), vc.Harmonic()))}
    assert {"peak_actuator_torque", *names} < {*vc.measure_table()}
    pendulum = vc.System(vc.PendulumCrawler(), vc.Coulomb(), vc.Harmonic(0.5))
    run = vc.simulate(pendulum, periods=2)
    torque = run["actuator_torque"][run.time >= run.period]
    peak = vc.measured(run, "peak_actuator_torque", window=1)["peak_actuator_torque"]
    assert peak == pytest.approx(abs(torque).max(), rel=1e-3)
    with pytest.raises(ValueError, match="'actuator_force' is not known of an instant"):
        vc.measured(run, "peak_actuator_force", window=1)


@parameters
class Tethered(Machine):
    """A crawler that a spring, a damper, a potential and a stop hold to the ground, on a line that rises."""

    rise: Number = parameter(0.2, "a", "rise of the line", unit="1")

    name: ClassVar[str] = "tethered-crawler"
    bend: ClassVar[float] = 0.0
    effort: ClassVar = "displacement"
    position = coordinate("X", "place of the base", "m")

    def parts(self, q):
        x = q.position
        base = Mass("base", 0.5, x=x, z=self.rise * x + self.bend * x * x)
        inner = Mass("inner mass", 1.5, on=base, x=q.imposed(q.drive), z=0.1 * q.drive)
        held = Spring(2.0, x, rest=0.1), Damper(0.3, x), Potential(0.4 * x * x * x * x)
        stop = Stop(x, gap=0.05, back_gap=0.05, stiffness=8.0, damping=0.2)
        return base, inner, held, stop, Contact(base, load=0.5)


def test_a_drive_that_imposes_the_motion_works_against_all_that_holds_the_machine():
    """The balances of energy and momentum close, by themselves and on a slope."""
    for environment in (None, vc.Environment(inclination=0.05)):
        system = vc.System(Tethered(), vc.Coulomb(0.1, 0.2), vc.Harmonic(0.4, 1.3), environment=environment)
        motion = vc.simulate(system, initial={"position": 0.04}, periods=4)
        assert motion.certificate.ok, motion.certificate
        assert {"impact", "stop_opened"} <= {event.kind for event in motion.events}
    bent = type("Bent", (Tethered,), {"bend": 0.1})
    with pytest.raises(ValueError, match="moves along straight lines with 'position'"):
        vc.System(bent(), vc.Coulomb(0.1, 0.2), vc.Harmonic(0.4, 1.3))
    pair = type(
        "Pair", (Tethered,), {"parts": lambda self, q: [*(parts := Tethered.parts(self, q)), Contact(parts[1])]}
    )
    with pytest.raises(ValueError, match="'inner mass' follows the motion: at imposed distances give a constant one"):
        vc.System(pair(), vc.Coulomb(0.1, 0.2), vc.Harmonic(0.4, 1.3))
