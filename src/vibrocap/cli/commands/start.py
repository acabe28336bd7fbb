"""`vibrocap new`, `vibrocap examples` and `vibrocap convert`: cases to begin with, and a case in the other form."""

import dataclasses
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vibrocap.arguments import Complaints, suggestion
from vibrocap.case.case import RUN_DEFAULTS, CaseError, case_text
from vibrocap.case.sections import CHOICES
from vibrocap.case.units import DIMENSIONLESS, SI, WORDS
from vibrocap.cli.example_files import examples_folder, shows
from vibrocap.cli.options import Refusal, pairs, split, writable_file, writable_folder
from vibrocap.cli.terminal import OK, Page, table
from vibrocap.files import made_folder, write_text
from vibrocap.io.motion_file import read_source
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.scales import Scales
from vibrocap.physics.units import UNDECLARED, undeclared

HEAD = """\
# A case: a machine on a contact, moved by a drive. Run it with
#
#     vibrocap simulate {file}
#
# Every value is its default; what is left out has it too. All are dimensionless (docs/case-files.md).
"""
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
    out: Path | None = None,
    overwrite: bool = False,
) -> int:
    """A new case: every parameter of its parts with its default, its symbol and what it means.

    Parameters
    ----------
    kind
        of the machine: pendulum-capsule or oscillator
    law
        of friction, as `vibrocap friction list` shows them
    drive
        its waveform: harmonic, square, table and others, see docs/drives.md
    out
        FILE.toml to write instead of printing the case
    overwrite
        write it even if there is such a file
    """
    chosen, complaints = {"machine": kind, "friction": law, "drive": drive}, Complaints()
    options = {"machine": "KIND", "friction": "--law", "drive": "--drive"}
    for part, name in chosen.items():
        known = CHOICES[part][1]()
        if name not in known:
            complaints.add(options[part], f"there is no {name!r}; {suggestion(name, known)}")
    with complaints.collected():
        writable_file("--out", out, (".toml",))
        if out is not None and out.exists() and not overwrite:
            complaints.add("--out", f"{str(out)!r} is there already; name another file, or say --overwrite")
    if complaints:
        raise Refusal(*complaints)
    text = new_case(chosen, "case.toml" if out is None else str(out))
    return _given(text, out, f"Written: {out}\nNext: vibrocap simulate {out}")


def _given(text: str, out: Path | None, said: str) -> int:
    """Write a case into a file and say so, or print it where there is none."""
    if out is None:
        print(text, end="")
    else:
        write_text(out, text)
        Page().say(said)
    return OK


def new_case(chosen: Mapping[str, str], file: str) -> str:
    """A case of these kinds of parts with a comment on every line; file: under which name it is run."""
    from vibrocap.case.text import toml_value
    from vibrocap.physics.actuator import Actuator
    from vibrocap.physics.environment import Environment
    from vibrocap.physics.parameters import parameter_table
    from vibrocap.physics.states import state_names
    from vibrocap.physics.symbols import STATES

    def line(name: str, value: Any, words: str) -> str:
        return f"{f'{name} = {toml_value(value)}':<{COLUMN}}# {words}"

    lines, classes = [HEAD.format(file=file)], {}
    for section, (key, catalogue) in CHOICES.items():
        classes[section] = part = catalogue()[chosen[section]]
        others = ", ".join(name for name in catalogue() if name != part.name)
        others = "see `vibrocap friction list` for the others" if section == "friction" else f"or {others}"
        lines += [f"[{section}]", line(key, part.name, others)]
        for info in parameter_table(part):
            words = f"{info.symbol}: {info.meaning}"
            lines.append(f"# {info.name}: {words}" if info.default is None else line(info.name, info.default, words))
        lines.append("")
    for part, words in (
        (Environment, "a slope, a fluid or a force from outside; left out, there is none of them."),
        (Actuator, "a lag and limits between drive and machine; left out, there are none."),
    ):
        lines.append(f"# [{part.name}]: {words}")
        for info in parameter_table(part):
            meaning, default = f"{info.symbol}: {info.meaning}", info.default
            lines.append(f"# {info.name}: {meaning}" if default is None else f"# {line(info.name, default, meaning)}")
        lines.append("")
    lines.append("[initial]")
    for state in state_names(classes):
        symbol, meaning = STATES.get(state, (state, state))
        lines.append(line(state, 0.0, f"{symbol}: {meaning}"))
    lines += ["", "[run]", *(line(name, RUN_DEFAULTS[name], words) for name, words in RUN.items())]
    return "\n".join(lines) + "\n"


def examples(*names: str, to: Path | None = None) -> int:
    """The example cases that come with vibrocap: what each shows, and a copy of them to work with.

    Without names and --to they are listed. Files that are there already are left as they are.

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
    for name in names or known:
        source = known[name.removesuffix(".toml")]
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
    with refused.collected():
        writable_file("--out", out, [".toml"])
    try:
        setup = read_source(case)
    except CaseError as error:
        raise CaseError([*error.complaints, *refused], error.source) from None
    known = setup.system.units or setup.scales
    wanted = to or (DIMENSIONLESS if setup.system.units is not None else SI)
    record = setup.system.machine.si_scales
    with refused.collected():
        if given:
            known = _scales(record, given)
    if known is None and parameter_table(record) and wanted == SI and not refused:
        infos = (info for info in parameter_table(record) if not isinstance(info.default, float))
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
        if name not in given and not isinstance(info.default, float):
            complaints.add("--scales", f"{name} is missing, the {info.meaning}")
    if not complaints:
        try:
            return record(**values)
        except ValueError:
            wrong = [name for name, value in values.items() if not 0.0 < value < float("inf")]
            complaints += [f"--scales {name}: should be a number above 0, got {given[name]}" for name in wrong]
    raise Refusal(*complaints)
