"""simulate(system, ...) -> Trajectory: the bridge from physics to numerics."""

import dataclasses
import functools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole, is_number, shown
from vibrocap.motion.certificate import Certificate
from vibrocap.motion.evidence import certificate
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.start import Start, begun, initial_state
from vibrocap.motion.status import Status
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.api import Recorded, codes, recorded_run, series_order
from vibrocap.numerics.expressions.graph import Expression, evaluate
from vibrocap.physics.events import BOUNDS, KINDS
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System
from vibrocap.progress import Progress, reporting
from vibrocap.quantities.declared import ByName, Time
from vibrocap.resources import TooMuchMemory, in_words


@dataclasses.dataclass(frozen=True)
class Observer:
    """Observables and rates of integrals of a system, as functions of time, states and side of the contact."""

    system: System

    def __reduce__(self):
        return type(self), (self.system,)  # the equations are recorded anew

    @functools.cached_property
    def known(self) -> dict[str, Expression]:
        """What can be asked for, by name."""
        recording = equations(self.system)
        names = (*(f"{name}_work" for name in self.system.channels), "impulse")
        return recording.observables | dict(zip(names, recording.integrals, strict=True))

    def __call__(
        self, names: tuple[str, ...], t: np.ndarray, states: np.ndarray, sides: tuple, drive: tuple
    ) -> list[np.ndarray]:
        """Values by name at times t [n], with states [states, n] and the side of each contact [n]: an array [n] each.

        drive: (times since it began its period, parameter vector), see `Trajectory.drive_at`
        """
        found = evaluate([self.known[name] for name in names], drive[0], states, sides, drive[1])
        return [np.broadcast_to(np.asarray(value, dtype=float), t.shape) for value in found]


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
    initial: initial states by name, with a unit in it where they are in SI; what is not named starts at zero
    start: when it begins: at a time, or as a `Start` says (time and phase of the drive), by default at 0. Or a motion
        of the same states, at whose end it continues: there in time, with the states (but for those in `initial`), and
        where in its period the drive was then
    tolerance: error per step, relative to the natural size of each state (1e-14 to 1e-2)
    samples: points per period of the grid `motion.time`; the motion itself is known at every instant
    progress: True for a bar, or a function that is called now and then with the share done

    Returns the motion; where it could not be completed, its status says why, and it holds what was computed.
    Raises ValueError or TypeError, naming the argument, before any work.
    """
    state, time, phase = begun(system, start, initial)
    check_run(periods=periods, tolerance=tolerance, max_events_per_period=max_events_per_period, max_steps=max_steps)
    check_whole("samples", samples, 1, MOST_SAMPLES)
    limits = max_events_per_period, max_steps
    with reporting(progress, "Simulating") as report:
        recorded = _run(system, state, periods, tolerance, *limits, phase, progress=report)
    return _trajectory(system, state, periods, tolerance, limits, time, phase, samples, recorded)


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
    found = _run(system, start, periods, tolerance, max_events_per_period, max_steps, keep_pieces=False)
    return STATUSES[found.status], found.sections


def check_run(*, periods: Any, tolerance: Any, max_events_per_period: Any, max_steps: Any) -> None:
    """ArgumentError for run settings that make no sense."""
    for name, value, low, high in (("periods", periods, SHORTEST, 1e9), ("tolerance", tolerance, 1e-14, 1e-2)):
        if not is_number(value) or not (low <= value <= high):
            wanted = "a positive number" if name == "periods" else f"a number from {low:g} to {high:g}"
            wanted += f", at least {low:g}" if name == "periods" and is_number(value) and 0 < value < low else ""
            raise ArgumentError(name, f"should be {wanted}, got {shown(value)}")
    check_whole("max_events_per_period", max_events_per_period, 1, 2**62 - 1)
    check_whole("max_steps", max_steps, 1, 2**62 - 1)


def _run(
    system, start, periods, tolerance, max_events, max_steps, phase=0.0, progress=None, keep_pieces=True, order=None
) -> Recorded:
    try:
        begin, limits = list(start.values()), (periods, tolerance, max_events, max_steps)
        how = {"progress": progress, "keep_pieces": keep_pieces, "phase": phase, "order": order}
        return recorded_run(equations(system), parameter_values(system), begin, system.drive.period, *limits, **how)
    except TooMuchMemory as error:
        fitting = periods * error.available / error.needed
        taken = f"{periods:g} drive periods of this motion take some {in_words(error.needed)} of memory"
        instead = f"some {fitting:.1g} at most, or for its measures alone (ensemble, sweep), which are taken as it runs"
        instead += "; is a damping or a stiffness far too large?" if error.said != "are free" else ""
        raise ArgumentError(
            "periods", f"{taken}, {in_words(error.available)} {error.said}; ask for {instead}"
        ) from None


def _trajectory(system, start, periods, tolerance, limits, time, phase, samples, recorded) -> Trajectory:
    recording = equations(system)
    period = system.drive.period
    begun, events = recorded.piece_instants, recorded.event_instants
    origin = time - phase * period  # when the drive began the period in which the motion begins
    motion = Trajectory(
        system=system,
        initial=start,
        periods=periods,
        tolerance=tolerance,
        period=period,
        run_status=STATUSES[recorded.status],
        state_names=system.state_names,
        integral_names=(*(f"{name}_work" for name in system.channels), "impulse"),
        piece_start=origin + (begun[:, 0] * period + begun[:, 1]),
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
        certify=Certifier(recorded, limits),
        samples=samples,
        start_time=time,
        start_phase=phase,
        piece_drive_time=begun[:, 1],
    )
    if phase and len(begun):  # the run's own marks are those of the drive
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
    """Makes the certificate of a motion when it is asked for, from what its run left and from a second, tighter run.

    limits: most events per period and most steps of the run
    """

    recorded: Recorded
    limits: tuple[int, int]

    def __reduce__(self):
        """Pieces and events are not asked for, and are with the motion."""
        return type(self), (dataclasses.replace(self.recorded, pieces=NOTHING, events=NOTHING), self.limits)

    def __call__(self, motion: Trajectory) -> Certificate:
        events, steps = self.limits
        given = dict(motion.initial), motion.periods, COMPANION * motion.tolerance, events, MORE_STEPS * steps
        order = series_order(motion.tolerance)  # of the same kernel
        tighter = _run(motion.system, *given, motion.start_phase, keep_pieces=False, order=order)
        return certificate(motion, self.recorded, tighter, COMPANION)
