"""`vibrocap equilibria`: steady sliding and rest of a case that nothing drives in time, and their Hopf points."""

<<<<<<< HEAD
=======
import dataclasses
import math
>>>>>>> main
from pathlib import Path
from typing import Annotated, Any

<<<<<<< HEAD
from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.cli.options import Refusal, quantity_range, refusing, writable_picture
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress
from vibrocap.io.motion_file import read_source
=======
from vibrocap.arguments import check_whole
from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.completers import paths_of_case
from vibrocap.cli.options import Json, Option, picture
from vibrocap.cli.refusal import Refusal
from vibrocap.cli.terminal import Page
from vibrocap.cli.texts import quantity_range
from vibrocap.quantities.declared import WithUnit, element, without_unit
>>>>>>> main
from vibrocap.quantities.dimensional import in_si, view


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

<<<<<<< HEAD
    given = read_source(case)
    if over is None:
        for option, value in (("--start", start), ("--plot", plot)):
            if value is not None:
                raise Refusal(f"{option}: should be left out without --over, which says what to follow")
        with refusing("points"):
            check_whole("points", points, 10)
            found = _refused_by_drive(equilibria_of, given.system)
        shown = in_si(found)
        if json:
            print(json_text({"equilibria": view(shown)["found"]}))
        else:
            Page().say(f"{case}: {shown}")
        return OK
    return _followed(given.system, over, start, points, plot, json)
=======
    check_whole("points", request.points, 10)
    system = request.setup.system
    if request.over is not None:
        return _followed(system, request)
    found = equilibria_of(system)
    record = {"equilibria": view(in_si(found))["found"]}
    return Answer(record, lambda page: _print_equilibria(page, record, str(request.case)))
>>>>>>> main


def _followed(system: Any, request: EquilibriaRequest) -> Answer:
    """The branch of one state of steady sliding."""
    from vibrocap.orbits.equilibria.equilibrium import equilibria as equilibria_of
    from vibrocap.orbits.equilibria.equilibrium_branch import equilibrium_branch

    along, low, high = quantity_range(request.over or "", system)
    begun = None
<<<<<<< HEAD
    if start is not None:
        states = _refused_by_drive(equilibria_of, system).found
        if not 0 <= start < len(states):
            raise Refusal(f"--start: should be the number of one of the {len(states)} equilibria, got {start}")
        begun = states[start]
    with progress(f"Following steady sliding over {along.path}"), refusing("points", over="--over", between="--over"):
        found = _refused_by_drive(equilibrium_branch, system, along.plain, (low, high), start=begun, points=points)
    shown = in_si(found, over=along.path)
    if json:
        print(json_text(shown))
    else:
        Page().say(str(shown))
    if plot is not None:
        from vibrocap.plotting.look.finishing import save
        from vibrocap.plotting.steady.equilibria import equilibrium_figure

        save(equilibrium_figure(found), plot)
        if not json:
            Page().say(f"picture    {plot}")
    early = [end for end in found.ends if end.early]
    for end in early:
        complain(f"The branch was not followed to its end ({end.value}). {end.advice}")
    return INCOMPLETE if early else OK
=======
    if request.start is not None:
        states = equilibria_of(system).found
        if not 0 <= request.start < len(states):
            raise Refusal(f"--start: should be the number of one of the {len(states)} equilibria, got {request.start}")
        begun = states[request.start]
    found = equilibrium_branch(system, along.plain, (low, high), start=begun, points=request.points)
    record = view(in_si(found, over=along.path))

    def figure() -> Any:
        from vibrocap.plotting.steady.equilibria import equilibrium_figure

        return equilibrium_figure(found)

    early = [f"The branch was not followed to its end ({end.value}). {end.advice}" for end in found.ends if end.early]
    return Answer(record, lambda page: _print_branch(page, record), figure, incomplete="\n".join(early))


def _print_equilibria(page: Page, record: dict[str, Any], title: str) -> None:
    """The list of equilibria."""
    found = record["equilibria"]
    page.say(f"{len(found)} equilibri{'um' if len(found) == 1 else 'a'} of {title}", style="bold")
    for i, each in enumerate(found):
        sort = f"set of {each['kind']}, dimension {each['dimension']}" if each["dimension"] else each["kind"]
        page.say(f"[{i}] {sort}, {each['stability']}")
        rows = [(name, _span(each["least"][name], each["most"][name], state)) for name, state in each["state"].items()]
        if without_unit(each["travel"]):
            rows.append(("travel", f"{each['travel']:.10g}"))
        rate = f" {each['eigenvalues'].unit}" if isinstance(each["eigenvalues"], WithUnit) else ""
        rows.append(("eigenvalues", ", ".join(_shown(value, rate) for value in without_unit(each["eigenvalues"]))))
        page.rows(rows, 20)


def _span(least: Any, most: Any, state: Any) -> str:
    """A state, or how far it reaches over a set."""
    if least == most and math.isfinite(without_unit(least)):
        return f"{state:.10g}"
    low, high = (f"{end:.10g}" if math.isfinite(without_unit(end)) else "any" for end in (least, most))
    return f"{low} to {high}" if low != high else low


def _shown(value: complex, unit: str) -> str:
    """An eigenvalue."""
    turns = f" {'-' if value.imag < 0 else '+'} {abs(value.imag):.6g}i" if value.imag else ""
    return f"{value.real:.6g}{turns}{unit}"


def _print_branch(page: Page, record: dict[str, Any]) -> None:
    """Special points and ends of a branch."""
    stable = record["stable"]
    page.say(f"Branch of steady sliding over {record['over']}, {len(stable)} points", style="bold")
    for each in record["special_points"]:
        turns = "" if each["frequency"] is None else f"omega {each['frequency']:.10g}"
        kept = "" if each["stability"] == "kept" else f"stability {each['stability']}"
        remarks = "; ".join(filter(None, (turns, each["criticality"], kept)))
        error = without_unit(each["error"])
        page.say(f"  {each['kind']:<14}{each['parameter']:.12g} (error {error:.0e})  {remarks}")
    for where, end in (("begins", 0), ("ends", -1)):
        page.say(f"  {where} at {element(record['parameter'], end):.10g}: {record['ends'][end]}")
    page.say(f"  {sum(stable) / len(stable):.0%} of the points are stable".replace("%", " %"))
>>>>>>> main
