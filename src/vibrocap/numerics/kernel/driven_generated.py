"""The contract of generated code of a driven law: what `driven_source.py` writes and `driven.py` calls by these names.

Linking puts the generated definitions in the place of these.
"""

STATES = 1
GUARDS = 0  # how many
MOVING = 1  # how many states move
SET_VALUED = False
SHARP_INTERNAL = False  # whether a sharp function depends on an internal state, see `resolution.py`


class Wholes:
    """Entries of `ints`."""

    status: int
    steps: int  # accepted
    refused: int
    step_limit: int
    jumps: int  # between two samples
    force_start: int  # places on the trace
    internal_start: int  # -1: internal states are not kept


class Numbers:
    """Entries of `floats`."""

    parameter: list[float]
    frozen: list[float]  # what depends on parameters and side only
    state: list[float]
    new: list[float]  # states at the end of the step
    inverse_scale: list[float]  # one over tolerance and natural size
    side: float
    velocity: float
    load: float
    velocity_rate: float
    load_rate: float
    step: float  # proposed
    visible_speed: float  # up to which friction changes fast
    leap: float  # longest change of a state within a step, over its tolerance


class Law(Wholes, Numbers):
    """What a law carries that is driven."""


law = Law()


def freeze(floats, side):
    """Compute what depends on parameters and the side only, from PARAMETER to FROZEN."""
    raise NotImplementedError


def attempt(floats, side, h) -> float:
    """Step of length h from STATE to NEW, VELOCITY and LOAD changing at their rates; returns error over tolerance."""
    raise NotImplementedError


def force(floats, at, v, w, side) -> float:
    """Friction force with the states at floats[at:at + STATES], velocity v and load w."""
    raise NotImplementedError


def least_guard(floats, at, v, w, side) -> tuple:
    """(value, number) of the guard that is least."""
    raise NotImplementedError


def switch(floats, at, which, v, w, side):
    """Change the states at floats[at:at + STATES] to those after guard `which` has fallen."""
    raise NotImplementedError


def reverse(floats, at, w, side):
    """Change the states at floats[at:at + STATES] to those after the contact has turned to `side`."""
    raise NotImplementedError
