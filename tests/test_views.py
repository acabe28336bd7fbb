"""Views of results: the JSON of every command has one shape, and holds the numbers of the case without units.

Each quantity of every command is its number without units times the size of its unit, written out by hand.
"""

import json
import math
import re
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
    "orbit": f"{BENCH}",
    "orbit gradients": f"{BENCH} --gradients",
    "crossing": f"{BENCH} --over drive.frequency_Hz=0.99:1.01 --points 2 --value=-0.12",
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

# mass, length and time in which a case counts: of its pendulum or its inner mass, with sqrt(l/g), or SI itself
SIZES = {"bench": (0.2, 0.25, math.sqrt(0.25 / 9.80665)), "robot": (1.0, 0.1, math.sqrt(0.1 / 9.80665))}
SIZES |= {"belt": (1.0, 1.0, 1.0)}
# what the case without units calls the parameters over which a command goes, and their units
PLAIN = {
    "drive.frequency_Hz": ("drive.frequency", "Hz"),
    "machine.capsule_mass_kg": ("machine.mass_ratio", "kg"),
    "machine.damping_N_m_s_per_rad": ("machine.damping", "N m s/rad"),
    "--value": ("--value", "m"),
}
# commands on the bench, in SI and without units
IN_SI_ALONE = {
    "simulate": "--periods 3",
    "orbit": "",
    "friction": "",
    "basins": "--plane angle,phase --resolution 2",
    "crossing": "--over drive.frequency_Hz=0.99:1.01 --points 2 --value=-0.12",
    "branch": "--over machine.capsule_mass_kg=0.5:0.502 --points 400 --depth 0",
    "optimise": "--over drive.frequency_Hz=0.9:1.1 --evaluations 16",
    "robust": "--uncertain machine.damping_N_m_s_per_rad=0.07:0.09 --samples 8",
}
# which numbers of a record in SI have a unit; the rest have none
UNITS = {
    "rad": "angle",
    "rad/s": "angle_rate eigenvalues frequency",
    "m": "differences drift position value values",
    "m/s": "centre_velocity deviation mean mean_velocity nominal reached sliding_velocity tail_mean value velocity"
    " worst 0.05 0.25 0.5 0.75 0.95",
    "s": "period time window",
    "kg": "between parameter",
    "N": "breakaway_force coulomb_force friction least_reaction load",
    "J": "bristle_loss contact_sliding contact_storage damper drive residual stored",
    "J/m": "cost_of_transport reached value",
    "Hz": "at bracket drive.frequency_Hz error parameters",
    "m per Hz": "slope",
    "m/s per Hz": "drive.frequency_Hz",
    "N s/m": "slope",
    "1": "back bound correlation defect deviation elasticity energy_residual error estimated_error event_velocity"
    " failed forward friction.coulomb_coefficient high imaginary largest_multiplier least_reaction least_velocity lost"
    " low misfit momentum_residual no_travel not_certified not_settled periods real residual"
    " share slip_shortfall slope standard_error stick_force_ratio stick_fraction value wrong_way",
}


def unit_size(unit, case="bench"):
    """How much of a unit is one without units."""
    kg, m, s = SIZES[case]
    newton = kg * m / s**2
    sizes = {"kg": kg, "m": m, "s": s, "N": newton, "J": newton * m, "rad": 1.0, "Hz": 0.5 / (math.pi * s)}
    above, *below = (math.prod(sizes[word] for word in part.split()) for part in re.split("/| per ", unit))
    return above / math.prod(below)


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
        return [quantity for each in value for quantity in quantities(each)]
    if not isinstance(value, dict):
        return []
    return [value] if "unit" in value else [quantity for each in value.values() for quantity in quantities(each)]


def units_of(value, name=""):
    """(name, unit) of all numbers of a record."""
    if isinstance(value, list | dict) and "unit" not in value:
        items = value.items() if isinstance(value, dict) else ((name, each) for each in value)
        return {pair for key, each in items for pair in units_of(each, key)}
    return {(name, value["unit"] if isinstance(value, dict) else "1")} if isinstance(value, float | dict) else set()


def leaves(value, place=()):
    """What stands at the ends of a record, and where."""
    if not isinstance(value, list | dict):
        return [(place, value)]
    items = value.items() if isinstance(value, dict) else enumerate(value)
    return [leaf for key, each in items for leaf in leaves(each, (*place, key))]


def numbers(quantity):
    """All numbers of a quantity in one array; none is nan."""
    return np.array([np.nan if number is None else number for _, number in leaves(quantity)])


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
    with_json = {name for name, command in COMMANDS.items() if "json" in command.request.options()}
    assert with_json == {each.split()[0] for each in IN_SI}


MARKS = {"calibrate": pytest.mark.slow, "orbit gradients": pytest.mark.slow, "orbit within a bound": pytest.mark.plain}


@pytest.mark.parametrize("command", [pytest.param(each, marks=MARKS.get(each, ())) for each in IN_SI])
def test_json_of_every_command_has_one_shape(command, answer):
    for name, text in {"robot": ROBOT, "belt": BELT}.items():
        Path(f"{name}.toml").write_text(text, encoding="utf-8")
    record = answer(command.split()[0], *IN_SI[command].split())
    assert fits(record, {"ref": "record"}), json.dumps(record)
    found = quantities(record)
    of_case = command not in ("fit", "stick-slip")
    assert bool(found) == (not command.startswith(("friction ", "list")))
    assert all(("dimensionless" in each) == of_case for each in found)
    case = next((name for name in SIZES if f"{name}.toml" in IN_SI[command]), "bench")
    for name, unit in units_of(record) if found and of_case else ():
        assert name.replace(" ", "_") in UNITS[unit].split(), (name, unit)
    for each in found if of_case else ():
        wanted = numbers(each["dimensionless"]) * unit_size(each["unit"], case)
        np.testing.assert_allclose(numbers(each["value"]), wanted, rtol=1e-12, err_msg=str(each))


def without_units(words):
    """The words of a command with the names and the ranges of the case without units."""

    def plain(match):
        path, unit = PLAIN[match[1]]
        return f"{path}=" + ":".join(repr(float(end) / unit_size(unit)) for end in match[2].split(":"))

    words = re.sub(rf"({'|'.join(PLAIN)})=([\d.:-]+)", plain, words)
    return re.sub("|".join(PLAIN), lambda match: PLAIN[match[0]][0], words)


@pytest.mark.parametrize("command", IN_SI_ALONE)
def test_numbers_without_units_are_those_of_the_case_without(command, answer):
    """Quantity by quantity, in the same tree: to the last bit, but where the ends of a range are rounded anew."""
    case = read_case(BENCH)
    plain_case = Case(case.system.dimensionless, case.initial, periods=case.periods, tolerance=case.tolerance)
    Path("plain.toml").write_text(case_text(plain_case), encoding="utf-8")
    words = IN_SI_ALONE[command]
    output, plain = (
        answer(command, str(BENCH), *words.split()),
        answer(command, "plain.toml", *without_units(words).split()),
    )
    assert quantities(output)
    assert not quantities(plain)
    output = json.loads(without_units(json.dumps(bare(output))))
    for (place, one), (same, other) in zip(leaves(output), leaves(plain), strict=True):
        assert place == same
        rounded = "=" in words and isinstance(one, float)
        assert one == (pytest.approx(other, rel=1e-6, abs=1e-9) if rounded else other), place
