"""Settling runs: the map iterated from many starts until motions repeat, and the orbits that they lead to."""

import dataclasses
from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.motion.evidence import certified
from vibrocap.numerics.api import Budget, codes, device
from vibrocap.orbits.closing.periodic_solution import OrbitStatus, PeriodicSolution
from vibrocap.orbits.closing.shooting import closed, shortest, unclosed
from vibrocap.orbits.maps.stroboscopic_map import MOST_EVENTS, StroboscopicMap, in_rows, state_vector

SETTLED = 1e-6  # distance to the steady motion, over natural sizes, at which a run has settled
ROUGH = 1e-9  # tolerance of these runs
MOST_STEPS = 10**9


@dataclasses.dataclass(frozen=True)
class SettlingRuns:
    """Where runs ended, arrays [runs, ...].

    state: [runs, states] at the start of a drive period, or of a system that nothing drives in time at a return to rest
        of a contact; ended: numbers of `numerics/kernel/codes.py`
    response_period: drive periods, or returns of a cycle; 0 where it did not settle
    drift: change of the cyclic coordinate per drive period, over the last response; NaN where it did not settle
    certified: whether the evidence of the last response, or else of the last drive period, is within the bounds of a
        certificate, see `motion.evidence`
    """

    state: np.ndarray
    ended: np.ndarray
    response_period: np.ndarray
    drift: np.ndarray
    certified: np.ndarray

    @property
    def finished(self) -> np.ndarray:
        return self.ended == codes.DONE

    def some(self, runs: np.ndarray) -> "SettlingRuns":
        return SettlingRuns(**{field.name: getattr(self, field.name)[runs] for field in dataclasses.fields(self)})

    def replaced(self, runs: np.ndarray, others: "SettlingRuns") -> "SettlingRuns":
        """The runs, with others in place of the chosen ones."""
        columns = {field.name: getattr(self, field.name).copy() for field in dataclasses.fields(self)}
        for name, column in columns.items():
            column[runs] = getattr(others, name)
        return SettlingRuns(**columns)


def settling_runs(
    map_: StroboscopicMap, states: np.ndarray, periods: int, *, progress: Callable[[float], None] | None = None
) -> SettlingRuns:
    """Run states [runs, states] until each settles, or for so many drive periods.

    progress: called now and then, from any thread, with the share begun
    """
    count, parameters = len(states), map_.parameters()
    how = {"window": 1, "threshold": SETTLED, "evidence": 1, "returns": not map_.equations.timed}
    budget = Budget(periods, ROUGH, MOST_EVENTS, MOST_STEPS, **how)
    parts = []
    chunk = device("cpu").chunk
    for base in range(0, count, chunk):
        part = slice(base, min(base + chunk, count))
        report = None if progress is None else lambda begun, base=base: progress((base + begun) / count)
        ends = map_.run(budget, states[part], parameters, progress=report)
        response = ends.response_period
        drift = np.full(len(response), np.nan)
        if map_.cyclic >= 0:
            gained = ends.state[:, map_.cyclic] - ends.start[:, map_.cyclic]
            over = np.maximum(response, 1).astype(float)
            if ends.layout.returns:
                turn = ends.entry("CYCLE_TIME")
                over = np.where(turn > 0.0, turn / map_.period(parameters), over)
            drift[response > 0] = (gained / over)[response > 0]
        good = certified(map_.equations, ends, in_rows(parameters, states[part]), ROUGH)
        parts.append((ends.state, ends.status, response, drift, good))
    return SettlingRuns(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def continued(
    map_: StroboscopicMap, runs: SettlingRuns, waiting: np.ndarray, longer: int, periods: int
) -> SettlingRuns:
    """The runs, of which the chosen ones went on: `longer` periods in any case, then until they settled."""
    budget = Budget(longer, ROUGH, MOST_EVENTS, MOST_STEPS, window=1)
    ends = map_.run(budget, runs.state[waiting], map_.parameters())
    later = settling_runs(map_, ends.state, periods)
    later.ended[:] = np.where(ends.finished, later.ended, ends.status)
    later.response_period[~later.finished] = 0
    return runs.replaced(waiting, later)


def iterates(map_: StroboscopicMap, states: np.ndarray, periods: int) -> np.ndarray:
    """States after 0, 1, ... drive periods [periods + 1, runs, states]; NaN after a run that could not be completed."""
    states_after = np.full((periods + 1, *states.shape), np.nan)
    states_after[0] = states
    running = np.all(np.isfinite(states), axis=1)
    for k in range(periods):
        if not running.any():
            break
        images = map_.images(states_after[k, running], map_.parameters(), 1, tangents=False)
        states_after[k + 1, running] = np.where(images.finished[:, None], images.state, np.nan)
        running[running] = images.finished
    return states_after


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
