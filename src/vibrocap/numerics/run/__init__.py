"""Runs kernels, and returns arrays.

One motion, recorded (`motion`); many, measured as they run, on threads or a device (`ensemble`);
a law under an imposed motion (`driven_run`). All but the last take a `Budget` and begin in one way
(`budget`). The hooks of a run answer for stored motions too (`replay`, `stroboscope`).
"""
