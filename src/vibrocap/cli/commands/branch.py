"""`vibrocap branch` and `vibrocap basins`: steady motions over a parameter, and which starts lead to which."""

from pathlib import Path
from typing import Any

from vibrocap.arguments import ArgumentError
from vibrocap.cli.options import Refusal, quantity_range, range_of, refusing, writable_picture
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress
from vibrocap.io.motion_file import read_source
from vibrocap.physics.dimensions.conversion import INITIAL, Quantity, quantity, quantity_in_si
from vibrocap.physics.system import System
from vibrocap.quantities.dimensional import in_si, view
from vibrocap.quantities.json_text import json_text


def branch(
    case: Path,
    /,
    *,
    over: str,
    depth: int = 2,
    points: int = 1000,
    settle_periods: int = 2000,
    plot: Path | None = None,
    json: bool = False,
) -> int:
    """The branches of steady motions over a parameter: where symmetry breaks and travel begins.

    The symmetric motion is followed, stable or not, and so are the branches that
    leave it at pitchforks and flips. Where stable motions end within the range, a
    simulation shows what follows them, and that is followed too. Folds, flips, pitchforks and changes of the
    mode sequence are located. If the case's own value is outside the range, the
    search begins at the nearer end.

    Exit code 3: a branch continues but could not be followed.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    over
        PATH=LEAST:LARGEST, such as drive.amplitude=1:3, or drive.frequency_Hz=0.5:2 of a case in SI
    depth
        recursion depth at branch points
    points
        points of a branch in each direction, at most
    settle_periods
        drive periods simulated to find the first motion, at most
    plot
        FILE.png, .svg or .pdf: the mean velocity over the parameter, or the period if the machine cannot travel
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.orbits.continuation.branch_diagram import branches

    given = read_source(case)
    along, low, high = quantity_range(over, given.system)
    writable_picture("--plot", plot)
    names = ("depth", "points", "settle_periods")
    with progress(f"Following steady motions over {along.path}"), refusing(*names, over="--over", between="--over"):
        found = branches(
            given.system,
            along.plain,
            (low, high),
            initial=given.initial,
            depth=depth,
            points=points,
            settle_periods=settle_periods,
        )
    shown = in_si(found, over=along.path)
    if json:
        print(json_text(shown))
    else:
        Page().say(str(shown))
    if plot is not None and len(found.branches) and any(len(each) for each in found.branches):
        from vibrocap.plotting.look.finishing import save
        from vibrocap.plotting.steady.branches import branch_figure

        drawn = "mean_velocity" if found.system.cyclic is not None else "period"
        save(branch_figure(found, drawn, over=along.path), plot)
        if not json:
            Page().say(f"picture    {plot}")
    if not any(len(each) for each in found.branches):
        complain("No steady motion closed at the start; simulate the case, or raise --settle-periods.")
        return INCOMPLETE
    refused = sum(int((~each.certified).sum()) for each in found.branches)
    if refused:
        complain(f"{refused} points are not certified: their motions are not those of the equations.")
    early = {end: i for i, each in enumerate(found.branches) for end in each.ends if end.early}
    for end, i in early.items():
        complain(f"Branch [{i}] was not followed to its end ({end.value}). {end.advice}")
    return INCOMPLETE if early or refused else OK


def basins(
    case: Path,
    /,
    *,
    plane: list[str],
    resolution: int = 100,
    phase: float = 0.0,
    settle_periods: int = 500,
    plot: Path | None = None,
    json: bool = False,
) -> int:
    """Which starts of a plane lead to which steady motion, and which way it travels.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    plane
        two axes, such as angle=-1:1,angle_rate, in SI velocity_m_per_s=-1:1; "phase" is a share of the drive's period
        [default range: as visited]
    resolution
        starts along each axis
    phase
        where in the drive's period the runs start, from 0 to 1
    settle_periods
        drive periods that a motion has to settle
    plot
        draw the plane: FILE.png, .svg or .pdf
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.orbits.attractors.basins import basins as basins_of

    given = read_source(case)
    asked = [_axis(one, given.system) for each in plane for one in each.split(",")]
    axes = {along.plain.removeprefix(INITIAL): ends for along, ends in asked}
    writable_picture("--plot", plot)
    names = ("plane", "resolution", "phase", "settle_periods")
    with progress("Running the starts of the plane") as report, refusing(*names):
        found = basins_of(
            given.system,
            axes,
            resolution,
            phase=phase,
            initial=given.initial,
            settle_periods=settle_periods,
            progress=report,
        )
    record = view(in_si(found))
    if json:
        print(json_text(record))
    else:
        _print_basins(record)
    if plot is not None:
        from vibrocap.plotting.look.finishing import save
        from vibrocap.plotting.steady.basins import PRINT, basin_figure

        save(basin_figure(found, [along.path.removeprefix(INITIAL) for along, _ in asked]), plot, PRINT)
        if not json:
            Page().say(f"picture    {plot}")
    return OK


def _axis(text: str, system: System) -> tuple[Quantity, tuple[float, float] | None]:
    """NAME, or NAME=LEAST:LARGEST, which in SI carries the unit of the range: the state and its range without units."""
    if "=" not in text:
        return quantity_in_si(text if text == "phase" else INITIAL + text, system), None
    name, low, high = range_of(text, "--plane", "angle=-3:3")
    try:
        asked = quantity(INITIAL + name, system)
    except ArgumentError as error:
        raise Refusal(f"--plane {name}: {error.complaint.text.replace(INITIAL, '')}") from None
    best = quantity_in_si(asked.plain, system)
    if asked.scale == 1.0 and asked.unit == "1" and best.unit not in ("1", "rad"):
        raise Refusal(f"--plane {name}: has no unit in a case in SI; give {best.path.removeprefix(INITIAL)}")
    return asked, (low / asked.scale, high / asked.scale)


def _print_basins(record: dict[str, Any]) -> None:
    """The table of shares."""
    page = Page()
    page.say(f"{record['starts']:,} starts over {record['axes'][0]} and {record['axes'][1]}", style="bold")
    for word, share in record["directions"].items():
        if share and (word != "no travel" or any(each["drift"] is not None for each in record["attractors"])):
            page.print(f"  {word:<12}{share:.2%}")
    for i, each in enumerate(record["attractors"]):
        drift = "" if each["drift"] is None else f", drift {each['drift']:.10g} per drive period"
        share = f"{each['share']:.2%} +- {each['error']:.2%}"
        page.say(f"  attractor {i}: {share} of the starts, {each['kind']}{drift}")
