"""`vibrocap branch`: the branches of steady motions over a parameter."""

from pathlib import Path

from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.options import JSON, OVER, SETTLE_PERIODS, option, picture
from vibrocap.cli.texts import quantity_range
from vibrocap.quantities.dimensional import in_si


class BranchRequest(OfCase, Drawn):
    over: str = OVER
    plot: Path | None = picture("mean velocity over the parameter; period and multipliers if the machine cannot travel")
    json: bool = JSON
    depth: int = option("recursion depth at branch points", 2, advanced=True)
    points: int = option("points of a branch in each direction, at most", 1000, advanced=True)
    settle_periods: int = SETTLE_PERIODS(2000)


@command(
    "steady",
    "vibrocap branch case.toml --over drive.amplitude=1:1.5 --plot branch.png",
    doing="Following steady motions over {over}",
)
def branch(request: BranchRequest, report: Report) -> Answer:
    """Branches of steady motions over a parameter.

    The command follows the symmetric motion, stable or not, and the branches that leave it at pitchforks and flips.
    Where stable motions end within the range, it simulates and follows their successors too. It locates folds, flips,
    pitchforks and changes of the mode sequence. If the case's own value is outside the range, the search begins at the
    nearer end.

    Exit code 3: a branch continues but could not be followed.
    """
    from vibrocap.orbits.continuation.branch_diagram import branches

    setup = request.setup
    along, low, high = quantity_range(request.over, setup.system)
    settings = request.given("depth", "points", "settle_periods")
    result = branches(setup.system, along.plain, (low, high), initial=setup.initial, **settings)
    shown = in_si(result, over=along.path)
    travels = result.system.cyclic is not None
    if not any(len(branch) for branch in result.branches):
        words = "No steady motion closed at the start; simulate the case, or raise --settle-periods."
        return Answer(shown, str(shown), incomplete=words)
    refused = sum(int((~branch.certified).sum()) for branch in result.branches)
    wrong = [f"{refused} points are not certified: their motions are not those of the equations."] if refused else []
    early = {end: i for i, branch in enumerate(result.branches) for end in branch.ends if end.early}
    wrong += [f"Branch [{i}] was not followed to its end ({end.value}). {end.advice}" for end, i in early.items()]
    drawing = {"quantity": "mean_velocity" if travels else "period", "over": along.path, "multipliers": not travels}
    return Answer(shown, str(shown), result, drawing, incomplete="\n".join(wrong))
