"""Scales: what one unit of each dimensionless quantity is in SI.

A machine declares in `si_scales` which record of scales it has: the pendulum capsule counts in the mass and length of
its pendulum, the oscillator in whatever units its parameters have.
"""

import math
from typing import Annotated, Any

from pydantic import AfterValidator

from vibrocap.physics.elementary import sqrt
from vibrocap.physics.parameters import (
    FORCE,
    LENGTH,
    NUMBER,
    SPEED,
    TORQUE,
    Dimension,
    Positive,
    dimension_of_unit,
    parameter,
    parameters,
)

STANDARD_GRAVITY_M_PER_S2 = 9.80665  # by definition (3rd CGPM, 1901)
EFFORTS = {"force": FORCE, "torque": TORQUE, "displacement": LENGTH, "speed": SPEED, "angle": NUMBER, "number": NUMBER}
# In place of an effort, of a law: at a contact that turns, where forces are torques and ways angles; and under a load
# that follows the motion, where the law acts per load, so that its stiffness is one over the load.
TURNING, PER_LOAD, TURNING_PER_LOAD = "turning", "per load", "turning, per load"


def _within_numbers(scale: float) -> float:
    """A scale, of which every unit that is made, up to that of power, kg m^2/s^3, is a number of the computer."""
    if not 1e-50 <= scale <= 1e50:
        raise ValueError("should be between 1e-50 and 1e50")
    return scale


Scale = Annotated[Positive, AfterValidator(_within_numbers)]


def resolved(dimension: Dimension, effort: str) -> Dimension:
    """A dimension in force, length and time, of a drive's effort, of a signal in its unit, or of a law (`PER_LOAD`)."""
    if effort not in (TURNING, PER_LOAD, TURNING_PER_LOAD):
        return dimension.resolved(EFFORTS[effort] if effort in EFFORTS else dimension_of_unit(effort))
    own, force = dimension.resolved(FORCE), dimension.force if effort == TURNING else 0.0
    return Dimension(force=force, length=own.length if effort == PER_LOAD else force, time=own.time)


class Scales:
    """What one unit of mass, length and time is in SI; all others follow.

    A record of scales has the numbers that say so as its fields, each with its unit in its name, and gives `units`.
    """

    @property
    def units(self) -> tuple[float, float, float]:
        """One unit of mass (kg), of length (m) and of time (s)."""
        raise NotImplementedError

    mass_kg = property(lambda self: self.units[0])
    length_m = property(lambda self: self.units[1])
    time_s = property(lambda self: self.units[2])

    def of(self, dimension: Dimension, effort: str = "force") -> float:
        """What one dimensionless unit of a quantity is in SI: m^a l^b t^c for its exponents of mass, length and time.

        effort: what the drive exerts, "force" or "torque"; of a law see `PER_LOAD`
        """
        own = resolved(dimension, effort)
        exponents = own.force, own.length + own.force, own.time - 2 * own.force
        above = below = 1.0
        for scale, exponent in zip(self.units, exponents, strict=True):
            if exponent > 0:
                above *= scale**exponent
            elif exponent < 0:
                below *= scale**-exponent
        return above / below


def oscillation(mass: Any, stiffness: Any, force: Any, time: Any) -> tuple[Any, Any]:
    """Amplitude and speed that a force gives a mass on a spring: F/|k + m omega^2| and omega times as much.

    omega^2 is that of the free vibration, k/m, plus that of a drive with the period `time`, so that no number but the
    mass need be there. 1.0 would be no size of a motion in SI.
    """
    stiffness = stiffness + mass * (2.0 * math.pi / time) * (2.0 * math.pi / time)
    return force / stiffness, force / sqrt(mass * stiffness)


@parameters
class SIScales(Scales):
    """Scales of a machine whose parameters may stand in any consistent units: in SI they stay as they are."""

    @property
    def units(self) -> tuple[float, float, float]:
        return 1.0, 1.0, 1.0


@parameters
class FreeScales(Scales):
    """Scales of a machine that declares none: the units of mass, length and time in which it counts are given."""

    mass_unit_kg: Scale = parameter(..., "m", "unit of mass", unit="kg")
    length_unit_m: Scale = parameter(..., "l", "unit of length", unit="m")
    time_unit_s: Scale = parameter(..., "t", "unit of time", unit="s")

    @property
    def units(self) -> tuple[float, float, float]:
        return self.mass_unit_kg, self.length_unit_m, self.time_unit_s


@parameters
class PendulumScales(Scales):
    """Scales of a pendulum of mass m and length l under gravity g_0: time in 1/omega_n = sqrt(l/g_0), force in m g_0.

    Liu et al. 2019, before eq. 4.
    """

    pendulum_mass_kg: Scale = parameter(..., "m", "mass of the pendulum", unit="kg")
    pendulum_length_m: Scale = parameter(..., "l", "length of the pendulum", unit="m")
    gravity_m_per_s2: Scale = parameter(STANDARD_GRAVITY_M_PER_S2, "g_0", "gravitational acceleration", unit="m/s^2")

    @property
    def units(self) -> tuple[float, float, float]:
        return self.pendulum_mass_kg, self.pendulum_length_m, math.sqrt(self.pendulum_length_m / self.gravity_m_per_s2)


@parameters
class WeightScales(Scales):
    """Scales of a machine that has weight: mass and length of one's choice, and time in sqrt(l/g_0)."""

    mass_unit_kg: Scale = parameter(..., "m", "unit of mass", unit="kg")
    length_unit_m: Scale = parameter(..., "l", "unit of length", unit="m")
    gravity_m_per_s2: Scale = parameter(STANDARD_GRAVITY_M_PER_S2, "g_0", "gravitational acceleration", unit="m/s^2")

    @property
    def units(self) -> tuple[float, float, float]:
        return self.mass_unit_kg, self.length_unit_m, math.sqrt(self.length_unit_m / self.gravity_m_per_s2)


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
