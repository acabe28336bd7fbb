"""A drive as an input: the caller of a stepper sets it, and it is held until the next setting."""

from typing import ClassVar

from vibrocap.physics.drives.drive import Number, Piecewise, Positive, Segment, parameter, parameters
from vibrocap.physics.system import System

INPUT_NAMES = ("value", "slope", "curvature")


@parameters
class HeldInput(Piecewise):
    """v + w s + c s^2/2 in the time s since the input was set: one segment, of which a stepper sets the numbers.

    As the segment of any drive with corners it stands behind the parameters, so that one set of equations serves all
    inputs. Machines whose motion the drive imposes need its slope and curvature; a force is held with both at 0.
    """

    unit_time: Positive = parameter(1.0, "T", "time scale of the motion: the period of the drive that it replaces")
    value_held: Number = parameter(0.0, "v", "value at the start")
    slope_held: Number = parameter(0.0, "w", "slope at the start")
    curvature_held: Number = parameter(0.0, "c", "curvature")

    name: ClassVar[str] = "input"

    def segments(self) -> tuple[Segment, ...]:
        whole = self.unit_time
        square = 0.5 * self.curvature_held * whole * whole
        return (Segment(1.0, (self.value_held, self.slope_held * whole, square)),)

    @property
    def period(self) -> float:
        return self.unit_time


def with_held_input(system: System) -> System:
    """The same system with an input in place of its drive."""
    return System.of_parts({**system.parts, "drive": HeldInput(system.drive.period)}, system.units)
