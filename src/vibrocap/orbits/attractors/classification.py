"""What a motion becomes: periodic modulo its drift, quasi-periodic or chaotic, with the numbers that decided it.

Where nothing drives the system in time, runs are looked at whole drive periods apart, of whatever length. One that has
settled within the residue of an equilibrium of the equations rests there; a set of rest is one attractor. The others
are closed to cycles by their returns, one run for each cycle: every other run on it is near a point of its path.
"""

import dataclasses
import math

import numpy as np

from vibrocap.arguments import check_whole
from vibrocap.motion.simulate import STATUSES, check_run, initial_state, simulate
from vibrocap.motion.trust import RESIDUE
from vibrocap.orbits.attractors.lyapunov import BATCHES, LyapunovExponents, ZeroOneTest, exponents, zero_one_test
from vibrocap.orbits.closing.autonomous_orbit import autonomous_orbit, comes_to_rest
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.orbits.closing.periodic_solution import OrbitStatus, PeriodicSolution, judged
from vibrocap.orbits.closing.settling_runs import NEAR, SETTLED, SettlingRuns, iterates, orbits_reached, settling_runs
from vibrocap.orbits.closing.shooting import closed, shortest
from vibrocap.orbits.equilibria.equilibrium import Equilibrium, equilibria
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, is_driven, named_states, state_vector
from vibrocap.orbits.walk.residual import CLOSE_TO_CIRCLE
from vibrocap.physics.system import System
from vibrocap.quantities.declared import ByName, Length, Number, States
from vibrocap.quantities.dimensional import Dimensional

SURE = 3.0  # errors by which an exponent, or a mean drift, differs from zero
REGULAR, CHAOTIC = 0.2, 0.8  # results of the 0-1 test below and above which it has decided
FAINT = 1e-3  # growth per drive period that counts as none, where the 0-1 test finds no chaos
LONGEST_PERIOD = 128  # of the periodic motions that are looked for where a run did not settle
RECURRENT = 1e-3  # distance over natural sizes from which such an orbit is shot
ALIKE = 3.0  # spacings of the states of one motion within which those of another lie, if both fill the same set
CLOUD = 512  # states that are compared with their mirror images


@dataclasses.dataclass(frozen=True)
class MotionClass(Dimensional):
    """What a motion has become, and why it is called so.

    kind: "period-1", "period-2", ...: repeats after so many drive periods up to a shift of the cyclic coordinate; of a
        system that nothing drives in time "cycle", or "steady sliding", "rest" and "partial rest" (equilibria);
        "quasi-periodic": two frequencies without a common period (a multiplier pair on the unit circle, or a largest
        Lyapunov exponent that is zero); "chaotic": a largest exponent above zero; "not settled": still on its way, or
        the numbers do not agree; "failed": a run could not be completed
    reason: the numbers that decided it, in words
    drift: change of the cyclic coordinate per drive period, of an aperiodic motion the mean over `lyapunov.periods`
        with the standard error `drift_error`; None without such a coordinate, or where it is not known
    symmetric: whether the motion is its own mirror image half a period later (an aperiodic one: whether it fills the
        same set); None where it has no such symmetry, or is not known
    winding: mean turns per drive period of each coordinate that turns, by name
    orbit: the orbit of a periodic motion; lyapunov, zero_one: of one that did not settle
    state: at the section, on the motion or on the way to it
    """

    kind: str
    reason: str
    drift: Length | None
    drift_error: Length
    symmetric: bool | None
    state: States
    orbit: Orbit | None = None
    lyapunov: LyapunovExponents | None = None
    zero_one: ZeroOneTest | None = None
    winding: dict[str, Number] = dataclasses.field(default_factory=dict)

    @property
    def response_period(self) -> int | None:
        """Drive periods after which the motion repeats; None where it does not, and of a cycle with its own period."""
        periods = 0 if self.orbit is None or self.kind == "quasi-periodic" else self.orbit.response_period
        return periods or None


def classify(
    system: System,
    initial: ByName | None = None,
    *,
    settle_periods: int = 2000,
    periods: int = 1000,
    tolerance: float = 1e-12,
    threads: int | None = None,
) -> MotionClass:
    """The kind of motion that an initial condition leads to.

    It is simulated until it settles, then closed by shooting: the response period and the multipliers decide. Where it
    does not settle within `settle_periods`, its largest Lyapunov exponent over `periods` more and the 0-1 test of its
    stroboscopic states have to agree; after a negative exponent orbits of up to 128 periods are searched.

    Where nothing drives the system in time, motions end at equilibria or on cycles with a period of their own.

    Raises ValueError naming the argument.
    """
    start = np.array(list(initial_state(system, initial).values()))
    check_whole("settle_periods", settle_periods, 10, 10**7)
    check_whole("periods", periods, 200, 10**6)
    check_run(periods=1, tolerance=tolerance, max_events_per_period=1, max_steps=1)
    map_ = StroboscopicMap(system, tolerance, threads)
    run = settling_runs(map_, start[None], settle_periods)
    if not is_driven(system):
        reached, which, run = settled_without_clock(map_, run, settle_periods)
        if which[0] >= 0:
            return class_of(reached[0])
        run.response_period[:] = 0
        if (limit := _rest_in_the_limit(system, initial, min(settle_periods, LOOKED_AT))) is not None:
            return limit
    orbits, _, run = orbits_reached(map_, run, settle_periods, 1)
    if not run.finished[0]:
        reason = f"the run did not go to its end: {STATUSES[int(run.ended[0])].text}"
        return MotionClass("failed", reason, None, math.nan, None, named_states(map_.system, run.state[0]))
    if run.response_period[0] > 0:
        return class_of_orbit(orbits[0].orbit)
    return class_of_iterates(map_, iterates(map_, run.state, periods)[:, 0])


def _rest_in_the_limit(system: System, initial: ByName | None, periods: int) -> MotionClass | None:
    """Class of a motion from a start that comes to rest by ever smaller stops; None where it does not."""
    motion = simulate(system, initial=initial, periods=periods)
    if not (motion.run_status.ok and comes_to_rest(motion)):
        return None
    drift = 0.0 if system.cyclic is not None else None
    reason = "it comes to rest in the limit, by stops that shrink by one share and grow longer by as much"
    return MotionClass("rest", reason, drift, 0.0, None, motion.state)


def class_of(reached: Equilibrium | PeriodicSolution) -> MotionClass:
    """Class of a motion that ended at an equilibrium, in a set of them, or on an orbit."""
    if isinstance(reached, PeriodicSolution):
        return class_of_orbit(reached)
    drift = None if reached.travel is None else reached.travel * reached.system.drive.period
    extent = f"one of a set of dimension {reached.dimension}; " if reached.dimension else ""
    reason = f"all rates vanish but that of travel; {extent}it is {reached.stability}"
    return MotionClass(reached.kind, reason, drift, 0.0, None, reached.state)


def class_of_orbit(orbit: PeriodicSolution) -> MotionClass:
    n = orbit.response_period or orbit.period / orbit.system.drive.period
    drift = None if orbit.drift is None else orbit.drift / n
    known: dict = {"drift": drift, "drift_error": 0.0, "symmetric": orbit.symmetric}
    known |= {"state": orbit.state, "orbit": Orbit.of(orbit)}
    known |= {"winding": {name: turns / n for name, turns in orbit.winding.items()}}
    if orbit.status is OrbitStatus.CONTRADICTED:
        return MotionClass("not settled", "an orbit closes, but runs beside it contradict its multipliers", **known)
    if not orbit.closes:
        reason = f"it settled, but no orbit closes there (residual {orbit.residual:.2g})"
        return MotionClass("not settled", reason, **known)
    largest = complex(orbit.multipliers[0]) if len(orbit.multipliers) else 0.0j
    size = abs(largest)
    if abs(size - 1.0) <= CLOSE_TO_CIRCLE and abs(largest.imag) > CLOSE_TO_CIRCLE:
        reason = f"the pair of multipliers {largest:.9f} is on the unit circle"
        return MotionClass("quasi-periodic", reason, **known)
    after = f"{n} drive periods" if orbit.response_period else "its period"
    reason = f"it closes after {after} to {orbit.residual:.2g}; largest multiplier {size:.9g}"
    if known["orbit"].status is OrbitStatus.NOT_CERTIFIED:
        reason += "; not certified: it is no motion of the equations"
    return MotionClass(f"period-{n}" if orbit.response_period else "cycle", reason, **known)


def class_of_iterates(map_: StroboscopicMap, states: np.ndarray) -> MotionClass:
    """Class of a motion that did not settle, from many iterates [periods, states]."""
    whole = np.all(np.isfinite(states), axis=1)
    finished, states = bool(whole.all()), states[whole]
    last = named_states(map_.system, states[-1])
    if not finished:
        return MotionClass("failed", f"the run failed after {len(states)} periods", None, math.nan, None, last)
    growth = exponents(map_, states[:-1], True)
    cloud = map_.section(states)
    widest = int(np.argmax(np.ptp(cloud, axis=0)))
    chaos = zero_one_test(cloud[:, widest])
    half = len(cloud) // 2
    kind, reason = _decided(growth, chaos, map_.period(map_.parameters()), same_set(cloud[:half], cloud[half:]))
    drift, error = _mean_drift(map_, states)
    clock, returns = is_driven(map_.system), kind == "not settled" and growth.value < 0.0
    if clock and returns and (orbit := _long_orbit(map_, states, cloud)) is not None:
        return class_of_orbit(orbit)
    symmetric, turns = None, map_.system.turns
    if clock and map_.system.mirrored and kind != "not settled":
        symmetric = same_set(cloud[-CLOUD:], mirrored_cloud(map_, states[-CLOUD:]))
    gained = (states[-1] - states[0]) / max(1, len(states) - 1)
    turned = {name: float(gained[map_.system.state_names.index(name)] / p) for name, p in turns.items()}
    return MotionClass(kind, reason, drift, error, symmetric, last, None, growth, chaos, turned)


def same_set(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two clouds of states [periods, states] fill the same set, as far as so many states can tell."""
    return within_set(one, other) and within_set(other, one)


def within_set(few: np.ndarray, cloud: np.ndarray) -> bool:
    """Whether some states lie in the set that a cloud fills."""
    from scipy.spatial import KDTree

    tree = KDTree(cloud)
    spacing = float(np.median(tree.query(cloud, k=2)[0][:, 1]))
    return float(np.median(tree.query(few)[0])) <= max(ALIKE * spacing, NEAR)


def mirrored_cloud(map_: StroboscopicMap, states: np.ndarray) -> np.ndarray:
    """Marks of the mirror image of a motion, over natural sizes."""
    return map_.section(map_.mirrored_half(states, map_.parameters(), tangents=False).state)


def _decided(growth: LyapunovExponents, chaos: ZeroOneTest, period: float, stays: bool) -> tuple[str, str]:
    """(kind, reason) by the largest exponent and the 0-1 test.

    stays: whether both halves of them fill the same set. A slow way to or from an orbit has a small exponent too
    """
    value, error = growth.value * period, growth.error * period
    exponent = f"largest Lyapunov exponent {value:.3g} +- {error:.1g} per drive period"
    numbers = f"{exponent} over {growth.periods} drive periods, 0-1 test {chaos.value:.3f}"
    if not stays:
        return "not settled", f"the second half of the iterates lies elsewhere than the first: {numbers}"
    if value > max(SURE * error, FAINT) and chaos.value > CHAOTIC:
        return "chaotic", numbers
    if abs(value) <= max(SURE * error, FAINT) and chaos.value < REGULAR and error <= 10.0 * FAINT:
        return "quasi-periodic", numbers
    if value < 0.0:
        return "not settled", f"neighbouring motions still approach it: {numbers}"
    return "not settled", f"these do not agree, or not yet: {numbers}"


def _long_orbit(map_: StroboscopicMap, states: np.ndarray, cloud: np.ndarray) -> PeriodicSolution | None:
    """A stable orbit of up to 128 periods near the end of a motion; None where there is none."""
    back = np.max(np.abs(cloud[-1] - cloud[-1 - LONGEST_PERIOD : -1][::-1]), axis=1)
    if not len(back) or np.min(back) > RECURRENT:
        return None
    n = int(np.flatnonzero(back <= max(2.0 * np.min(back), 1e-9))[0]) + 1
    orbit = closed(map_, states[-1], n)
    if not orbit.closes or not orbit.stable:
        return None
    near = np.max(np.abs(map_.section(state_vector(map_.system, orbit.state)) - cloud[-1])) <= 10.0 * RECURRENT
    return shortest(map_, orbit) if near else None


def _mean_drift(map_: StroboscopicMap, states: np.ndarray) -> tuple[float | None, float]:
    """(mean gain of the cyclic coordinate per period, its standard error from batch means)."""
    if map_.cyclic < 0:
        return None, math.nan
    gains = np.diff(states[:, map_.cyclic])
    batches = np.array([batch.mean() for batch in np.array_split(gains, min(BATCHES, len(gains)))])
    return float(gains.mean()), float(batches.std(ddof=1) / math.sqrt(len(batches)))


NEAR_EQUILIBRIUM = RESIDUE * SETTLED  # of an equilibrium, over natural sizes
MUCH_LONGER = 4
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
    for longer in (0, MUCH_LONGER):
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
    inside = (turned >= least - NEAR_EQUILIBRIUM * sizes) & (turned <= most + NEAR_EQUILIBRIUM * sizes)
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
