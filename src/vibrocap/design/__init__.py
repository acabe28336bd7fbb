"""Design: which drive, machine and friction serve best, found with exact motions only.

Input: a system, variables or uncertain quantities, and measures. Output: the best settled, stable design (`optimise`),
a Pareto front (`front`), the distribution of a measure (`robustness`), bounds of performance (`bounds`), or parameters
that explain a measured table (`calibration`). `search` holds the parts of a search.
"""
