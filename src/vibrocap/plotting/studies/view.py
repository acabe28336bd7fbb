"""The view of a study: one measure over one or two axes, with how every run ended; what a picture of it shows.

More dimensions than two are fixed at a value, or become panels side by side (friction laws, or any few values).
"""

import contextlib
import dataclasses
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import Complaints, Refusal, suggestion
from vibrocap.case.case import Case, CaseError, case_from_text
from vibrocap.motion.status import Status
from vibrocap.motion.trust import TRAVEL, ZERO
from vibrocap.physics.dimensions.conversion import INITIAL
from vibrocap.plotting.look.labels import bracketed, case_words, percent, symbol_text, value_text, whole
from vibrocap.studies.plan.runs import even_in_logarithm
from vibrocap.studies.plan.variation import residues, with_varied_parts
from vibrocap.studies.variables import ALWAYS, NOT_RUN

MOST_PANELS = 6
BAND = "dead_band"
# few different values, each with a meaning
WHOLE = ("response_period", "stick_phases", "impacts", "symmetric", "travel")
FEW = 10

NOTHING = re.compile(r" \((?:NaN|empty|infinite): (.*)\)")  # what a meaning says of missing values
SYMBOLS = {
    "mean_velocity": "⟨X′⟩",
    "drift": "ΔX",
    "displacement": "ΔX",
    "peak_friction": "max |R|",
    "mean_friction": "⟨|R|⟩",
    "velocity_loop_area": "∮R dv",
    "displacement_loop_area": "∮R dX",
    "cost_of_transport": "W/|ΔX|",
}
VALUE_LABELS = {
    "symmetric": {0.0: "not its own mirror image", 1.0: "its own mirror image"},
    "travel": {-1.0: "back", 0.0: "none", 1.0: "forward"},
    "response_period": {0.0: "not settled"},
    "settled": {0.0: "not settled", 1.0: "settled"},
    "computed": {0.0: "filled in", 1.0: "run"},
}


@dataclasses.dataclass(frozen=True, eq=False)
class ViewAxis:
    """An axis of a picture: what varies, its values in ascending order, and how it is labelled and spaced."""

    path: str
    values: np.ndarray
    label: str
    scattered: bool = False

    @property
    def logarithmic(self) -> bool:
        """Whether the values are evenly spaced, or where they are scattered spread, in their logarithm."""
        if self.scattered and len(self.values) > 2 and self.values[0] > 0.0:
            low, middle, high = np.percentile(self.values, (0.0, 50.0, 100.0))
            return high > low and bool(abs(_share(np.log, low, middle, high)) < abs(_share(float, low, middle, high)))
        return not self.scattered and even_in_logarithm(self.values)

    @property
    def edges(self) -> np.ndarray:
        """Borders of the cells around the values: middles between them, and half a step beyond the ends [n + 1]."""
        x = np.log(self.values) if self.logarithmic else self.values
        middles = (x[1:] + x[:-1]) / 2
        half = np.array([0.5 * abs(x[0]) or 0.5] * 2) if len(x) == 1 else np.diff(x)[[0, -1]] / 2
        edges = np.concatenate(([x[0] - half[0]], middles, [x[-1] + half[1]]))
        return np.exp(edges) if self.logarithmic else edges


def _share(scale: Any, low: float, middle: float, high: float) -> float:
    """Where the middle lies between the ends, from -1/2 to 1/2, on a scale."""
    return (scale(middle) - scale(low)) / (scale(high) - scale(low)) - 0.5


@dataclasses.dataclass(frozen=True, eq=False)
class Panel:
    """What one pair of axes shows. Arrays [x] or [x, y], or [runs] where the runs do not lie on a grid."""

    title: str
    values: np.ndarray  # numbers, or words
    status: np.ndarray  # index into list(Status); -1: not run
    settled: np.ndarray  # True everywhere where the study did not ask
    dead_band: np.ndarray  # sizes of a signed measure up to this are no travel
    dataset: Any  # the same runs with all their variables

    def other(self, name: str) -> np.ndarray:
        """Numbers of another variable for the same runs."""
        return self.dataset[name].values.astype(float)


@dataclasses.dataclass(frozen=True, eq=False)
class View:
    """A measure of a study over its axes.

    kind: "signed" (travel), "plain" (any other number) or "discrete" (words, whole numbers with a meaning)
    points: coordinates [runs] along the axes where the runs do not lie on a grid, else None
    """

    measure: str
    meaning: str
    unit: str
    kind: str
    axes: tuple[ViewAxis, ...]
    panels: tuple[Panel, ...]
    points: tuple[np.ndarray, ...] | None
    setting: str  # the case in brief
    note: str  # what else a reader should know

    @property
    def title(self) -> str:
        """The measure and what it means, without what is said of missing values."""
        return f"{self.measure.replace('_', ' ')}: {NOTHING.sub('', self.meaning)}"

    @property
    def label(self) -> str:
        """The measure with its symbol and unit."""
        return f"{self.measure.replace('_', ' ')} {SYMBOLS.get(self.measure, '')}".rstrip() + bracketed(self.unit)

    @property
    def band(self) -> str:
        """Up to where a size is no travel, with its unit; over all runs where these differ."""
        bands = np.concatenate([panel.dead_band.ravel() for panel in self.panels])
        ends = dict.fromkeys(f"{end(bands):.2g}" for end in (np.min, np.max))
        return whole(f"{' to '.join(ends)} {'' if self.unit == '1' else self.unit}".strip())


def study_view(
    dataset: Any, measure: str | None = None, at: Mapping[str, str] | None = None, dead_band: float | None = None
) -> View:
    """What a picture of a study shows.

    measure: a variable, by default the first measure that the study took
    at: values at which dimensions are fixed, by path; the nearest value of the axis is taken
    dead_band: sizes of travel up to this are none; by default the residue of each settled motion
    Raises Refusal for a measure or a path that the study does not have, and where dimensions are left over.
    """
    complaints = Complaints()
    names = [str(name) for name in dataset.data_vars]
    asked = measure or first_measure(dataset)
    if asked not in names:
        complaints.add("--measure", f"the study has no {asked!r}; {suggestion(asked, names)}")
    runs, fixed, view_axes = _fixed(dataset, at or {})
    complaints += view_axes
    if complaints:
        raise Refusal(*complaints)
    case = case_of(dataset)
    runs = runs.assign({BAND: _dead_band(runs, case, travel_of(dataset, asked) or TRAVEL[0], dead_band)})

    gridded = all(dim in dataset.coords for dim in runs["status"].dims)
    if gridded:
        facets, dims = _facets(runs)
        values = {dim: np.sort(runs[dim].values.astype(float)) for dim in dims}
        axes = tuple(ViewAxis(dim, values[dim], axis_label(dim, runs[dim].attrs)) for dim in dims)
        points = None
    else:
        facets, dims = [], tuple(runs["status"].dims)
        axes, points = _scattered(runs)
    panels = tuple(_panel(part, asked, axes if gridded else (), title) for title, part in _parts(runs, facets))
    if asked in TRAVEL:
        kind = "signed"
    else:
        named = asked == "status" or asked in WHOLE or asked in VALUE_LABELS
        kind = "discrete" if named or panels[0].values.dtype.kind == "U" else "plain"
    return View(
        asked,
        str(dataset[asked].attrs.get("long_name", asked.replace("_", " "))),
        str(dataset[asked].attrs.get("units", "1")),
        kind,
        axes,
        panels,
        points,
        case_label(runs, case, fixed),
        runs_label(runs, case),
    )


def _dead_band(runs: Any, case: Case | None, travel: str, asked: float | None) -> Any:
    """Up to where a measure of travel is none, of every run."""
    status, settle = runs["status"], runs.attrs.get("settle")
    unit = float(runs[travel].attrs.get("dimensionless_unit", 1.0)) if travel in runs else 1.0
    size: Any = asked
    if size is None and travel == "mean_velocity" and BAND in runs.attrs:  # of mean velocities alone
        size = unit * float(runs.attrs[BAND])
    elif size is None and settle and case:
        paths = [str(path) for path in runs.coords if "." in str(path) and not str(path).startswith(INITIAL)]
        values = {path: runs[path].broadcast_like(status).transpose(*status.dims).values.ravel() for path in paths}
        values = {path: x.astype(object) if _has_words(x) else x.astype(float) for path, x in values.items()}
        system = with_varied_parts(case.system, paths)
        size = unit * residues(system, values, status.size, travel, float(settle)).reshape(status.shape)
    return status.copy(data=np.broadcast_to(unit * ZERO if size is None else size, status.shape))


def travel_of(dataset: Any, measure: str) -> str | None:
    """The measure whose sign is the direction of travel, and whose size up to the dead band is none."""
    return next((name for name in (measure, *TRAVEL) if name in TRAVEL and name in dataset), None)


def first_measure(dataset: Any) -> str:
    """The first measure that a study took."""
    return next((str(name) for name in dataset.data_vars if name not in ALWAYS), "response_period")


def _fixed(dataset: Any, at: Mapping[str, str]) -> tuple[Any, dict[str, str], list[str]]:
    """The dataset at some values, which they are, and what is wrong with them; a single value is fixed by itself."""
    dims = [str(dim) for dim in dataset["status"].dims]
    gridded = [dim for dim in dims if dim in dataset.coords]
    places: dict[str, int] = {}
    complaints = Complaints()
    for path, text in at.items():
        if path not in gridded:
            complaints.add(f"--at {path}", f"is no axis of the study; {suggestion(path, gridded)}")
            continue
        values, wanted = np.array(dataset[path].values.tolist()), np.nan
        with contextlib.suppress(ValueError):
            wanted = float(text)
        if values.dtype.kind == "U" and text in values:
            places[path] = values.tolist().index(text)
        elif values.dtype.kind == "U":
            complaints.add(f"--at {path}", f"has no {text!r}; {suggestion(text, values.tolist())}")
        elif values.min() <= wanted <= values.max():
            places[path] = int(np.abs(values - wanted).argmin())
        else:
            limits = f"from {values.min():g} to {values.max():g}"
            complaints.add(f"--at {path}", f"should be a number {limits}, got {text!r}")
    places |= {dim: 0 for dim in gridded if dataset.sizes[dim] == 1 and dim not in at}
    part = dataset.isel(places)
    fixed = {str(path): value_text(part[path].values.item()) for path in part.coords if not part[path].dims}
    return part, fixed, complaints


def _facets(dataset: Any) -> tuple[list[str], tuple[str, ...]]:
    """The dimensions that become panels, and the one or two that are drawn."""
    dims = [str(dim) for dim in dataset["status"].dims]
    words = [dim for dim in dims if _has_words(dataset[dim])]
    numbers = [dim for dim in dims if dim not in words]
    while len(numbers) > 2 and dataset.sizes[few := min(numbers, key=lambda dim: dataset.sizes[dim])] <= MOST_PANELS:
        words.append(few)
        numbers.remove(few)
    panels = int(np.prod([dataset.sizes[dim] for dim in words]))
    if not numbers:
        raise Refusal("--at: leaves no axis of numbers to draw over; fix fewer")
    if len(numbers) > 2 or panels > MOST_PANELS:
        ways = "; ".join(f"{dim}: {_span(dataset[dim])}" for dim in dims)
        limit = f"a picture has one or two axes and at most {MOST_PANELS} panels"
        raise Refusal(f"--at: {limit}; fix some with --at PATH=VALUE ({ways})")
    return words, tuple(numbers)


def _parts(dataset: Any, facets: Sequence[str]) -> Iterator[tuple[str, Any]]:
    for place in np.ndindex(*(dataset.sizes[dim] for dim in facets)):
        part = dataset.isel(dict(zip(facets, place, strict=True)))
        yield ", ".join(panel_title(dim, part[dim].values.item()) for dim in facets), part


def _panel(part: Any, measure: str, axes: Sequence[ViewAxis], title: str) -> Panel:
    """The runs of a panel, along ascending axes."""
    for axis in axes:
        part = part.isel({axis.path: np.argsort(part[axis.path].values, kind="stable")})
    part = part.transpose(*(axis.path for axis in axes)) if axes else part
    values = part[measure].values
    known = bool(part.attrs.get("settle"))
    settled = part["settled"].values.astype(bool) if known else np.ones(values.shape, bool)
    shown = np.array(values.tolist(), dtype=str) if _has_words(values) else values.astype(float)
    return Panel(title, shown, part["status"].values.astype(int), settled, part[BAND].values, part)


def _scattered(dataset: Any) -> tuple[tuple[ViewAxis, ...], tuple[np.ndarray, ...]]:
    """The first two quantities that vary from run to run as axes; of a list of cases without numbers, its order."""
    runs = dataset["status"].dims[0]
    axes = [
        (ViewAxis(str(path), np.sort(values), axis_label(str(path), dataset[path].attrs), scattered=True), values)
        for path in dataset.coords
        if dataset[path].dims == (runs,) and not _has_words(dataset[path])
        if not np.isnan(values := dataset[path].values.astype(float)).any()
    ][:2]
    if not axes or runs == "case":
        values = np.arange(dataset.sizes[runs], dtype=float)
        axes = [(ViewAxis(str(runs), values, f"number of the {runs}"), values)]
    return tuple(axis for axis, _ in axes), tuple(values for _, values in axes)


def _has_words(values: Any) -> bool:
    return values.dtype.kind in "OTU"


def _span(values: Any) -> str:
    if _has_words(values):
        return ", ".join(map(str, values.values.tolist()))
    return f"{values.size} values from {float(values.min()):g} to {float(values.max()):g}"


def status_label(code: int) -> str:
    """A status in words."""
    return "not run yet" if code == NOT_RUN else list(Status)[code].value


def axis_label(path: str, attributes: Mapping[str, Any]) -> str:
    """What varies, with its symbol and unit."""
    unit = attributes.get("units", "1")
    meaning = str(attributes.get("long_name", path)).replace(" [rad]", "")
    for plain, nice in (("^2", "²"), ("omega_n", "ωₙ")):
        meaning = meaning.replace(plain, nice)
    unit = "rad" if "[rad]" in str(attributes.get("long_name", "")) else unit
    return f"{meaning} {symbol_text(str(attributes.get('symbol', '')))}".rstrip() + bracketed(unit)


def case_of(dataset: Any) -> Case | None:
    """The case of a study; None where a dataset tells of none."""
    try:
        return case_from_text(str(dataset.attrs["case"]))
    except (KeyError, CaseError):
        return None


def case_label(dataset: Any, case: Case | None, fixed: Mapping[str, str]) -> str:
    """The case in brief: the kinds of its parts, and the parameters that the study left as they are."""
    if case is None:
        return ", ".join(f"{path} = {value}" for path, value in fixed.items())
    return case_words(case, {str(name) for name in dataset.coords} - set(fixed), fixed)


def runs_label(dataset: Any, case: Case | None) -> str:
    """How the runs were made."""
    runs, periods, settle = dataset["status"].size, dataset.attrs.get("periods"), dataset.attrs.get("settle")
    words = [f"{runs:,} runs"]
    if periods is not None:
        settled = f", settled to {float(settle):g}" if settle else ""
        words[0] += f" of {'at most ' if settle else ''}{periods} periods{settled}"
    if "runs_computed" in dataset.attrs:
        words.append(f"{percent(float(dataset.attrs['share_computed']))} of them made, the others filled in between")
    in_si = any("dimensionless_unit" in dataset[name].attrs for name in dataset.data_vars)
    in_si = in_si if case is None else case.system.units is not None
    return "; ".join([*words, "in SI" if in_si else "all dimensionless"])


def panel_title(path: str, value: float | str) -> str:
    """The title of a panel that shows one value of a quantity."""
    return value if isinstance(value, str) else f"{path.partition('.')[2].replace('_', ' ')} {value_text(value)}"


def value_label(measure: str, value: float | str) -> str:
    """A discrete value of a measure in words."""
    if isinstance(value, str):
        return value or "(no word)"
    if measure == "status":
        return status_label(int(value))
    return VALUE_LABELS.get(measure, {}).get(float(value)) or f"{value:g}"


def missing_label(meaning: str) -> str:
    """Why a run may have no value, as the meaning of its measure says."""
    label = NOTHING.search(meaning)
    return f"no value ({label[1]})" if label else "no value"
