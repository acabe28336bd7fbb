"""The contract of generated code of a driven law: what `driven_step.py` writes and `driven.py` calls by these names.

Linking puts the generated definitions in the place of these.
"""

STATES = 1
GUARDS = 0  # how many
MOVING = 1  # how many states move
SET_VALUED = False
SHARP_INTERNAL = False  # whether a sharp function depends on an internal state, see `resolution.py`

STATUS = STEPS = REFUSED = STEP_LIMIT = JUMPS = FORCE_START = INTERNAL_START = 0  # places in `ints`
PARAMETER = FROZEN = STATE = NEW = INVERSE_SCALE = 0  # places in `floats`
VELOCITY = LOAD = VELOCITY_RATE = LOAD_RATE = STEP = VISIBLE_SPEED = LEAP = 0


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
