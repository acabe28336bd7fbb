"""The cubic controller: a spring that grows stiffer away from its goal."""

from typing import ClassVar

from vibrocap.physics.controllers.controller import Controller, Positive, parameter, parameters


@parameters
class Cubic(Controller):
    """A command proportional to the cube of the position error, nearly zero close to the goal.

    u = K e (e/l)^2,     e = r - x
    """

    gain: Positive = parameter(1.0, "K", "force or torque per length of error, at the error l", "position gain")
    distance: Positive = parameter(1.0, "l", "error at which the gain holds", "distance")

    name: ClassVar[str] = "cubic"
    source: ClassVar[str] = "vibrocap"
    reference: ClassVar = "displacement"

    def measures(self, machine) -> tuple[str, ...]:
        """The position."""
        return (machine.place or machine.cyclic,)

    def command(self, t, measured, own, reference, slope):
        """The command u."""
        error = (reference - measured[0]) / self.distance
        return self.gain * self.distance * error * error * error
