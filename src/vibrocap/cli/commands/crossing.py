"""`vibrocap crossing`: where a measure of the steady motion of a case takes a value."""

from typing import Any

from vibrocap.arguments import Complaint, Complaints, Refusal, suggestion
from vibrocap.case.case import CaseError
from vibrocap.case.sections import is_kind, kinds_of
from vibrocap.cli import completers
from vibrocap.cli.command import Answer, OfCase, Report, command
from vibrocap.cli.options import JSON, OVER, option
from vibrocap.cli.terminal import said
from vibrocap.cli.texts import pairs, quantity_range, split, value_of
from vibrocap.physics.names import split_path
from vibrocap.quantities.dimensional import in_si


class CrossingRequest(OfCase):
    over: str = OVER
    measure: str = option(
        "a measure that is a number; `vibrocap list measures`",
        "drift",
        sets=("measures",),
        offers=completers.measure_names,
    )
    value: float = option("the value to find, of a case in SI in the unit of the measure", 0.0)
    against: str | None = option(
        "PATH=VALUE or friction.law=NAME, or several with commas between: find the value in the difference from "
        "the case so changed; another law keeps the parameters that both laws have",
        offers=completers.paths_of_case,
    )
    json: bool = JSON
    points: int = option("values of the parameter at which the motion is run first", 200, advanced=True)
    periods: int = option("drive periods in which a motion has to settle", 2000, advanced=True)


@command(
    "steady",
    "vibrocap crossing case.toml --over drive.amplitude=1:3 --points 20",
    doing="Looking for {measure} = {value:g}",
)
def crossing(request: CrossingRequest, report: Report) -> Answer:
    """Where a steady measure takes a value, or two laws agree.

    Each place has a bracket and an error. The report also lists ranges in which the measure keeps the value (symmetric
    motions have zero drift) and jumps across it (from a motion to its mirror-image solution).

    Exit code 3: some motions did not settle, so places may be missing.
    """
    from vibrocap.measures.of_measure import measure_unit
    from vibrocap.orbits.continuation.crossing import crossing as crossings
    from vibrocap.orbits.continuation.crossing_bracket import CrossingKind

    setup = request.setup
    along, low, high = quantity_range(request.over, setup.system)
    unit, scale = measure_unit(request.measure, setup.system)
    result = crossings(
        setup.system,
        request.measure,
        along.plain,
        (low, high),
        value=request.value if scale is None else request.value / scale,
        against=None if request.against is None else _other(setup.system, request.against),
        initial=setup.initial,
        progress=report,
        **request.given("points", "periods"),
    )
    shown = in_si(result, setup.system, over=along.path)
    other = "" if request.against is None else f" less that with {request.against}"
    head = f"{result.measure}{other} = {said(request.value, unit, 6)} over {along.path}"
    what = ""
    if result.unsettled:
        what = f"{len(result.unsettled)} of {len(result.parameters)} motions of the scan did not settle"
    elif any(place.kind is CrossingKind.LOST for place in result.found):
        what = "in a bracket of the scan a motion did not settle"
    advice = f"Places may be missing: {what}. Raise --periods, or narrow the range; such motions may be chaotic."
    text = "\n".join([head, *(f"  {line}" for line in str(shown).splitlines())])
    return Answer(shown, text, incomplete=advice if what else "")


def _other(system: Any, text: str) -> Any:
    """The system with another kind of part, which keeps the parameters that both have, or with other parameters."""
    from vibrocap.studies.plan import variation

    complaints = Complaints()
    wanted = "friction.law=NAME or PATH=VALUE"
    values = {path: value_of(word) for path, word in pairs("against", split([text]), complaints, wanted).items()}
    if complaints:
        raise Refusal(f"--against should be {wanted}, got {text!r}")
    for path, name in values.items():
        if is_kind(path) and (known := kinds_of(split_path(path)[0])).get(str(name)) is None:
            complaints.add(path, f"no {path.replace('.', ' ')} is called {name!r}; {suggestion(name, known)}")
    system, values = variation.with_varied_parts(system, values), variation.plainly(values, system)
    if not complaints:
        complaints += variation.path_complaints(values, [variation.kinds_chosen(system, values)], system.units)
    try:
        if not complaints:
            return variation.varied(system, values)
    except CaseError as error:
        fields = [complaint.field for complaint in error.complaints if isinstance(complaint, Complaint)]
        more = ",".join([text, *(f"{field}=..." for field in fields)])
        complaints += [f"{complaint}; give it too, --against {more}" for complaint in error.complaints]
    except ValueError:
        complaints += variation.refusal(system, values)
    raise Refusal(*(f"--against {complaint}" for complaint in complaints))
