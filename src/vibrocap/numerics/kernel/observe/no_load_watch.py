"""Loads that nothing has to be said of: what `load_watch.py` does is nothing for them."""


def watch_load(floats, ints, lane, h):
    """Nothing to look at."""


def look_at_load(floats, ints, lane, h):
    """Nothing to look at."""
