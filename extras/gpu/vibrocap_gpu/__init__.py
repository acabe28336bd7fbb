"""Ensembles of vibrocap on an NVIDIA GPU: a device for `vibrocap.ensemble`, `vibrocap.sweep` and `vibrocap sweep`.

The GPU (`driver`) runs threads (`thread`), whose code is made of the package's own kernels (`ptx`), through all runs
(`ensemble`).
"""
