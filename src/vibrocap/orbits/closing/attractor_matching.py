"""Which of many runs ended in the same motion: settled ones by their orbits, others by where their marks lie."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from vibrocap.orbits.closing.orbit import CLOSE_TO_CIRCLE, Orbit, OrbitStatus
from vibrocap.orbits.closing.shooting import closing, mapped, shoot
from vibrocap.orbits.closing.steady import SETTLED, shortest
from vibrocap.orbits.maps.settling_runs import LongRuns, continued, kept_states
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap

NEAR = 10.0 * SETTLED  # of an orbit, over natural sizes: a run that ends there has settled to it
SAME = 1e-8  # distance within which two orbits, each closed to rounding, are one
LONGER = (100, 1000)  # periods that a run goes on which came to rest near an unstable orbit, before it may settle again
ALIKE = 3.0  # spacings of the marks of one motion within which those of another lie, if both fill the same set


@dataclasses.dataclass(frozen=True)
class Told:
    """An orbit and its points at the marks, [response period, kept states], over natural sizes."""

    orbit: Orbit
    points: np.ndarray

    @property
    def trusted(self) -> bool:
        """Whether the orbit closed."""
        return self.orbit.status is OrbitStatus.CONVERGED

    @property
    def attracts(self) -> bool:
        """Whether no multiplier is outside the unit circle, as far as is known."""
        return not self.trusted or bool(np.max(np.abs(self.orbit.multipliers), initial=0.0) <= 1.0 + CLOSE_TO_CIRCLE)


def over_sizes(map_: StroboscopicMap, states: np.ndarray) -> np.ndarray:
    """States [..., states] over their natural sizes, without the cyclic coordinate."""
    kept = kept_states(map_)
    return states[..., kept] / map_.scales(map_.parameters())[kept]


def orbits_reached(
    map_: StroboscopicMap, runs: LongRuns, periods: int, most: int
) -> tuple[list[Told], np.ndarray, LongRuns]:
    """(orbits to which runs lead, index of that of each run [runs], the runs); -1: none that is told apart.

    A run that passes close to an unstable orbit looks settled for a while, since what it still moves is less than
    settling asks. Shooting tells, and such a run goes on until it has left; one that does not leave has not settled.
    """
    which = np.full(len(runs.state), -1)
    settled = np.flatnonzero(runs.response_period > 0)
    found, which[settled] = orbits_told_apart(map_, runs.state[settled], runs.response_period[settled], most)
    for longer in LONGER:
        caught = np.flatnonzero(np.isin(which, [k for k, each in enumerate(found) if not each.attracts]))
        if not len(caught):
            break
        runs = continued(map_, runs, caught, longer, periods)
        again = caught[runs.response_period[caught] > 0]
        which[caught] = -1
        found, which[again] = orbits_told_apart(
            map_, runs.state[again], runs.response_period[again], most + len(found), found
        )
    unstable = np.flatnonzero(np.isin(which, [k for k, each in enumerate(found) if not each.attracts]))
    runs.response_period[unstable] = 0
    which[unstable] = -1
    stable = [k for k, each in enumerate(found) if each.attracts]
    place = np.full(len(found) + 1, -1)
    place[stable] = np.arange(len(stable))
    return [found[k] for k in stable], place[which], runs


def orbits_told_apart(
    map_: StroboscopicMap,
    states: np.ndarray,
    response_period: np.ndarray,
    most: int,
    known: Sequence[Told] = (),
) -> tuple[list[Told], np.ndarray]:
    """(orbits to which settled runs lead, index of that of each run [runs]; -1: there are more than `most`).

    A motion of period n passes the mark in n states, and so does its image shifted by a drive period: all n are one
    orbit. One run of those near an orbit is shot; the others are within `NEAR` of one of its n points. Where shooting
    does not lead to an orbit near the run, the motion is known by where the run ended.

    known: orbits that were found before, which come first
    """
    ends = over_sizes(map_, states)
    found = list(known)
    away = np.full(len(states), np.inf)
    which = np.full(len(states), -1)
    for k, each in enumerate(found):
        distance = _distance(each.points, ends)
        nearer = (distance < away) & (distance <= NEAR)
        which[nearer], away[nearer] = k, distance[nearer]
    for _ in range(most):
        left = np.flatnonzero(away > NEAR)
        if not len(left):
            break
        run = left[0]
        each = _settled_orbit(map_, states[run], int(response_period[run]))
        if each is None or _distance(each.points, ends[run : run + 1])[0] > np.sqrt(SETTLED):
            each = Told(_as_it_is(map_, states[run], int(response_period[run])), ends[run : run + 1])
        same = [k for k, other in enumerate(found) if _same_orbit(each, other)]
        if same:
            which[run], away[run] = same[0], 0.0
            continue
        distance = _distance(each.points, ends)
        distance[run] = 0.0
        nearer = (distance < away) & (distance <= NEAR)
        which[nearer], away[nearer] = len(found), distance[nearer]
        found.append(each)
    return found, which


def mirrored_points(map_: StroboscopicMap, told: Told) -> np.ndarray | None:
    """Points of the mirror twin of an orbit; None without the half-period symmetry."""
    if told.orbit.mirrored_state is None:
        return None
    return _points(map_, np.array(list(told.orbit.mirrored_state.values())), told.orbit.response_period)


def nearest(points: np.ndarray, orbits: list[Told]) -> int | None:
    """The orbit that passes through points; None if there is none."""
    for k, other in enumerate(orbits):
        if len(other.points) == len(points) and _distance(other.points, points[:1])[0] <= NEAR:
            return k
    return None


def same_set(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two clouds of marks [marks, states] fill the same set, as far as so many marks can tell."""
    return _within(one, other) and _within(other, one)


def within_set(few: np.ndarray, cloud: np.ndarray) -> bool:
    """Whether some marks lie in the set that a cloud fills."""
    return _within(few, cloud)


def _within(marks: np.ndarray, cloud: np.ndarray) -> bool:
    from scipy.spatial import KDTree

    tree = KDTree(cloud)
    spacing = float(np.median(tree.query(cloud, k=2)[0][:, 1]))
    return float(np.median(tree.query(marks)[0])) <= max(ALIKE * spacing, NEAR)


def _settled_orbit(map_: StroboscopicMap, state: np.ndarray, periods: int) -> Told | None:
    """The orbit near the end of a settled run, over its shortest period; None where it does not close."""
    start = dict(zip(map_.system.state_names, map(float, state), strict=True))
    found = shoot(map_.system, start, periods, tolerance=map_.tolerance, map_=map_)
    if found.status is OrbitStatus.CONVERGED and periods > 1:
        found = shortest(found)
    if found.status is not OrbitStatus.CONVERGED:
        return None
    return Told(found, _points(map_, np.array(list(found.state.values())), found.response_period))


def _as_it_is(map_: StroboscopicMap, state: np.ndarray, periods: int) -> Orbit:
    """The record of a run that settled near no orbit that shooting finds."""

    return closing(map_, state, periods, OrbitStatus.NOT_CONVERGED)


def _points(map_: StroboscopicMap, state: np.ndarray, periods: int) -> np.ndarray:
    """An orbit at the marks of one response."""
    parameters = map_.parameters()
    states = [state]
    for _ in range(periods - 1):
        states.append(mapped(map_, states[-1], parameters, 1, False).state[0])
    return over_sizes(map_, np.array(states))


def _same_orbit(one: Told, other: Told) -> bool:
    """Whether two orbits are the same, begun at whichever mark."""
    limit = SAME if one.trusted and other.trusted else NEAR
    return len(one.points) == len(other.points) and bool(_distance(other.points, one.points[:1])[0] <= limit)


def _distance(points: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Distance of each end [runs, states] from the nearest of some points, the largest over the states."""
    nearest_yet = np.full(len(ends), np.inf)
    for point in points:
        np.minimum(nearest_yet, np.max(np.abs(ends - point), axis=1), out=nearest_yet)
    return nearest_yet
