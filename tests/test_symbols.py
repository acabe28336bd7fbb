"""The page of symbols: every symbol, name and meaning, both ways complete."""

import dataclasses
import itertools
import re

import pytest

import vibrocap as vc
from vibrocap.case.case import case_from_text
from vibrocap.cli.commands.new import new_case
from vibrocap.motion.recording.equations import equations
from vibrocap.physics import symbols
from vibrocap.physics.catalogue import controllers, drives, laws, machines, wrappers
from vibrocap.physics.parameters import parameter_table

SYMBOLS_PAGE = symbols.page()
KINDS = {"Machine": machines(), "Friction law": laws(), "Drive": drives(), "Controller": controllers()}
PAGE = {part: f"{kind} `{part.name}`" for kind, parts in KINDS.items() for part in parts.values()}  # its heading
PAGE |= {part: part.__name__ for part in (vc.Environment, vc.Actuator)}


def page_rows(heading):
    """(symbol, name, meaning) of the tables of the page under the headings that begin so."""
    sections = re.split(r"^#+ ", SYMBOLS_PAGE, flags=re.MULTILINE)
    rows = [re.findall(r"^\| (.+?) \| `(.+?)` \| (.+?) \|", s, re.MULTILINE) for s in sections if s.startswith(heading)]
    return [row for entry in rows for row in entry]


@pytest.mark.parametrize("part", PAGE, ids=lambda part: part.name)
def test_every_parameter_is_on_the_page_of_symbols(part):
    expected = [(symbols.printed(i.symbol), i.name, i.meaning) for i in parameter_table(part)]
    assert page_rows(PAGE[part]) == expected


def test_the_page_of_symbols_has_every_state_and_quantity_and_no_other():
    friction = [*(law() for law in laws().values()), vc.anisotropic(vc.LuGre)(), vc.backlash(vc.LuGre)()]
    states = {name for m in machines().values() for name in m.states} | {n for law in friction for n in law.internal}
    states |= {
        *vc.Actuator(limit=1.0, command_limit=1.0).states,
        *vc.PositionPID.all_states,
        *vc.SampledPositionPID.all_states,
        *vc.FrictionObserver.all_states,
    }
    assert {name for _, name, _ in page_rows("States")} == states
    names = {"time", "side", "impulse", "impulse_2", "impulse_3", "command", "reference", "controller_work"}
    every, few = [machine() for machine in machines().values()], [vc.PendulumCapsule(), vc.TwoBodyCrawler()]
    every.append(vc.PendulumCapsule(normal_load="dynamic"))
    pairs = [*itertools.product(every, (vc.Coulomb(), vc.LuGre())), *itertools.product(few, friction)]
    for made, law in pairs:
        for environment in (None, vc.Environment()):
            system = vc.System(made, law, vc.Harmonic(), environment=environment)
            names |= {*equations(system).observables, *(f"{channel}_work" for channel in system.channels)}
    assert {name for _, name, _ in page_rows("Further quantities")} == names
    motion = vc.simulate(vc.System(vc.PendulumCapsule(), vc.LuGre(), vc.Harmonic()), periods=0.1)
    assert set(motion.names) <= names | states
    assert all(printed for printed, _, _ in page_rows(""))


def test_a_state_is_called_what_its_machine_calls_it():
    """The block of an oscillator, a coordinate of a mechanism, a law of a further contact: not what others call so."""
    machine, law = (
        case_from_text(
            new_case({"machine": "mechanism", "friction": "lugre", "drive": "harmonic"}, "case.toml")
        ).system.machine,
        vc.LuGre(),
    )
    assert symbols.state_symbols({"machine": machine, "friction": law})["displacement"] == (
        "z",
        "inner mass from the middle of the capsule",
    )
    words = symbols.state_symbols({"machine": vc.TwoBlockRow(), "friction": law})
    assert words["sliding_velocity_2"] == ("v_2", "sliding velocity of body 2")
    assert words["bristle_2"] == ("xi_2", f"{symbols.OF_LAWS['bristle'][1]}, of contact 2")
    assert symbols.state_symbols({"machine": vc.Oscillator, "friction": law})["position"] == ("x", "place of the block")


@pytest.mark.parametrize("name", wrappers())
def test_what_a_wrapper_adds_is_on_the_page_of_symbols(name):
    law = vc.Exponential if name == "smoothed" else vc.LuGre
    added = parameter_table(wrappers()[name](law))[len(parameter_table(law)) :]
    assert added
    expected = [(symbols.printed(i.symbol), i.name, i.meaning) for i in added]
    assert page_rows(f"Around a friction law: `{name}-") == expected


def test_the_page_agrees_with_the_specification():
    """Rows of docs/model.md, typed again."""
    known = {(symbol, name) for several, name, _ in page_rows("") for symbol in several.split(" or ")}
    assert known >= {
        ("λ", "mass_ratio"),
        ("ρ", "stiffness"),
        ("ν", "damping"),
        ("h", "amplitude"),
        ("ω", "frequency"),
        ("N", "normal_load"),
        ("θ", "angle"),
        ("θ'", "angle_rate"),
        ("X", "position"),
        ("X'", "velocity"),
        ("ξ", "bristle"),
        ("δ₀", "bristle_stiffness"),
        ("δ₁", "bristle_damping"),
        ("δ₂", "viscous_damping"),
        ("η_c", "coulomb_coefficient"),
        ("η_s", "static_coefficient"),
        ("v_s", "stribeck_velocity"),
        ("α", "stribeck_exponent"),
        ("a", "decay_rate"),
    }


def test_defaults_are_the_papers():
    law = vc.LuGre()
    assert dataclasses.astuple(law) == (100.0, 10.0, 0.0, 0.15, 0.45, 0.1, 2.0, None)
    assert dataclasses.astuple(vc.Exponential()) == (0.15, 0.45, 10.0)
    assert dataclasses.astuple(vc.PendulumCapsule()) == (2.5, 2.0, 1.0, 1.0)
