"""The PID controllers: of a place and of an angle, and the PI controller of a velocity, each with a limit."""

from typing import ClassVar

from vibrocap.physics.controllers.controller import INTEGRAL, OWN, Linear, anti_windup
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.parameters import NonNegative, Positive, parameter, parameters

HELD, PENDING, SAMPLING = "held_command", "pending_command", "sampling"


@parameters
class PositionPID(Linear):
    """PID controller of a place; the reference is where it should be.

        u = K_P e + K_D e' + S,  S' = K_I e,     e = r - x

    x is the place of the machine (`Machine.place`), or any other state that is a length. With static friction above
    the Coulomb level the integral makes it hunt about its goal for ever (Armstrong-Helouvry, Dupont and Canudas de
    Wit 1994, section 4).
    """

    proportional_gain: NonNegative = parameter(1.0, "K_P", "force or torque per length of error", "position gain")
    integral_gain: NonNegative = parameter(
        0.0, "K_I", "rate of the command per length of error", "position integral gain"
    )
    derivative_gain: NonNegative | None = parameter(
        None, "K_D", "force or torque per speed of error; none where its rate is not measured", "position rate gain"
    )
    anti_windup: NonNegative = anti_windup("position anti-windup")
    limit: Positive | None = parameter(None, "u_max", "largest command; none where there is no limit", "effort")
    measured: str = parameter(OWN, "x", "the state that is measured; own: the place of the machine")

    name: ClassVar[str] = "position-pid"
    source: ClassVar[str] = "astrom2006; armstrong1994"
    reference: ClassVar = "displacement"


@parameters
class AnglePID(Linear):
    """PID controller of an angle, such as that of a pendulum or a rotor; the reference is the angle wanted.

    u = K_P e + K_D e' + S,  S' = K_I e,     e = r - theta
    """

    proportional_gain: NonNegative = parameter(1.0, "K_P", "force or torque per rad of error", "effort")
    integral_gain: NonNegative = parameter(0.0, "K_I", "rate of the command per rad of error", "effort rate")
    derivative_gain: NonNegative | None = parameter(
        None, "K_D", "force or torque per rad/s of error; none where its rate is not measured", "angle rate gain"
    )
    anti_windup: NonNegative = anti_windup("angle anti-windup")
    limit: Positive | None = parameter(None, "u_max", "largest command; none where there is no limit", "effort")
    measured: str = parameter(OWN, "theta", "the state that is measured; own: the state angle of the machine")

    name: ClassVar[str] = "angle-pid"
    reference: ClassVar = "angle"


@parameters
class VelocityPI(Linear):
    """PI controller of a velocity; the reference is the velocity that it should have.

        u = K_P e + S,  S' = K_I e,     e = r - v

    v is the sliding velocity at the first contact of the machine, or any other state that is a velocity.
    """

    proportional_gain: NonNegative = parameter(1.0, "K_P", "force or torque per speed of error", "position rate gain")
    integral_gain: NonNegative = parameter(0.0, "K_I", "rate of the command per speed of error", "position gain")
    anti_windup: NonNegative = anti_windup("velocity anti-windup")
    limit: Positive | None = parameter(None, "u_max", "largest command; none where there is no limit", "effort")
    measured: str = parameter(OWN, "v", "the state that is measured; own: sliding velocity at the first contact")

    name: ClassVar[str] = "velocity-pi"
    reference: ClassVar = "speed"


SHIFT = 1.5 * 2.0**52  # added and taken off again, it rounds a number to a whole one


@parameters
class Sampled(Linear):
    """The same law in a processor: it samples every h, and its command is held until the next one.

        at k h:  u_raw = K_P e + K_D (r' - y') + S,   u = u_raw cut off at +-u_max,   S -> S + K_I h [e + a (u - u_raw)]

    The command acts after the delay, or at once, and is 0 before. With `quantum` what is measured is rounded to whole
    multiples of it, as an encoder does. Samples and actions are corners of time, k h and k h + delay, at which the
    states of the controller jump.
    """

    sample_time: Positive = parameter(0.01, "h", "time between two samples", "duration")
    delay: Positive | None = parameter(None, "d", "from a sample to its action; none where it acts at once", "duration")
    quantum: Positive | None = parameter(None, "q", "to whose multiples what is measured is rounded; none: it is not")

    all_states: ClassVar = (HELD, PENDING, INTEGRAL, SAMPLING)
    effort_states: ClassVar = (HELD, PENDING, INTEGRAL)
    sampled: ClassVar[bool] = True
    # SAMPLING is 1 after a sample, -1 after its action, 0 before the first
    switched: ClassVar = (SAMPLING,)  # type: ignore[override,assignment]
    switch_events: ClassVar = ("sample",)  # type: ignore[override,assignment]

    @property
    def states(self) -> tuple[str, ...]:
        """u that acts, u that is to act where there is a delay, S, and whether a sample or an action came last."""
        return (HELD, *(() if self.delay is None else (PENDING,)), INTEGRAL, SAMPLING)

    def command(self, t, measured, own, reference, slope):
        return own[0]

    def rates(self, t, measured, own, reference, slope) -> tuple:
        return (0.0,) * len(own)

    def switches(self, t, measured, own, reference, slope) -> tuple:
        return ()

    def after_sample(self, t, measured, own, reference, slope) -> tuple:
        """Its states, but for the last one, after a sample."""
        if self.quantum is not None:
            whole = (measured[0] / self.quantum + SHIFT) - SHIFT
            measured = (self.quantum * whole, *measured[1:])
        *_, integral, _ = own
        raw = self._raw(measured, (integral,), reference, slope)
        command = raw
        if self.limit is not None:
            above, below = raw + self.limit, raw - self.limit
            command = 0.5 * (sqrt(above * above) - sqrt(below * below))
        error = reference - measured[0] + self.anti_windup * (command - raw)
        integral = integral + self.integral_gain * self.sample_time * error
        return (command, integral) if self.delay is None else (own[0], command, integral)

    def after_action(self, own) -> tuple:
        """The same after the action."""
        return own[:-1] if self.delay is None else (own[1], own[1], own[2])


@parameters
class SampledPositionPID(Sampled, PositionPID):
    """Sampled PID controller of a place, a `PositionPID` in a processor; the rate of the place is measured, too."""

    quantum: Positive | None = parameter(None, "q", "to whose multiples the place is rounded; none: it is not", "gap")

    name: ClassVar[str] = "sampled-position-pid"


@parameters
class SampledAnglePID(Sampled, AnglePID):
    """Sampled PID controller of an angle, an `AnglePID` in a processor; the rate of the angle is measured, too."""

    quantum: Positive | None = parameter(None, "q", "to whose multiples the angle is rounded; none: it is not", "phase")

    name: ClassVar[str] = "sampled-angle-pid"


@parameters
class SampledVelocityPI(Sampled, VelocityPI):
    """Sampled PI controller of a velocity, a `VelocityPI` in a processor."""

    quantum: Positive | None = parameter(None, "q", "to whose multiples the velocity is rounded; none: not", "speed")

    name: ClassVar[str] = "sampled-velocity-pi"
