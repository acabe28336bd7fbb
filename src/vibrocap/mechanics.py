"""The vocabulary of your own machines: parts, coordinates, parameters and elementary functions, under one name.

For example `from vibrocap.mechanics import Contact, Machine, Mass, Spring, coordinate, parameters`.
"""

from vibrocap.physics.elementary import atan, cos, exp, log, sin, sqrt, tanh
from vibrocap.physics.machines.machine import Machine, NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import (
    Contact,
    Damper,
    Drag,
    Drive,
    Inertia,
    Mass,
    MechanicsError,
    Motor,
    Point,
    Potential,
    Spring,
    Stop,
    Support,
    coordinate,
    distance,
    offset,
    signal,
)

__all__ = ["Contact", "Damper", "Drag", "Drive", "Inertia", "Machine", "Mass", "MechanicsError", "Motor"]
__all__ += ["NonNegative", "Number", "Point", "Positive", "Potential", "Spring", "Stop", "Support", "atan"]
__all__ += ["coordinate", "cos", "distance", "exp", "log", "offset", "parameter", "parameters", "signal", "sin", "sqrt"]
__all__ += ["tanh"]
