"""A motion: how a system moves in time, and how exact that is.

`simulate` is given a system, its start and a number of drive periods. `equations` records what the physics says into
the graph that the numerics compile, once for all systems of one form. What comes back is a `Trajectory`: every state at
every instant, the events of the contact, the status of the run in words, and the certificate of how exact it is.
"""
