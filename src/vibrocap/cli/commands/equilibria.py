"""`vibrocap equilibria`: steady sliding and rest of a case that nothing drives in time, and their Hopf points."""

from pathlib import Path
from typing import Any

from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.cli.options import Refusal, quantity_range, refusing, writable_picture
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.dimensional import in_si, view
from vibrocap.quantities.json_text import json_text


def equilibria(
    case: Path,
    /,
    *,
    over: str | None = None,
    start: int | None = None,
    points: int = 2000,
    plot: Path | None = None,
    json: bool = False,
) -> int:
    """Steady sliding and intervals of rest of a case that nothing drives in time, with their stability.

    All states of the friction law count. With --over, one state of steady sliding
    is followed over a parameter, and its folds and Hopf points are located.

    Exit code 3: a branch continues but could not be followed.

    Parameters
    ----------
    case
        a case file (.toml) whose drive is constant, or a motion exported before (.nc, .csv)
    over
        PATH=LEAST:LARGEST, such as machine.belt_speed=0.5:2, to follow a state of steady sliding
    start
        which state of steady sliding to follow, by its number in the list that is printed without --over
    points
        points of a branch in each direction, at most
    plot
        FILE.png, .svg or .pdf: the real parts of the eigenvalues over the parameter
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.orbits.equilibria.equilibrium import equilibria as equilibria_of

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


def _refused_by_drive(ask: Any, *arguments: Any, **named: Any) -> Any:
    """What a function answers; Refusal for a complaint about the case itself."""
    try:
        return ask(*arguments, **named)
    except ArgumentError as error:
        if error.complaint.field in ("system", "start"):
            where = {"system": "CASE", "start": "--start"}[error.complaint.field]
            raise Refusal(f"{where}: {error.complaint.text}") from None
        raise


def _followed(system: Any, over: str, start: int | None, points: int, plot: Path | None, json: bool) -> int:
    """The branch of one state of steady sliding."""
    from vibrocap.orbits.equilibria.equilibrium import equilibria as equilibria_of
    from vibrocap.orbits.equilibria.equilibrium_branch import equilibrium_branch

    along, low, high = quantity_range(over, system)
    writable_picture("--plot", plot)
    begun = None
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
