"""Attractor matching: which settled runs ended on the same orbit, begun at whichever drive period."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from vibrocap.orbits.closing.periodic_solution import OrbitStatus, PeriodicSolution
from vibrocap.orbits.closing.shooting import closed, shortest, unclosed
from vibrocap.orbits.maps.settling_runs import SETTLED, SettlingRuns, continued
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, state_vector

NEAR = 10.0 * SETTLED  # of an orbit, over natural sizes: a run that ends there has settled to it
SAME_ORBIT = 1e-8  # distance within which two orbits, each closed to rounding, are one
LONGER = (
    100,
    1000,
)  # periods that a run near an unstable orbit continues before it may settle again


@dataclasses.dataclass(frozen=True)
class OrbitPoints:
    """An orbit and its points at the starts of drive periods, [response period, kept states], over natural sizes."""

    orbit: PeriodicSolution
    points: np.ndarray

    @property
    def closed_exactly(self) -> bool:
        """Whether the orbit closed."""
        return self.orbit.closes

    @property
    def attracts(self) -> bool:
        """Whether no multiplier is outside the unit circle, as far as is known."""
        return not (self.closed_exactly and self.orbit.unstable)


def orbits_reached(
    map_: StroboscopicMap, runs: SettlingRuns, periods: int, most: int
) -> tuple[list[OrbitPoints], np.ndarray, SettlingRuns]:
    """(orbits to which runs lead, index of that of each run [runs], the runs); -1: none that is known.

    A run that passes close to an unstable orbit looks settled for a while, since what it still moves is less than
    settling asks. Shooting tells, and such a run goes on until it has left; one that does not leave has not settled.
    """
    which = np.full(len(runs.state), -1)
    settled = np.flatnonzero(runs.response_period > 0)
    orbits, which[settled] = distinct_orbits(map_, runs.state[settled], runs.response_period[settled], most)
    for longer in LONGER:
        caught = np.flatnonzero(np.isin(which, [k for k, orbit in enumerate(orbits) if not orbit.attracts]))
        if not len(caught):
            break
        runs = continued(map_, runs, caught, longer, periods)
        again = caught[runs.response_period[caught] > 0]
        which[caught] = -1
        orbits, which[again] = distinct_orbits(
            map_, runs.state[again], runs.response_period[again], most + len(orbits), orbits
        )
    unstable = np.flatnonzero(np.isin(which, [k for k, orbit in enumerate(orbits) if not orbit.attracts]))
    runs.response_period[unstable] = 0
    which[unstable] = -1
    stable = [k for k, orbit in enumerate(orbits) if orbit.attracts]
    place = np.full(len(orbits) + 1, -1)
    place[stable] = np.arange(len(stable))
    return [orbits[k] for k in stable], place[which], runs


def distinct_orbits(
    map_: StroboscopicMap,
    states: np.ndarray,
    response_period: np.ndarray,
    most: int,
    known: Sequence[OrbitPoints] = (),
) -> tuple[list[OrbitPoints], np.ndarray]:
    """(orbits to which settled runs lead, index of that of each run [runs]; -1: there are more than `most`).

    A motion of period n passes the section in n states, and so does its image shifted by a drive period: all n are one
    orbit. One run of those near an orbit is shot; the others are within `NEAR` of one of its n points. Where shooting
    does not lead to an orbit near the run, the motion is known by where the run ended.

    known: orbits that were found before, which come first
    """
    ends = map_.section(states)
    orbits = list(known)
    away = np.full(len(states), np.inf)
    which = np.full(len(states), -1)
    for k, orbit in enumerate(orbits):
        distance = _distance(orbit.points, ends)
        nearer = (distance < away) & (distance <= NEAR)
        which[nearer], away[nearer] = k, distance[nearer]
    for _ in range(most):
        left = np.flatnonzero(away > NEAR)
        if not len(left):
            break
        run = left[0]
        orbit = _settled_orbit(map_, states[run], int(response_period[run]))
        if orbit is None or _distance(orbit.points, ends[run : run + 1])[0] > np.sqrt(SETTLED):
            as_it_is = unclosed(map_, states[run], int(response_period[run]), OrbitStatus.NOT_CONVERGED)
            orbit = OrbitPoints(as_it_is, ends[run : run + 1])
        same = [k for k, other in enumerate(orbits) if _same_orbit(orbit, other)]
        if same:
            which[run], away[run] = same[0], 0.0
            continue
        distance = _distance(orbit.points, ends)
        distance[run] = 0.0
        nearer = (distance < away) & (distance <= NEAR)
        which[nearer], away[nearer] = len(orbits), distance[nearer]
        orbits.append(orbit)
    return orbits, which


def orbit_points(map_: StroboscopicMap, orbit: PeriodicSolution) -> OrbitPoints:
    """An orbit with its points."""
    return OrbitPoints(orbit, _points(map_, state_vector(map_.system, orbit.state), orbit.response_period))


def mirrored_points(map_: StroboscopicMap, found: OrbitPoints) -> np.ndarray | None:
    """Points of the mirror twin of an orbit; None without the half-period symmetry."""
    if found.orbit.mirrored_state is None:
        return None
    return _points(map_, state_vector(map_.system, found.orbit.mirrored_state), found.orbit.response_period)


def nearest(points: np.ndarray, orbits: list[OrbitPoints]) -> int | None:
    """The orbit that passes through points; None if there is none."""
    for k, other in enumerate(orbits):
        if len(other.points) == len(points) and _distance(other.points, points[:1])[0] <= NEAR:
            return k
    return None


def _settled_orbit(map_: StroboscopicMap, state: np.ndarray, periods: int) -> OrbitPoints | None:
    """The orbit near the end of a settled run, over its shortest period; None where it does not close."""
    orbits = shortest(map_, closed(map_, state, periods))
    return orbit_points(map_, orbits) if orbits.closes else None


def _points(map_: StroboscopicMap, state: np.ndarray, periods: int) -> np.ndarray:
    """The states of one response at the section."""
    parameters = map_.parameters()
    states = [state]
    for _ in range(periods - 1):
        states.append(map_.images(states[-1][None], parameters[None]).state[0])
    return map_.section(np.array(states))


def _same_orbit(one: OrbitPoints, other: OrbitPoints) -> bool:
    """Whether two orbits are the same, begun at whichever drive period."""
    limit = SAME_ORBIT if one.closed_exactly and other.closed_exactly else NEAR
    return len(one.points) == len(other.points) and bool(_distance(other.points, one.points[:1])[0] <= limit)


def _distance(points: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Distance of each end [runs, states] from the nearest of some points, the largest over the states."""
    nearest_yet = np.full(len(ends), np.inf)
    for point in points:
        np.minimum(nearest_yet, np.max(np.abs(ends - point), axis=1), out=nearest_yet)
    return nearest_yet
