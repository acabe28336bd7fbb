"""Arithmetic of kernels: lanes side by side as one value (`plain_vectors`, as many as `registers` hold), the same names
for one number alone (`one_number`), and elementary functions of either (`elementary_polynomials`).
"""
