"""A machine under a controller: what is measured, when it is sampled, and inverse dynamics.

Given: a machine and a controller. Given back: the machine of the closed loop.
"""
