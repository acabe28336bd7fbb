"""Runs that wait: none goes on from an extrapolated limit."""


def begin_marks(ints, lane):
    """Nothing is kept."""


def note_event(floats, ints, lane, event, c):
    """Nothing is kept."""


def starts_trial(floats, ints, lane):
    """Never."""
    return False


def trial_fails(floats, ints, lane):
    """There is none."""
    return False


def ends_trial(floats, ints, lane):
    """There is none."""
    return False
