"""`vibrocap equilibria`: steady sliding and rest of a case that nothing drives in time, and their Hopf points."""

from pathlib import Path

from vibrocap.arguments import Refusal, check_whole
from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.completers import paths_of_case
from vibrocap.cli.options import JSON, option, picture
from vibrocap.cli.texts import quantity_range
from vibrocap.quantities.dimensional import in_si, view


class EquilibriaRequest(OfCase, Drawn):
    over: str | None = option(
        "PATH=LEAST:LARGEST, such as machine.belt_speed=0.5:2, to follow a state of steady sliding",
        sets=("between",),
        offers=paths_of_case,
    )
    start: int | None = option("the state of steady sliding to follow, by its number without --over", needs="over")
    plot: Path | None = picture("the real parts of the eigenvalues over the parameter", needs="over")
    json: bool = JSON
    points: int = option("points of a branch in each direction, at most", 2000, advanced=True)


@command(
    "steady",
    "vibrocap equilibria examples/slides-or-sticks-by-its-start.toml",
    "vibrocap equilibria examples/slides-or-sticks-by-its-start.toml --over machine.belt_speed=0.5:2 --plot hopf.png",
    doing="Looking for equilibria",
)
def equilibria(request: EquilibriaRequest, report: Report) -> Answer:
    """Steady sliding and rest without a periodic drive.

    Equilibria include all states of the friction law. With --over, the command follows one state of steady sliding over
    a parameter, and locates folds and Hopf points.

    Exit code 3: a branch continues but could not be followed.
    """
    from vibrocap.orbits.equilibria.equilibrium import equilibria as equilibria_of
    from vibrocap.orbits.equilibria.equilibrium_branch import equilibrium_branch

    check_whole("points", request.points, 10)
    system = request.setup.system
    if request.over is None:
        result = equilibria_of(system)
        shown = in_si(result)
        return Answer({"equilibria": view(shown)["found"]}, f"{request.case}: {shown}")
    along, low, high = quantity_range(request.over, system)
    begun = None
    if request.start is not None:
        states = equilibria_of(system).found
        if not 0 <= request.start < len(states):
            raise Refusal(f"--start: should be the number of one of the {len(states)} equilibria, got {request.start}")
        begun = states[request.start]
    result = equilibrium_branch(system, along.plain, (low, high), start=begun, points=request.points)
    shown = in_si(result, over=along.path)
    early = [f"The branch was not followed to its end ({end.value}). {end.advice}" for end in result.ends if end.early]
    return Answer(view(shown), str(shown), result, incomplete="\n".join(early))
