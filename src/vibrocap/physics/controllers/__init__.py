"""Controllers, one kind or family per file: what makes the command of what is measured and of a reference.

A controller is given measured quantities, its own states and the reference, which is the drive of the system; it gives
the command that the machine, or the actuator before it, obeys. Scalar functions alone; each knows its contract
(`controller.py`) and no other controller.
"""
