from typing import ClassVar

from vibrocap.physics.machines.consistent_units import ConsistentUnits
from vibrocap.physics.machines.machine import NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Potential, Spring, Support, coordinate


@parameters
class ModeCouplingBlock(ConsistentUnits):
    """Block on a belt, on springs that couple its motion along the belt, x, to that towards it, y.

    The smallest model in which a constant friction coefficient makes vibrations (Hoffmann, Fischer, Allgaier and Gaul,
    Mech. Res. Comm. 29, 2002, 197-205): pressed on, the block is pulled along. N = N_0 + k3 y, and k22 holds the
    stiffness k3 of the contact. On a faster belt, R = -mu N, the stiffness matrix is [[k11, k12 - mu k3], [k12, k22]]:
    without damping two frequencies meet, at sqrt((k11 + k22)/(2 m)), and one vibration grows, where

        mu > [(k11 - k22)^2/(4 k12) + k12]/k3

    The run ends where N falls to zero. Any consistent units may be used.
    """

    mass: Positive = parameter(1.0, "m", "mass of the block", "mass")
    sliding_stiffness: Positive = parameter(2.0, "k11", "stiffness along the belt", "stiffness")
    coupling_stiffness: Number = parameter(0.5, "k12", "stiffness that couples both directions", "stiffness")
    normal_stiffness: Positive = parameter(
        1.6, "k22", "stiffness towards the belt, the contact's included", "stiffness"
    )
    contact_stiffness: NonNegative = parameter(1.2, "k3", "stiffness of the contact", "stiffness")
    damping: NonNegative = parameter(0.0, "c", "viscous damper, in each direction", "viscous damping")
    belt_speed: Number = parameter(1.0, "v_b", "speed of the belt under the block", "speed")
    normal_load: Positive = parameter(1.0, "N_0", "load on the contact where y = 0", "load")

    name: ClassVar[str] = "mode-coupling-block"
    source: ClassVar[str] = "hoffmann2002"
    approach = coordinate("y", "place of the block towards the belt", "m")
    position = coordinate("x", "place of the block along the belt", "m", rate="sliding_velocity")
    gravity: ClassVar = None
    si_load: ClassVar = "1 where the coefficients of the law are forces in N"

    def parts(self, q):
        belt, block = Support("belt", x=self.belt_speed * q.time), Mass("block", self.mass, x=q.position, z=-q.approach)
        springs = Spring(self.sliding_stiffness, q.position), Spring(self.normal_stiffness, q.approach)
        coupling = Potential(self.coupling_stiffness * (q.position * q.approach))
        dampers = Damper(self.damping, q.position), Damper(self.damping, q.approach)
        pressed = Contact(block, on=belt, load=self.normal_load + self.contact_stiffness * q.approach)
        return [belt, block, *springs, coupling, *dampers, Drive(q.position), pressed]

    def sized_by(self):
        """k11, along the belt."""
        return self.sliding_stiffness
