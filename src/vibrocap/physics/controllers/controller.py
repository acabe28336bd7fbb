"""The contract of a controller: one kind or family per file in this folder; what makes the command."""

from typing import Any, ClassVar, Literal

from vibrocap.physics.elementary import HELD_AFTER, limit_guards, limited
from vibrocap.physics.parameters import NonNegative, Number, Part, Positive, parameter, parameters  # noqa: F401 for parts

INTEGRAL, SATURATED = "integral_command", "command_saturated"
LIMIT_EVENTS = ("command_saturated", "command_unsaturated", "command_saturated")
SIDE, CURVATURE = "side", "reference_curvature"  # what may be measured besides states and their rates
OWN = "own"  # what is measured where nothing else is said


class Controller(Part):
    """What every controller offers, as scalar functions of time, of what it measures, of its states and the reference.

    The reference r(tau) is the drive of the system, which the controller compares with what it measures; `reference`
    says what kind of quantity it is: a displacement, a speed, or a number (an angle). The command u takes the place of
    the drive before the machine, or before its actuator. All functions are called with numbers, and with symbols to
    record them, so they never branch on a value.

    states: names of its own states, which no machine, actuator or law uses. switched: those of them that are whole
    numbers (a limit reached or not): they have the rate 0.0 and change only where a guard of `switches` falls to zero;
    a run starts with all of them at 0, and with the branch that its other states ask for. all_states: all that one of
    the class may have, where that depends on its parameters. effort_states: those in units of the command; the others
    have no unit. switch_events: the name of what happens at each guard. odd: whether the command changes its sign with
    all that it is given.
    sampled: whether it acts at samples alone, every `sample_time` and `delay` later (None: at once). The last of its
    states is then whether a sample or an action came last, +1 or -1; `after_sample` and `after_action` say what the
    others are after each, and `command` is one of them.
    orders: "effort", or "acceleration": the machine's own equations make a force or torque of the command, see
    `AccelerationController`.
    """

    name: ClassVar[str]
    reference: ClassVar[Literal["displacement", "speed", "angle"]]
    states: Any = ()
    all_states: ClassVar[tuple[str, ...]] = ()
    switched: Any = ()
    switch_events: Any = ()
    effort_states: ClassVar[tuple[str, ...]] = ()
    odd: ClassVar[bool] = True
    sampled: ClassVar[bool] = False
    orders: ClassVar[Literal["effort", "acceleration"]] = "effort"
    bound_kinds: ClassVar[tuple[str, ...]] = ()
    sample_time: Any
    delay: Any
    limit: Any

    def measures(self, machine: Any) -> tuple[str, ...]:
        """What it measures of a machine: names of states ("position"), or of their rates ("position_rate"), which must
        not depend on the command.

        Besides, `SIDE`: the side to which its first contact slides, 1 or -1, at rest 0 or, of a contact that cannot
        rest, one of the two; and `CURVATURE`: the curvature r'' of the reference.
        """
        raise NotImplementedError

    @property
    def uses_slope(self) -> bool:
        """Whether it asks for the slope of the reference, which then must not jump."""
        return False

    def scales(self, effort) -> tuple:
        """Natural size of each of its states, given that of the command."""
        return tuple(1.0 if name in self.switched else effort for name in self.states)

    def compared(self, machine: Any) -> str | None:
        """The state that follows the reference; None where it is a function of states that does."""
        return self.measures(machine)[0]

    def command(self, t, measured, own, reference, slope):
        """u. measured: as `measures` names it; own: its states; reference, slope: r and r' (0 where not asked for)."""
        raise NotImplementedError

    def rates(self, t, measured, own, reference, slope) -> tuple:
        """Rates of its own states."""
        return ()

    def bounds(self, measured) -> tuple:
        """What is positive as long as its command exists, each of the kind "singular_command" in `bound_kinds`."""
        return ()

    def switches(self, t, measured, own, reference, slope) -> tuple:
        """Guards of its branches, each positive while its branch lasts; their natural size is 1."""
        return ()

    def after_switch(self, which, t, measured, own, reference, slope) -> tuple:
        """All of its own states after guard number `which` has fallen to zero."""
        raise NotImplementedError

    def after_sample(self, t, measured, own, reference, slope) -> tuple:
        """Of a sampled one: its states, but for the last, after a sample; reference, slope: r and r' at it."""
        raise NotImplementedError

    def after_action(self, own) -> tuple:
        """Of a sampled one: its states, but for the last, after the action that follows a sample."""
        raise NotImplementedError


class Limited(Controller):
    """A controller of one state, whose command has a limit that is reached and left at located events."""

    limit: Any
    measured: str

    @property
    def switched(self) -> tuple[str, ...]:
        """1 or -1 while the limit holds, 0 while it does not; nothing without a limit."""
        return () if self.limit is None else (SATURATED,)

    @property
    def switch_events(self) -> tuple[str, ...]:
        return () if self.limit is None else LIMIT_EVENTS

    def own_measured(self, machine) -> str:
        """The state that is measured where nothing else is said: angle, place or velocity, as the reference is."""
        if self.reference == "angle":
            return "angle"
        if self.reference == "speed":
            return machine.contact_states[0]
        return machine.place or machine.cyclic or machine.states[0]

    def measures(self, machine) -> tuple[str, ...]:
        name = self.own_measured(machine) if self.measured == OWN else self.measured
        return (name, f"{name}_rate") if self.uses_slope else (name,)


def anti_windup(role: str) -> Any:
    """How strongly a controller of this role feeds the excess of its command back, as a parameter of it."""
    return parameter(0.0, "a", "error that a unit of cut-off command counts as; 0: none", role)


class Linear(Limited):
    """A linear law of the error e = r - y with the integral S of it, behind a limit of the command.

        u_raw = K_P e + K_D (r' - y') + S,     u = u_raw cut off at +-u_max,     S' = K_I [e + a (u - u_raw)]

    With a > 0 the integral does not wind up: the excess of the command is fed back to it, with the tracking time
    1/(a K_I) (Astrom and Hagglund, Advanced PID Control, 2006, section 3.5). The limit is reached and left at located
    events, so that no step crosses a breakpoint of u. S starts at 0 unless the start says otherwise.
    """

    proportional_gain: Any
    integral_gain: Any
    anti_windup: Any

    source: ClassVar[str] = "astrom2006"
    all_states: ClassVar = (INTEGRAL, SATURATED)
    effort_states: ClassVar = (INTEGRAL,)

    @property
    def states(self) -> tuple[str, ...]:
        """S, then whether the limit holds where there is one."""
        return INTEGRAL, *self.switched

    @property
    def uses_slope(self) -> bool:
        return getattr(self, "derivative_gain", None) is not None

    def _raw(self, measured, own, reference, slope):
        raw = self.proportional_gain * (reference - measured[0]) + own[0]
        return raw + self.derivative_gain * (slope - measured[1]) if len(measured) > 1 else raw  # type: ignore[attr-defined]

    def command(self, t, measured, own, reference, slope):
        raw = self._raw(measured, own, reference, slope)
        return raw if self.limit is None else limited(own[1], raw, self.limit)

    def rates(self, t, measured, own, reference, slope) -> tuple:
        error = reference - measured[0]
        if self.limit is None:
            return (self.integral_gain * error,)
        excess = own[1] * own[1] * (own[1] * self.limit - self._raw(measured, own, reference, slope))
        return self.integral_gain * (error + self.anti_windup * excess), 0.0

    def switches(self, t, measured, own, reference, slope) -> tuple:
        if self.limit is None:
            return ()
        raw = self._raw(measured, own, reference, slope)
        return limit_guards(own[1], raw, raw, self.limit)

    def after_switch(self, which, t, measured, own, reference, slope) -> tuple:
        return own[0], HELD_AFTER[which]


class AccelerationController(Limited):
    """A controller whose command is the rate that a state of the machine is to have; its effort follows from that.

    The effort is the force or torque that gives the state this rate, under the friction at the contacts as it is then,
    or, while the state `command_saturated` is 1 or -1, the limit to that side.
    """

    orders: ClassVar = "acceleration"
    all_states: ClassVar = (SATURATED,)

    @property
    def states(self) -> tuple[str, ...]:
        return self.switched

    @property
    def uses_slope(self) -> bool:
        return True

    def own_measured(self, machine) -> str:
        """The state that is tracked where nothing else is said: the angle, or the first state."""
        return "angle" if self.reference == "angle" else machine.states[0]

    def measures(self, machine) -> tuple[str, ...]:
        return *super().measures(machine), CURVATURE

    def accelerated(self, machine) -> str:
        """The state that is the rate, or that moves one to one with it."""
        rate = self.measures(machine)[1]
        place = machine.place or machine.cyclic
        return machine.contact_states[0] if rate not in machine.states and rate == f"{place}_rate" else rate

    def rates(self, t, measured, own, reference, slope) -> tuple:
        return (0.0,) * len(own)

    def effort_switches(self, effort, t, measured, own, reference, slope) -> tuple:
        """Guards of the limit. effort: what would give the rate that is ordered."""
        return () if self.limit is None else limit_guards(own[0], effort, effort, self.limit)

    def after_switch(self, which, t, measured, own, reference, slope) -> tuple:
        return (HELD_AFTER[which],)
