"""Views of results: the JSON of every command has one shape, and holds the numbers of the case without units."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from vibrocap.case.case import Case, case_text, read_case
from vibrocap.cli.command import COMMANDS
from vibrocap.cli.main import app_of, main

EXAMPLES = Path(__file__).parents[1] / "examples"
BENCH = EXAMPLES / "bench-in-si.toml"
# Each value of a record is one of these; an object with "unit" is a number with a unit, or several in lists.
NUMBERS = {"anyOf": [{"type": "number"}, {"type": "null"}, {"ref": "complex"}, {"items": {"ref": "numbers"}}]}
SCHEMA = {
    "record": {
        "anyOf": [
            {"type": "null"},
            {"type": "boolean"},
            {"type": "string"},
            {"ref": "numbers"},
            {"ref": "quantity"},
            {"items": {"ref": "record"}},
            {"without": "unit", "values": {"ref": "record"}},
        ]
    },
    "numbers": NUMBERS,
    "complex": {"keys": {"real": {"type": "number"}, "imaginary": {"type": "number"}}},
    "quantity": {
        "anyOf": [
            {"keys": {"value": {"ref": "numbers"}, "unit": {"type": "unit"}, "dimensionless": {"ref": "numbers"}}},
            {"keys": {"value": {"ref": "numbers"}, "unit": {"type": "unit"}}},
        ]
    },
}
TYPES = {
    "null": lambda x: x is None,
    "boolean": lambda x: isinstance(x, bool),
    "string": lambda x: isinstance(x, str),
    "number": lambda x: isinstance(x, (int, float)) and not isinstance(x, bool) and math.isfinite(x),
    "unit": lambda x: isinstance(x, str) and x not in ("", "1"),
}
# command, and a word on the form where it has several: its words
IN_SI = {
    "simulate": f"{BENCH} --periods 3",
    "orbit": f"{BENCH} --gradients",
    "crossing": f"{BENCH} --over drive.frequency_Hz=0.99:1.01 --points 2",
    "branch": f"{BENCH} --over machine.capsule_mass_kg=0.5:0.502 --points 400 --depth 0",
    "basins": f"{BENCH} --plane angle_deg=-20:20,velocity_m_per_s=-1:1 --resolution 2",
    "friction": f"{BENCH}",
    "orbit within a bound": "robot.toml",
    "equilibria": "belt.toml",
    "optimise": f"{BENCH} --over drive.frequency_Hz=0.9:1.1 --evaluations 16",
    "robust": f"{BENCH} --uncertain machine.damping_N_m_s_per_rad=0.07:0.09 --samples 8",
    "calibrate": f"{BENCH} --to table.csv --over friction.coulomb_coefficient=0.02:0.2 --starts 1",
    "fit": "damper.csv --law exponential --steady",
    "stick-slip": "pull.csv --stiffness 10 --speed 0.1",
    "friction of a law": "coulomb",
    "friction tests": "coulomb --tests",
    "list": "pendulum-capsule",
    "list of measures": "measures",
    "list check": "coulomb --check --quick",
}

ROBOT = """
[machine]
kind = "two-mass-crawler"
body_mass_kg = 1.0
inner_mass_kg = 1.0
length_unit_m = 0.1
normal_load = "weight"
[friction]
law = "coulomb"
coulomb_coefficient = 1.0
static_coefficient = 1.0
[drive]
waveform = "triangle"
amplitude_m = 0.005
frequency_Hz = 20.0
rise = 0.8
"""
BELT = """
[machine]
kind = "oscillator"
mass_kg = 1.0
stiffness_N_per_m = 1.0
damping_N_s_per_m = 0.1
belt_speed_m_per_s = 1.0
normal_load_N = 1.0
[friction]
law = "coulomb"
coulomb_coefficient = 0.2
static_coefficient = 0.3
[drive]
waveform = "constant"
duration_s = 1.0
"""


def fits(value, rule):
    """Whether a value is one that a rule of the schema allows."""
    if "ref" in rule:
        return fits(value, SCHEMA[rule["ref"]])
    if "anyOf" in rule:
        return any(fits(value, each) for each in rule["anyOf"])
    if "type" in rule:
        return TYPES[rule["type"]](value)
    if "items" in rule:
        return isinstance(value, list) and all(fits(each, rule["items"]) for each in value)
    if not isinstance(value, dict):
        return False
    if "keys" in rule:
        return value.keys() == rule["keys"].keys() and all(fits(value[key], own) for key, own in rule["keys"].items())
    return rule["without"] not in value and all(fits(each, rule["values"]) for each in value.values())


def quantities(value):
    """All objects with a unit in a record."""
    if isinstance(value, list):
        return [found for each in value for found in quantities(each)]
    if not isinstance(value, dict):
        return []
    return [value] if "unit" in value else [found for each in value.values() for found in quantities(each)]


def bare(value):
    """The record with each quantity as it is without units."""
    if isinstance(value, list):
        return [bare(each) for each in value]
    if not isinstance(value, dict):
        return value
    return value["dimensionless"] if "unit" in value else {key: bare(each) for key, each in value.items()}


@pytest.fixture
def answer(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    time = np.linspace(0.0, 6.0, 400)
    speed = 0.1 * np.sin(np.pi * time + 0.3)
    force = np.sign(speed) * (0.8 + 0.7 * np.exp(-50.0 * np.abs(speed)))
    write("damper.csv", "time,velocity,force", time, speed, force)
    write("pull.csv", "time (s),force (N)", time, 1.0 + 0.2 * (time % 0.5 > 0.4) * np.sin(time))
    write("table.csv", "drive.frequency_Hz,mean_velocity", np.array([0.9, 1.0, 1.1]), np.array([-0.1, -0.12, -0.13]))

    def run(command, *words):
        assert main([command, *words, "--json"]) in (0, 3)
        return json.loads(capsys.readouterr().out)

    return run


def write(name, header, *columns):
    np.savetxt(name, np.c_[columns], delimiter=",", header=header, comments="")


def test_every_command_with_json_is_in_the_table():
    app_of()
    with_json = {name for name, each in COMMANDS.items() if "json" in each.request.options()}
    assert with_json == {each.split()[0] for each in IN_SI}


@pytest.mark.parametrize(
    "command", [pytest.param(each, marks=[pytest.mark.slow] * (each == "calibrate")) for each in IN_SI]
)
def test_json_of_every_command_has_one_shape(command, answer):
    for name, text in {"robot": ROBOT, "belt": BELT}.items():
        Path(f"{name}.toml").write_text(text, encoding="utf-8")
    record = answer(command.split()[0], *IN_SI[command].split())
    assert fits(record, {"ref": "record"}), json.dumps(record)
    found = quantities(record)
    of_case = command not in ("fit", "stick-slip")
    assert bool(found) == (not command.startswith(("friction ", "list")))
    assert all(("dimensionless" in each) == of_case for each in found)
    assert all(np.shape(each["value"]) == np.shape(each["dimensionless"]) for each in found if of_case)


@pytest.mark.parametrize("command", ["simulate", "orbit", "friction", "basins"])
def test_numbers_without_units_are_those_of_the_case_without(command, answer):
    """Quantity by quantity, in the same tree, to the last bit."""
    case = read_case(BENCH)
    plain_case = Case(case.system.dimensionless, case.initial, periods=case.periods, tolerance=case.tolerance)
    Path("plain.toml").write_text(case_text(plain_case), encoding="utf-8")
    words = {"simulate": "--periods 3", "basins": "--plane angle,phase --resolution 2"}
    rest = words.get(command, "").split()
    in_si, plain = (answer(command, str(path), *rest) for path in (BENCH, "plain.toml"))
    assert quantities(in_si)
    assert not quantities(plain)
    assert bare(in_si) == plain


def test_a_shape_of_another_kind_is_refused():
    for bad in ({"value": 1.0, "unit": "1"}, {"drift": {"value": 1.0, "units": "m", "unit": "m"}}, [{"unit": "m"}]):
        assert not fits(bad, {"ref": "record"})
