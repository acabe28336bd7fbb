"""A motion that is moved on from outside, step by step: of a controller, a robot, a policy.

It is what the library in C is, to the last bit, and is made of the same kernel. Where its case is in SI, `vc.stepper`
makes it take and answer in SI.
"""

import dataclasses
import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, TypedDict, Unpack, overload

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole, is_number, shown, suggestion
from vibrocap.case.case import Case
from vibrocap.exchange.stepped_case import NO_UNITS, Input, PortScales, Stepped, SteppedCase
from vibrocap.exchange.stepper_array import StepperArray
from vibrocap.motion.held_input import INPUT_NAMES
from vibrocap.motion.simulate import STATUSES
from vibrocap.motion.status import Status
from vibrocap.numerics.api import StepperMemory
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System
from vibrocap.quantities.declared import ByKey, Context, Declared
from vibrocap.quantities.dimensional import said


class MotionEnded(RuntimeError):
    """A motion that cannot continue, as its load has lifted off for example: `time` says when, `status` why.

    unit: of the time, "1" for none
    """

    def __init__(self, time: float, status: Status, unit: str = "1"):
        super().__init__(f"the motion has ended at t = {said(time, unit)}: {status.value}. {status.text}")
        self.time, self.status, self.unit = time, status, unit

    def __reduce__(self):
        return type(self), (self.time, self.status, self.unit)


@dataclasses.dataclass(frozen=True)
class StepperEvent:
    """The last event of a motion. kind: as of `Event`; contact: its number, 1 for the first, 0 of none."""

    time: float
    kind: str
    contact: int


@dataclasses.dataclass(frozen=True)
class Instant:
    """A motion at one instant, in SI where the stepper is.

    states: by name; observables: friction, energy and what else can be asked of a motion, by name
    sides: of each contact, +1 or -1 where it slides, 0 at rest; events: how often each kind occurred
    status: None while the motion continues
    """

    time: float
    states: Mapping[str, float]
    observables: Mapping[str, float]
    sides: tuple[int, ...]
    events: Mapping[str, int]
    last_event: StepperEvent | None
    status: Status | None


class SameInSI(Declared):
    """A motion that knows its own scales."""

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        return value.dimensionless if back else value.in_si


class _Options(TypedDict, total=False):
    initial: ByKey | None
    tolerance: float | None
    parameters: Mapping[str, Any] | None


@overload
def stepper(
    case: Case | System, *, input: None = None, count: None = None, **options: Unpack[_Options]
) -> "Stepper": ...
@overload
def stepper(
    case: Case | System, *, input: Literal["drive"], count: None = None, **options: Unpack[_Options]
) -> "InputStepper": ...
@overload
def stepper(case: Case | System, *, input: Input = None, count: int, **options: Unpack[_Options]) -> StepperArray: ...
def stepper(
    case: Case | System,
    *,
    input: Input = None,
    initial: ByKey | None = None,
    tolerance: float | None = None,
    parameters: Mapping[str, Any] | None = None,
    count: int | None = None,
) -> "Annotated[Stepper | InputStepper | StepperArray, SameInSI()]":
    """The motion of a case or a system, at its start, to be moved on by any lengths of time.

    input: "drive", if it is set at each step, `.step(value, length)`; None: the case's own continues, `.step(length)`
    initial: initial states by name, as of `simulate`; tolerance: error per step (1e-14 to 1e-2); both by default those
        of the case, or of `simulate`
    parameters: values by path that replace those of the system, such as {"machine.mass_ratio": 2.0}
    count: so many motions at once, side by side (`StepperArray`), of which initial states and parameters may be arrays
        [count]; None: one
    Where the case is in SI, times, inputs and all that is seen are; `.dimensionless` is the same motion without units.
    Raises ValueError or TypeError, naming the argument, before any work.
    """
    if not isinstance(case, (Case, System)):
        raise ArgumentError("case", f"should be a case or a system, got {shown(case)}")
    columns: dict[str, Any] = {}
    if count is not None:
        check_whole("count", count, 1, 2**24)
        (initial, parameters), columns = _columns_apart(initial, parameters)
    options: dict[str, Any] = {"initial": initial, "tolerance": tolerance}
    options = {name: value for name, value in options.items() if value is not None}
    own = Case(case, **options) if isinstance(case, System) else dataclasses.replace(case, **options)
    if parameters is not None:
        own = dataclasses.replace(own, system=own.system.with_parameters(parameters))
    stepped = SteppedCase(own, input)
    if count is not None:
        return StepperArray(stepped, int(count), columns)
    return Stepper(stepped) if input is None else InputStepper(stepped)


def _columns_apart(*mappings: Mapping[str, Any] | None) -> tuple[list[Any], dict[str, Any]]:
    """What is given by name without its arrays, and the arrays."""
    arrays = {name: value for column in mappings for name, value in (column or {}).items() if np.ndim(value)}
    rest = [column and {name: column[name] for name in column if name not in arrays} for column in mappings]
    return rest, arrays


class SteppedMotion(Stepped):
    """One motion that is moved on from outside: what can be seen of it, and how it is kept (see `Stepper`)."""

    def __init__(self, stepped: SteppedCase):
        self.stepped = stepped
        self._bind(stepped.memory(), NO_UNITS)
        self._entry("begin_motion")(0)

    def _bind(self, memory: StepperMemory, scales: PortScales) -> None:
        self._memory, self._scales, self._names = memory, scales, self.stepped.names
        places = self.stepped.kernel.places
        self._time_scale, self._input_scales, self._value_scales = scales.time, scales.inputs, scales.values
        self._floats: Any = memory.floats.data  # faster, number by number, than arrays
        self._ints: Any = memory.ints.data
        self._length, self._ended, self._stopped = places["LENGTH"], places["ENDED"], places["STOPPED"]
        self._input, self._new_input = places["INPUT"], places["NEW_INPUT"]
        self._take, self._look = self._entry("take_step"), self._entry("look_at")

    def _copied(self) -> StepperMemory:
        own = self.stepped.memory()
        own.take(self._memory)
        return own

    def _entry(self, name: str) -> Any:
        return self.stepped.kernel.entry(name, self._memory)

    def _go_on(self, length: float, to_event: int = 0) -> bool:
        """Advance, with 1 to the first event at most; whether it stands at one."""
        _check_length(length)
        self._floats[self._length] = length / self._time_scale
        self._ints[self._stopped] = 0
        self._take(to_event)
        if self._ints[self._ended]:
            raise MotionEnded(self.time, self._status(), self.unit_of("time"))
        return self._ints[self._stopped] == 1

    # --- looking ------------------------------------------------------------------------------------------------------

    @property
    def time(self) -> float:
        """Time since the motion began."""
        return self._floats[self.stepped.kernel.places["CLOCK"]] * self._time_scale

    @property
    def values(self) -> np.ndarray:
        """All states, then all observables, in the order of `names`: array [names]."""
        self._look(0)
        return self._memory.trace[: len(self._names)] * self._value_scales

    @property
    def states(self) -> np.ndarray:
        """In the order of the system's: array [states]."""
        return self.values[: len(self.stepped.states)]

    def __getitem__(self, name: str) -> float:
        if name not in self._names:
            raise KeyError(f"{name!r} is not known of this motion; {suggestion(name, self._names)}")
        return float(self.values[self._names.index(name)])

    @property
    def sides(self) -> tuple[int, ...]:
        """Of each contact: +1, -1 it slides; 0 it is at rest."""
        first = self.stepped.kernel.places["SHOWN_SIDE"]
        return tuple(int(self._floats[first + c]) for c in range(self.stepped.contacts))

    @property
    def events(self) -> dict[str, int]:
        """How often each kind of event occurred; of a further contact "stick_2" and so on."""
        first, counts = self.stepped.kernel.places["COUNTED"], dict.fromkeys(self.stepped.counted, 0)
        for i, name in enumerate(self.stepped.counted):
            counts[name] += self._ints[first + i]
        return counts

    @property
    def last_event(self) -> StepperEvent | None:
        """None before the first."""
        if not any(self.events.values()):
            return None
        places, floats, ints = self.stepped.kernel.places, self._floats, self._ints
        kind, contact = self.stepped.event_kinds[ints[places["LAST_KIND"]]], ints[places["LAST_CONTACT"]]
        return StepperEvent(floats[places["LAST_TIME"]] * self._time_scale, numbered(kind, max(1, contact)), contact)

    @property
    def status(self) -> Status | None:
        """Why the motion has ended; None while it continues."""
        return self._status() if self._ints[self._ended] else None

    def _status(self) -> Status:
        return STATUSES[self._ints[self._ended]]

    def look(self) -> Instant:
        """All of it at the present instant."""
        values, states = self.values.tolist(), len(self.stepped.states)
        return Instant(
            time=self.time,
            states=dict(zip(self._names[:states], values[:states], strict=True)),
            observables=dict(zip(self._names[states:], values[states:], strict=True)),
            sides=self.sides,
            events=self.events,
            last_event=self.last_event,
            status=self.status,
        )

    def __repr__(self) -> str:
        pairs = zip(self._names, self.states, strict=False)
        states = ", ".join(f"{name} {said(value, self.unit_of(name), 5)}" for name, value in pairs)
        now = said(self.time, self.unit_of("time"))
        return f"<{type(self).__name__}: t = {now}; {states}; {self.status or 'continues'}>"

    def restore(self, kept: "SteppedMotion") -> None:
        """Go back, or over, to a motion of the same case that was kept by `copy`."""
        if type(kept) is not type(self) or (kept.stepped is not self.stepped and kept.stepped != self.stepped):
            raise ArgumentError("kept", f"should be a copy of this motion, of the same case, got {shown(kept)}")
        self._memory.take(kept._memory)


class Stepper(SteppedMotion):
    """One motion with the case's own drive, moved on by `step` and `step_to_event`; look at it by name or by `look`.

    The instant is read from steps of the kernel's own choice, so that the motion does not depend on where it is looked
    at: it has the bits of the kernel without fused operations, as the library in C. `copy` and `restore` keep and bring
    back a motion, and so does `pickle`. No limit of periods ends it.
    """

    def step(self, length: float) -> None:
        """Advance by a length of time > 0. Raises MotionEnded where it cannot: it stands where it ended then."""
        self._go_on(length)

    def step_to_event(self, length: float) -> bool:
        """Advance by at most a length of time, to the first event that changes anything; whether there was one.

        A graze changes nothing and is only counted. Events at one instant count as one here. Raises MotionEnded.
        """
        return self._go_on(length, 1)


class InputStepper(SteppedMotion):
    """One motion whose drive is set from step to step; all else as of `Stepper`.

    From where it is set on, the drive is value + slope s + curvature s^2/2 after the time s; machines whose motion it
    imposes need slope and curvature, as they feel nothing else. Where it jumps, a contact that is at rest is asked
    again whether it stays there.
    """

    def _set(self, value: float, slope: float, curvature: float) -> None:
        try:
            finite = value - value == 0.0 and slope - slope == 0.0 and curvature - curvature == 0.0
        except (TypeError, ValueError):  # a text, an array
            finite = False
        if not finite:
            inputs = zip(INPUT_NAMES, (value, slope, curvature), strict=True)
            name, wrong = next(pair for pair in inputs if not is_number(pair[1]) or not math.isfinite(pair[1]))
            raise ArgumentError(name, f"should be a finite number, got {shown(wrong)}")
        floats, place, (v, w, c) = self._floats, self._input, self._input_scales
        floats[place], floats[place + 1], floats[place + 2] = value / v, slope / w, curvature / c
        self._ints[self._new_input] = 1

    def step(self, value: float, length: float, slope: float = 0.0, curvature: float = 0.0) -> None:
        """Set the drive and advance by a length of time > 0. Raises MotionEnded where the motion cannot continue."""
        _check_length(length)  # before the drive is set
        self._set(value, slope, curvature)
        self._go_on(length)

    def step_to_event(self, value: float, length: float, slope: float = 0.0, curvature: float = 0.0) -> bool:
        """Set the drive and advance by at most a length of time, to the first event; whether there was one.

        Where the drive jumps and a side changes at once, that is an event: no time has passed then.
        """
        _check_length(length)
        self._set(value, slope, curvature)
        return self._go_on(length, 1)


def _check_length(length: Any) -> None:
    try:
        right = 0.0 < length < math.inf
    except (TypeError, ValueError):  # a text, an array
        right = False
    if not right:
        raise ArgumentError("length", f"should be a finite length of time > 0, got {shown(length)}")
