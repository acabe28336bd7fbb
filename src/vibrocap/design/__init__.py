"""Design: which drive, machine and friction serve best, found with exact motions only.

Given: a system, design variables with their bounds, an objective and constraints on measures. Populations of designs
run as ensembles (`population`) in a global search (`search`), whose populations can be stored; the best designs are
refined on closed orbits (`refinement`). Given back: an `Optimum`, with its orbit, its stability and what limits it.
"""
