"""The tandem: two blocks on a belt, joined by a spring, a spring holds the first one to a wall."""

from typing import ClassVar

from vibrocap.physics.machines.machine import Machine, Number, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Drive, Mass, Spring, Support, coordinate


@parameters
class Tandem(Machine):
    """A spring joins block 1 to a wall, another one block 2 of mass mu to block 1; a belt runs under both.

    The drive acts on block 1. Each block has its own contact with the belt. Units are the mass, spring and load of
    block 1.
    """

    mass_ratio: Positive = parameter(0.8, "mu", "mass of block 2 over that of block 1", "mass")
    coupling_stiffness: Positive = parameter(1.2, "kappa", "spring between the blocks", "stiffness")
    belt_speed: Number = parameter(0.3, "v_b", "speed of the belt", "speed")
    normal_load: Positive = parameter(1.0, "N", "load on block 1", "load")
    normal_load_2: Positive = parameter(1.0, "N_2", "load on block 2", "load")

    name: ClassVar[str] = "tandem"
    source: ClassVar[str] = "vibrocap"
    position = coordinate("x", "position of each block", "m", rate="sliding_velocity", count=2)

    def parts(self, q):
        """Blocks on the belt."""
        belt, (first, second) = Support("belt", x=self.belt_speed * q.time), q.position
        blocks = Mass("block 1", 1.0, x=first), Mass("block 2", self.mass_ratio, x=second)
        springs = Spring(1.0, first), Spring(self.coupling_stiffness, second - first)
        loads = zip(blocks, (self.normal_load, self.normal_load_2), strict=True)
        return belt, blocks, springs, Drive(first), [Contact(block, on=belt, load=load) for block, load in loads]
