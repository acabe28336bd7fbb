"""`vibrocap bound`: what no drive can better, and how near the steady motion of a case comes to it."""

import dataclasses
from pathlib import Path
from typing import Any

from vibrocap.cli.options import Refusal
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.declared import without_unit
from vibrocap.quantities.dimensional import in_si, view
from vibrocap.quantities.json_text import json_text


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
    rows = [_reached(each, steady, given.system) for each in bounds]
    if json:
        print(json_text({"bounds": rows, "orbit": steady.status.value}))
    else:
        page = Page()
        for each, row in zip(bounds, rows, strict=True):
            page.say(each.heading, style="bold")
            shown = [("bound", f"{row['value']:.10g}"), ("source", each.source)]
            if (reached := row["reached"]) is not None:
                what = ", to which the bound does not apply"
                if row["holds"]:
                    what = f", {without_unit(reached) / each.value:.6g} of the bound"
                shown.append(("this case", f"{reached:.10g}{what}"))
            page.rows(shown, 12)
    if not steady.closes:
        complain(f"The steady motion of the case: {steady.status.value}. {steady.status.advice}")
        return INCOMPLETE
    return OK


def _reached(bound: Any, steady: Any, system: Any) -> dict[str, Any]:
    """A bound, what the steady motion reaches, and whether it is one for which the bound holds."""
    known = {"reached": None, "holds": None}
    if steady.closes:
        same = dataclasses.replace(bound, value=bound.of(steady))
        known = {"reached": view(in_si(same, system))["value"], "holds": bound.holds(steady)}
    return view(in_si(bound, system)) | known
