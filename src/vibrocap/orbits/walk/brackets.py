"""Brackets: where a function of one number changes its sign, or where something ceases to hold, to rounding."""

import dataclasses
from collections.abc import Callable

import numpy as np

MOST_TRIALS = 80
JUMPS = 1e-3  # of the largest value at the ends of a search: one that stays above it does not pass zero


class Lost(Exception):
    """The function cannot be evaluated at a place."""


@dataclasses.dataclass(frozen=True)
class Bracket:
    """Two places between which a function changes its sign, and its values there."""

    left: float
    right: float
    value_left: float
    value_right: float
    scale: float  # largest value at the ends of the search

    @property
    def jumps(self) -> bool:
        """Whether the function jumps over zero instead of passing it."""
        return min(abs(self.value_left), abs(self.value_right)) > JUMPS * self.scale


def root(function: Callable[[float], float], left: float, right: float, width: float) -> Bracket:
    """Where a function changes its sign between two places, to half a width: bracketing with the ITP method.

    Interpolate, truncate, project (Oliveira and Takahashi 2020): as safe as bisection, as quick as the secant. It does
    not assume that the function is continuous; `Bracket.jumps` tells. Raises what the function raises.
    """
    low, high = function(left), function(right)
    scale, span = max(abs(low), abs(high)), right - left
    most = int(np.ceil(np.log2(span / (2.0 * width)))) + 1
    for trial in range(MOST_TRIALS):
        if right - left <= 2.0 * width or low == 0.0 or high == 0.0:
            break
        middle = 0.5 * (left + right)
        secant = (high * left - low * right) / (high - low)
        towards = np.sign(middle - secant)
        truncated = min(0.2 * (right - left) ** 2 / span, abs(middle - secant)) * towards + secant
        radius = max(width * 2.0 ** (most - trial) - 0.5 * (right - left), 0.0)
        place = truncated if abs(truncated - middle) <= radius else middle - towards * radius
        place = float(np.clip(place, left + 0.1 * width, right - 0.1 * width))
        if not left < place < right:
            break  # no number lies between
        value = function(place)
        if np.sign(value) == np.sign(low):
            left, low = place, value
        else:
            right, high = place, value
    return Bracket(left, right, low, high, scale)


def change(
    holds: Callable[[float], bool], left: float, right: float, width: float, kink: float = 0.0
) -> tuple[float, float]:
    """Two places no farther apart than a width: something holds at the first and not at the second (bisection).

    kink: width of the bracket below which a place that is lost ends the search; above, `Lost` is raised
    """
    for _ in range(MOST_TRIALS):
        middle = 0.5 * (left + right)
        if right - left <= width or not left < middle < right:
            break
        try:
            left, right = (middle, right) if holds(middle) else (left, middle)
        except Lost:
            if right - left < kink:
                break
            raise
    return left, right
