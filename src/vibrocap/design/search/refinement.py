"""Refinement of a design on its closed orbit: measures to rounding, stability by multipliers, an optimum to 1e-9.

The measures of runs are as exact as a run has settled. Those of a closed orbit are exact to rounding, so an optimum can
be followed until its slopes vanish, or something that can be named is in the way: along exact gradients where the
measure has them, and by models that interpolate where the mode sequence changes or a constraint is active.
"""

import dataclasses
import functools
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.design.search.ascent import Slopes, ascend, slopes_by_share, vanishes
from vibrocap.design.search.problem import Problem
from vibrocap.measures.during_run import measured
from vibrocap.measures.recorded.sticking import spelled_all
from vibrocap.measures.standard import COST
from vibrocap.motion.trajectory import Trajectory
from vibrocap.motion.trust import residue
from vibrocap.orbits.closing.orbit import orbit
from vibrocap.orbits.closing.periodic_solution import PeriodicSolution
from vibrocap.orbits.closing.shooting import closed
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, state_vector

TOLERANCE = 1e-12  # of the runs that close an orbit
REGION = 0.01, 1e-9  # first and last radius of the trust region, in shares of the ranges
STEP = 1e-5  # of the differences that give slopes, in shares of the ranges
CLOSER = 0.125  # of the step, at which a secant over a jump is eight times steeper, to a vertical slope 8**0.5 times
LEAP = 1e-7  # least jump over the measure: more than closing and the curvature over a step leave
FLAT = 1e-4  # of a slope by differences over the size of the measure, per range, that counts as none
NOISE = 1e-10 / STEP  # of a difference over the step, relative to the measure: what closing leaves of it
ALLOWED = 1e-9  # by which a constraint may be violated, relative to its limit: what rounding leaves of an active one


@dataclasses.dataclass(frozen=True)
class Refined:
    """A design with its closed orbits.

    shares: [variables]; solutions: the periodic solution of the design itself, then one for each sample of what is
    uncertain, None where none closes or none is stable; found: the measures by name; margins: of the constraints,
    relative to their limits, and last of stability; merit: what is made as large as possible
    """

    shares: np.ndarray
    solutions: tuple[PeriodicSolution | None, ...]
    found: dict[str, float]
    margins: np.ndarray
    merit: float

    @property
    def solution(self) -> PeriodicSolution:
        """The periodic solution of the design itself."""
        assert self.solutions[0] is not None
        return self.solutions[0]

    @property
    def allowed(self) -> bool:
        """Whether it closes, is certified, is stable with its margin, and fulfils the constraints."""
        return self.solution.stable and bool(np.all(self.margins >= -ALLOWED))

    @functools.cached_property
    def motion(self) -> Trajectory:
        """The motion along the orbit."""
        return self.solution.motion(tolerance=1e-11)

    @property
    def mode_sequence(self) -> str:
        """The mode sequences of all contacts along the orbit."""
        return spelled_all(self.motion)


class ClosedDesigns:
    """Designs near one whose orbit is known, each with its own orbits, closed from those of the best so far."""

    def __init__(self, problem: Problem, solution: PeriodicSolution, shares: np.ndarray):
        self.problem = problem
        self.map_ = StroboscopicMap(solution.system, TOLERANCE)
        variants = problem.variants(problem.space.parameters(shares))
        samples = (self._near_sample(values, solution) for values in variants[1:])
        self.near: tuple[PeriodicSolution | None, ...] = (solution, *samples)
        self.known: dict[bytes, Refined | None] = {}
        self.gradients: dict[bytes, np.ndarray | None] = {}
        self.best: Refined | None = self.at(shares)
        if self.best is not None:
            self.near = self.best.solutions

    @property
    def top(self) -> Refined:
        """The best design, where there is one."""
        assert self.best is not None
        return self.best

    def at(self, shares: np.ndarray) -> Refined | None:
        """The design at some shares; None where no orbit closes, or its motion did not go to its end."""
        shares = np.clip(shares, 0.0, 1.0)
        key = shares.tobytes()
        if key not in self.known:
            self.known[key] = self._closed(shares)
        return self.known[key]

    def _closed(self, shares: np.ndarray) -> Refined | None:
        goal, samples = self.problem.goal, self.problem.samples
        variants = zip(self.problem.variants(self.problem.space.parameters(shares)), self.near, strict=True)
        steady = [self._steady(values, near or self.near[0]) for values, near in variants]
        if steady[0] is None:
            return None
        solution, values = steady[0]
        solutions = [one and one[0] for one in steady]
        if samples is not None:
            kept = np.array([one is not None and self._room(one[0]) >= 0.0 for one in steady[1:]])
            solutions = [solution, *(one if keep else None for one, keep in zip(solutions[1:], kept, strict=True))]
            every = {name: np.array([np.nan if one is None else one[1][name] for one in steady[1:]]) for name in values}
            values = values | {name: float(x) for name, x in goal.over_samples(every, kept, samples.chosen).items()}
        margins = [one.margin(values[one.measure]) / max(abs(one.limit), 1e-3) for one in goal.constraints]
        margins.append(min(self._room(one) for one in solutions if one is not None))
        merit = float(goal.merit(values[goal.measure]))
        if not np.isfinite(merit) or not np.all(np.isfinite(margins)):
            return None
        return Refined(shares, tuple(solutions), values, np.array(margins), merit)

    def _near_sample(self, values: Mapping[str, Any], solution: PeriodicSolution) -> PeriodicSolution | None:
        """The orbit of a sample, near that of the design; where Newton's method leaves stable motions, by a run."""
        near = self._steady(values, solution)
        if near is not None and self._room(near[0]) >= 0.0:
            return near[0]
        try:
            settled = orbit(self.problem.of(values), initial=solution.state)
        except ValueError:  # a part refuses it, or it may not start there
            return None
        return settled if settled.closes else None

    def _room(self, solution: PeriodicSolution) -> float:
        """By how much the largest multiplier is below its limit."""
        return 1.0 - self.problem.margin - float(np.max(np.abs(solution.multipliers), initial=0.0))

    def _steady(
        self, values: Mapping[str, Any], near: PeriodicSolution | None
    ) -> tuple[PeriodicSolution, dict[str, float]] | None:
        """(the orbit of one system, closed from one near it, and its measures); None where there is none."""
        try:
            system = self.problem.of(values)
        except ValueError:  # a part refuses it
            return None
        assert near is not None
        state, periods = state_vector(system, near.state), near.response_period
        solution = closed(self.map_.of(system), state, periods)
        if not solution.closes:
            return None
        motion = solution.motion(tolerance=1e-11)
        if not motion.status.ok:
            return None
        steady = measured(motion, list(self.problem.measures), window=periods)
        if "mean_velocity" in steady and solution.mean_velocity is not None:
            steady["mean_velocity"] = solution.mean_velocity
        left = residue(system, "mean_velocity", self.problem.settle)
        if COST in steady and abs(solution.mean_velocity or 0.0) <= left:
            steady[COST] = np.inf
        return solution, steady

    def gradient(self, design: Refined) -> np.ndarray | None:
        """d(measure)/d(share) of a design by each continuous variable, exactly; None where there is none."""
        key = design.shares.tobytes()
        if key not in self.gradients:
            value = design.found[self.problem.goal.measure]
            self.gradients[key] = slopes_by_share(self.problem, design.solution, design.shares, value)
        return self.gradients[key]

    def _rise(self, design: Refined) -> np.ndarray | None:
        """d(merit)/d(share), exactly."""
        gradient, goal = self.gradient(design), self.problem.goal
        if gradient is None:
            return None
        turned = goal.size and design.found[goal.measure] < 0.0
        return -gradient if turned == goal.maximise else gradient

    def refine(self, evaluations: int) -> None:
        """Make the best design better: along its gradient, then by a trust region where that does not lead to the end.

        The quadratic models of the trust region (COBYQA, Ragonneau and Zhang 2024) interpolate, so they serve where the
        mode sequence changes and a derivative jumps, if more slowly.
        """
        from scipy.optimize import Bounds, NonlinearConstraint, minimize

        moving = self.problem.space.continuous
        if self.best is None or not len(moving) or evaluations == 0:
            return
        base, size = self.top.shares.copy(), max(abs(self.top.merit), 1e-12)

        def at(x: np.ndarray) -> Refined | None:
            shares = base.copy()
            shares[moving] = x
            refined = self.at(shares)
            if refined is not None and refined.allowed and refined.merit > self.top.merit:
                self.best, self.near = refined, refined.solutions
            return refined

        def slopes(x: np.ndarray) -> Slopes | None:
            design = at(x)
            rise = None if design is None or not design.allowed else self._rise(design)
            return None if design is None or rise is None else (design.merit, rise)

        def arrived() -> bool:
            end = ascend(self.top.shares[moving], slopes, evaluations)
            flat = None if end is None else at(end)
            if flat is not None:  # as good to rounding as the best so far, and flatter
                self.best, self.near = flat, flat.solutions
            return flat is not None

        if arrived():
            return

        def cost(x: np.ndarray) -> float:
            design = at(x)
            return 1.0 if design is None else -design.merit / size

        def margins(x: np.ndarray) -> np.ndarray:
            design = at(x)
            return np.full(len(self.problem.goal.constraints) + 1, -1.0) if design is None else design.margins

        bounds = Bounds(np.zeros(len(moving)), np.ones(len(moving)))  # type: ignore[arg-type]
        within = [NonlinearConstraint(margins, 0.0, np.inf)]
        options = {"final_tr_radius": REGION[1], "maxfev": evaluations, "feasibility_tol": ALLOWED}
        for radius in (REGION[0], REGION[0] / 10.0):
            before, options["initial_tr_radius"] = self.top.merit, radius
            minimize(cost, self.top.shares[moving], method="COBYQA", bounds=bounds, constraints=within, options=options)
            if self.top.merit - before <= 1e-11 * size:
                break
        arrived()

    def slopes(self) -> dict[str, tuple[float | None, float | None]]:
        """d(measure)/d(variable) below and above the best design; None at a bound, and where it closes or jumps.

        Exact where the measure has gradients and the mode sequence continues; beyond a change of it the slope there is
        extrapolated to the design, with the error of the square of the step.
        """
        best, space = self.top, self.problem.space
        slopes = {}
        for place, i in enumerate(map(int, space.continuous)):
            rate = space.derivative(i, float(best.shares[i]))
            below, above = (self._slope(place, i, sign) for sign in (-1.0, 1.0))
            slopes[space.paths[i]] = (below and below / rate, above and above / rate)
        return slopes

    def _slope(self, place: int, variable: int, sign: float) -> float | None:
        """d(measure)/d(share) of a variable to one side of the best design; place: its number among the continuous."""
        best, secants = self.top, self._secants(variable, sign)
        if secants is None or self._jumps(variable, sign):
            return None
        (far, of_far), (close, of_close) = secants
        noise = NOISE * abs(best.found[self.problem.goal.measure])
        alike = abs(of_far - of_close) <= 0.5 * abs(of_close) + noise / CLOSER  # else a jump or a kink is between them
        near, secant, noise = (far, of_far, noise) if alike else (close, of_close, noise / CLOSER)
        own, there = self.gradient(best), self.gradient(near)
        if there is None:
            return secant
        if own is not None and near.mode_sequence == best.mode_sequence:
            # Where all is smooth the secant is the mean of the slopes at its ends; over a kink it is not.
            apart = abs(secant - 0.5 * float(own[place] + there[place]))
            if apart <= 0.1 * abs(float(own[place] - there[place])) + noise:
                return float(own[place])
        return 2.0 * secant - float(there[place])

    def _secants(self, variable: int, sign: float) -> list[tuple[Refined, float]] | None:
        """(design, change of the measure over that of the share) a step and a part of it beside the best one; None
        where one of them is beyond a bound or lost."""
        best, name, secants = self.top, self.problem.goal.measure, []
        for part in (1.0, CLOSER):
            if (near := self._beside(variable, sign, part)) is None:
                return None
            change = near.found[name] - best.found[name]
            secants.append((near, change / float(near.shares[variable] - best.shares[variable])))
        return secants

    def _jumps(self, variable: int, sign: float) -> bool:
        """Whether the measure jumps, or rises vertically, beside the best design: nearer secants are steeper."""
        if (secants := self._secants(variable, sign)) is None:
            return False
        far, close = (abs(secant) for _, secant in secants)
        leap = close * CLOSER * STEP > LEAP * abs(self.top.found[self.problem.goal.measure])
        return leap and close > 2.0 * far

    def _beside(self, variable: int, sign: float, part: float = 1.0) -> Refined | None:
        """The design a part of the step beside the best one; None beyond a bound, or where a sample's orbit is lost."""
        shares = self.top.shares.copy()
        shares[variable] += sign * part * STEP
        near = self.at(shares) if 0.0 <= shares[variable] <= 1.0 else None
        lost = near is None or any(a and not b for a, b in zip(self.top.solutions, near.solutions, strict=True))
        return None if lost else near

    def limits(self) -> tuple[str, ...]:
        """The active limits of the best design, by name."""
        best, space, goal = self.top, self.problem.space, self.problem.goal
        limits = []
        for i in map(int, space.continuous):
            for end, name in ((0.0, "lower"), (1.0, "upper")):
                if abs(best.shares[i] - end) <= 10.0 * REGION[1]:
                    limits.append(f"{name} bound of {space.paths[i]}")
        for constraint, margin in zip(goal.constraints, best.margins[:-1], strict=True):
            if margin <= 1e-6:
                limits.append(f"constraint {constraint.words}")
        if best.margins[-1] <= 1e-6:
            limits.append("stability")
        for i in map(int, space.continuous):
            if any(self._jumps(i, sign) for sign in (-1.0, 1.0)):
                limits.append(f"jump of {goal.measure} over {space.paths[i]}")
            near = [side for sign in (-1.0, 1.0) if (side := self._beside(i, sign)) is not None]
            words = dict.fromkeys([best.mode_sequence, *(motion.mode_sequence for motion in near)])
            if len(words) > 1:
                limits.append(f"change of mode sequence over {space.paths[i]} ({' to '.join(words)})")
            elif any(self._beside(i, s) is None and 0.0 <= best.shares[i] + s * STEP <= 1.0 for s in (-1.0, 1.0)):
                kind = "closed orbit" if self.problem.samples is None else "stable orbit of every sample"
                limits.append(f"no {kind} beyond it over {space.paths[i]}")
        return tuple(limits) or (self._flatness(),)

    def _flatness(self) -> str:
        """What is said where nothing has a name: whether the slopes vanish."""
        best, moving = self.top, self.problem.space.continuous
        if not len(moving):
            return "nothing: choices alone are compared"
        own, level = self.gradient(best), FLAT * max(abs(best.merit), 1e-12)
        if own is not None and vanishes(best.shares[moving], best.merit, own):
            return "nothing: the slopes vanish"
        pairs = [[self._slope(place, i, sign) for sign in (-1.0, 1.0)] for place, i in enumerate(map(int, moving))]
        sides = np.array([pair for pair in pairs if None not in pair], dtype=float).reshape(-1, 2)
        largest = float(np.max(np.abs(np.mean(sides, axis=1)), initial=0.0))
        if own is None and largest <= level:
            return "nothing: the slopes vanish, to the accuracy of differences"
        goal = self.problem.goal
        rises = sides if goal.maximise != (goal.size and best.found[goal.measure] < 0.0) else -sides
        if len(sides) == len(moving) and np.all(rises[:, 0] >= -level) and np.all(rises[:, 1] <= level):
            return f"a kink: {goal.measure} is worse on both sides in each variable"
        return f"nothing that is active: a slope of {largest / max(abs(best.merit), 1e-12):.2g} of it per range is left"
