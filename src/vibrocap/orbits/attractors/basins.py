"""Basins: which way each start of a plane travels in the end, and which attractor it leads to."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Annotated, Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.motion.simulate import check_run, initial_state
from vibrocap.motion.trust import FINISHED, Trust, residue
from vibrocap.numerics.api import Budget, codes
from vibrocap.orbits.attractors.attractors import FAILED, NOT_CERTIFIED, NOT_SETTLED, NOT_TOLD, Attractor, attractors_of
from vibrocap.orbits.attractors.classification import SURE
from vibrocap.orbits.attractors.starts import check_state, checked_start_range, visited_ranges
from vibrocap.orbits.closing.settling_runs import ROUGH, SETTLED, SettlingRuns, settling_runs
from vibrocap.orbits.maps.stroboscopic_map import MOST_EVENTS, MOST_STEPS, StroboscopicMap, is_driven
from vibrocap.orbits.parameter_range import checked_pair
from vibrocap.physics.dimensions.conversion import INITIAL
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByKey, ByName, Context, Declared, Keyed, Lengths, Number, Numbers, Over
from vibrocap.ranges import cell_middles
from vibrocap.results import Result

PHASE = "phase"
FORWARD, NO_TRAVEL, BACK = 1, 0, -1
MOST_STARTS = 10_000_000
PLANE = ("path_x", "path_y")
CODES = {"not_certified": NOT_CERTIFIED, "not_told_apart": NOT_TOLD, "failed": FAILED, "not_settled": NOT_SETTLED}
TRAVELS = {"back": BACK, "no_travel": NO_TRAVEL, "forward": FORWARD}
DIRECTIONS = {"forward": FORWARD, "no travel": NO_TRAVEL, "back": BACK}
DIRECTIONS |= {"not settled": NOT_SETTLED, "failed": FAILED, "not certified": NOT_CERTIFIED}


@dataclasses.dataclass(frozen=True)
class OfAxis(Declared):
    """The quantity along one of the axes."""

    axis: int

    def unit(self, context: Context) -> str:
        return context.units.unit(context.known("axes")[0][self.axis])


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Basins(Result):
    """Where the starts of a plane lead; arrays [x, y].

    axes: names of both axes, states or "phase"; x, y: their values, the middles of cells
    phase: where in the drive's period the starts are, as a share of it, unless it is an axis
    initial: values of the other states
    direction: 1 forward, 0 no travel, as of a machine that does not travel, -1 back; or, as in `label`,
        NOT_SETTLED (-2), FAILED (-3), NOT_CERTIFIED (-5)
    label: index of the attractor, or NOT_SETTLED (-2), FAILED (-3), NOT_TOLD (-4), NOT_CERTIFIED (-5), see `Attractors`
    drift: of the motion in the end, per drive period; NaN where it is not known
    attractors: that with most starts first
    keys: under which the axes were given, such as "angle_deg", in which pictures show them; empty for states
    """

    system: System
    axes: tuple[str, str]
    x: Annotated[np.ndarray, OfAxis(0), Over("path_x", name="path_x")]
    y: Annotated[np.ndarray, OfAxis(1), Over("path_y", name="path_y")]
    phase: Number
    initial: ByName
    direction: Annotated[Numbers, Over(*PLANE, words="direction of travel in the end", flags=CODES | TRAVELS)]
    label: Annotated[Numbers, Over(*PLANE, words="index of the attractor", flags=CODES)]
    drift: Annotated[Lengths, Over(*PLANE, words="drift in the end, per drive period")]
    attractors: Annotated[tuple[Attractor, ...], Over("attractor")]
    settle_periods: int
    keys: tuple[str, ...] = ()

    rows = "attractors"
    in_record = "axes starts directions attractors"

    @property
    def path_x(self) -> str:
        """The first axis as a path of a start."""
        return _path(self.axes[0])

    @property
    def path_y(self) -> str:
        """The second one."""
        return _path(self.axes[1])

    @property
    def starts(self) -> int:
        return self.direction.size

    @property
    def directions(self) -> dict[str, Number]:
        """Share of the starts by the direction of travel in the end, in words."""
        return {word: float(np.mean(self.direction == code)) for word, code in DIRECTIONS.items()}


def _path(axis: str) -> str:
    return axis if axis == PHASE else INITIAL + axis


@shows_progress("Running the starts of the plane")
def basins(
    system: System,
    plane: ByKey | Sequence[str],
    resolution: int | tuple[int, int] = 200,
    *,
    phase: Number = 0.0,
    initial: ByName | None = None,
    settle_periods: int = 500,
    tolerance: float = 1e-12,
    threads: int | None = None,
    progress: Progress = None,
) -> Basins:
    """Basins of direction on a plane of starts, such as {"angle": (-3, 3), "angle_rate": (-3, 3)}.

    plane: two axes with (low, high) each: states, or "phase", where in the drive's period a run starts as a share of it
        (0.25: a quarter after the start). Without a range, as in ("angle", "phase"), a state has the range that motions
        visit (as in `attractors`), the phase's a whole period. Runs start in the middles of equal cells
    resolution: cells along both axes, or along each
    phase: that share for all runs, where it is no axis; initial: values of the other states
    settle_periods, tolerance, progress: as in `attractors`, whose attractors are those of these starts

    In a system with the half-period symmetry the basins are their own mirror image: the mirrored start half a period
    later leads to the mirror-image solution.
    A system that nothing drives in time has no phase.
    Raises ValueError naming the argument.
    """
    start = initial_state(system, initial)
    axes, pairs = _checked_plane(system, plane)
    counts = _checked_resolution(resolution)
    if not is_driven(system) and (PHASE in axes or phase):
        why = "the system has no drive in time, hence no phase; plane should name two states"
        raise ArgumentError("phase", why)
    if isinstance(phase, (bool, str)) or not math.isfinite(phase):
        raise ArgumentError("phase", f"should be a finite share of the drive's period, got {phase!r}")
    check_whole("settle_periods", settle_periods, 10, 10**7)
    check_run(periods=1, tolerance=tolerance, max_events_per_period=1, max_steps=1)
    map_ = StroboscopicMap(system, tolerance, threads)
    visited = visited_ranges(map_, np.array(list(start.values()))) if None in pairs else {}
    visited |= {PHASE: (0.0, 1.0)}
    ranges = [pair or visited[name] for name, pair in zip(axes, pairs, strict=True)]
    values = [cell_middles(low, high, n) for (low, high), n in zip(ranges, counts, strict=True)]
    across = [column.ravel() for column in np.meshgrid(*values, indexing="ij")]
    states = np.tile(list(start.values()), (counts[0] * counts[1], 1))
    phases = np.full(len(states), float(phase))
    for name, column in zip(axes, across, strict=True):
        if name == PHASE:
            phases = column
        else:
            states[:, system.state_names.index(name)] = column
    runs = started_anywhere(map_, states, phases, settle_periods, told(progress))
    distinct, label, runs = attractors_of(map_, runs, settle_periods)
    drift = _drifts(distinct, label, runs)
    shape = (counts[0], counts[1])
    errors = [share_error(label.reshape(shape) == k) for k in range(len(distinct))]
    distinct = tuple(dataclasses.replace(known, error=error) for known, error in zip(distinct, errors, strict=True))
    return Basins(
        system=system,
        axes=axes,
        x=values[0],
        y=values[1],
        phase=float(phase),
        initial={name: value for name, value in start.items() if name not in axes},
        direction=_directions(system, distinct, label, drift).reshape(shape),
        label=label.reshape(shape),
        drift=drift.reshape(shape),
        attractors=distinct,
        settle_periods=settle_periods,
        keys=plane.keys_given if isinstance(plane, Keyed) else (),
    )


def started_anywhere(
    map_: StroboscopicMap,
    states: np.ndarray,
    phases: np.ndarray,
    periods: int,
    progress: Callable[[float], None] | None = None,
) -> SettlingRuns:
    """Runs from states at phases of the drive [runs], until they settle."""
    marked, ended = at_next_section(map_, states, phases)
    going, count = ended == codes.DONE, len(states)
    parts = settling_runs(map_, marked[going], periods, progress=progress)
    nothing = np.zeros(count, dtype=int), np.full(count, np.nan), np.zeros(count, dtype=bool)
    return SettlingRuns(marked, ended, *nothing).replaced(np.flatnonzero(going), parts)


def at_next_section(map_: StroboscopicMap, states: np.ndarray, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(states at the next start of a drive period [runs, states], how each run ended: numbers of `codes`).

    phase: [runs] share of the drive's period at which each run starts; whole parts do not matter
    """
    share, ends, ended = phase - np.floor(phase), states.copy(), np.full(len(states), codes.DONE)
    if len(waiting := np.flatnonzero(share)):  # the others are there already
        budget, parameters = Budget(1, ROUGH, MOST_EVENTS, MOST_STEPS), map_.parameters()
        run = map_.run(budget, states[waiting], parameters, start=share[waiting] * map_.period(parameters))
        ends[waiting], ended[waiting] = run.state, run.status
    return ends, ended


def share_error(inside: np.ndarray) -> float:
    """Standard error of the share of the cells [x, y] of a basin, from where its border may run between their middles.

        e = sqrt(b/12 + sum of (L^2 - L)/12 + a/4)/n

    The border cuts about each of the b cells beside another basin at a place of its own. Along a straight wall of L
    cells that does not go on one cell farther, as along an axis, it is one place for all of them. A cell with another
    basin on both sides (a of them) lies in either by chance.
    """
    from scipy.ndimage import binary_erosion

    beside = inside & ~np.asarray(binary_erosion(inside, border_value=1), dtype=bool)
    variance, alone = float(np.sum(beside)) / 12.0, np.zeros(inside.shape, dtype=bool)
    for turned, between in ((inside, alone), (inside.T, alone.T)):
        walls = np.diff(turned.astype(np.int8), axis=0)  # between neighbours along x, then along y
        between[1:-1] |= walls[1:] * walls[:-1] < 0
        padded, wall = np.pad(walls, 1), walls != 0
        ends = [wall & (walls != padded[1:-1, side]) for side in (slice(None, -2), slice(2, None))]
        goes_on = [
            (padded[:-2, side] == walls) | (padded[2:, side] == walls) for side in (slice(None, -2), slice(2, None))
        ]
        first, last = map(np.flatnonzero, ends)
        lengths = (last - first + 1.0)[~goes_on[0][ends[0]] | ~goes_on[1][ends[1]]]
        variance += float(np.sum(lengths * (lengths - 1.0))) / 12.0
    return math.sqrt(variance + float(np.sum(alone)) / 4.0) / inside.size


def _drifts(reached: tuple[Attractor, ...], label: np.ndarray, runs: SettlingRuns) -> np.ndarray:
    """Drift per drive period: that of the attractor, or of the run where it settled to one of too many."""
    known = np.array([math.nan if one.motion.drift is None else one.motion.drift for one in reached] + [math.nan])
    return np.where(label >= 0, known[np.maximum(label, -1)], np.where(label == NOT_TOLD, runs.drift, math.nan))


def _directions(system: System, reached: tuple[Attractor, ...], label: np.ndarray, drift: np.ndarray) -> np.ndarray:
    """Direction of the drift; NOT_SETTLED or FAILED where there is none to speak of."""
    left = residue(system, "drift", SETTLED)
    residues = [left if one.motion.orbit is not None else SURE * one.motion.drift_error for one in reached]
    known = (label >= 0) | (label == NOT_TOLD)
    trust = Trust(np.full(label.shape, FINISHED), known, np.array([*residues, left])[np.maximum(label, -1)])
    return np.where(known, np.nan_to_num(trust.direction(drift)), label).astype(np.int8)


def _checked_plane(system: System, plane: Any) -> tuple[tuple[str, str], list[tuple[float, float] | None]]:
    if isinstance(plane, (tuple, list)) and all(isinstance(name, str) for name in plane):
        plane = dict.fromkeys(plane)
    if not isinstance(plane, Mapping) or len(plane) != 2:
        why = f'should name two states, or one and "phase", with (low, high) each, got {plane!r}'
        raise ArgumentError("plane", why)
    for name in plane:
        if name != PHASE:
            check_state("plane", system, name)
    first, second = plane
    pairs: list[tuple[float, float] | None] = []
    for name, pair in plane.items():
        if pair is not None and name == PHASE:
            pair = checked_pair(f"plane: {name}", system, name, pair)
        elif pair is not None:
            pair = checked_start_range(f"plane: {name}", system, name, pair)
        pairs.append(pair)
    return (first, second), pairs


def _checked_resolution(resolution: Any) -> tuple[int, int]:
    pair = (resolution, resolution) if isinstance(resolution, (int, np.integer)) else resolution
    whole = isinstance(pair, (tuple, list, np.ndarray)) and len(pair) == 2
    if not whole or not all(isinstance(n, (int, np.integer)) and not isinstance(n, bool) and n >= 1 for n in pair):
        raise ArgumentError("resolution", f"should be one or two whole numbers >= 1, got {resolution!r}")
    if pair[0] * pair[1] > MOST_STARTS:
        raise ArgumentError("resolution", f"{pair[0]} x {pair[1]} starts are more than {MOST_STARTS:,}")
    return int(pair[0]), int(pair[1])
