"""Stops on the ground, and several of one machine: independent solvers, closed forms, momentum, what a certificate
refuses."""

import math
from typing import ClassVar

import numpy as np
import pytest

import vibrocap as vc
from planted import planted
from thinned import exhaustive_but
from vibrocap.mechanics import (
    Contact,
    Drive,
    Machine,
    Mass,
    NonNegative,
    Spring,
    Stop,
    coordinate,
    parameter,
    parameters,
)

pytestmark = pytest.mark.plain

COULOMB = vc.Coulomb(0.3, 0.4)
BETWEEN = vc.OscillatorWithStops(damping=0.05, gap=0.8, back_gap=0.8, restitution=0.7)
PUSHED = vc.OscillatorWithStops(damping=0.05, gap=0.3, back_gap=0.3, restitution=0.0)
SLOWLY = vc.Harmonic(amplitude=2.0, frequency=0.3)


# Ends of other solvers: of issue 25, and of DOP853 between the events at a tolerance of 1e-13.
@pytest.mark.slow
@pytest.mark.parametrize(
    ("machine", "drive", "periods", "end"),
    [
        (BETWEEN, vc.Harmonic(amplitude=1.0), 200, (0.4419227121539, 0.8286367306170)),
        (PUSHED, SLOWLY, 3.3, (0.1997793306096, -0.2876917973607)),
    ],
)
def test_between_walls_it_ends_where_an_independent_solver_does(machine, drive, periods, end):
    motion = vc.simulate(vc.System(machine, COULOMB, drive), periods=periods, tolerance=1e-12)
    assert motion.certificate.ok
    states = [motion.state[name] for name in ("position", "sliding_velocity")]
    assert states == pytest.approx(end, abs=1e-12 if periods == 200 else 1e-11)


@pytest.mark.parametrize("stuck", [False, True])
def test_impacts_give_their_impulse_to_the_ground(stuck):
    """(1 + e) m x' of each; with the force of the wall on a block that rests there the momentum is in balance."""
    machine, drive = (PUSHED, SLOWLY) if stuck else (BETWEEN, vc.Harmonic(amplitude=1.0))
    motion = vc.simulate(vc.System(machine, COULOMB, drive), periods=4)
    blows = motion.piece_blows[motion.piece_blows != 0.0]
    struck = motion.event_times[motion.event_kinds == "impact"]
    assert len(blows) == len(struck) > 5
    before = np.searchsorted(motion.piece_start, struck) - 1
    speeds = motion.piece_states(before, motion.piece_length[before])[1]
    assert blows == pytest.approx(-(1.0 + machine.restitution) * speeds, rel=1e-12)
    assert motion.certificate.ok
    assert motion.certificate.momentum_residual < 1e-9
    assert ("stop_opened" in motion.event_kinds) == stuck


@planted(vc.OscillatorWithStops)
class Silent:
    """Its impacts on the ground are not told."""

    name = "silent"
    strikes_ground = ()


@planted(vc.OscillatorWithStops)
class Weightless:
    """The force of its walls is not told."""

    name = "weightless"

    def wall_force(self, t, y, drive, frictions):
        return 0.0


@pytest.mark.parametrize("kind", [Silent, Weightless])
def test_what_is_not_told_of_the_walls_is_refused(kind):
    machine = kind(damping=0.05, gap=0.3, back_gap=0.3, restitution=0.0)
    certificate = vc.simulate(vc.System(machine, COULOMB, SLOWLY), periods=4).certificate
    assert [verdict.field for verdict in certificate.verdicts if not verdict.ok] == ["momentum_residual"]


def test_a_block_that_is_pressed_against_a_wall_rests():
    """Held by friction at first, then by the wall: at 0.41, a little more than friction holds, it does not slide."""
    machine = vc.OscillatorWithStops(stiffness=0.0, gap=0.3, restitution=0.0)
    drive = vc.Harmonic(amplitude=0.41, frequency=0.3)
    motion = vc.simulate(vc.System(machine, COULOMB, drive), periods=2, initial={"position": 0.3})
    opens, leaves = math.pi / 2.0 / 0.3, math.acos(-0.4 / 0.41) / 0.3
    assert list(motion.event_kinds[:4]) == ["impact", "stick", "stop_opened", "slip_back"]
    assert list(motion.event_times[2:4]) == pytest.approx([opens, leaves], abs=1e-10)
    assert [(phase.side, phase.end) for phase in motion.phases[:1]] == [(0, pytest.approx(leaves))]
    assert motion.certificate.ok


@pytest.mark.slow
@pytest.mark.parametrize(
    "law", exhaustive_but([0, 2], [vc.Coulomb(0.0, 0.0), vc.BoucWen(), vc.LuGre(), vc.SmoothedTanh()])
)
def test_rebounds_without_end_rest_at_a_wall_and_leave_it(law):
    machine = vc.OscillatorWithStops(damping=0.05, gap=0.3, back_gap=0.3)
    motion = vc.simulate(vc.System(machine, law, SLOWLY), periods=3)
    assert motion.status.ok
    assert motion.certificate.ok, motion.certificate.failures
    assert np.sum(motion.event_kinds == "stop_opened") == 6
    assert np.abs(motion["position"]).max() <= 0.3 + 1e-12


def test_over_a_belt_it_slides_at_the_wall():
    machine = vc.OscillatorWithStops(gap=0.3, belt_speed=0.2, restitution=0.0, stiffness=1.0)
    system = vc.System(machine, vc.Coulomb(0.5, 0.5), vc.Constant())
    motion = vc.simulate(system, periods=3)
    assert motion.state == {"position": 0.3, "sliding_velocity": -0.2, "touching": 1.0}  # friction 0.5 > k delta
    assert motion.certificate.ok
    assert vc.simulate(system, start=motion, periods=1).state == motion.state
    with pytest.raises(ValueError, match=r"initial\.sliding_velocity should be -0.2, as touching is 1, got 0"):
        vc.simulate(system, initial={"position": 0.3, "touching": 1.0}, periods=1)


@pytest.mark.slow
def test_the_multipliers_are_those_of_two_impacts_and_the_damper():
    """No reversal but at the walls: their product is e^4 exp(-c T/m)."""
    orbit = vc.orbit(vc.System(BETWEEN, COULOMB, vc.Harmonic(amplitude=1.0)))
    assert orbit.stable
    product = np.prod(orbit.multipliers).real
    assert product == pytest.approx(0.7**4 * math.exp(-0.05 * 2.0 * math.pi), rel=1e-9)


# --- elastic stops ---------------------------------------------------------------------------------------------------

FREE = {"stiffness": 0.0, "damping": 0.0, "stop_stiffness": 9.0, "gap": 0.3, "back_gap": 0.2}
STOPS = {
    # what: (parameters, spring and damper that are struck forward, back)
    "alike": ({}, (9.0, 0.0), (9.0, 0.0)),
    "one damper": ({"stop_damping": 0.6}, (9.0, 0.6), (9.0, 0.6)),
    "its own spring": ({"back_stop_stiffness": 4.0}, (9.0, 0.0), (4.0, 0.0)),
    "its own damper": ({"back_stop_damping": 0.5}, (9.0, 0.0), (9.0, 0.5)),
    "its own": ({"stop_damping": 0.6, "back_stop_stiffness": 4.0, "back_stop_damping": 0.5}, (9.0, 0.6), (4.0, 0.5)),
}


def capsule(given):
    """A vibro-impact capsule that friction holds: its inner mass is a free block between stops."""
    return vc.VibroImpactCapsule(normal_load=1e3, actuation="internal", **given), "displacement"


def block(given):
    return vc.OscillatorWithStops(**given), "position"


@pytest.mark.parametrize("made", [block, capsule])
def test_stops_are_symmetric_only_if_they_are_alike(made):
    alike = FREE | {"back_gap": FREE["gap"], "stop_damping": 0.6}
    assert made(alike)[0].symmetric
    for name in ("back_gap", "back_stop_stiffness", "back_stop_damping"):
        assert not made(alike | {name: 0.7})[0].symmetric, name


@pytest.mark.slow
@pytest.mark.parametrize("what", exhaustive_but([0, 4], [*STOPS]))
@pytest.mark.parametrize("made", [block, capsule])
@pytest.mark.parametrize("side", exhaustive_but([1], [1.0, -1.0]))  # struck back, of springs that differ
def test_a_rebound_is_half_a_vibration_of_spring_and_damper(made, what, side):
    """It takes pi/omega_d and leaves exp(-pi zeta/sqrt(1 - zeta^2)) of the speed."""
    given, *stops = STOPS[what]
    machine, place = made(FREE | given)
    speed = {"position": "sliding_velocity", "displacement": "displacement_rate"}[place]
    law = vc.Coulomb(0.0, 0.0) if made is block else vc.Coulomb()
    system = vc.System(machine, law, vc.Loading(0.0, 0.0, 0.0, 1.0))
    motion = vc.simulate(system, periods=0.5, initial={speed: side}, tolerance=1e-11)
    stiffness, damping = stops[0 if side > 0.0 else 1]
    ratio = damping / (2.0 * math.sqrt(stiffness))
    own = math.sqrt(stiffness * (1.0 - ratio * ratio))
    gap = machine.gap if side > 0.0 else machine.back_gap
    ends = motion.event_times[motion.event_kinds == "stop_opened"][0]
    assert ends == pytest.approx(gap + math.pi / own, abs=1e-9)
    rebound = math.exp(-math.pi * ratio / math.sqrt(1.0 - ratio * ratio))
    assert motion.at(ends, speed) == pytest.approx([-side * rebound], abs=1e-9)
    assert motion.certificate.ok, motion.certificate.failures
    balance = vc.energy_balance(motion, window=(0.0, ends + 1e-6))
    assert balance.damper == pytest.approx(0.5 * (rebound * rebound - 1.0), abs=1e-9)


def test_what_cannot_be_said_of_stops_is_refused():
    for given, said in (
        ({"stop_damping": 1.0}, "stop_damping: should be left out without stop_stiffness, got 1.0"),
        ({"stop_stiffness": 1.0, "back_stop_damping": 2.0}, "back_stop_damping: should be left out without back_gap"),
        ({"back_gap": 1.0, "back_stop_stiffness": 2.0}, "back_stop_stiffness: should be left out without stop_stiff"),
        ({"restitution": 1.5}, "restitution"),
        ({"gap": 0.0}, "gap"),
        ({"stop_stiffness": -1.0}, "stop_stiffness"),
    ):
        with pytest.raises(ValueError, match=said):
            vc.OscillatorWithStops(**given)


@parameters
class Struck(Machine):
    """A capsule of mass 2 that strikes a wall, with masses 1 and 1/2 in it, between rigid stops of their own."""

    restitution: NonNegative = parameter(0.8, "e", "restitution of the first mass and of the wall", "fraction")
    restitution_2: NonNegative = parameter(0.0, "e_2", "restitution of the second mass", "fraction")
    first = coordinate("z_1", "first mass from the capsule", "m")
    second = coordinate("z_2", "second mass from the capsule", "m")
    position = coordinate("X", "place of the capsule", "m")
    name: ClassVar[str] = "struck"

    def parts(self, q):
        capsule = Mass("capsule", 2.0, x=q.position)
        masses = Mass("first", 1.0, on=capsule, x=q.first), Mass("second", 0.5, on=capsule, x=q.second)
        held = Spring(0.5, q.first), Spring(0.5, q.second), Drive(q.first), Drive(q.second), Contact(capsule, load=1.0)
        inner = Stop(q.first, gap=0.3, restitution=self.restitution)
        other = Stop(q.second, gap=0.1, back_gap=0.1, restitution=self.restitution_2)
        wall = Stop(between=(None, capsule), gap=0.5, restitution=self.restitution)
        return capsule, *masses, *held, inner, other, wall


def after_a_blow(which, **states):
    """States of a struck machine after a blow at a guard, and whether its second mass, pressed on, leaves its stop."""
    machine, names = Struck(), list(Struck.states)
    y = [states.get(name, 0.0) for name in names]
    after = machine.after_switch(which, 0.0, tuple(y), 0.0, (0.1,))
    pressing = states.get("touching_2", 0.0)
    return dict(zip(names, after, strict=True)), machine.switches(0.0, after, pressing, (0.1,))[3] < 0.0


def test_a_wall_gives_no_impulse_to_what_is_inside_and_bears_what_it_exerts():
    """Absolute speeds of both masses stay; of a capsule at rest the wall bears the masses' inertia and friction."""
    after, _ = after_a_blow(5, first_rate=0.2, second_rate=-0.3, velocity=1.0, position=0.5)
    assert (after["velocity"], after["first_rate"], after["second_rate"]) == pytest.approx((-0.8, 2.0, 1.5))
    still = tuple({"first": 0.2, "second": -0.4, "position": 0.5, "touching_3": 1.0}.get(n, 0.0) for n in Struck.states)
    rates = dict(zip(Struck.states, Struck().rates(0.0, still, 0.7, (0.1,)), strict=True))
    assert rates["velocity"] == 0.0
    assert Struck().wall_force(0.0, still, 0.7, (0.1,)) == pytest.approx(
        rates["first_rate"] + 0.5 * rates["second_rate"] + 0.1
    )


@pytest.mark.parametrize("side", [1.0, -1.0, 0.0])
def test_a_mass_at_rest_at_its_stop_takes_part_in_a_blow_at_another(side):
    """In front it leaves, as the blow at the front of the first mass drives the capsule on; behind it is carried along.

    The impulse is (1 + e) v over 1/m + 1/M, M what the capsule takes along.
    """
    place = {"second": 0.1 * side, "touching_2": side}
    after, leaves = after_a_blow(0, first=0.3, first_rate=1.0, velocity=0.1, **place)
    carrier = 2.5 if side < 0.0 else 2.0
    gained = 1.8 / (1.0 + 1.0 / carrier) / carrier
    assert leaves == (side > 0.0)
    assert after["first_rate"] == pytest.approx(-0.8)
    assert after["velocity"] == pytest.approx(0.1 + gained)
    assert after["second_rate"] == pytest.approx(0.0 if side < 0.0 else -gained)


@pytest.mark.slow
def test_a_motion_with_several_rigid_stops_is_certified_and_counts_the_impacts_of_each():
    """The second mass strikes twice a period, stays, and leaves once by itself and once by a blow at the first."""
    system = vc.System(Struck(), vc.Coulomb(0.3, 0.3), vc.Harmonic(amplitude=1.2))
    options = {"periods": 6, "initial": {"position": -9.0}}
    motion = vc.simulate(system, **options)
    assert motion.certificate.ok
    struck = np.sum((motion.event_kinds == "impact") & (motion.event_times > 2 * motion.period))
    opened = np.sum((motion.event_kinds == "stop_opened") & (motion.event_times > 2 * motion.period))
    assert struck > opened > 0
    assert vc.measured(motion, "impacts", window=4)["impacts"] == struck / 4.0
    counted = vc.ensemble(system, {"drive.amplitude": [1.2]}, measures=["impacts"], window=4, **options)
    assert counted["impacts"] == struck / 4.0
