"""A closed cycle of a contact: a velocity that repeats, and internal states that return to where they began.

`searched_cycle` looks for one that creates energy where chatter at a frozen state does not tell all: laws with several
internal states, or with pieces, may create energy only while their states move.
"""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from vibrocap.laboratory.driven import driven_force
from vibrocap.laboratory.recorded_law import RecordedLaw

Numbers = Sequence[float] | np.ndarray
POINTS = 64  # per level of the velocity, of the arrays that are handed out
CLOSED = 1e-8  # over the natural size of an internal state: how exactly a cycle returns
PROBE = 1e-5  # over the natural size: of the differences that make the Jacobian of the map
MOST_SWITCHES = 100  # within one level
PLAIN, TURNS = 2, 12  # turns towards a cycle that closes: plain ones first, then Newton steps


@dataclasses.dataclass(frozen=True, eq=False)
class Cycle:
    """One period of a motion under piecewise constant velocity, after which the contact is as it was.

    time, velocity, force [n]; internal [n, states], with both sides of every jump of the velocity
    energy: taken by the contact over the cycle, the integral of R v; negative: given
    share: energy over the integral of |R v|, from -1 (all power comes out of the contact) to 1
    closure: largest difference of an internal state over the cycle, over its natural size
    """

    time: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    internal: np.ndarray
    energy: float
    share: float
    closure: float

    @property
    def period(self) -> float:
        return float(self.time[-1])

    @property
    def fastest(self) -> float:
        return float(np.max(np.abs(self.velocity)))


def closed_cycle(
    recorded: RecordedLaw, levels: Numbers, durations: Numbers, start: Numbers, scales: Numbers
) -> Cycle | None:
    """The cycle of a law under levels of velocity held for the given durations, from a guess of its internal states.

    They follow by SciPy's LSODA at 1e-10; those in which the cycle closes by repetition, then by Newton's method on the
    map over one period. None where it does not close, or is not finite.

    levels, durations [levels]   start, scales [states]: the guess, and the natural size of each internal state
    """
    state, size = np.array(start, dtype=float), np.asarray(scales, dtype=float)
    for attempt in range(TURNS):
        turned = _turn(recorded, levels, durations, state, size)
        if turned is None:
            return None
        miss = (turned[-1].internal[-1] - state) / size
        closure = float(np.max(np.abs(miss), initial=0.0))
        if closure <= CLOSED:
            return _cycle(turned, closure)
        step = miss * size if attempt < PLAIN else _newton_step(recorded, levels, durations, state, size, miss)
        state = state + step
    return None


@dataclasses.dataclass(frozen=True, eq=False)
class _Stretch:
    """What happens at one level: time [n], velocity, force [n], internal [n, states], energy and integral of |R v|."""

    time: np.ndarray
    velocity: float
    force: np.ndarray
    internal: np.ndarray
    energy: float
    magnitude: float


def _turn(recorded, levels, durations, state, size) -> list[_Stretch] | None:
    """One period from a state; None where something is not finite."""
    side = next((math.copysign(1.0, v) for v in reversed(levels) if v), 1.0)
    now, stretches = 0.0, []
    for velocity, duration in zip(levels, durations, strict=True):
        if velocity * side < 0.0:
            side = -side
            state = recorded.turned(state, -side, side)
        stretch = _stretch(recorded, velocity, side, state, size, now, duration)
        if stretch is None:
            return None
        stretches.append(stretch)
        state, now = stretch.internal[-1], now + duration
    return stretches


def _stretch(recorded, velocity, side, state, size, now, duration) -> _Stretch | None:
    """Internal states under a constant velocity, switch after switch."""
    from scipy.integrate import solve_ivp

    states, load, law = len(state), recorded.load, recorded.law

    def rates(_t, y):
        force, internal = law.force(velocity, tuple(y[:states].tolist()), side, load)
        return [*internal, force * velocity, abs(force * velocity)]

    def guard(which):
        def value(_t, y):
            return law.switches(velocity, tuple(y[:states].tolist()), side, load)[which]

        vars(value).update(terminal=True, direction=-1)
        return value

    guards = [guard(which) for which in range(len(recorded.switches))]
    forces = recorded.values([recorded.force], velocity, np.array([state, size, -size]).T, side)
    energy_size = np.nanmax(np.abs(forces), initial=1e-300) * abs(velocity) * duration + 1e-300
    small = 1e-12 * np.append(size, [energy_size] * 2)
    t, y = [], []
    start, before = 0.0, np.append(state, (0.0, 0.0))
    for _ in range(MOST_SWITCHES):
        before[:states] = recorded.settled_pieces(velocity, before[:states], side)
        if not np.all(np.isfinite(before)):
            return None
        grid = np.linspace(start, duration, POINTS)
        solution = solve_ivp(rates, (start, duration), before, "LSODA", grid, events=guards, rtol=1e-10, atol=small)
        if solution.status < 0 or not np.all(np.isfinite(solution.y)):
            return None
        t.append(solution.t)
        y.append(solution.y.T)
        if solution.status == 0:
            break
        which = next(i for i, times in enumerate(solution.t_events) if len(times))
        start, before = float(solution.t_events[which][0]), solution.y_events[which][0].copy()
        before[:states] = recorded.values(recorded.after_switch[which], velocity, before[:states], side)
    else:
        return None
    times, values = np.concatenate(t), np.concatenate(y)
    internal = values[:, :states]
    force = recorded.values([recorded.force], velocity, internal.T, side)[0]
    energy, magnitude = map(float, values[-1, states:])
    return _Stretch(now + times, velocity, np.broadcast_to(force, times.shape), internal, energy, magnitude)


def _newton_step(recorded, levels, durations, state, size, miss) -> np.ndarray:
    """Step towards the state that the map over one period leaves as it is, from differences of that map."""
    moving = recorded.continuous
    matrix = np.empty((len(moving), len(moving)))
    for column, j in enumerate(moving):
        probe = state.copy()
        probe[j] += PROBE * size[j]
        turned = _turn(recorded, levels, durations, probe, size)
        if turned is None:
            return miss * size
        matrix[:, column] = (((turned[-1].internal[-1] - probe) / size - miss) / PROBE)[moving]
    step = miss * size
    step[moving] = size[moving] * np.clip(np.linalg.lstsq(matrix, -miss[moving], rcond=1e-9)[0], -0.5, 0.5)
    return step


def _cycle(turned: list[_Stretch], closure: float) -> Cycle:
    energy = sum(stretch.energy for stretch in turned)
    magnitude = sum(stretch.magnitude for stretch in turned)
    rows = [(part.time, np.full(len(part.time), part.velocity), part.force, part.internal) for part in turned]
    time, velocity, force, internal = map(np.concatenate, zip(*rows, strict=True))
    return Cycle(time, velocity, force, internal, energy, energy / magnitude if magnitude > 0.0 else 0.0, closure)


LEVELS = 4  # of a cycle: there, any, back, any
PERIODS = 3  # turns that a cycle is given to close
# Samples of a level, as shares of it, close at its beginning, where most happens; the first is the end of the jump.
GRID = np.concatenate(([1e-6], np.geomspace(1e-3, 1.0, 12)))
OPEN = 10.0  # weight of what is missing to close, against the share of energy
DURATIONS = (-3.0, 1.5)  # of a level, decades of the times in which the internal states change at its speed
GENERATIONS, POPULATION = 40, 16
TOLERANCE = 1e-6


def searched_cycle(
    recorded: RecordedLaw, slowest: float, fastest: float, sizes: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(levels, durations, internal states at the start) of the cycle with the least share of energy that was found.

    slowest, fastest: bounds of the speeds   sizes [states]: natural sizes of the internal states
    The same random numbers every time.
    """
    from scipy.optimize import differential_evolution

    def objective(unknown: np.ndarray) -> float:
        return _share(recorded, *_candidate(recorded, unknown, slowest, fastest, sizes), sizes)[0]

    bounds = [(-1.0, 1.0)] * LEVELS + [DURATIONS] * (LEVELS - 1)
    best = differential_evolution(
        objective, bounds, popsize=POPULATION, maxiter=GENERATIONS, rng=20, polish=False, tol=0.0
    )
    levels, durations = _candidate(recorded, best.x, slowest, fastest, sizes)
    return levels, durations, _share(recorded, levels, durations, sizes)[1]


def _candidate(recorded, unknown, slowest, fastest, sizes) -> tuple[np.ndarray, np.ndarray]:
    """Levels and durations [levels] of an encoded cycle.

    A level is a direction and the logarithm of a speed, a duration the logarithm of times of change at that speed. The
    third level runs against the first, for as long as it takes to be back in the end (at least a thousandth of that).
    """
    place = unknown[:LEVELS].copy()
    place[2] = -np.copysign(place[2], place[0])
    levels = np.copysign(slowest * (fastest / slowest) ** np.abs(place), place)
    quickness = recorded.quickness(levels, np.zeros((len(recorded.rates), LEVELS)), np.copysign(1.0, place), sizes)
    durations = 10.0 ** np.insert(unknown[LEVELS:], 2, DURATIONS[0]) / quickness
    others = [0, 1, 3]
    durations[2] = max(durations[2], -(levels[others] @ durations[others]) / levels[2])
    return levels, durations


def _share(recorded, levels, durations, sizes) -> tuple[float, np.ndarray]:
    """Share of energy in the last turn of a cycle, plus a penalty where it does not close, and the state at its start.

    The jumps of the velocity take a millionth of the level that begins.
    """
    starts = np.concatenate(([0.0], np.cumsum(np.tile(durations, PERIODS))))
    time = (starts[:-1, None] + np.tile(durations, PERIODS)[:, None] * GRID).ravel()
    velocity = np.repeat(np.tile(levels, PERIODS), len(GRID))
    driven = driven_force(recorded.law, time, velocity, load=recorded.load, tolerance=TOLERANCE)
    if not driven.status.ok:
        return math.inf, np.zeros(len(sizes))
    turn = slice(-1 - LEVELS * len(GRID), None)
    power = driven.force[turn] * velocity[turn]
    spans = np.diff(time[turn])
    energy = 0.5 * float(spans @ (power[1:] + power[:-1]))
    magnitude = 0.5 * float(spans @ (np.abs(power[1:]) + np.abs(power[:-1])))
    start = driven.internal[turn][0]
    miss = float(np.max(np.abs(driven.internal[-1] - start) / sizes))
    return energy / max(magnitude, 1e-300) + OPEN * miss, start
