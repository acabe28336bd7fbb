"""A number of one motion alone, under the names by which `elementary_polynomials.py` knows the numbers of all lanes."""

import math

import numpy as np

MANTISSA_BITS, ONE_BITS = 2**52 - 1, 1023 * 2**52
LAST_DIGITS = 1.5 * 2.0**52 + 1023.0


def where(choice, one, other):
    """One number where the choice is true, else the other."""
    return one if choice else other


def load(floats, place):
    """The number at a place."""
    return floats[place]


def store(floats, place, number):
    """Write the number to a place."""
    floats[place] = number


def bits(choice):
    """1 where the choice is true."""
    return 1 if choice else 0


def floor(x):
    """The largest whole number up to x, as a float."""
    return np.floor(x)


def square_root(x):
    """The square root."""
    return math.sqrt(x)


def exponent(x):
    """Exponent e of x = m 2^e with 1 <= m < 2."""
    return ((np.float64(x).view(np.int64) >> 52) & 2047) - 1023.0


def mantissa(x):
    """m of x = m 2^e with 1 <= m < 2."""
    return np.int64((np.float64(x).view(np.int64) & MANTISSA_BITS) | ONE_BITS).view(np.float64)


def power_of_two(k):
    """2^k: the last binary digits of the sum are k + 1023."""
    return np.int64(np.float64(k + LAST_DIGITS).view(np.int64) << 52).view(np.float64)
