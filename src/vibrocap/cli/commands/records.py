"""`vibrocap stick-slip` and `vibrocap datasets`: measured records of pulled sliders, and the published measurements."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cyclopts import App

from vibrocap.arguments import Complaints, suggestion
from vibrocap.cli.command_examples import examples_of
from vibrocap.cli.completers import completing, data_sets
from vibrocap.cli.options import Refusal, needs, pairs, split, writable_folder, writable_picture
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress, table
from vibrocap.quantities.json_text import json_text

if TYPE_CHECKING:
    from vibrocap.records.slips.periods import Drift
    from vibrocap.records.stick_slip import Spread, StickSlip


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

    It finds stick and slip phases, period, slips, levels of friction and the
    regime: stick-slip, inertial or steady. If a file has several records, all are
    listed, and --plot draws a diagram of their regimes.

    Parameters
    ----------
    source
        FILE.csv, .txt, .npz or .mat with force over time, or the folder of the data set paper-stick-slip
    record
        the name of one record of several, such as k168_v42
    columns
        QUANTITY=NAME for time and force, such as force=F1, if the columns have unusual names
    units
        QUANTITY=UNIT, such as force=mN; force=1 is friction over normal force
    sampling_rate
        samples per second (Hz), if there is no column of time
    stiffness
        stiffness of the spring in N/m
    speed
        speed at which the spring is pulled, in m/s
    mass
        mass of the slider in kg
    normal_force
        normal force in N, for friction coefficients
    coefficient
        the column of force holds friction over normal force
    minor
        slips smaller than this share of the mean slip are minor, and left out of period and slips
    plot
        draw the record, or the diagram of regimes: FILE.png, .svg or .pdf
    json
        print one JSON object in full precision, a list of them for several records
    """
    from vibrocap.records.checks import RecordError
    from vibrocap.records.slips.pull import read_pulls
    from vibrocap.records.stick_slip import stick_slip as stick_slip_of_force

    complaints = Complaints()
    pair = "QUANTITY=NAME, such as force=F1"
    named = pairs("columns", split(columns), complaints, pair)
    wanted = {quantity: int(name) if name.isdigit() else name for quantity, name in named.items()}
    units_given = pairs("units", split(units), complaints, pair)
    with complaints.collected():
        writable_picture("--plot", plot)
    given = {"stiffness": stiffness, "pulling_speed": speed, "mass": mass, "normal_force": normal_force}
    settings: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    if coefficient:
        settings["coefficient"] = True
    found: list[StickSlip] = []
    try:
        pulls = read_pulls(source, record, wanted, units_given, sampling_rate)
    except (RecordError, FileNotFoundError) as error:
        raise Refusal(*complaints, str(error)) from None
    if coefficient and any("coefficient" not in each.settings for each in pulls):
        complaints.append(f"--coefficient: the reader of {source.name} has made newtons of its coefficients already")
    for each in pulls if not complaints else ():
        try:
            arguments = {**each.settings, **settings, "minor": minor, "name": each.name}
            found.append(stick_slip_of_force(each.time, each.force, **arguments))
        except RecordError as error:
            complaints.append(str(error).replace("pulling_speed:", "speed:"))
    if complaints:
        raise Refusal(*complaints)
    if plot is not None:
        _draw(found, plot)
    if json:
        print(json_text(found[0] if len(found) == 1 else found))
    elif len(found) == 1:
        print_stick_slip(found[0])
        for note in pulls[0].notes:
            Page().say(f"  read: {note}")
    else:
        print_records(found)
    if plot is not None and not json:
        Page().say(f"Picture: {plot}")
    return OK


def _draw(found: "list[StickSlip]", path: Path) -> None:
    from vibrocap.plotting.look.finishing import save
    from vibrocap.plotting.stick_slip import regime_figure, stick_slip_figure
    from vibrocap.records.regime_diagram import regime_diagram

    if len(found) == 1:
        save(stick_slip_figure(found[0]), path)
        return
    try:
        save(regime_figure(regime_diagram(found)), path)
    except ValueError as error:
        raise Refusal(f"--plot: {error}; or draw one with --record") from None


def print_stick_slip(found: "StickSlip") -> None:
    """The summary of a record."""
    page = Page()
    page.say(f"{found.name}: {found.regime.name}", style="bold")
    page.say(f"  {found.regime.reason}")
    unit = "" if found.force_unit == "1" else " N"
    rows: list[tuple[str, str | None]] = [
        ("slips", _slip_count(found)),
        ("period", _spread_text(found.period, " s")),
        ("drift of period", _drift_text(found.drift)),
        ("spectrum", _spread_text(found.recurrence.spectral_period, " s")),
        ("correlation", _spread_text(found.recurrence.correlation_period, " s")),
        ("slip", _spread_text(found.slip, " um", scale=1e6)),
        ("release of spring", _spread_text(found.release, " um", scale=1e6)),
        ("stick phases", _spread_text(found.stick_duration, " s")),
        ("slip phases", _spread_text(found.slip_duration, " s")),
        ("at rest", None if found.stick_fraction is None else f"{found.stick_fraction:.1%} of the time"),
        ("static level", _spread_text(found.static_level, unit, found.static_coefficient)),
        ("kinetic level", _spread_text(found.kinetic_level, unit, found.kinetic_coefficient, found.kinetic_from)),
        ("level at slip end", _spread_text(found.slip_end_level, unit)),
        ("rate over k V", _spread_text(found.loading_ratio, "")),
        ("fastest", None if found.velocity is None else f"{found.velocity.max():.4g} m/s"),
        ("noise", f"{found.noise:.3g}{unit}, {found.spikes:,} spikes taken out"),
    ]
    page.rows(rows, 19)
    for note in found.notes:
        page.say(f"  note: {note}")


def _slip_count(found: "StickSlip") -> str | None:
    """How many slips there are, and what the minor ones change."""
    main, every = len(found.main_slips), [slip.start for slip in found.slips]
    if len(every) == main:
        return str(main) if main else None
    period = (every[-1] - every[0]) / (len(every) - 1)
    return f"{main}, and {len(every) - main} minor; were these counted, the period would be {period:.4g} s"


def _drift_text(drift: "Drift | None") -> str | None:
    if drift is None:
        return None
    return f"{drift.last - drift.first:+.3g} s from the first third to the last, standard error {drift.error:.2g} s"


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


def print_records(found: "list[StickSlip]") -> None:
    """A table of several records."""
    made = table(None, "record", "regime", "slips", "period s", "inertial s", "slip um", "at rest", no_wrap=7)
    for each in found:
        numbers = (
            each.period.mean if each.period else math.nan,
            each.regime.inertial_period or math.nan,
            1e6 * each.slip.mean if each.slip else math.nan,
        )
        shown = ["" if math.isnan(number) else f"{number:.4g}" for number in numbers]
        rest = "" if each.stick_fraction is None else f"{each.stick_fraction:.0%}"
        made.add_row(each.name, each.regime.name, str(len(each.main_slips)), *shown, rest)
    page = Page()
    page.print(made)
    page.print("inertial: 2 pi sqrt(m/k). Of one record more is told with --record NAME.")


# --- published measurements -------------------------------------------------------------------------------------------
datasets = App(
    name="datasets",
    help="Published measurements of friction: which there are, and fetching their originals.",
    help_epilogue=examples_of("datasets"),
)


@datasets.command(name="list", help_epilogue=examples_of("datasets list"))
def list_data_sets() -> int:
    """The data sets that can be fetched: what was measured, by whom, the licence, and whether it is here."""
    from vibrocap.records.fetching import DATA_SETS
    from vibrocap.records.published import FOLDERS, data_root

    page = Page()
    for each in DATA_SETS.values():
        folder = data_root() / FOLDERS[each.name]
        count = len(each.originals)
        here = f"here, in {folder}" if folder.is_dir() else f"not here; {count} file{'s' * (count != 1)}"
        page.say(f"{each.name}", style="bold")
        for line in (each.title, f"{each.authors}; {each.licence}", each.page, here):
            page.say(f"  {line}")
    return OK


@datasets.command(help_epilogue=examples_of("datasets fetch"))
@completing(name=data_sets)
def fetch(name: str, /, *, to: Path | None = None) -> int:
    """Fetch the published files of a data set, and check them; what is there already is not fetched again.

    A file must have the checksum that its publisher gives. If there is none, the
    checksum of the first fetch is kept in SHA256SUMS, and must be the same later.

    Exit codes: 0 done; 2 wrong input; 3 the files could not be had (no network) or
    are not what they should be.

    Parameters
    ----------
    name
        a data set, as `vibrocap datasets list` shows them
    to
        folder for data sets [default: VIBROCAP_DATA, else a folder in the user's cache]
    """
    from vibrocap.records.fetching import DATA_SETS, FetchError
    from vibrocap.records.fetching import fetch as fetched
    from vibrocap.records.published import data_root

    if name not in DATA_SETS:
        begun = next((each for each in DATA_SETS if name and each.startswith(name)), name)
        raise Refusal(f"no data set is called {name!r}; {suggestion(begun, DATA_SETS)}")
    needs("datasets fetch", "pooch")
    writable_folder("--to", to if to is not None else data_root())
    try:
        with progress(f"Fetching {name}") as report:
            came = fetched(DATA_SETS[name], to, lambda share: report(share, None))
    except FetchError as error:
        complain(str(error))
        return INCOMPLETE
    page = Page()
    samples = sum(map(len, came.records))
    page.say(f"{name}: {len(came.records)} records, {samples:,} samples, in {came.folder}")
    if came.known:
        page.print(f"  checked    {came.known} against the published checksum")
    if came.recorded:
        page.print(f"  checked    {came.recorded} against the checksum of the first fetch")
    if came.first:
        page.say(f"  trusted    {came.first} on first use; checksums in SHA256SUMS there")
    page.say(f"  by         {DATA_SETS[name].authors}; {DATA_SETS[name].licence}")
    if to is not None:
        page.say(f"To use it: VIBROCAP_DATA={to}")
    return OK
