"""Equilibria: steady sliding and intervals of rest of systems that nothing drives in time, and what becomes of them.

Given a system, `equilibria` finds its states of steady sliding and its sets of rest, with their eigenvalues; given a
parameter and its range, `equilibrium_branch` follows one state of steady sliding and locates its folds and Hopf points,
each by an equation of its own. All derivatives are exact: they are taken of the recorded equations.
"""
