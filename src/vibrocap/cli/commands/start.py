"""`vibrocap new`, `vibrocap examples` and `vibrocap convert`: cases to begin with, and a case in the other form."""

import dataclasses
import os
import tomllib
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from vibrocap.arguments import Complaints, is_number, suggestion
from vibrocap.case.case import RUN_DEFAULTS, CaseError, case_text
from vibrocap.case.sections import CHOICES, CHOICES_LEFT_OUT, DIMENSIONLESS, SI, WORDS, described_machine
from vibrocap.cli.command_examples import examples_folder, shows, tables_of
from vibrocap.cli.options import Refusal, by_option, pairs, split, writable_file, writable_folder
from vibrocap.cli.terminal import OK, Page, table
from vibrocap.files import made_folder, write_text
from vibrocap.io.motion_file import read_source
from vibrocap.physics.dimensions.scales import Scales
from vibrocap.physics.dimensions.units import UNDECLARED, one_way, parameter_keys, state_keys, undeclared, units_of
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import ParameterError, ParameterInfo, parameter_table
from vibrocap.physics.symbols import STATES

HEAD = """\
# A case: a machine on a contact, moved by a drive. Run it with
#
#     vibrocap simulate {file}
#
"""
PLAIN = "# Every value is its default; what is left out has it too. All are dimensionless (docs/case-files.md).\n"
SI_HEAD = "# A bench of usual size, in SI: defaults at its masses and lengths, to three digits (docs/case-files.md).\n"
SI_AS_IT_STANDS = "# In SI, with every default as it stands, of 1 kg, 1 m and 1 s: no bench (docs/case-files.md).\n"
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


def new(
    kind: str = "pendulum-capsule",
    /,
    *,
    law: str = "exponential",
    drive: str = "harmonic",
    si: bool = False,
    out: Path | None = None,
    overwrite: bool = False,
) -> int:
    """A new case: every parameter of its parts with its default, its symbol and what it means.

    Parameters
    ----------
    kind
        of the machine, such as pendulum-capsule, vibro-impact-capsule or oscillator; "mechanism" for one of your own
    law
        of friction, as `vibrocap friction list` shows them
    drive
        its waveform: harmonic, square, table and others, see docs/drives.md
    si
        a case in SI, of a bench of a usual size
    out
        FILE.toml to write instead of printing the case
    overwrite
        write it even if there is such a file
    """
    chosen, complaints = {"machine": kind, "friction": law, "drive": drive}, Complaints()
    options = {"machine": "KIND", "friction": "--law", "drive": "--drive"}
    for part, name in chosen.items():
        known = CHOICES[part][1]()
        if name not in known and (part, name) != ("machine", "mechanism"):
            complaints.add(options[part], f"there is no {name!r}; {suggestion(name, known)}")
    with complaints.collected():
        writable_file("--out", out, (".toml",))
        if out is not None and out.exists() and not overwrite:
            complaints.add("--out", f"{str(out)!r} is there already; name another file, or say --overwrite")
    if complaints:
        raise Refusal(*complaints)
    text = new_case(chosen, "case.toml" if out is None else str(out), si)
    return _given(text, out, f"Written: {out}\nNext: vibrocap simulate {out}")


def _given(text: str, out: Path | None, said: str) -> int:
    """Write a case into a file and say so, or print it where there is none."""
    if out is None:
        print(text, end="")
    else:
        write_text(out, text)
        Page().say(said)
    return OK


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
        others = "see `vibrocap friction list` for the others" if section == "friction" else f"or {others}"
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
        found = []
        for info in parameter_table(self.given):
            value = getattr(self.given, info.name)
            given = info.name in self.needed
            found.append(_line(info.name, value, info.meaning) if given else f"# {info.name}: {info.meaning}")
        return found

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
            value = [float(f"{each * units.per_key(key):.3g}") for each in value]
        return [_line(name, value, info.in_si)]

    def state(self, name: str) -> str:
        """A state, from zero."""
        key, (symbol, meaning) = one_way(state_keys(self.units.states), name), STATES.get(name, (name, name))
        return _line(name if key is None else key.key, 0.0, f"{symbol}: {meaning}")


def examples(*names: str, to: Path | None = None) -> int:
    """The example cases that come with vibrocap: what each shows, and a copy of them to work with.

    Without names and --to they are listed. Measured tables of a case go along with it. Files that are there already are
    left as they are.

    Parameters
    ----------
    names
        which, as the list shows them [default: all]
    to
        folder for the copies, made if it is not there [default: examples, where names are given]
    """
    known = {path.stem: path for path in sorted(examples_folder().glob("*.toml"))}
    complaints = Complaints()
    for name in names:
        if name.removesuffix(".toml") not in known:
            complaints.add(name, f"there is no such example; {suggestion(name, known)}")
    if to is not None:
        with complaints.collected():
            writable_folder("--to", to)
    if complaints:
        raise Refusal(*complaints)
    page = Page()
    if to is None and not names:
        made = table(None, "example", "what it shows", no_wrap=1)
        for name, path in known.items():
            made.add_row(name, shows(path))
        page.print(made)
        page.say("Next: vibrocap examples --to examples; vibrocap simulate examples/travels-by-stick-slip.toml")
        return OK
    folder = to or Path("examples")
    made_folder(folder)
    chosen = [known[name.removesuffix(".toml")] for name in names or known]
    for source in (each for case in chosen for each in (case, *tables_of(case))):
        target = folder / source.name
        if os.path.lexists(target):
            same = target.is_file() and target.read_bytes() == source.read_bytes()
            page.say(f"{target} is there already" + ("" if same else ", and another; it is left as it is"))
            continue
        write_text(target, source.read_text(encoding="utf-8"))
        page.say(f"Written: {target}")
    return OK


def convert(case: Path, /, *, to: str | None = None, scales: list[str] | None = None, out: Path | None = None) -> int:
    """A case in the other form: in SI, or without units. Comments are not kept.

    A case in SI knows what its units are, and so does the file without units that is
    made of it, in its section [scales]: the way back gives the same numbers. Of any
    other case it has to be said.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    to
        SI or dimensionless [default: the other form than that of the case]
    scales
        what the units of the machine are, KEY=VALUE, where the case does not say it; replaces what it says
    out
        FILE.toml to write [default: print it]
    """
    refused = Complaints()
    given = pairs("scales", split(scales), refused, "KEY=VALUE, such as pendulum_mass_kg=0.2")
    if to is not None and to not in WORDS:
        refused.add("--to", f"should be {' or '.join(WORDS)}, got {to!r}")
    try:
        setup = read_source(case)
    except CaseError as error:
        setup = error
    with refused.collected():
        writable_file("--out", out, [".toml"])
    if isinstance(setup, CaseError):
        raise CaseError([*setup.complaints, *refused], setup.source)
    known = setup.system.units or setup.scales
    wanted = to or (DIMENSIONLESS if setup.system.units is not None else SI)
    record = setup.system.machine.si_scales
    with refused.collected():
        if given:
            known = _scales(record, given)
    if known is None and parameter_table(record) and wanted == SI and not refused:
        infos = (info for info in parameter_table(record) if not isinstance(info.default, (float, type(None))))
        fields = ", ".join(f"{info.name} ({info.meaning})" for info in infos)
        refused.add("--scales", f"is missing; the case does not say what its units are; give {fields}")
    for name, part in setup.system.parts.items() if wanted == SI else ():
        for each in undeclared(type(part)):
            refused.add(f"{name}.{each}", UNDECLARED)
    if refused:
        raise Refusal(*refused)
    plain = dataclasses.replace(setup.system, units=None)  # the scales are kept beside; results stay without units
    text = case_text(dataclasses.replace(setup, system=plain, scales=known), wanted)
    return _given(text, out, f"Case: {out}")


def _scales(record: type, given: dict[str, str]) -> Scales:
    """The scales that an option gives; Refusal with every complaint."""
    known = {info.name: info for info in parameter_table(record)}
    complaints, values = Complaints(), {}
    for name, text in given.items():
        if name not in known:
            complaints.add(f"--scales {name}", f"no such key; {suggestion(name, known)}")
            continue
        try:
            values[name] = float(text)
        except ValueError:
            complaints.add(f"--scales {name}", f"should be a number, got {text!r}")
    for name, info in known.items():
        if name not in given and not isinstance(info.default, (float, type(None))):
            complaints.add("--scales", f"{name} is missing, the {info.meaning}")
    if not complaints:
        try:
            return record(**values)
        except ParameterError as error:
            complaints += by_option(error.complaints, {name: f"--scales {name}" for name in given})
    raise Refusal(*complaints)
