"""Matched laws: the parameters of one law that bring it closest to another, and the difference that remains."""

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.identification.experiments.motions import Motion, checked_range, synthetic_record
from vibrocap.identification.fitting.fit import fit
from vibrocap.identification.fitting.steady_fit import steady_fit
from vibrocap.identification.problem.samples import Samples
from vibrocap.identification.problem.steady_prediction import steady_force
from vibrocap.identification.result.fit_result import Fit
from vibrocap.physics.friction.law import Law
from vibrocap.ranges import values_between

CURVE = 400  # points of a matched steady curve
AT_REST = 1e-9  # of the largest speed: rounding


@dataclasses.dataclass(frozen=True, eq=False)
class Match:
    """A law matched to another.

    law: with the parameters that bring it closest to `to`; over: the velocity range or the motion in words
    relative_rmse: root mean square difference over the root mean square of the target's force
    largest: largest difference, in units of the force; where: velocity at which it occurs
    time [n] (empty for a velocity range), velocity [n], target [n], matched [n]: the curves
    """

    law: Law
    to: Law
    over: str
    relative_rmse: float
    largest: float
    where: float
    time: np.ndarray
    velocity: np.ndarray
    target: np.ndarray
    matched: np.ndarray
    fit: Fit


def match(
    law: Any,
    to: Law,
    *,
    velocity: tuple[float, float] | None = None,
    motion: Motion | None = None,
    spacing: str = "even",
    load: float = 1.0,
    free: Iterable[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    starts: int = 8,
    seed: int = 0,
) -> Match:
    """The parameters of a law that bring its force closest to that of another, in least squares.

    The paper compares two laws with parameters that are alike by name; whether they differ as laws shows once one is
    brought as close to the other as it can be.

    law: a law, its class or its name; to: the target, with its parameters
    velocity: (lowest, highest) speed > 0: the steady curves are matched there, at points of even or "logarithmic"
    spacing
    motion: both laws are driven by it from rest (one of velocity and motion)
    Parameters that the curves do not show keep the values of `law`. Raises ValueError for input that makes no sense,
    and where the law cannot be driven through the motion.
    """
    if (velocity is None) == (motion is None):
        raise ArgumentError("velocity", "give either a velocity range or a motion")
    if not isinstance(to, Law):
        raise ArgumentError("to", f"should be a friction law with its parameters, got {to!r}")
    if motion is not None:
        record = synthetic_record(to, motion, load=load)
        fitted = fit(
            record, law, free=free, fixed=fixed, starts=starts, start="relaxed", intervals="covariance", seed=seed
        )
        over = f"the motion {motion.name}"
    else:
        assert velocity is not None
        low, high = checked_range("velocity", velocity)
        if spacing not in ("even", "logarithmic"):
            raise ArgumentError("spacing", f"should be 'even' or 'logarithmic', got {spacing!r}")
        speeds = values_between(low, high, CURVE, spacing == "logarithmic")
        target = steady_force(to, speeds, load)
        deviation, none = float(np.std(target)) or 1.0, np.zeros(CURVE)
        points = Samples("curve", np.arange(float(CURVE)), speeds, target, none, load, deviation, none)
        fitted = steady_fit([points], law, free=free, fixed=fixed, starts=starts, intervals="covariance", seed=seed)
        over = f"velocities from {low:g} to {high:g}"
    if fitted.law is None:
        raise ArgumentError("law", f"{fitted.law_name} cannot be matched: {fitted.status}")
    of_record = fitted.records[0]
    time, speeds = np.empty(0) if motion is None else of_record.time, of_record.velocity
    target, matched = of_record.measured, of_record.predicted
    difference = np.abs(matched - target)
    at = int(np.argmax(difference))
    relative = float(np.sqrt(np.mean(difference**2) / np.mean(target**2)))
    where = float(speeds[at]) if abs(speeds[at]) > AT_REST * np.abs(speeds).max() else 0.0
    return Match(fitted.law, to, over, relative, float(difference[at]), where, time, speeds, target, matched, fitted)
