"""Sliding mode: a command that is all or nothing brings a motion onto a line of its errors and holds it there."""

from typing import ClassVar

from vibrocap.physics.controllers.controller import OWN, AccelerationController
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.parameters import Positive, parameter, parameters

NEAR = 1e-6  # of the line, as an error: where a motion counts as on it from its start
LATE = 2e-13  # of the line, as an error: by so much it is passed as it is reached; half of that is on it


@parameters
class SlidingMode(AccelerationController):
    """A command of full size against the sliding variable s, set-valued where that is zero, as friction is at rest.

        u in -u_max Sgn(s),     s = (y' - r') + c (y - r)

    (Utkin 1977). Where the command can, it keeps the motion on s = 0, as a contact sticks: it then is whatever force or
    torque holds it there under the friction at the contacts, the equivalent control, within +-u_max, and the error
    decays as exp(-c t) whatever the machine is. The line is reached and left at located events, `command_unsaturated`
    and `command_saturated`, so that nothing chatters. Rounding is led back to it at the rate c.
    """

    convergence_rate: Positive = parameter(1.0, "c", "rate at which errors decay on the line", unit="1/s")
    limit: Positive = parameter(1.0, "u_max", "force or torque beside the line, the most that there is", "effort")

    source: ClassVar[str] = "utkin1977"

    @property
    def switch_events(self) -> tuple[str, ...]:
        """Leaving the line forward, starting behind it, reaching it, starting before it, leaving it back."""
        leaves, reaches = "command_saturated", "command_unsaturated"
        return leaves, leaves, reaches, leaves, leaves

    def _errors(self, measured, reference, slope) -> tuple:
        place, rate, _ = measured
        return (rate - slope) + self.convergence_rate * (place - reference), rate - slope

    def command(self, t, measured, own, reference, slope):
        """y'' = r'' - c (y' - r') - c s, by which s stays at zero."""
        away, rate = self._errors(measured, reference, slope)
        return measured[2] - self.convergence_rate * rate - self.convergence_rate * away

    def effort_switches(self, effort, t, measured, own, reference, slope) -> tuple:
        """Of the ends of the command while on the line, and of the line while beside it. effort: that holds it there"""
        held, away = own[0], self._errors(measured, reference, slope)[0] / self.convergence_rate
        beside, on = held * held, 1.0 - held * held
        return (
            beside + on * (self.limit - effort) / self.limit,
            beside + on * (NEAR + away),
            on + beside * LATE - held * away,
            beside + on * (NEAR - away),
            beside + on * (self.limit + effort) / self.limit,
        )

    def after_switch(self, which, t, measured, own, reference, slope) -> tuple:
        """At which end the command is; 0: between them, on the line.

        What the command cannot keep on the line leaves it to the side to which it is pushed. But what integration has
        moved off it to the other side, the command has to bring there first.
        """
        away = self._errors(measured, reference, slope)[0] / self.convergence_rate
        before, behind = 0.5 * LATE - away, 0.5 * LATE + away  # negative while that is not so
        forward, back = before / sqrt(before * before), -(behind / sqrt(behind * behind))
        return ((forward, 1.0, 0.0, -1.0, back)[which],)


@parameters
class AngleSlidingMode(SlidingMode):
    """Sliding mode of an angle, such as that of a pendulum or a rotor; the reference is the angle wanted."""

    measured: str = parameter(OWN, "theta", "the state that is tracked; own: the state angle of the machine")

    name: ClassVar[str] = "angle-sliding-mode"
    reference: ClassVar = "angle"


@parameters
class PositionSlidingMode(SlidingMode):
    """Sliding mode of a displacement, such as that of a mass in its capsule; the reference is the one wanted.

    It cannot be the place of a body that comes to rest: what is held by friction and by the command at once is open.
    """

    measured: str = parameter(OWN, "z", "the state that is tracked; own: the first state of the machine")

    name: ClassVar[str] = "position-sliding-mode"
    reference: ClassVar = "displacement"
