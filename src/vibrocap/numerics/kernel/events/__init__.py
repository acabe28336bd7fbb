"""Events within a step, which happen where a guard falls to zero, and what they change.

The contact sticks, slips, turns (`contact`); a law goes over to another of its branches (`law_branches`); a tangent is
carried through by saltation (`tangents`).
"""
