"""steer(system, target): a schedule of the drive that brings a machine to a place and holds it there."""

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import Complaint, Complaints, check_one_of, check_whole, is_number, is_positive, shown
from vibrocap.case.case import Case, CaseError
from vibrocap.design.search.uncertainty import sample_points, samples_of, uncertain_quantities
from vibrocap.design.steering.search import NEAR, Search, said_place, said_time
from vibrocap.design.steering.steering import Steering, SteeringStatus, steering_of
from vibrocap.design.steering.trials import Trials, with_schedule
from vibrocap.motion.simulate import initial_state
from vibrocap.orbits.maps.stroboscopic_map import is_driven
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import ByName, Length, Time

FRESH = 4  # times as many samples as the search has seen check what it found
CHECKS = 3  # searches, each with the samples added that the last one's schedule misses by more than it foresaw
FORESEEN = 1.1  # times the worst error in the samples that it has seen
OBJECTIVES = ("time", "work")


@shows_progress("Looking for a schedule")
def steer(
    system: System | Case,
    target: Length,
    *,
    tolerance: Length,
    uncertain: Mapping[Any, Any] | None = None,
    within: Time | None = None,
    least: str = "time",
    initial: ByName | None = None,
    hold: int = 10,
    samples: int = 16,
    levels: int = 16,
    threads: int | None = None,
    progress: Progress = None,
) -> Steering:
    """A schedule of the drive that brings a machine to a target and holds it there, the best of a stated family.

    The family: one burst or two, each of so many periods of the drive's own wave times a factor, begun anew and
    followed by a pause, in which the contact sticks. Factors are k/levels from -1 to 1: a negative one turns the drive
    round, and a machine without a preferred direction makes the mirror image of its motion. First bursts have every
    factor and up to 8 periods, or they are long: those of the six factors whose settled motions travel fastest towards
    the target, with each of ten whole numbers of periods about the one that arrives. Second bursts have every factor
    and up to 4 periods. Lengths are multiples of a quarter of a period; of one, where the drive has corners of its own.
    The last factor may lie between two of these where the error changes its sign, and is refined five times, by 8 each.
    The ways of bursts nearly add up, as nothing depends on the place and a pause ends at rest but for what an inner
    mass still swings; by their sums the best are chosen, and these are run in whole.

    Found is a schedule that is feasible and the best of those that were run, not the best of all: a drive of another
    shape, or a feedback, may do better.

    system: a machine that travels under a drive that changes in time, and rests without
    target: the place where it is to be, in the position's own units, and in SI for a system in SI; tolerance: how far
        from there is near enough
    uncertain: {path: distribution}, as `robustness` takes it: every sample has to arrive, the corners of a box included
    within: the time that the schedule may take until its last pause has ended; None: any
    least: what is made small, "time" or "work" of the drive
    initial: where it starts, by state; by default that of the case, else at rest at 0
    hold: drive periods of the last pause that are there to hold it
    samples: of what is uncertain, that the search sees; four times as many others check what it found. Those that it
        misses by more than it foresaw are added, and it is searched again and checked in others still, twice at most
    threads: at most so many

    Returns a `Steering`, whose status says whether it arrives in every sample, and how near it comes if not. Raises
    CaseError with every complaint about the arguments before any work, and after it for a machine that does not rest
    while the drive pauses, a target that cannot be reached by this drive, and a time in which it cannot.
    """
    case = system if isinstance(system, Case) else Case(system)
    system = case.system
    complaints = Complaints()
    _check_system(system, complaints)
    if not is_number(target) or not math.isfinite(target):
        complaints.add("target", f"should be a finite number, got {shown(target)}")
    for name, value, said in (("tolerance", tolerance, said_place), ("within", within, said_time)):
        if not (value is None and name == "within") and not is_positive(value):
            known = value is not None and is_number(value) and system.cyclic is not None
            got = said(system, float(value)) if known else shown(value)  # type: ignore[arg-type]
            complaints.add(name, f"should be positive, got {got}")
    for name, value, low, high in (("hold", hold, 1, 10_000), ("samples", samples, 1, 4096), ("levels", levels, 1, 64)):
        with complaints.collected():
            check_whole(name, value, low, high)
    if not complaints and uncertain and samples & (samples - 1):
        complaints.add("samples", f"should be a power of two, got {samples}")
    with complaints.collected():
        check_one_of("least", least, OBJECTIVES)
    quantities = uncertain_quantities(system, uncertain, complaints) if uncertain else ()
    start: Mapping[str, float] = {}
    with complaints.collected():
        start = initial_state(system, case.initial if initial is None else initial)
    if complaints:
        raise CaseError(complaints, "the question")
    seen = samples_of(quantities, samples, "worst").points if quantities else np.zeros((0, 0))
    tell = told(progress) or (lambda share: None)

    def searched(points: np.ndarray, seed: int) -> Steering:
        """What is found with these samples, checked in others."""
        search = Search(system, start, float(target), float(tolerance), least, (quantities, points), levels, threads)
        others = sample_points(len(quantities), FRESH * samples, seed) if quantities else points
        bursts = _best(search, within, tell)
        return steering_of(search, bursts, hold, Trials(system, start, quantities, others, threads))

    found: list[Steering] = []
    for seed in range(1, CHECKS + 1):
        found.append(searched(seen, seed))
        errors = np.nan_to_num(np.abs(found[-1].positions - found[-1].target), nan=math.inf)
        foreseen = max(found[-1].tolerance, FORESEEN * np.max(errors[: len(seen)], initial=0.0))
        missed = errors[len(seen) :] > foreseen
        if not np.any(missed):
            break
        others = sample_points(len(quantities), FRESH * samples, seed)
        seen = np.concatenate([seen, others[missed]])  # and again, with those that it did not foresee
    return min(found, key=lambda each: (each.status is not SteeringStatus.ARRIVES, each.worst_error))


def _check_system(system: System, complaints: Complaints) -> None:
    """Complaints about a system that cannot be steered."""
    if system.cyclic is None:
        complaints.add("system", "should be free to travel: this machine is held to its place")
    if system.controller is not None:
        complaints.add("system", "should have no controller, which does not let the drive pause; steer its machine")
        return
    if not is_driven(system):
        complaints.add("system", "should have a drive that changes in time")
        return
    try:
        with complaints.collected():
            with_schedule(system, [(1.0, 1.0), (1.0, 0.0)])
    except ValueError as error:
        complaints.add("system", f"should have a drive that can be scheduled: {error}")


def _best(search: Search, within: float | None, tell: Callable[[float], None]) -> np.ndarray:
    """The bursts [2, 2] of the best schedule, or of the one that comes nearest to arriving.

    Raises CaseError where none comes near, or none arrives in time.
    """
    limit = math.inf if within is None else within
    found = search.schedules(tell, limit if search.least == "work" else math.inf)
    arrives = np.flatnonzero(found.worst <= search.tolerance)
    timely = arrives[found.time[arrives] <= limit]
    if len(timely):
        return found.bursts[timely[np.lexsort((found.worst[timely], found.cost[timely]))[0]]]
    if len(arrives):
        soonest = said_time(search.system, float(np.min(found.time[arrives])))
        what = f"should be at least {soonest}, which the soonest schedule takes"
        raise CaseError([Complaint("within", f"{what}, got {said_time(search.system, limit)}")], "the question")
    if search.least == "work" and within is not None:
        search.least = "time"  # to say how long it takes, and whether it can be reached at all
        return _best(search, within, tell)
    nearest = int(np.argmin(found.worst))
    way = abs(search.target - search.here)
    own = np.min(np.nan_to_num(np.abs(found.own), nan=math.inf))
    if math.isfinite(found.worst[nearest]) and own <= max(search.tolerance, NEAR * way):
        return found.bursts[nearest]
    who = (
        "the schedules of the family"
        if len(search.travelling)
        else "no settled motion of this drive travels there, and short bursts"
    )
    place = search.target + found.own[int(np.nanargmin(np.abs(found.own)))]
    nearest, asked = (said_place(search.system, float(each)) for each in (place, search.target))
    what = f"should be within reach: {who} come no nearer than {nearest}, got {asked}"
    raise CaseError([Complaint("target", what)], "the question")
