"""A case that is stepped from outside: its kernel, and every quantity that crosses the border, with bounds and unit.

It is what the library in C, the stepper in Python and all that is built on them have in common.
"""

import dataclasses
import functools
import math
from collections.abc import Mapping
from typing import Any, Literal, Self

import numpy as np

from vibrocap.arguments import ArgumentError, shown
from vibrocap.case.case import Case
from vibrocap.motion.held_input import INPUT_NAMES, with_held_input
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.simulate import STATUSES, event_kinds, initial_state
from vibrocap.numerics.api import Budget, StepperKernel, StepperMemory, codes, stepper_kernel
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.physics.dimensions.conversion import quantity_in_si
from vibrocap.physics.dimensions.units import over_seconds, shortest
from vibrocap.physics.names import numbered, split_path
from vibrocap.physics.parameters import bounds
from vibrocap.physics.system import System

INPUTS = ("drive",)
AT_EVENT, REFUSED = codes.DONE, codes.TRACE_FULL  # codes that a stepper has no other use for
SEGMENT = "segment."

Input = Literal["drive"] | None


@dataclasses.dataclass(frozen=True)
class Port:
    """A quantity that crosses the border between a motion and what steps it.

    A dimensionless number times `scale` is in `unit`, an SI unit; "1" and 1.0 where the case is not in SI. All other
    numbers are dimensionless.
    value: of the case, of parameters and initial states; least, most: what a parameter may be by itself
    place: of a parameter, in the parameter vector
    """

    name: str
    unit: str = "1"
    scale: float = 1.0
    value: float = 0.0
    least: float = -math.inf
    most: float = math.inf
    place: int = 0

    @property
    def in_unit(self) -> float:
        """The value in the unit, with the fewest digits that give the dimensionless one exactly."""
        number = shortest(self.value, self.scale)
        return self.value * self.scale if number is None else number

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and most in the unit; what is to be greater than 0 stays so."""
        least = self.least * self.scale
        return math.nextafter(0.0, 1.0) if self.least > 0.0 and least == 0.0 else least, self.most * self.scale


@dataclasses.dataclass(frozen=True)
class PortScales:
    """What one dimensionless unit of all that is stepped and seen is, in units by name.

    inputs: of value, slope and curvature; values: of states and observables, a number for all or an array
    """

    time: float = 1.0
    inputs: tuple[float, ...] = (1.0, 1.0, 1.0)
    values: Any = 1.0
    units: Mapping[str, str] = dataclasses.field(default_factory=dict)


NO_UNITS = PortScales()


@dataclasses.dataclass(frozen=True)
class SteppedCase:
    """A case whose motion is moved on from outside. input: what of it is an input; None: nothing is."""

    case: Case
    input: Input = None

    def __post_init__(self):
        if self.input is not None and self.input not in INPUTS:
            raise ArgumentError("input", f"should be {shown(INPUTS[0])} or None, got {shown(self.input)}")
        controller = self.case.system.controller
        if self.input is not None and controller is not None and controller.sampled:
            what = f"should be None with a {controller.name}, which samples the reference of the case"
            raise ArgumentError("input", f"{what}; leave the controller out and set its command as the input")

    def __reduce__(self):
        return type(self), (self.case, self.input)  # all else follows

    @functools.cached_property
    def system(self) -> System:
        """That of the case, with the input in place of the drive where it is one."""
        return self.case.system if self.input is None else with_held_input(self.case.system)

    @functools.cached_property
    def equations(self) -> Equations:
        return equations(self.system)

    @functools.cached_property
    def kernel(self) -> StepperKernel:
        recorded, values = self.equations, parameter_values(self.system)
        return stepper_kernel(recorded, recorded.observables, self.case.tolerance, self.input is not None, values)

    def memory(self) -> StepperMemory:
        """What the stepper carries, before the motion begins."""
        initial = initial_state(self.case.system, self.case.initial).values()
        return self.kernel.memory(parameter_values(self.system), [*initial], Budget(**self.case.run))

    # --- what crosses the border --------------------------------------------------------------------------------------

    @functools.cached_property
    def time(self) -> Port:
        return self._of_motion("time")

    @functools.cached_property
    def inputs(self) -> tuple[Port, ...]:
        """Value, slope and curvature of the input; none without."""
        if self.input is None:
            return ()
        inputs = [self._of_motion("drive")]
        for _ in INPUT_NAMES[1:]:
            unit = inputs[-1].unit if self.system.units is None else over_seconds(inputs[-1].unit)
            inputs.append(Port("", unit, inputs[-1].scale / self.time.scale))
        names = ("drive", *(f"drive_{name}" for name in INPUT_NAMES[1:]))
        return tuple(dataclasses.replace(port, name=name) for port, name in zip(inputs, names, strict=True))

    @functools.cached_property
    def scales(self) -> PortScales:
        """Of the SI units, where the case is in SI."""
        if self.system.units is None:
            return NO_UNITS
        names = (*self.states, *self.observables)
        units = {port.name: port.unit for port in (self.time, *self.inputs, *names)}
        inputs = tuple(port.scale for port in self.inputs) or NO_UNITS.inputs
        return PortScales(self.time.scale, inputs, np.array([port.scale for port in names]), units)

    @functools.cached_property
    def parameters(self) -> tuple[Port, ...]:
        """Those that can be set before the motion begins, by their paths; an input has none.

        Of a sampled controller those are left out that decide how many samples a period has, and when they act.
        """
        parameters, parts, corners = [], self.system.parts, self.equations.corners
        counted = () if corners is None else corners.counted
        values = zip(self.equations.parameter_paths, parameter_values(self.system), strict=True)
        for place, (path, value) in enumerate(values):
            part, name = split_path(path)
            if not (path.startswith(SEGMENT) or part == self.input or place in counted):
                known = quantity_in_si(path, self.system)
                parameters.append(Port(path, known.unit, known.scale, value, *bounds(parts[part], name), place))
        return tuple(parameters)

    @functools.cached_property
    def states(self) -> tuple[Port, ...]:
        """In the order of the state vector; the value is the initial one."""
        initial = initial_state(self.case.system, self.case.initial)
        return tuple(self._of_motion(name, value) for name, value in initial.items())

    @functools.cached_property
    def observables(self) -> tuple[Port, ...]:
        """In the order in which the stepper shows them, after the states."""
        return tuple(map(self._of_motion, self.kernel.observed))

    def _of_motion(self, name: str, value: float = 0.0) -> Port:
        if self.system.units is None:
            return Port(name, value=value)
        return Port(name, self.system.si.unit(name), self.system.si.factor(name), value)

    @functools.cached_property
    def names(self) -> tuple[str, ...]:
        """What is seen: states, then observables."""
        return (*(port.name for port in self.states), *self.kernel.observed)

    @functools.cached_property
    def contacts(self) -> int:
        return len(self.equations.contacts)

    @functools.cached_property
    def event_kinds(self) -> tuple[str, ...]:
        """Names of what is counted: kinds of event of each contact, then those of none, from `contact_kinds` on."""
        kinds = event_kinds(self.system.placed.switch_events)
        all_kinds = (*kinds[: codes.SWITCHED + 1].tolist(), *kinds[codes.MACHINE_SWITCHED :].tolist())
        return all_kinds[: self.kernel.counted_kinds]  # a machine may have fewer branches than it has names

    @property
    def contact_kinds(self) -> int:
        """How many kinds of event are of a contact."""
        return codes.SWITCHED

    @functools.cached_property
    def counted(self) -> tuple[str, ...]:
        """Name of each number that the stepper counts events with; of a further contact "stick_2" and so on."""
        own, others = self.event_kinds[: self.contact_kinds], self.event_kinds[self.contact_kinds :]
        return (*(numbered(kind, c) for kind in own for c in range(1, self.contacts + 1)), *others)

    @functools.cached_property
    def statuses(self) -> dict[int, str]:
        """What each status is called."""
        named = {code: status.value for code, status in STATUSES.items() if code != codes.DONE}
        return {codes.RUNNING: "running", AT_EVENT: "at an event", REFUSED: "refused", **named}


class Stepped:
    """What motions that are moved on from outside have in common, one or many: what can be seen, units, keeping.

    A subclass binds its memory in `_bind(memory, scales)` and copies it in `_copied`.
    """

    stepped: SteppedCase
    _memory: Any
    _scales: PortScales

    def _bind(self, memory: Any, scales: PortScales) -> None:
        raise NotImplementedError

    def _copied(self) -> Any:
        raise NotImplementedError

    @property
    def names(self) -> tuple[str, ...]:
        """What can be asked for by name, the order of `values`: states, then observables."""
        return self.stepped.names

    @property
    def dimensionless(self) -> Self:
        """The same, not a copy, that takes and answers in numbers without units."""
        return stepped_again(type(self), self.stepped, self._memory, NO_UNITS)

    @property
    def in_si(self) -> Self:
        """The same, not a copy, that takes and answers in SI; the numbers without units where nothing is."""
        return stepped_again(type(self), self.stepped, self._memory, self.stepped.scales)

    def unit_of(self, name: str) -> str:
        """The SI unit of "time" or of a name; of inputs "drive", "drive_slope", "drive_curvature". "1": without."""
        return self._scales.units.get(name, "1")

    def copy(self) -> Self:
        """The same once more, apart from this one."""
        return stepped_again(type(self), self.stepped, self._copied(), self._scales)

    def __reduce__(self):
        return stepped_again, (type(self), self.stepped, self._copied(), self._scales)


def stepped_again(kind: type[Stepped], stepped: SteppedCase, memory: Any, scales: PortScales) -> Any:
    """What is stepped with a memory."""
    again = object.__new__(kind)
    again.stepped = stepped
    again._bind(memory, scales)
    return again
