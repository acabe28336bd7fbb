"""Samples of a posterior: draws from the density of coordinates, by an ensemble of walkers.

The density is exp(-cost/s^2) as in the profiles, with priors, flat in the coordinates of the search (logarithms of
positive parameters) within their bounds. Errors that are correlated count as their correlation times say: with tau_j of
coordinate j and T, the geometric mean of all,

    ln density(u) = -cost(u*)/(s^2 T),    u*_j = best_j + (u_j - best_j) sqrt(T/tau_j)

has the covariance of `uncertainty` where the fit is linear, and the shape of the cost elsewhere.

Walkers move by differences of others (ter Braak 2006), at times by a whole one, from mode to mode. Near a normal
density this takes a third of the steps of stretches; the program is emcee (Foreman-Mackey et al. 2013). Its snooker
moves are left out: they draw towards the mean, and deviations come out small.
"""

import importlib
from collections.abc import Callable
from typing import Any

import numpy as np

from vibrocap.arguments import check_whole

WALKERS, LEAST = 3, 24  # walkers a coordinate, and in all
ENOUGH = 50  # correlation times, after which the length of a chain is known (Foreman-Mackey et al. 2013)
BURNT, BLOCK, LONGEST = 5, 100, 4000  # correlation times left out at first; steps between looks, and in all


class Source:
    """What is sampled: the cost of coordinates about its minimum, and what follows from them.

    names: of the parameters; begin [p], spread [p, p]: the minimum and the covariance of the coordinates; bounds: of
    these; unit, inflation [p]: s^2 and the correlation times of `uncertainty`.
    """

    def __init__(
        self,
        names: tuple[str, ...],
        begin: np.ndarray,
        spread: np.ndarray,
        bounds: tuple[np.ndarray, np.ndarray],
        unit: float,
        inflation: np.ndarray,
    ):
        self.names, self.begin, self.spread, self.bounds = names, begin, spread, bounds
        self.time = float(np.exp(np.mean(np.log(inflation))))
        self.unit, self.near = unit, np.sqrt(self.time / inflation)

    def cost(self, table: np.ndarray) -> np.ndarray:
        """[m] at coordinates [m, p]."""
        raise NotImplementedError

    def values(self, table: np.ndarray) -> np.ndarray:
        """Parameters [m, p] at coordinates."""
        raise NotImplementedError

    def curve(self, table: np.ndarray, velocity: np.ndarray, load: float, section: str) -> np.ndarray:
        """Steady friction [m, k] at velocities [k]; section: of the law in a case."""
        raise NotImplementedError

    def record(self, name: str, table: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
        """(time [n], predictions [m, n], standard deviation of a measurement about them) of a record."""
        raise NotImplementedError

    def density(self, table: np.ndarray) -> np.ndarray:
        """Logarithm [m] at coordinates [m, p] within the bounds; -inf elsewhere."""
        good = np.all((table >= self.bounds[0]) & (table <= self.bounds[1]), axis=1)
        densities = np.full(len(table), -np.inf)
        if good.any():
            near = self.begin + (table[good] - self.begin) * self.near
            densities[good] = -self.cost(near) / (self.unit * self.time)
        return np.where(np.isnan(densities), -np.inf, densities)


def chain(
    source: Source, samples: int, seed: int, report: Callable[[float], None] | None = None
) -> tuple[np.ndarray, float, bool]:
    """(draws [n, p] of coordinates, independent ones among them, whether it was long enough); reproducible by the seed.

    Needs emcee (the extra `fit`).
    """
    emcee: Any = importlib.import_module("emcee")
    check_whole("samples", samples, 100)
    random, begin, (low, high) = np.random.default_rng(seed), source.begin, source.bounds
    walkers = max(2 * (WALKERS * len(begin) // 2), LEAST)
    deviation = np.sqrt(np.diag(source.spread))
    ball = normal_draws(source.spread / np.outer(deviation, deviation), random.standard_normal((walkers, len(begin))))
    ball = begin + np.minimum(deviation, high - low) * ball  # what the data leave open fills its bounds
    room = 1e-3 * (high - low)
    state = emcee.State(
        np.clip(ball, low + room * random.random(ball.shape), high - room * random.random(ball.shape)),
        random_state=np.random.RandomState(seed).get_state(),
    )

    moves = [(emcee.moves.DEMove(), 0.9), (emcee.moves.DEMove(gamma0=1.0), 0.1)]
    sampler = emcee.EnsembleSampler(walkers, len(begin), source.density, moves=moves, vectorize=True)
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
    even = np.linspace(0, len(draws) - 1, min(samples, len(draws))).astype(int)
    effective = min(walkers * (steps - BURNT * time) / time, len(even))
    return random.permutation(draws[even]), max(float(effective), 0.0), settled


def normal_draws(covariance: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Independent normal numbers [m, p] as numbers of a covariance [p, p]."""
    values, vectors = np.linalg.eigh(covariance)
    return normal @ (vectors * np.sqrt(np.maximum(values, 0.0))).T
