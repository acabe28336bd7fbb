"""The memory of a run: what each lane carries from step to step, and the trace on which a motion is recorded.

A kernel gets three flat arrays, since every further one costs at each call: `floats` and `ints` hold the lanes, item i
of an entry at `ENTRY + i * LANES + lane`; `trace` what is recorded, or the runs of an ensemble with their results. The
places are constants of the linked kernel.
"""

import dataclasses
import functools
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.numerics.expressions.structure import Traits
from vibrocap.numerics.kernel.codes import MODE_PLACES
from vibrocap.numerics.kernel.lane import (
    FLOAT_ENTRIES,
    INT_ENTRIES,
    NOT_OF_STEPPER,
    OF_RETURNS,
    OF_STEPPER,
    PER_CONTACT,
)

if TYPE_CHECKING:
    from vibrocap.numerics.codegen.source import Integrands

# A piece on the trace: period, time, length, method, then the states at its start, then row by row the other
# coefficients of its series, but for states whose rate is another state (`Layout.rates`), then the sides.
PIECE_HEAD = 4
# The first numbers of a result of a run on the trace; its window ends with the run.
RESULT_HEAD = (
    *("status", "periods", "time"),  # periods completed, time since the start of the one in which the run ended
    *("response_period", "since", "remaining", "window_start"),
    *("taylor_steps", "implicit_steps", "contact_residual"),
    *("refused_trials", "extrapolated"),  # periods from limits that were refused; 1: the window began at such a limit
)
RESULT_HEAD_SIZE = len(RESULT_HEAD)
EVENT_HEAD = 3  # an event on the trace: period, time, kind, then states, then the number of the contact
WHOLES = frozenset(INT_ENTRIES)
OWN_CONSTANTS = (  # of a layout that a kernel knows by their names
    *("lanes", "states", "order", "piece_size", "event_size", "switches", "shifts", "contacts", "parameters"),
    *("present", "coefficients", "run_size", "result_size", "waiting"),
)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Layout(Traits):
    """Where everything stands in the arrays of one kernel: follows from what a system has and what is kept of it."""

    lanes: int = 1
    order: int
    marks: int = 0
    gathered: tuple[tuple[str, int], ...] = ()  # see `gathered_entries`
    counts: int = 0  # events that a stepper counts apart; 0: it is none
    waiting: int = 0  # events of a stepper that may be later than its clock
    observed: int = 0  # observables that a stepper or a page shows
    part: int = 0  # numbers of a part of the table of its drive
    table: int = 0  # of all of it, of a stepper
    extrapolates: bool = False  # whether runs can go on from extrapolated limits of their marks

    @property
    def measured(self) -> int:
        """Numbers gathered over the window of a run."""
        return sum(size for _, size in self.gathered)

    @property
    def watched(self) -> int:
        """True loads that are looked at, of those that are held constant."""
        return dict(self.gathered).get("LIFTED", 0)

    @property
    def returns(self) -> bool:
        """Whether returns tell that a motion has settled."""
        return ("RETURNS", 1) in self.gathered

    @property
    def pair(self) -> bool:
        """Whether the slow manifolds of a motion alone are two of one contact, which may be slaved together."""
        return self.lanes == self.contacts == 1 and len(self.slow) == 2

    @property
    def start_place(self) -> int:
        """Where the states at the start of the window stand in a result; those at its end follow."""
        return len(RESULT_HEAD)

    def gathered_slice(self, name: str) -> slice:
        """Where an entry of what is gathered stands in a result."""
        first = self.start_place + 2 * self.states
        for entry, size in self.gathered:
            if entry == name:
                return slice(first, first + size)
            first += size
        raise KeyError(name)

    @functools.cached_property
    def sizes(self) -> dict[str, int]:
        """Items per entry that does not have one."""
        sizes = self._own_sizes()
        if self.extrapolates:
            before = FLOAT_ENTRIES[: FLOAT_ENTRIES.index("KEPT")]
            sizes["KEPT"] = sum(sizes.get(name, 1) for name in (*INT_ENTRIES, *before))
        return sizes

    def _own_sizes(self) -> dict[str, int]:
        """All but the size of KEPT, which follows from the others."""
        return {
            "STATE": self.states,
            "PARAMETER": -(-self.parameters // 8) * 8,  # in eights: systems of one page have their places in common
            "SCALE": self.states,
            "INVERSE_SCALE": self.states,
            "START_STATE": self.states,
            "MEASURED": self.measured,
            "UNTIL": 1 if self.coefficients else 0,
            **dict.fromkeys(("SLOW", "SWEEPS", "WAIT", "PAUSE", "OWN_DECAY", "DRIFT", "KICK"), len(self.slow)),
            "GUESS": len(self.slow) * (self.order + 1),
            "STEADY": self.states if self.extrapolates else 0,
            "KEPT": 0,
            "MARKS": self.marks * (self.states + self.turns),
            **dict.fromkeys(OF_RETURNS, int(self.returns)),
            "RETURN_TIMES": self.marks if self.returns else 0,
            "RETURN_MARKS": self.marks * (self.states + self.turns) if self.returns else 0,
            "SERIES": self.series_rows * (self.order + 1),
            **dict.fromkeys(PER_CONTACT, self.contacts),
            **(dict.fromkeys(NOT_OF_STEPPER, 0) if self.counts else dict.fromkeys(OF_STEPPER, 0)),
            "COUNTED": self.counts,
            "WAITING_KIND": self.waiting,
            "WAITING_CONTACT": self.waiting,
            "WAITING_TIME": self.waiting,
            "SHOWN_SIDE": self.contacts if self.counts else 0,
            "INPUT": self.coefficients if self.counts else 0,
            "PIECE_SEGMENT": self.coefficients + 2 if self.counts and self.coefficients else 0,
        }

    @property
    def series_rows(self) -> int:
        """States; a row of the event search; guards; contacts; true loads that are watched."""
        return self.states + 1 + self.switches + self.imposed + self.shifts + 2 * self.held + self.watched

    @property
    def present(self) -> int:
        """Number of the first parameter that belongs to the present segment of the drive: the drive's period.

        After it follow the start of the segment and its coefficients, see `kernel/events/corners.py`.
        """
        return self.parameters - self.coefficients - 2

    @property
    def event_work_size(self) -> int:
        """Work space of the event search; or that of a point and of functions, or of a part of a table, there.

        The search keeps its polynomial and 38 intervals at most: one is halved 37 times until it is too narrow.
        """
        gathering = self.states + 8 * (self.measured + 8)
        deciding = self.states + self.contacts * (4 * self.contacts + 24) if self.contacts > 1 else 0
        points = self.states + max(5 * self.switches, 10 * self.contacts)
        tangents = self.states + 3 * self.contacts + self.switches
        settling = 9 * (self.states + self.turns) + 30 if self.marks > 1 else 0
        search = self.order + 1 + 38 * (self.order + 2)
        shown = self.states + max(self.observed, self.part)
        return max(search, points, tangents, settling, gathering, deciding, shown)

    @property
    def work_size(self) -> int:
        """Work space of the event search, then of the implicit step: Jacobian, matrix, stages, velocities."""
        if not self.stiff:
            return self.event_work_size
        square = self.states * self.states
        implicit = self.states * (self.states + 1) + square + max(10 * self.states, square)
        implicit += 1 + 3 * self.shifts
        return self.event_work_size + implicit

    @functools.cached_property
    def piece_size(self) -> int:
        """Numbers per piece on the trace."""
        return PIECE_HEAD + self.states + len(self.whole_rows) * self.order + self.contacts

    @functools.cached_property
    def whole_rows(self) -> tuple[int, ...]:
        """Rows of which a piece on the trace has all coefficients."""
        return tuple(row for row in range(self.states) if not self.rates or self.rates[row] < 0)

    @property
    def event_size(self) -> int:
        """Numbers per event on the trace."""
        return EVENT_HEAD + self.states + 1

    @property
    def run_size(self) -> int:
        """Numbers per run of an ensemble on the trace: state, parameters, scales, time, period, delay."""
        return 2 * self.states + self.parameters + 3

    @functools.cached_property
    def result_size(self) -> int:
        """Numbers per result of a run on the trace: RESULT_HEAD, states at the window's start and end, measured."""
        return len(RESULT_HEAD) + 2 * self.states + self.measured

    @functools.cached_property
    def real_size(self) -> int:
        """Numbers in `floats`."""
        return self.places["WORK"] + self.work_size

    @functools.cached_property
    def whole_size(self) -> int:
        """Numbers in `ints`."""
        return sum(self.sizes.get(name, 1) for name in INT_ENTRIES) * self.lanes

    @functools.cached_property
    def places(self) -> dict[str, int]:
        """Offset of each entry of `ints` and of `floats`."""
        places, place = {}, 0
        for name in INT_ENTRIES:
            places[name] = place
            place += self.sizes.get(name, 1) * self.lanes
        place = 0
        for name in FLOAT_ENTRIES:
            places[name] = place
            place += self.sizes.get(name, 1) * self.lanes
        place = places["MEASURED"]
        for name, size in self.gathered:
            places[name] = place
            place += size * self.lanes
        return places

    @property
    def shown(self) -> int:
        """Numbers that a stepper shows at the start of its trace: states, observables. Then follow table and backup."""
        return self.states + self.observed

    @property
    def stepper_trace_size(self) -> int:
        """Numbers on the trace of a stepper: what it shows, the table of its drive, a backup of what it carries."""
        return self.shown + self.table + self.places["SERIES"] + self.whole_size

    def put(self, floats: np.ndarray, ints: np.ndarray, entries: Mapping[str, Any]) -> None:
        """Put a number into an entry of every lane, or several numbers into that of the one lane that there is."""
        places, alone = self.places, self.lanes == 1
        for name, value in entries.items():
            array, place = ints if name in WHOLES else floats, places[name]
            if hasattr(value, "__len__"):
                array[place : place + len(value)] = value
            elif alone:
                array[place] = value
            else:
                array[place : place + self.lanes] = value

    def allocated(self) -> tuple[np.ndarray, np.ndarray]:
        """(floats, ints) with everything zero."""
        return _aligned_zeros(self.real_size, np.float64), _aligned_zeros(self.whole_size, np.int64)

    def constants(self) -> dict[str, int]:
        """All places and sizes, for the linked kernel."""
        return {
            **{name.upper(): getattr(self, name) for name in OWN_CONSTANTS},
            "EVENT_WORK": self.event_work_size,
            "MARK_COUNT": self.marks,
            "MARK_SIZE": self.states + self.turns,
            "MEASURED_COUNT": self.measured,
            "SHOWN": 0,
            "BACKUP": self.shown + self.table,
            "INT_COUNT": self.whole_size,
            **self.places,
        }


def _aligned_zeros(size: int, kind: type) -> np.ndarray:
    """Zeros that begin a cache line: a vector of eight numbers is then read from one line, not from two."""
    room = np.zeros(size + 7, dtype=kind)
    first = -room.__array_interface__["data"][0] % 64 // 8
    return room[first : first + size]


def gathered_entries(
    has: Traits, integrands: "Integrands", machine_switches: int = 0, watched: int = 0, returns: bool = False
) -> tuple[tuple[str, int], ...]:
    """Names and sizes of what is gathered over the window of a run; the names are constants of the linked kernel.

    machine_switches: guards of the machine; watched: true loads that are looked at, of those that are held constant
    returns: whether these tell that a motion has settled
    """
    states, contacts = has.states, has.contacts
    return (
        ("INTEGRAL", integrands.summed),
        ("MAGNITUDE", contacts),  # integral of |R|
        ("PEAK", contacts + integrands.own_extremes),  # largest |R| of each contact, then own ones
        ("LARGEST", states),
        ("LEAST", states),
        ("STICK_TIME", contacts),
        ("STICK_PHASES", contacts),
        ("PHASE_SIDE", contacts),  # of the present phase of the window
        ("PHASE_LENGTH", contacts),
        ("LETTER_SIDE", contacts),  # of the present phase of the last period
        ("LETTER_LENGTH", contacts),
        ("LETTER_COUNT", contacts),
        ("LETTERS", contacts * MODE_PLACES),
        ("ASYMMETRY", 1),
        ("DEFECT", 1),  # evidence, see `observe/evidence.py`
        ("STICKING_SHARE", 1),
        ("LEAST_VELOCITY", 1),
        *((("OCCURRED", machine_switches),) if machine_switches else ()),  # how often each of them fell to zero
        *((("LIFTED", watched),) if watched else ()),  # 1 once a true load has been below zero
        # returns of the whole run; length of the window of a cycle, 0: of none; time from which on it was settled
        *((("RETURNS", 1), ("CYCLE_TIME", 1), ("SETTLED_TIME", 1)) if returns else ()),
    )
