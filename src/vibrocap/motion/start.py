"""Where a motion begins: its states, its time, and where in its period the drive is then."""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, ClassVar

from vibrocap.arguments import ArgumentError, is_number, shown, suggestion
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.dimensions.units import state_keys
from vibrocap.physics.names import OUTPUT
from vibrocap.physics.system import System
from vibrocap.quantities.declared import Number, Time
from vibrocap.quantities.dimensional import Dimensional, said

AT_STOP = 1e-9  # of a stop, over the natural size: a printed state of a mass that touches it is there
BRANCH = "as it says which branch of the equations holds"
WHOLE = 1e-12  # of a period: a phase that is so little short of a whole one is none


@dataclasses.dataclass(frozen=True)
class Start(Dimensional):
    """When a motion begins, and where in its period the drive is then.

    phase: share of the drive's period, whole parts do not matter; by default what the time says, time/T, for a drive
    is a function of time that begins a period at time 0
    """

    time: Time = 0.0
    phase: Number | None = None

    given: ClassVar[bool] = True

    def __post_init__(self):
        for name, value in (("time", self.time), ("phase", 0.0 if self.phase is None else self.phase)):
            if not is_number(value) or not math.isfinite(value):
                raise ArgumentError(f"start.{name}", f"should be a finite number, got {shown(value)}")

    def phase_of(self, period: float) -> float:
        """The phase in [0, 1) of a drive of that period."""
        phase = self.time / period if self.phase is None else self.phase
        return max(0.0, phase - math.floor(phase + WHOLE))


def begun(system: System, start: Any, initial: Mapping[str, float] | None) -> tuple[dict[str, float], float, float]:
    """(initial states by name, time, phase of the drive) at the start of a motion, see `simulate`."""
    state, time, phase = _begun(system, start, initial)
    if system.machine.follows_load:
        check_load(system, state, phase * system.drive.period)
    return state, time, phase


def _begun(system: System, start: Any, initial: Mapping[str, float] | None) -> tuple[dict[str, float], float, float]:
    if start is None:
        return initial_state(system, initial), 0.0, 0.0
    if isinstance(start, Trajectory):
        if start.state_names != system.state_names:
            raise ArgumentError(
                "start",
                f"should be a motion of the states {', '.join(system.state_names)} to continue from, got one of "
                f"{', '.join(start.state_names)}; give a Start and initial= instead",
            )
        given = start.state | dict(initial or {})
        return initial_state(system, given), start.end, Start(phase=start.end_phase).phase_of(system.drive.period)
    if is_number(start):
        start = Start(float(start))
    if not isinstance(start, Start):
        raise ArgumentError("start", f"should be a motion, a time or a Start, got {shown(start)}")
    return initial_state(system, initial), float(start.time), start.phase_of(system.drive.period)


def check_load(system: System, state: Mapping[str, float], time: float) -> None:
    """ArgumentError for a start at which the ground would have to pull at the machine.

    time: of the drive. A start at which the load does not follow from the forces is left to the run, which ends there.
    """
    y = tuple(state.values())
    placed = system.placed
    velocity = placed.contacts(time, y[: len(placed.states)], system.drive.value(time))[0].velocity
    side = (velocity > 0.0) - (velocity < 0.0)
    resting = side == 0 and system.friction.kind == "set-valued"
    flow = system.flow(time, y, side if side or resting else 1)
    load = flow.loads[1 if resting else 0]
    if load < 0.0 < (1.0 if resting else flow.bounds[0]):
        states = ", ".join(f"{name} {value:g}" for name, value in state.items() if value) or "all at 0"
        said = f"the normal load is negative at the start, {load:.4g}: the machine would lift off at once ({states})"
        raise ArgumentError("initial", said)


def initial_state(system: System, initial: Mapping[str, float] | None) -> dict[str, float]:
    """All initial states by name; ArgumentError for a state that does not exist or is not a finite number, or
    not a whole one where it says which branch of the equations holds.

    A name with a unit, "position_m", is a state of a system that knows its scales.
    """
    start = dict.fromkeys(system.state_names, 0.0)
    keys = state_keys(system.result_units.states)
    for name, value in (initial or {}).items():
        if name not in start and name not in keys:
            near = suggestion(name, [*start, *keys], cutoff=0.0)
            raise ArgumentError(f"initial.{name}", f"no such state; {near} States: {', '.join(start)}")
        if not is_number(value) or not math.isfinite(value):
            raise ArgumentError(f"initial.{name}", f"should be a finite number, got {shown(value)}")
        if value != round(value) and name in system.switched:
            raise ArgumentError(f"initial.{name}", f"should be a whole number, {BRANCH}, got {value!r}")
        if name in start:
            start[name] = float(value)
        else:
            start[keys[name].name] = float(value) / system.si.per_key(keys[name])
    check_room(system, start)
    return start


def within_room(system: System, state: Mapping[str, float]) -> dict[str, float]:
    """A state of a motion of other parameters, at the stop or the limit where it would lie beyond it."""
    placed = system.placed
    room = placed.room()
    found = dict(state) | {name: min(max(state[name], low), high) for name, (low, high) in room.items()}
    for switch, (name, *_) in placed.locked.items():
        if found[switch] != 0.0 and name in room:
            found[name] = room[name][found[switch] > 0.0]
    return found


def check_room(system: System, start: Mapping[str, float]) -> None:
    """ArgumentError for a start beyond a rigid stop of the machine, or with a branch that does not hold there."""
    for name in system.switched:
        if start[name] not in (-1.0, 0.0, 1.0):
            raise ArgumentError(f"initial.{name}", f"should be -1, 0 or 1, got {start[name]:g}")
    for switch, (name, *still) in system.placed.locked.items():
        where = start[switch] and system.placed.room()[name][start[switch] > 0.0]
        if not math.isfinite(where):
            raise ArgumentError(f"initial.{switch}", f"should not be {start[switch]:g}, as there is no stop")
        rest = {system.machine.contact_states[0]: -system.machine.ground_speed()}  # over a belt it slides at the stop
        for locked, value in ((name, where), *((each, rest.get(each, 0.0)) for each in still)) if start[switch] else ():
            if not abs(start[locked] - value) <= AT_STOP * (1.0 + abs(value)):
                wanted, got = (_said(each, locked, system, 10) for each in (value, start[locked]))
                what = f"should be {wanted}, as {switch} is {start[switch]:g}, got {got}"
                raise ArgumentError(f"initial.{locked}", what)
    for name, (low, high) in system.placed.room().items():
        rounding = WHOLE * (1.0 + abs(start[name]))
        if not low - rounding <= start[name] <= high + rounding:
            what = "the actuator has its limit" if name == OUTPUT else "a stop stands"
            side, bound = ("most", high) if start[name] > high else ("least", low)
            wanted, got = (_said(each, name, system, 6) for each in (bound, start[name]))
            raise ArgumentError(f"initial.{name}", f"should be at {side} {wanted}, where {what}, got {got}")


def _said(value: float, name: str, system: System, digits: int) -> str:
    """A value of a state in words, with the unit that results have."""
    units = system.result_units
    return said(value * units.factor(name), units.unit(name), digits)
