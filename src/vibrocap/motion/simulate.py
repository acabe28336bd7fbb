"""simulate(system, ...) -> Trajectory: the bridge from physics to numerics, and where a motion begins.

It begins with its states, at a time, and at a place in the period of its drive.
"""

import dataclasses
import functools
import itertools
import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from vibrocap.arguments import ArgumentError, check_mapping, check_whole, is_number, shown, suggestion
from vibrocap.motion.certificate import Certificate
from vibrocap.motion.evidence import certificate
from vibrocap.motion.observer import Observer
from vibrocap.motion.recording.equations import equations, integrals, parameter_values
from vibrocap.motion.status import Status
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.api import Budget, Form, MotionStart, Recorded, codes, recorded_run, series_order
from vibrocap.physics.dimensions.conversion import INITIAL, value_in_words
from vibrocap.physics.dimensions.units import state_keys
from vibrocap.physics.events import BOUNDS, KINDS
from vibrocap.physics.names import OUTPUT, numbered
from vibrocap.physics.system import System
from vibrocap.progress import Progress, reporting
from vibrocap.quantities.declared import ByName, Number, Time
from vibrocap.quantities.dimensional import Dimensional, said
from vibrocap.resources import TooMuchMemory, in_words

AT_STOP = 1e-9  # of a stop, over the natural size: a printed state of a mass that touches it is there
BRANCH = "as it selects the branch of the equations"
WHOLE = 1e-12  # of a period: a phase that is so little short of a whole one is none


@dataclasses.dataclass(frozen=True)
class Start(Dimensional):
    """The time at which a motion begins, and the phase of the drive then.

    phase: share of the drive's period, modulo 1; by default time/T, as the drive begins a period at time 0
    """

    time: Time = 0.0
    phase: Number | None = None

    given: ClassVar[bool] = True

    def __post_init__(self):
        for name, value in (("time", self.time), ("phase", 0.0 if self.phase is None else self.phase)):
            if not is_number(value) or not math.isfinite(value):
                raise ArgumentError(f"start.{name}", f"should be a finite number, got {shown(value)}")

    def phase_of(self, period: float) -> float:
        """The phase in [0, 1) of a drive of that period."""
        phase = self.time / period if self.phase is None else self.phase
        return max(0.0, phase - math.floor(phase + WHOLE))


def begun(system: System, start: Any, initial: Mapping[str, float] | None) -> tuple[dict[str, float], float, float]:
    """(initial states by name, time, phase of the drive) at the start of a motion, see `simulate`."""
    given = initial
    if isinstance(start, Trajectory):
        if start.state_names != system.state_names:
            raise ArgumentError(
                "start",
                f"should be a motion of the states {', '.join(system.state_names)} to continue from, got one of "
                f"{', '.join(start.state_names)}; give a Start and initial= instead",
            )
        given = start.state | dict(initial or {})
        start = Start(start.end, start.end_phase)
    elif start is None or is_number(start):
        start = Start(float(start or 0.0))
    if not isinstance(start, Start):
        raise ArgumentError("start", f"should be a motion, a time or a Start, got {shown(start)}")
    state, phase = initial_state(system, given), start.phase_of(system.drive.period)
    if system.machine.follows_load:
        check_load(system, state, phase * system.drive.period)
    return state, float(start.time), phase


def check_load(system: System, state: Mapping[str, float], time: float) -> None:
    """ArgumentError for a start at which the ground would have to pull at the machine, whatever contacts at rest do.

    time: of the drive. A start at which the loads do not follow from the forces is left to the run, which ends there.
    """
    y = tuple(state.values())
    contacts = system.placed.contacts(time, y[: len(system.placed.states)], system.drive.value(time))
    reactions = [contact.reaction for contact in contacts]
    if any(slope for _, *slopes in reactions for slope in slopes):
        pairs = zip(contacts, system.laws, strict=True)
        modes = itertools.product(*(_possible_sides(contact.velocity, law.kind) for contact, law in pairs))
        loads = (_least_load(system, time, y, sides) for sides in modes)
    else:  # no friction raises or lowers any of them
        loads = iter([min((own, i) for i, (own, *_) in enumerate(reactions, start=1))])
    least, number = -math.inf, 0
    for load in loads:
        least, number = max((least, number), load)
        if least >= 0.0:
            return
    words = (f"{name} {value_in_words(INITIAL + name, value, system)}" for name, value in state.items() if value)
    states = ", ".join(words) or "all at 0"
    force = said(least * system.result_units.factor("reaction"), system.result_units.unit("reaction"), 4)
    where = f" on contact {number}" if len(contacts) > 1 else ""
    what = f"the normal load{where} is negative at the start, {force}: the machine would lift off at once"
    raise ArgumentError("initial", f"{what} ({states})")


def _possible_sides(velocity: float, kind: str) -> tuple[int, ...]:
    """The sides to which a contact may slide, or 0 where it may rest."""
    side = (velocity > 0.0) - (velocity < 0.0)
    return (side,) if side else (0, 1, -1) if kind == "set-valued" else (1,)


def _least_load(system: System, time: float, y: tuple, sides: tuple) -> tuple[float, int]:
    """(least load, number of its contact) in some modes of the contacts; 0 where it does not follow from the forces."""
    flow = system.flow(time, y, sides)
    if any(side and not contact.clear > 0.0 for side, contact in zip(sides, flow.contacts, strict=True)):
        return 0.0, 1
    return min((flow.reaction(i), i + 1) for i in range(len(sides)))


def initial_state(system: System, initial: Mapping[str, float] | None) -> dict[str, float]:
    """All initial states by name; ArgumentError for a state that does not exist or is not a finite number, or
    not a whole one where it says which branch of the equations holds.

    A name with a unit, "position_m", is a state of a system that knows its scales.
    """
    initial = {} if initial is None else initial
    check_mapping("initial", initial, '{"velocity": 0.1}')
    start = dict.fromkeys(system.state_names, 0.0)
    keys = state_keys(system.result_units.states)
    for name, value in initial.items():
        if name not in start and name not in keys:
            near = suggestion(name, [*start, *keys], cutoff=0.0)
            raise ArgumentError(f"initial.{name}", f"no such state; {near} States: {', '.join(start)}")
        if not is_number(value) or not math.isfinite(value):
            raise ArgumentError(f"initial.{name}", f"should be a finite number, got {shown(value)}")
        if value != round(value) and name in system.switched:
            raise ArgumentError(f"initial.{name}", f"should be a whole number, {BRANCH}, got {value!r}")
        if name in start:
            start[name] = float(value)
        else:
            start[keys[name].name] = float(value) / system.si.per_key(keys[name])
    check_room(system, start)
    return start


def within_room(system: System, state: Mapping[str, float]) -> dict[str, float]:
    """A state of a motion of other parameters, at the stop or the limit where it would lie beyond it."""
    placed = system.placed
    room = placed.room()
    clipped = dict(state) | {name: min(max(state[name], low), high) for name, (low, high) in room.items()}
    for switch, (name, *_) in placed.locked.items():
        if clipped[switch] != 0.0 and name in room:
            clipped[name] = room[name][clipped[switch] > 0.0]
    return clipped


def check_room(system: System, start: Mapping[str, float]) -> None:
    """ArgumentError for a start beyond a rigid stop of the machine, or with a branch that does not hold there."""
    for name in system.switched:
        if start[name] not in (-1.0, 0.0, 1.0):
            raise ArgumentError(f"initial.{name}", f"should be -1, 0 or 1, got {start[name]:g}")
    for switch, (name, *still) in system.placed.locked.items():
        where = start[switch] and system.placed.room()[name][start[switch] > 0.0]
        if not math.isfinite(where):
            raise ArgumentError(f"initial.{switch}", f"should not be {start[switch]:g}, as there is no stop")
        # over a belt it slides at the stop
        rest = dict.fromkeys(system.machine.contact_states, -system.machine.ground_speed())
        for locked, value in ((name, where), *((key, rest.get(key, 0.0)) for key in still)) if start[switch] else ():
            if not abs(start[locked] - value) <= AT_STOP * (1.0 + abs(value)):
                wanted, got = (
                    value_in_words(INITIAL + locked, number, system, 10) for number in (value, start[locked])
                )
                what = f"should be {wanted}, as {switch} is {start[switch]:g}, got {got}"
                raise ArgumentError(f"initial.{locked}", what)
    for name, (low, high) in system.placed.room().items():
        rounding = WHOLE * (1.0 + abs(start[name]))
        if not low - rounding <= start[name] <= high + rounding:
            what = "the actuator has its limit" if name == OUTPUT else "a stop stands"
            side, bound = ("most", high) if start[name] > high else ("least", low)
            wanted, got = (value_in_words(INITIAL + name, number, system) for number in (bound, start[name]))
            raise ArgumentError(f"initial.{name}", f"should be at {side} {wanted}, where {what}, got {got}")


MOST_SAMPLES = 2**24  # per period
SHORTEST = 1e-9  # drive periods of a run: shorter ones are rounding

# By the numbers of `codes`.
STATUSES = {
    codes.DONE: Status.FINISHED,
    codes.STEP_UNDERFLOW: Status.STEP_UNDERFLOW,
    codes.NOT_FINITE: Status.NOT_FINITE,
    codes.TOO_MANY_EVENTS: Status.TOO_MANY_EVENTS,
    codes.UNDECIDED: Status.UNDECIDED_CONTACT,
    codes.TOO_MANY_STEPS: Status.TOO_MANY_STEPS,
    **{codes.BEYOND_BOUND + i: Status(kind.replace("_", " ")) for i, kind in enumerate(BOUNDS)},
}
NOTHING = np.empty((0, 0))
MORE_STEPS = 2  # times as many as the run may take; a tenth of the tolerance takes up to 10^(1/5) times as many
COMPANION = 0.1  # times the tolerance: that of the second run, with which the error is estimated


def simulate(
    system: System,
    *,
    periods: float = 40,
    initial: ByName | None = None,
    start: Trajectory | Start | Time | None = None,
    tolerance: float = 1e-9,
    max_events_per_period: int = 10_000,
    max_steps: int = 50_000_000,
    samples: int = 256,
    progress: Progress = None,
) -> Trajectory:
    """The motion of a system over so many drive periods, with the sticking contact solved exactly.

    Each step is a Taylor series (an implicit step where the law is stiff), and the roots of these polynomials are the
    events: no step crosses a change between sticking and sliding.

    periods: drive periods, a positive number, not necessarily whole
    initial: initial states by name, with a unit in it where they are in SI; others start at zero
    start: a time or a `Start` (time and phase of the drive), by default 0; or a motion of the same states, which it
        continues with its time, states (but for those in `initial`) and phase of the drive
    tolerance: error per step, relative to the natural size of each state (1e-14 to 1e-2)
    samples: points per period of the grid `motion.time`; the motion itself has values at every instant
    progress: True for a bar, or a function that is called now and then with the share done

    Returns the motion; an incomplete one holds its computed part, and its status the reason.
    Raises ValueError or TypeError, naming the argument, before any work.
    """
    begin = state, _, phase = begun(system, start, initial)
    check_run(periods=periods, tolerance=tolerance, max_events_per_period=max_events_per_period, max_steps=max_steps)
    check_whole("samples", samples, 1, MOST_SAMPLES)
    budget = Budget(periods, tolerance, max_events_per_period, max_steps)
    with reporting(progress, "Simulating") as report:
        recorded = _run(system, state, budget, phase, progress=report)
    return _trajectory(system, begin, budget, samples, recorded)


def period_marks(
    system: System,
    *,
    periods: int,
    initial: Mapping[str, float] | None = None,
    tolerance: float = 1e-9,
    max_events_per_period: int = 10_000,
    max_steps: int = 50_000_000,
) -> tuple[Status, np.ndarray]:
    """(status, states at the start of every period and at the end [periods + 1, states]) of a long motion.

    Nothing else of it is kept, so that a hundred thousand periods cost little memory. The arguments are those of
    `simulate`; where the motion could not be completed there are fewer marks.
    """
    start = initial_state(system, initial)
    check_run(periods=periods, tolerance=tolerance, max_events_per_period=max_events_per_period, max_steps=max_steps)
    budget = Budget(periods, tolerance, max_events_per_period, max_steps)
    run = _run(system, start, budget, keep_pieces=False)
    return STATUSES[run.status], run.sections


def check_run(*, periods: Any, tolerance: Any, max_events_per_period: Any, max_steps: Any) -> None:
    """ArgumentError for run settings that make no sense."""
    for name, value, low, high in (("periods", periods, SHORTEST, 1e9), ("tolerance", tolerance, 1e-14, 1e-2)):
        if not is_number(value) or not (low <= value <= high):
            wanted = "a positive number" if name == "periods" else f"a number from {low:g} to {high:g}"
            wanted += f", at least {low:g}" if name == "periods" and is_number(value) and 0 < value < low else ""
            raise ArgumentError(name, f"should be {wanted}, got {shown(value)}")
    check_whole("max_events_per_period", max_events_per_period, 1, 2**62 - 1)
    check_whole("max_steps", max_steps, 1, 2**62 - 1)


def _run(system: System, state: Mapping[str, float], budget: Budget, phase: float = 0.0, **how: Any) -> Recorded:
    period = system.drive.period
    start = MotionStart(equations(system), parameter_values(system), list(state.values()), period, phase)
    try:
        return recorded_run(start, budget, **how)
    except TooMuchMemory as error:
        fitting = budget.periods * error.available / error.needed
        taken = f"{budget.periods:g} drive periods of this motion take some {in_words(error.needed)} of memory"
        size = 10.0 ** math.floor(math.log10(fitting))
        most = math.floor(fitting / size) * size
        instead = f"some {most:g} at most, or for its measures alone (ensemble, sweep), which need no stored motion"
        instead += "; is a damping or a stiffness far too large?" if error.said != "are free" else ""
        raise ArgumentError(
            "periods", f"{taken}, {in_words(error.available)} {error.said}; ask for {instead}"
        ) from None


def _trajectory(system, begin, budget, samples, recorded) -> Trajectory:
    recording, (state, time, phase) = equations(system), begin
    period = system.drive.period
    starts, events = recorded.piece_instants, recorded.event_instants
    origin = time - phase * period  # when the drive began the period in which the motion begins
    motion = Trajectory(
        system=system,
        initial=state,
        periods=budget.periods,
        tolerance=budget.tolerance,
        period=period,
        run_status=STATUSES[recorded.status],
        state_names=system.state_names,
        integral_names=tuple(integrals(recording)),
        piece_start=origin + (starts[:, 0] * period + starts[:, 1]),
        piece_length=recorded.piece_lengths,
        piece_sides=recorded.piece_sides,
        piece_implicit=recorded.piece_implicit,
        series=recorded.series,
        sections=recorded.sections,
        event_times=origin + (events[:, 0] * period + events[:, 1]),
        event_kinds=_event_kinds(system, recorded),
        event_contacts=recorded.event_contacts,
        event_states=recorded.event_states,
        observe=Observer(system),
        observable_names=tuple(recording.observables),
        certify=Certifier(recorded, budget),
        samples=samples,
        start_time=time,
        start_phase=phase,
        piece_drive_time=starts[:, 1] % period,
    )
    if phase and len(starts):  # the run's own marks are those of the drive
        done = math.floor((motion.end - time) / period + 1e-12)
        own = np.minimum(time + np.arange(done + 1) * period, motion.end)
        motion = dataclasses.replace(motion, sections=motion.states(own).T)
    return motion


@functools.lru_cache(maxsize=64)
def event_kinds(own: tuple[str, ...]) -> np.ndarray:
    """Names of the kinds of event, by the numbers of `codes`. own: those of the machine, `switch_events`, which stand
    at MACHINE_SWITCHED."""
    unused = [""] * (codes.MACHINE_SWITCHED - len(KINDS))
    return np.array([*KINDS, *unused, *own])


def _event_kinds(system: System, recorded: Recorded) -> np.ndarray:
    """Names of the events; those at a further contact end in its number."""
    kinds = event_kinds(system.placed.switch_events)[recorded.event_kinds]
    if len(system.machine.contact_states) == 1:
        return kinds
    pairs = zip(kinds, recorded.event_contacts, strict=True)
    return np.array([numbered(str(kind), max(1, int(number))) for kind, number in pairs], dtype=str)


@dataclasses.dataclass(frozen=True, eq=False)
class Certifier:
    """Makes the certificate of a motion when it is asked for, from what its run left and from a second, tighter run."""

    recorded: Recorded
    budget: Budget

    def __reduce__(self):
        """Pieces and events are not asked for, and are with the motion."""
        return type(self), (dataclasses.replace(self.recorded, pieces=NOTHING, events=NOTHING), self.budget)

    def __call__(self, motion: Trajectory, whole: bool = True) -> Certificate:
        """whole: False: without what is held to no bound, which a second run tells."""
        if not whole:
            return certificate(motion, self.recorded, None, COMPANION)
        own = self.budget
        more = dataclasses.replace(own, tolerance=COMPANION * own.tolerance, max_steps=MORE_STEPS * own.max_steps)
        form = Form(order=series_order(motion.tolerance))  # of the same kernel
        tighter = _run(motion.system, motion.initial, more, motion.start_phase, form=form, keep_pieces=False)
        return certificate(motion, self.recorded, tighter, COMPANION)
