"""Runs of which no evidence is taken, as those of a page: what `evidence.py` does is nothing for them."""


def take_evidence(floats, ints, lane, h):
    """Nothing to ask."""
