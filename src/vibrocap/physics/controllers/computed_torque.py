"""Computed torque: a motion is tracked exactly, with the force or torque that the machine's own equations ask for."""

from typing import ClassVar

from vibrocap.physics.controllers.controller import CURVATURE, OWN, AccelerationController
from vibrocap.physics.elementary import cos, sin
from vibrocap.physics.parameters import NonNegative, Number, Positive, parameter, parameters

LYING = 1e-3  # cosine of the angle at which a pendulum counts as lying


@parameters
class ComputedTorque(AccelerationController):
    """The acceleration of what is tracked is that of the reference, and what the errors ask for besides.

        y'' = r'' + K_D (r' - y') + K_P (r - y)

    by the force or torque that gives it under the friction at the contacts, whether they slide or rest (Spong,
    Hutchinson and Vidyasagar 2006, section 8.3; Spong 1994 where other coordinates move along). The controller knows
    the machine, its loads and its friction, not the drag of an environment on masses that rub on nothing: the error
    falls as the two gains say, whatever the contacts do. A limit of the force or torque is reached and left at located
    events. Where the slope of the reference jumps, its curvature has an impulse, which is left out.
    """

    proportional_gain: NonNegative = parameter(
        1.0, "K_P", "acceleration per error, the square of its natural frequency", unit="1/s^2"
    )
    derivative_gain: NonNegative = parameter(2.0, "K_D", "acceleration per rate of error", unit="1/s")
    limit: Positive | None = parameter(None, "u_max", "largest force or torque; none where there is no limit", "effort")

    source: ClassVar[str] = "spong2006; spong1994"

    def command(self, t, measured, own, reference, slope):
        """r'' + K_D (r' - y') + K_P (r - y), the acceleration of the state."""
        place, rate, curvature = measured
        return self._ordered(place, rate, curvature, reference, slope)

    def _ordered(self, place, rate, curvature, reference, slope):
        return curvature + self.derivative_gain * (slope - rate) + self.proportional_gain * (reference - place)


@parameters
class AngleComputedTorque(ComputedTorque):
    """Computed torque of an angle, such as that of a pendulum or a rotor; the reference is the angle wanted."""

    measured: str = parameter(OWN, "theta", "the state that is tracked; own: the state angle of the machine")

    name: ClassVar[str] = "angle-computed-torque"
    reference: ClassVar = "angle"


@parameters
class StrokeComputedTorque(ComputedTorque):
    """Computed torque of a pendulum's stroke sin(theta) - s_0, the displacement of its bob along the line in lengths l.

    The reference is the stroke wanted, which moves the capsule as the displacement of an inner mass does (`crawler`):

        theta'' = [(sin theta)'' + sin(theta) theta'^2] / cos(theta)

    Without a limit and on its reference the capsule is the pendulum crawler of that motion. A run ends with the status
    "singular command" where the pendulum all but lies, which no torque brings further.
    """

    origin: Number = parameter(0.0, "s_0", "displacement of the bob from which the stroke counts", unit="m")

    name: ClassVar[str] = "stroke-computed-torque"
    reference: ClassVar = "displacement"
    bound_kinds: ClassVar = ("singular_command",)

    @property
    def odd(self) -> bool:  # type: ignore[override]
        return self.origin == 0.0

    def compared(self, machine) -> None:
        """None: it is the stroke that follows."""

    def measures(self, machine) -> tuple[str, ...]:
        return "angle", "angle_rate", CURVATURE

    def bounds(self, measured) -> tuple:
        """cos(theta) is positive, and a little more."""
        return (cos(measured[0]) - LYING,)

    def command(self, t, measured, own, reference, slope):
        """theta'', by which sin(theta) has the acceleration that is ordered."""
        angle, rate, curvature = measured
        ordered = self._ordered(sin(angle) - self.origin, cos(angle) * rate, curvature, reference, slope)
        return (ordered + sin(angle) * (rate * rate)) / cos(angle)


@parameters
class PositionComputedForce(ComputedTorque):
    """Computed force of a displacement, such as that of a mass in its capsule; the reference is the one wanted.

    It cannot be the place of a body that comes to rest: its friction would be cancelled, at rest as well.
    """

    measured: str = parameter(OWN, "z", "the state that is tracked; own: the first state of the machine")

    name: ClassVar[str] = "position-computed-force"
    reference: ClassVar = "displacement"
