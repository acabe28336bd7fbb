"""The two branches of a friction loop: friction while accelerating against friction while decelerating."""

import dataclasses
import functools
import itertools

import numpy as np

from vibrocap.measures.stretch import Stretch

SPEEDS = 256  # at which the branches are compared
INVERSIONS = 60  # bisections: a speed is inverted to rounding
MINORITY = 0.05  # of the integral of |difference|: with more than this of either sign the branches are mixed


@dataclasses.dataclass(frozen=True)
class Branches:
    """Accelerating against decelerating friction in one direction and one regime.

    The difference is side (R_accelerating - R_decelerating) at equal speed: positive where friction is larger in
    magnitude on the way up, the paper's clockwise loop.

    direction: "accelerating above", "decelerating above", "mixed" (neither has 95 % of it) or "coincide"
    area: oint R dv over that part of the loop, the integral of the difference over speed; positive clockwise
    mean_difference: area over the range of speeds
    largest_difference: the difference of greatest magnitude, with its sign; None where no speed is passed both ways
    speeds: the range of speeds compared
    """

    direction: str
    area: float
    mean_difference: float
    largest_difference: float | None
    speeds: tuple[float, float]


@dataclasses.dataclass(frozen=True)
class Excursion:
    """A slide from rest to rest, cut into its monotone ways up and down."""

    stretch: Stretch

    @functools.cached_property
    def ways(self) -> list[tuple[float, float, bool]]:
        """(start, end, accelerating) of each monotone way."""
        turns = self.stretch.roots(self.stretch.acceleration)
        marks = np.concatenate(([self.stretch.start], turns, [self.stretch.end]))
        speeds = self.stretch.side * self.stretch.velocity(marks)
        return [
            (float(marks[i]), float(marks[i + 1]), bool(speeds[i + 1] > speeds[i]))
            for i in range(len(marks) - 1)
            if marks[i + 1] > marks[i]
        ]

    @functools.cached_property
    def speeds(self) -> tuple[float, float]:
        """Least and greatest speed."""
        marks = np.array([self.ways[0][0], *(end for _, end, _ in self.ways)])
        speeds = self.stretch.side * self.stretch.velocity(marks)
        return max(0.0, float(speeds.min())), float(speeds.max())

    def branch(self, speeds: np.ndarray, accelerating: bool) -> np.ndarray:
        """side R at the given speeds, the mean over the ways up (or down) that pass it; NaN where none does."""
        side, stretch = self.stretch.side, self.stretch
        total, passes = np.zeros_like(speeds), np.zeros_like(speeds)
        for start, end, up in self.ways:
            if up != accelerating:
                continue
            ends = side * stretch.velocity(np.array([start, end]))
            inside = (speeds >= ends.min()) & (speeds <= ends.max())
            wanted = speeds[inside]
            low, high = np.full(len(wanted), start), np.full(len(wanted), end)
            for _ in range(INVERSIONS):
                middle = 0.5 * (low + high)
                early = (side * stretch.velocity(middle) < wanted) == accelerating
                low, high = np.where(early, middle, low), np.where(early, high, middle)
            total[inside] += side * stretch.friction(0.5 * (low + high))
            passes[inside] += 1.0
        return np.divide(total, passes, out=np.full_like(speeds, np.nan), where=passes > 0)

    def difference(self, speeds: np.ndarray) -> np.ndarray:
        """Accelerating less decelerating friction (times side) at equal speed; NaN where either is missing."""
        return self.branch(speeds, True) - self.branch(speeds, False)

    def crossings(self, least: float) -> tuple[float, ...]:
        """Speeds at which the branches change places, where they do so by more than a least difference."""
        from scipy.optimize import brentq

        low, high = self.speeds
        # Denser towards rest, where a branch may change steeply.
        grid = low + (high - low) * np.linspace(0.0, 1.0, SPEEDS + 2)[1:-1] ** 2
        difference = self.difference(grid)
        known = np.flatnonzero(np.abs(difference) > least)
        found = []
        for i, j in itertools.pairwise(known):
            if difference[i] * difference[j] < 0.0:
                speed, _ = brentq(self._known_difference, grid[i], grid[j], xtol=1e-14, full_output=True)
                # Where a way begins or ends the mean over ways jumps or is missing, which is no crossing.
                if abs(self.difference(np.array([speed]))[0]) <= 1e-6 * (abs(difference[i]) + abs(difference[j])):
                    found.append(float(speed))
        return tuple(found)

    def _known_difference(self, speed: float) -> float:
        return float(np.nan_to_num(self.difference(np.array([speed]))[0]))


def branches(excursion: Excursion, area: float, low: float, high: float, least: float) -> Branches | None:
    """Compare both branches of an excursion at speeds from low to high; None where it does not come there.

    area: the part of oint R dv that belongs to it; least: mean difference that counts as none
    """
    slowest, fastest = excursion.speeds
    low, high = max(low, slowest), min(high, fastest)
    if not high > low:
        return None
    centres = low + (high - low) * (np.arange(SPEEDS) + 0.5) / SPEEDS
    difference = excursion.difference(centres)
    difference = difference[np.isfinite(difference)]
    mean = area / (high - low)
    largest = float(difference[np.argmax(np.abs(difference))]) if len(difference) else None
    total = float(np.abs(difference).sum())
    minority = min(float(difference[difference > 0].sum()), float(-difference[difference < 0].sum()))
    if largest is None or abs(largest) <= least:
        direction = "coincide"
    elif minority > MINORITY * total:
        direction = "mixed"
    else:
        direction = "accelerating above" if difference.sum() > 0.0 else "decelerating above"
    return Branches(direction, area, mean, largest, (low, high))
