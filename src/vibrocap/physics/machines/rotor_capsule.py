import math
from typing import ClassVar

from vibrocap.physics.machines.capsule_with_bob import CapsuleWithBob, Load, load
from vibrocap.physics.machines.machine import NonNegative, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import coordinate


@parameters
class RotorCapsule(CapsuleWithBob):
    """Eccentric mass (mass m, eccentricity l) turned by a motor on a capsule (mass M), which its reaction pushes.

    The motor is one of limited power: the faster it turns, the less torque it has left,

        P = T + sin(theta) - nu theta',     nu = T/Omega_0              Kononenko 1969, linear characteristic

    where T is the drive, the torque at standstill, which the voltage of a direct-current motor sets, and Omega_0 the
    speed at which nothing of it is left (damping of the bearings adds to nu). So the speed follows from the motion of
    the capsule; it may be caught at a resonance, or stop where T cannot lift the mass. A constant drive is a motor that
    is switched on. The equations are those of `PendulumCapsule` under this P, with theta from upright; all have the
    period 2 pi in theta, and the number of whole turns in a period of a motion is its winding number.

    Units as of the pendulum capsule. The load is the weight lambda + 1, another constant or "dynamic".
    """

    mass_ratio: Positive = parameter(
        4.0, "lambda", "capsule mass over eccentric mass, M/m", "mass", in_si="mass of the capsule"
    )
    damping: NonNegative = parameter(
        0.75, "nu", "fall of the motor's torque over its speed (stall torque over no-load speed)", "torsional damping"
    )
    normal_load: Load = load("weight")

    name: ClassVar[str] = "rotor-capsule"
    source: ClassVar[str] = "kononenko1969"
    angle = coordinate("theta", "angle of the rotor from upright", "rad", repeats=2.0 * math.pi)
    bob: ClassVar[str] = "eccentric mass"
    si_load: ClassVar = (
        '"weight" for that of capsule and eccentric mass, (M + m) g, or "dynamic" for the reaction of the ground'
    )
