"""The forces on the pieces that implicit steps have made."""

import functools

import numpy as np

from vibrocap.motion.recording.equations import equations
from vibrocap.numerics import api as numerics
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, derivative, evaluate
from vibrocap.physics.system import System


def correction(
    system: System,
    t: np.ndarray,
    parameters: tuple,
    states: np.ndarray,
    slopes: np.ndarray,
    sides: tuple[np.ndarray, ...],
    length: np.ndarray,
) -> np.ndarray:
    """What to add to the states of a stiff piece before the law is asked: array [states, n].

    The polynomials of an implicit step follow the states to the tolerance, and their slopes are as exact. What a stiff
    law makes of such states is not: friction may change by as much as the load within the error of a velocity. The
    states y* at which the equations do have the slopes y' of the polynomials, to the error of those over the length h
    of the step, are next to them,

        y* = y + h [f(y*) - y']

    and found by Newton's method, whose matrix is 1/h - J. Where nothing is stiff they are as near as h (f - y'); along
    a stiff direction most of the error goes. Where they would be farther, disturbances grow instead of decaying, and
    the states are left as they are. Of a law with a kink at rest, y* stays on its side.

    t: since the start of the period; parameters: of each point, see `equations.parameters_at`; sides: of each contact
    length: of its piece
    """
    recording = equations(system)
    size, count = states.shape
    scales = np.asarray(evaluate(recording.scales, 0.0, [], 1.0, parameters), float)[:, None]
    change, reach = np.zeros_like(states), None
    for _ in range(numerics.NEWTON_STEPS):
        at = states + change
        with np.errstate(all="ignore"):  # near rest a law may divide by zero; such a point is left where it is
            rates = _filled(evaluate(recording.rates, t, at, sides, parameters), count)
            slope = _filled(evaluate(jacobian(recording), t, at, sides, parameters), count)
            left = rates - slopes - change / length
            if reach is None:
                reach = np.max(np.abs(left * length) / scales, axis=0)
            matrix = np.eye(size) / length[:, None, None] - slope.reshape(size, size, count).transpose(2, 0, 1)
            usable = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(left).all(axis=0)
        change[:, usable] += np.linalg.solve(matrix[usable], left.T[usable, :, None])[:, :, 0].T
        if any(each.kind == "kinked" for each in recording.contacts):
            change *= _share_to_rest(recording, t, states, change, sides, parameters)
    return np.where(np.max(np.abs(change) / scales, axis=0) <= reach, change, 0.0)


def _share_to_rest(recording: Equations, t, states, change, sides, parameters) -> np.ndarray:
    """Share of the changes at which no velocity of a kinked law has passed rest: array [n]."""
    count = len(sides[0])
    found = np.ones(count)
    for contact, side in zip(recording.contacts, sides, strict=True):
        if contact.kind != "kinked":
            continue
        values = (evaluate([contact.velocity], t, at, sides, parameters) for at in (states, states + change))
        before, after = (side * _filled(each, count)[0] for each in values)
        beyond = after < 0.0
        share = np.divide(before, before - after, out=np.zeros(len(side)), where=beyond & (before > 0.0))
        found = np.minimum(found, np.where(beyond, numerics.INSIDE * share, 1.0))
    return found


@functools.lru_cache(maxsize=64)
def jacobian(recording: Equations) -> tuple[Expression, ...]:
    """Slopes of the rates with respect to the states, row by row."""
    states = len(recording.rates)
    return tuple(derivative(rate, j) for rate in recording.rates for j in range(states))


def _filled(values: list, count: int) -> np.ndarray:
    return np.array([np.broadcast_to(np.asarray(value, dtype=float), (count,)) for value in values])
