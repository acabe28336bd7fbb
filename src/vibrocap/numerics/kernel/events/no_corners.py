"""Drives without corners: what `corners.py` does is nothing for them, and UNTIL is the end of the period."""


def begin_drive(floats, ints, trace, lane, run):
    """Nothing to look up."""


def at_corner(floats, ints, trace, lane):
    """Never."""
    return False


def begin_drive_period(floats, ints, trace, lane):
    """Nothing begins anew."""
