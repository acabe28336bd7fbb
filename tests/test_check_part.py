"""check_part: a part that keeps its contract is told so, and each fault is found by its clause and said in words."""

import json
from typing import ClassVar

import pytest

import vibrocap as vc
from cases import printed, refused
from thinned import exhaustive_but
from vibrocap.cli.main import main
from vibrocap.cli.terminal import WRONG_INPUT
from vibrocap.contracts.system_clauses import motion_of, moves, system_of
from vibrocap.mechanics import Contact, Damper, Drive, Machine, Mass, Potential, Spring, Stop, Support, coordinate
from vibrocap.physics.catalogue import unregister
from vibrocap.physics.elementary import cos, sin, tanh
from vibrocap.physics.friction.law import Law, NonNegative, Positive, parameter, parameters
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
    "scales": (of(CAPSULE, scales=lambda self, time=1.0: (1.0, 1.0)), "scales: should be a positive size for each of"),
    "effort": (of(CAPSULE, effort="torqe"), "effort: should be one of force, torque, displacement, angle, number, got"),
    "impulse of the ground": (of(vc.OscillatorWithStops, strikes_ground=()), "after_switch: guard 0 changes the momen"),
    "half": (
        of(vc.OscillatorWithStops, after_switch=lambda self, *at: (*at[2][:2], 0.5)),
        "touching should become whole",
    ),
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


# --- parts that are right ---------------------------------------------------------------------------------------------


def led(q):
    """How far the anchor of a spring is led, or a belt, with the period of the drive of `system_of`."""
    return 0.3 * sin(1.3 * q.time)


class Led(Machine):
    """A block that stands on a belt, or on a spring whose far end is led."""

    position = coordinate("x", "place", "m", rate="sliding_velocity")
    name: ClassVar = "led"

    def parts(self, q):
        belt, block = Support("belt", x=self.belt(q)), Mass("block", 1.0, x=q.position)
        return belt, block, self.joint(q), Drive(q.position), Contact(block, on=belt, load=1.0)

    def belt(self, q):
        return 0.0

    def joint(self, q):
        return Spring(1.0, q.position)


def as_led(**own):
    return parameters(type("Led", (Led,), {"__module__": __name__, "__doc__": Led.__doc__, **own}))


RIGHT = {
    "an anchor that moves in time": as_led(joint=lambda self, q: Spring(1.0, q.position - led(q))),
    "a rest that moves in time": as_led(joint=lambda self, q: Spring(1.0, q.position, rest=led(q))),
    "an energy that depends on time": as_led(joint=lambda self, q: Potential(0.5 * (q.position - led(q)) ** 2)),
    "a damper that is led": as_led(joint=lambda self, q: (Spring(1.0, q.position), Damper(0.3, q.position - led(q)))),
    "a stop that moves": as_led(joint=lambda self, q: Stop(q.position - led(q), 0.2, stiffness=5.0)),
    "a belt whose speed depends on time": as_led(belt=lambda self, q: led(q)),
    "numbers of its own that say the period": as_led(
        **{name: parameter(rate, name, "of the belt", unit="rad/s") for name, rate in (("slow", 0.7), ("fast", 1.4))},
        __annotations__={"slow": Positive, "fast": Positive},
        belt=lambda self, q: 0.3 * sin(self.slow * q.time) + 0.1 * sin(self.fast * q.time),
    ),
}


@pytest.mark.parametrize("what", RIGHT)
def test_what_moves_in_time_works_on_the_channel_of_belts(what):
    assert RIGHT[what].channels == ("drive", "damper", "belt")
    assert vc.check_part(RIGHT[what], motion=False).wrong == ()


@pytest.mark.slow
@pytest.mark.parametrize("what", exhaustive_but([3, 5], [*RIGHT]))
def test_a_part_that_moves_in_time_is_certified(what):
    assert moves(RIGHT[what]()) is None


def test_large_numbers_and_a_slow_belt_are_right():
    part = OSCILLATOR(mass=1e3, stiffness=5e5, damping=4.5e6, belt_speed=-1e-8, normal_load=5e7)
    assert vc.check_part(part, motion=False).wrong == ()


def test_what_follows_from_the_parts_is_not_written_again():
    text = "Changed: rates, momentum: should be left out, it follows from `parts`"
    with pytest.raises(TypeError, match=text):
        of(OSCILLATOR, rates=lambda self, t, y, drive, frictions: (y[1], drive), momentum=len)


def test_a_part_that_is_none_of_the_contracts_is_refused():
    text = "should be a class that extends Law, Machine, Drive or Controller, got <class 'int'>"
    with pytest.raises(TypeError, match=text):
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
    verdict = vc.check_part(Rising, motion=False)  # of the class, numbers are drawn as well
    assert any("(with " in each and "extra 0." in each for each in verdict.wrong)
    assert verdict.notes[0].startswith("extra, scale: declares neither a role nor a unit")


@pytest.mark.plain
def test_a_good_part_moves():
    report = vc.check_part(vc.Exponential)
    assert report.ok
    assert report.wrong == ()
    assert report.clauses[-1].clause.startswith("It moves for some periods")
    assert str(report).startswith("The law exponential keeps its contract.\n  ok     ")


@pytest.mark.plain
def test_a_machine_that_ends_at_once_does_not_move():
    """One that lifts off within a period, however little it is driven, so that nothing can be said of its motion."""
    light = vc.ModeCouplingBlock(normal_load=0.01)
    report = vc.check_part(light)
    assert [clause.ok for clause in report.clauses[-2:]] == [True, False]
    assert "ended early: The ground would have to pull" in report.wrong[0]
    motion = motion_of(system_of(light), light, 0.1)
    assert 0.0 < motion.end < motion.period


@pytest.mark.slow
def test_a_motion_of_a_machine_with_ends_begins_between_them_and_slides():
    """Driven in full the linkage comes to its stop at once, and driven little it rests: it is checked in between."""
    part = vc.LinkageCrawler()
    motions = {share: motion_of(system_of(part), part, share) for share in (1.0, 0.5, 0.3)}
    assert [motion.status.ok for motion in motions.values()] == [False, False, True]
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
    found = printed(capsys, "list", "--check", "--quick", "--parts", "weak.py", code=WRONG_INPUT)
    assert "The law weak breaks one clause of its contract." in found
    assert "WRONG  At rest it is what its kind says" in found
    options = ["--check", "--quick", "--json", "--parts", "weak.py"]
    assert main(["list", "oscillator", "anisotropic-weak", *options]) == WRONG_INPUT
    first, second = json.loads(capsys.readouterr().out)["parts"]
    assert (first["name"], first["kind"], first["ok"]) == ("oscillator", "machine", True)
    assert (second["name"], second["ok"]) == ("anisotropic-weak", False)
    for part in load_parts("weak.py"):
        unregister(part)
    assert "The law lugre keeps its contract." in printed(capsys, "list", "lugre", "--check", "--quick")
    assert "--check: name a part" in refused(capsys, "list", "--check")
    assert "'drives' is no part; `vibrocap list drives`" in refused(capsys, "list", "drives", "--check")
    assert main(["list", "lugree", "--check"]) == WRONG_INPUT
    assert "no machine, law, drive or controller is called 'lugree'; did you mean 'lugre'?" in capsys.readouterr().err


BROKEN = [
    ({"reference": "length"}, "reference: should be one of"),
    ({"switched": ("on",)}, "switched: should be named by states, got 'on'"),
    ({"measures": lambda self, machine: ("height",)}, "measures: should name states of the machine"),
    ({"rates": lambda self, *given: (0.0,)}, "rates: should be 0 numbers"),
    ({"scales": lambda self, effort: (1.0,)}, "scales: should be 0 positive numbers"),
    ({"command": lambda self, t, m, own, r, s: (r - m[0]) * (r - m[0])}, "odd: is True, but the command is"),
    ({"command": lambda self, t, m, own, r, s: float("nan")}, "command, rates, switches: should be finite"),
    ({"switches": lambda self, *given: (1.0,)}, "switch_events: should name the event at each of 1 guards"),
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
