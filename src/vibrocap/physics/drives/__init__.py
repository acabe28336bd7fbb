"""Drives, one family of waveforms per file.

A drive is given its parameters and then the time; it gives back its value, its period, and whether it is odd under half
of it. `drive.py` is the contract.
"""
