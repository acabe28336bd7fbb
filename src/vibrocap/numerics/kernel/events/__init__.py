"""Events within a step: the first root of a guard (`roots`), and what it changes.

The contact sticks, slips, turns (`contact`); a law goes over to another of its branches (`law_branches`; `one_branch`
for laws that have one); a tangent is carried through by saltation (`tangents`; `no_tangents` where none is followed).
"""
