"""The two-mass capsule: a mass on a spring and a damper inside a capsule, driven along the line of sliding."""

from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator

from hand_machines.inner_mass import Load, WithInnerMass
from vibrocap.physics.bodies import capsule_with_mass
from vibrocap.physics.machines.machine import (
    Body,
    Contact,
    Mechanism,
    NonNegative,
    Positive,
    Shape,
    parameter,
    parameters,
)

ACTUATIONS = ("internal", "external")


def _checked_actuation(given: Any) -> Any:
    if isinstance(given, str) and given in ACTUATIONS:
        return given
    raise ValueError('should be "internal" (the drive acts between the masses) or "external" (on the mass alone)')


Actuation = Annotated[str, BeforeValidator(_checked_actuation)]


@parameters
class TwoMassCapsule(WithInnerMass):
    """Inner mass m on a spring and a damper in a capsule M; both move along one line.

    With z the displacement of the mass in the capsule, and the force F that pulls it back,

        z'' + X'' = drive - F,     lambda X'' = F - drive - R,     F = rho z + nu z'

    A drive between the masses pushes the capsule back, as here. One that pulls the mass from outside, a magnet for
    instance (actuation = "external"), does not: lambda X'' = F - R (Liu et al. 2013).

    Time is in units of 1/omega_0 for a frequency omega_0 of one's choice, mass in m, length in a length l of one's
    choice and force in m l omega_0^2; the load is a force in that unit. Nothing rises or falls: the load is constant.
    Where force is counted in m g, as in SI, normal_load = "weight" is that of capsule and mass, lambda + 1.
    """

    mass_ratio: Positive = parameter(
        2.5, "lambda", "capsule mass over inner mass, M/m", "mass", in_si="mass of the capsule"
    )
    stiffness: NonNegative = parameter(1.0, "rho", "spring, k/(m omega_0^2)", "stiffness", in_si="spring")
    damping: NonNegative = parameter(
        0.1, "nu", "viscous damper, c/(m omega_0)", "viscous damping", in_si="viscous damper"
    )
    normal_load: Load = parameter(
        1.0,
        "N",
        'load on the contact over m l omega_0^2: a number, or "weight" (lambda + 1, in units of m g)',
        "load",
        in_si='load on the contact: a force, or "weight"',
    )
    actuation: Actuation = parameter(
        "internal", "a", 'where the drive acts: "internal", between the masses, or "external", on the mass alone'
    )

    name: ClassVar[str] = "two-mass-capsule"
    source: ClassVar[str] = "chernousko2002; liu2013"
    states: ClassVar = ("displacement", "displacement_rate", "position", "velocity")
    cyclic: ClassVar = "position"
    contact_states: ClassVar = ("velocity",)
    symmetry: ClassVar = (-1, -1, -1, -1)
    channels: ClassVar = ("drive", "damper")
    si_load: ClassVar = '"weight" for that of capsule and inner mass, (M + m) g'
    si_names: ClassVar = {"mass_ratio": "capsule_mass"}

    @property
    def _external(self) -> bool:
        return self.actuation == "external"

    def masses(self):
        """lambda and 1."""
        return {"velocity": self.mass_ratio, "displacement_rate": 1.0}

    def pull(self, y):
        """F, what pulls the mass back to its place in the capsule."""
        return self.stiffness * y[0] + self.damping * y[1]

    def _held(self, t, y, drive):
        """R that keeps X'' = 0: what the mass and the drive do to the capsule."""
        return self.pull(y) if self._external else self.pull(y) - drive

    def contacts(self, t, y, drive):
        """X', and what holds the capsule."""
        return (Contact(y[3], self._held(t, y, drive)),)

    def rates(self, t, y, drive, frictions) -> tuple:
        """y' = (z', z'', X', X''), with X'' = (holding force - R)/lambda."""
        capsule = (self._held(t, y, drive) - frictions[0]) / self.mass_ratio
        return y[1], drive - self.pull(y) - capsule, y[3], capsule

    def energy(self, t, y):
        """H = lambda X'^2/2 + (X' + z')^2/2 + rho z^2/2."""
        inner = y[3] + y[1]
        return 0.5 * self.mass_ratio * y[3] * y[3] + 0.5 * inner * inner + 0.5 * self.stiffness * y[0] * y[0]

    def momentum(self, t, y):
        """p = lambda X' + (X' + z')."""
        return (self.mass_ratio + 1.0) * y[3] + y[1]

    def outer_force(self, t, y, drive):
        """The drive, where it pulls from outside."""
        return drive if self._external else 0.0

    def powers(self, t, y, drive, frictions) -> tuple:
        """Power of the drive, drive z' (from outside: drive (X' + z')), and of the damper, -nu z'^2."""
        path = y[3] + y[1] if self._external else y[1]
        return drive * path, -self.damping * y[1] * y[1]

    def mechanism(self, t, y) -> Mechanism | None:
        """The inner mass on its spring in the capsule; a drive from outside acts on both joints."""
        outside = 1.0 if self._external else 0.0
        capsule = Body("capsule", self.mass_ratio, place=y[2], rate=y[3], actuation=outside, contact=0)
        joint = {"place": y[0], "rate": y[1], "carrier": "capsule", "actuation": 1.0}
        return Mechanism((capsule, Body("inner mass", 1.0, stiffness=self.stiffness, damping=self.damping, **joint)))

    def scene(self, t, y) -> tuple[Shape, ...]:
        """The capsule, and in it the mass on its spring."""
        spring = Shape("spring", "spring", ((y[2] - 0.9, 0.4), (y[2] + y[0] - 0.15, 0.4)))
        return *capsule_with_mass(y[2], y[2] + y[0]), spring
