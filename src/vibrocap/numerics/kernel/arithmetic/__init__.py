"""Arithmetic of kernels: elementary functions (`elementary_polynomials`), roots and turns of polynomials (`roots`).

Lanes side by side are one value (`plain_vectors`); the same names mean one number where a
motion runs alone (`one_number`).
"""
