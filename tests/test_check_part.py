"""check_part: a part that keeps its contract is told so, and each fault is found by its clause and said in words."""

import dataclasses
import json
from typing import ClassVar

import pytest

import vibrocap as vc
from hand_machines import pendulum_capsule as by_hand
from vibrocap.cli.main import main
from vibrocap.cli.terminal import OK, WRONG_INPUT
from vibrocap.contracts.system_clauses import motion_of, moves, system_of
from vibrocap.physics.bodies import Mechanism
from vibrocap.physics.catalogue import unregister
from vibrocap.physics.elementary import cos, sin, tanh
from vibrocap.physics.friction.law import Law, NonNegative, Positive, parameter, parameters
from vibrocap.physics.machines.machine import Contact
from vibrocap.physics.part_files import load_parts


def of(part, **changed):
    """A class like a part, with other constants and functions."""
    return parameters(type("Changed", (part,), {"__module__": __name__, "name": "changed", **changed}))


def abs_force(self, velocity, internal, side, load):
    return side * self.steady_force(abs(velocity), load), ()


def one_sided(self, velocity, internal, side, load):
    return side * self.steady_force(side * velocity, load) + 0.1 * velocity * velocity, ()


def counting(self, t):
    self.__dict__["calls"] = self.__dict__.get("calls", 0) + 1
    return self.amplitude * cos(self.frequency * t) + 1e-3 * self.__dict__["calls"]


class DYNAMIC(vc.PendulumCapsule):
    """A capsule under the load that it makes."""

    follows_load = True

    def loads(self):
        return (self.mass_ratio + 1.0,)


def lifted(self, t, y, drive):
    (found,) = vc.PendulumCapsule.contacts(self, t, y, drive)
    inertia, own, slope = found.reaction
    return (dataclasses.replace(found, reaction=(inertia, own + 0.1 * drive, slope)),)


def held_otherwise(part, number, **changed):
    """Its contacts, one of them with other fields."""

    def contacts(self, t, y, drive):
        found = list(part.contacts(self, t, y, drive))
        found[number - 1] = dataclasses.replace(found[number - 1], **changed)
        return tuple(found)

    return of(part, contacts=contacts)


def sprung(self, t, y, drive, frictions):
    return y[1], (drive - frictions[0]) / self.mass


def forgets_a_belt(self, t, y, drive, frictions):
    drive_power, damper = vc.TwoBodyCrawler.powers(self, t, y, drive, frictions)
    return drive_power, damper - 0.3 * sum(frictions[1:])


def unsprung(self, t, y):
    capsule, bob = vc.PendulumCapsule.mechanism(self, t, y).bodies
    return Mechanism((capsule, dataclasses.replace(bob, stiffness=0.0)))


def heavier(self, t, y):
    (block,) = vc.Oscillator.mechanism(self, t, y).bodies
    mass, rate = 2.0 * block.mass, block.rate / 2.0**0.5  # of the same energy
    return Mechanism((dataclasses.replace(block, mass=mass, rate=rate),))


def undamped(self, t, y):
    found = vc.TwoBodyCrawler.mechanism(self, t, y)
    return Mechanism(found.bodies, (dataclasses.replace(found.links[0], damping=0.0),))


LAW, LUGRE, OSCILLATOR, CAPSULE, HARMONIC = vc.Exponential, vc.LuGre, vc.Oscillator, vc.PendulumCapsule, vc.Harmonic
FAULTS = {
    # what: (the part, what its report says)
    "a kink": (of(LAW, force=abs_force), "in abs_force: a recorded formula cannot hold a kink: write side * velocity"),
    "holds less than it slides with": (
        of(LAW, holding_limit=lambda self, load: load * self.coulomb_coefficient),
        "holding_limit: at rest it holds from -0.195 to 0.195, but slides with -0.585 and 0.585 as the speed vanishes",
    ),
    "one-sided": (of(LAW, force=one_sided), "should be the same with the other sign, exactly"),
    "says it is one-sided": (of(LAW, symmetric=False), "holding_centre: is 0, while `symmetric` is False"),
    "infinite": (of(LAW, steady_force=lambda self, speed, load: load / speed), "ZeroDivisionError: "),
    "steady force": (of(LAW, force=lambda self, v, z, side, load: (0.2 * side * load, ())), "steady_force: is "),
    "gives energy": (
        of(LAW, force=lambda self, v, z, side, load: (-0.2 * side * load, ())),
        "passive: is True, but the law gives",
    ),
    "losses": (
        of(LUGRE, losses=lambda self, v, z, side, load: (0.0, 0.0)),
        "losses, stored_energy: the contact",
    ),
    "rates": (of(LUGRE, internal=("bristle", "other")), "internal_scales: gives 1 sizes for the 2 states in internal"),
    "jump": (of(LAW, kind="kinked"), "kind: is 'kinked', but the force jumps at rest"),
    "kink of a smooth law": (of(LUGRE, kind="smooth"), "kind: is 'smooth', but a law with internal states is 'kinked'"),
    "no kink": (
        of(LAW, kind="kinked", force=lambda self, v, z, side, load: (load * v, ())),
        "kind: is 'kinked', but neither the force nor a rate has a kink at rest",
    ),
    "words": (of(LAW, creeps="no"), "creeps: should be True or False, got 'no'"),
    "unknown shape": (of(LAW, shape_parameters=("alpha",)), "shape_parameters: should be a tuple of names among"),
    "not held": (
        of(OSCILLATOR, rates=sprung),
        "rates: with its holding_force as friction the rate of sliding_",
    ),
    "energy": (
        of(OSCILLATOR, energy=lambda self, t, y: 0.5 * self.mass * y[1] * y[1]),
        "energy, powers: the",
    ),
    "momentum": (of(OSCILLATOR, momentum=lambda self, t, y: y[1]), "momentum, outer_force: the momentum grows by"),
    "signs": (of(OSCILLATOR, symmetry=(-1, 1), symmetric=True), "symmetry: mirrored rates should be"),
    "cyclic": (of(OSCILLATOR, cyclic="position"), "rates: should not depend on the cyclic state position"),
    "turns": (of(CAPSULE, turns={"angle": 6.0}), "rates: should be the same after a whole turn of angle"),
    "travel turns": (of(CAPSULE, turns={"position": 1.0}), "turns: should name states that neither travel nor slide"),
    "place": (of(OSCILLATOR, place="sliding_velocity"), "rates: sliding_velocity should move with the velocity of"),
    "contact": (
        of(OSCILLATOR, contacts=lambda self, t, y, drive: (Contact(2 * y[1], drive),), rates=sprung),
        "contacts: the velocity changes by 0.5",
    ),
    "contact state": (of(OSCILLATOR, contact_states=("speed",)), "contact_states: should be a tuple of one name for"),
    "one name": (of(OSCILLATOR, contact_states="position"), "contact_states: should be a tuple of one name for each"),
    "a contact is missing": (
        of(vc.TwoBodyCrawler, contacts=lambda self, t, y, drive: (Contact(y[3], 0.0),)),
        "contacts: should be a tuple of one Contact for each of contact_states (velocity, velocity_2)",
    ),
    "a load is missing": (of(vc.TwoBodyCrawler, loads=lambda self: (1.0,)), "loads: should be a tuple of one load for"),
    "nothing holds": (
        held_otherwise(OSCILLATOR, 1, holding_force=None),
        "contacts: contact 1 should have a holding_force or, in its place, an acceleration and a response of 1 numbers",
    ),
    "the second is held by another force": (
        held_otherwise(vc.TwoBodyCrawler, 2, holding_force=0.1),
        "rates: with its holding_force as friction the rate of velocity_2 should be exactly 0, got",
    ),
    "two forms": (
        held_otherwise(vc.LinkageCrawler, 2, acceleration=None, response=(), holding_force=0.0),
        "contacts: should all have a holding_force, or all an acceleration and a response",
    ),
    "another response": (
        held_otherwise(vc.LinkageCrawler, 1, response=(0.5, 0.1)),
        "rates: the acceleration of contact 1 should be",
    ),
    "no reaction": (
        held_otherwise(DYNAMIC, 1, reaction=None),
        "contacts: contact 1 should have a reaction, which is its load by follows_load",
    ),
    "part of a reaction": (
        held_otherwise(vc.LinkageCrawler, 2, reaction=(1.0, 0.5, 0.1)),
        "contacts: the reaction of contact 2 should be (b, n, s_1, ...), 4 numbers",
    ),
    "mechanism without its spring": (of(CAPSULE, mechanism=unsprung), "mechanism: its energy is "),
    "mechanism of another mass": (of(OSCILLATOR, mechanism=heavier), "mechanism: its momentum is "),
    "mechanism without its damper": (of(vc.TwoBodyCrawler, mechanism=undamped), "mechanism: its power is "),
    "channels": (of(CAPSULE, channels=("motor", "damper")), "channels: should be a tuple of names, each once, among"),
    "channel of friction": (of(CAPSULE, channels=("drive", "bristle_loss")), "channels: 'bristle_loss' is no name for"),
    "strikes nothing": (of(OSCILLATOR, strikes_ground=("impact",)), "strikes_ground: names 'impact', which is none of"),
    "impulse of the ground": (of(vc.OscillatorWithStops, strikes_ground=()), "after_switch: guard 0 changes the momen"),
    "wall force": (
        of(vc.OscillatorWithStops, wall_force=lambda self, t, y, drive, frictions: 0.1),
        "momentum, outer_force: the momentum grows by",
    ),
    "work at a second contact": (of(vc.TwoBodyCrawler, powers=forgets_a_belt), "energy, powers: the energy grows by"),
    "heavier": (
        of(DYNAMIC, vertical_momentum=lambda self, t, y: 0.5 * CAPSULE.vertical_momentum(self, t, y)),
        "contacts, vertical_momentum: the load is",
    ),
    "lifted one way": (
        of(DYNAMIC, contacts=lifted, symmetric=True, vertical_momentum=lambda self, t, y: None),
        "contacts: loads should be the same in the mirrored state",
    ),
    "no mass": (of(CAPSULE, masses=lambda self: {"angle_rate": 1.0}), "masses: should have that of the body at the"),
    "unknown mass": (of(CAPSULE, masses=lambda self: {"speed": 1.0}), "masses: should be named by states, got speed"),
    "mass of an angle": (
        of(by_hand.PendulumCapsule, masses=lambda self: {"velocity": 2.5, "angle_rate": 1.0}),
        "masses: on a slope the energy grows by",
    ),
    "load": (of(CAPSULE, loads=lambda self: (-1.0,)), "loads: should be positive, got (-1)"),
    "scales": (of(CAPSULE, scales=lambda self, time=1.0: (1.0, 1.0)), "scales: should be a positive size for each of"),
    "period": (of(HARMONIC, period=1.0), "value: is "),
    "even": (of(HARMONIC, odd=False), "odd: is False, but value(t + period/2) + value(t) is up to"),
    "slope": (of(HARMONIC, slope=lambda self, t: -self.amplitude * sin(self.frequency * t)), "slope: is "),
    "curvature": (of(vc.Square, curvature=lambda self, t: 1.0), "curvature: is 1 at time "),
    "memory": (of(HARMONIC, value=counting), "value: is "),
}


@pytest.mark.parametrize("what", FAULTS)
def test_a_fault_is_found_and_said(what):
    part, said = FAULTS[what]
    report = vc.check_part(part, motion=False)
    assert not report.ok
    assert any(said in each for each in report.wrong), str(report)
    assert str(report).startswith(f"The {report.kind} changed breaks ")


def test_a_part_that_is_none_of_the_contracts_is_refused():
    said = "should be a class that extends Law, Machine, Drive or Controller, got <class 'int'>"
    with pytest.raises(TypeError, match=said):
        vc.check_part(3)


def test_a_class_that_cannot_be_registered_is_told_why():
    class Bare(Law):
        kind: ClassVar = "set-valued"

    report = vc.check_part(Bare)
    assert len(report.clauses) == 1
    assert "name: should be a ClassVar" in report.wrong[0]
    assert "write @parameters above the class" in report.wrong[0]


def test_a_part_that_reads_what_is_no_parameter_is_found_by_its_recorded_form():
    """A number that changes behind the back of the recorded equations."""
    memory = {"factor": 1.0}

    def force(self, velocity, internal, side, load):
        memory["factor"] *= 1.01
        return memory["factor"] * tanh(velocity), ()

    changed = of(vc.SmoothedTanh, force=force, steady_force=lambda self, speed, load: tanh(speed), symmetric=False)
    assert any("the recorded rate of" in each for each in vc.check_part(changed, motion=False).wrong)


def test_a_machine_in_the_words_of_before_is_told_what_to_write():
    """As its class is made, so that none of its functions is left out in silence."""
    before = {"contact_state": "velocity", "contacts": ("velocity_2",), "coupled": "motion"}
    before |= dict.fromkeys(("holding_force", "further_holding_forces", "further_loads", "reaction"), len)
    before |= dict.fromkeys(("rates", "powers"), lambda self, t, y, drive, force, force_2=0.0: y)
    with pytest.raises(TypeError, match=r"^Changed: ") as caught:
        of(OSCILLATOR, **before)
    said = str(caught.value).removeprefix("Changed: ").split("; ")
    for found, (names, wanted) in zip(
        said,
        (
            ("contact_state", "write `contact_states`, a tuple of one name for each contact, of the state"),
            ("contacts, holding_force, further_holding_forces", "write `contacts(self, t, y, drive)`, which gives a"),
            ("further_loads", "write `loads(self)`, a tuple of the load on each contact, or leave it out where"),
            ("reaction", "write it as the `reaction` of a `Contact`, (b, n, s_1, ...)"),
            ("coupled", "give each `Contact` its `acceleration` and its `response`"),
            ("rates, powers", "take the friction forces of all contacts as one tuple, `frictions`"),
        ),
        strict=True,
    ):
        assert found.startswith(f"{names}: {wanted}")


def test_an_instance_is_checked_with_its_own_numbers():
    @parameters
    class Rising(vc.Exponential):
        name = "rising"
        extra: NonNegative = parameter(0.0, "b", "what it slides with and does not hold")
        scale: Positive = parameter(1.0, "c", "a number without a role")

        def force(self, velocity, internal, side, load):
            return side * (self.steady_force(side * velocity, load) + self.extra), ()

    assert "kind" not in vc.check_part(Rising(), motion=False).wrong
    assert vc.check_part(Rising(), motion=False).ok
    assert any(each.startswith("holding_limit") for each in vc.check_part(Rising(extra=0.1), motion=False).wrong)
    found = vc.check_part(Rising, motion=False)  # of the class, numbers are drawn as well
    assert any("(with " in each and "extra 0." in each for each in found.wrong)
    assert found.notes[0].startswith("extra, scale: declares neither a role nor a unit")


def test_a_good_part_moves():
    report = vc.check_part(vc.Exponential)
    assert report.ok
    assert report.wrong == ()
    assert report.clauses[-1].clause.startswith("It moves for some periods")
    assert str(report).startswith("The law exponential keeps its contract.\n  ok     ")


def test_a_machine_that_ends_at_once_does_not_move():
    """One that lifts off within a period, however little it is driven, so that nothing can be said of its motion."""
    light = vc.ModeCouplingBlock(normal_load=0.01)
    report = vc.check_part(light)
    assert [each.ok for each in report.clauses[-2:]] == [True, False]
    assert "ended early: The ground would have to pull" in report.wrong[0]
    motion = motion_of(system_of(light), light, 0.1)
    assert 0.0 < motion.end < motion.period


@pytest.mark.slow
def test_a_motion_of_a_machine_with_ends_begins_between_them_and_slides():
    """Driven in full the linkage comes to its stop at once, and driven little it rests: it is checked in between."""
    part = vc.LinkageCrawler()
    motions = {share: motion_of(system_of(part), part, share) for share in (1.0, 0.5, 0.3)}
    assert [each.status.ok for each in motions.values()] == [False, False, True]
    assert motions[1.0].end < motions[1.0].period < motions[0.5].end
    assert motions[0.5].piece_sides.any()
    assert not motions[0.3].piece_sides.any()
    assert moves(part) is None


def test_the_command_checks_files_and_names(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = (
        "import vibrocap as vc\nfrom vibrocap.physics.parameters import parameters\n"
        "@parameters\nclass Weak(vc.Exponential):\n"
        '    """Holds too little."""\n'
        "    name = 'weak'\n"
        "    def holding_limit(self, load): return 0.9 * load * self.static_coefficient\n"
    )
    (tmp_path / "weak.py").write_text(text)
    assert main(["check", "--quick", "--parts", "weak.py"]) == WRONG_INPUT
    found = capsys.readouterr().out
    assert "The law weak breaks one clause of its contract." in found
    assert "WRONG  At rest it is what its kind says" in found
    assert main(["check", "oscillator", "anisotropic-weak", "--quick", "--json", "--parts", "weak.py"]) == WRONG_INPUT
    first, second = json.loads(capsys.readouterr().out)["parts"]
    assert (first["name"], first["kind"], first["ok"]) == ("oscillator", "machine", True)
    assert (second["name"], second["ok"]) == ("anisotropic-weak", False)
    for part in load_parts("weak.py"):
        unregister(part)
    assert main(["check", "--quick", "lugre"]) == OK
    assert "The law lugre keeps its contract." in capsys.readouterr().out
    assert main(["check"]) == WRONG_INPUT
    assert "Name a law, a machine, a drive or a controller" in capsys.readouterr().err
    assert main(["check", "lugree"]) == WRONG_INPUT
    assert "no law, machine, drive or controller is called 'lugree'; did you mean 'lugre'?" in capsys.readouterr().err


BROKEN = [
    ({"reference": "length"}, "reference: should be one of"),
    ({"switched": ("on",)}, "switched: should be named by states, got 'on'"),
    ({"measures": lambda self, machine: ("height",)}, "measures: should name states of the machine"),
    ({"rates": lambda self, *given: (0.0,)}, "rates: should be 0 numbers"),
    ({"scales": lambda self, effort: (1.0,)}, "scales: should be 0 positive numbers"),
    ({"command": lambda self, t, m, own, r, s: (r - m[0]) * (r - m[0])}, "odd: is True, but the command is"),
    ({"command": lambda self, t, m, own, r, s: float("nan")}, "command, rates, switches: should be finite"),
    ({"switches": lambda self, *given: (1.0,)}, "switch_events: should name what happens at each of 1 guards"),
]


@pytest.mark.parametrize(("wrong", "said"), BROKEN, ids=lambda each: each[:30] if isinstance(each, str) else "")
def test_each_clause_of_a_controller_finds_its_fault(wrong, said):
    from vibrocap.physics.controllers.controller import Controller
    from vibrocap.physics.parameters import parameters

    own = {
        "__doc__": "A spring.",
        "name": "own-spring",
        "reference": "displacement",
        "measures": lambda self, machine: ("position",),
        "command": lambda self, t, measured, own, reference, slope: reference - measured[0],
    }
    assert vc.check_part(parameters(type("Spring", (Controller,), dict(own))), motion=False).ok
    report = vc.check_part(parameters(type("Spring", (Controller,), own | wrong)), motion=False)
    assert any(said in each for each in report.wrong), str(report)
