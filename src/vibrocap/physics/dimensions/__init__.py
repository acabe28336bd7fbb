"""Units: what one unit of each quantity is, keys in SI, and systems in SI made dimensionless.

Given: parts with numbers in SI, or scales. Given back: parts without units, factors, names of units.
"""
