"""Elementary functions of the physics, for numbers and for recorded expressions alike.

The equations of a law, a machine or a drive are written once, as scalar code on `+ - * /` and the functions below.
Called with floats they compute; called with an object that has a method of the same name (a recorded expression, a
SymPy wrapper) they record. That is how one source serves plain Python, compiled code, series, derivatives and proofs.

Behind them stand the few functions that several kinds of parts share: the bristles of a contact, as friction laws and
observers of friction know them, and a limit of a value, reached in front and behind, which never branches on a value.
"""

import math
from collections.abc import Callable
from typing import Any

HELD_AFTER = (1.0, 0.0, -1.0)  # what `held` is after each of the guards of a limit


def _elementary(name: str, meaning: str) -> Callable[[Any], Any]:
    """A function of numbers and of whatever has a method of its name."""
    of_number = getattr(math, name)

    def function(x):
        return getattr(x, name)() if hasattr(x, name) else of_number(x)

    function.__name__, function.__qualname__, function.__doc__ = name, name, meaning
    return function


sin = _elementary("sin", "Sine of x [rad].")
cos = _elementary("cos", "Cosine of x [rad].")
exp = _elementary("exp", "Exponential of x.")
log = _elementary("log", "Natural logarithm of x > 0.")
sqrt = _elementary("sqrt", "Square root of x >= 0.")
tanh = _elementary("tanh", "Hyperbolic tangent of x.")
atan = _elementary("atan", "Arc tangent of x [rad].")


def power(x, exponent):
    """x**exponent for x >= 0. A whole exponent from 1 to 8 is a product; any other has no Taylor series at x = 0."""
    if isinstance(exponent, (int, float)) and exponent == int(exponent) and 1 <= exponent <= 8:
        product = x
        for _ in range(int(exponent) - 1):
            product = product * x
        return product
    return (abs(x) if isinstance(x, (int, float)) else x) ** exponent


def stribeck_curve(speed, least, most, velocity, exponent):
    """least + (most - least) exp(-|speed/velocity|^exponent), for a speed >= 0."""
    return least + (most - least) * exp(-power(speed / velocity, exponent))


def bristle_slip(speed, bristle, stiffness, level):
    """Velocity at which bristles of this deflection slip, |v| xi/g with g = level/stiffness; speed: |v|."""
    return stiffness * speed * bristle / level


def limited(held, value, limit) -> Any:
    """A value behind a limit: `held` is +1 or -1 where the limit holds, 0 where it does not."""
    return (1.0 - held * held) * value + held * limit


def limit_guards(held, value, asked, limit) -> tuple:
    """Guards of a limit: it is reached in front, left, reached behind; asked: what has to come back."""
    at, free = held * held, 1.0 - held * held
    return (
        at + free * (limit - value) / limit,
        free + (held * asked - at * limit) / limit,
        at + free * (limit + value) / limit,
    )
