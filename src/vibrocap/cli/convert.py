"""`vibrocap convert`: a case in the other form, in SI or without units."""

import dataclasses
from pathlib import Path

from vibrocap.arguments import Complaints, suggestion
from vibrocap.case.case import Case, CaseError, case_text
from vibrocap.case.units import DIMENSIONLESS, SI, WORDS
from vibrocap.cli.options import Refusal, pairs, split, writable_file
from vibrocap.cli.terminal import OK, Page
from vibrocap.files import write_text
from vibrocap.io.motion_file import read_source
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.scales import Scales


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
    if refused:
        raise Refusal(*refused)
    text = case_text(_with_scales(setup, known), wanted)
    if out is None:
        print(text, end="")
        return OK
    write_text(out, text)
    Page().say(f"Case: {out}")
    return OK


def _with_scales(case: Case, scales: Scales | None) -> Case:
    """The case with scales that are kept; its results stay without units."""
    system = dataclasses.replace(case.system, units=None)
    return dataclasses.replace(case, system=system, scales=scales)


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
