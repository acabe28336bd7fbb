"""What machines have in common whose parameters stand in any consistent units, SI as well as none."""

from typing import Any, ClassVar

from vibrocap.physics.dimensions.scales import SIScales, oscillation
from vibrocap.physics.machines.machine import Machine


class ConsistentUnits(Machine):
    """A machine of masses on springs, whose natural sizes follow from its loads."""

    stiffness: Any
    si_scales: ClassVar = SIScales

    def sized_by(self):
        """The stiffness by which the sizes are told."""
        return self.stiffness

    def scales(self, time=1.0):
        """Amplitude and speed that a force of the size of all loads gives to all masses, of each coordinate."""
        sizes = oscillation(self.evaluated("whole_mass"), self.sized_by(), self.effort_scale(), time)
        return sizes * len(self.coordinates) + (1.0,) * len(self.switched)

    def effort_scale(self):
        return sum(self.loads())
