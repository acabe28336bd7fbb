"""A machine on which the drive imposes a motion, written by hand."""

from typing import Any, ClassVar

from vibrocap.physics.machines.machine import Contact, Machine


class Imposed(Machine):
    """A machine in which the drive is a motion, of which its functions need the slope and the curvature too.

    Their contact velocity depends on the time, and jumps where the slope of the drive does.
    """

    imposed: ClassVar[Any] = None  # the drive, of a machine that `driven_by` gave

    def driven_by(self, drive) -> Any:
        """The same machine, which knows the drive."""
        copy = object.__new__(type(self))
        vars(copy).update(vars(self) | {"imposed": drive})
        return copy


class ImposedDisplacement(Imposed):
    """A body with an inner mass whose displacement z along the line is imposed; the ground acts on nothing else.

    The state is the position and p, the velocity of the common centre of mass, which continues where z' jumps:

        X' = p - mu z',     (lambda + 1) p' = -R,     mu = 1/(lambda + 1)

    in units of the inner mass. At rest the contact holds R = -z''.
    """

    mass_ratio: Any
    states: ClassVar = ("position", "centre_velocity")
    cyclic: ClassVar = "position"
    contact_states: ClassVar = ("centre_velocity",)
    symmetry: ClassVar = (-1, -1)
    channels: ClassVar = ("drive", "damper")
    state_units: ClassVar = {"centre_velocity": "m/s"}

    def displacement(self, t) -> tuple:
        """(z', z''); that of the drive itself."""
        return self.imposed.slope(t), self.imposed.curvature(t)

    def _velocity(self, t, y):
        """X' = p - mu z'."""
        return y[1] - self.displacement(t)[0] / (self.mass_ratio + 1.0)

    def contacts(self, t, y, drive):
        """X', and R = -z'' that keeps X'' = 0."""
        return (Contact(self._velocity(t, y), holding_force=-self.displacement(t)[1]),)

    def rates(self, t, y, drive, frictions):
        """y' = (X', p')."""
        return self._velocity(t, y), -frictions[0] / (self.mass_ratio + 1.0)

    def energy(self, t, y):
        """H = (lambda + 1) p^2/2, of the common centre."""
        return 0.5 * (self.mass_ratio + 1.0) * y[1] * y[1]

    def momentum(self, t, y):
        """(lambda + 1) p; its rate is -R."""
        return (self.mass_ratio + 1.0) * y[1]

    def powers(self, t, y, drive, frictions):
        """What of the power of the drive moves the common centre, -mu z' R; a damper is the drive's affair."""
        return -(self.displacement(t)[0] * frictions[0]) / (self.mass_ratio + 1.0), 0.0
