"""SI <-> dimensionless, both ways: masses in kg, lengths in m, torques in N m and so on.

`Scales` says what one unit of each dimensionless quantity is in SI. A part in SI is a record of its own whose fields
carry their units; each field knows the dimensionless parameter that it becomes and the scale between the two, so that
both ways are one table. All this stands beside `system` and not among the machines because a scale needs a machine's
pendulum but converts the drive and the friction law as well.
"""

import dataclasses
import math
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator

from vibrocap.physics.drives.biharmonic import Biharmonic
from vibrocap.physics.drives.harmonic import Harmonic
from vibrocap.physics.friction.exponential import Exponential
from vibrocap.physics.friction.law import levels_in_order
from vibrocap.physics.friction.lugre import LuGre
from vibrocap.physics.machines.pendulum_capsule import PendulumCapsule
from vibrocap.physics.parameters import NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.system import System

STANDARD_GRAVITY_M_S2 = 9.80665  # by definition (3rd CGPM, 1901)


@parameters
class Scales:
    """What one unit of each dimensionless quantity is in SI, for a pendulum of mass m and length l under gravity g.

    Time is counted in units of 1/omega_n = sqrt(l/g), length in l, mass in m (Liu et al. 2019, before eq. 4); all else
    follows. A dimensionless quantity times its scale is the quantity in SI.
    """

    pendulum_mass_kg: Positive = parameter(..., "m", "mass of the pendulum [kg]")
    pendulum_length_m: Positive = parameter(..., "l", "length of the pendulum [m]")
    gravity_m_s2: Positive = parameter(STANDARD_GRAVITY_M_S2, "g_0", "gravitational acceleration [m/s^2]")

    @property
    def one(self) -> float:
        """Scale of what has no unit (angles in radians, coefficients)."""
        return 1.0

    @property
    def mass_kg(self) -> float:
        """m."""
        return self.pendulum_mass_kg

    @property
    def length_m(self) -> float:
        """l."""
        return self.pendulum_length_m

    @property
    def frequency_rad_s(self) -> float:
        """omega_n = sqrt(g/l)."""
        return math.sqrt(self.gravity_m_s2 / self.pendulum_length_m)

    @property
    def time_s(self) -> float:
        """1/omega_n = sqrt(l/g)."""
        return math.sqrt(self.pendulum_length_m / self.gravity_m_s2)

    @property
    def velocity_m_s(self) -> float:
        """l omega_n = sqrt(g l)."""
        return math.sqrt(self.gravity_m_s2 * self.pendulum_length_m)

    @property
    def inverse_velocity_s_m(self) -> float:
        """1/(l omega_n)."""
        return 1.0 / self.velocity_m_s

    @property
    def force_N(self) -> float:
        """m l omega_n^2 = m g, the weight of the pendulum."""
        return self.pendulum_mass_kg * self.gravity_m_s2

    @property
    def torque_N_m(self) -> float:
        """m l^2 omega_n^2 = m g l; also the scale of a torsional spring [N m/rad]."""
        return self.force_N * self.pendulum_length_m

    @property
    def torsional_damping_N_m_s(self) -> float:
        """m l^2 omega_n [N m s/rad]."""
        return self.torque_N_m * self.time_s

    @property
    def stiffness_N_m(self) -> float:
        """m g/l, of a spring along the line of travel [N/m]."""
        return self.force_N / self.pendulum_length_m

    @property
    def damping_N_s_m(self) -> float:
        """m g/(l omega_n) = m omega_n, of a damper along the line of travel [N s/m]."""
        return self.force_N / self.velocity_m_s

    @property
    def energy_J(self) -> float:
        """m g l."""
        return self.torque_N_m

    @property
    def power_W(self) -> float:
        """m g l omega_n."""
        return self.energy_J * self.frequency_rad_s

    @property
    def momentum_N_s(self) -> float:
        """m l omega_n."""
        return self.force_N * self.time_s

    def of(self, name: str) -> float:
        """Scale of a named quantity of a motion ("time", "position", "friction", "drive_work", ...).

        `motion[name]` times this is in the unit `MOTION_UNITS[name]`. KeyError for a name without a scale ("side").
        """
        return getattr(self, _SCALE_OF_UNIT[MOTION_UNITS[name]])


# Unit of each quantity that a motion can be asked for.
MOTION_UNITS = {
    "time": "s",
    "angle": "rad",
    "angle_rate": "rad/s",
    "position": "m",
    "velocity": "m/s",
    "sliding_velocity": "m/s",
    "bristle": "m",
    "bristle_rate": "m/s",
    "contact_velocity": "m/s",
    "friction": "N",
    "holding_force": "N",
    "drive": "N m",
    "energy": "J",
    "contact_energy": "J",
    "momentum": "N s",
    "outer_force": "N",
    "reaction": "N",
    "holding_limit": "N",
    "holding_middle": "N",
    "impulse": "N s",
    "drive_work": "J",
    "damper_work": "J",
    "belt_work": "J",
    "contact_sliding_work": "J",
    "bristle_loss_work": "J",
    "contact_storage_work": "J",
}
_SCALE_OF_UNIT = {
    "s": "time_s",
    "rad": "one",
    "rad/s": "frequency_rad_s",
    "m": "length_m",
    "m/s": "velocity_m_s",
    "N": "force_N",
    "N m": "torque_N_m",
    "J": "energy_J",
    "N s": "momentum_N_s",
}


def _scaled(value: Any, factor: float) -> Any:
    """The value times the factor; a word ("weight") or none says the same in both."""
    return value if value is None or isinstance(value, str) else value * factor


class PartInSI:
    """What every part in SI offers.

    dimensionless_part: the record that it becomes. quantities: its fields, each with the parameter that it becomes and
    the scale between them: field = parameter * scale.
    """

    dimensionless_part: ClassVar[type]
    quantities: ClassVar[dict[str, tuple[str, str]]]

    def dimensionless(self, scales: Scales) -> Any:
        """The same part without units."""
        values: dict[str, Any] = {}
        for name, (to, scale) in self.quantities.items():
            value, factor = getattr(self, name), getattr(scales, scale)
            values[to] = value if value is None or isinstance(value, str) else value / factor
        return self.dimensionless_part(**values)


def _checked_load(given: Any) -> Any:
    if given == "weight" or (isinstance(given, (int, float)) and not isinstance(given, bool) and 0 <= given < 1e300):
        return given
    raise ValueError('should be a finite number >= 0 [N] or "weight" (of capsule and pendulum)')


@parameters
class PendulumCapsuleInSI(PartInSI):
    """The pendulum capsule as it stands on a bench: masses, lengths, spring and damper in SI; it sets the scales."""

    capsule_mass_kg: Positive = parameter(..., "M", "mass of the capsule without the pendulum [kg]")
    pendulum_mass_kg: Positive = parameter(..., "m", "mass of the pendulum [kg]")
    pendulum_length_m: Positive = parameter(..., "l", "length of the pendulum [m]")
    torsional_stiffness_N_m_rad: NonNegative = parameter(..., "k", "torsional spring at the pivot [N m/rad]")
    torsional_damping_N_m_s_rad: NonNegative = parameter(..., "c", "viscous damper at the pivot [N m s/rad]")
    normal_load_N: Annotated[Any, BeforeValidator(_checked_load)] = parameter(
        "weight", "N_0", 'load on the contact [N], or "weight", (M + m) g'
    )
    gravity_m_s2: Positive = parameter(STANDARD_GRAVITY_M_S2, "g_0", "gravitational acceleration [m/s^2]")

    dimensionless_part: ClassVar = PendulumCapsule
    quantities: ClassVar = {
        "capsule_mass_kg": ("mass_ratio", "mass_kg"),
        "torsional_stiffness_N_m_rad": ("stiffness", "torque_N_m"),
        "torsional_damping_N_m_s_rad": ("damping", "torsional_damping_N_m_s"),
        "normal_load_N": ("normal_load", "force_N"),
    }

    @property
    def scales(self) -> Scales:
        """The scales that this pendulum sets."""
        return Scales(self.pendulum_mass_kg, self.pendulum_length_m, self.gravity_m_s2)


@parameters
class HarmonicInSI(PartInSI):
    """Harmonic drive torque A cos(Omega t)."""

    amplitude_N_m: Number = parameter(..., "A", "drive torque [N m]")
    frequency_rad_s: Positive = parameter(..., "Omega", "angular frequency of the drive [rad/s]")

    dimensionless_part: ClassVar = Harmonic
    quantities: ClassVar = {
        "amplitude_N_m": ("amplitude", "torque_N_m"),
        "frequency_rad_s": ("frequency", "frequency_rad_s"),
    }


@parameters
class BiharmonicInSI(PartInSI):
    """Biharmonic drive torque A cos(Omega t) + A2 cos(2 Omega t + psi)."""

    amplitude_N_m: Number = parameter(..., "A", "drive torque [N m]")
    frequency_rad_s: Positive = parameter(..., "Omega", "angular frequency of the drive [rad/s]")
    second_amplitude_N_m: Number = parameter(0.0, "A2", "torque of the second harmonic [N m]")
    second_phase: Number = parameter(0.0, "psi", "phase of the second harmonic [rad]")

    dimensionless_part: ClassVar = Biharmonic
    quantities: ClassVar = {
        "amplitude_N_m": ("amplitude", "torque_N_m"),
        "frequency_rad_s": ("frequency", "frequency_rad_s"),
        "second_amplitude_N_m": ("second_amplitude", "torque_N_m"),
        "second_phase": ("second_phase", "one"),
    }


@parameters
class ExponentialInSI(PartInSI):
    """Exponential law with its rate per m/s. The coefficients have no unit: the law multiplies them by the load."""

    coulomb_coefficient: NonNegative = parameter(..., "eta_c", "friction coefficient at high speed")
    static_coefficient: NonNegative = parameter(..., "eta_s", "friction coefficient at rest")
    decay_rate_s_m: NonNegative = parameter(..., "a_0", "rate of the drop from static to Coulomb level [s/m]")

    dimensionless_part: ClassVar = Exponential
    quantities: ClassVar = {
        "coulomb_coefficient": ("coulomb_coefficient", "one"),
        "static_coefficient": ("static_coefficient", "one"),
        "decay_rate_s_m": ("decay_rate", "inverse_velocity_s_m"),
    }

    _levels = levels_in_order


@parameters
class LuGreInSI(PartInSI):
    """LuGre law in SI: F = sigma0 z + sigma1 z' + sigma2 v, with z in m and v in m/s.

    The load is in the steady level g alone (erratum 1 of the paper), so the bristles' stiffness and damping are those
    of the whole contact, in N/m and N s/m, not per unit of load: delta0 = sigma0 l/(m g), delta1 = sigma1/(m omega_n).
    """

    bristle_stiffness_N_m: Positive = parameter(..., "sigma0", "stiffness of the bristles [N/m]")
    bristle_damping_N_s_m: NonNegative = parameter(..., "sigma1", "damping of the bristles [N s/m]")
    viscous_damping_N_s_m: NonNegative = parameter(..., "sigma2", "viscous friction coefficient [N s/m]")
    coulomb_coefficient: Positive = parameter(..., "eta_c", "friction coefficient at high speed")
    static_coefficient: Positive = parameter(..., "eta_s", "friction coefficient at rest")
    stribeck_velocity_m_s: Positive = parameter(
        ..., "V_s", "speed over which friction drops from static to Coulomb level [m/s]"
    )
    stribeck_exponent: Positive = parameter(2.0, "alpha", "shape of the drop (2: Gaussian)")
    damping_velocity_m_s: Positive | None = parameter(
        None, "V_d", "speed over which the damping of the bristles fades [m/s]; none: it stays"
    )

    dimensionless_part: ClassVar = LuGre
    quantities: ClassVar = {
        "bristle_stiffness_N_m": ("bristle_stiffness", "stiffness_N_m"),
        "bristle_damping_N_s_m": ("bristle_damping", "damping_N_s_m"),
        "viscous_damping_N_s_m": ("viscous_damping", "damping_N_s_m"),
        "coulomb_coefficient": ("coulomb_coefficient", "one"),
        "static_coefficient": ("static_coefficient", "one"),
        "stribeck_velocity_m_s": ("stribeck_velocity", "velocity_m_s"),
        "stribeck_exponent": ("stribeck_exponent", "one"),
        "damping_velocity_m_s": ("damping_velocity", "velocity_m_s"),
    }

    _levels = levels_in_order


PARTS_IN_SI = (PendulumCapsuleInSI, HarmonicInSI, BiharmonicInSI, ExponentialInSI, LuGreInSI)


@dataclasses.dataclass(frozen=True)
class SystemInSI:
    """A system whose parts are given in SI: machine, friction law and drive.

    `system.dimensionless()` is what `simulate` takes; `SystemInSI.of` is the way back, exact to rounding.
    """

    machine: PendulumCapsuleInSI
    friction: ExponentialInSI | LuGreInSI
    drive: HarmonicInSI | BiharmonicInSI

    @property
    def scales(self) -> Scales:
        """The scales between this system and the dimensionless one."""
        return self.machine.scales

    def dimensionless(self) -> System:
        """The same system without units."""
        scales = self.scales
        return System(*(part.dimensionless(scales) for part in (self.machine, self.friction, self.drive)))

    @classmethod
    def of(cls, system: System, scales: Scales) -> "SystemInSI":
        """A dimensionless system in SI by the scales given. TypeError for a part that has no record in SI."""
        return cls(*(_part_in_si(part, scales) for part in (system.machine, system.friction, system.drive)))


def _part_in_si(part: Any, scales: Scales) -> Any:
    for record in PARTS_IN_SI:
        if type(part) is record.dimensionless_part:
            values = {
                name: _scaled(getattr(part, to), getattr(scales, scale))
                for name, (to, scale) in record.quantities.items()
            }
            if record is PendulumCapsuleInSI:
                values |= {field.name: getattr(scales, field.name) for field in dataclasses.fields(scales)}
            return record(**values)
    there_are = ", ".join(record.__name__ for record in PARTS_IN_SI)
    raise TypeError(f"{type(part).__name__} has no record in SI; there are {there_are}")
