"""The equations of a system as they are recorded: what all writers and runs of the numerics are given."""

import dataclasses
import functools
from collections.abc import Container, Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.expressions.graph import (
    Expression,
    Graph,
    depends_on_time,
    derivative,
    evaluate,
    evaluated,
    reachable,
)

NEAR = 2.0 * float(np.finfo(float).eps)  # of the period, as in the kernel: a segment that ends so soon is over


@dataclasses.dataclass(frozen=True, eq=False)
class Corners:
    """The segments of a drive in one period, as functions of the parameter vector.

    place: number of the first parameter that belongs to the present segment; coefficients: per segment
    parts: how many equal ones the period has, to rounding, each of all these segments: samples of a controller, or 1.0
    lengths, shapes: of each segment of a part its share of the period and its coefficients in powers of the share; may
        depend on the time at which the part begins
    """

    place: int
    coefficients: int
    period: Expression
    lengths: tuple[Expression, ...]
    shapes: tuple[tuple[Expression, ...], ...]
    parts: Expression

    @property
    def row_size(self) -> int:
        """Numbers per segment of a table: the share at its end, its coefficients."""
        return 1 + self.coefficients

    @functools.cached_property
    def numbers(self) -> list[Expression]:
        """Of each segment of a part its length, then its coefficients."""
        return [e for length, shape in zip(self.lengths, self.shapes, strict=True) for e in (length, *shape)]

    @functools.cached_property
    def counted(self) -> list[int]:
        """Numbers of the parameters that decide how many parts there are, and where their corners lie."""
        return [] if self.parts.value == 1.0 else self._reached([self.period, self.parts, *self.lengths])

    @functools.cached_property
    def _moving(self) -> list[int]:
        """Numbers of the parameters on which the table depends."""
        return self._reached([*self.numbers, *([] if self.parts.value == 1.0 else [self.period])])

    @functools.cached_property
    def _decisive(self) -> list[int]:
        """Numbers of the parameters on which table and period depend."""
        return self._reached([*self.numbers, self.period, self.parts])

    def _reached(self, expressions: Sequence[Expression]) -> list[int]:
        graph = self.period.graph
        nodes = (graph.nodes[i] for i in reachable(graph, [e.index for e in expressions]))
        return [operands[0] for op, *operands in nodes if op == "parameter"]

    def count(self, parameters: np.ndarray) -> int:
        """How many parts the period has with parameters [..., parameters], as many with all of them."""
        (parts,) = evaluate([self.parts], 0.0, (), 1.0, np.moveaxis(parameters, -1, 0))
        return round(float(np.ravel(parts)[0]))

    def tables(self, parameters: np.ndarray) -> np.ndarray:
        """[runs, segments, row_size] of parameter vectors [runs, parameters]; one table if it is the same for all."""
        if np.all(parameters[:, self._moving] == parameters[:1, self._moving]):
            parameters = parameters[:1]
        runs, parts = len(parameters), self.count(parameters)
        begins = np.arange(parts)[:, None] * (self.periods(parameters) / parts)
        columns = evaluated(self.numbers, begins, (), 1.0, parameters.T, (parts, runs))
        tables = np.ascontiguousarray(columns.T).reshape(runs, parts, -1, self.row_size)
        tables[..., 0] = np.cumsum(tables[..., 0], axis=2) + (np.arange(parts) / parts)[:, None]
        tables[:, :, -1, 0] = np.arange(1, parts + 1) / parts  # where no rounding adds up
        return tables.reshape(runs, -1, self.row_size)

    def periods(self, parameters: np.ndarray) -> np.ndarray:
        """[runs] periods of the drive."""
        return evaluated([self.period], 0.0, (), 1.0, parameters.T, (len(parameters),))[0]

    def of_one(self, parameters: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
        """([1, segments, row_size] table, [1] period) of one parameter vector, whatever segment it holds."""
        return _of_one(self, tuple(parameters[i] for i in self._decisive))

    def filled(self, parameters: np.ndarray, time: Any = 0.0) -> np.ndarray:
        """Parameter vectors [..., parameters] with the segment that holds at a time since the start of the period."""
        rows = np.atleast_2d(np.array(parameters, dtype=float))
        known = self.of_one(tuple(rows[0])) if len(rows) == 1 else (self.tables(rows), self.periods(rows))
        _, present = self.present(*known, np.broadcast_to(time, (len(rows),)))
        rows[:, self.place :] = present.T
        return rows.reshape(np.shape(parameters))

    def present(
        self, tables: np.ndarray, periods: np.ndarray, time: np.ndarray, near: float = NEAR
    ) -> tuple[np.ndarray, np.ndarray]:
        """(number of the segment [n], its numbers in the parameter vector [2 + coefficients, n]) at times [n].

        tables: [n or 1, segments, row_size]; periods: [n or 1]; time: since the start of the period
        near: share of the period from which on a segment that is left counts as over
        """
        time = np.asarray(time, dtype=float)
        if len(tables) == 1:
            share = time / periods + near
            number = np.searchsorted(tables[0, :, 0], share, side="right")
        else:
            number = np.sum(tables[:, :, 0] <= (time / periods + near)[:, None], axis=1)
        number = np.minimum(number, tables.shape[1] - 1)
        which = np.arange(len(time)) if len(tables) > 1 else np.zeros(len(time), dtype=int)
        start = np.where(number > 0, tables[which, number - 1, 0], 0.0) * periods
        divisors = np.broadcast_to(periods, (self.coefficients, len(time))).copy()
        divisors[:1] = 1.0
        scale = np.divide.accumulate(np.vstack((np.ones((1, len(time))), divisors)))[1:].T  # as the kernel does it
        coefficients = tables[which, number, 1:] * scale
        return number, np.stack((np.broadcast_to(periods, time.shape), start, *coefficients.T))


@functools.lru_cache(maxsize=64)
def _of_one(corners: Corners, decisive: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    row = np.zeros((1, corners.place))
    row[0, corners._decisive] = decisive
    return corners.tables(row), corners.periods(row)


@dataclasses.dataclass(frozen=True, eq=False)
class ContactEquations:
    """Recorded equations of one contact.

    friction: R; velocity: of sliding; state: number of the state that moves one to one with it; kind: "set-valued" (it
    can rest), "kinked" or "smooth"; hold: the force that would hold it in the present modes of all others, over the
    middle of what it can hold; limit: how far that reaches (both None where it cannot rest); internal: numbers of the
    states of its law, without those that change at events only; after_reversal: all states after it has turned to its
    side
    """

    friction: Expression
    velocity: Expression
    state: int
    kind: str
    hold: Expression | None
    limit: Expression | None
    internal: tuple[int, ...]
    after_reversal: tuple[Expression, ...]

    @property
    def sticks(self) -> bool:
        """Whether it can rest."""
        return self.hold is not None

    @functools.cached_property
    def is_state(self) -> bool:
        """Whether its velocity is one of the states, whose series is then its own."""
        return self.velocity.index == self.velocity.graph.node("state", self.state).index


@dataclasses.dataclass(frozen=True, eq=False)
class DecisionRows:
    """The problem of several contacts at rest, recorded: see `physics/contacts.py`, and what each may take.

    b [n], response [n n], loads [n], load_response [n n] (none of constant loads); of each contact, as taken by the
    machine: force while it slides (per load), what pushes it then and at rest, least and most that it can hold, and
    least and most once it has given way (per load; None where it cannot rest)
    """

    b: tuple[Expression, ...]
    response: tuple[tuple[Expression, ...], ...]
    loads: tuple[Expression, ...]
    load_response: tuple[tuple[Expression, ...], ...]
    forces: tuple[Expression, ...]
    pushes: tuple[tuple[Expression, ...], ...]
    bounds: tuple[tuple[Expression, ...] | None, ...]

    @property
    def groups(self) -> tuple[int, ...]:
        """Of each contact the first of those with which the friction of one on another connects it."""
        groups = list(range(len(self.b)))
        for answers in (self.response, self.load_response):
            for i, row in enumerate(answers):
                for j, entry in enumerate(row):
                    if entry.value != 0.0:
                        both = groups[i], groups[j]
                        groups = [min(both) if group in both else group for group in groups]
        return tuple(groups)


@dataclasses.dataclass(frozen=True, eq=False)
class MotionRow:
    """One equation of motion as mechanics tells it, along a speed of the machine.

    left: what inertial forces, by rates of the velocities of places, leave of all others: what friction takes, or 0
    rates: the solved acceleration, and it again where it is exactly zero at rest
    """

    left: Expression
    rates: tuple[Expression, ...]


@dataclasses.dataclass(frozen=True, eq=False)
class Load:
    """A load that the motion makes: as told by accelerations, and as solved, moving and at rest (None: no other)."""

    value: Expression
    moving: Expression
    at_rest: Expression | None


@dataclasses.dataclass(frozen=True, eq=False)
class ContactMechanics:
    """What friction does to the row of one contact.

    friction: while it slides, less the push from outside; share: 1 where it slides, 0 where it rests; held, taken: the
    solved forces that would hold it, and that act on it among others
    """

    friction: Expression
    share: Expression
    held: Expression | None
    taken: Expression | None
    load: Load | None

    def without_load(self, outside: Container[int]) -> "ContactMechanics":
        """The same where its load is one of the forces from outside, which are known by these nodes."""
        outer = self.load is not None and self.load.moving.index in outside
        return dataclasses.replace(self, load=None) if outer else self


@dataclasses.dataclass(frozen=True, eq=False)
class Mechanics:
    """The equations of motion, told rather than solved: a row for each speed, those of the contacts last."""

    rows: tuple[MotionRow, ...]
    contacts: tuple[ContactMechanics, ...]


def rate_of(value: Expression, rates: Sequence[Expression]) -> Expression:
    """Rate of a function of time and state."""
    expression = derivative(value, -1)
    for i, rate in enumerate(rates):
        expression = expression + derivative(value, i) * rate
    return expression


@dataclasses.dataclass(frozen=True, eq=False)
class Equations:
    """Recorded equations of all systems of one form; their numbers are in the parameter vector.

    rates: y' per state; powers: of the energy channels.
    """

    graph: Graph
    state_names: tuple[str, ...]
    channels: tuple[str, ...]
    parameter_paths: tuple[str, ...]
    rates: tuple[Expression, ...]
    powers: tuple[Expression, ...]
    scales: tuple[Expression, ...]
    contacts: tuple[ContactEquations, ...]
    rows: DecisionRows | None  # of several contacts
    # at imposed distances, the velocity of each contact less the state that all share: functions of time
    shifts: tuple[Expression, ...]
    cyclic_state: int  # -1: none
    turns: tuple[tuple[int, float], ...]  # states that turn, each with its period
    symmetry: tuple[int, ...]  # sign of each state under the half-period symmetry
    period: Expression
    switches: tuple[Expression, ...]  # guards of the branches of the law, then of the machine
    law_switches: int  # how many of them are the laws'
    impact: int  # place among the powers of the work of impacts; -1: there is none
    loads: tuple[Expression, ...]  # of a contact that slips and of one at rest, or of all contacts; none if constant
    divisors: tuple[Expression, ...]  # by which forces at contacts are solved; they vanish only where a bound does
    bounds: tuple[Expression, ...]  # positive while the equations hold; a run ends where one of them is not
    bound_kinds: tuple[int, ...]  # number of each bound among those that there are
    located: tuple[bool, ...]  # of each bound: whether the run ends at the very instant, or at the start of a step
    after_switch: tuple[tuple[Expression, ...], ...]  # states, per guard
    maybe_stiff: bool  # whether a contact has a law with a force for every velocity
    observables: dict[str, Expression]
    base: int  # states of the motion itself; tangents may follow them
    mechanics: Mechanics | None  # the equations of motion before they are solved, where they are told
    guard_tangents: tuple[Expression, ...] = ()  # how the guards grow along the tangent
    corners: Corners | None = None  # of the drive; its present segment stands behind the other parameters
    # what the ground would have to give, of loads that are held constant: by the name of the observable
    true_loads: dict[str, Expression] = dataclasses.field(default_factory=dict)

    @property
    def integrals(self) -> tuple[Expression, ...]:
        """Rates of the quantities that a motion carries along: powers, then friction by contact."""
        return (*self.powers, *(contact.friction for contact in self.contacts))

    @property
    def timed(self) -> bool:
        """Whether they contain the time; otherwise motions have periods of their own."""
        return self.corners is not None or depends_on_time(self.rates)

    def by_momenta(self, load: Expression) -> Expression:
        """A load by the rates of momenta where mechanics has it so, which takes few products."""
        contacts = () if self.mechanics is None else self.mechanics.contacts
        loads = {contact.load.moving.index: contact.load.value for contact in contacts if contact.load is not None}
        return loads.get(load.index, load)

    @property
    def holding(self) -> list[Expression]:
        """Of each contact that can rest the force that would hold it, and its limit."""
        pairs = ((contact.hold, contact.limit) for contact in self.contacts)
        return [value for pair in pairs for value in pair if value is not None]

    @property
    def several(self) -> bool:
        """Whether there are several contacts."""
        return len(self.contacts) > 1

    @property
    def coupled(self) -> bool:
        """Whether friction at one contact accelerates another."""
        rows = () if self.rows is None else self.rows.response
        return any(entry.value != 0.0 for i, row in enumerate(rows) for entry in (*row[:i], *row[i + 1 :]))

    @property
    def imposed(self) -> tuple[ContactEquations, ...]:
        """Contacts whose velocities are no states."""
        return tuple(contact for contact in self.contacts if not contact.is_state)

    @property
    def guards(self) -> tuple[Expression, ...]:
        """Of the branches of law and machine, then the bounds: a step ends where one of them falls to zero."""
        return (*self.switches, *self.bounds)

    def filled(self, parameters: Any, time: Any = 0.0) -> Any:
        """Parameter vectors with the segment of the drive at a time since the start of its period, where it has any."""
        if self.corners is None or not np.size(parameters):  # no drive that has corners, or no run
            return parameters
        return self.corners.filled(parameters, time)
