"""Branches of cycles that nothing drives in time: their sections, and where they are born or lose their stick.

Given the map of a cycle and a point of its branch, `cycles_followed` gives the points, the special points and the end,
as `following` does of driven motions.
"""
