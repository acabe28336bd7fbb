"""`vibrocap crossing`: where a measure of the steady motion of a case takes a value."""

from pathlib import Path
from typing import Any

from vibrocap.arguments import Complaint, Complaints, suggestion
from vibrocap.case.case import CaseError
from vibrocap.case.sections import is_kind, kinds_of
from vibrocap.cli.options import Refusal, pairs, quantity_range, refusing, split, value_of
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress, said
from vibrocap.io.motion_file import read_source
from vibrocap.physics.names import split_path
from vibrocap.quantities.dimensional import in_si
from vibrocap.quantities.json_text import json_text


def crossing(
    case: Path,
    /,
    *,
    over: str,
    measure: str = "drift",
    value: float = 0.0,
    against: str | None = None,
    points: int = 200,
    periods: int = 2000,
    json: bool = False,
) -> int:
    """Where a steady measure takes a value, or agrees with that of another law, over a parameter.

    Each place is given with a bracket and an error. Where the measure has the
    value over a whole range (symmetric motions have zero drift) or jumps across it
    (from a motion to its mirror twin), this is said instead.

    Exit code 3: some motions did not settle, so places may be missing.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    over
        PATH=LEAST:LARGEST, such as machine.mass_ratio=0.2:8.1, or drive.frequency_Hz=0.5:2 of a case in SI
    measure
        a measure that is a number; `vibrocap measures` lists them
    value
        the value to look for, of a case in SI in the unit of the measure
    against
        PATH=VALUE or friction.law=NAME, or several with commas between: compare with the case so changed, where a law
        keeps the parameters that both laws have, and look for the difference instead
    points
        values of the parameter at which the motion is run first
    periods
        drive periods that a motion has to settle
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.measures.of_measure import measure_unit
    from vibrocap.orbits.crossings.crossing import crossing as crossings
    from vibrocap.orbits.crossings.crossing_bracket import CrossingKind

    given = read_source(case)
    along, low, high = quantity_range(over, given.system)
    unit, scale = measure_unit(measure, given.system)
    other = None if against is None else _other(given.system, against)
    names = ("measure", "value", "against", "points", "periods", "over")
    options = {"between": "--over", "measures": "--measure"}
    with progress(f"Looking for {measure} = {said(value, unit)}") as report, refusing(*names, **options):
        found = crossings(
            given.system,
            measure,
            along.plain,
            (low, high),
            value=value if scale is None else value / scale,
            against=other,
            initial=given.initial,
            points=points,
            periods=periods,
            progress=report,
        )
    shown = in_si(found, given.system, over=along.path)
    if json:
        print(json_text(shown))
    else:
        page = Page()
        wanted = f"{found.measure} = {said(value, unit, 6)}"
        if against is not None:
            wanted = f"{found.measure} less that with {against} = {said(value, unit, 6)}"
        page.say(f"{wanted} over {along.path}", style="bold")
        for line in str(shown).splitlines():
            page.say(f"  {line}")
    lost = [each for each in found.found if each.kind is CrossingKind.LOST]
    if found.unsettled or lost:
        many = f"{len(found.unsettled)} of {len(found.parameters)} motions of the scan did not settle"
        what = many if found.unsettled else "in a bracket of the scan a motion did not settle"
        complain(f"Places may be missing: {what}. Raise --periods, or narrow the range; such motions may be chaotic.")
        return INCOMPLETE
    return OK


def _other(system: Any, text: str) -> Any:
    """The system with another kind of part, which keeps the parameters that both have, or with other parameters."""
    from vibrocap.studies.plan.variation import (
        kinds_chosen,
        path_complaints,
        plainly,
        refusal,
        varied,
        with_varied_parts,
    )

    found = Complaints()
    wanted = "friction.law=NAME or PATH=VALUE"
    values = {path: value_of(word) for path, word in pairs("against", split([text]), found, wanted).items()}
    if found:
        raise Refusal(f"--against should be {wanted}, got {text!r}")
    for path, name in values.items():
        if is_kind(path) and (known := kinds_of(split_path(path)[0])).get(str(name)) is None:
            found.add(path, f"no {path.replace('.', ' ')} is called {name!r}; {suggestion(name, known)}")
    system, values = with_varied_parts(system, values), plainly(values, system)
    if not found:
        found += path_complaints(values, [kinds_chosen(system, values)], system.units)
    try:
        if not found:
            return varied(system, values)
    except CaseError as error:
        fields = [each.field for each in error.complaints if isinstance(each, Complaint)]
        more = ",".join([text, *(f"{field}=..." for field in fields)])
        found += [f"{each}; give it too, --against {more}" for each in error.complaints]
    except ValueError:
        found += refusal(system, values)
    raise Refusal(*(f"--against {each}" for each in found))
