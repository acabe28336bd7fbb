"""Orbits closed to rounding, stable or not, modulo the drift.

Given a system and a start, `orbit` simulates until the motion settles and closes it by Newton's method; `shoot` closes
an orbit near a given state. Both give an `Orbit` with its period, drift and Floquet multipliers, and a status that says
what to try where none closed. Settling runs iterate the map until motions repeat, and are matched with the orbits that
they lead to.
"""
