"""Pictures of steady motions: branches, equilibria, basins and bifurcation diagrams.

Given: the records of `orbits`. Given back: figures.
"""
