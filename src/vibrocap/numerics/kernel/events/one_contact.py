"""Machines with one contact: what `decision.py` does is nothing for them."""


def decide_together(floats, ints, lane):
    """Its own force decides, see `contact.decide`."""
