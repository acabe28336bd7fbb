"""Frictional limits: breakaway, the steady friction curve and v* (Liu et al. 2019, eqs 10-15; errata 3, 4 and 7)."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

from vibrocap.arguments import ArgumentError
from vibrocap.measures.recorded.offset_points import OffsetPoints, checked_load, offset_points, root_between
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.friction.curves import Exponential
from vibrocap.quantities.declared import Damping, Force, Length, Speed
from vibrocap.quantities.dimensional import Dimensional


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
        raise ArgumentError(
            "velocity", f"should be a finite number other than 0, where the curve jumps, got {velocity!r}"
        )
    return abs(float(velocity))
