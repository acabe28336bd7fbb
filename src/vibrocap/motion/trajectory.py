"""What a motion is: its pieces, its events, and the certificate of how exact it is."""

import collections
import dataclasses
import functools
from collections.abc import Callable
from typing import Annotated, Any

import numpy as np

from vibrocap.motion.certificate import Certificate
from vibrocap.motion.crossings import polynomial_slopes, polynomial_values
from vibrocap.motion.observer import Observer
from vibrocap.motion.recording.equations import parameters_at
from vibrocap.motion.status import Status
from vibrocap.numerics.api import PieceSeries
from vibrocap.physics.names import numbered
from vibrocap.quantities.declared import (
    AlongNames,
    ByName,
    In,
    Named,
    NamedArray,
    Number,
    Numbers,
    StateColumns,
    StateRows,
    States,
    Time,
    Times,
)
from vibrocap.quantities.dimensional import Dimensional, said
from vibrocap.results import Result, Rows

IMPACT_WORK = "impact_work"  # what impacts take, at one instant each
STUCK, FORWARD, BACK = 0, 1, -1
PIECES_AT_A_TIME = 10_000  # where many are looked at
MANY = 100_000  # instants from which on a compiled loop looks at them, whose kernel is made in a tenth of a second
Moments = Annotated[Any, In("s")]  # a time or an array of times
NamedValue = Annotated[float, Named("name")]  # of the quantity that the argument `name` names
GAUSS_NODES = 12  # per piece; a piece is short against the distance to the nearest singularity
gauss = functools.cache(np.polynomial.legendre.leggauss)  # made once
AT_ONCE = 1e-12  # of a period: so soon after a piece of no length, an event at the end, its drive is asked for


@dataclasses.dataclass(frozen=True)
class Event(Dimensional):
    """A change of the contact, located to rounding level.

    kind: "stick", "slip_forward", "impact" and so on; what each means stands in `physics/events.py`. Of a further
    contact its number stands behind it: "stick_2".
    contact: its number, 1 for the first; 0 of what happens at none
    """

    time: Time
    kind: str
    state: States
    contact: int = 0


@dataclasses.dataclass(frozen=True)
class Phase(Dimensional):
    """A stretch of time on one side: 0 stuck, +1 sliding forward, -1 sliding back."""

    start: Time
    end: Time
    side: int

    @property
    def length(self) -> Time:
        """Duration."""
        return self.end - self.start


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Result):
    """A motion, known at every instant: on each piece every state is a polynomial in time.

    motion["position"] is the position at motion.time (a uniform grid that ends with the run), motion.at(t, name) at any
    times. Names: the states, the contact's "side", observables such as "friction", "drive", "holding_force" and
    "energy", and the integrals from the start, such as "drive_work".

    Two motions are equal if system, start, settings and every number of their pieces and events are. A motion can be
    pickled, with its certificate if that has been asked for.
    """

    system: Any
    initial: ByName
    periods: Number
    tolerance: Number
    period: Time
    run_status: Status  # how the run ended, whatever its certificate says
    state_names: tuple[str, ...]
    integral_names: tuple[str, ...]
    piece_start: Times  # [pieces]
    piece_length: Times  # [pieces]
    piece_sides: Numbers  # [pieces, contacts] 0 where a contact rests, +1 or -1 where it slides
    piece_implicit: Numbers  # [pieces] whether an implicit step made it
    piece_drive_time: Times  # [pieces] at their starts, since the drive began its period
    series: Annotated[PieceSeries, np.ndarray]  # read like an array [pieces, states, order + 1] of no one quantity
    sections: StateColumns  # [whole periods completed + 1, states] at the period marks, which count from the start
    event_times: Times  # [events]
    event_kinds: Numbers  # [events] of names
    event_contacts: Numbers  # [events] number of the contact, 1 for the first; 0 where it is of none
    event_states: StateColumns  # [events, states]
    observe: Observer = dataclasses.field(compare=False)
    observable_names: tuple[str, ...]
    certify: Callable[..., Certificate] = dataclasses.field(compare=False)
    samples: int = 256  # per period, of the grid `time`
    start_time: Time = 0.0
    start_phase: Number = 0.0  # of the drive at the start, a share of its period

    @property
    def coefficients(self) -> np.ndarray:
        """Coefficients of all pieces in powers of the time since their start: array [pieces, states, order + 1].

        Made anew at each call, as a motion keeps some of them only, see `PieceSeries`.
        """
        return self.series[:]

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled: the fields, and of what was made from them only the certificate, which costs a run."""
        kept = {field.name for field in dataclasses.fields(self)} | {"certificate"}
        return {name: value for name, value in vars(self).items() if name in kept}

    @property
    def heading(self) -> str:
        parts = self.system
        return f"motion of a {parts.machine.name}, {parts.law_names} friction, {parts.drive.name} drive"

    @property
    def facts(self) -> dict[str, str]:
        kinds = collections.Counter(map(str, self.event_kinds))
        what = ", ".join(f"{count} {kind.replace('_', ' ')}" for kind, count in kinds.items())
        return {
            "length": f"{self.periods:g} periods, time {self.start_time:.6g} to {self.said('end', 6)}",
            "events": f"{len(self.event_times)} events" + (f" ({what})" if what else ""),
            "end": ", ".join(f"{name} = {said(value, self.unit_of(name), 5)}" for name, value in self.state.items()),
            "status": self.status.value,
        }

    @property
    def status(self) -> Status:
        """How the run ended; `NOT_CERTIFIED` once its certificate has been asked for and has failed."""
        certificate = vars(self).get("certificate")
        if self.run_status.ok and certificate is not None and not certificate.ok:
            return Status.NOT_CERTIFIED
        return self.run_status

    @property
    def end(self) -> Time:
        """Time reached."""
        return float(self.piece_start[-1] + self.piece_length[-1]) if len(self.piece_start) else self.start_time

    @property
    def end_phase(self) -> Number:
        """Where in its period the drive is at the end, from 0 to 1."""
        done = self.periods if self.run_status.ok else (self.end - self.start_time) / self.period
        return (self.start_phase + done) % 1.0

    def drive_at(self, index: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, tuple]:
        """(time since the drive began its period, parameter vector) at times s since the start of the pieces.

        At the end of a piece the drive is still that of the piece, also where it jumps. Where it has corners, the
        numbers of its segment in the parameter vector are arrays.
        """
        start, length = self.piece_drive_time[index], self.piece_length[index]
        inside = np.where(length > 0.0, 0.5 * length, AT_ONCE * self.period)
        parameters = parameters_at(self.system, start + inside)
        return along(start, s) + s, tuple(along(own, s) if np.ndim(own) else own for own in parameters)

    def sides(self, index: np.ndarray) -> tuple[np.ndarray, ...]:
        """Side of each contact on some pieces: an array [n] each."""
        return tuple(self.piece_sides[index].T)

    @functools.cached_property
    def time(self) -> Times:
        """A uniform grid, `samples` points per period, both ends included; empty of a motion that never began."""
        if not len(self.piece_start):
            return np.empty(0)
        count = max(1, round(self.samples * (self.end - self.start_time) / self.period))
        return np.linspace(self.start_time, self.end, count + 1)

    @functools.cached_property
    def events(self) -> Rows[Event]:
        """Changes of the contact, in order; `events.table()` and `events.to_pandas()` give them as a table."""
        states = (dict(zip(self.state_names, map(float, row), strict=True)) for row in self.event_states)
        rows = zip(self.event_times, self.event_kinds, states, self.event_contacts, strict=True)
        return Rows(Event(float(t), str(kind), state, int(contact)) for t, kind, state, contact in rows)

    @functools.cached_property
    def certificate(self) -> Certificate:
        """Evidence of exactness, computed on first use."""
        return self.certify(self)

    @property
    def certified(self) -> bool:
        """The verdict of its certificate, computed without the fields that have no bound."""
        return (vars(self).get("certificate") or self.certify(self, whole=False)).ok

    @functools.cached_property
    def state(self) -> States:
        """The final state by name."""
        values = self.states(np.array([self.end])) if len(self.piece_start) else self.sections[:1].T
        return {name: float(values[i, 0]) for i, name in enumerate(self.state_names)}

    @property
    def names(self) -> tuple[str, ...]:
        """All names of the motion's quantities."""
        return (*self.state_names, *self.integral_names, *self.observable_names, *self.side_names)

    @property
    def side_names(self) -> tuple[str, ...]:
        """Names of the sides of all contacts, "side" of the first."""
        return tuple(numbered("side", i) for i in range(1, 1 + self.piece_sides.shape[1]))

    def side_of(self, name: str) -> Numbers:
        """A side by its name: array [pieces]."""
        return self.piece_sides[:, self.side_names.index(name)]

    def piece_at(self, t: Moments) -> Numbers:
        """Index of the piece at each time; at a border the later one."""
        return np.maximum(np.searchsorted(self.piece_start, t, side="right") - 1, 0)

    def _located(self, t: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times as an array, the piece of each and the time since its start."""
        t = np.atleast_1d(np.asarray(t, dtype=float))
        if len(t) and not len(self.piece_start):
            raise ValueError(
                f"this motion ended where it began ({self.status.value}): it holds its initial condition only"
            )
        if np.any((t < self.start_time - 1e-12 * abs(self.start_time)) | (t > self.end + 1e-12 * abs(self.end))):
            raise ValueError(f"times should lie between start_time and end of the motion ({self.status.value})")
        index = self.piece_at(t)
        return t, index, t - self.piece_start[index]

    def piece_states(self, index: np.ndarray, s: np.ndarray) -> np.ndarray:
        """States at times s since the start of the pieces: array [states, *s.shape].

        index: [n]; s: [n], or [n, points] of as many instants in each of the pieces
        """
        if s.size >= MANY:
            return self.observe.at_many(self, self.state_names, index, s)
        return polynomial_values(self.series, index, s)

    def piece_slopes(self, index: np.ndarray, s: np.ndarray) -> np.ndarray:
        """Slopes of the polynomials of the states at times s since the start of the pieces: [states, *s.shape]."""
        return polynomial_slopes(self.series, index, s)

    def piece_observables(self, names: tuple[str, ...], index: np.ndarray, s: np.ndarray) -> np.ndarray:
        """Observables, or rates of integrals, at times s since the start of the pieces: array [names, *s.shape].

        Of pieces that implicit steps have made, what depends on the law's forces and rates is asked at states that fit
        to the slopes of the polynomials, see `kernel/step/linear_system.py`.
        """
        if s.size >= MANY or np.any(self.piece_implicit[index]):
            return self.observe.at_many(self, names, index, s)
        t, sides = along(self.piece_start[index], s) + s, tuple(along(side, s) for side in self.sides(index))
        return self.observe(names, t, self.piece_states(index, s), sides, self.drive_at(index, s))

    def states(self, t: Moments) -> StateRows:
        """States at times t: array [states, len(t)]."""
        _, index, s = self._located(t)
        return self.piece_states(index, s)

    def integrals(self, t: Moments) -> Annotated[np.ndarray, AlongNames(0, ("integral_names",))]:
        """Integrals from the start to times t, work by channel and impulse of friction: array [integrals, len(t)].

        Gauss-Legendre quadrature of the powers on every piece, where they are analytic; exact to rounding for the
        motion as it is recorded.
        """
        _, index, s = self._located(t)
        return self.piece_marks[:, index] + self.piece_integrals(index, s)

    @functools.cached_property
    def piece_marks(self) -> np.ndarray:
        """Integrals at the start of every piece and at the end: array [integrals, pieces + 1]."""
        whole = self.piece_integrals(np.arange(len(self.piece_start)), self.piece_length)
        marks = np.concatenate((np.zeros((len(whole), 1)), np.cumsum(whole, axis=1)), axis=1)
        if IMPACT_WORK in self.integral_names:
            marks[self.integral_names.index(IMPACT_WORK), 1:] += np.cumsum(np.append(self.piece_jumps, 0.0))
        return marks

    @functools.cached_property
    def piece_distances(self) -> np.ndarray:
        """How far each contact has slid over its ground at the start of every piece: array [contacts, pieces]."""
        names = tuple(numbered("contact_velocity", i) for i in range(1, 1 + self.piece_sides.shape[1]))
        distances = self.piece_integrals(np.arange(len(self.piece_start) - 1), self.piece_length[:-1], names)
        return np.concatenate((np.zeros((len(names), 1)), np.cumsum(distances, axis=1)), axis=1)

    def _gained(self, name: str, later: np.ndarray) -> np.ndarray:
        """What an observable gains where these pieces begin, over the ends of those before: array [n]."""
        index, s = np.concatenate((later - 1, later)), np.concatenate((self.piece_length[later - 1], 0.0 * later))
        before, after = self.piece_observables((name,), index, s).reshape(2, -1)
        return after - before

    @functools.cached_property
    def piece_jumps(self) -> np.ndarray:
        """Energy that the machine gains where each piece but the first begins, in impacts: array [pieces - 1]."""
        return self._gained("energy", np.arange(1, len(self.piece_start)))

    @functools.cached_property
    def piece_blows(self) -> np.ndarray:
        """Momentum that the machine takes from the ground where each piece but the first begins: array [pieces - 1].

        It does where it strikes a wall on the ground (`Machine.strikes_ground`), at one instant.
        """
        struck = self.event_times[np.isin(self.event_kinds, self.system.machine.strikes_ground)]
        later = np.searchsorted(self.piece_start, struck)  # at the end of a run the piece may begin a rounding later
        later = np.unique(later[(later > 0) & (later < len(self.piece_start))])
        blows = np.zeros(max(len(self.piece_start) - 1, 0))
        blows[later - 1] = self._gained("momentum", later)
        return blows

    def piece_integrals(self, index: np.ndarray, s: np.ndarray, names: tuple[str, ...] | None = None) -> np.ndarray:
        """Integrals over the first s of each of the pieces, or those of observables: array [integrals, *s.shape]."""
        (nodes, weights), names = gauss(GAUSS_NODES), names or self.integral_names
        integrals = np.empty((len(names), *s.shape))
        for first in range(0, len(s), PIECES_AT_A_TIME):
            block = slice(first, first + PIECES_AT_A_TIME)
            half = 0.5 * s[block, ..., None]
            points = (half * (1.0 + nodes)).reshape(len(half), -1)
            powers = self.piece_observables(names, index[block], points).reshape(len(names), *half.shape[:-1], -1)
            integrals[:, block] = (powers @ weights) * half[..., 0]
        return integrals

    def values(self, t: Moments) -> Annotated[np.ndarray, AlongNames(0, ("state_names", "integral_names"))]:
        """States and integrals at times t: array [states + integrals, len(t)]."""
        return np.concatenate((self.states(t), self.integrals(t)))

    def at(self, t: Moments, name: str) -> NamedArray:
        """A named quantity at times t."""
        _, index, s = self._located(t)
        return self.piece_values(name, index, s)

    def piece_values(self, name: str, index: np.ndarray, s: np.ndarray) -> np.ndarray:
        """A named quantity at times s since the start of the pieces: array [*s.shape]."""
        if name in self.side_names:
            return np.broadcast_to(along(self.side_of(name)[index], s), s.shape)
        if name in self.state_names:
            return self.piece_states(index, s)[self.state_names.index(name)]
        if name in self.integral_names:
            row = self.integral_names.index(name)
            return along(self.piece_marks[row, index], s) + self.piece_integrals(index, s, (name,))[0]
        if name in self.observable_names:
            return self.piece_observables((name,), index, s)[0]
        raise KeyError(f"{name!r} is not known of this motion; it has {', '.join(self.names)}")

    def crossings(
        self, name: str, value: NamedValue, direction: int | None = None, modulo: NamedValue | None = None
    ) -> Times:
        """Times at which a quantity passes a value, exact as the motion is: array [n], in order.

        name: anything that `motion.at` knows
        direction: 1 upwards only, -1 downwards only, None both
        modulo: value + k modulo counts for every whole k, as an angle that goes round passes at each turn
        A value that is touched without being passed is no crossing; one that is kept for a while, as velocity 0 at
        rest, is passed where it is left for the other side. A jump over the value, as of a velocity in an impact,
        passes it.
        """
        from vibrocap.motion.crossings import crossings

        return crossings(self, name, value, direction, modulo)

    def __getitem__(self, name: str) -> NamedArray:
        return self.at(self.time, name)

    @functools.cached_property
    def phases(self) -> Rows[Phase]:
        """Stretches of sticking and sliding, in order; `phases.table()` and `phases.to_pandas()` as for the events."""
        return self.phases_of(1)

    def phases_of(self, contact: int) -> Rows[Phase]:
        """The same of a further contact, 2 for the second."""
        sides = self.piece_sides[:, contact - 1]
        if not len(self.piece_start):
            return Rows()
        sides = sides[: len(sides) - (len(sides) > 1 and self.piece_length[-1] == 0.0)]  # that of an event at the end
        starts = np.flatnonzero(np.concatenate(([True], sides[1:] != sides[:-1])))
        times = np.concatenate((self.piece_start[starts], [self.end]))
        return Rows(Phase(float(times[i]), float(times[i + 1]), int(sides[start])) for i, start in enumerate(starts))


def along(values: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Values [n] of pieces in a shape that goes with times s in them, [n] or [n, points]."""
    return values.reshape(-1, *[1] * (s.ndim - 1))
