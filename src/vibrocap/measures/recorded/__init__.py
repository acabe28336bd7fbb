"""Measures of a recorded motion: travel, sticking, energy, loops of friction, and whether it has settled.

Given: a motion, or a stretch of it. Given back: numbers and records of them.
"""
