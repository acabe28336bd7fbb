"""`vibrocap new`: a case to begin with, or a case in the other form."""

import dataclasses
import shlex
import tomllib
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

from vibrocap.arguments import Complaints, Refusal, by_option, is_number, suggestion
from vibrocap.case.case import RUN_DEFAULTS, case_text
from vibrocap.case.sections import CHOICES, CHOICES_LEFT_OUT, DIMENSIONLESS, SI, described_machine
from vibrocap.cli import completers
from vibrocap.cli.command import Answer, WithParts, command
from vibrocap.cli.options import file, option
from vibrocap.cli.texts import pairs, split
from vibrocap.files import write_text
from vibrocap.io.motion_file import read_source
from vibrocap.physics.dimensions.scales import FreeScales, Scales
from vibrocap.physics.dimensions.units import UNDECLARED, one_way, parameter_keys, state_keys, undeclared, units_of
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import ConsistentUnits
from vibrocap.physics.parameters import ParameterError, ParameterInfo, parameter_table
from vibrocap.physics.symbols import state_symbols

HEAD = """\
# A case: a machine on a contact, moved by a drive. Run it with
#
#     vibrocap simulate {file}
#
"""
PLAIN = "# A missing key has its default, which is the value here or behind its meaning. All are dimensionless.\n"
SI_HEAD = "# A bench of usual size, in SI, to three digits.\n"
SI_AS_IT_STANDS = "# In SI, with every default as it stands.\n"
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


def new_case(kinds: Mapping[str, str], file: str, si: bool = False, defaults: bool = False) -> str:
    """A case of these kinds of parts with a comment on every line; file: under which name it is run; si: in SI.

    defaults: whether every value is the default of its part, also where a machine has another `first_case`
    """
    from vibrocap.physics.closed_loop.actuator import Actuator
    from vibrocap.physics.environment import Environment
    from vibrocap.physics.names import state_names

    own = files("vibrocap.case").joinpath("new_mechanism.toml").read_text("utf-8")
    own = own if kinds["machine"] == "mechanism" else ""
    classes: dict[str, Any] = (
        {"machine": described_machine({"machine": {"kind": "mechanism"}, **tomllib.loads(own)})} if own else {}
    )
    classes |= {name: known()[kinds[name]] for name, (_, known) in CHOICES.items() if name not in classes}
    first = {} if defaults else classes["machine"].first_case
    form = _InSI(classes) if si else _Plain()
    lines = [HEAD.format(file=file) + form.head]
    for section, (key, catalogue) in CHOICES.items():
        part = classes[section]
        others = ", ".join(name for name in catalogue() if name != part.name)
        others = "see `vibrocap list laws` for the others" if section == "friction" else f"or {others}"
        others = "described below, under [mechanism]" if own and section == "machine" else others
        lines += [f"[{section}]", _line(key, part.name, others), *(form.scales() if section == "machine" else ())]
        for info in parameter_table(part):
            lines.append(form.line(part, info, first.get(f"{section}.{info.name}", info.default)))
        lines.append("")
    for part, words in (
        (Environment, "a slope, a fluid or an external force; without this section there is none."),
        (Actuator, "a lag and limits between drive and machine; left out, there are none."),
    ):
        lines.append(f"# [{part.name}]: {words}")
        texts = (form.line(part, info, info.default) for info in parameter_table(part))
        lines += [*(text if text.startswith("#") else f"# {text}" for text in texts), ""]
    key, catalogue = CHOICES_LEFT_OUT["controller"]
    lines += ["# [controller]: computes the command from its measurement; the drive is then its reference."]
    first, *others = catalogue()
    lines += ["# " + _line(key, first, "or " + ", ".join(others)), ""]
    symbols = state_symbols(classes)
    lines += ["[initial]", *(form.state(name, ": ".join(symbols[name])) for name in state_names(classes))]
    lines += ["", "[run]", *(_line(name, RUN_DEFAULTS[name], words) for name, words in RUN.items())]
    return "\n".join(lines) + ("\n\n" + own if own else "\n")


def _line(name: str, value: Any, words: str) -> str:
    from vibrocap.case.text import toml_value

    return f"{f'{name} = {toml_value(value)}':<{COLUMN}}# {words}"


class _Plain:
    """How a new case without units says its parameters and states."""

    head = PLAIN

    def scales(self) -> list[str]:
        return []

    def line(self, part: Any, info: ParameterInfo, value: Any) -> str:
        """A parameter with a value, or where it has none a comment."""
        words = f"{info.symbol}: {info.meaning}"
        if value != info.default:
            words += f"; default {'none' if info.default is None else info.default}"
        return f"# {info.name}: {words}" if value is None else _line(info.name, value, words)

    def state(self, name: str, words: str) -> str:
        return _line(name, 0.0, words)


class _InSI(_Plain):
    """The same of a new case in SI: the defaults at the size of a bench, to three digits."""

    def __init__(self, classes: Mapping[str, Any]):
        record = classes["machine"].si_scales
        table = parameter_table(record)
        self.needed = [info.name for info in table if not isinstance(info.default, (float, type(None)))]
        self.given = bench = record(**{name: BENCH[name] for name in self.needed})
        if issubclass(classes["machine"], ConsistentUnits):
            bench = FreeScales(**{info.name: BENCH[info.name] for info in parameter_table(FreeScales)})
        self.head = SI_HEAD if parameter_table(bench) else SI_AS_IT_STANDS
        self.units = units_of(classes, bench)

    def scales(self) -> list[str]:
        lines = []
        for info in parameter_table(self.given):
            value = getattr(self.given, info.name)
            required = info.name in self.needed
            lines.append(_line(info.name, value, info.meaning) if required else f"# {info.name}: {info.meaning}")
        return lines

    def line(self, part: Any, info: ParameterInfo, value: Any) -> str:
        """A parameter with a value in SI."""
        units = self.units.of_part("friction" if Law in part.__mro__ else "")
        key = one_way(parameter_keys(part, units.effort), info.name)
        name = info.name if key is None else key.key
        if value is None:
            return f"# {name}: {info.in_si}"
        if info.name == "normal_load" and part.si_load.startswith('"weight"'):
            return _line("normal_load", "weight", info.in_si)
        if key is not None and key.has_unit and is_number(value):
            value = float(f"{value * units.per_key(key):.3g}")
        elif key is not None and key.has_unit and isinstance(value, (tuple, list)):
            value = [float(f"{number * units.per_key(key):.3g}") for number in value]
        return _line(name, value, info.in_si)

    def state(self, name: str, words: str) -> str:
        key = one_way(state_keys(self.units.states), name)
        return _line(name if key is None else key.key, 0.0, words)


class NewRequest(WithParts):
    kind: str = option(
        'of the machine, such as pendulum-capsule or oscillator; "mechanism" for one of your own',
        "pendulum-capsule",
        place=True,
        offers=completers.machine_names,
    )
    law: str = option("of friction, see `vibrocap list laws`", "exponential", offers=completers.law_names)
    drive: str = option("its waveform, see `vibrocap list drives`", "harmonic", offers=completers.drive_names)
    si: bool = option("a case in SI, of a bench of a usual size", False)
    defaults: bool = option("with the defaults of the parts only", False, advanced=True)
    from_: Path | None = option(
        "a case file (.toml) or exported motion to write in the other form, SI or without units"
    )
    out: Path | None = file("FILE.toml to write [default: print it]", ".toml")
    overwrite: bool = option("write it even if there is such a file", False)
    to: Literal["SI", "dimensionless"] | None = option(
        "the form of --from [default: the other form than that of the case]", needs="from_", advanced=True
    )
    scales: list[str] | None = option(
        "KEY=VALUE, the units of the machine of --from, where the case does not give them; replaces its own",
        needs="from_",
        advanced=True,
    )

    @property
    def chosen(self) -> dict[str, str]:
        """The names of machine, friction law and drive."""
        return {"machine": self.kind, "friction": self.law, "drive": self.drive}

    def refuse(self) -> None:
        """A case that is converted is read first, so that it is not replaced."""
        if self.from_ is not None:
            read_source(self.from_)
        super().refuse()

    def plan(self, refused: Complaints) -> None:
        """Known kinds of parts, and a file that does not exist."""
        options = {"machine": "KIND", "friction": "--law", "drive": "--drive"}
        for part, name in self.chosen.items():
            known = CHOICES[part][1]()
            if name not in known and (part, name) != ("machine", "mechanism"):
                refused.add(options[part], f"there is no {name!r}; {suggestion(name, known)}")
        if self.out is not None and self.out.exists() and not (self.overwrite or self.from_):
            refused.add("--out", f"{str(self.out)!r} exists; name another file, or add --overwrite")


@command(
    "start",
    "vibrocap new --out case.toml",
    "vibrocap new --si --out bench.toml",
    "vibrocap new oscillator --law dahl --drive ramp",
    "vibrocap new --from bench.toml --out bench-without-units.toml",
    "vibrocap new --from examples/travels-by-stick-slip.toml --scales pendulum_mass_kg=0.2,pendulum_length_m=0.25",
)
def new(request: NewRequest) -> Answer:
    """A new case, or a case in SI or without units.

    A new case lists every parameter of its parts with symbol and meaning. Its values are defaults, but of machines that
    show little with them (`default ...`). With --from, the command rewrites a
    case in the other form: in SI, or without units; its comments are not kept. A case in SI knows its units, and so
    does the file without units that is made of it, in its section [scales]: the way back gives the same numbers. Of any
    other case --scales gives them.
    """
    converted = request.from_ is not None
    text = (
        _converted(request)
        if converted
        else new_case(request.chosen, str(request.out or "case.toml"), request.si, request.defaults)
    )
    if request.out is None:
        return Answer(text=text.removesuffix("\n"))
    write_text(request.out, text)
    next_ = "" if converted else f"\nNext: vibrocap simulate {shlex.quote(str(request.out))}"
    return Answer(text=f"Written: {request.out}{next_}")


def _converted(request: NewRequest) -> str:
    refused = Complaints()
    assert request.from_ is not None
    entries = pairs("scales", split(request.scales), refused, "KEY=VALUE, such as pendulum_mass_kg=0.2")
    setup = read_source(request.from_)
    known = setup.system.units or setup.scales
    wanted = request.to or (DIMENSIONLESS if setup.system.units is not None else SI)
    record = setup.system.machine.si_scales
    with refused.collected():
        if entries:
            known = _scales(record, entries)
    if known is None and parameter_table(record) and wanted == SI and not refused:
        infos = (info for info in parameter_table(record) if not isinstance(info.default, (float, type(None))))
        fields = ", ".join(f"{info.name} ({info.meaning})" for info in infos)
        refused.add("--scales", f"is missing; the case does not give its units; add {fields}")
    for name, part in setup.system.parts.items() if wanted == SI else ():
        for parameter in undeclared(type(part)):
            refused.add(f"{name}.{parameter}", UNDECLARED)
    if refused:
        raise Refusal(*refused)
    plain = dataclasses.replace(setup.system, units=None)  # the scales are kept beside; results stay without units
    return case_text(dataclasses.replace(setup, system=plain, scales=known), wanted)


def _scales(record: type, numbers: dict[str, str]) -> Scales:
    """The scales that an option gives; Refusal with every complaint."""
    known = {info.name: info for info in parameter_table(record)}
    complaints, values = Complaints(), {}
    for name, text in numbers.items():
        if name not in known:
            complaints.add(f"--scales {name}", f"no such key; {suggestion(name, known)}")
            continue
        try:
            values[name] = float(text)
        except ValueError:
            complaints.add(f"--scales {name}", f"should be a number, got {text!r}")
    for name, info in known.items():
        if name not in numbers and not isinstance(info.default, (float, type(None))):
            complaints.add("--scales", f"{name} is missing, the {info.meaning}")
    if not complaints:
        try:
            return record(**values)
        except ParameterError as error:
            complaints += by_option(error.complaints, {name: f"--scales {name}" for name in numbers})
    raise Refusal(*complaints)
