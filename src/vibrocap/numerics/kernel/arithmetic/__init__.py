"""Arithmetic of kernels: elementary functions (`elementary_polynomials`) and first roots of polynomials (`roots`).

Lanes side by side are one value (`plain_vectors`, as many as `registers` hold); the same names mean one number where a
motion runs alone (`one_number`).
"""
