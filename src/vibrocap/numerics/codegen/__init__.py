"""Writes kernels' text: what one system's equations make of the contracts `generated` and `driven_generated`.

Given: recorded equations (`expressions/`) and a memory layout. Given back: Python source, without loops and branches
where it can be: Taylor series (`jets`, `mechanics_series`), in an order in which no sum waits (`straight_line`); rates,
Jacobian and what is measured (`source`); the proof that a step sees all of the law (`resolution`); a law under an
imposed motion (`driven_source`, `driven_step`).
"""
