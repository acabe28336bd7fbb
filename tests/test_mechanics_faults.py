"""Faults of descriptions: each is named, by `check_part` and where a system is made."""

import math
from typing import ClassVar

import pytest

import vibrocap as vc
from vibrocap.mechanics import (
    Contact,
    Damper,
    Drive,
    Inertia,
    Machine,
    Mass,
    MechanicsError,
    NonNegative,
    Spring,
    Stop,
    Support,
    coordinate,
    cos,
    distance,
    parameter,
    parameters,
    sin,
)
from vibrocap.physics.catalogue import machines
from vibrocap.physics.mechanics.dead_points import DEAD

pytestmark = pytest.mark.plain


def capsule(q, **more):
    return Mass("capsule", 2.5, x=q.position, **more)


def bob(q, carrier, **more):
    return Mass("bob", **{"mass": 1.0, "on": carrier, "x": -sin(q.angle), "z": cos(q.angle), **more})


def joint(q):
    return Spring(2.0, q.angle), Damper(1.0, q.angle), Drive(q.angle)


def swings(q, body, *more, contact=True, **changed):
    """The parts of a pendulum capsule and more, with another bob."""
    return [body, bob(q, body, **changed), joint(q), *([Contact(body)] if contact else []), *more]


def block(q, body):
    return Mass("block", 1.0, on=body, x=q.angle)


def blocks(q, c, *more):
    return [c, block(q, c), joint(q), *more]


FAULTS = {
    "there is no Contact": lambda q, c: swings(q, c, contact=False),
    "'bob' moves twice as far as 'position'; its x counts from 'capsule', on which it stands: leave 'position'": (
        lambda q, c: swings(q, c, x=q.position - sin(q.angle))
    ),
    "take sin, cos, sqrt, exp, tanh and atan from vibrocap.mechanics, not from math": (
        lambda q, c: swings(q, c, x=-math.sin(q.angle))
    ),
    "the coordinate 'angle' moves no mass: give the body that it moves a mass": lambda q, c: swings(q, c, x=0.0, z=1.0),
    "the coordinate 'angle' moves no mass: ": (
        lambda q, c: [c, Mass("bob", 0.0, on=c, x=q.angle), joint(q), Contact(c)]
    ),
    "the body that it stands on should be a body": lambda q, c: swings(q, c, on="capsule"),
    "'bob' stands on 'capsule', which is not among the parts": lambda q, c: swings(q, c)[1:],
    "the contact of 'capsule' is with ['capsule'], not among": lambda q, c: swings(q, c, on=None)[1:],
    "nothing carries 'bob': name the body below it": lambda q, c: swings(q, c, on=None, x=q.angle, z=0.0),
    "two bodies have the name 'block'": lambda q, c: blocks(q, c, block(q, c), Contact(c)),
    "the load on 'capsule' should be dynamic or weight": lambda q, c: blocks(q, c, Contact(c, load="heavy")),
    "the load on 'disc', which turns, is a torque: give it": (
        lambda q, c: [c, disc := Inertia("disc", 1.0, q.angle), joint(q), Contact(c, load=1.0), Contact(disc)]
    ),
    "contact 1 (capsule): no coordinate moves it": lambda q, c: blocks(q, c, Contact(c, on=c)),
    "contact 3 (disc): its sliding velocity follows from those before it": (
        lambda q, c: [*swings(q, c), d := Mass("disc", 1.0, x=q.angle), Contact(d), Contact(d, on=c)]
    ),
    "a Drive acts along a path that never moves": lambda q, c: swings(q, c, Drive(1.0)),
    "a Spring acts along a path that never moves": lambda q, c: swings(q, c, Spring(1.0, 0.5)),
    "'capsule' and 'block' are at one height: take their offset": (
        lambda q, c: [c, b := block(q, c), Spring(1.0, distance(c, b)), Contact(c)]
    ),
    "should be parts, masses, springs and so on, got 3.0": lambda q, c: swings(q, c, 3.0),
    "q.angel: there is no such quantity": lambda q, c: swings(q, c, Drive(q.angel)),
    "a place follows q.drive, a force here": lambda q, c: swings(q, c, Spring(1.0, q.angle + q.drive)),
    "a stop should bound one coordinate": (
        lambda q, c: [*swings(q, c)[:3], Contact(c, load=1.0), Stop(q.angle + q.position, 0.3, restitution=0.5)]
    ),
    "a rigid stop holds 'position' while a function of time changes its sliding velocity": (
        lambda q, c: [
            table := Support("table", x=sin(q.time)),
            *swings(q, body := capsule(q, on=table), Stop(between=(table, body), gap=0.3, restitution=0.5)),
        ]
    ),
    "a rigid stop bounds a rubbing body, among several contacts": (
        lambda q, c: [c, b := block(q, c), joint(q), Contact(c), Contact(b, on=c), Stop(q.angle, 0.3, restitution=0.5)]
    ),
    "TypeError: 'NoneType' object is not iterable": lambda q, c: None,
    "contact 2 (capsule): its sliding velocity follows from": lambda q, c: swings(q, c, Contact(c)),
    "two states have the name 'angle_rate'": lambda q, c: swings(q, c, Contact(c, speed="angle_rate"), contact=False),
}
NUMBERS = {  # named by `check_part` alone, which puts numbers in
    "the mass matrix is singular at angle ": lambda q, c: swings(q, c, x=q.angle * q.angle, z=0.0),
    "a Spring adds position in m and angle in rad": lambda q, c: swings(q, c, Spring(1.0, q.position + q.angle)),
    "the damping of a Damper should be >= 0, got -0.5": lambda q, c: swings(q, c, Damper(-0.5, q.angle)),
    "the mass of 'bob' should be >= 0, got -1": lambda q, c: swings(q, c, mass=-1.0),
    "the restitution of a Stop should be 0 to 1, got 1.5": lambda q, c: swings(
        q, c, Contact(c, load=1.0), Stop(q.angle, 0.3, restitution=1.5), contact=False
    ),
    "the stops of angle leave it no room, from 0.5 to 0.3": lambda q, c: swings(
        q, c, Contact(c, load=1.0), Stop(q.angle, 0.3, -0.5, restitution=0.5), contact=False
    ),
    "loads: should be positive, got (-1)": lambda q, c: swings(q, c, Contact(c, load=-1.0), contact=False),
}


def machine_with(fault):
    """A machine whose parts have a fault."""
    space = {
        "angle": coordinate("theta", "angle", "rad"),
        "position": coordinate("X", "place", "m"),
        "parts": lambda self, q: fault(q, capsule(q)),
        "name": "mistake",
        "effort": "torque",
        "__doc__": "A mistake.",
        "__module__": __name__,
    }
    return parameters(type("Mistake", (Machine,), space))


@pytest.mark.parametrize("said", [*FAULTS, *NUMBERS])
def test_a_fault_of_a_description_is_named(said):
    fault = (FAULTS | NUMBERS)[said]
    report = vc.check_part(machine_with(fault), motion=False)
    assert not report.ok
    assert any(said in each for each in report.wrong), report.wrong
    if said in NUMBERS:
        return
    with pytest.raises((MechanicsError, TypeError)):
        vc.simulate(vc.System(machine_with(fault)(), vc.Coulomb(), vc.Harmonic()), periods=1)


def test_a_contact_has_no_speed_of_its_own_under_an_imposed_motion():
    def parts(self, q):
        table = Support("table", x=q.drive)
        part = Mass("part", 1.0, x=q.position)
        return table, part, Contact(part, on=table, load=1.0, speed="slip")

    own = {"position": coordinate("X", "place", "m"), "parts": parts, "effort": "displacement", "name": "shaken"}
    kind = parameters(type("Shaken", (Machine,), own | {"__doc__": "A part.", "__module__": __name__}))
    (wrong,) = vc.check_part(kind, motion=False).wrong
    assert "the contact of 'part' has a speed: leave it out, the state is 'velocity'" in wrong


def test_a_machine_without_parts_is_told_so():
    @parameters
    class Empty(Machine):
        """Nothing."""

        position = coordinate("X", "place", "m")
        name: ClassVar = "empty"

    assert any("should list the parts of the machine" in each for each in vc.check_part(Empty, motion=False).wrong)


def test_contacts_may_be_named_in_any_order():
    """Each takes a coordinate of its own, whichever stands first: here one that two coordinates move."""

    def parts(self, q):
        rear, front = Mass("rear", 1.0, x=q.position), Mass("front", 1.0, x=q.position + q.displacement)
        return rear, front, Drive(q.displacement), Contact(front, load=1.0), Contact(rear, load=1.0)

    own = {"displacement": coordinate("z", "gap", "m"), "position": coordinate("X", "place", "m"), "parts": parts}
    kind = parameters(type("Pair", (Machine,), own | {"name": "pair", "__doc__": "A pair.", "__module__": __name__}))
    assert kind.contact_states == ("sliding_velocity", "velocity")
    assert (kind.place, kind.cyclic) == ("position", "position")
    assert kind().rates(0.0, (0.0, 0.3, 0.0, 0.1), 0.5, (0.1, 0.2)) == pytest.approx((0.2, 0.4, 0.1, -0.7))


@parameters
class SlidingCrank(Machine):
    """A crank of inertia J moves a slider to and fro on a block: at its dead points it moves nothing else."""

    crank_inertia: NonNegative = parameter(0.0, "J", "inertia of the crank", "inertia")
    slider_mass: NonNegative = parameter(1.0, "m", "mass of the slider", "mass")
    name: ClassVar = "sliding-crank"
    effort: ClassVar = "torque"
    angle = coordinate("theta", "angle of the crank", "rad")
    position = coordinate("X", "place of the block", "m")

    def parts(self, q):
        block = Mass("block", 2.0, x=q.position)
        slider = Mass("slider", self.slider_mass, on=block, x=sin(q.angle))
        crank = Inertia("crank", self.crank_inertia, angle=q.angle, on=block)
        return [block, slider, crank, Drive(q.angle), Damper(0.1, q.angle), Contact(block, load="weight")]


def crank(**numbers):
    return vc.System(SlidingCrank(**numbers), vc.Stribeck(), vc.Harmonic(amplitude=1.0, frequency=1.0))


def test_a_linkage_at_its_dead_point_ends_with_a_singular_mass_matrix():
    motion = vc.simulate(crank(), periods=5)
    assert motion.status is vc.Status.SINGULAR_MASS_MATRIX
    assert 0.0 < motion.end < motion.periods * motion.period
    assert math.pi / 2 - abs(motion.state["angle"]) == pytest.approx(math.sqrt(DEAD), rel=1e-6)  # cos(theta)^2 = DEAD
    assert [event.kind for event in motion.events][-1] == "singular_mass_matrix"
    report = vc.check_part(SlidingCrank, motion=False)
    assert any("the mass matrix is singular at angle -1.57" in each for each in report.wrong), report.wrong
    assert vc.check_part(SlidingCrank(crank_inertia=0.5), motion=False).ok


@pytest.mark.parametrize(("numbers", "angle"), [({}, math.pi / 2), ({"slider_mass": 0.0}, 0.3)])
def test_a_mass_matrix_that_is_singular_at_the_start_is_a_status(numbers, angle):
    motion = vc.simulate(crank(**numbers), periods=1, initial={"angle": angle})
    assert motion.status is vc.Status.SINGULAR_MASS_MATRIX
    assert motion.end == 0.0
    report = vc.check_part(SlidingCrank(**numbers), motion=False)
    assert any("the mass matrix is singular" in each for each in report.wrong), report.wrong


def test_ensembles_say_where_a_mass_matrix_is_singular_and_other_statuses_stay():
    """An inertia of the crank removes the dead point; a run that fails by its drive is "not finite"."""
    over = {"machine.crank_inertia": [0.0, 0.5, 0.5], "drive.amplitude": [1.0, 1.0, 1e308]}
    numbers = vc.ensemble(crank(), over, periods=3)["status"]
    statuses = [list(vc.Status)[number] for number in numbers]
    assert statuses == [vc.Status.SINGULAR_MASS_MATRIX, vc.Status.FINISHED, vc.Status.NOT_FINITE]
    assert vc.simulate(crank(crank_inertia=0.5), periods=3, max_steps=5).status is vc.Status.TOO_MANY_STEPS


def test_a_dead_point_is_located_in_few_steps_wherever_the_crank_runs():
    """Against a damper, where a run would creep on in a million steps; a stepper says so too."""
    start = {"angle_rate": 1.0}
    motion = vc.simulate(crank(), periods=5, initial=start)
    assert motion.status is vc.Status.SINGULAR_MASS_MATRIX
    assert len(motion.piece_start) < 1000
    stepper = vc.stepper(crank(), initial=start)
    with pytest.raises(vc.MotionEnded, match="singular mass matrix"):
        stepper.step(3.0)
    assert stepper.status is vc.Status.SINGULAR_MASS_MATRIX
    assert stepper.time == pytest.approx(motion.end, rel=1e-9)


def test_two_coordinates_that_come_to_move_the_same_masses_end_a_run():
    """Masses at a + b and a + sin(b): det M = (1 - cos(b))^2, of which each inertia by itself says nothing."""

    def parts(self, q):
        block = Mass("block", 2.0, x=q.position)
        masses = [Mass(f"mass {i}", 1.0, on=block, x=q.lead + way) for i, way in enumerate((q.lag, sin(q.lag)))]
        return block, *masses, Drive(q.lag), Contact(block, load="weight")

    own = {"lead": coordinate("a", "place", "m"), "lag": coordinate("b", "place", "m")}
    own |= {"position": coordinate("X", "place", "m"), "parts": parts, "name": "pair-of-leads", "__doc__": "A pair."}
    system = vc.System(
        parameters(type("Pair", (Machine,), own | {"__module__": __name__}))(), vc.Coulomb(), vc.Harmonic()
    )
    motion = vc.simulate(system, periods=5, initial={"lag": 0.5, "lag_rate": -1.0})
    assert motion.status is vc.Status.SINGULAR_MASS_MATRIX
    left = (1.0 - math.cos(motion.state["lag"])) ** 2 / 2.0  # what is left of M_bb = 1 + cos(b)^2
    assert left == pytest.approx(DEAD * math.sqrt(2.0), rel=1e-4)


def test_no_machine_of_the_package_can_lose_a_mass():
    """It follows from their parts, so that none is watched along a motion."""
    assert not [name for name, kind in machines().items() if "singular_mass_matrix" in kind().bound_kinds]


@pytest.mark.parametrize("uneven", [0, 1])
def test_a_load_at_any_contact_that_does_not_repeat_is_named(uneven):
    """The place along a ring comes back after a turn; that of the first contact alone was asked."""

    @parameters
    class Pair(Machine):
        """Two blocks, one of them on a ring."""

        name: ClassVar = "pair"
        first = coordinate("x", "place of one block", "m")
        ring = coordinate("y", "place of the other along its ring", "m", repeats=1.0)

        def parts(self, q):
            bodies = Mass("a", 1.0, x=q.first), Mass("b", 1.0, x=q.ring)
            loads = [2.0 + q.ring if i == uneven else 1.0 for i in range(2)]
            return [*bodies, Drive(q.first), *(Contact(b, load=n) for b, n in zip(bodies, loads, strict=True))]

    wrong = vc.check_part(Pair, motion=False).wrong
    assert any("loads should be the same after a turn of ring" in line for line in wrong)
