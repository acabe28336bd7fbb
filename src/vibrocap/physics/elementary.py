"""Elementary functions of the physics, for numbers and for recorded expressions alike.

The equations of a law, a machine or a drive are written once, as scalar code on `+ - * /` and the functions below.
Called with floats they compute; called with an object that has a method of the same name (a recorded expression, a
SymPy wrapper) they record. That is how one source serves plain Python, compiled code, series, derivatives and proofs.

Behind them stand the few functions that several kinds of parts share: the bristles of a contact, as friction laws and
observers of friction know them, and a limit of a value, reached in front and behind, which never branches on a value.
"""

import math
from typing import Any

HELD_AFTER = (1.0, 0.0, -1.0)  # what `held` is after each of the guards of a limit


def sin(x):
    """Sine of x [rad]."""
    return x.sin() if hasattr(x, "sin") else math.sin(x)


def cos(x):
    """Cosine of x [rad]."""
    return x.cos() if hasattr(x, "cos") else math.cos(x)


def exp(x):
    """Exponential of x."""
    return x.exp() if hasattr(x, "exp") else math.exp(x)


def log(x):
    """Natural logarithm of x > 0."""
    return x.log() if hasattr(x, "log") else math.log(x)


def sqrt(x):
    """Square root of x >= 0."""
    return x.sqrt() if hasattr(x, "sqrt") else math.sqrt(x)


def tanh(x):
    """Hyperbolic tangent of x."""
    return x.tanh() if hasattr(x, "tanh") else math.tanh(x)


def atan(x):
    """Arc tangent of x [rad]."""
    return x.atan() if hasattr(x, "atan") else math.atan(x)


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
