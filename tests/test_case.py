"""Case files: what they say is what runs, and every complaint names its field and what would be right."""

import dataclasses
import inspect
import itertools
import math
import types
import typing

import pytest

import vibrocap as vc
from cases import DEFAULTS as PLAIN
from vibrocap.arguments import ArgumentError
from vibrocap.case.case import Case, CaseError, case_from_dict, case_from_text, case_text, read_case
from vibrocap.physics.catalogue import drives, laws, machines
from vibrocap.physics.catalogue import law as law_of
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.parameters import parameter_table
from vibrocap.quantities.hints import call_hints
from vibrocap.quantities.opening import opened_in_si


def complaints(text: str) -> tuple[str, ...]:
    with pytest.raises(CaseError) as caught:
        case_from_text(text)
    return caught.value.complaints


def with_line(section: str, line: str, text: str = PLAIN) -> str:
    """PLAIN with one more line in a section, which is added if it is not there."""
    if f"[{section}]" not in text:
        return f"{text}\n[{section}]\n{line}\n"
    return text.replace(f"[{section}]\n", f"[{section}]\n{line}\n")


def test_a_case_without_numbers_has_the_papers():
    case = case_from_text(PLAIN)
    assert case == Case(vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic()))
    assert (case.initial, case.periods, case.tolerance) == ({}, 40, 1e-9)


def test_the_same_words_as_in_python():
    case = case_from_text(
        """
        [machine]
        kind = "pendulum-capsule"
        mass_ratio = 3
        normal_load = "weight"
        [friction]
        law = "lugre"
        viscous_damping = 0.4
        [drive]
        waveform = "biharmonic"
        second_phase = 0.5
        [initial]
        bristle = 1e-3
        [run]
        periods = 2.5
        tolerance = 1e-8
        max_events_per_period = 7
        max_steps = 1000
        """
    )
    assert case.system == vc.System(
        vc.PendulumCapsule(mass_ratio=3.0, normal_load="weight"),
        vc.LuGre(viscous_damping=0.4),
        vc.Biharmonic(second_phase=0.5),
    )
    assert case.initial == {"bristle": 1e-3}
    assert case.run == {"periods": 2.5, "tolerance": 1e-8, "max_events_per_period": 7, "max_steps": 1000}


TRIPLES = list(zip(machines(), itertools.cycle(drives()), itertools.cycle(laws())))
TRIPLES += [("pendulum-capsule", drive, "coulomb") for drive in drives()]


@pytest.mark.parametrize(("machine", "drive", "law"), TRIPLES)
def test_text_reads_back_equal_to_the_last_bit(machine, law, drive):
    def part(cls):  # every number changed to one that has no short decimal form
        numbers = {i.name: i.default for i in parameter_table(cls) if isinstance(i.default, float)}
        return cls(**{name: math.nextafter(1.03 * value + 0.001 / 3, 9) for name, value in numbers.items()})

    moving, driving = part(machines()[machine]), part(drives()[drive])
    if moving.imposes_motion and not (driving.continuous and type(driving).slope is not Drive.slope):
        with pytest.raises(ArgumentError, match=f"drive: the waveform {drive}"):
            vc.System(moving, part(laws()[law]), driving)
        return
    system = vc.System(moving, part(laws()[law]), driving)
    start = dict.fromkeys(system.state_names, -1e-17 / 3) | dict.fromkeys(system.switched, -1.0)
    start |= {"touching": 0.0} if "touching" in start else {}  # at no stop
    case = Case(system, start, periods=7 / 3, tolerance=1e-9 / 3)
    assert case_from_text(case_text(case)) == case


@pytest.mark.parametrize("law", ["backlash-anisotropic-lugre", "anisotropic-coulomb"])
def test_wrapped_laws_and_parameters_without_a_value_read_back(law):
    """A parameter that is none is left out; with a number it is written."""
    friction = law_of(law)(back_ratio=1.0 / 3)
    system = vc.System(vc.PendulumCapsule(), friction, vc.Harmonic())
    assert case_from_text(case_text(Case(system))).system == system
    lugre = vc.System(vc.PendulumCapsule(), vc.LuGre(damping_velocity=0.1 / 3), vc.Harmonic())
    assert case_from_text(case_text(Case(lugre))).system == lugre
    assert "damping_velocity" not in case_text(Case(system))


def test_text_writes_every_parameter_out():
    """A case stays what it is if a default changes."""
    text = case_text(case_from_text(PLAIN))
    for part in (vc.PendulumCapsule, vc.Exponential, vc.Harmonic):
        for info in parameter_table(part):
            assert f"\n{info.name} = " in text
    for name in ("periods", "tolerance", "max_events_per_period", "max_steps"):
        assert f"\n{name} = " in text


def test_simulate_is_simulate_with_the_same_arguments():
    case = case_from_text(with_line("initial", "angle = 1.0") + "[run]\nperiods = 3\n")
    assert case.simulate().state == vc.simulate(case.system, initial={"angle": 1.0}, periods=3).state


@pytest.mark.parametrize(
    ("section", "line", "expected"),
    [
        ("machine", "mass_ratio = -1", "machine.mass_ratio: should be greater than 0, got -1"),
        ("machine", "mass_ratio = 0.0", "machine.mass_ratio: should be greater than 0, got 0.0"),
        ("machine", "damping = -0.1", "machine.damping: should be at least 0, got -0.1"),
        ("machine", "stiffness = nan", "machine.stiffness: should be a finite number, got nan"),
        ("machine", "stiffness = -inf", "machine.stiffness: should be a finite number, got -inf"),
        ("machine", 'stiffness = "soft"', "machine.stiffness: should be a number, got 'soft'"),
        ("machine", "stiffness = true", "machine.stiffness: should be a number, got True"),
        ("machine", "stiffness = [1, 2]", "machine.stiffness: should be a number, got [1, 2]"),
        ("machine", 'normal_load = "heavy"', "machine.normal_load: should be a finite number >= 0"),
        ("machine", "stifness = 2", "no such key for kind = 'pendulum-capsule'; did you mean 'stiffness'?"),
        ("friction", "bristle_stiffness = 1", "it belongs to law = 'bouc-wen'; here there is coulomb_coefficient,"),
        ("friction", "static_coefficient = 0.1", "friction.static_coefficient: should be at least coulomb_coefficient"),
        ("friction", "coulomb_coefficient = 0.5", "friction.static_coefficient: should be at least coulomb_"),
        ("drive", "frequency = 0", "drive.frequency: should be greater than 0, got 0"),
        ("drive", "second_phase = 0", "drive.second_phase: no such key for waveform = 'harmonic'"),
        ("initial", "angel = 1", "initial.angel: no such state; did you mean 'angle'?"),
        ("initial", "bristle = 1", "initial.bristle: no such state; there is angle, angle_rate, position, velocity"),
        ("initial", "angle = inf", "initial.angle: should be a finite number, got inf"),
        ("initial", 'angle = "pi/3"', "initial.angle: should be a finite number, got 'pi/3'"),
        ("run", "periods = 0", "run.periods: should be a positive number, got 0"),
        ("run", "periods = -2.5", "run.periods: should be a positive number, got -2.5"),
        ("run", "periods = nan", "run.periods: should be a positive number, got nan"),
        ("run", "periods = 1e-300", "run.periods: should be a positive number, at least 1e-09, got 1e-300"),
        ("run", "tolerance = 1", "run.tolerance: should be a number from 1e-14 to 0.01, got 1"),
        ("run", "max_steps = 1.5", "run.max_steps: should be a whole number >= 1, got 1.5"),
        ("run", "max_events_per_period = 0", "run.max_events_per_period: should be a whole number >= 1, got 0"),
        ("run", "period = 3", "run.period: no such key; did you mean 'periods'?"),
        ("runs", "periods = 3", "runs: no such section; did you mean 'run'?"),
        ("colour", "red = 1", "colour: no such section; there is machine, friction, drive, environment, actuator"),
        ("initial", f"angle = 1{'0' * 400}", "initial.angle: should be a finite number, got 1000"),
        ("machine", f"mass_ratio = 1{'0' * 400}", "machine.mass_ratio: should be a number, got 1000"),
    ],
)  # fmt: skip
def test_complaint_names_the_field_and_what_would_be_right(section, line, expected):
    found = complaints(with_line(section, line))
    assert len(found) == 1
    assert expected in found[0]
    assert len(found[0]) < 250


@pytest.mark.parametrize(
    ("given", "wanted", "expected"),
    [
        ('law = "exponential"', f"law = '{5000 * 'x'}'", "friction.law: no law is called 'xxxx"),
        ('law = "exponential"', 'law = "lugree"', "friction.law: no law is called 'lugree'; did you mean 'lugre'?"),
        ('law = "exponential"', 'law = "backlash-coulomb"', "friction.law: no law is called 'backlash-coulomb'"),
        ('law = "exponential"', 'law = "viscous"', "no law is called 'viscous'; there is bouc-wen, coulomb, dahl"),
        ('law = "exponential"', "law = 3", "friction.law: should be 'bouc-wen' or 'coulomb' or 'dahl'"),
        ('law = "exponential"', "", "friction.law: is missing; should be 'bouc-wen' or 'coulomb'"),
        ('waveform = "harmonic"', 'waveform = "sine"', "drive.waveform: no waveform is called 'sine'"),
        ('kind = "pendulum-capsule"', 'kind = "pendulum_capsule"', "machine.kind: no kind is called"),
        ('law = "exponential"', 'law = "lugre"\nstribeck_exponent = 1e308', "should be at most 1e+06, got 1e+308"),
        (
            '[friction]\nlaw = "exponential"', 'normal_load = 0\n[friction]\nlaw = "lugre"',
            "machine.normal_load: should be > 0 with the lugre law, got 0",
        ),
    ],
)  # fmt: skip
def test_unknown_and_missing_parts_and_what_a_law_refuses(given, wanted, expected):
    found = complaints(PLAIN.replace(given, wanted))
    assert len(found) == 1
    assert expected in found[0]


def test_every_complaint_at_once():
    text = """
        [machine]
        kind = "pendulum-capsule"
        mass_ratio = -1
        normal_load = 0
        [friction]
        law = "lugre"
        coulomb_coefficient = 0.5
        bristle_stiffness = "x"
        [drive]
        waveform = "harmonic"
        frequency = 0
        [initial]
        angel = 0
        [run]
        periods = 0
        tolerance = "x"
        """
    paths = [complaint.partition(":")[0] for complaint in complaints(text)]
    assert sorted(paths) == [
        "drive.frequency",
        "friction.bristle_stiffness",
        "friction.static_coefficient",
        "initial.angel",
        "machine.mass_ratio",
        "machine.normal_load",
        "run.periods",
        "run.tolerance",
    ]


def test_empty_text_says_what_is_missing():
    paths = [complaint.partition(":")[0] for complaint in complaints("")]
    assert paths == ["machine.kind", "friction.law", "drive.waveform"]


def test_section_that_is_no_section():
    found = complaints(PLAIN.replace("[machine]", "machine = 3\n[other]"))
    assert "machine: should be a section, [machine] with its keys below it, got 3" in found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("[machine\n", "line 1, column 9: "),
        (
            "[machine]\nkind = pendulum\n",
            "line 2, column 8: Invalid value: a number such as 0.1, or words in quotation",
        ),
        ("[run]\nperiods = 1\nperiods = 2\n", "line 3"),
        (f"a = {'[' * 5000}", "TOML: "),
        (f"a = {'1' * 5000}", "TOML: "),
    ],
)
def test_broken_toml_says_where(text, expected):
    (found,) = complaints(text)
    assert expected in found


def test_files_that_cannot_be_read(tmp_path):
    (tmp_path / "picture.toml").write_bytes(b"\x89PNG\xff")
    for name, expected in (("nowhere.toml", "no such file"), ("", "is a folder"), ("picture.toml", "UTF-8")):
        with pytest.raises(CaseError, match=expected) as caught:
            read_case(tmp_path / name)
        assert str(tmp_path / name) in str(caught.value)


def test_file_with_a_byte_order_mark_and_settings_from_outside(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(PLAIN + "[run]\nperiods = 3\n", encoding="utf-8-sig")
    assert read_case(path).periods == 3
    assert read_case(path, periods=5).periods == 5


def test_case_made_in_python_is_checked_too():
    system = case_from_text(PLAIN).system
    with pytest.raises(ValueError, match="periods"):
        Case(system, periods=0)
    with pytest.raises(ValueError, match=r"initial\.angel"):
        Case(system, {"angel": 1.0})
    with pytest.raises(dataclasses.FrozenInstanceError):
        Case(system).periods = 3  # type: ignore[misc]


def test_dict_with_numbers_that_toml_does_not_know():
    case = {"machine": {"kind": "pendulum-capsule", "mass_ratio": None}, "friction": {"law": "lugre"}}
    with pytest.raises(CaseError) as caught:
        case_from_dict(case)
    assert len(caught.value.complaints) == 2


# --- a case in place of a system --------------------------------------------------------------------------------------
START = {"angle": -1.0}


def cased(units=None):
    """A case that starts where the motion that it settles to travels backwards, and runs as few periods."""
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic(), units=units)
    return system, Case(system, START, periods=4, tolerance=1e-8)


def test_a_case_is_simulated_as_it_says():
    """By the public function, the command and the case itself: with its start and its run, unless others are given."""
    system, case = cased()
    wanted = vc.simulate(system, initial=START, periods=4, tolerance=1e-8)
    assert vc.simulate(case).state == case.simulate().state == wanted.state
    assert vc.simulate(case, periods=2, initial={}).state == vc.simulate(system, periods=2, tolerance=1e-8).state
    again = vc.simulate(case, start=wanted, periods=1)  # a motion that goes on begins where it was
    assert again.initial == wanted.state
    assert vc.simulate(case, start=2.0).start_time == 2.0
    assert vc.simulate(case, start=2.0).initial == wanted.initial


def test_a_case_in_si_answers_in_si():
    system, case = cased(vc.PendulumScales(0.2, 0.25))
    assert vc.simulate(case).unit_of("position") == "m"
    assert vc.simulate(case).state == vc.simulate(system, initial=START, periods=4, tolerance=1e-8).state


def test_every_public_function_of_a_system_takes_a_case():
    """It is given the system, the case's start where it takes one, and the run where it takes all of that."""
    system, case = cased()
    table = {}
    for name in vc.__all__:
        function = getattr(vc, name)
        if not isinstance(function, types.FunctionType):
            continue
        for parameter, hint in call_hints(function).items():
            kinds = typing.get_args(hint) or (hint,)
            if parameter != "return" and vc.System in kinds:
                table[name] = parameter, kinds
    assert len(table) >= 25
    for name, (parameter, kinds) in table.items():
        signature = inspect.signature(getattr(vc, name))
        if vc.Case in kinds:
            continue
        given = {}

        def plain(*args, signature=signature, given=given, **kwargs):
            given.update(signature.bind_partial(*args, **kwargs).arguments)

        others = {
            parameter.name: None
            for parameter in signature.parameters.values()
            if parameter.default is parameter.empty
            and parameter.kind not in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL)
        }
        plain.__wrapped__ = inspect.unwrap(getattr(vc, name))
        opened_in_si(plain)(**(others | {parameter: case}))
        assert given[parameter] is system, name
        assert given.get("initial", START) == START, name
        assert ("initial" in given) == ("initial" in signature.parameters), name
        assert ("max_steps" in given) == (given.get("periods") == 4), name
