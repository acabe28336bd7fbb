"""Runs the kernel for one motion and returns its trace as arrays."""

import dataclasses
import functools
import math
import threading
from collections.abc import Callable

import numpy as np

from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.structure import traits
from vibrocap.numerics.kernel import codes
from vibrocap.numerics.kernel import memory_layout as memory
from vibrocap.numerics.kernel.memory_layout import Layout
from vibrocap.numerics.linker import Linked, kept_kernel, linked_source, motion_recipe, plain_kernel
from vibrocap.numerics.run.budget import COMPILED, Budget, Form, MotionStart, prepared_memory
from vibrocap.numerics.run.results import PieceSeries
from vibrocap.resources import check_kept, check_memory

ROUNDS = 50_000  # steps between two looks at the clock, the keyboard and the trace
EVENT_ROOM = 2_000
PIECE_ROOM = 20_000
LARGEST_TRACE = 2**21  # numbers of a trace that a thread keeps for its next motion

NO_TABLE = np.empty((0, 0))  # of a drive without corners
FEWEST_PIECES = 4  # per period, with which a motion that cannot be kept is known before it begins

Progress = Callable[[float], None]


@dataclasses.dataclass(frozen=True)
class Recorded:
    """What came back from the kernel. Times of pieces and events count from the start of their period."""

    status: int  # of `codes`
    pieces: np.ndarray  # [pieces, size] as `memory_layout.PIECE_HEAD` says
    rates: tuple[int, ...]  # of each state the state that is its rate, see `PieceSeries`
    events: np.ndarray  # [events, 4 + rows]: period, time, kind, states, number of the contact (0: of none)
    sections: np.ndarray  # [whole periods completed + 1, rows]
    final: np.ndarray  # [rows] where the run ended
    contact_residual: float
    taylor_steps: int
    implicit_steps: int
    contacts: int = 1

    @property
    def piece_instants(self) -> np.ndarray:
        """[pieces, 2] start: whole periods, and the time since the start of the period."""
        return self.pieces[:, :2]

    @property
    def piece_lengths(self) -> np.ndarray:
        """[pieces]"""
        return self.pieces[:, 2]

    @property
    def piece_sides(self) -> np.ndarray:
        """[pieces, contacts] +1, -1 sliding; 0 at rest."""
        return self.pieces[:, self.pieces.shape[1] - self.contacts :]

    @property
    def piece_implicit(self) -> np.ndarray:
        """[pieces] whether it is an implicit step."""
        return self.pieces[:, 3] == 1.0

    @property
    def series(self) -> PieceSeries:
        """[pieces, rows, order + 1] coefficients in powers of the time since the start of the piece."""
        numbers = self.pieces[:, memory.PIECE_HEAD : self.pieces.shape[1] - self.contacts]
        whole = sum(rate < 0 for rate in self.rates)
        return PieceSeries(numbers, self.rates, (numbers.shape[1] - len(self.rates)) // whole)

    @property
    def event_kinds(self) -> np.ndarray:
        """[events] numbers of `codes`."""
        return self.events[:, 2].astype(int)

    @property
    def event_states(self) -> np.ndarray:
        """[events, rows]"""
        return self.events[:, memory.EVENT_HEAD : -1]

    @property
    def event_contacts(self) -> np.ndarray:
        """[events] number of the contact, 1 for the first; 0: of none."""
        return self.events[:, -1].astype(int)

    @property
    def event_instants(self) -> np.ndarray:
        """[events, 2] whole periods, and the time since the start of the period."""
        return self.events[:, :2]


class Traces(threading.local):
    """The trace of each thread, lent to one motion after the other: to fill memory that is new takes as long as to run.

    A motion that begins while another one of the same thread runs, as in a function that is told of its progress, finds
    none and gets a new one. The list is emptied in one instruction, so that an interrupt cannot lend a trace twice.
    """

    def __init__(self):
        self._free: list[np.ndarray] = []

    def lend(self, size: int) -> np.ndarray:
        """A trace of at least so many numbers, whatever they are."""
        try:
            kept = self._free.pop()
        except IndexError:
            return np.empty(size)
        return kept if len(kept) >= size else np.empty(size)

    def give_back(self, trace: np.ndarray) -> None:
        """Keep a trace of which nothing is in use for the next motion, unless it is very large."""
        if len(trace) <= LARGEST_TRACE:
            self._free[:] = [trace]


TRACES = Traces()


def series_order(tolerance: float) -> int:
    """Order of the series: the cheapest of three, so that few kernels are ever compiled (benchmarks/orders.py).

    Coarser ones than 1e-5 keep the higher order: long steps of order 10 lose momentum at sharp exponential contacts.
    """
    if 1e-7 <= tolerance <= 1e-5:
        return 10
    return 12 if tolerance >= 1e-11 else 16


def motion_layout(equations: Equations, order: int) -> Layout:
    """The memory of one motion of these equations."""
    return Layout(**vars(traits(equations)), order=order)


def linked_motion(equations: Equations, order: int) -> tuple[Layout, Linked]:
    """(layout, text) of the kernel for one motion of these equations."""
    from vibrocap.numerics.codegen.source import generated_source  # only here: most kernels are on the disk

    layout = motion_layout(equations, order)
    return layout, linked_source(generated_source(equations, layout), motion_recipe(layout))


@functools.lru_cache(maxsize=64)
def kernel(equations: Equations, order: int, plain: bool = False, literal: bool = False) -> tuple[Layout, Callable]:
    """(layout, entry) of the kernel for one motion of these equations, compiled or as plain Python."""
    if plain:
        layout, text = linked_motion(equations, order)
        return layout, plain_kernel(text)["advance"]
    layout = motion_layout(equations, order)
    return layout, kept_kernel(lambda: linked_motion(equations, order)[1], equations, layout, literal=literal)


def recorded_run(
    start: MotionStart,
    budget: Budget,
    form: Form = COMPILED,
    keep_pieces: bool = True,
    progress: Progress | None = None,
) -> Recorded:
    """Run one motion to its end, or to where it could not go on."""
    periods, period = budget.periods, start.period
    order = form.order or series_order(budget.tolerance)
    layout, advance = kernel(start.equations, order, form.plain, form.literal)
    whole_trace = 8.0 * math.floor(start.phase + periods + 1e-12) * layout.states
    check_memory(whole_trace + keep_pieces * FEWEST_PIECES * periods * 8.0 * layout.piece_size)
    room = int(min(PIECE_ROOM, 250 * periods + 200)), EVENT_ROOM
    floats, ints, trace = motion_memory(start, layout, budget, room)
    in_place = False
    place, rows = layout.places, layout.states
    event_start, piece_start = int(ints[place["RECORDED_EVENT_START"]]), int(ints[place["PIECE_START"]])
    pieces, events = [], []
    status = codes.RUNNING
    while status == codes.RUNNING:
        advance(floats, ints, trace, ROUNDS)
        status = int(ints[place["STATUS"]])
        full = status == codes.TRACE_FULL
        if status != codes.RUNNING or not keep_pieces:
            if keep_pieces:
                count, size = int(ints[place["PIECES"]]), layout.piece_size
                in_place = not full and 2 * count > int(ints[place["PIECE_LIMIT"]])
                events.append(_rows(trace, event_start, ints[place["RECORDED_EVENTS"]], layout.event_size).copy())
                kept = _rows(trace, piece_start, count, size)
                pieces.append(kept if in_place else kept.copy())
            ints[place["PIECES"]] = ints[place["RECORDED_EVENTS"]] = 0
        if full:
            ints[place["STATUS"]] = status = codes.RUNNING
            share = (ints[place["PERIOD_COUNT"]] + floats[place["TIME"]] / period) / periods
            held = sum(part.nbytes for part in pieces) + sum(part.nbytes for part in events)
            if pieces and share > 0.0:  # to be joined in the end, which takes the same again
                check_memory(held * (2.0 / share - 1.0), held)  # a motion may begin with very many short steps
                check_kept(held, share, periods)
        if progress is not None:
            progress((ints[place["PERIOD_COUNT"]] + floats[place["TIME"]] / period - start.phase) / periods)
    completed = int(ints[place["PERIOD_COUNT"]])
    recorded = Recorded(
        status=status,
        pieces=_joined(pieces, layout.piece_size),
        rates=layout.rates,
        events=_joined(events, layout.event_size),
        sections=trace[: (completed + 1) * rows].reshape(-1, rows).copy(),
        final=floats[place["STATE"] : place["STATE"] + rows].copy(),
        contact_residual=float(floats[place["CONTACT_RESIDUAL"]]),
        taylor_steps=int(ints[place["TAYLOR_STEPS"]]),
        implicit_steps=int(ints[place["IMPLICIT_STEPS"]]),
        contacts=layout.contacts,
    )
    if not in_place:
        TRACES.give_back(trace)
    return recorded


def motion_memory(
    start: MotionStart, layout: Layout, budget: Budget, room: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(floats, ints, trace) of one motion that is about to begin; room: pieces and events that the trace holds."""
    corners, parameters = start.equations.corners, start.parameters
    marks = start.phase + budget.periods  # of the drive, at the end
    whole_periods = math.floor(marks + 1e-12)
    rest = marks - whole_periods
    table = NO_TABLE
    if corners is not None:
        (table,), (present,) = corners.of_one(tuple(parameters))
        parameters = [*parameters[: corners.place], present, *parameters[corners.place + 1 :]]
        start = dataclasses.replace(start, parameters=parameters)
    (pieces, events), rows = room, layout.states
    event_start = (whole_periods + 1) * rows
    table_start = event_start + events * layout.event_size
    piece_start = table_start + table.size  # the last, so that the trace can be cut
    trace = TRACES.lend(piece_start + pieces * layout.piece_size)
    trace[:rows] = start.initial
    trace[table_start:piece_start] = table.ravel()
    floats, ints = prepared_memory(
        layout,
        budget,
        STATUS=codes.BEGINNING,
        **start.entries,
        WHOLE_PERIODS=whole_periods,
        TAIL=rest * start.period if rest > 1e-12 else 0.0,
        TABLE_START=table_start,
        SEGMENT_COUNT=len(table),
        PIECE_START=piece_start,
        PIECE_LIMIT=pieces,
        RECORDED_EVENT_START=event_start,
        RECORDED_EVENT_LIMIT=events,
    )
    return floats, ints, trace


def _rows(trace: np.ndarray, start: int, count: int, size: int) -> np.ndarray:
    return trace[start : start + count * size].reshape(-1, size)


def _joined(parts: list[np.ndarray], size: int) -> np.ndarray:
    if len(parts) == 1:
        return parts[0]
    return np.concatenate(parts) if parts else np.empty((0, size))
