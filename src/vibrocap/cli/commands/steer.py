"""`vibrocap steer`: a schedule of a case's drive that brings the machine to a place and holds it there."""

import math
import re
from pathlib import Path
from typing import Any

from vibrocap.arguments import Complaints
from vibrocap.cli.options import Refusal, pairs, refusing, writable_folder, writable_picture
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress, table
from vibrocap.files import made_folder, write_table, write_text
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.dimensional import in_si
from vibrocap.quantities.json_text import json_text
from vibrocap.records.reading.units import unit_named


def steer(
    case: Path,
    /,
    *,
    to: str,
    tolerance: str,
    uncertain: list[str] | None = None,
    within: str | None = None,
    least: str = "time",
    hold: int = 10,
    samples: int = 16,
    levels: int = 16,
    out: Path | None = None,
    plot: Path | None = None,
    json: bool = False,
) -> int:
    """A schedule of the drive that brings the machine to a place and holds it there.

    The schedule is the best of a stated family: one burst of the drive or two, each by
    a factor from -1 to 1, begun anew and followed by a pause in which the contact
    sticks. It is checked by exact runs, in every sample of what is uncertain.

    Exit code 3: no schedule of the family arrives in every sample; what is attainable
    is said.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    to
        the place to go to, such as 5.0, or 0.05m of a case in SI
    tolerance
        how far from there is near enough, such as 0.01, or 1mm of a case in SI
    uncertain
        what is not known exactly, as in `vibrocap robust`: PATH=LOW:HIGH, PATH=factor:LOW:HIGH, friction=fit:FILE
    within
        the time that the schedule may take until its last pause ends, such as 60, or 20s of a case in SI
    least
        what is made small: time, or work of the drive
    hold
        drive periods of the last pause that are there to hold it
    samples
        of what is uncertain, that the search sees; four times as many others check what it found
    levels
        factors of the drive, up to 1
    out
        a folder for steering.json, schedule.csv and steered.toml, a case that runs the schedule
    plot
        FILE.png, .svg or .pdf: position over time with the target and the schedule, and the samples
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.design.steering.steer import steer as steered

    given = read_source(case)
    complaints = Complaints()
    unsure = dict(pairs("uncertain", uncertain, complaints, "PATH=LOW:HIGH, such as machine.damping=0.9:1.1"))
    numbers: dict[str, Any] = {
        option: None if text is None else _number(option, text, dimension, given.system, complaints)
        for option, text, dimension in (
            ("to", to, "length"),
            ("tolerance", tolerance, "length"),
            ("within", within, "time"),
        )
    }
    if complaints:
        raise Refusal(*complaints)
    if out is not None:
        writable_folder("--out", out, "steering.json", "schedule.csv", "steered.toml")
    writable_picture("--plot", plot)
    arguments = ("tolerance", "within", "least", "hold", "samples", "levels")
    with progress("Looking for a schedule") as report, refusing(*arguments, target="--to", system="CASE"):
        found = steered(
            given,
            numbers["to"],
            tolerance=numbers["tolerance"],
            uncertain=unsure or None,
            within=numbers["within"],
            least=least,
            hold=hold,
            samples=samples,
            levels=levels,
            progress=report,
        )
    shown = in_si(found)
    segments = shown.table()
    if out is not None:
        write_text(made_folder(out) / "steering.json", json_text(shown) + "\n")
        write_table(out / "schedule.csv", segments[0], (row.values() for row in segments))
        found.save(out / "steered.toml")
    if plot is not None:
        from vibrocap.plotting.look.finishing import save
        from vibrocap.plotting.steering import steering_figure

        save(steering_figure(found), plot)
    if json:
        print(json_text(shown))
    else:
        _print(shown, segments, out, plot)
    if found.status.value != "arrives":
        worst = shown.said("worst_error", 6)
        complain(f"The schedule: {found.status.value}. The worst error is {worst}. {found.status.advice}")
        return INCOMPLETE
    return OK


def _number(option: str, text: str, dimension: str, system: Any, complaints: Complaints) -> float | None:
    """The number of an option without units; of a system that knows its scales it is given in SI, or with its unit."""
    unit, example = {"length": ("m", "0.05m or 50mm"), "time": ("s", "20s")}[dimension]
    match = re.fullmatch(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(.*)", text)
    try:
        value = float(match[1]) if match else math.nan
    except ValueError:
        value = math.nan
    named = unit_named(match[2]) if match and match[2] else None
    if match is None or not math.isfinite(value):
        what = "a number" if system.units is None else f"a {dimension}, such as {example}"
    elif system.units is None:
        if not match[2]:
            return value
        what = "a number, as the case is without units"
    else:
        if not match[2] or (named is not None and named.dimension == dimension):
            return value * (1.0 if named is None else named.factor) / system.si.factor_of(unit)
        what = f"a {dimension}, such as {example}"
    complaints.add(f"--{option}", f"should be {what}, got {text!r}")
    return None


def _print(found: Any, segments: list[dict[str, Any]], out: Path | None, plot: Path | None) -> None:
    """The schedule as a table, and what is to be said of it."""
    page = Page()
    page.say(found.heading.capitalize(), style="bold")
    unit, second = found.unit_of("position"), found.unit_of("duration")
    made = table(None, "segment", "value", "value", "value", "value", no_wrap=5)
    heads = ("", "factor", "periods", f"ends{_of(second)}", f"position{_of(unit)}")
    for column, head in zip(made.columns, heads, strict=True):
        column.header = head
    for each in segments:
        numbers = (each["factor"], each["periods"], each["end"], each["end_position"])
        made.add_row(each["kind"], *(f"{number:.6g}" for number in numbers))
    page.print(made)
    page.rows([(name, text) for name, text in found.facts.items() if name != "schedule"], 12)
    if out is not None:
        page.rows([("case", str(out / "steered.toml")), ("table", str(out / "schedule.csv"))], 12)
    if plot is not None:
        page.rows([("picture", str(plot))], 12)


def _of(unit: str) -> str:
    return "" if unit == "1" else f" [{unit}]"
