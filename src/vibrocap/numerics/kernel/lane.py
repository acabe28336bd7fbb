"""What each lane carries from step to step, by name; where it stands, `memory_layout.py` decides.

A kernel's text reads and writes `lane.time`, or `lane.side[c]` where there are several: entries of the arrays `floats`
and `ints` that its functions get. Linking writes their places, `floats[TIME + lane]` and `floats[SIDE + c * LANES +
lane]` (`with_places`). `shared` is what the first lane carries for all, `stepper` the only lane of a stepper,
`alone` that of any motion alone. Of all lanes at once `lanes.time` is read, and `at.time` is its place.
"""

import re
from collections.abc import Iterator
from typing import Any

from vibrocap.numerics.kernel.driven_generated import Law


class Wholes:
    """Entries of `ints`: one number of each lane, or per contact and the like in brackets."""

    status: int
    period_count: int  # whole periods completed
    whole_periods: int  # periods to run
    transition: list[int]  # [contacts] what of its mode is yet to be decided, see `events/transitions.py`
    gave_way: list[int]  # [contacts] 1: it has given way at this instant, of several contacts
    stiff: int  # 1: implicit steps
    patience: int  # steps until the choice of method is looked at again
    taylor_steps: int  # accepted
    implicit_steps: int  # accepted
    events: int  # in this period
    event_limit: int  # most events allowed in a period
    zero_progress: int  # decisions in a row that did not advance time
    pending: int  # 1: the tangent has left a piece and not begun the next one
    pieces: int  # written to the trace
    piece_limit: int
    recorded_events: int  # written to the trace
    recorded_event_limit: int
    piece_start: int  # place of the first piece on the trace
    recorded_event_start: int  # place of the first event on the trace
    # of an ensemble only
    run: int  # which run of the trace the lane is on; -1: none
    step_limit: int
    window: int  # periods over which is measured where nothing settles
    window_start: int  # period at which measuring began; -1: not yet
    response: int  # drive periods after which the settled motion repeats; 0: not settled
    since: int  # period from which on it was settled
    return_count: int  # of a system that nothing drives in time: returns so far, see `observe/returns.py`
    left: int  # returns until the window ends
    quiet_since: int  # first period that began after the last return
    by_place: int  # 1: returns are passages of a place, as no contact comes to rest
    passed: int  # passages of the place since a contact came to rest
    passed_at: int  # steps before the last one
    modes: int  # a number for the sides at the start of the period and its events
    last_modes: int  # the same of the period before
    steady_mark: int  # for which STEADY has been extrapolated
    next_trial: int  # first mark at which the limit may be tried
    on_trial: int  # 1: the lane has gone on from that limit; 2: which holds
    refused_trials: int
    # of drives with corners
    segment: int  # present one of the drive
    cycle: int  # whole periods of the drive since the period of the run began
    table: int  # place of the run's table of segments on the trace
    # all below of lane 0, for all lanes
    period_budget: int  # periods to run where nothing settles
    evidence_periods: int  # last periods of which evidence is taken where nothing settles; 0: none is taken at all
    extrapolate: int  # 1: runs go on from the extrapolated limit of their marks
    asked: int  # groups of measures to gather, a sum of the powers of two in `window.py`
    result_start: int  # place of the first result on the trace
    next_run: int  # first run of the trace that no lane has begun
    last_run: int  # end of the runs to begin
    more: int  # 1: come back for more runs as soon as a lane is free
    segment_count: int  # of a table
    table_start: int  # place of the first table on the trace
    table_stride: int  # from the table of a run to that of the next; 0: one serves all runs
    # of a stepper only
    begun: int  # 1: the motion has begun
    ended: int  # status with which the motion has ended; RUNNING: it has not
    stopping: int  # 1: it is to stop at the first event
    stopped: int  # 1: it has
    noticed: int  # events, but for grazes, at the instant at which the next step begins
    steps_per_call: int  # most of them
    new_input: int  # 1: an input has been set, which the next step takes
    piece_stiff: int  # STIFF of the step within which the clock stands
    last_kind: int  # of event
    last_contact: int  # 1 for the first, 0: of none
    counted: list[int]  # [counts] how often events occurred, see `loop/stepper`
    waiting_events: int  # later than the clock
    waiting_kind: list[int]  # [waiting] of these
    waiting_contact: list[int]  # [waiting]


class Numbers:
    """Entries of `floats`, likewise."""

    time: float  # since the start of the period
    period: float  # length of a period
    sticking_rate: float  # of the last term of a sticking force over the last but two, see `taylor.holding_terms`
    tail: float  # time to run after the whole periods
    side: list[float]  # [contacts] +1, -1 sliding; 0 stuck
    came_from: list[float]  # [contacts] side before it came to rest
    recorded_side: list[float]  # [contacts] side in the last piece that was recorded
    tolerance: float  # error per step over the natural size of a state
    implicit_step: float  # step that the implicit method proposes, or of the series on a slow manifold
    explicit_step: float  # last step of the Taylor method before the implicit method took over
    decay_rate: float  # of the fastest decay at the start of the step, about; of laws that cannot stick
    damped_step: float  # step for which the series has been damped by the step of all lanes; 0: it has not
    safe_speed: float  # up to which a series is known to see all that the law holds, see `resolved.py`
    refuted_speed: float  # for which this has been asked, and is not so
    far_speed: float  # from which on the law holds nothing that a step could notice
    near_speed: float  # for which this has been asked, and is not so
    contact_residual: float  # largest |contact velocity| at a located event
    state: list[float]  # [states]
    parameter: list[float]  # [parameters]
    scale: list[float]  # [states] natural size of each state
    # of an ensemble only
    step: float  # length of the present step
    event_contact: float  # number of the contact of the event with which the step ends
    delay: float  # by which the event comes later, per unit of the tangent
    inverse_scale: list[float]  # [states] one over SCALE
    threshold: float  # of settling; 0: the run goes on to its end
    remaining: float  # bound of the distance still to go, when the motion was found settled
    begun_at: float  # time at which the window of a cycle began; -1: of none
    settled_at: float  # time from which on it was settled
    return_times: list[float]  # [marks] of returns
    start_state: list[float]  # [states] at the start of the window
    measured: list[float]  # [measured] what is gathered over the window
    slow: list[float]  # [manifolds] 1: the motion is on it, see `step/slow_manifold.py`
    sweeps: list[float]  # [manifolds] series since then, of which none was accepted
    wait: list[float]  # [manifolds] steps until it is tried again
    pause: list[float]  # [manifolds] how long it waits after the next failure
    own_decay: list[float]  # [manifolds] rate of decay towards it
    drift: list[float]  # [manifolds] change of other states by an error of it, over their natural size, per time
    kick: list[float]  # [manifolds] the same while it decays
    guess: list[float]  # [manifolds * (order + 1)] series of what is slaved, of the sweep before
    until: float  # end of the present segment of a drive with corners; of any other, PERIOD stands for it
    # of a stepper only
    clock: float  # time since the motion began
    clock_rest: float  # what rounding leaves of it
    length: float  # by which the motion is to go on
    input: list[float]  # [coefficients] value, slope and curvature of an input that was set
    piece_clock: float  # start of the step within which the clock stands
    piece_time: float  # the same as TIME
    piece_length: float
    piece_segment: list[float]  # [coefficients + 2] numbers of the drive's segment in that step
    shown_side: list[float]  # [contacts] side at the clock
    last_time: float  # of the last event
    waiting_time: list[float]  # [waiting] of events that are later than the clock
    steady: list[float]  # [states] extrapolated limit of the marks, over natural sizes
    kept: list[float]  # [entries] all of the lane above, and of `ints`, while a limit is tried
    return_marks: list[float]  # [marks * (states + turns)] the same as MARKS of states at returns
    marks: list[float]  # [marks * (states + turns)] stroboscopic states over natural sizes, k at k modulo `marks`
    series: list[float]  # [series rows * (order + 1)] coefficients of the present step, see `Layout.series_rows`
    work: list[float]  # [work size, once for all lanes] of the event search and the implicit step


class Gathered:
    """Entries of `floats` over the window of a run, see `gathered_entries`."""

    integral: list[float]
    magnitude: list[float]  # [contacts]
    peak: list[float]
    largest: list[float]
    least: list[float]
    stick_time: list[float]  # [contacts]
    stick_phases: list[float]  # [contacts]
    phase_side: list[float]  # [contacts]
    phase_length: list[float]  # [contacts]
    letter_side: list[float]  # [contacts]
    letter_length: list[float]  # [contacts]
    letter_count: list[float]  # [contacts]
    letters: list[float]
    asymmetry: float
    defect: float
    sticking_share: float
    least_velocity: float
    occurred: list[float]
    lifted: list[float]  # [loads]
    returns: float
    cycle_time: float
    settled_time: float


class Rows:
    """Series: the places of their first coefficients, the next ones LANES further on each; of contacts these too."""

    row: list[int]  # [series rows] those of the states first
    guard_row: list[int]  # [guards]
    guess_row: list[int]  # [manifolds]
    load_row: list[int]  # [loads] that are watched
    velocity_row: list[int]  # [contacts]
    sticking_force_row: list[int]
    limit_row: list[int]
    velocity: list[float]  # [contacts]
    sticking_force: list[float]  # [contacts] that would hold it
    limit: list[float]  # [contacts] the largest one that can


class Lane(int, Wholes, Numbers, Gathered, Rows):
    """One lane: its number, and what it carries."""


def every_lane() -> Iterator[Lane]:
    """All lanes in turn."""
    raise NotImplementedError  # linking writes a range


shared = stepper = alone = Lane()
lanes: Any = alone  # the numbers of all lanes
at: Any = alone  # their places
INT_ENTRIES, FLOAT_ENTRIES = (tuple(map(str.upper, record.__annotations__)) for record in (Wholes, Numbers))
OF_STEPPER = (
    *("BEGUN", "ENDED", "STOPPING", "STOPPED", "NOTICED", "STEPS_PER_CALL", "NEW_INPUT", "PIECE_STIFF", "LAST_KIND"),
    *("LAST_CONTACT", "WAITING_EVENTS", "CLOCK", "CLOCK_REST", "LENGTH", "PIECE_CLOCK", "PIECE_TIME", "PIECE_LENGTH"),
    "LAST_TIME",
)
NOT_OF_STEPPER = (
    *("PENDING", "PIECES", "PIECE_LIMIT", "PIECE_START", "RECORDED_EVENTS", "RECORDED_EVENT_LIMIT"),
    *("RECORDED_EVENT_START", "RUN", "WINDOW", "WINDOW_START", "RESPONSE", "SINCE", "PERIOD_BUDGET", "EXTRAPOLATE"),
    *("MODES", "LAST_MODES", "STEADY_MARK", "NEXT_TRIAL", "ON_TRIAL", "REFUSED_TRIALS"),
    *("EVIDENCE_PERIODS", "ASKED", "RESULT_START", "NEXT_RUN", "LAST_RUN", "MORE", "EVENT_CONTACT", "DELAY"),
    *("INVERSE_SCALE", "THRESHOLD", "REMAINING", "START_STATE"),
)
OF_RETURNS = ("RETURN_COUNT", "LEFT", "QUIET_SINCE", "BY_PLACE", "PASSED", "PASSED_AT", "BEGUN_AT", "SETTLED_AT")
PER_CONTACT = ("TRANSITION", "GAVE_WAY", "SIDE", "CAME_FROM", "RECORDED_SIDE")


WHOLES, NUMBERS = (Wholes, Law.__bases__[0]), (Numbers, Gathered, Law.__bases__[1])
ARRAYS = {
    name: array
    for array, records in (("ints", WHOLES), ("floats", NUMBERS))
    for record in records
    for name in record.__annotations__
}
ROWS = {"row": "SERIES", "guard_row": "SWITCH", "guess_row": "GUESS", "load_row": "REACTION"}
OF_CONTACT = {"velocity": "VELOCITY_OF", "sticking_force": "STICKING_FORCE_OF", "limit": "LIMIT_OF"}
assert Rows.__annotations__.keys() == {*ROWS, *OF_CONTACT, *(f"{name}_row" for name in OF_CONTACT)}
ENTRY = re.compile(r"\b(lane|lanes|at|shared|stepper|alone|law)\.(\w+)(\[?)")
HOOK = re.compile(r"\bhook\.(?=\w+\()")
SIMPLE = re.compile(r"\w+|\w+\[\w+\]")  # an index that needs no brackets before `* LANES`


def with_places(text: str) -> str:
    """The text of a kernel with places for names, line by line as before; hooks are called by their own names.

        lane.time        floats[TIME + lane]             lane.side[c]     floats[SIDE + c * LANES + lane]
        lanes.time       load(floats, TIME)              lane.row[i]      SERIES + i * (ORDER + 1) * LANES + lane
        at.side[c]       SIDE + c * LANES                alone.side[c]    floats[SIDE + c]
        lane.velocity[c] floats[VELOCITY_OF[c] + lane]   lane.velocity_row[c]    VELOCITY_OF[c] + lane

    Raises ValueError for an entry that no lane has.
    """
    done, start = [], 0
    for match in ENTRY.finditer(text):
        if match.start() < start:
            continue  # within an index that is done
        (owner, name, bracket), end, index = match.groups(), match.end(), ""
        if name not in ARRAYS and name not in Rows.__annotations__:
            raise ValueError(f"`{match[0]}`: {Lane.__module__} has no entry of this name")
        if bracket:
            end = _closing(text, end)
            index = with_places(text[match.end() : end - 1])
        place = _place(owner, name, index)
        if owner != "at" and not name.endswith("row"):
            array = ARRAYS.get(name, "floats")
            place = f"load({array}, {place})" if owner == "lanes" else f"{array}[{place}]"
        done += [text[start : match.start()], place]
        start = end
    return HOOK.sub("", "".join([*done, text[start:]]).replace("every_lane()", "range(LANES)"))


def _place(owner: str, name: str, index: str) -> str:
    """The place of an entry, or of the item of it at an index."""
    several, lane = owner in ("lane", "lanes", "at"), " + lane" if owner == "lane" else ""
    if owner != "law" and name.removesuffix("_row") in OF_CONTACT:
        return f"{OF_CONTACT[name.removesuffix('_row')]}[{index}]{lane}"
    if not index:
        return name.upper() + lane
    factors = (" * (ORDER + 1)" if name in ROWS else "") + (" * LANES" if several else "")
    index = index if not factors or SIMPLE.fullmatch(index) else f"({index})"
    return f"{ROWS.get(name, name.upper())} + {index}{factors}{lane}"


def _closing(text: str, start: int) -> int:
    """Behind the bracket that closes the one before `start`."""
    depth = 1
    for end in range(start, len(text)):
        depth += {"[": 1, "]": -1}.get(text[end], 0)
        if depth == 0:
            return end + 1
    raise ValueError(f"`{text[start : start + 40]}`: its bracket is not closed")
