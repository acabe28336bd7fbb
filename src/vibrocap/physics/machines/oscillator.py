from typing import ClassVar

from vibrocap.physics.machines.consistent_units import ConsistentUnits
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, Support, coordinate
from vibrocap.physics.parameters import NonNegative, Number, Positive, parameter, parameters


@parameters
class Oscillator(ConsistentUnits):
    """Block of mass m on a spring k and a damper c, on a belt of the speed v_b, moved by the force of the drive.

    The oldest machine of dry friction (Den Hartog 1931), and with a running belt the standard test of stick-slip. The
    block is at x; v = x' - v_b, over the belt, is the state, so that it is exactly zero while the contact sticks. A
    block that is pulled over fixed ground through a spring, whose far end moves at the speed V, is the same system: v_b
    = -V, and the stretch of the spring is -x (`pulled`). Without a spring it is a mass on the ground. Any consistent
    units may be used; with a law whose coefficients are forces in N, the normal load is 1.
    """

    mass: Positive = parameter(1.0, "m", "mass of the block", "mass")
    stiffness: NonNegative = parameter(1.0, "k", "stiffness of the spring", "stiffness")
    damping: NonNegative = parameter(0.0, "c", "viscous damper beside the spring", "viscous damping")
    belt_speed: Number = parameter(0.0, "v_b", "speed of the belt under the block", "speed")
    normal_load: Positive = parameter(
        1.0, "N", "load on the contact; 1 where the coefficients of the law are forces", "load"
    )

    name: ClassVar[str] = "oscillator"
    source: ClassVar[str] = "denhartog1931"
    position = coordinate("x", "place of the block", "m", rate="sliding_velocity")
    si_load: ClassVar = "1 where the coefficients of the law are forces in N"

    @classmethod
    def pulled(cls, speed: float, **given: float) -> "Oscillator":
        """The block that is pulled at a speed through its spring over fixed ground; `given`: the other parameters.

        Its spring pulls with -k x, and the block has moved by x + V t.
        """
        return cls(belt_speed=-speed, **given)

    def parts(self, q):
        belt, block = Support("belt", x=self.belt_speed * q.time), Mass("block", self.mass, x=q.position)
        wall = Spring(self.stiffness, q.position), Damper(self.damping, q.position)
        return [belt, block, *wall, Drive(q.position), Contact(block, on=belt, load=self.normal_load)]
