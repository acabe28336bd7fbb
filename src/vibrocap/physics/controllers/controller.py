"""The contract of a controller: one kind or family per file in this folder; what makes the command."""

from typing import Any, ClassVar, Literal

from vibrocap.physics.elementary import cos, exp, sin, sqrt
from vibrocap.physics.parameters import NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.part import Part

__all__ = [
    "Controller",
    "NonNegative",
    "Number",
    "Positive",
    "cos",
    "exp",
    "parameter",
    "parameters",
    "sin",
    "sqrt",
]


class Controller(Part):
    """What every controller offers, as scalar functions of time, of what it measures, of its states and the reference.

    The reference r(tau) is the drive of the system, whose values are then no force but what the controller compares
    with what it measures; `reference` says what kind of quantity that is: a displacement, a speed, or a number (an
    angle). The command u takes the place of the drive before the machine, or before its actuator. All functions are
    called with numbers, and with symbols to record them, so they never branch on a value.

    states: names of its own states, which no machine, actuator or law uses. switched: those of them that are whole
    numbers, which say what branch holds (a limit reached or not), have the rate 0.0 and change only where a guard of
    `switches` falls to zero; a run starts with all of them at 0, and with the branch that its other states ask for.
    all_states: the names of all states that one of the class may have, where that depends on its parameters.
    switch_events: the name of what happens at each guard. effort_states: those of its states that count in units of the
    command; the others have no unit. odd: whether the command changes its sign with all that it is given.
    sampled: whether it acts at samples alone, every `sample_time` and `delay` later (None: at once). The last of its
    states is then whether a sample or an action came last, +1 or -1; `after_sample` and `after_action` say what the
    others are after each, and `command` is one of them.
    orders: "effort", or "acceleration" of one whose command is turned into a force or torque by the machine's own
    equations and the friction forces that act at its contacts (`inverse_dynamics.py`). Its command then is what it adds
    to the acceleration r'' of the reference; `accelerated` names the state whose rate is decided so, `rate_for` says
    what that rate should be, and `limit` and the state `command_saturated` limit the force or torque, not the command.
    """

    name: ClassVar[str]
    reference: ClassVar[Literal["displacement", "speed", "number"]]
    states: Any = ()
    all_states: ClassVar[tuple[str, ...]] = ()
    switched: Any = ()
    switch_events: Any = ()
    effort_states: ClassVar[tuple[str, ...]] = ()
    odd: ClassVar[bool] = True
    sampled: ClassVar[bool] = False
    orders: ClassVar[Literal["effort", "acceleration"]] = "effort"
    sample_time: Any
    delay: Any
    limit: Any

    def measures(self, machine: Any) -> tuple[str, ...]:
        """What it measures of a machine: names of states ("position"), or of their rates ("position_rate"), or `SIDE`,
        the side to which its first contact slides: 1 or -1, at rest 0.

        A rate must not depend on the command.
        """
        raise NotImplementedError

    @property
    def uses_curvature(self) -> bool:
        """Whether it asks for the curvature of the reference as well."""
        return self.orders == "acceleration"

    def accelerated(self, machine: Any) -> str:
        """Of one that orders an acceleration: the state of the machine whose rate it decides."""
        raise NotImplementedError

    def rate_for(self, measured, acceleration):
        """Of one that orders an acceleration: the rate of that state with which what is measured has it."""
        return acceleration

    @property
    def uses_slope(self) -> bool:
        """Whether it asks for the slope of the reference, which then must not jump."""
        return False

    def scales(self, effort) -> tuple:
        """Natural size of each of its states, given that of the command."""
        return tuple(1.0 if name in self.switched else effort for name in self.states)

    def command(self, t, measured, own, reference, slope):
        """u. measured: as `measures` names it; own: its states; reference, slope: r and r' (0 where not asked for)."""
        raise NotImplementedError

    def rates(self, t, measured, own, reference, slope) -> tuple:
        """Rates of its own states."""
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


SATURATED, SIDE = "command_saturated", "side"
LIMIT_EVENTS = ("command_saturated", "command_unsaturated", "command_saturated")
