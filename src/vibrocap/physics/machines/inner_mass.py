"""What machines with an inner mass on a line have in common: their scales, and the load that their weight makes."""

import math
from typing import Annotated, Any, ClassVar

from vibrocap.arguments import ArgumentError
from vibrocap.physics.dimensions.scales import STANDARD_GRAVITY_M_PER_S2, Scale, Scales
from vibrocap.physics.machines.machine import Machine, parameter, parameters
from vibrocap.physics.parameters import MOST, allowed

WEIGHT = "weight"
ROUNDING = 1e-9  # of gravity, within which scales count force in the weight of the inner mass


Load = Annotated[Any, allowed('a finite number >= 0 or "weight" (mass_ratio + 1, in units of m g)', (WEIGHT,), MOST)]


def load(unit: str) -> Any:
    """The load of such a machine, as a parameter of it."""
    plain = f'load on the contact{unit}: a number, or "weight" (lambda + 1, in units of m g)'
    return parameter(1.0, "N", plain, "load", in_si='load on the contact: a force, or "weight"')


@parameters
class InnerMassScales(Scales):
    """Scales of a machine that counts mass in that of its inner mass.

    Length is counted in a centimetre and time in sqrt(l/g), 32 milliseconds, unless they are given; force is then
    counted in the weight of the inner mass, m g. Errors are measured over these sizes: good units are the length of a
    stroke and the time of one radian of the drive.
    """

    inner_mass_kg: Scale = parameter(..., "m", "inner mass", unit="kg")
    length_unit_m: Scale = parameter(0.01, "l", "unit of length, such as the stroke of the inner mass", unit="m")
    time_unit_s: Scale | None = parameter(
        None, "1/omega_0", "unit of time, such as sqrt(m/k); sqrt(l/g) where it is left out", unit="s"
    )
    gravity_m_per_s2: Scale = parameter(STANDARD_GRAVITY_M_PER_S2, "g_0", "gravitational acceleration", unit="m/s^2")

    @property
    def units(self) -> tuple[float, float, float]:
        time = self.time_unit_s
        time = math.sqrt(self.length_unit_m / self.gravity_m_per_s2) if time is None else time
        return self.inner_mass_kg, self.length_unit_m, time


class WithInnerMass(Machine):
    """A body of mass lambda in which a mass 1 moves to and fro, on one contact under a constant load or its weight."""

    mass_ratio: Any
    normal_load: Any

    si_scales: ClassVar = InnerMassScales

    def check_scales(self, scales: Scales) -> None:
        """The weight is lambda + 1 where force is counted in m g: ArgumentError for it in other units."""
        gravity = getattr(scales, "gravity_m_per_s2", STANDARD_GRAVITY_M_PER_S2)
        counted = scales.length_m / scales.time_s**2
        if self.normal_load == WEIGHT and not abs(counted - gravity) <= ROUNDING * gravity:
            what = "which counts forces in m g; leave out time_unit_s, or give the load in N, normal_load_N"
            raise ArgumentError("machine.normal_load", f'should be "weight" with a unit of time sqrt(l/g), {what}')
