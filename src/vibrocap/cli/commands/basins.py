"""`vibrocap basins`: which initial conditions lead to which steady motion."""

from pathlib import Path
from typing import Any

from vibrocap.arguments import ArgumentError, Refusal
from vibrocap.cli import completers
from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.options import JSON, SETTLE_PERIODS, option, picture, required
from vibrocap.cli.terminal import Page
from vibrocap.cli.texts import range_of
from vibrocap.physics.dimensions.conversion import INITIAL, Quantity, quantity, quantity_in_si
from vibrocap.physics.system import System
from vibrocap.quantities.dimensional import in_si, view


class BasinsRequest(OfCase, Drawn):
    plane: list[str] = required(
        'two axes, such as angle=-1:1,angle_rate, in SI velocity_m_per_s=-1:1; "phase" is a share of the drive\'s '
        "period [default range: as visited]",
        offers=completers.states_of_case,
    )
    resolution: int = option("initial conditions along each axis", 100)
    plot: Path | None = picture("the plane")
    json: bool = JSON
    phase: float = option("where in the drive's period the runs start, from 0 to 1", 0.0, advanced=True)
    settle_periods: int = SETTLE_PERIODS(500)


@command(
    "steady",
    "vibrocap basins case.toml --plane angle,angle_rate --resolution 20",
    doing="Running the starts of the plane",
)
def basins(request: BasinsRequest, report: Report) -> Answer:
    """Which initial conditions lead to which steady motion."""
    from vibrocap.orbits.attractors.basins import basins as basins_of

    setup = request.setup
    asked = [_axis(one, setup.system) for axis in request.plane for one in axis.split(",")]
    result = basins_of(
        setup.system,
        {along.plain.removeprefix(INITIAL): ends for along, ends in asked},
        request.resolution,
        initial=setup.initial,
        progress=report,
        **request.given("phase", "settle_periods"),
    )
    record, axes = view(in_si(result)), [along.path.removeprefix(INITIAL) for along, _ in asked]
    return Answer(record, lambda page: _print_basins(page, record), result, {"axes": axes})


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


def _print_basins(page: Page, record: dict[str, Any]) -> None:
    page.say(f"{record['starts']:,} starts over {record['axes'][0]} and {record['axes'][1]}", style="bold")
    for word, share in record["directions"].items():
        if share and (word != "no travel" or any(attractor["drift"] is not None for attractor in record["attractors"])):
            page.print(f"  {word:<12}{share:.2%}")
    for i, attractor in enumerate(record["attractors"]):
        drift = "" if attractor["drift"] is None else f", drift {attractor['drift']:.10g} per drive period"
        share = f"{attractor['share']:.2%} +- {attractor['error']:.2%}"
        page.say(f"  attractor {i}: {share} of the starts, {attractor['kind']}{drift}")
