"""Stick, slip and what lies between: every edge of the contact's modes.

An edge is found by bisection to the last bit of a number, and then run on both sides of it: whatever rounding decides
there, the motion must stay consistent, and neighbouring motions must stay neighbours.
"""

import math

import numpy as np
import pytest

import vibrocap as vc
from independent import motion as independent_motion
from plain_kernels import kernel_of
from vibrocap.numerics.kernel.codes import TOO_MANY_EVENTS
from vibrocap.numerics.kernel.events.transitions import ARRIVED
from vibrocap.physics.events import KINDS

EPSILON = float(np.finfo(float).eps)
TOLERANCE = 1e-9
SMOOTH = {"mass_ratio": 1.0, "stiffness": 1.0, "damping": 0.0}  # the holding force starts with its second derivative


def stick_slip(machine=None, drive=None, **friction):
    return vc.System(
        vc.PendulumCapsule(**(machine or {})), vc.Exponential(**friction), drive or vc.Harmonic(amplitude=1.8)
    )


def assert_consistent(motion, tolerance=TOLERANCE):
    """What the certificate must say of any motion."""
    assert motion.status.ok, motion.status.text
    certificate = motion.certificate
    if certificate.stick_force_ratio is not None:
        assert certificate.stick_force_ratio <= 1.0 + 1e-12
    assert certificate.sign_kept
    size = max(1.0, float(np.abs(motion["velocity"]).max()))
    assert certificate.event_velocity <= 8 * EPSILON * size
    assert certificate.energy_residual <= 100 * tolerance
    assert certificate.momentum_residual <= 100 * tolerance


def bisected(inside, low, high):
    """The last number from low towards high for which `inside` holds."""
    assert inside(low)
    assert not inside(high)
    while True:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            return low
        low, high = (middle, high) if inside(middle) else (low, middle)


def neighbours(number, count=24):
    """The number, some of its neighbours bit by bit, and more of them further off on both sides."""
    offsets = [*range(-count, count + 1), *(sign * 2**k for k in range(5, 40, 5) for sign in (-1, 1))]
    return [number + k * math.ulp(number) for k in offsets]


# --- the start -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("law", [vc.Exponential(), vc.LuGre()], ids=lambda law: law.name)
def test_start_on_the_switching_surface(law, direction):
    """Velocity exactly zero and more force than the contact can hold: it slides at once, the right way."""
    system = vc.System(vc.PendulumCapsule(), law, vc.Harmonic(amplitude=1.8 * direction))
    motion = vc.simulate(system, periods=2)
    assert motion.phases[0].side == direction
    assert motion.at(1e-3, "velocity")[0] * direction > 0.0
    assert_consistent(motion)


def test_start_stuck():
    """It leaves when the independent solver says, having rested exactly until then."""
    start = {"angle": 0.8, "angle_rate": -0.2, "position": 0.7}
    system = stick_slip(drive=vc.Harmonic(amplitude=1.3, frequency=0.7))
    motion = vc.simulate(system, periods=2, initial=start)
    assert motion.phases[0].side == 0
    assert motion.events[0].kind in ("slip_forward", "slip_back")
    left = motion.events[0].time
    assert left == pytest.approx(independent_motion(system, start, 0.5).events[0][0], rel=10 * TOLERANCE)
    t = np.linspace(0.0, left, 50)[:-1]
    assert np.all(motion.at(t, "velocity") == 0.0)
    assert np.all(motion.at(t, "position") == 0.7)
    assert np.ptp(motion.at(t, "angle")) > 0.01
    assert_consistent(motion)


def test_never_leaving_stick():
    motion = vc.simulate(stick_slip(drive=vc.Harmonic(amplitude=0.3)), periods=10, initial={"position": -0.4})
    assert motion.events == ()
    assert [phase.side for phase in motion.phases] == [0]
    assert motion.state["velocity"] == 0.0
    assert motion.state["position"] == -0.4
    assert 0.3 < motion.certificate.stick_force_ratio < 1.0
    assert_consistent(motion)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(
    ("machine", "drive", "vanishing"),
    [
        # rate of the force 2 h2 - nu h
        (SMOOTH | {"damping": 0.5}, {"amplitude": 0.45, "second_amplitude": 0.5, "second_phase": -math.pi / 2}, 1),
        # no rate, second derivative -h - 4 h2 with h + h2 = 0.45
        (SMOOTH, {"amplitude": 0.9, "second_amplitude": -0.45}, 2),
    ],
)
def test_force_exactly_at_the_limit_and_growing_leaves_in_the_first_instant(machine, drive, vanishing, direction):
    """At rest the holding force is the drive, 0.45 = N eta_s to rounding, and grows as the power `vanishing` of t."""
    drive = {name: value if name == "second_phase" else direction * value for name, value in drive.items()}
    motion = vc.simulate(stick_slip(machine, vc.Biharmonic(**drive)), periods=1)
    assert motion.phases[0].side == direction
    assert motion.phases[0].start == 0.0
    # B X'' = excess = c t^k, so X' grows as t^(k+1)
    early = motion.at([1e-3, 2e-3], "velocity")
    assert early[0] * direction > 0.0
    assert early[1] / early[0] == pytest.approx(2.0 ** (vanishing + 1), rel=0.02)
    assert_consistent(motion)


def test_force_exactly_at_the_limit_and_falling_stays():
    """Rate of the force -nu h < 0."""
    motion = vc.simulate(stick_slip(drive=vc.Harmonic(amplitude=0.45)), periods=0.2)
    assert [phase.side for phase in motion.phases] == [0]
    assert_consistent(motion)


def test_force_that_only_touches_the_limit():
    """The largest holding force is tuned to the limit: below it nothing moves, above it the capsule creeps a little."""

    def run(amplitude):
        drive = vc.Biharmonic(amplitude=0.0, second_amplitude=amplitude, second_phase=2.0, frequency=0.5)
        return vc.simulate(stick_slip(drive=drive), periods=1, initial={"angle": -0.1})

    edge = bisected(lambda h: all(phase.side == 0 for phase in run(h).phases), 0.2, 1.0)
    for amplitude in neighbours(edge):
        motion = run(amplitude)
        assert_consistent(motion)
        assert abs(motion.state["position"]) <= 1e-9
    assert vc.simulate(run(edge + 1e-2).system, periods=1, initial={"angle": -0.1}).events[0].kind.startswith("slip")


# --- velocity zero ---------------------------------------------------------------------------------------------------

DIPPING = vc.Biharmonic(amplitude=1.2, second_amplitude=0.9, second_phase=0.7)


def test_velocity_that_touches_zero_without_changing_sign():
    """The least velocity of a forward slide is tuned to zero by the initial velocity."""
    system = vc.System(vc.PendulumCapsule(mass_ratio=2.5, normal_load=0.2), vc.Exponential(), DIPPING)

    def run(velocity):
        return vc.simulate(system, periods=0.6, initial={"angle": 0.3, "velocity": velocity})

    def always_forward(velocity):
        return all(phase.side == 1 for phase in run(velocity).phases)

    edge = bisected(always_forward, 0.3, 0.2)
    motions = [run(velocity) for velocity in neighbours(edge)]
    kinds = {tuple(event.kind for event in motion.events) for motion in motions}
    assert len(kinds) >= 2  # both sides of the edge were seen
    assert () in kinds or ("graze",) in kinds
    for motion in motions:
        assert_consistent(motion)
        velocity = motion.at(np.linspace(0.0, motion.end, 4001), "velocity")
        assert velocity.min() >= -1e-5
    finals = np.array([list(motion.state.values()) for motion in motions])
    # A dip of depth d < 1e-6 lasts sqrt(d); stick in place of it changes the velocity by the order of d.
    assert np.ptp(finals, axis=0).max() <= 1e-5
    close = finals[: 2 * 24 + 1]
    assert np.ptp(close, axis=0).max() <= 100 * TOLERANCE


def test_reversal_at_the_period_mark():
    """Two things at one instant, a reversal and the end of a period: neither is lost, in whatever order they fall."""
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Biharmonic(second_amplitude=0.4, second_phase=0.5))

    def run(velocity, periods=2):
        return vc.simulate(system, periods=periods, initial={"angle": 1.0, "velocity": velocity})

    edge = bisected(lambda velocity: run(velocity, 1).state["velocity"] < 0.0, -0.65, -0.6)
    motions = [run(velocity) for velocity in neighbours(edge)]
    for motion in motions[: 2 * 24 + 1]:
        at_mark = [event for event in motion.events if abs(event.time - motion.period) <= 1e-12]
        assert [event.kind for event in at_mark] == ["reversal"]
    for motion in motions:
        assert_consistent(motion)
        assert len(motion.sections) == 3
    finals = np.array([list(motion.state.values()) for motion in motions[: 2 * 24 + 1]])
    assert np.ptp(finals, axis=0).max() <= 1e-11


def test_slip_at_the_period_mark():
    """The hold gives way just as the period ends."""

    def run(phase, periods=2):
        drive = vc.Biharmonic(amplitude=0.0, frequency=0.5, second_amplitude=0.6, second_phase=phase)
        return vc.simulate(stick_slip(drive=drive), periods=periods, initial={"angle": -0.05})

    def leaves_late(phase):
        return run(phase, 1).state["velocity"] == 0.0 and run(phase, 1).phases[-1].side == 0

    phases = np.linspace(0.0, 2 * math.pi, 60)
    stuck = [leaves_late(float(phase)) for phase in phases]
    first = next(i for i in range(59) if stuck[i] and not stuck[i + 1])
    edge = bisected(leaves_late, float(phases[first]), float(phases[first + 1]))
    motions = [run(phase) for phase in neighbours(edge)]
    for motion in motions:
        assert_consistent(motion)
    times = [min(abs(event.time - motion.period) for event in motion.events) for motion in motions[: 2 * 24 + 1]]
    assert max(times) <= 10 * TOLERANCE
    finals = np.array([list(motion.state.values()) for motion in motions[: 2 * 24 + 1]])
    assert np.ptp(finals, axis=0).max() <= 10 * TOLERANCE


# --- no load, no drive -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("start", [{"angle": 0.4}, {"angle_rate": 0.5}, {"velocity": 0.1}, {"angle": 1.0}])
def test_without_load_nothing_sticks(start):
    """N = 0: the velocity passes zero as if nothing were there, also from a start with exactly no force."""
    machine = {"normal_load": 0.0, "stiffness": 0.0 if "angle_rate" in start else 2.0, "damping": 0.0}
    amplitude = 0.0 if "angle_rate" in start else 1.8
    motion = vc.simulate(stick_slip(machine, vc.Harmonic(amplitude=amplitude)), periods=2, initial=start)
    assert all(phase.side != 0 for phase in motion.phases)
    assert np.all(motion["friction"] == 0.0)
    assert_consistent(motion)


@pytest.mark.parametrize("law", [vc.Exponential(), vc.LuGre()], ids=lambda law: law.name)
def test_equilibrium_stays(law):
    motion = vc.simulate(vc.System(vc.PendulumCapsule(), law, vc.Harmonic(amplitude=0.0)), periods=5)
    assert set(motion.state.values()) == {0.0}
    assert motion.events == ()
    assert_consistent(motion)


def test_motion_without_drive_comes_to_rest_for_good():
    motion = vc.simulate(
        stick_slip(drive=vc.Harmonic(amplitude=0.0)), periods=10, initial={"angle": 1.2, "velocity": 0.5}
    )
    assert motion.phases[-1].side == 0
    assert motion.phases[-1].length > 5 * motion.period
    assert motion.state["velocity"] == 0.0
    assert_consistent(motion)


def test_bristles_without_drive_come_to_rest():
    """Bristles swing the capsule to and fro ever less; no event is lost, and the end is an equilibrium."""
    system = vc.System(vc.PendulumCapsule(), vc.LuGre(), vc.Harmonic(amplitude=0.0))
    motion = vc.simulate(system, periods=15, initial={"angle": 1.2, "velocity": 0.5})
    assert_consistent(motion)
    assert max(map(abs, system.rates(0.0, tuple(motion.state.values()), 1))) <= 100 * TOLERANCE


# --- a velocity that jumps -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("law", "before", "velocity", "side", "kinds"),
    [
        (vc.Exponential(), 1.0, 0.3, 1.0, []),
        (vc.Exponential(), 1.0, -0.3, -1.0, ["reversal"]),
        (vc.Exponential(), 0.0, 0.3, 1.0, ["slip_forward"]),
        (vc.Exponential(), 0.0, -0.3, -1.0, ["slip_back"]),
        (vc.Exponential(), 0.0, 1e-15, 0.0, []),
        (vc.Exponential(), -1.0, 1e-15, 0.0, []),  # at rest; the force decides in the next step
        (vc.LuGre(), 1.0, -0.3, -1.0, ["reversal"]),
        (vc.LuGre(), -1.0, -0.3, -1.0, []),
        (vc.LuGre(), 1.0, -1e-15, -1.0, ["reversal"]),  # a kinked law never rests
    ],
    ids=lambda value: getattr(value, "name", str(value)),
)
def test_side_after_a_jump(law, before, velocity, side, kinds):
    kernel = kernel_of(vc.System(vc.PendulumCapsule(), law, vc.Harmonic()))
    state = [0.4, 0.1, 0.7, velocity, *[0.0] * len(law.internal)]
    sides = ("SIDE", before), ("RECORDED_SIDE", before)
    for entry, value in (("STATE", state), *sides, ("EVENT_LIMIT", 1), ("RECORDED_EVENT_LIMIT", 9)):
        kernel.fill(entry, value)
    trace = np.zeros(9 * kernel.layout.event_size)
    kernel["jumped"](kernel.floats, kernel.ints, trace, 0)
    if side != 0.0:  # one at rest has still to be asked
        kernel["record_sides"](kernel.floats, kernel.ints, trace, 0)
    assert kernel.floats[kernel.place("SIDE")] == side
    recorded = kernel.ints[kernel.place("RECORDED_EVENTS")]
    assert [KINDS[int(trace[i * kernel.layout.event_size + 2])] for i in range(recorded)] == kinds
    at_rest = before != 0.0 and side == 0.0
    assert kernel.ints[kernel.place("TRANSITION")] == (ARRIVED if at_rest else 0)
    assert kernel.floats[kernel.place("CAME_FROM")] == (before if at_rest else 0.0)
    assert (kernel.floats[kernel.place("STATE") + 3] == 0.0) == at_rest


def test_jumps_are_counted_among_the_events():
    """A contact that jumps to and fro for ever ends its run."""
    kernel = kernel_of(stick_slip())
    kernel.fill("STATE", [0.0, 0.0, 0.0, -1.0])
    kernel.fill("SIDE", 1.0)
    kernel["jumped"](kernel.floats, kernel.ints, np.zeros(100), 0)
    assert kernel.ints[kernel.place("STATUS")] == TOO_MANY_EVENTS
