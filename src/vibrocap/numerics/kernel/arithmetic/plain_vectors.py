"""Lanes as one value: a number, or a yes or no, for each of `lane_count` trajectories.

What acts on each lane alone is of one number, too.

These are the names and their meaning, on NumPy arrays. In a compiled kernel the values live in vector registers
(`compiler/lanes.py`).
"""

import builtins
import functools

import numpy as np

from vibrocap.numerics.kernel.arithmetic import one_number

floor, square_root = np.floor, np.sqrt
exponent, mantissa, power_of_two = one_number.exponent, one_number.mantissa, one_number.power_of_two


@functools.cache
def lane_count() -> int:
    """8 where registers hold eight doubles (AVX-512), else 4.

    Eight in pairs of registers of four would wait in memory most of the time, as there are half as many registers too:
    with the LuGre law a sweep took a quarter longer. A run gives the same in eight lanes and in four.
    """
    from vibrocap.numerics.compiler.machine import host  # only here: plain kernels need no LLVM

    return host().lanes


def all_lanes():
    """The places of all lanes in a row that begins at 0."""
    return np.arange(lane_count())


def align_stack():
    """Nothing to align."""


def where(choice, one, other):
    """One number where the choice is true, else the other; the choice and both numbers may be of all lanes."""
    return np.where(choice, one, other) if np.ndim(choice) else one if choice else other


def max(*numbers):
    """The largest of numbers as Python has it, of all lanes where any is."""
    if any(map(np.ndim, numbers)):
        return functools.reduce(lambda one, other: np.where(other > one, other, one), numbers)
    return builtins.max(*numbers)


def min(*numbers):
    """The least of numbers as Python has it, of all lanes where any is."""
    if any(map(np.ndim, numbers)):
        return functools.reduce(lambda one, other: np.where(other < one, other, one), numbers)
    return builtins.min(*numbers)


def load(floats, place):
    """The numbers of all lanes at a place of `floats`, or of `ints`."""
    return floats[place : place + lane_count()].copy()


def store(floats, place, numbers):
    """Write the numbers of all lanes."""
    floats[place : place + lane_count()] = numbers


def bits(choices):
    """As an integer, bit i for lane i."""
    return sum(1 << lane for lane, choice in enumerate(np.atleast_1d(choices)) if choice)
