"""Frictional limits: breakaway, the steady curve, v*, offset points (Liu et al. 2019, eqs 10-15; errata 3, 4, 7)."""

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import Any

from vibrocap.arguments import ArgumentError, is_positive
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.friction.curves import Exponential
from vibrocap.quantities.declared import Damping, Force, Length, Number, Reason, Speed
from vibrocap.quantities.dimensional import Dimensional

MOST_ITERATIONS = 100_000
# Relative change at which a recursion has arrived. Not rounding itself, at which it may hop between two neighbours.
ARRIVED = 4e-16
ROUNDING = 4e-16  # of the logarithm of a number of the order of one
LARGEST_LOGARITHM = 700.0  # of a floating-point number, nearly


@dataclasses.dataclass(frozen=True)
class Recursion(Dimensional):
    """Where a recursion went: its value (None where it left the real numbers or did not arrive) and how many steps."""

    value: Speed | None
    iterations: int
    converged: bool


@dataclasses.dataclass(frozen=True)
class OffsetPoints(Dimensional):
    """Speeds at which the steady friction curve of the LuGre law has slope zero (eq. 13).

    exist: whether there is any; reason: why, or why not, in words
    ratio: C = alpha N (eta_s - eta_c)/(delta2 v_s); None where it is infinite (delta2 = 0)
    lower, upper: X'_l and X'_h, exact (Lambert's W); None where there is none
    greatest_viscous_damping: largest delta2 with offset points; None where there is no such limit (alpha < 1)
    printed_lower: eq. 14 as printed, None where it is undefined; printed_upper: eq. 15 as printed (exponent 1/2)
    corrected_upper: the recursion x = {ln[C x^(alpha-1)]}^(1/alpha) that follows from eq. 13 (erratum 4)
    """

    exist: bool
    reason: Reason
    ratio: Number | None
    lower: Speed | None
    upper: Speed | None
    greatest_viscous_damping: Damping | None
    printed_lower: Speed | None
    printed_upper: Recursion
    corrected_upper: Recursion


def offset_points(law: LuGre, load: float = 1.0) -> OffsetPoints:
    """Speeds at which the steady curve has slope zero: exact, and as the paper approximates them (eqs 13-15).

    With x = X'/v_s eq. 13 reads C x^(alpha-1) exp(-x^alpha) = 1. For alpha > 1 its left side rises to a greatest value
    at x^alpha = m, m = (alpha-1)/alpha, and falls: two solutions where C is large enough, else none. With Lambert's W

        x^alpha = -m W(-C^(-1/m)/m),   W_0 for the lower, W_-1 for the upper point,

    which for alpha = 2 is x = sqrt(-W(-2/C^2)/2), if and only if C >= sqrt(2 e). The values are found by bisection of
    the logarithm of eq. 13, which gives the same to rounding and, unlike most programs for W, also where both meet.
    For alpha <= 1 the left side only falls: at most one, the upper point.
    """
    checked_load(load)
    exponent, scale = law.stribeck_exponent, law.stribeck_velocity
    drop = load * (law.static_coefficient - law.coulomb_coefficient)
    m = (exponent - 1.0) / exponent
    greatest: float | None = None  # largest slope of the drop, at x^alpha = m
    if exponent > 1.0:
        greatest = drop / scale * exponent * m**m * math.exp(-m)
    elif exponent == 1.0:
        greatest = drop / scale
    nowhere = Recursion(None, 0, False)
    if law.viscous_damping == 0.0:
        reason = "viscous_damping is 0: the curve falls at every speed (X'_l = 0, X'_h = infinity)"
        if drop == 0.0:
            reason = "viscous_damping is 0 and static_coefficient equals coulomb_coefficient: the curve is flat"
        printed = 0.0 if drop > 0.0 and exponent > 1.0 else None
        return OffsetPoints(False, reason, None, None, None, greatest, printed, nowhere, nowhere)
    ratio = exponent * drop / (law.viscous_damping * scale)
    if ratio == 0.0:
        reason = "static_coefficient equals coulomb_coefficient: the curve rises at every speed"
        return OffsetPoints(False, reason, 0.0, None, None, greatest, None, nowhere, nowhere)
    lower, upper = _solutions(ratio, exponent, m)
    limit = f"the largest at which the curve falls anywhere, {greatest:.6g}" if greatest is not None else ""
    if upper is None:
        reason = f"viscous_damping {law.viscous_damping:g} is above {limit}: it rises at every speed"
    elif lower is None:
        reason = f"stribeck_exponent {exponent:g} is at most 1: the curve falls from rest on and has no lower point"
    else:
        reason = f"viscous_damping {law.viscous_damping:g} is not above {limit}"
    logarithm = math.log(ratio)

    def printed_upper(x: float) -> float:  # eq. 15: {ln[C^(1/(alpha-1)) x]}^(1/2)
        return math.sqrt(logarithm / (exponent - 1.0) + math.log(x))

    def corrected_upper(x: float) -> float:  # what eq. 13 gives: {ln[C x^(alpha-1)]}^(1/alpha)
        power = logarithm + (exponent - 1.0) * math.log(x)
        if power < 0.0:
            raise ValueError("the root of a negative number is not real")
        return power ** (1.0 / exponent)

    return OffsetPoints(
        exist=upper is not None,
        reason=reason,
        ratio=ratio,
        lower=None if lower is None else scale * lower,
        upper=None if upper is None else scale * upper,
        greatest_viscous_damping=greatest,
        printed_lower=_printed_lower(law, ratio),
        printed_upper=nowhere if exponent == 1.0 else _recursion(printed_upper, scale),
        corrected_upper=_recursion(corrected_upper, scale),
    )


def _solutions(ratio: float, exponent: float, m: float) -> tuple[float | None, float | None]:
    """Both x with ratio x^(exponent-1) exp(-x^exponent) = 1, or None."""

    def surplus(y: float) -> float:  # logarithm of the left side, over y = ln x^alpha
        return math.log(ratio) + m * y - math.exp(y)

    if exponent <= 1.0:
        if exponent == 1.0:
            return (None, math.log(ratio)) if ratio > 1.0 else (None, None)
        top = low = 0.0
        while surplus(low) < 0.0:
            low = 2.0 * low - 1.0
    else:
        top = low = math.log(m)
        if surplus(top) < -ROUNDING:
            return None, None
        if surplus(top) <= 0.0:  # both solutions in one
            return math.exp(top / exponent), math.exp(top / exponent)
    high = top + 1.0
    while surplus(high) > 0.0:
        high = 2.0 * high - top
    upper = math.exp(root_between(surplus, low, high) / exponent)
    if exponent < 1.0:
        return None, upper
    bottom = -math.log(ratio) / m  # there the first two terms cancel
    return math.exp(root_between(surplus, min(bottom, top), top) / exponent), upper


def _printed_lower(law: LuGre, ratio: float) -> float | None:
    """Eq. 14: v_s [delta2 v_s/(alpha N (eta_s - eta_c))]^(1/(alpha-1))."""
    if law.stribeck_exponent == 1.0:
        return None
    logarithm = -math.log(ratio) / (law.stribeck_exponent - 1.0)
    return law.stribeck_velocity * math.exp(logarithm) if logarithm < LARGEST_LOGARITHM else None


def _recursion(step: Callable[[float], float], scale: float) -> Recursion:
    """Iterate from x = 1, "in adjacency of the Stribeck velocity", until nothing changes; x in units of `scale`."""
    x = 1.0
    for iteration in range(1, MOST_ITERATIONS + 1):
        try:
            following = step(x)
        except ValueError:  # the logarithm or the root is not real: there is nothing to converge to
            return Recursion(None, iteration, False)
        if abs(following - x) <= ARRIVED * following:
            return Recursion(scale * following, iteration, True)
        x = following
    return Recursion(None, MOST_ITERATIONS, False)


def root_between(function: Callable[[float], float], low: float, high: float) -> float:
    """The root between two ends at which the function differs in sign, by bisection down to neighbouring numbers."""
    rising = function(high) > 0.0
    while low < (middle := 0.5 * (low + high)) < high:
        if (function(middle) > 0.0) == rising:
            high = middle
        else:
            low = middle
    return middle


def checked_load(load: Any) -> None:
    """ValueError for a normal load that is not a finite number above 0."""
    if not is_positive(load):
        raise ArgumentError("load", f"should be a finite number > 0, got {load!r}")


@dataclasses.dataclass(frozen=True)
class SteadyPoint(Dimensional):
    """A point of the steady friction curve: eq. 11 and its slope, eq. 12."""

    velocity: Speed
    friction: Force
    slope: Damping


@dataclasses.dataclass(frozen=True)
class FrictionalLimits(Dimensional):
    """The limits of a friction law under a normal load.

    breakaway_force: N eta_s; coulomb_force: N eta_c
    deflection_limit: g(0) = N eta_s/delta0, the largest deflection of the bristles; None for a law without bristles
    boundary_velocity: v* (`boundary_velocity`)
    curve: points of the steady curve
    offset: offset points; None for a law without viscous friction, whose curve only falls
    """

    law: str
    load: Force
    breakaway_force: Force
    coulomb_force: Force
    deflection_limit: Length | None
    boundary_velocity: Speed | None
    curve: tuple[SteadyPoint, ...]
    offset: OffsetPoints | None


def frictional_limits(law: Any, load: float = 1.0, *, velocities: Sequence[float] | None = None) -> FrictionalLimits:
    """Frictional limits of the LuGre or the exponential law under a normal load N.

    velocities: where the steady curve is given (not 0); by default a tenth of, once and ten times the speed over which
    friction drops (v_s, or 1/a).

    Breakaway is approached exponentially in displacement and not reached at a point, as (10) seems to say (erratum 3).
    Raises TypeError for another law, whose limits these equations are not.
    """
    checked_load(load)
    if isinstance(law, LuGre):
        scale = law.stribeck_velocity
    elif isinstance(law, Exponential):
        scale = 1.0 / law.decay_rate if law.decay_rate > 0.0 else 1.0
    else:
        raise TypeError(f"friction should be a LuGre or an exponential law for these limits, got {law!r}")
    if velocities is None:
        velocities = (0.1 * scale, scale, 10.0 * scale)
    curve = tuple(SteadyPoint(float(v), steady_friction(law, load, v), steady_slope(law, load, v)) for v in velocities)
    bristles = isinstance(law, LuGre)
    return FrictionalLimits(
        law=law.name,
        load=float(load),
        breakaway_force=load * law.static_coefficient,
        coulomb_force=load * law.coulomb_coefficient,
        deflection_limit=load * law.static_coefficient / law.bristle_stiffness if bristles else None,
        boundary_velocity=boundary_velocity(law, load),
        curve=curve,
        offset=offset_points(law, load) if bristles else None,
    )


def steady_friction(law: Any, load: float, velocity: float) -> float:
    """Friction force at a constant velocity, the steady curve (eqs 11 and 8, with the sgn that 11 leaves out).

    Raises ValueError at velocity 0, where the curve jumps from -N eta_s to N eta_s.
    """
    return math.copysign(law.steady_force(_speed(velocity), load), velocity)


def steady_slope(law: LuGre | Exponential, load: float, velocity: float) -> float:
    """Slope of the steady curve (eq. 12), the same for either direction.

    LuGre:        delta2 - alpha N (eta_s - eta_c) |v|^(alpha-1)/v_s^alpha exp(-|v/v_s|^alpha)
    exponential:  -a N (eta_s - eta_c) exp(-a |v|)
    A slope below zero feeds vibration, it does not damp it (erratum 5). ValueError at velocity 0.
    """
    speed = _speed(velocity)
    drop = load * (law.static_coefficient - law.coulomb_coefficient)
    if isinstance(law, LuGre):
        x, exponent = speed / law.stribeck_velocity, law.stribeck_exponent
        fall = exponent * drop / law.stribeck_velocity * x ** (exponent - 1.0) * math.exp(-(x**exponent))
        return law.viscous_damping - fall
    return -law.decay_rate * drop * math.exp(-law.decay_rate * speed)


def boundary_velocity(law: Any, load: float = 1.0) -> float | None:
    """v*: the speed at which the accelerating and the decelerating branch of sliding change places (erratum 7).

    R = xi (delta0 - delta1 |v|/g(v)) + (delta1 + delta2) v, so where

        delta1 v* = delta0 g(v*)

    friction does not depend on the bristles: every branch of every loop passes through (v*, R_steady(v*)), exactly. As
    bristles lag behind their steady deflection, R - R_steady = (delta1 - delta0 g/v) g'(v) v' to first order in v':
    friction is larger while accelerating below v*, and smaller above it. 0.0405 for the paper's values.

    None for a law without bristles or without a droop (eta_s = eta_c), whose branches coincide, and for delta1 = 0, for
    which v* is infinite.
    """
    checked_load(load)
    if not isinstance(law, LuGre) or law.bristle_damping == 0.0 or law.static_coefficient == law.coulomb_coefficient:
        return None
    slowest = load * law.coulomb_coefficient / law.bristle_damping
    fastest = load * law.static_coefficient / law.bristle_damping

    def surplus(speed: float) -> float:  # rises from below zero to above, once
        lag_free = law.steady_force(speed, load) - law.viscous_damping * speed
        return law.bristle_damping * speed - lag_free

    return root_between(surplus, slowest, fastest)


def _speed(velocity: float) -> float:
    if velocity == 0.0 or not math.isfinite(velocity):
        why = f"should be a finite number other than 0, where the curve jumps, got {velocity!r}"
        raise ArgumentError("velocity", why)
    return abs(float(velocity))
