"""Search for a cycle that creates energy, where chatter at a frozen state does not tell all.

Laws with several internal states, or with pieces, may create energy only while their states move. The search is over
periodic velocities of four levels that lead back to where they began, by differential evolution on the driven law; what
it finds counts only after `closed_cycle` has closed and measured it.
"""

import math

import numpy as np

from vibrocap.laboratory.driven import driven_force
from vibrocap.laboratory.recorded_law import RecordedLaw

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
        return _share(recorded, *_cycle(recorded, unknown, slowest, fastest, sizes), sizes)[0]

    bounds = [(-1.0, 1.0)] * LEVELS + [DURATIONS] * (LEVELS - 1)
    best = differential_evolution(
        objective, bounds, popsize=POPULATION, maxiter=GENERATIONS, rng=20, polish=False, tol=0.0
    )
    levels, durations = _cycle(recorded, best.x, slowest, fastest, sizes)
    return levels, durations, _share(recorded, levels, durations, sizes)[1]


def _cycle(recorded, unknown, slowest, fastest, sizes) -> tuple[np.ndarray, np.ndarray]:
    """Levels and durations [levels] of an encoded cycle.

    A level is a direction and the logarithm of a speed, a duration the logarithm of times of change at that speed. The
    third level runs against the first, for as long as it takes to be back in the end (at least a thousandth of that).
    """
    place = unknown[:LEVELS].copy()
    place[2] = -np.copysign(place[2], place[0])
    levels = np.copysign(slowest * (fastest / slowest) ** np.abs(place), place)
    states, side = len(recorded.rates), np.copysign(1.0, place)
    rest = np.zeros((states, LEVELS))
    rate = recorded.values(recorded.rates, levels, rest, side)
    slope = recorded.values(recorded.rate_slopes, levels, rest, side).reshape(states, states + 1, LEVELS)[:, 1:]
    quickness = np.max(np.abs(slope), axis=(0, 1)) + np.max(np.abs(rate) / sizes[:, None], axis=0)
    durations = 10.0 ** np.insert(unknown[LEVELS:], 2, DURATIONS[0]) / np.maximum(quickness, 1e-300)
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
