"""What a motion becomes: periodic modulo its drift, quasi-periodic or chaotic, with the numbers that decided it."""

import dataclasses
import math
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.measures.recorded.settling import stroboscopic_states
from vibrocap.motion.simulate import STATUSES, check_run, initial_state, simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.orbits.attractors.lyapunov import BATCHES, LyapunovExponents, exponents
from vibrocap.orbits.attractors.without_clock import LOOKED_AT, settled_without_clock
from vibrocap.orbits.closing.attractor_matching import NEAR, orbits_reached
from vibrocap.orbits.closing.autonomous_orbit import comes_to_rest
from vibrocap.orbits.closing.orbit import Orbit
from vibrocap.orbits.closing.periodic_solution import OrbitStatus, PeriodicSolution
from vibrocap.orbits.closing.shooting import closed, shortest
from vibrocap.orbits.equilibria.equilibrium import Equilibrium
from vibrocap.orbits.maps.settling_runs import iterates, settling_runs
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, is_driven, named_states, state_vector
from vibrocap.orbits.walk.residual import CLOSE_TO_CIRCLE
from vibrocap.physics.system import System
from vibrocap.quantities.declared import ByName, Length, Number, States
from vibrocap.quantities.dimensional import Dimensional

FREQUENCIES = 100
LOWEST, HIGHEST = math.pi / 5, 4 * math.pi / 5  # of c: farther out resonances are frequent
SHARE = 0.1  # of the series, the longest lag
FEWEST = 200  # values; Gottwald and Melbourne advise a thousand or more
CONSTANT = 1e-9  # extent over the largest value, below which a series stands still


@dataclasses.dataclass(frozen=True)
class ZeroOneTest:
    """Result of the 0-1 test: `value` near 1 is chaos, near 0 a periodic or quasi-periodic motion.

    value: median of `correlations`, one per frequency c in `frequencies` (radians per sample); samples: values used
    """

    value: float
    correlations: np.ndarray
    frequencies: np.ndarray
    samples: int


def zero_one_test(series: Any, *, frequencies: int = FREQUENCIES, seed: int = 0) -> ZeroOneTest:
    """The 0-1 test of Gottwald and Melbourne (SIAM J. Appl. Dyn. Syst. 8, 129-145, 2009), by correlation.

    The series phi drives a point in the plane, which wanders off as by chance if the series is chaotic and stays within
    bounds if it is regular:

        p(n) + i q(n) = sum_{j<=n} phi(j) exp(i j c)
        M(n) = mean_j |(p, q)(j + n) - (p, q)(j)|^2,   n <= N/10
        D(n) = M(n) - <phi>^2 (1 - cos n c)/(1 - cos c)           the modified mean-square displacement
        K(c) = correlation of D(n) with n;   the result is the median of K over c from (pi/5, 4 pi/5)

    series: [N] values, one per period (a finely sampled signal looks regular), or a `Trajectory`, of which the state at
        the section that varies most is taken, over its natural size, in the last half of the motion
    A series that stands still has K = 0. Weak chaos and slow transients need many values; noise counts as chaos.
    Returns `ZeroOneTest`. Raises ValueError for fewer than 200 values or what is no series of finite numbers.
    """
    phi = _values(series)
    check_whole("frequencies", frequencies, 1)
    count = len(phi)
    c = np.sort(np.random.default_rng(seed).uniform(LOWEST, HIGHEST, frequencies))
    if np.ptp(phi) <= CONSTANT * np.max(np.abs(phi)):
        return ZeroOneTest(0.0, np.zeros(frequencies), c, count)
    lags = np.arange(1, int(SHARE * count) + 1)
    displacement = np.stack([_displacement(phi, frequency, len(lags)) for frequency in c])
    swinging = np.mean(phi) ** 2 * (1.0 - np.cos(lags * c[:, None])) / (1.0 - np.cos(c[:, None]))
    correlations = _correlations(displacement - swinging, lags)
    return ZeroOneTest(float(np.median(correlations)), correlations, c, count)


def _values(series: Any) -> np.ndarray:
    if isinstance(series, Trajectory):
        states = stroboscopic_states(series)
        states = states[len(states) // 2 :]
        series = states[:, np.argmax(np.ptp(states, axis=0))] if len(states) else states.ravel()
    try:
        phi = np.asarray(series, dtype=float)
    except (TypeError, ValueError):
        raise ArgumentError("series", f"should be numbers, one per period, or a motion, got {series!r}") from None
    if phi.ndim != 1 or len(phi) < FEWEST:
        why = f"should be at least {FEWEST} numbers in a row, got an array of shape {phi.shape}"
        raise ArgumentError("series", why)
    if not np.all(np.isfinite(phi)):
        why = f"should be finite, got {phi[~np.isfinite(phi)][0]} at {np.argmin(np.isfinite(phi))}"
        raise ArgumentError("series", why)
    return phi


def _displacement(phi: np.ndarray, c: float, longest: int) -> np.ndarray:
    """M(n) for n = 1 ... longest, each a mean over the same number of j."""
    count = len(phi)
    z = np.cumsum(phi * np.exp(1j * c * np.arange(1, count + 1)))
    used = count - longest
    size = 1 << (2 * count - 1).bit_length()
    first = np.where(np.arange(count) < used, z, 0.0)
    products = np.fft.ifft(np.conj(np.fft.fft(first, size)) * np.fft.fft(z, size))[1 : longest + 1]
    squares = np.concatenate(([0.0], np.cumsum(np.abs(z) ** 2)))
    later = squares[used + 1 : used + longest + 1] - squares[1 : longest + 1]
    return (later + squares[used] - 2.0 * products.real) / used


def _correlations(rows: np.ndarray, lags: np.ndarray) -> np.ndarray:
    """Correlation of each row with the lags; 0 for a row that does not vary."""
    rows = rows - rows.mean(axis=1, keepdims=True)
    ramp = lags - lags.mean()
    spread = np.sqrt(np.sum(rows**2, axis=1) * np.sum(ramp**2))
    return np.divide(rows @ ramp, spread, out=np.zeros(len(rows)), where=spread > 0.0)


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
    """Class of a motion that settled to an orbit."""
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
