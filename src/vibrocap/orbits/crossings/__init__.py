"""Parameters at which a measure of the steady motion takes a value.

Given a system (or two, to compare laws), a measure and the range of a parameter, `crossing` gives every place where the
measure passes the value, with its error, and says where it equals the value throughout or jumps over it.
"""
