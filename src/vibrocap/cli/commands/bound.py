"""`vibrocap bound`: what no drive can better, and how near the steady motion of a case comes to it."""

from pathlib import Path
from typing import Any

from vibrocap.cli.options import Refusal
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress, said
from vibrocap.io.json_text import json_text
from vibrocap.io.motion_file import read_source


def bound(case: Path, /, *, json: bool = False) -> int:
    """The known bounds of speed and cost of transport, and how near the steady motion of a case comes to them.

    A bound holds whatever drives the machine. Which bounds are known depends on the
    machine, the friction law and the ground; where none is, the reasons are said.

    Exit code 3: the steady motion could not be closed.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.design.bounds import performance_bounds
    from vibrocap.orbits.closing.orbit import orbit

    given = read_source(case)
    try:
        bounds = performance_bounds(given.system)
    except ValueError as error:
        raise Refusal(f"CASE: {error}") from None
    with progress("Looking for the steady motion") as report:
        steady = orbit(given.system, initial=given.initial, progress=report)
    rows = [_record(each, steady) for each in bounds]
    if json:
        print(json_text({"bounds": rows, "orbit": steady.status.value}))
    else:
        page = Page()
        for each, row in zip(bounds, rows, strict=True):
            page.say(each.heading, style="bold")
            shown = [("bound", said(row["bound"], row["unit"])), ("source", row["source"])]
            if row["value"] is not None:
                what = said(row["value"], row["unit"])
                if row["holds"]:
                    what += f", {row['value'] / row['bound']:.6g} of the bound"
                else:
                    what += ", to which the bound does not apply"
                shown.append(("this case", what))
            page.rows(shown, 12)
    if not steady.closes:
        complain(f"The steady motion of the case: {steady.status.value}. {steady.status.advice}")
        return INCOMPLETE
    return OK


def _record(each: Any, steady: Any) -> dict[str, Any]:
    """A bound, and what the steady motion reaches."""
    names = ("measure", "kind", "unit", "holds_for", "source")
    found = {"bound": each.value} | {name: getattr(each, name) for name in names}
    reached = (
        {"value": each.of(steady), "holds": each.holds(steady)} if steady.closes else {"value": None, "holds": None}
    )
    return found | reached
