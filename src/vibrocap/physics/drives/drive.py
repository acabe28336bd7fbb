"""The contract of a drive: one waveform per file in this folder, the generalised force that the actuator applies."""

from typing import ClassVar

from vibrocap.physics.elementary import cos
from vibrocap.physics.parameters import Number, Positive, parameter, parameters
from vibrocap.physics.part import Part

__all__ = ["Drive", "Number", "Positive", "cos", "parameter", "parameters"]


class Drive(Part):
    """What every drive offers: its value, its period, and whether it is odd under half a period."""

    name: ClassVar[str]

    def value(self, t):
        """Drive at time t, periodic with `period`."""
        raise NotImplementedError

    @property
    def period(self) -> float:
        """Time after which the drive repeats."""
        raise NotImplementedError

    @property
    def odd(self) -> bool:
        """Whether value(t + period/2) = -value(t); then the half-period symmetry of the capsule holds."""
        raise NotImplementedError
