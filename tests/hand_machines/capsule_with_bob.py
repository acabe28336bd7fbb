"""What capsules have in common whose inner mass goes round a pivot: a pendulum, or the eccentric mass of a rotor."""

import math
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator

from vibrocap.physics.dimensions.scales import STANDARD_GRAVITY_M_PER_S2
from vibrocap.physics.machines.machine import (
    Body,
    Contact,
    Machine,
    Mechanism,
    Positive,
    Scales,
    cos,
    parameter,
    parameters,
    sin,
)

LOADS = ("weight", "dynamic")


def _checked_load(given: Any) -> Any:
    number = isinstance(given, (int, float)) and not isinstance(given, bool)
    if given in LOADS if isinstance(given, str) else number and 0 <= given < 1e300:
        return given
    raise ValueError(
        'should be a finite number >= 0 (in units of m g), "weight" (mass_ratio + 1) or "dynamic" (of the motion)'
    )


Load = Annotated[Any, BeforeValidator(_checked_load)]
SPRING = parameter(2.0, "rho", "torsional spring, k/(m l^2 omega_n^2)", "torsional stiffness", in_si="torsional spring")
DAMPER = parameter(
    1.0,
    "nu",
    "viscous damper at the pivot, c/(m l^2 omega_n)",
    "torsional damping",
    in_si="viscous damper at the pivot",
)


def load(default: Any) -> Any:
    """The load of a capsule with a bob, as a parameter of the machine."""
    return parameter(
        default,
        "N",
        'load on the contact over m g: a number, "weight" (lambda + 1) or "dynamic" (what the motion makes)',
        "load",
        in_si='load on the contact: a force, "weight" or "dynamic" (what the motion makes)',
    )


@parameters
class PendulumScales(Scales):
    """Scales of a pendulum of mass m and length l under gravity g_0 (Liu et al. 2019, before eq. 4).

    Mass is counted in m, length in l and time in 1/omega_n = sqrt(l/g_0), so that forces are counted in the weight of
    the pendulum, m g_0.
    """

    pendulum_mass_kg: Positive = parameter(..., "m", "mass of the pendulum", unit="kg")
    pendulum_length_m: Positive = parameter(..., "l", "length of the pendulum", unit="m")
    gravity_m_per_s2: Positive = parameter(STANDARD_GRAVITY_M_PER_S2, "g_0", "gravitational acceleration", unit="m/s^2")

    @property
    def units(self) -> tuple[float, float, float]:
        """m, l, 1/omega_n = sqrt(l/g_0)."""
        return self.pendulum_mass_kg, self.pendulum_length_m, math.sqrt(self.pendulum_length_m / self.gravity_m_per_s2)


class CapsuleWithBob(Machine):
    """What swings or turns about a pivot on a capsule: a bob at the distance 1, under a torque P (Liu et al. 2019).

    With B = lambda + 1 - cos^2(theta), theta from upright,

        theta'' = [(lambda+1) P - sin(theta) cos(theta) theta'^2 - R cos(theta)] / B
        X''     = [cos(theta) P - sin(theta) theta'^2 - R] / B
    """

    mass_ratio: Any
    damping: Any

    states: ClassVar = ("angle", "angle_rate", "position", "velocity")
    cyclic: ClassVar = "position"
    contact_states: ClassVar = ("velocity",)
    symmetry: ClassVar = (-1, -1, -1, -1)
    channels: ClassVar = ("drive", "damper")
    effort: ClassVar = "torque"
    si_scales: ClassVar = PendulumScales
    si_names: ClassVar = {"mass_ratio": "capsule_mass"}
    gravity: ClassVar = (1.0, 0.0)

    @property
    def follows_load(self) -> bool:
        """Whether normal_load is "dynamic"."""
        return isinstance(self.normal_load, str) and self.normal_load == "dynamic"

    def loads(self):
        """N, where it is constant; of a load that follows the motion its mean, the weight (lambda + 1) g_n."""
        word = isinstance(self.normal_load, str)
        return (self._towards_ground(self.mass_ratio + 1.0) if word else self.normal_load,)

    def masses(self):
        """lambda + 1, of which the bob's share also turns the pendulum (`gravity`)."""
        return {"velocity": self.mass_ratio + 1.0}

    def _towards_ground(self, mass):
        """Weight of a mass, normal to the line: g_n times it."""
        return mass if self.level else self.gravity[0] * mass

    def _inertia(self, y):
        """B."""
        return self.mass_ratio + 1.0 - cos(y[0]) * cos(y[0])

    def _reaction(self, y, drive):
        """(B, (lambda+1) [B g_n - sin(theta) P] - lambda cos(theta) theta'^2, sin(theta) cos(theta))."""
        inertia, sine, cosine = self._inertia(y), sin(y[0]), cos(y[0])
        own = (self.mass_ratio + 1.0) * (self._towards_ground(inertia) - sine * self._torque(y, drive))
        return inertia, own - self.mass_ratio * (cosine * (y[1] * y[1])), sine * cosine

    def vertical_momentum(self, t, y):
        """(cos(theta))' = -sin(theta) theta', of the bob."""
        return -(sin(y[0]) * y[1])

    def _torque(self, y, drive):
        """P, all torques on the pendulum but the capsule's inertia."""
        weight = self._towards_ground(sin(y[0]))
        if not self.level:
            weight = weight + self.gravity[1] * cos(y[0])
        return self._less_spring(drive + weight, y) - self.damping * y[1]

    def _less_spring(self, torque, y):
        """A torque, less that of the spring at the pivot where there is one."""
        return torque

    def _held(self, y, drive):
        """R that keeps X'' = 0: cos(theta) P - sin(theta) theta'^2 (eq. 9)."""
        return cos(y[0]) * self._torque(y, drive) - sin(y[0]) * (y[1] * y[1])

    def contacts(self, t, y, drive):
        """X', what holds the capsule, and the load that the bob makes."""
        return (Contact(y[3], self._held(y, drive), reaction=self._reaction(y, drive)),)

    def accelerations(self, t, y, drive, force):
        """(theta'', X'') of eq. 9, in the form X'' = (holding force - R)/B, theta'' = P + cos(theta) X'' (eq. 4).

        y: (theta, theta', X, X') [1]   drive: torque [1]   force: friction force R [1]
        """
        capsule = (self._held(y, drive) - force) / self._inertia(y)
        return self._torque(y, drive) + cos(y[0]) * capsule, capsule

    def rates(self, t, y, drive, frictions) -> tuple:
        """y' = (theta', theta'', X', X'')."""
        pendulum, capsule = self.accelerations(t, y, drive, frictions[0])
        return y[1], pendulum, y[3], capsule

    def energy(self, t, y):
        """H = (lambda+1) X'^2/2 + theta'^2/2 - cos(theta) theta' X' + g_n cos(theta) - g_t sin(theta).

        With the energy of the spring, where there is one. The weight along a slope does work on the capsule besides, as
        nothing depends on X.
        """
        kinetic = 0.5 * (self.mass_ratio + 1.0) * y[3] * y[3] + 0.5 * y[1] * y[1] - cos(y[0]) * y[1] * y[3]
        total = self._with_spring(kinetic, y) + self._towards_ground(cos(y[0]))
        return total if self.level else total - self.gravity[1] * sin(y[0])

    def _with_spring(self, energy, y):
        """An energy, with that of the spring at the pivot where there is one."""
        return energy

    def momentum(self, t, y):
        """p = (lambda+1) X' - cos(theta) theta'; p' = -R (eq. 5)."""
        return (self.mass_ratio + 1.0) * y[3] - cos(y[0]) * y[1]

    def _with_bob(self, y, bob, stiffness=0.0) -> Mechanism:
        """Capsule and bob, which stands under this name in the scene."""
        turning = Body(bob, 1.0, "hinge", y[0], y[1], "capsule", stiffness, self.damping, actuation=1.0)
        return Mechanism((Body("capsule", self.mass_ratio, place=y[2], rate=y[3], contact=0), turning))

    def powers(self, t, y, drive, frictions) -> tuple:
        """Power of the drive, drive theta', and of the damper, -nu theta'^2."""
        return drive * y[1], -self.damping * y[1] * y[1]
