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
LONGER = (100, 1000)  # periods that a run near an unstable orbit continues before it may settle again


@dataclasses.dataclass(frozen=True)
class OrbitPoints:
    """An orbit and its points at the starts of drive periods, [response period, kept states], over natural sizes."""

    orbit: PeriodicSolution
    points: np.ndarray

    @property
    def attracts(self) -> bool:
        """Whether no multiplier is outside the unit circle, as far as is known."""
        return not self.orbit.unstable


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
        if not len(caught := _caught(orbits, which)):
            break
        runs = continued(map_, runs, caught, longer, periods)
        again = caught[runs.response_period[caught] > 0]
        which[caught] = -1
        states, response = runs.state[again], runs.response_period[again]
        orbits, which[again] = distinct_orbits(map_, states, response, most + len(orbits), orbits)
    runs.response_period[_caught(orbits, which)] = 0
    return *selected(orbits, which, [k for k, orbit in enumerate(orbits) if orbit.attracts]), runs


def _caught(orbits: list[OrbitPoints], which: np.ndarray) -> np.ndarray:
    """Indices of the runs near orbits that do not attract."""
    return np.flatnonzero(np.isin(which, [k for k, orbit in enumerate(orbits) if not orbit.attracts]))


def selected(orbits: list[OrbitPoints], which: np.ndarray, kept: list[int]) -> tuple[list[OrbitPoints], np.ndarray]:
    """(some of the orbits, index of that of each run [runs]); -1: none of these."""
    place = np.full(len(orbits) + 1, -1)
    place[kept] = np.arange(len(kept))
    return [orbits[k] for k in kept], place[which]


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
    ends, orbits = map_.section(states), list(known)
    away, which = np.full(len(states), np.inf), np.full(len(states), -1)

    def label(k: int) -> None:
        """Give the runs near an orbit that are nearer to it than to any before."""
        distance = _distance(orbits[k].points, ends)
        nearer = (distance < away) & (distance <= NEAR)
        which[nearer], away[nearer] = k, distance[nearer]

    for k in range(len(orbits)):
        label(k)
    for _ in range(most):
        left = np.flatnonzero(away > NEAR)
        if not len(left):
            break
        run, response = left[0], int(response_period[left[0]])
        solution = shortest(map_, closed(map_, states[run], response))
        orbit = orbit_points(map_, solution) if solution.closes else None
        if orbit is None or _distance(orbit.points, ends[run : run + 1])[0] > np.sqrt(SETTLED):
            as_it_is = unclosed(map_, states[run], response, OrbitStatus.NOT_CONVERGED)
            orbit = OrbitPoints(as_it_is, ends[run : run + 1])
        same = [k for k, other in enumerate(orbits) if _same_orbit(orbit, other)]
        which[run], away[run] = [*same, len(orbits)][0], 0.0
        if not same:
            orbits.append(orbit)
            label(len(orbits) - 1)
    return orbits, which


def orbit_points(map_: StroboscopicMap, orbit: PeriodicSolution) -> OrbitPoints:
    """An orbit with its points."""
    return OrbitPoints(orbit, _points(map_, state_vector(map_.system, orbit.state), orbit.response_period))


def mirrored_points(map_: StroboscopicMap, known: OrbitPoints) -> np.ndarray | None:
    """Points of the mirror-image solution of an orbit; None without the half-period symmetry."""
    mirrored = known.orbit.mirrored_state
    return None if mirrored is None else _points(map_, state_vector(map_.system, mirrored), known.orbit.response_period)


def nearest(points: np.ndarray, orbits: list[OrbitPoints]) -> int | None:
    """The orbit that passes through points; None if there is none."""
    for k, other in enumerate(orbits):
        if len(other.points) == len(points) and _distance(other.points, points[:1])[0] <= NEAR:
            return k
    return None


def _points(map_: StroboscopicMap, state: np.ndarray, periods: int) -> np.ndarray:
    """The states of one response at the section."""
    rows, states = map_.parameters()[None], [state]
    for _ in range(periods - 1):
        states.append(map_.images(states[-1][None], rows).state[0])
    return map_.section(np.array(states))


def _same_orbit(one: OrbitPoints, other: OrbitPoints) -> bool:
    """Whether two orbits are the same, begun at whichever drive period."""
    limit = SAME_ORBIT if one.orbit.closes and other.orbit.closes else NEAR
    return len(one.points) == len(other.points) and bool(_distance(other.points, one.points[:1])[0] <= limit)


def _distance(points: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Distance of each end [runs, states] from the nearest of some points, the largest over the states."""
    nearest_yet = np.full(len(ends), np.inf)
    for point in points:
        np.minimum(nearest_yet, np.max(np.abs(ends - point), axis=1), out=nearest_yet)
    return nearest_yet
