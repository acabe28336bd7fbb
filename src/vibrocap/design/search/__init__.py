"""The parts of a search for designs.

Given a system, variables with their bounds, goals and what is uncertain (`problem`, `variables`, `goal`,
`uncertainty`; `fitted`: what a fit leaves uncertain), this room runs populations of designs as ensembles
(`population`), evolves and stores them (`evolution`, `search_store`) and refines the best on closed orbits
(`refinement`), along exact gradients (`ascent`). Imports go one way:

    evolution -> population | search_store -> problem -> goal | variables | uncertainty -> fitted
    refinement -> ascent -> problem
"""
