"""Quantities: what each number of a result is, and the one walker that gives results their units.

A record extends `Dimensional` and says by the type of each field what it is (`declared.py`: `period: Time`, `drift:
Length | None`, `state: States`); so do public functions by the types of their arguments and of what they return. The
rooms compute without units. `in_si` shows a result of a system that knows its scales in SI, and `opening.py` makes the
public functions take and answer in SI; both read the declarations.
"""
