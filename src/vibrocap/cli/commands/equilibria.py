"""`vibrocap equilibria`: steady sliding and rest of a case that nothing drives in time, and their Hopf points."""

import dataclasses
import math
from pathlib import Path
from typing import Annotated, Any

from vibrocap.arguments import check_whole
from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.completers import paths_of_case
from vibrocap.cli.options import Json, Option, picture
from vibrocap.cli.refusal import Refusal
from vibrocap.cli.terminal import Page, said
from vibrocap.cli.texts import quantity_range
from vibrocap.io.json_text import in_both
from vibrocap.quantities.dimensional import in_si, units_of


@dataclasses.dataclass(frozen=True, kw_only=True)
class EquilibriaRequest(OfCase, Drawn):
    """The options of `vibrocap equilibria`."""

    over: Annotated[
        str | None,
        Option(
            "PATH=LEAST:LARGEST, such as machine.belt_speed=0.5:2, to follow a state of steady sliding",
            sets=("between",),
            offers=paths_of_case,
        ),
    ] = None
    start: Annotated[
        int | None, Option("the state of steady sliding to follow, by its number without --over", needs="over")
    ] = None
    plot: Annotated[Path | None, picture("the real parts of the eigenvalues over the parameter", needs="over")] = None
    json: Json = False
    points: Annotated[int, Option("points of a branch in each direction, at most", advanced=True)] = 2000


@command(
    "steady",
    "vibrocap equilibria examples/slides-or-sticks-by-its-start.toml",
    "vibrocap equilibria examples/slides-or-sticks-by-its-start.toml --over machine.belt_speed=0.5:2 --plot hopf.png",
    doing="Looking for equilibria",
)
def equilibria(request: EquilibriaRequest, report: Report) -> Answer:
    """Steady sliding and rest without a periodic drive.

    All states of the friction law count. With --over, one state of steady sliding is followed over a parameter, and its
    folds and Hopf points are located.

    Exit code 3: a branch continues but could not be followed.
    """
    from vibrocap.orbits.equilibria.equilibrium import equilibria as equilibria_of

    check_whole("points", request.points, 10)
    system = request.setup.system
    if request.over is not None:
        return _followed(system, request)
    found = equilibria_of(system)
    record: dict[str, Any] = {"equilibria": [equilibrium_record(each) for each in found]}
    if (shown := in_si(found)) is not found:
        seen = {"equilibria": [equilibrium_record(each) for each in shown]}
        record = in_both(seen, {"equilibria": _units(shown[0]) if len(found) else {}}, record)
    return Answer(record, lambda page: _print_equilibria(page, record, str(request.case)))


def _followed(system: Any, request: EquilibriaRequest) -> Answer:
    """The branch of one state of steady sliding."""
    from vibrocap.orbits.equilibria.equilibrium import equilibria as equilibria_of
    from vibrocap.orbits.equilibria.equilibrium_branch import equilibrium_branch

    along, low, high = quantity_range(request.over or "", system)
    begun = None
    if request.start is not None:
        states = equilibria_of(system).found
        if not 0 <= request.start < len(states):
            raise Refusal(f"--start: should be the number of one of the {len(states)} equilibria, got {request.start}")
        begun = states[request.start]
    found = equilibrium_branch(system, along.plain, (low, high), start=begun, points=request.points)
    record, shown = _branch_record(found), in_si(found, over=along.path)
    if shown is not found:
        states = {name: shown.unit_of(name) for name in system.state_names}
        units = {"state": states} | _rates(shown) | units_of(shown, "between", "parameter")
        units["special_points"] = _units(shown.special_points[0]) if found.special_points else {}
        record = in_both(_branch_record(shown), units, record)

    def figure() -> Any:
        from vibrocap.plotting.steady.equilibria import equilibrium_figure

        return equilibrium_figure(found)

    early = [f"The branch was not followed to its end ({end.value}). {end.advice}" for end in found.ends if end.early]
    unit = shown.unit_of("over")
    return Answer(record, lambda page: _print_branch(page, record, unit), figure, incomplete="\n".join(early))


def _units(found: Any) -> dict[str, Any]:
    """The units of the record of an equilibrium or a special point in SI, in its form."""
    names = ("state", "least", "most", "travel", "friction", "frequency", "parameter", "error")
    return units_of(found, *(name for name in names if hasattr(found, name))) | _rates(found)


def _rates(found: Any) -> dict[str, Any]:
    """The units of eigenvalues in SI, where there are any."""
    rate = found.unit_of("eigenvalues") if hasattr(found, "eigenvalues") else ""
    return {"eigenvalues": {"real": rate, "imaginary": rate}} if rate else {}


def _branch_record(found: Any) -> dict[str, Any]:
    """What is known of a branch of equilibria, by name."""
    return {
        "over": found.over,
        "between": list(found.between),
        "parameter": found.parameter.tolist(),
        "state": {name: found.states[:, i].tolist() for i, name in enumerate(found.system.state_names)},
        "eigenvalues": [[_complex(value) for value in values] for values in found.eigenvalues],
        "stable": found.stable.tolist(),
        "special_points": [
            {
                "kind": each.kind.value,
                "parameter": each.parameter,
                "error": each.error,
                "frequency": each.frequency,
                "criticality": each.criticality,
                "state": each.state,
                "stability": each.stability,
            }
            for each in found.special_points
        ],
        "ends": [each.value for each in found.ends],
        "advice": [each.advice for each in found.ends],
    }


def equilibrium_record(found: Any) -> dict[str, Any]:
    """What is known of an equilibrium, by name; None where a set has no end."""
    return {
        "kind": found.kind,
        "stable": found.stable,
        "stability": found.stability,
        "dimension": found.dimension,
        "sides": list(found.sides),
        "state": found.state,
        "least": {name: value if math.isfinite(value) else None for name, value in found.least.items()},
        "most": {name: value if math.isfinite(value) else None for name, value in found.most.items()},
        "travel": found.travel,
        "friction": list(found.friction),
        "frequency": found.frequency,
        "eigenvalues": [_complex(value) for value in found.eigenvalues],
    }


def _complex(value: complex) -> dict[str, float]:
    return {"real": float(value.real), "imaginary": float(value.imag)}


def _print_equilibria(page: Page, record: dict[str, Any], title: str) -> None:
    """The list of equilibria."""
    units = record.get("units", {}).get("equilibria", {})
    found = record["equilibria"]
    page.say(f"{len(found)} equilibri{'um' if len(found) == 1 else 'a'} of {title}", style="bold")
    for i, each in enumerate(found):
        sort = f"set of {each['kind']}, dimension {each['dimension']}" if each["dimension"] else each["kind"]
        page.say(f"[{i}] {sort}, {each['stability']}")
        own = units.get("state", {})
        rows = [(name, _span(each, name, own.get(name, ""))) for name in each["state"]]
        if each["travel"]:
            rows.append(("travel", said(each["travel"], units.get("travel", ""))))
        rate = units.get("frequency", "")
        rows.append(("eigenvalues", ", ".join(_shown(value, rate) for value in each["eigenvalues"])))
        page.rows(rows, 20)


def _span(each: dict[str, Any], name: str, unit: str) -> str:
    """A state, or how far it reaches over a set."""
    least, most = each["least"][name], each["most"][name]
    if least == most is not None:
        return said(each["state"][name], unit)
    low, high = ("any" if end is None else said(end, unit) for end in (least, most))
    return f"{low} to {high}" if low != high else low


def _shown(value: dict[str, float], unit: str) -> str:
    """An eigenvalue."""
    real, imaginary = value["real"], value["imaginary"]
    turns = f" {'-' if imaginary < 0 else '+'} {abs(imaginary):.6g}i" if imaginary else ""
    return f"{real:.6g}{turns}{' ' + unit if unit else ''}"


def _print_branch(page: Page, record: dict[str, Any], unit: str) -> None:
    """Special points and ends of a branch."""
    values = record["parameter"]
    page.say(f"Branch of steady sliding over {record['over']}, {len(values)} points", style="bold")
    shown, rate = "" if unit == "1" else unit, "rad/s" if "units" in record else ""
    for each in record["special_points"]:
        place = f"{said(each['parameter'], shown, 12)} (error {each['error']:.0e})"
        turns = "" if each["frequency"] is None else f"omega {said(each['frequency'], rate)}"
        kept = "" if each["stability"] == "kept" else f"stability {each['stability']}"
        remarks = "; ".join(filter(None, (turns, each["criticality"], kept)))
        page.say(f"  {each['kind']:<14}{place}  {remarks}")
    for where, value, end in (("begins", values[0], 0), ("ends", values[-1], 1)):
        page.say(f"  {where} at {said(value, shown)}: {record['ends'][end]}")
    stable = sum(record["stable"]) / len(values)
    page.say(f"  {stable:.0%} of the points are stable".replace("%", " %"))
