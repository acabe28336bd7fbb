"""The PID controllers: of a place and of an angle, and the PI controller of a velocity, each with a limit."""

from typing import Any, ClassVar

from vibrocap.physics.controllers.controller import (
    LIMIT_EVENTS,
    SATURATED,
    Controller,
    NonNegative,
    Positive,
    parameter,
    parameters,
    sqrt,
)
from vibrocap.physics.limits import HELD_AFTER, limit_guards, limited

INTEGRAL = "integral_command"
HELD, PENDING, SAMPLING = "held_command", "pending_command", "sampling"
OWN = "own"  # what is measured where nothing else is said


class Linear(Controller):
    """A linear law of the error e = r - y with the integral S of it, behind a limit of the command.

        u_raw = K_P e + K_D (r' - y') + S,     u = u_raw cut off at +-u_max,     S' = K_I [e + a (u - u_raw)]

    With a > 0 the integral does not wind up: the excess of the command is fed back to it, with the tracking time
    1/(a K_I) (Astrom and Hagglund, Advanced PID Control, 2006, section 3.5). The limit is reached and left at located
    events, so that no step crosses a corner of u. S starts at 0 unless the start says otherwise.
    """

    proportional_gain: Any
    integral_gain: Any
    anti_windup: Any
    limit: Any
    measured: str

    source: ClassVar[str] = "astrom2006"
    all_states: ClassVar = (INTEGRAL, SATURATED)
    effort_states: ClassVar = (INTEGRAL,)

    @property
    def states(self) -> tuple[str, ...]:
        """S, then whether the limit holds where there is one."""
        return INTEGRAL, *self.switched

    @property
    def switched(self) -> tuple[str, ...]:
        """1 or -1 while the limit holds, 0 while it does not."""
        return () if self.limit is None else (SATURATED,)

    @property
    def switch_events(self) -> tuple[str, ...]:
        """Of the limit."""
        return () if self.limit is None else LIMIT_EVENTS

    def own_measured(self, machine) -> str:
        """The state that is measured where nothing else is said."""
        raise NotImplementedError

    def measures(self, machine) -> tuple[str, ...]:
        """The state, and its rate where it is differentiated."""
        name = self.own_measured(machine) if self.measured == OWN else self.measured
        return (name, f"{name}_rate") if self.uses_slope else (name,)

    @property
    def uses_slope(self) -> bool:
        """Whether there is a K_D."""
        return getattr(self, "derivative_gain", None) is not None

    def _raw(self, measured, own, reference, slope):
        raw = self.proportional_gain * (reference - measured[0]) + own[0]
        return raw + self.derivative_gain * (slope - measured[1]) if len(measured) > 1 else raw  # type: ignore[attr-defined]

    def command(self, t, measured, own, reference, slope):
        """u."""
        raw = self._raw(measured, own, reference, slope)
        return raw if self.limit is None else limited(own[1], raw, self.limit)

    def rates(self, t, measured, own, reference, slope) -> tuple:
        """S' = K_I [e + a (u - u_raw)]."""
        error = reference - measured[0]
        if self.limit is None:
            return (self.integral_gain * error,)
        excess = own[1] * own[1] * (own[1] * self.limit - self._raw(measured, own, reference, slope))
        return self.integral_gain * (error + self.anti_windup * excess), 0.0

    def switches(self, t, measured, own, reference, slope) -> tuple:
        """Those of the limit."""
        if self.limit is None:
            return ()
        raw = self._raw(measured, own, reference, slope)
        return limit_guards(own[1], raw, raw, self.limit)

    def after_switch(self, which, t, measured, own, reference, slope) -> tuple:
        """S as it was."""
        return own[0], HELD_AFTER[which]


@parameters
class PositionPID(Linear):
    """PID controller of a place; the reference is where it should be.

        u = K_P e + K_D e' + S,  S' = K_I e,     e = r - x

    x is the place of the machine (`Machine.place`), or any other state that is a length. With static friction above
    the Coulomb level the integral makes it hunt about its goal for ever (Armstrong-Helouvry, Dupont and Canudas de
    Wit 1994, section 4).
    """

    proportional_gain: NonNegative = parameter(1.0, "K_P", "force or torque per length of error", "position gain")
    integral_gain: NonNegative = parameter(0.0, "K_I", "its rate per length of error", "position integral gain")
    derivative_gain: NonNegative | None = parameter(
        None, "K_D", "force or torque per speed of error; none where its rate is not measured", "position rate gain"
    )
    anti_windup: NonNegative = parameter(
        0.0, "a", "error that a unit of cut-off command counts as; 0: none", "position anti-windup"
    )
    limit: Positive | None = parameter(None, "u_max", "largest command; none where there is no limit", "effort")
    measured: str = parameter(OWN, "x", "the state that is measured; own: the place of the machine")

    name: ClassVar[str] = "position-pid"
    source: ClassVar[str] = "astrom2006; armstrong1994"
    reference: ClassVar = "displacement"

    def own_measured(self, machine) -> str:
        """The place."""
        return machine.place or machine.cyclic or machine.states[0]


@parameters
class AnglePID(Linear):
    """PID controller of an angle, such as that of a pendulum or a rotor; the reference is the angle wanted.

    u = K_P e + K_D e' + S,  S' = K_I e,     e = r - theta
    """

    proportional_gain: NonNegative = parameter(1.0, "K_P", "force or torque per rad of error", "effort")
    integral_gain: NonNegative = parameter(0.0, "K_I", "its rate per rad of error", "effort rate")
    derivative_gain: NonNegative | None = parameter(
        None, "K_D", "force or torque per rad/s of error; none where its rate is not measured", "angle rate gain"
    )
    anti_windup: NonNegative = parameter(
        0.0, "a", "error that a unit of cut-off command counts as; 0: none", "angle anti-windup"
    )
    limit: Positive | None = parameter(None, "u_max", "largest command; none where there is no limit", "effort")
    measured: str = parameter(OWN, "theta", "the state that is measured; own: the state angle of the machine")

    name: ClassVar[str] = "angle-pid"
    reference: ClassVar = "number"

    def own_measured(self, machine) -> str:
        """The angle."""
        return "angle"


@parameters
class VelocityPI(Linear):
    """PI controller of a velocity; the reference is the velocity that it should have.

        u = K_P e + S,  S' = K_I e,     e = r - v

    v is the sliding velocity at the first contact of the machine, or any other state that is a velocity.
    """

    proportional_gain: NonNegative = parameter(1.0, "K_P", "force or torque per speed of error", "position rate gain")
    integral_gain: NonNegative = parameter(0.0, "K_I", "its rate per speed of error", "position gain")
    anti_windup: NonNegative = parameter(
        0.0, "a", "error that a unit of cut-off command counts as; 0: none", "velocity anti-windup"
    )
    limit: Positive | None = parameter(None, "u_max", "largest command; none where there is no limit", "effort")
    measured: str = parameter(OWN, "v", "the state that is measured; own: sliding velocity at the first contact")

    name: ClassVar[str] = "velocity-pi"
    reference: ClassVar = "speed"

    def own_measured(self, machine) -> str:
        """The sliding velocity."""
        return machine.contact_states[0]


SHIFT = 1.5 * 2.0**52  # added and taken off again, it rounds a number to a whole one


class Sampled(Linear):
    """The same law in a processor: it samples every h, and its command is held until the next one.

        at k h:  u_raw = K_P e + K_D (r' - y') + S,   u = u_raw cut off at +-u_max,   S -> S + K_I h [e + a (u - u_raw)]

    The command acts after the delay, or at once, and is 0 before. With `quantum` what is measured is rounded to whole
    multiples of it, as an encoder does. Samples and actions are corners of time, k h and k h + delay, at which the
    states of the controller jump.
    """

    sample_time: Any
    delay: Any
    quantum: Any

    all_states: ClassVar = (HELD, PENDING, INTEGRAL, SAMPLING)
    effort_states: ClassVar = (HELD, PENDING, INTEGRAL)
    sampled: ClassVar[bool] = True

    @property
    def states(self) -> tuple[str, ...]:
        """u that acts, u that is to act where there is a delay, S, and whether a sample or an action came last."""
        return (HELD, *(() if self.delay is None else (PENDING,)), INTEGRAL, SAMPLING)

    @property
    def switched(self) -> tuple[str, ...]:
        """1 after a sample, -1 after its action, 0 before the first."""
        return (SAMPLING,)

    @property
    def switch_events(self) -> tuple[str, ...]:
        """Of samples and actions."""
        return ("sample",)

    def command(self, t, measured, own, reference, slope):
        """u as it is held."""
        return own[0]

    def rates(self, t, measured, own, reference, slope) -> tuple:
        """Nothing changes between samples."""
        return (0.0,) * len(own)

    def switches(self, t, measured, own, reference, slope) -> tuple:
        """None of its own."""
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


SAMPLE_TIME = parameter(0.01, "h", "time between two samples", "duration")
DELAY = parameter(None, "d", "from a sample to its action; none where it acts at once", "duration")


@parameters
class SampledPositionPID(Sampled, PositionPID):
    """Sampled PID controller of a place, a `PositionPID` in a processor; the rate of the place is measured, too."""

    sample_time: Positive = SAMPLE_TIME
    delay: Positive | None = DELAY
    quantum: Positive | None = parameter(None, "q", "to whose multiples the place is rounded; none: it is not", "gap")

    name: ClassVar[str] = "sampled-position-pid"


@parameters
class SampledAnglePID(Sampled, AnglePID):
    """Sampled PID controller of an angle, an `AnglePID` in a processor; the rate of the angle is measured, too."""

    sample_time: Positive = SAMPLE_TIME
    delay: Positive | None = DELAY
    quantum: Positive | None = parameter(None, "q", "to whose multiples the angle is rounded; none: it is not", "phase")

    name: ClassVar[str] = "sampled-angle-pid"


@parameters
class SampledVelocityPI(Sampled, VelocityPI):
    """Sampled PI controller of a velocity, a `VelocityPI` in a processor."""

    sample_time: Positive = SAMPLE_TIME
    delay: Positive | None = DELAY
    quantum: Positive | None = parameter(None, "q", "to whose multiples the velocity is rounded; none: not", "speed")

    name: ClassVar[str] = "sampled-velocity-pi"
