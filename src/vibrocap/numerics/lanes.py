"""The memory of a run: what each lane carries from step to step, and the tape on which a motion is recorded.

A kernel gets three flat arrays, since every further one costs at each call: `real` and `whole` hold the lanes, item i
of an entry at `ENTRY + i * LANES + lane`; `tape` holds what is recorded. The places are constants of the linked kernel.
"""

import dataclasses
import functools

import numpy as np

# What a lane is doing, or why it stopped.
RUNNING = 0
DONE = 1
TAPE_FULL = 2
STEP_UNDERFLOW = 3
NOT_FINITE = 4
TOO_MANY_EVENTS = 5
UNDECIDED = 6

# Kinds of event.
STICK = 0
SLIP_FORWARD = 1
SLIP_BACK = 2
REVERSAL = 3
GRAZE = 4

# Entries of `whole`, one number per lane each.
WHOLE = (
    "STATUS",
    "PERIOD_COUNT",  # whole periods completed
    "WHOLE_PERIODS",  # periods to run
    "ARRIVING",  # 1: the contact is at rest and it is not decided yet whether it sticks
    "ZEROS",  # how many coefficients of the contact velocity are known to vanish at the start of the step
    "STIFF",  # 1: implicit steps
    "PATIENCE",  # steps until the choice of method is looked at again
    "TAYLOR_STEPS",  # accepted
    "IMPLICIT_STEPS",  # accepted
    "EVENTS",  # in this period
    "EVENT_LIMIT",  # most events allowed in a period
    "IDLE",  # decisions in a row that did not advance time
    "PIECES",  # written to the tape
    "PIECE_LIMIT",
    "RECORDED_EVENTS",  # written to the tape
    "RECORDED_EVENT_LIMIT",
    "PIECE_START",  # place of the first piece on the tape
    "RECORDED_EVENT_START",  # place of the first event on the tape
)
# Entries of `real`, one number per lane each unless sized in `Layout`.
REAL = (
    "TIME",  # since the start of the period
    "PERIOD",  # length of a period
    "TAIL",  # time to run after the whole periods
    "SIDE",  # +1, -1 sliding; 0 stuck
    "CAME_FROM",  # side before the contact came to rest
    "TOLERANCE",  # error per step over the natural size of a state
    "IMPLICIT_STEP",  # step that the implicit method proposes
    "EXPLICIT_STEP",  # last step of the Taylor method before the implicit method took over
    "VISIBLE_SPEED",  # speed up to which a series notices that friction changes near rest
    "CONTACT_RESIDUAL",  # largest |contact velocity| at a located event
    "STATE",  # [rows] states and integrals
    "PARAMETER",  # [parameters]
    "SCALE",  # [states] natural size of each state
    "SERIES",  # [(rows + 4) * (order + 1)] coefficients of the present step
    "WORK",  # [work size, once for all lanes] of the event search and the implicit step
)
PIECE_HEAD = 5  # a piece on the tape: period, time, length, side, method, then the coefficients of its series
EVENT_HEAD = 3  # an event on the tape: kind, period, time, then states and integrals


@dataclasses.dataclass(frozen=True)
class Layout:
    """Where everything stands in the arrays of one kernel."""

    lanes: int
    states: int
    rows: int
    order: int
    parameters: int

    @property
    def sizes(self) -> dict[str, int]:
        """Items per entry of `real` that have more than one."""
        return {
            "STATE": self.rows,
            "PARAMETER": self.parameters,
            "SCALE": self.states,
            "SERIES": (self.rows + 4) * (self.order + 1),
        }

    @property
    def event_work_size(self) -> int:
        """Work space of the event search: 38 intervals at most."""
        return 40 * (self.order + 3)

    @property
    def work_size(self) -> int:
        """Work space of the event search, then that of the implicit step (Jacobian, matrix, stages)."""
        implicit = self.rows * (self.states + 1) + self.states * self.states + 10 * self.rows
        return self.event_work_size + implicit

    @property
    def piece_size(self) -> int:
        """Numbers per piece on the tape."""
        return PIECE_HEAD + self.rows * (self.order + 1)

    @property
    def event_size(self) -> int:
        """Numbers per event on the tape."""
        return EVENT_HEAD + self.rows

    @functools.cached_property
    def places(self) -> dict[str, int]:
        """Offset of each entry of `whole` and of `real`."""
        found = {name: i * self.lanes for i, name in enumerate(WHOLE)}
        place = 0
        for name in REAL:
            found[name] = place
            place += self.sizes.get(name, 1) * self.lanes
        return found

    def allocated(self) -> tuple[np.ndarray, np.ndarray]:
        """(real, whole) with everything zero."""
        return np.zeros(self.places["WORK"] + self.work_size), np.zeros(len(WHOLE) * self.lanes, dtype=np.int64)

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
            **self.places,
        }
