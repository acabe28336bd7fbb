"""Friction laws, one family per file.

A law is given its parameters (checked, with defaults) and then a velocity, its internal states, the side of sliding and
the load; it gives back the friction force and the rates of its states. `law.py` is the contract; `wrappers.py` makes
laws of laws.
"""
