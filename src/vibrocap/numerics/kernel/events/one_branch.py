"""Laws of one branch on each side: what `law_branches.py` does is nothing for them."""


def within_bounds(real, whole, tape, lane):
    """Always."""
    return True


def branch_holds(real, whole, tape, lane):
    """Always."""
    return True


def first_switch(real, lane, event, h):
    """The event known so far."""
    return event, h


def begin_branch(real, whole, tape, lane, which):
    """There is none to begin."""


def turned(real, lane):
    """A reversal changes nothing but the side."""


def interpolated_guards(real, lane, h):
    """There is none."""
