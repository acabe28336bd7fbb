"""The memory of a run: what each lane carries from step to step, and the trace on which a motion is recorded.

A kernel gets three flat arrays, since every further one costs at each call: `floats` and `ints` hold the lanes, item i
of an entry at `ENTRY + i * LANES + lane`; `trace` what is recorded, or the runs of an ensemble with their results. The
places are constants of the linked kernel.
"""

import dataclasses
import functools

import numpy as np

from vibrocap.numerics.kernel.codes import MODE_PLACES

# Entries of `ints`, one number per lane each, or per contact of the lane.
INT_ENTRIES = (
    "STATUS",
    "PERIOD_COUNT",  # whole periods completed
    "WHOLE_PERIODS",  # periods to run
    "ARRIVING",  # [contacts] 1: it is at rest and not decided yet whether it sticks; 2: its series decide
    "ZEROS",  # [contacts] how many coefficients of the velocity are known to vanish at the start of the step
    "GAVE_WAY",  # [contacts] 1: it has given way at this instant, of several contacts
    "STIFF",  # 1: implicit steps
    "PATIENCE",  # steps until the choice of method is looked at again
    "TAYLOR_STEPS",  # accepted
    "IMPLICIT_STEPS",  # accepted
    "EVENTS",  # in this period
    "EVENT_LIMIT",  # most events allowed in a period
    "IDLE",  # decisions in a row that did not advance time
    "PENDING",  # 1: the tangent has left a piece and not begun the next one
    "PIECES",  # written to the trace
    "PIECE_LIMIT",
    "RECORDED_EVENTS",  # written to the trace
    "RECORDED_EVENT_LIMIT",
    "PIECE_START",  # place of the first piece on the trace
    "RECORDED_EVENT_START",  # place of the first event on the trace
    # of an ensemble only
    "RUN",  # which run of the trace the lane is on; -1: none
    "STEP_LIMIT",
    "WINDOW",  # periods over which is measured where nothing settles
    "WINDOW_START",  # period at which measuring began; -1: not yet
    "RESPONSE",  # drive periods after which the settled motion repeats; 0: not settled
    "SINCE",  # period from which on it was settled
    "PERIOD_BUDGET",  # periods to run where nothing settles (of lane 0, for all lanes, like all below)
    "EVIDENCE_PERIODS",  # last periods of which evidence is taken where nothing settles; 0: none is taken at all
    "ASKED",  # groups of measures to gather, a sum of the powers of two in `window.py`
    "RESULT_START",  # place of the first result on the trace
    "NEXT_RUN",  # first run of the trace that no lane has begun
    "LAST_RUN",  # end of the runs to begin
    "MORE",  # 1: come back for more runs as soon as a lane is free
    # of drives with corners only
    "SEGMENT",  # present one of the drive
    "CYCLE",  # whole periods of the drive since the period of the run began
    "TABLE",  # place of the run's table of segments on the trace
    "SEGMENT_COUNT",  # of a table (of lane 0, for all lanes, like all below)
    "TABLE_START",  # place of the first table on the trace
    "TABLE_STRIDE",  # from the table of a run to that of the next; 0: one serves all runs
    # of a stepper only
    "BEGUN",  # 1: the motion has begun
    "ENDED",  # status with which the motion has ended; RUNNING: it has not
    "STOPPING",  # 1: it is to stop at the first event
    "STOPPED",  # 1: it has
    "NOTICED",  # events, but for grazes, at the instant at which the next step begins
    "STEPS_PER_CALL",  # most of them
    "NEW_INPUT",  # 1: an input has been set, which the next step takes
    "PIECE_STIFF",  # STIFF of the step within which the clock stands
    "LAST_KIND",  # of event
    "LAST_CONTACT",  # 1 for the first, 0: of none
    "COUNTED",  # [counts] how often events occurred, see `stepper/event_counts.py`
    "WAITING_EVENTS",  # later than the clock
    "WAITING_KIND",  # [waiting] of these
    "WAITING_CONTACT",  # [waiting]
)
# Entries of `floats`, one number per lane each unless sized in `Layout`.
FLOAT_ENTRIES = (
    "TIME",  # since the start of the period
    "PERIOD",  # length of a period
    "HOLD_RATE",  # by which the last term of a holding force follows from the last but two, see `taylor.taylor_step`
    "TAIL",  # time to run after the whole periods
    "SIDE",  # [contacts] +1, -1 sliding; 0 stuck
    "CAME_FROM",  # [contacts] side before it came to rest
    "SIDE_TOLD",  # [contacts] side in the last piece that was recorded
    "TOLERANCE",  # error per step over the natural size of a state
    "IMPLICIT_STEP",  # step that the implicit method proposes
    "EXPLICIT_STEP",  # last step of the Taylor method before the implicit method took over
    "DECAY_RATE",  # of the fastest decay at the start of the step, about; of laws that cannot stick
    "DAMPED_STEP",  # step for which the series has been damped by the step of all lanes; 0: it has not
    "SAFE_SPEED",  # up to which a series is known to see all that the law holds, see `resolved.py`
    "UNSAFE_SPEED",  # for which this has been asked, and is not so
    "FAR_SPEED",  # from which on the law holds nothing that a step could notice
    "NEAR_SPEED",  # for which this has been asked, and is not so
    "CONTACT_RESIDUAL",  # largest |contact velocity| at a located event
    "STATE",  # [rows] states and integrals
    "PARAMETER",  # [parameters]
    "SCALE",  # [states] natural size of each state
    # of an ensemble only
    "STEP",  # length of the present step
    "EVENT_CONTACT",  # number of the contact of the event with which the step ends
    "DELAY",  # by which the event comes later, per unit of the tangent
    "INVERSE_SCALE",  # [states] one over SCALE
    "THRESHOLD",  # of settling; 0: the run goes on to its end
    "REMAINING",  # bound of the distance still to go, when the motion was found settled
    "START_STATE",  # [states] at the start of the window
    "MEASURED",  # [measured] what is gathered over the window
    "SLOW",  # [contacts] 1: its bristles are on their slow manifold, see `step/slow_manifold.py`
    "SWEEPS",  # [contacts] series since then, of which none was accepted
    "WAIT",  # [contacts] steps until it is tried again
    "PAUSE",  # [contacts] how long it waits after the next failure
    "OWN_DECAY",  # [contacts] rate of decay of its bristles
    "GUESS",  # [contacts * (order + 1)] series of its bristles of the sweep before
    "UNTIL",  # end of the present segment of a drive with corners; of any other, PERIOD stands for it
    # of a stepper only
    "CLOCK",  # time since the motion began
    "CLOCK_REST",  # what rounding leaves of it
    "LENGTH",  # by which the motion is to go on
    "INPUT",  # [coefficients] value, slope and curvature of an input that was set
    "PIECE_CLOCK",  # start of the step within which the clock stands
    "PIECE_TIME",  # the same as TIME
    "PIECE_LENGTH",
    "PIECE_SEGMENT",  # [coefficients + 2] numbers of the drive's segment in that step
    "SHOWN_SIDE",  # [contacts] side at the clock
    "LAST_TIME",  # of the last event
    "WAITING_TIME",  # [waiting] of events that are later than the clock
    "MARKS",  # [marks * (states + turns)] stroboscopic states over their natural size, mark k at k modulo `marks`
    "SERIES",  # [series rows * (order + 1)] coefficients of the present step, see `Layout.series_rows`
    "WORK",  # [work size, once for all lanes] of the event search and the implicit step
)
# A piece on the trace: period, time, length, side, method, then the states at its start, then row by row the other
# coefficients of its series, but for states whose rate is another state (`Layout.rates`), then further sides.
PIECE_HEAD = 5
OF_STEPPER = (
    *("BEGUN", "ENDED", "STOPPING", "STOPPED", "NOTICED", "STEPS_PER_CALL", "NEW_INPUT", "PIECE_STIFF", "LAST_KIND"),
    *("LAST_CONTACT", "WAITING_EVENTS", "CLOCK", "CLOCK_REST", "LENGTH", "PIECE_CLOCK", "PIECE_TIME", "PIECE_LENGTH"),
    "LAST_TIME",
)
NOT_OF_STEPPER = (
    *("PENDING", "PIECES", "PIECE_LIMIT", "PIECE_START", "RECORDED_EVENTS", "RECORDED_EVENT_LIMIT"),
    *("RECORDED_EVENT_START", "RUN", "WINDOW", "WINDOW_START", "RESPONSE", "SINCE", "PERIOD_BUDGET"),
    *("EVIDENCE_PERIODS", "ASKED", "RESULT_START", "NEXT_RUN", "LAST_RUN", "MORE", "EVENT_CONTACT", "DELAY"),
    *("INVERSE_SCALE", "THRESHOLD", "REMAINING", "START_STATE"),
)
PER_CONTACT = ("ARRIVING", "ZEROS", "GAVE_WAY", "SIDE", "CAME_FROM", "SIDE_TOLD")
# The first numbers of a result of a run on the trace; its window ends with the run.
RESULT_HEAD = (
    *("status", "periods", "time"),  # periods completed, time since the start of the one in which the run ended
    *("response_period", "since", "remaining", "window_start"),
    *("taylor_steps", "implicit_steps", "contact_residual"),
)
RESULT_HEAD_SIZE = len(RESULT_HEAD)
EVENT_HEAD = 3  # an event on the trace: period, time, kind, then states and integrals, then the number of the contact


def gathered_entries(
    states: int, integrals: int, own_extremes: int, machine_switches: int = 0, watched: bool = False
) -> tuple[tuple[str, int], ...]:
    """Names and sizes of what is gathered over the window of a run; the names are constants of the linked kernel.

    integrals: all that are summed, own ones included; own_extremes: functions of which the largest value is kept
    machine_switches: guards of the machine; watched: whether the true load is looked at, of one that is held constant
    """
    return (
        ("INTEGRAL", integrals),
        ("MAGNITUDE", 1),  # integral of |R|
        ("PEAK", 1 + own_extremes),  # largest |R|, then own ones
        ("LARGEST", states),
        ("LEAST", states),
        ("STICK_TIME", 1),
        ("STICK_PHASES", 1),
        ("PHASE_SIDE", 1),  # of the present phase of the window
        ("PHASE_LENGTH", 1),
        ("LETTER_SIDE", 1),  # of the present phase of the last period
        ("LETTER_LENGTH", 1),
        ("LETTER_COUNT", 1),
        ("LETTERS", MODE_PLACES),
        ("ASYMMETRY", 1),
        ("DEFECT", 1),  # evidence, see `observe/evidence.py`
        ("HOLD_SHARE", 1),
        ("LEAST_VELOCITY", 1),
        *((("OCCURRED", machine_switches),) if machine_switches else ()),  # how often each of them fell to zero
        *((("LIFTED", 1),) if watched else ()),  # 1 once the true load has been below zero
    )


@dataclasses.dataclass(frozen=True)
class Layout:
    """Where everything stands in the arrays of one kernel."""

    lanes: int
    states: int
    rows: int
    order: int
    parameters: int
    marks: int = 0
    gathered: tuple[tuple[str, int], ...] = ()  # see `gathered_entries`
    switches: int = 0  # guards of the branches of law and machine, and bounds
    coefficients: int = 0  # per segment of a drive with corners; 0: it has none
    imposed: int = 0  # velocities of further contacts that are no states
    shifts: int = 0  # of these and of the first contact, where one may be stiff: how far each is ahead of a state
    contacts: int = 1
    held: int = 0  # further contacts that can rest, each with two rows: the force that holds it, and its limit
    turns: int = 0  # coordinates that turn, of which a mark keeps a second number
    counts: int = 0  # events that a stepper counts apart; 0: it is none
    waiting: int = 0  # events of a stepper that may be later than its clock
    implicit: bool = True  # whether there are implicit steps, which need work space
    observed: int = 0  # observables that a stepper or a page shows
    table: int = 0  # numbers of the table of its drive
    rates: tuple[int, ...] = ()  # of each row the one that is its rate, whose series tells its own, else -1; (): none
    slow: tuple[int, ...] = ()  # of each contact the state that may be on a slow manifold, else -1; (): none is

    @property
    def measured(self) -> int:
        """Numbers gathered over the window of a run."""
        return sum(size for _, size in self.gathered)

    @property
    def watched(self) -> bool:
        """Whether the true load is looked at, of one that is held constant."""
        return ("LIFTED", 1) in self.gathered

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
        """Items per entry of `floats` that have more than one."""
        return {
            "STATE": self.rows,
            "PARAMETER": self.parameters,
            "SCALE": self.states,
            "INVERSE_SCALE": self.states,
            "START_STATE": self.states,
            "MEASURED": self.measured,
            "UNTIL": 1 if self.coefficients else 0,
            **dict.fromkeys(("SLOW", "SWEEPS", "WAIT", "PAUSE", "OWN_DECAY"), len(self.slow)),
            "GUESS": len(self.slow) * (self.order + 1),
            "MARKS": self.marks * (self.states + self.turns),
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
        """States and integrals; velocity, force and limit of the first contact and a guard; guards; what is known of
        further contacts; the true load where it is watched."""
        return self.rows + 4 + self.switches + self.imposed + self.shifts + 2 * self.held + self.watched

    @property
    def present(self) -> int:
        """Number of the first parameter that belongs to the present segment of the drive: the drive's period.

        After it follow the start of the segment and its coefficients, see `kernel/events/corners.py`.
        """
        return self.parameters - self.coefficients - 2

    @property
    def event_work_size(self) -> int:
        """Work space of the event search; or that of a point and of functions at points, or of a drive's table.

        The search keeps its polynomial and 38 intervals at most: one is halved 37 times until it is too narrow.
        """
        gathering = self.states + 8 * (self.measured + 8)
        deciding = self.states + self.contacts * (4 * self.contacts + 24) if self.contacts > 1 else 0
        points = self.states + max(5 * self.switches, 10 * self.contacts)
        tangents = self.states + 3 * self.contacts + self.switches
        search = self.order + 1 + 38 * (self.order + 2)
        shown = self.states + max(self.observed, self.table)
        return max(search, points, tangents, gathering, deciding, shown)

    @property
    def work_size(self) -> int:
        """Work space of the event search, then of the implicit step: Jacobian, matrix, stages, velocities."""
        if not self.implicit:
            return self.event_work_size
        square = self.states * self.states
        implicit = self.rows * (self.states + 1) + square + max(10 * self.rows, square)
        implicit += 1 + 3 * self.shifts
        return self.event_work_size + implicit

    @functools.cached_property
    def piece_size(self) -> int:
        """Numbers per piece on the trace."""
        return PIECE_HEAD + self.rows + len(self.whole_rows) * self.order + self.contacts - 1

    @functools.cached_property
    def whole_rows(self) -> tuple[int, ...]:
        """Rows of which a piece on the trace has all coefficients."""
        return tuple(row for row in range(self.rows) if not self.rates or self.rates[row] < 0)

    @property
    def event_size(self) -> int:
        """Numbers per event on the trace."""
        return EVENT_HEAD + self.rows + 1

    @property
    def run_size(self) -> int:
        """Numbers per run of an ensemble on the trace: state, parameters, scales, time, period, sides."""
        return 2 * self.states + self.parameters + 2 + self.contacts

    @property
    def result_size(self) -> int:
        """Numbers per result of a run on the trace: RESULT_HEAD, states at the window's start and end, measured."""
        return len(RESULT_HEAD) + 2 * self.states + self.measured

    @property
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
        found, place = {}, 0
        for name in INT_ENTRIES:
            found[name] = place
            place += self.sizes.get(name, 1) * self.lanes
        place = 0
        for name in FLOAT_ENTRIES:
            found[name] = place
            place += self.sizes.get(name, 1) * self.lanes
        place = found["MEASURED"]
        for name, size in self.gathered:
            found[name] = place
            place += size * self.lanes
        return found

    @property
    def shown(self) -> int:
        """Numbers that a stepper shows at the start of its trace: states, observables. Then follow table and backup."""
        return self.states + self.observed

    @property
    def stepper_trace_size(self) -> int:
        """Numbers on the trace of a stepper: what it shows, the table of its drive, a backup of what it carries."""
        return self.shown + self.table + self.places["SERIES"] + self.whole_size

    def allocated(self) -> tuple[np.ndarray, np.ndarray]:
        """(floats, ints) with everything zero."""
        return _aligned_zeros(self.real_size, np.float64), _aligned_zeros(self.whole_size, np.int64)

    def constants(self) -> dict[str, int]:
        """All places and sizes, for the linked kernel."""
        return {
            "LANES": self.lanes,
            "STATES": self.states,
            "ROWS": self.rows,
            "ORDER": self.order,
            "PIECE_SIZE": self.piece_size,
            "EVENT_SIZE": self.event_size,
            "EVENT_WORK": self.event_work_size,
            "SWITCHES": self.switches,
            "SHIFTS": self.shifts,
            "CONTACTS": self.contacts,
            "PARAMETERS": self.parameters,
            "PRESENT": self.present,
            "COEFFICIENTS": self.coefficients,
            "MARK_COUNT": self.marks,
            "MARK_SIZE": self.states + self.turns,
            "MEASURED_COUNT": self.measured,
            "RUN_SIZE": self.run_size,
            "RESULT_SIZE": self.result_size,
            "SHOWN": 0,
            "BACKUP": self.shown + self.table,
            "WAITING": self.waiting,
            "INT_COUNT": self.whole_size,
            **self.places,
        }


def _aligned_zeros(size: int, kind: type) -> np.ndarray:
    """Zeros that begin a cache line: a vector of eight numbers is then read from one line, not from two."""
    room = np.zeros(size + 7, dtype=kind)
    first = -room.__array_interface__["data"][0] % 64 // 8
    return room[first : first + size]
