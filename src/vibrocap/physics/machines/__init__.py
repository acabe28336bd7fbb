"""Machines, one family per file.

A machine is given its parameters and then its state, the drive and the friction force; it gives back the rates of its
state, the force that would hold its contact, its energy and its powers by channel. `machine.py` is the contract.
"""
