"""What motions become that nothing drives in time: equilibria, cycles, and what wanders.

Runs are looked at whole drive periods apart, of whatever length. One that has settled within the residue of an
equilibrium of the equations rests there; a set of rest is one attractor. The others are closed to cycles by their
returns, one run for each cycle: every other run on it is near a point of its path.
"""

import numpy as np

from vibrocap.motion.trust import RESIDUE
from vibrocap.orbits.closing.autonomous_orbit import autonomous_orbit
from vibrocap.orbits.closing.periodic_solution import PeriodicSolution, judged
from vibrocap.orbits.equilibria.equilibrium import Equilibrium, equilibria
from vibrocap.orbits.maps.settling_runs import SETTLED, SettlingRuns, settling_runs
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, state_vector

NEAR = RESIDUE * SETTLED  # of an equilibrium, over natural sizes
LONGER = 4
MOST_CYCLES = 32  # runs that are tried to be closed
LOOKED_AT = 200  # drive periods at most, from whose returns a cycle is guessed
SAME_PERIOD = 1e-8  # relative difference between the periods of one cycle, each closed to rounding
SAMPLES = 4096  # points of the path of a cycle
ON_CYCLE = 1e-3  # of its extents: runs that are so near to its path lead to it


Reached = list[Equilibrium | PeriodicSolution]


def settled_without_clock(
    map_: StroboscopicMap, runs: SettlingRuns, periods: int
) -> tuple[Reached, np.ndarray, SettlingRuns]:
    """(motions to which runs lead, index of that of each run [runs], the runs); -1: none that is known, or a failure.

    What neither rests nor closes goes on for `LONGER` times as many periods: it may still be on its way.
    """
    which = np.full(len(runs.state), -1)
    reached: Reached = []
    for longer in (0, LONGER):
        left = np.flatnonzero(runs.finished & (which < 0))
        if longer and len(left):
            runs = runs.replaced(left, settling_runs(map_, runs.state[left], longer * periods))
        _find_rests(map_, runs, which, reached)
        _find_cycles(map_, runs, which, reached, min(periods, LOOKED_AT))
    return reached, which, runs


def _find_rests(map_: StroboscopicMap, runs: SettlingRuns, which: np.ndarray, reached: Reached) -> None:
    """Label the runs that are at an equilibrium, adding those to what is reached."""
    resting = np.flatnonzero(runs.finished & (runs.response_period > 0) & (which < 0))
    known = {k: motion for k, motion in enumerate(reached) if isinstance(motion, Equilibrium)}
    for k, rest in known.items():
        which[resting[_belongs(map_, runs.state[resting], rest)]] = k
    for motion in () if known or not len(resting) else equilibria(map_.system):
        there = resting[_belongs(map_, runs.state[resting], motion) & (which[resting] < 0)]
        if len(there):
            which[there] = len(reached)
            reached.append(motion)


def _find_cycles(map_: StroboscopicMap, runs: SettlingRuns, which: np.ndarray, reached: Reached, periods: int) -> None:
    """Label the runs that are on a cycle, adding those to what is reached: one run of each is closed."""
    left = np.flatnonzero(runs.finished & (which < 0))
    for k, motion in enumerate(reached):
        if isinstance(motion, PeriodicSolution):
            on_it = _near_path(map_, motion, runs.state[left])
            which[left[on_it]] = k
            left = left[~on_it]
    for _ in range(MOST_CYCLES):
        if not len(left):
            break
        head, solution = left[0], autonomous_orbit(map_.system, runs.state[left[0]], periods, map_.tolerance)
        left = left[1:]
        if not solution.closes or solution.unstable:
            continue
        known = next((k for k, motion in enumerate(reached) if _same_cycle(map_, motion, solution)), len(reached))
        on_it = _near_path(map_, solution, runs.state[left])
        which[head] = which[left[on_it]] = known
        left = left[~on_it]
        if known == len(reached):
            reached.append(judged(solution))


def _belongs(map_: StroboscopicMap, states: np.ndarray, rest: Equilibrium) -> np.ndarray:
    """Which states [runs, states] lie within the extents of an equilibrium, but for travel and whole turns: [runs]."""
    system, sizes = map_.system, map_.scales(map_.parameters())
    least, most, middle = (np.array(list(named.values())) for named in (rest.least, rest.most, rest.state))
    turned = middle + map_.away(states, middle)
    inside = (turned >= least - NEAR * sizes) & (turned <= most + NEAR * sizes)
    kept = [i for i in map_.section_states if system.state_names[i] not in system.switched]
    return np.all(inside[:, kept], axis=1)


def _same_cycle(map_: StroboscopicMap, one: Equilibrium | PeriodicSolution, other: PeriodicSolution) -> bool:
    """Whether two cycles are one, begun at different places."""
    if not isinstance(one, PeriodicSolution) or abs(one.period - other.period) > SAME_PERIOD * other.period:
        return False
    return bool(_near_path(map_, one, state_vector(map_.system, other.state)[None])[0])


def _near_path(map_: StroboscopicMap, orbit: PeriodicSolution, states: np.ndarray) -> np.ndarray:
    """Which states [runs, states] are on the path of a cycle, as far as runs come near it."""
    from scipy.spatial import KDTree

    motion = orbit.motion()
    path = map_.section(motion.states(np.linspace(0.0, orbit.period, SAMPLES)).T)
    extents = np.ptp(path, axis=0)
    extents[extents == 0.0] = 1.0
    path, ends = path / extents, map_.section(states) / extents
    places = KDTree(path).query(ends)[1]
    away = np.full(len(ends), np.inf)
    for other in (-1, 1):  # the nearest point of either side that begins or ends at the nearest sample
        start, step = path[places], path[(places + other) % SAMPLES] - path[places]
        share = np.clip(np.sum((ends - start) * step, axis=1) / np.maximum(np.sum(step**2, axis=1), 1e-300), 0.0, 1.0)
        away = np.minimum(away, np.max(np.abs(start + share[:, None] * step - ends), axis=1))
    return away <= ON_CYCLE
