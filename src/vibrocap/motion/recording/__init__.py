"""A system's equations, recorded: from scalar physics to the graph that the numerics compile.

Given: a system. Given back: its equations, the corners of its drive and sections, for all systems of one form.
"""
