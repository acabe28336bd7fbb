"""The text of a new case: every parameter of its parts with its default, its symbol and its meaning."""

import tomllib
from collections.abc import Mapping
from importlib.resources import files
from typing import Any

from vibrocap.arguments import is_number
from vibrocap.case.case import RUN_DEFAULTS
from vibrocap.case.sections import CHOICES, CHOICES_LEFT_OUT, described_machine
from vibrocap.physics.dimensions.units import one_way, parameter_keys, state_keys, units_of
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import ParameterInfo, parameter_table
from vibrocap.physics.symbols import STATES

HEAD = """\
# A case: a machine on a contact, moved by a drive. Run it with
#
#     vibrocap simulate {file}
#
"""
PLAIN = "# Every value is its default; what is left out has it too. All are dimensionless.\n"
SI_HEAD = "# A bench of usual size, in SI: defaults at its masses and lengths, to three digits.\n"
SI_AS_IT_STANDS = "# In SI, with every default as it stands, of 1 kg, 1 m and 1 s: no bench.\n"
BENCH = {  # of a bench, what a machine declares as its units
    "pendulum_mass_kg": 0.2,
    "pendulum_length_m": 0.25,
    "inner_mass_kg": 0.1,
    "mass_unit_kg": 0.1,
    "length_unit_m": 0.01,
    "time_unit_s": 0.03,
}
COLUMN = 40  # where the comments begin
RUN = {
    "periods": "drive periods",
    "tolerance": "error per step, relative to the natural size of each state",
    "max_events_per_period": "a run with more of them is stopped",
    "max_steps": "of a run",
}


def new_case(chosen: Mapping[str, str], file: str, si: bool = False) -> str:
    """A case of these kinds of parts with a comment on every line; file: under which name it is run; si: in SI."""
    from vibrocap.physics.closed_loop.actuator import Actuator
    from vibrocap.physics.environment import Environment
    from vibrocap.physics.names import state_names

    own = files("vibrocap.case").joinpath("new_mechanism.toml").read_text("utf-8")
    own = own if chosen["machine"] == "mechanism" else ""
    classes: dict[str, Any] = (
        {"machine": described_machine({"machine": {"kind": "mechanism"}, **tomllib.loads(own)})} if own else {}
    )
    classes |= {name: known()[chosen[name]] for name, (_, known) in CHOICES.items() if name not in classes}
    form = _InSI(classes) if si else _Plain()
    lines = [HEAD.format(file=file) + form.head]
    for section, (key, catalogue) in CHOICES.items():
        part = classes[section]
        others = ", ".join(name for name in catalogue() if name != part.name)
        others = "see `vibrocap list laws` for the others" if section == "friction" else f"or {others}"
        others = "described below, under [mechanism]" if own and section == "machine" else others
        lines += [f"[{section}]", _line(key, part.name, others), *(form.scales() if section == "machine" else ())]
        lines += [*(text for info in parameter_table(part) for text in form.lines(part, info)), ""]
    for part, words in (
        (Environment, "a slope, a fluid or a force from outside; left out, there is none of them."),
        (Actuator, "a lag and limits between drive and machine; left out, there are none."),
    ):
        lines.append(f"# [{part.name}]: {words}")
        texts = (text for info in parameter_table(part) for text in form.lines(part, info))
        lines += [*(text if text.startswith("#") else f"# {text}" for text in texts), ""]
    key, catalogue = CHOICES_LEFT_OUT["controller"]
    lines += ["# [controller]: what makes the command of what it measures; the drive is then its reference."]
    first, *others = catalogue()
    lines += ["# " + _line(key, first, "or " + ", ".join(others)), ""]
    lines += ["[initial]", *(form.state(name) for name in state_names(classes))]
    lines += ["", "[run]", *(_line(name, RUN_DEFAULTS[name], words) for name, words in RUN.items())]
    return "\n".join(lines) + ("\n\n" + own if own else "\n")


def _line(name: str, value: Any, words: str) -> str:
    from vibrocap.case.text import toml_value

    return f"{f'{name} = {toml_value(value)}':<{COLUMN}}# {words}"


class _Plain:
    """How a new case without units says its parameters and states."""

    head = PLAIN

    def scales(self) -> list[str]:
        """What says the units of the machine: nothing."""
        return []

    def lines(self, part: Any, info: ParameterInfo) -> list[str]:
        """A parameter with its default, or where it has none a comment."""
        words = f"{info.symbol}: {info.meaning}"
        return [f"# {info.name}: {words}" if info.default is None else _line(info.name, info.default, words)]

    def state(self, name: str) -> str:
        """A state, from zero."""
        symbol, meaning = STATES.get(name, (name, name))
        return _line(name, 0.0, f"{symbol}: {meaning}")


class _InSI(_Plain):
    """The same of a new case in SI: the defaults at the size of a bench, to three digits."""

    def __init__(self, classes: Mapping[str, Any]):
        record = classes["machine"].si_scales
        table = parameter_table(record)
        self.needed = [info.name for info in table if not isinstance(info.default, (float, type(None)))]
        self.head = SI_HEAD if self.needed else SI_AS_IT_STANDS
        self.given = record(**{name: BENCH[name] for name in self.needed})
        self.units = units_of(classes, self.given)

    def scales(self) -> list[str]:
        """What says the units of the machine."""
        lines = []
        for info in parameter_table(self.given):
            value = getattr(self.given, info.name)
            given = info.name in self.needed
            lines.append(_line(info.name, value, info.meaning) if given else f"# {info.name}: {info.meaning}")
        return lines

    def lines(self, part: Any, info: ParameterInfo) -> list[str]:
        """A parameter with its default in SI."""
        units = self.units.of_part("friction" if Law in part.__mro__ else "")
        key = one_way(parameter_keys(part, units.effort), info.name)
        name = info.name if key is None else key.key
        if info.default is None:
            return [f"# {name}: {info.in_si}"]
        value = info.default
        if info.name == "normal_load" and part.si_load.startswith('"weight"'):
            return [_line("normal_load", "weight", info.in_si)]
        if key is not None and key.has_unit and is_number(value):
            value = float(f"{value * units.per_key(key):.3g}")
        elif key is not None and key.has_unit and isinstance(value, (tuple, list)):
            value = [float(f"{number * units.per_key(key):.3g}") for number in value]
        return [_line(name, value, info.in_si)]

    def state(self, name: str) -> str:
        """A state, from zero."""
        key, (symbol, meaning) = one_way(state_keys(self.units.states), name), STATES.get(name, (name, name))
        return _line(name if key is None else key.key, 0.0, f"{symbol}: {meaning}")
