"""What one unit of each dimensionless quantity is in SI, and the units of a motion."""

import math

from vibrocap.physics.parameters import Positive, parameter, parameters

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
    "impulse": "N s",
    "drive_work": "J",
    "damper_work": "J",
    "belt_work": "J",
    "contact_sliding_work": "J",
    "bristle_loss_work": "J",
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
