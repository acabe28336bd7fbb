"""`vibrocap stick-slip`: stick-slip in the measured force on sliders that are pulled through a spring."""

import functools
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.arguments import ArgumentError, Complaints, Refusal, by_option
from vibrocap.cli.command import Answer, Drawn, command
from vibrocap.cli.options import COLUMN_UNITS, COLUMNS, JSON, SAMPLING_RATE, option, picture, required
from vibrocap.cli.terminal import Page, table
from vibrocap.cli.texts import column_names, pairs, split

if TYPE_CHECKING:
    from vibrocap.records.stick_slip import Spread, StickSlip


class StickSlipRequest(Drawn):
    source: Path = required(
        "FILE.csv, .txt, .xlsx, .json, .npz or .mat with force over time, or the folder of paper-stick-slip",
        place=True,
    )
    record: str | None = option("the name of one record of several, such as k168_v42")
    columns: list[str] | None = COLUMNS
    units: list[str] | None = COLUMN_UNITS
    sampling_rate: float | None = SAMPLING_RATE
    stiffness: float | None = option("stiffness of the spring in N/m")
    speed: float | None = option("speed at which the spring is pulled, in m/s", sets=("pulling_speed",))
    mass: float | None = option("mass of the slider in kg")
    normal_force: float | None = option("normal force in N, for friction coefficients")
    coefficient: bool = option("the column of force holds friction over normal force", False)
    plot: Path | None = picture("the record, or the diagram of regimes of several")
    json: bool = JSON
    minor: float = option(
        "slips below this share of the mean slip do not count in period and slips", 0.5, advanced=True
    )

    @functools.cached_property
    def reading(self) -> tuple[dict[str, Any], dict[str, str]]:
        """Columns and units by quantity; Refusal for texts that are none."""
        refused = Complaints()
        columns = column_names(self.columns, refused)
        units = pairs("units", split(self.units), refused, "QUANTITY=UNIT, such as force=kN")
        if refused:
            raise Refusal(*refused)
        return columns, units

    def plan(self, refused: Complaints) -> None:
        """Columns and units can be read."""
        _ = self.reading


@command("data", "vibrocap stick-slip pull.csv --stiffness 168 --speed 42e-6 --plot pull.png")
def stick_slip(request: StickSlipRequest) -> Answer:
    """Stick-slip in the measured force on a slider.

    A spring pulls the slider. The report has stick and slip phases, period, slips, levels of friction and the regime:
    stick-slip, inertial or steady. For several records in a file it lists all, and --plot draws a diagram of their
    regimes.
    """
    from vibrocap.records.pull import read_pulls
    from vibrocap.records.record import RecordError
    from vibrocap.records.stick_slip import regime_diagram
    from vibrocap.records.stick_slip import stick_slip as stick_slip_of_force

    (columns, units), complaints = request.reading, Complaints()

    def named(error: RecordError) -> list[str]:
        return [f"{error.source}:", *(f"  {line}" for line in by_option(error.complaints, request.flags()))]

    settings: dict[str, Any] = request.given("stiffness", "mass", "normal_force", "minor")
    settings |= {} if request.speed is None else {"pulling_speed": request.speed}
    settings |= {"coefficient": True} if request.coefficient else {}
    results: list[StickSlip] = []
    try:
        pulls = read_pulls(request.source, request.record, columns, units, request.sampling_rate)
    except (RecordError, FileNotFoundError) as error:
        raise Refusal(*(named(error) if isinstance(error, RecordError) else [str(error)])) from None
    if request.coefficient and any("coefficient" not in pull.settings for pull in pulls):
        already = f"the reader of {request.source.name} has made newtons of its coefficients already"
        complaints.append(f"--coefficient: {already}")
    for pull in pulls if not complaints else ():
        try:
            arguments = {**pull.settings, **settings, "name": pull.name}
            results.append(stick_slip_of_force(pull.time, pull.force, **arguments))
        except RecordError as error:
            complaints += named(error)
    if complaints:
        raise Refusal(*complaints)

    def text(page: Page) -> None:
        if len(results) > 1:
            print_records(page, results)
            return
        print_stick_slip(page, results[0])
        for note in pulls[0].notes:
            page.say(f"  read: {note}")

    record = results[0] if len(results) == 1 else results
    try:
        drawn: Any = record if request.plot is None or len(results) == 1 else regime_diagram(results)
    except ArgumentError as error:  # records without a place in the diagram
        raise Refusal(f"--plot: {error}; or draw one with --record") from None
    return Answer(record, text, drawn)


def print_stick_slip(page: Page, analysis: "StickSlip") -> None:
    """The summary of a record."""
    page.say(f"{analysis.name}: {analysis.regime.name}", style="bold")
    page.say(f"  {analysis.regime.reason}")
    unit = "" if analysis.force_unit == "1" else " N"
    drift = None
    if analysis.drift is not None:
        change = analysis.drift.last - analysis.drift.first
        drift = f"{change:+.3g} s from the first third to the last, standard error {analysis.drift.error:.2g} s"
    rows: list[tuple[str, str | None]] = [
        ("slips", _slip_count(analysis)),
        ("period", _spread_text(analysis.period, " s")),
        ("drift of period", drift),
        ("spectrum", _spread_text(analysis.recurrence.spectral_period, " s")),
        ("correlation", _spread_text(analysis.recurrence.correlation_period, " s")),
        ("slip", _spread_text(analysis.slip, " um", scale=1e6)),
        ("release of spring", _spread_text(analysis.release, " um", scale=1e6)),
        ("stick phases", _spread_text(analysis.stick_duration, " s")),
        ("slip phases", _spread_text(analysis.slip_duration, " s")),
        ("at rest", None if analysis.stick_fraction is None else f"{analysis.stick_fraction:.1%} of the time"),
        ("static level", _spread_text(analysis.static_level, unit, analysis.static_coefficient)),
        (
            "kinetic level",
            _spread_text(analysis.kinetic_level, unit, analysis.kinetic_coefficient, analysis.kinetic_from),
        ),
        ("level at slip end", _spread_text(analysis.slip_end_level, unit)),
        ("rate over k V", _spread_text(analysis.loading_ratio, "")),
        ("fastest", None if analysis.velocity is None else f"{analysis.velocity.max():.4g} m/s"),
        ("noise", f"{analysis.noise:.3g}{unit}, {analysis.spikes:,} spike{'s' * (analysis.spikes != 1)} removed"),
    ]
    page.rows(rows, 19)
    for note in analysis.notes:
        page.say(f"  note: {note}")


def _slip_count(analysis: "StickSlip") -> str | None:
    """How many slips there are, and what the minor ones change."""
    main, every = len(analysis.main_slips), [slip.start for slip in analysis.slips]
    if len(every) == main:
        return str(main) if main else None
    period = (every[-1] - every[0]) / (len(every) - 1)
    return f"{main}, and {len(every) - main} minor; were these counted, the period would be {period:.4g} s"


def _spread_text(
    value: "Spread | float | None",
    unit: str,
    coefficient: float | None = None,
    source: str | None = None,
    scale: float = 1.0,
) -> str | None:
    if value is None:
        return None
    more = "" if coefficient is None or not unit else f"; coefficient {coefficient:.4g}"
    more += "" if source is None else f"; {source}"
    if isinstance(value, int | float):
        return f"{scale * value:.5g}{unit}{more}"
    deviation = "" if value.deviation is None else f", standard deviation {scale * value.deviation:.3g}"
    return f"{scale * value.mean:.5g}{unit} (median {scale * value.median:.5g}{deviation}, {value.number}){more}"


def print_records(page: Page, analyses: "list[StickSlip]") -> None:
    """A table of several records."""
    listing = table(None, "record", "regime", "slips", "period s", "inertial s", "slip um", "at rest", no_wrap=7)
    for record in analyses:
        numbers = (
            record.period.mean if record.period else math.nan,
            record.regime.inertial_period or math.nan,
            1e6 * record.slip.mean if record.slip else math.nan,
        )
        shown = ["" if math.isnan(number) else f"{number:.4g}" for number in numbers]
        rest = "" if record.stick_fraction is None else f"{record.stick_fraction:.0%}"
        listing.add_row(record.name, record.regime.name, str(len(record.main_slips)), *shown, rest)
    page.print(listing)
    page.print("inertial: 2 pi sqrt(m/k). --record NAME shows more of one record.")
