"""Drives without corners: what `corners.py` does is nothing for them, and UNTIL is the end of the period."""


def begin_drive(real, whole, tape, lane, run):
    """Nothing to look up."""


def at_corner(real, whole, tape, lane):
    """Never."""
    return False


def begin_drive_period(real, whole, tape, lane):
    """Nothing begins anew."""
