"""All attractors of a system: what many starts lead to, each once, and how many of them each attracts."""

import dataclasses
import math

import numpy as np

from vibrocap.arguments import check_whole
from vibrocap.motion.simulate import check_run, initial_state
from vibrocap.orbits.attractors.classification import (
    CLOUD,
    MotionClass,
    class_of,
    class_of_iterates,
    mirrored_cloud,
    same_set,
    settled_without_clock,
    within_set,
)
from vibrocap.orbits.attractors.starts import checked_ranges, spread_starts, visited_ranges
from vibrocap.orbits.closing.orbit import in_continuum
from vibrocap.orbits.closing.periodic_solution import PeriodicSolution
from vibrocap.orbits.closing.settling_runs import (
    SettlingRuns,
    iterates,
    mirrored_points,
    nearest,
    orbit_points,
    orbits_reached,
    selected,
    settling_runs,
)
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, is_driven
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByKey, ByName, Length, Number, Numbers, Speed, StateColumns
from vibrocap.quantities.dimensional import Dimensional
from vibrocap.results import Result

# What a start leads to, where that is none of the attractors.
NOT_SETTLED, FAILED, NOT_TOLD, NOT_CERTIFIED = -2, -3, -4, -5
MOST_SHOT = 100  # settled motions that are shot: more of them are not told apart
MOST_CLOUDS = 32  # unsettled runs whose iterates are gathered; the others are compared with these
FEW = 64  # iterates of each of those others
EXPONENT_PERIODS = 1000  # over which a motion that did not settle is looked at


@dataclasses.dataclass(frozen=True)
class Attractor(Dimensional):
    """A motion to which starts lead.

    motion: its class, with its drift, orbit or exponents; starts: how many lead to it; share: of all starts
    error: standard error of the share, as of the share of the ranges that leads to it: of spread starts at most that of
        random ones, sqrt(s (1 - s)/n); of a plane see `basins.share_error`
    twin: index of its mirror-image solution among the attractors, its own where it is symmetric; None where the system
    has no
        such symmetry or no start was seen to lead to the twin
    """

    motion: MotionClass
    starts: int
    share: Number
    error: Number
    twin: int | None

    in_record = "kind starts share error drift mean_velocity winding largest_multiplier twin"

    @property
    def kind(self) -> str:
        return self.motion.kind

    @property
    def drift(self) -> Length | None:
        return self.motion.drift

    @property
    def winding(self) -> dict[str, Number]:
        return {f"winding_{name}": turns for name, turns in self.motion.winding.items()}

    @property
    def mean_velocity(self) -> Speed | None:
        """That of its orbit; None of what is not periodic."""
        return None if self.motion.orbit is None else self.motion.orbit.mean_velocity

    @property
    def largest_multiplier(self) -> Number | None:
        """That of its orbit; None of what is not periodic."""
        return None if self.motion.orbit is None else self.motion.orbit.largest_multiplier


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Attractors(Result):
    """The attractors of a system, that with most starts first, and where each start led.

    starts: [starts, states]; label: [starts] index of the attractor, or NOT_SETTLED (-2), FAILED (-3), NOT_TOLD (-4):
        settled, to one of a continuum of motions (rests of a block) or of too many to tell them apart;
        NOT_CERTIFIED (-5): where it led is no motion of the equations, by evidence taken of its last response
    ranges: of the states in which the starts are spread; settle_periods: most drive periods that a run was given
    """

    system: System
    attractors: tuple[Attractor, ...]
    starts: StateColumns
    label: Numbers
    ranges: ByName
    settle_periods: int

    rows = "attractors"
    in_record = "attractors lost"

    @property
    def lost(self) -> Number:
        """Share of the starts that lead to none of them."""
        return float(np.mean(self.label < 0))

    def share(self, label: int) -> Number:
        """Share of the starts with a label."""
        return float(np.mean(self.label == label))

    def of(self, orbit: PeriodicSolution) -> int | None:
        """Index of the attractor that an orbit of the system is, whichever drive period it begins at.

        None where no start led to it.
        """
        if not is_driven(self.system) or not orbit.closes:
            return None
        map_ = StroboscopicMap(self.system, orbit.tolerance)
        orbits = {k: known for k, attractor in enumerate(self.attractors) if (known := attractor.motion.orbit)}
        place = nearest(orbit_points(map_, orbit).points, [orbit_points(map_, known) for known in orbits.values()])
        return None if place is None else list(orbits)[place]


@shows_progress("Running the starts")
def attractors(
    system: System,
    starts: int = 1000,
    ranges: ByKey | None = None,
    *,
    initial: ByName | None = None,
    settle_periods: int = 500,
    tolerance: float = 1e-12,
    threads: int | None = None,
    progress: Progress = None,
) -> Attractors:
    """The attractors of initial conditions spread over ranges of the states.

    All starts run side by side until they settle. Settled runs are polished by shooting, one for each orbit: the n
    states in which an orbit of period n passes the section are one attractor, and orbits may be mirror images of each
    other. Those that do not settle are grouped by the sets that they fill there and classified by
    their largest Lyapunov exponent and the 0-1 test; others stay NOT_SETTLED.

    starts: how many, of low discrepancy (the first thousand of two thousand are the same thousand)
    ranges: {state: (low, high)}; by default all states, as far as motions from within two natural sizes visit them
    Where nothing drives the system in time, runs end at equilibria (a set of rest is one attractor) or on cycles with
    periods of their own, which are closed as by `orbit`.

    initial: values of the states that have no range
    settle_periods: most drive periods of a run; tolerance: of the orbits, see `orbit`
    progress: True for a bar, or a function that is called now and then, from any thread, with the share of the starts
        that have begun

    An attractor with a small basin may be missed: one of the share s is, with the probability exp(-s starts).
    Raises ValueError naming the argument.
    """
    start = np.array(list(initial_state(system, initial).values()))
    check_whole("starts", starts, 1, 10_000_000)
    asked = None if ranges is None else checked_ranges(system, ranges)
    check_whole("settle_periods", settle_periods, 10, 10**7)
    check_run(periods=1, tolerance=tolerance, max_events_per_period=1, max_steps=1)
    map_ = StroboscopicMap(system, tolerance, threads)
    ranges = visited_ranges(map_, start) if asked is None else asked
    states = spread_starts(map_, start, ranges, starts)
    runs = settling_runs(map_, states, settle_periods, progress=told(progress))
    distinct, label, _ = attractors_of(map_, runs, settle_periods)
    return Attractors(system, distinct, states, label, ranges, settle_periods)


Labelled = tuple[tuple[Attractor, ...], np.ndarray, SettlingRuns]  # attractors, label [runs], the runs


def attractors_of(map_: StroboscopicMap, runs: SettlingRuns, periods: int) -> Labelled:
    """(attractors, label [runs], the runs) of runs of one system that have ended; a few may have to continue."""
    good = np.flatnonzero(runs.certified | ~runs.finished)
    distinct, labels, ended = _attractors_of_good(map_, runs.some(good), periods)
    label = np.full(len(runs.state), NOT_CERTIFIED)
    label[good] = labels
    return distinct, label, runs.replaced(good, ended)


def _attractors_of_good(map_: StroboscopicMap, runs: SettlingRuns, periods: int) -> Labelled:
    """As `attractors_of`, of runs that failed or are certified."""
    clock = is_driven(map_.system)
    if clock:
        orbits, which, runs = orbits_reached(map_, runs, periods, MOST_SHOT)
        settled, reached = runs.response_period > 0, []
    else:
        reached, which, runs = settled_without_clock(map_, runs, periods)
        settled, orbits = which >= 0, []
    waiting = np.flatnonzero(runs.finished & ~settled)
    apart = [k for k, known in enumerate(orbits) if not in_continuum(map_, known.orbit)]  # no samples of a continuum
    orbits, which = selected(orbits, which, apart) if clock else (orbits, which)
    continuum = bool(np.any(settled & (which < 0)))
    label = np.where(which >= 0, which, np.where(settled, NOT_TOLD, FAILED))
    motions = [class_of(orbit) for orbit in (*(known.orbit for known in orbits), *reached)]
    places = list(range(len(motions)))
    groups, members = _wandering(map_, runs.state[waiting])
    label[waiting] = NOT_SETTLED
    for motion, among in zip(groups, members, strict=True):
        if motion.kind in ("failed", "not settled"):
            label[waiting[among]] = FAILED if motion.kind == "failed" else NOT_SETTLED
            continue
        if continuum and motion.orbit is not None:
            label[waiting[among]] = NOT_TOLD
            continue
        orbit = None if motion.orbit is None else orbit_points(map_, motion.orbit)
        known = None if orbit is None else nearest(orbit.points, orbits)
        label[waiting[among]] = len(motions) if known is None else places[known]
        if known is None:
            if orbit is not None:
                orbits.append(orbit)
                places.append(len(motions))
            motions.append(motion)
    ordered, label = _in_order(motions, _twins(map_, motions) if clock else [None] * len(motions), label)
    return ordered, label, runs


def _in_order(
    motions: list[MotionClass], twins: list[int | None], label: np.ndarray
) -> tuple[tuple[Attractor, ...], np.ndarray]:
    """(attractors, label [runs]) of motions and labels in any order: that with most starts first."""
    counts = [int(np.sum(label == k)) for k in range(len(motions))]
    order = sorted(range(len(motions)), key=lambda k: -counts[k])
    place = {k: new for new, k in enumerate(order)}
    twin = [None if other is None else place[other] for other in (twins[k] for k in order)]
    shares = [counts[k] / max(len(label), 1) for k in order]
    errors = [math.sqrt(share * (1.0 - share) / max(len(label), 1)) for share in shares]
    known = zip(order, shares, errors, twin, strict=True)
    ordered = tuple(Attractor(motions[k], counts[k], share, error, other) for k, share, error, other in known)
    moved = np.array([*(place[k] for k in range(len(motions))), 0], dtype=int)
    return ordered, np.where(label >= 0, moved[np.maximum(label, -1)], label)


def _wandering(map_: StroboscopicMap, states: np.ndarray) -> tuple[list[MotionClass], list[np.ndarray]]:
    """(classes of motions that did not settle, indices of the runs of each) by the sets that they fill."""
    count = len(states)
    if not count:
        return [], []
    sample = np.unique(np.linspace(0, count - 1, min(count, MOST_CLOUDS)).round().astype(int))
    gathered = iterates(map_, states[sample], CLOUD)
    clouds: dict[int, np.ndarray] = {}  # of the first run of each group
    which = np.full(count, -1)
    for k, run in enumerate(sample):
        cloud = map_.section(gathered[:, k])
        if np.all(np.isfinite(cloud)):
            known = (g for g, other in enumerate(clouds.values()) if same_set(cloud, other))
            which[run] = next(known, len(clouds))
            if which[run] == len(clouds):
                clouds[k] = cloud
    others = np.setdiff1d(np.arange(count), sample)
    short = map_.section(iterates(map_, states[others], FEW))
    for k, run in enumerate(others):
        if np.all(np.isfinite(short[:, k])):
            which[run] = next((g for g, cloud in enumerate(clouds.values()) if within_set(short[:, k], cloud)), -1)
    later = (iterates(map_, gathered[-1, head : head + 1], EXPONENT_PERIODS) for head in clouds)
    classes = [class_of_iterates(map_, path[:, 0]) for path in later]
    return classes, [np.flatnonzero(which == g) for g in range(len(clouds))]


def _twins(map_: StroboscopicMap, motions: list[MotionClass]) -> list[int | None]:
    """Index of the mirror-image solution of each motion, its own where it is symmetric; None where it is missing."""
    if not map_.system.mirrored:
        return [None] * len(motions)
    points = {k: orbit_points(map_, motion.orbit) for k, motion in enumerate(motions) if motion.orbit is not None}
    starts = {k: list(motion.state.values()) for k, motion in enumerate(motions) if motion.orbit is None}
    # many iterates of each aperiodic motion [periods, states]
    clouds = {k: iterates(map_, np.array([y]), CLOUD)[:, 0] for k, y in starts.items()}
    twins: list[int | None] = []
    for k, motion in enumerate(motions):
        if motion.symmetric:
            twins.append(k)
        elif k in points:
            image = mirrored_points(map_, points[k])
            place = None if image is None else nearest(image, list(points.values()))
            twins.append(None if place is None else list(points)[place])
        else:
            image = mirrored_cloud(map_, clouds[k])
            twins.append(next((j for j in clouds if j != k and same_set(image, map_.section(clouds[j]))), None))
    return twins
