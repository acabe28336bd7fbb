"""Steady motions: what a capsule does in the long run, its stability, and how it changes with a parameter.

A steady motion is periodic up to a shift of the position, the drift. This room is given systems, and gives back orbits
with their Floquet multipliers (`closing`), branches of them with their special points and the parameters at which a
measure takes a value (`continuation`), attractors, basins and Lyapunov exponents (`attractors`). All of them look at
the system through its stroboscopic map (`maps`); states at which nothing changes but the travel are `equilibria`.
Whatever is followed over a parameter is followed by one `walk`. Imports go one way:

    attractors, continuation -> closing, equilibria -> maps -> walk
"""
