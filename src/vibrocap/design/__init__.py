"""Design: which drive, machine and friction serve best, found with exact motions only.

Given: a system, what may vary or is uncertain, and measures. Given back: the best settled, stable design (`optimise`),
a Pareto front (`front`), how sure a measure is (`robustness`), what no design can better (`bounds`), or parameters that
explain a measured table (`calibration`). What a search is made of stands in `search`.
"""
