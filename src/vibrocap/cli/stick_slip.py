"""The command `vibrocap stick-slip`: phases, period, slips, levels and regime of pulled sliders."""

import dataclasses
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.cli.exits import OK
from vibrocap.cli.terminal import Page, Refusal, writable_picture

if TYPE_CHECKING:
    from vibrocap.records.regimes import RegimeDiagram
    from vibrocap.records.stick_slip import Spread, StickSlip

ARRAYS = ("time", "force", "velocity")  # too long for a summary


def stick_slip(
    source: Path,
    /,
    *,
    record: str | None = None,
    columns: list[str] | None = None,
    units: list[str] | None = None,
    sampling_rate: float | None = None,
    stiffness: float | None = None,
    speed: float | None = None,
    mass: float | None = None,
    normal_force: float | None = None,
    coefficient: bool = False,
    minor: float = 0.5,
    plot: Path | None = None,
    json: bool = False,
) -> int:
    """Stick-slip in the measured force on a slider that is pulled through a spring.

    Stick and slip phases, period, slips, levels of friction and the regime:
    stick-slip, inertial or steady. Of a file with several records all are
    listed, and --plot draws the diagram of their regimes.

    Example: vibrocap stick-slip pull.csv --stiffness 168 --speed 42e-6 --mass 0.0307 --plot pull.png

    Parameters
    ----------
    source
        FILE.csv, .txt, .npz or .mat with force over time, or the folder of the data set paper-stick-slip
    record
        which record of several, such as k168_v42
    columns
        QUANTITY=NAME, once for time and force each, where their names are not usual ones
    units
        QUANTITY=UNIT, such as force=mN; force=1 is friction over normal force
    sampling_rate
        Hz, where there is no column of time
    stiffness
        of the spring, N/m
    speed
        at which the spring is pulled, m/s
    mass
        of the slider, kg
    normal_force
        N, for friction coefficients
    coefficient
        the force is friction over normal force
    minor
        slips whose fall is below this share of the mean fall count as minor and not for period and slips
    plot
        draw the record, or the diagram of regimes: FILE.png, .svg or .pdf
    json
        print one JSON object in full precision, a list of them for several records
    """
    from vibrocap.records.checks import RecordError
    from vibrocap.records.pull_files import read_pulls
    from vibrocap.records.stick_slip import stick_slip as stick_slip_of_force

    complaints: list[str] = []
    wanted = _pairs("columns", columns, complaints)
    units_given = {quantity: str(unit) for quantity, unit in _pairs("units", units, complaints).items()}
    try:
        writable_picture("--plot", plot)
    except Refusal as refusal:
        complaints.append(str(refusal))
    given = {"stiffness": stiffness, "pulling_speed": speed, "mass": mass, "normal_force": normal_force}
    settings: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    if coefficient:
        settings["coefficient"] = True
    found: list[StickSlip] = []
    try:
        pulls = read_pulls(source, record, wanted, units_given, sampling_rate)
    except (RecordError, FileNotFoundError) as error:
        raise Refusal("\n".join([*complaints, str(error)])) from None
    if coefficient and any("coefficient" not in each.settings for each in pulls):
        complaints.append(f"--coefficient: the reader of {source.name} has made newtons of its coefficients already")
    for each in pulls if not complaints else ():
        try:
            arguments = {**each.settings, **settings, "minor": minor, "name": each.name}
            found.append(stick_slip_of_force(each.time, each.force, **arguments))
        except RecordError as error:
            complaints.append(str(error).replace("pulling_speed:", "speed:"))
    if complaints:
        raise Refusal("\n".join(complaints))
    if plot is not None:
        _draw(found, plot)
    if json:
        from vibrocap.io.record import json_text

        print(json_text(_plain(found[0]) if len(found) == 1 else [_plain(each) for each in found]))
    elif len(found) == 1:
        print_stick_slip(found[0], plot)
    else:
        print_records(found, plot)
    return OK


def _pairs(option: str, texts: list[str] | None, complaints: list[str]) -> dict[str, str | int]:
    """QUANTITY=NAME pairs, one a text or several with commas between; a name of digits is a place."""
    pairs: dict[str, str | int] = {}
    for text in (piece for each in texts or () for piece in each.split(",")):
        quantity, equals, value = (piece.strip() for piece in text.partition("="))
        if not (quantity and equals and value):
            complaints.append(f"--{option} {text}: should be QUANTITY=NAME, such as force=F1")
        pairs[quantity] = int(value) if option == "columns" and value.isdigit() else value
    return pairs


def _draw(found: "list[StickSlip]", path: Path) -> None:
    from vibrocap.plotting.stick_slip import plot_regimes, plot_stick_slip

    path.parent.mkdir(parents=True, exist_ok=True)
    if len(found) == 1:
        plot_stick_slip(found[0], path)
        return
    plot_regimes(_diagram(found), path)


def _diagram(found: "list[StickSlip]") -> "RegimeDiagram":
    from vibrocap.records.regimes import regime_diagram

    try:
        return regime_diagram(found)
    except ValueError as error:
        raise Refusal(f"--plot: {error}; or draw one with --record") from None


def _plain(found: "StickSlip") -> dict[str, Any]:
    """What is known of a record by name, without the arrays."""
    record: dict[str, Any] = {}
    for field in dataclasses.fields(found):
        value = getattr(found, field.name)
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            value = dataclasses.asdict(value)
        if field.name not in ARRAYS:
            record[field.name] = value
    return record | {"phases": [dataclasses.asdict(phase) for phase in found.phases]}


def print_stick_slip(found: "StickSlip", plot: Path | None = None) -> None:
    """The summary of a record."""
    page = Page()
    page.print(f"{found.name}: {found.regime.name}", style="bold")
    page.print(f"  {found.regime.reason}", soft_wrap=True)
    unit = "" if found.force_unit == "1" else " N"
    rows: list[tuple[str, str | None]] = [
        ("slips", _counted(found)),
        ("period", _told(found.period, " s")),
        ("spectrum", _told(found.recurrence.spectral_period, " s")),
        ("correlation", _told(found.recurrence.correlation_period, " s")),
        ("slip", _told(found.slip, " um", scale=1e6)),
        ("release of spring", _told(found.release, " um", scale=1e6)),
        ("stick phases", _told(found.stick_duration, " s")),
        ("slip phases", _told(found.slip_duration, " s")),
        ("at rest", None if found.stick_fraction is None else f"{found.stick_fraction:.1%} of the time"),
        ("static level", _told(found.static_level, unit, found.static_coefficient)),
        ("kinetic level", _told(found.kinetic_level, unit, found.kinetic_coefficient, found.kinetic_from)),
        ("level at slip end", _told(found.slip_end_level, unit)),
        ("rate over k V", _told(found.loading_ratio, "")),
        ("fastest", None if found.velocity is None else f"{found.velocity.max():.4g} m/s"),
        ("noise", f"{found.noise:.3g}{unit}, {found.spikes:,} spikes taken out"),
    ]
    for name, text in rows:
        if text is not None:
            page.print(f"  {name:<18} {text}", soft_wrap=True)
    for note in found.notes:
        page.print(f"  note: {note}", soft_wrap=True)
    if plot is not None:
        page.print(f"Picture: {plot}", soft_wrap=True)


def _counted(found: "StickSlip") -> str | None:
    """How many slips there are, and what the minor ones change."""
    main, every = len(found.main_slips), [slip.start for slip in found.slips]
    if len(every) == main:
        return str(main) if main else None
    period = (every[-1] - every[0]) / (len(every) - 1)
    return f"{main}, and {len(every) - main} minor; were these counted, the period would be {period:.4g} s"


def _told(
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


def print_records(found: "list[StickSlip]", plot: Path | None = None) -> None:
    """A table of several records."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, header_style="dim")
    for heading in ("record", "regime", "slips", "period s", "inertial s", "slip um", "at rest"):
        table.add_column(heading, no_wrap=True)
    for each in found:
        numbers = (
            each.period.mean if each.period else math.nan,
            each.regime.inertial_period or math.nan,
            1e6 * each.slip.mean if each.slip else math.nan,
        )
        shown = ["" if math.isnan(number) else f"{number:.4g}" for number in numbers]
        rest = "" if each.stick_fraction is None else f"{each.stick_fraction:.0%}"
        table.add_row(each.name, each.regime.name, str(len(each.main_slips)), *shown, rest)
    page = Page()
    page.print(table)
    page.print("inertial: 2 pi sqrt(m/k). Of one record more is told with --record NAME.")
    if plot is not None:
        page.print(f"Picture: {plot}", soft_wrap=True)
