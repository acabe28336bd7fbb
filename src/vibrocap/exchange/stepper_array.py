"""Many motions of one case that are moved on from outside, side by side."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, shown, suggestion
from vibrocap.exchange.stepped_case import NO_UNITS, PortScales, Stepped, SteppedCase
from vibrocap.motion.held_input import INPUT_NAMES
from vibrocap.motion.recording.equations import parameter_values
from vibrocap.motion.simulate import STATUSES
from vibrocap.motion.status import Status
from vibrocap.numerics.api import StepperMemory


class StepperArray(Stepped):
    """Many motions of one case, apart from one another; arrays of their numbers go in and come out.

    Each has the bits that it has alone (`Stepper`). One that cannot continue stays where it ended: `ended` says which
    they are, and `statuses` why.
    """

    def __init__(self, stepped: SteppedCase, count: int, columns: Mapping[str, Any]):
        self.stepped, self.count = stepped, count
        one, placed = stepped.memory(), self._placed(columns)
        self._bind(tuple(np.tile(memory, (count, 1)) for memory in (one.floats, one.ints, one.trace)), NO_UNITS)
        for place, column in placed.items():
            self._floats[:, place] = column
        for memory in self._memories():
            stepped.kernel.entry("begin_motion", memory)(0)

    def _placed(self, columns: Mapping[str, Any]) -> dict[int, np.ndarray]:
        """Initial states and parameters of all motions by their place in the memory."""
        places, by_place = self.stepped.kernel.places, {}
        states = {port.name: places["STATE"] + i for i, port in enumerate(self.stepped.states)}
        ports = {port.name: port for port in self.stepped.parameters}
        for name, value in columns.items():
            in_si = self.stepped.system.units is not None and "." in name
            if name not in states and name not in ports and not in_si:
                raise ArgumentError(str(name), f"no such state or parameter; {suggestion(name, [*states, *ports])}")
            column = self._column(name, value)
            if name not in states and name not in ports:
                by_place |= {places["PARAMETER"] + i: values for i, values in self._given_in_si(name, column).items()}
                continue
            if name in ports:
                port = ports[name]
                if np.any((column < port.least) | (column > port.most)):
                    limits = f"from {port.least:.4g} to {port.most:.4g}"
                    raise ArgumentError(name, f"should be {limits}, got {shown(value)}")
                by_place[places["PARAMETER"] + port.place] = column
            else:
                by_place[states[name]] = column
        return by_place

    def _given_in_si(self, path: str, column: np.ndarray) -> dict[int, np.ndarray]:
        """What a parameter in SI makes of the parameter vector, by place, where it changes any of it."""
        system = self.stepped.system
        rows = np.array([parameter_values(system.with_parameters({path: value})) for value in column.tolist()])
        changed = np.flatnonzero(np.any(rows != parameter_values(system), axis=0))
        return {int(i): rows[:, i] for i in changed}

    def _column(self, name: str, value: Any) -> np.ndarray:
        column = np.asarray(value, dtype=float)
        if column.shape not in ((), (self.count,)):
            raise ArgumentError(name, f"should be a number or {self.count} of them, got an array {column.shape}")
        if not np.all(np.isfinite(column)):
            raise ArgumentError(name, f"should be finite, got {shown(value)}")
        return np.broadcast_to(column, (self.count,))

    def _bind(self, memory: tuple[np.ndarray, ...], scales: PortScales) -> None:
        self._memory, self._scales = memory, scales
        self._floats, self._ints, self._trace = memory
        self.count = len(self._floats)
        self._places, kernel = self.stepped.kernel.places, self.stepped.kernel
        self._take = [kernel.entry("take_step", memory) for memory in self._memories()]
        self._look = [kernel.entry("look_at", memory) for memory in self._memories()]

    def _memories(self) -> list[StepperMemory]:
        return [StepperMemory(*memory) for memory in zip(self._floats, self._ints, self._trace, strict=True)]

    def _copied(self) -> tuple[np.ndarray, ...]:
        return tuple(rows.copy() for rows in self._memory)

    def step(self, *numbers: Any) -> None:
        """`step(length)` with the case's own drive, `step(value, length)` of an input: numbers, or arrays [count].

        After the length may stand slope and curvature of the input, 0 by default, as of `InputStepper`.
        """
        self._set(numbers)
        for take in self._take:
            take(0)

    def step_to_event(self, *numbers: Any) -> np.ndarray:
        """As `step`, but each motion stops at its first event; whether it did: array [count] of bool."""
        self._set(numbers)
        self._ints[:, self._places["STOPPED"]] = 0
        for take in self._take:
            take(1)
        return self._ints[:, self._places["STOPPED"]] == 1

    def _set(self, numbers: Sequence[Any]) -> None:
        """Lengths and inputs of the next step."""
        wanted, last = (("length",), 1) if self.stepped.input is None else (("value", "length", *INPUT_NAMES[1:]), 2)
        if not last <= len(numbers) <= len(wanted):
            raise TypeError(f"step takes {' and '.join(wanted[:last])}, got {len(numbers)} values")
        columns = {name: self._column(name, value) for name, value in zip(wanted, numbers, strict=False)}
        if not np.all(columns["length"] > 0.0):
            raise ArgumentError("length", f"should be a finite length of time > 0, got {shown(numbers[last - 1])}")
        self._floats[:, self._places["LENGTH"]] = columns["length"] / self._scales.time
        if self.stepped.input is not None:
            for i, name in enumerate(INPUT_NAMES):
                self._floats[:, self._places["INPUT"] + i] = columns.get(name, 0.0) / self._scales.inputs[i]
            self._ints[:, self._places["NEW_INPUT"]] = 1

    @property
    def time(self) -> np.ndarray:
        """Of each motion: array [count]."""
        return self._floats[:, self._places["CLOCK"]] * self._scales.time

    @property
    def values(self) -> np.ndarray:
        """States and observables now: array [count, names]."""
        for look in self._look:
            look(0)
        return self._trace[:, : len(self.names)] * self._scales.values

    @property
    def states(self) -> np.ndarray:
        """Array [count, states]."""
        return self.values[:, : len(self.stepped.states)]

    @property
    def sides(self) -> np.ndarray:
        """+1, -1 where a contact slides, 0 where it is at rest: array [count, contacts] of ints."""
        first = self._places["SHOWN_SIDE"]
        return self._floats[:, first : first + self.stepped.contacts].astype(int)

    @property
    def events(self) -> dict[str, np.ndarray]:
        """How often each kind of event occurred, by name as of `Stepper`: arrays [count]."""
        first, counts = self._places["COUNTED"], dict.fromkeys(self.stepped.counted, np.zeros(self.count, int))
        for i, name in enumerate(self.stepped.counted):
            counts[name] = counts[name] + self._ints[:, first + i]
        return counts

    @property
    def ended(self) -> np.ndarray:
        """Whether each motion has ended: array [count] of bool."""
        return self._ints[:, self._places["ENDED"]] != 0

    @property
    def statuses(self) -> list[Status | None]:
        """Why each motion has ended; None of one that continues."""
        return [STATUSES[code] if code else None for code in self._ints[:, self._places["ENDED"]].tolist()]

    def __len__(self) -> int:
        return self.count

    def __repr__(self) -> str:
        return f"<StepperArray: {self.count} motions, {np.count_nonzero(self.ended)} of them ended>"

    def restore(self, kept: "StepperArray") -> None:
        """Go back to motions that were kept by `copy`."""
        if type(kept) is not type(self) or kept.count != self.count or kept.stepped != self.stepped:
            raise ArgumentError("kept", f"should be a copy of these motions, got {shown(kept)}")
        self._floats[:], self._ints[:], self._trace[:] = kept._floats, kept._ints, kept._trace
