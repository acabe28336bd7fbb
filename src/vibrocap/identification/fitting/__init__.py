"""Fits: `fit` drives a law by measured motions, `steady_fit` uses its steady curve, `spring_fit` pulls it by a spring.

Each is given records and a law and gives back a `Fit`. They differ in the prediction only; `solution` does the rest.
"""
