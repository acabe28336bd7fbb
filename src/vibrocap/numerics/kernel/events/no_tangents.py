"""Motions without a tangent: what `tangents.py` does is nothing for them."""


def tangent_waits(ints, lane):
    """Never."""
    return False


def leave_piece(floats, ints, lane, event, contact, h):
    """Nothing to carry over."""


def stay_in_piece(ints, lane):
    """Nothing waits."""


def enter_piece(floats, ints, lane):
    """Nothing to carry over."""


def tangents_wait(ints, plain):
    """The lanes that are plain stay so."""
    return plain
