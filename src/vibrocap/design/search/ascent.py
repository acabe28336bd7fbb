"""Ascent along exact gradients: a design on its closed orbit is made better until its slopes are at rounding.

A quasi-Newton method (BFGS) whose steps stay within the bounds and are halved until they lead to an allowed, better
design: so it never walks through a flip to motions that nobody sees. It holds while the mode sequence is the same; at a
change of it a derivative jumps, no step along the old gradient helps, and the ascent reports that it has not converged.
"""

import dataclasses
from collections.abc import Callable

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.design.search.problem import Problem
from vibrocap.orbits.closing.gradients import gradients, measures_with_gradients
from vibrocap.orbits.closing.periodic_solution import PeriodicSolution
from vibrocap.physics.dimensions.conversion import quantity

LEVEL = 1e-10  # slope of the measure over its size, per range of a variable: what rounding leaves of one that vanishes
LONGEST = 0.1  # of a step, in shares of the ranges
FIRST = 0.01  # of the first step, whose curvature is not known
HALVINGS = 20
ENOUGH = 1e-4  # share of the rise that the slope promises (Armijo)
ROUNDING = 1e-11  # of the measure, relative: smaller differences are those of closing

Slopes = tuple[float, np.ndarray]  # merit, and its derivative by each continuous variable's share


def slopes_by_share(
    problem: Problem, solution: PeriodicSolution, shares: np.ndarray, value: float
) -> np.ndarray | None:
    """d(measure)/d(share) of the first goal by each continuous variable, exact on a closed orbit.

    value: of the measure there; None where the measure has no gradient, or the orbit none that is determined
    """
    goal, space, system = problem.goal, problem.space, solution.system
    if problem.samples is not None or solution.failed or goal.measure not in measures_with_gradients(system):
        return None
    rates = space.slopes(shares)
    asked = [quantity(path, system) for path in rates]
    try:
        plain = dataclasses.replace(solution, system=system.dimensionless)
        orbit_gradients = gradients(plain, [variable.plain for variable in asked], goal.measure)
    except ArgumentError:  # one of a continuum, a fold, a segment of no length, or a system without gradients
        return None
    by = {slope.parameter: slope for slope in orbit_gradients.slopes}
    if any(abs(slope.value - value) > 1e-6 * abs(value) for slope in orbit_gradients.slopes):
        return None
    pairs = zip(asked, rates.values(), strict=True)
    gradient = np.sum([by[variable.plain].slope / variable.scale * rate for variable, rate in pairs], axis=0)
    return gradient if np.all(np.isfinite(gradient)) else None


def outward(x: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    """Which variables are at a bound beyond which the merit would rise."""
    return ((x <= 0.0) & (gradient < 0.0)) | ((x >= 1.0) & (gradient > 0.0))


def vanishes(x: np.ndarray, merit: float, gradient: np.ndarray) -> bool:
    """Whether the slopes are at rounding, but for those that point beyond a bound."""
    return bool(np.max(np.abs(gradient[~outward(x, gradient)]), initial=0.0) <= LEVEL * max(abs(merit), 1e-12))


def ascend(x: np.ndarray, slopes: Callable[[np.ndarray], Slopes | None], most: int) -> np.ndarray | None:
    """Follow the gradient from shares x [variables] to those where it vanishes; None where it does not lead there.

    slopes: the merit and its gradient at shares, None where no allowed design is; most: times that it may be asked
    """
    here = slopes(x)
    if here is None:
        return None
    merit, gradient = here
    asked, curve, scaled = 1, np.eye(len(x)), False
    while not vanishes(x, merit, gradient):
        free = ~outward(x, gradient)
        step = np.zeros(len(x))
        step[free] = np.linalg.solve(np.linalg.inv(curve)[np.ix_(free, free)], gradient[free])
        if step @ gradient <= 0.0 or not scaled:
            step = np.where(free, gradient, 0.0) * FIRST / max(float(np.max(np.abs(gradient[free]))), 1e-300)
        step *= min(1.0, LONGEST / float(np.max(np.abs(step))))
        best = None
        for halving in range(HALVINGS):
            there = np.clip(x + step * 0.5**halving, 0.0, 1.0)
            if asked >= most or np.array_equal(there, x):
                return None
            best, asked = slopes(there), asked + 1
            if best is not None and _better(there - x, merit, gradient, best):
                break
        else:
            return None
        assert best is not None
        moved, turned = there - x, gradient - best[1]
        if moved @ turned > 1e-12 * np.linalg.norm(moved) * np.linalg.norm(turned):
            if not scaled:
                curve, scaled = np.eye(len(x)) * (moved @ turned) / (turned @ turned), True
            rho = 1.0 / (moved @ turned)  # the inverse of minus the Hessian after a step, by BFGS
            one = np.eye(len(x)) - rho * np.outer(moved, turned)
            curve = one @ curve @ one.T + rho * np.outer(moved, moved)
        x, (merit, gradient) = there, best
    return x


def _better(moved: np.ndarray, merit: float, gradient: np.ndarray, end: Slopes) -> bool:
    """Whether a step rises as its slope promises, or, where merits are equal to rounding, makes the slopes smaller."""
    rise = end[0] - merit
    if abs(rise) > ROUNDING * abs(merit):
        return rise >= ENOUGH * float(gradient @ moved) > 0.0
    return float(np.linalg.norm(end[1])) < float(np.linalg.norm(gradient))
