from typing import ClassVar

from vibrocap.physics.machines.machine import NonNegative, parameter, parameters
from vibrocap.physics.machines.stops import BACK_GAP, BackGap
from vibrocap.physics.machines.two_mass_capsule import TwoMassCapsule
from vibrocap.physics.mechanics.parts import Stop
from vibrocap.physics.parameters import Fraction


@parameters
class RigidStopCapsule(TwoMassCapsule):
    """Two-mass capsule in which the inner mass strikes a rigid wall: forward, and back too where `back_gap` is given.

    By Newton's law of impact z' := -e z', which takes lambda/(lambda + 1) (1 - e^2) z'^2/2; dry friction is finite and
    has no impulse then. Rebounds of a mass that is pushed against the wall accumulate in a finite time (Zeno). Those
    slower than 1e-7 natural speeds, which would rise by rounding only, are left out: the masses continue together, with
    the momentum that they have, until the wall would have to pull.
    """

    restitution: Fraction = parameter(0.5, "e", "coefficient of restitution of the stops, 0 to 1", "fraction")
    gap: NonNegative = parameter(0.2, "delta", "gap between mass and front stop", "gap")
    back_gap: BackGap = BACK_GAP

    name: ClassVar[str] = "rigid-stop-capsule"
    source: ClassVar[str] = "liu2013; brogliato2016"

    def parts(self, q):
        stop = Stop(q.displacement, self.gap, self.back_gap, restitution=self.restitution)
        return [*super().parts(q), stop]
