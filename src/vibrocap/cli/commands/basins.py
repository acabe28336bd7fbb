"""`vibrocap basins`: which initial conditions lead to which steady motion."""

import dataclasses
import math
from pathlib import Path
from typing import Annotated, Any

from vibrocap.arguments import ArgumentError
from vibrocap.cli import completers
from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.options import Json, Option, SettlePeriods, picture
from vibrocap.cli.refusal import Refusal
from vibrocap.cli.terminal import Page, said
from vibrocap.cli.texts import range_of
from vibrocap.io.json_text import in_both
from vibrocap.physics.dimensions.conversion import INITIAL, Quantity, quantity, quantity_in_si
from vibrocap.physics.system import System
from vibrocap.quantities.dimensional import in_si, units_of


@dataclasses.dataclass(frozen=True, kw_only=True)
class BasinsRequest(OfCase, Drawn):
    """The options of `vibrocap basins`."""

    plane: Annotated[
        list[str],
        Option(
            'two axes, such as angle=-1:1,angle_rate, in SI velocity_m_per_s=-1:1; "phase" is a share of the drive\'s '
            "period [default range: as visited]",
            offers=completers.states_of_case,
        ),
    ]
    resolution: Annotated[int, Option("initial conditions along each axis")] = 100
    plot: Annotated[Path | None, picture("the plane")] = None
    json: Json = False
    phase: Annotated[float, Option("where in the drive's period the runs start, from 0 to 1", advanced=True)] = 0.0
    settle_periods: SettlePeriods = 500


@command(
    "steady",
    "vibrocap basins case.toml --plane angle,angle_rate --resolution 20",
    doing="Running the starts of the plane",
)
def basins(request: BasinsRequest, report: Report) -> Answer:
    """Which initial conditions lead to which steady motion."""
    from vibrocap.orbits.attractors.basins import basins as basins_of

    given = request.setup
    asked = [_axis(one, given.system) for each in request.plane for one in each.split(",")]
    found = basins_of(
        given.system,
        {along.plain.removeprefix(INITIAL): ends for along, ends in asked},
        request.resolution,
        phase=request.phase,
        initial=given.initial,
        settle_periods=request.settle_periods,
        progress=report,
    )
    record, shown = _basin_record(found), in_si(found)
    if shown is not found:
        record = in_both(_basin_record(shown), {"attractors": units_of(shown, "drift")}, record)

    def figure() -> Any:
        from vibrocap.plotting.steady.basins import PRINT, basin_figure

        return basin_figure(found, [along.path.removeprefix(INITIAL) for along, _ in asked]), PRINT

    return Answer(record, lambda page: _print_basins(page, record), figure)


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


def _basin_record(found: Any) -> dict[str, Any]:
    """Shares of the plane, by direction and by attractor."""
    size = found.direction.size
    words = {1: "forward", 0: "no travel", -1: "back", -2: "not settled", -3: "failed", -5: "not certified"}
    return {
        "axes": found.axes,
        "starts": size,
        "directions": {word: int((found.direction == code).sum()) / size for code, word in words.items()},
        "attractors": [
            {
                "index": i,
                "kind": each.motion.kind,
                "share": each.share,
                "share_error": each.error,
                "drift": _drift(found, i),
            }
            for i, each in enumerate(found.attractors)
        ],
    }


def _drift(found: Any, index: int) -> float | None:
    """Drift per drive period of the motions that lead to an attractor."""
    drifts = found.drift[found.label == index]
    return float(drifts[0]) if len(drifts) and math.isfinite(drifts[0]) else None


def _print_basins(page: Page, record: dict[str, Any]) -> None:
    """The table of shares."""
    page.say(f"{record['starts']:,} starts over {record['axes'][0]} and {record['axes'][1]}", style="bold")
    for word, share in record["directions"].items():
        if share and (word != "no travel" or any(each["drift"] is not None for each in record["attractors"])):
            page.print(f"  {word:<12}{share:.2%}")
    length = "m" if "units" in record else ""
    for each in record["attractors"]:
        drift = "" if each["drift"] is None else f", drift {said(each['drift'], length)} per drive period"
        share = f"{each['share']:.2%} +- {each['share_error']:.2%}"
        page.say(f"  attractor {each['index']}: {share} of the starts, {each['kind']}{drift}")
