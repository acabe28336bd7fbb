"""Laws of one branch on each side: what `law_branches.py` does is nothing for them."""


def within_bounds(floats, ints, trace, lane):
    """Always."""
    return True


def branch_holds(floats, ints, trace, lane):
    """Always."""
    return True


def first_switch(floats, lane, event, h):
    """The event known so far."""
    return event, h


def begin_branch(floats, ints, trace, lane, which):
    """There is none to begin."""


def turned(floats, lane, contact):
    """A reversal changes nothing but the side."""


def guards_at(floats, lane, s, out):
    """There is none."""


def interpolated_guards(floats, lane, h):
    """There is none."""
