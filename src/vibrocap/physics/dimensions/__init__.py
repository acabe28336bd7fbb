"""Units: what one unit of each quantity is, keys in SI, systems in SI made dimensionless; what parts keep of others.

Given: parts with numbers in SI, or scales. Given back: parts without units, factors, names of units.
"""
