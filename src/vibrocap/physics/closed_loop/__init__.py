"""What stands between drive and machine: an actuator, and a controller that measures, samples and knows the dynamics.

Given: a machine and a controller. Given back: the machine of the closed loop.
"""
