from typing import ClassVar

from vibrocap.physics.machines.capsule_with_bob import CAPSULE, DAMPER, SPRING, CapsuleWithBob, Load, load
from vibrocap.physics.machines.machine import NonNegative, Positive, parameters
from vibrocap.physics.mechanics.parts import Spring


@parameters
class PendulumCapsule(CapsuleWithBob):
    """Inverted pendulum (mass m, length l) on a capsule (mass M), joined by a torsional spring and a viscous damper.

    The drive torque swings the pendulum, whose reaction pushes the capsule against friction. With
    B = lambda + 1 - cos^2(theta) and P = drive + sin(theta) - rho theta - nu theta' (Liu et al. 2019, eq. 9):

        theta'' = [(lambda+1) P - sin(theta) cos(theta) theta'^2 - R cos(theta)] / B
        X''     = [cos(theta) P - sin(theta) theta'^2 - R] / B

    Time is in units of sqrt(l/g), length in l, mass in m: `PendulumScales`. N = 1, the default without units, is the
    weight of the pendulum, m g; that on the contact is lambda + 1, normal_load = "weight" (erratum 1). In SI there is
    no default. With normal_load = "dynamic" the load follows the bob, N = lambda + 1 + (cos(theta))'', and with eq. 9

        B N = (lambda+1) [B - sin(theta) P] - lambda cos(theta) theta'^2 + sin(theta) cos(theta) R

    Its mean over a period of a motion that repeats is lambda + 1. The capsule lifts off where N falls to zero.
    """

    mass_ratio: Positive = CAPSULE
    stiffness: NonNegative = SPRING
    damping: NonNegative = DAMPER
    normal_load: Load = load(1.0)

    name: ClassVar[str] = "pendulum-capsule"
    source: ClassVar[str] = "liu2019"
    si_load: ClassVar = (
        '"weight" for that of capsule and pendulum, (M + m) g, or "dynamic" (the ground\'s reaction); there is no '
        "default, because the one without units, 1, is the weight of the pendulum alone"
    )

    def parts(self, q):
        return [*super().parts(q), Spring(self.stiffness, q.angle)]
