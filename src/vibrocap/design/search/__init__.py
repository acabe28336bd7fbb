"""The parts of a search for designs.

Given a system, variables with their bounds, goals and what is uncertain (`problem`, `variables`, `uncertainty`), this
room runs populations of designs as ensembles (`population`), evolves and stores them (`evolution`) and refines the best
on closed orbits (`refinement`), along exact gradients (`ascent`). Imports go one way:

    evolution -> population -> problem -> uncertainty -> variables
    refinement -> ascent -> problem
"""
