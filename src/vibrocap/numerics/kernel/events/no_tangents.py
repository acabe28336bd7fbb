"""Motions without a tangent: what `tangents.py` does is nothing for them."""


def tangent_waits(whole, lane):
    """Never."""
    return False


def leave_piece(real, whole, lane, event, h):
    """Nothing to carry over."""


def enter_piece(real, whole, lane):
    """Nothing to carry over."""


def tangents_wait(whole, plain):
    """The lanes that are plain stay so."""
    return plain
