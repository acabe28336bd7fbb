"""Slips: what the stick-slip of a force record is made of.

Given a `Pull`, it gives back the phases (`phases`, with their `corners`), the `periods` between slips with their drift,
and the regime of the motion; `records/stick_slip.py` says them together.
"""
