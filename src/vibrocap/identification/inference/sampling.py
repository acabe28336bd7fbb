"""Samples of a posterior: draws from the density of coordinates, by an ensemble of walkers.

Walkers move by differences of others (ter Braak 2006), which takes a third of the steps of stretches near a normal
density; the program is emcee (Foreman-Mackey et al. 2013).
"""

import dataclasses
import importlib
from collections.abc import Callable
from typing import Any

import numpy as np

from vibrocap.arguments import check_whole

WALKERS, LEAST = 3, 24  # walkers a coordinate, and in all
ENOUGH = 50  # correlation times, after which the length of a chain is known (Foreman-Mackey et al. 2013)
BURNT, BLOCK, LONGEST = 5, 100, 4000  # correlation times left out at first; steps between looks, and in all


@dataclasses.dataclass(frozen=True, eq=False)
class Chain:
    """draws [n, p] of coordinates; effective: independent ones among them; settled: whether it was long enough."""

    draws: np.ndarray
    effective: float
    settled: bool


def chain(
    density: Callable[[np.ndarray], np.ndarray],
    begin: np.ndarray,
    spread: np.ndarray,
    bounds: tuple[np.ndarray, np.ndarray],
    samples: int,
    seed: int,
    report: Callable[[float], None] | None = None,
) -> Chain:
    """Draws from exp(density(u)), density of rows [m, p], within bounds; reproducible by the seed.

    begin [p], spread [p, p]: where the walkers begin, and their covariance. Needs emcee (the extra `fit`).
    """
    emcee: Any = importlib.import_module("emcee")
    check_whole("samples", samples, 100)
    random = np.random.default_rng(seed)
    walkers = max(2 * (WALKERS * len(begin) // 2), LEAST)
    low, high = bounds
    values, vectors = np.linalg.eigh(spread)
    ball = begin + random.standard_normal((walkers, len(begin))) @ (vectors * np.sqrt(np.maximum(values, 0.0))).T
    room = 1e-3 * (high - low)
    state = emcee.State(
        np.clip(ball, low + room * random.random(ball.shape), high - room * random.random(ball.shape)),
        random_state=np.random.RandomState(seed).get_state(),
    )

    def inside(table: np.ndarray) -> np.ndarray:
        good = np.all((table >= low) & (table <= high), axis=1)
        densities = np.full(len(table), -np.inf)
        if good.any():
            densities[good] = density(table[good])
        return np.where(np.isnan(densities), -np.inf, densities)

    moves = [(emcee.moves.DEMove(), 0.8), (emcee.moves.DESnookerMove(), 0.2)]
    sampler = emcee.EnsembleSampler(walkers, len(begin), inside, moves=moves, vectorize=True)
    settled, steps, time = False, 0, float(BLOCK)
    while steps < LONGEST and not settled:
        state = sampler.run_mcmc(state, BLOCK, skip_initial_state_check=steps > 0)
        steps += BLOCK
        time = float(np.max(sampler.get_autocorr_time(tol=0)))
        kept = walkers * (steps - BURNT * time) / time
        settled = steps > ENOUGH * time and kept >= samples
        if report:
            report(min(steps / (ENOUGH * time), kept / samples, 1.0))
    draws = sampler.get_chain(discard=min(int(BURNT * time), steps // 2), flat=True)
    chosen = np.linspace(0, len(draws) - 1, min(samples, len(draws))).astype(int)
    effective = min(walkers * (steps - BURNT * time) / time, len(chosen))
    return Chain(random.permutation(draws[chosen]), max(float(effective), 0.0), settled)
