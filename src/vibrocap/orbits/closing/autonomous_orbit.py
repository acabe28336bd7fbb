"""Orbits of systems that nothing drives in time, such as a block on a belt: the period is unknown.

Their turns are counted by returns to a section of the state space; the number after which a motion repeats gives the
first guess.
"""

import dataclasses
import math
from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_number, listed, suggestion
from vibrocap.motion.recording.equations import equations
from vibrocap.motion.recording.section import section_states
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.motion.trust import stands_still
from vibrocap.orbits.closing.periodic_solution import OrbitStatus, PeriodicSolution
from vibrocap.orbits.closing.settling_runs import SETTLED
from vibrocap.orbits.closing.shooting import closed
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, named_states, state_vector
from vibrocap.physics.events import CONTACT, IMPACT, STICK
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System
from vibrocap.quantities.declared import Context, Declared

KINDS = (*CONTACT, IMPACT)
WAYS = {"up": 1, "down": -1}
ARRIVED = 1e-6  # of the extents of the motion, within which a state is that of an earlier return
RECURRENT = 0.03  # as near as a motion has to come for Newton's method, which decides, to be tried there
FEWEST = 3  # returns by default sections: fewer may belong to a motion that is coming to rest


@dataclasses.dataclass(frozen=True)
class Section:
    """Where the turns of a motion are counted: at events of one kind and contact, or where an observable takes a value.

    event: "stick", "slip_forward", "slip_back", "reversal" or "impact"; contact: its number, 1 for the first
    observable: a state or an observable of the motion, in place of an event, which passes `value` upward
        (`direction` 1) or downward (-1); a coordinate that turns passes it modulo whole turns
    """

    event: str | None = None
    contact: int = 1
    observable: str | None = None
    value: float = 0.0
    direction: int = 1

    def times(self, motion: Trajectory) -> np.ndarray:
        if self.observable is None:
            kind = str(self.event) if self.event == IMPACT else numbered(str(self.event), self.contact)
            return np.array([event.time for event in motion.events if event.kind == kind])
        turn = motion.system.turns.get(self.observable)
        return motion.crossings(self.observable, self.value, self.direction, turn)

    def __str__(self) -> str:
        if self.observable is None:
            return f"{self.event} of contact {self.contact}"
        return f"{self.observable} = {self.value:g}, {'upward' if self.direction > 0 else 'downward'}"


class OfSection(Declared):
    """A section as it is asked for, whose value is in the unit of its observable."""

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        section = checked_section(context.system, value)
        if section is None or section.observable is None:
            return section
        return dataclasses.replace(section, value=section.value / context.units.factor(section.observable))


SectionAsked = Annotated[Any, OfSection()]  # a `Section` or a text


def checked_section(system: System, asked: Any) -> Section | None:
    """A section as given or in words: "stick_2" (an event and its contact), "position=0.5", "position=0.5:down"."""
    if asked is None:
        return None
    contacts = len(system.laws)
    if isinstance(asked, str) and "=" in asked:
        observable, _, place = asked.partition("=")
        value, _, direction = place.partition(":")
        try:
            way = WAYS[direction.strip() or "up"]
            asked = Section(observable=observable.strip(), value=float(value), direction=way)
        except (ValueError, KeyError):
            why = f"should be NAME=VALUE, NAME=VALUE:up or NAME=VALUE:down, got {asked!r}"
            raise ArgumentError("section", why) from None
    if isinstance(asked, str):
        names = {numbered(kind, k): (kind, k) for kind in KINDS for k in range(1, contacts + 1)}
        if asked not in names:
            raise ArgumentError("section", f"no event is called {asked!r}; {suggestion(asked, names)}")
        kind, contact = names[asked]
        return Section(kind, contact)
    if not isinstance(asked, Section) or (asked.event is None) == (asked.observable is None):
        raise ArgumentError("section", f"should be a Section with an event or an observable, got {asked!r}")
    if asked.observable is None:
        if asked.event not in KINDS:
            raise ArgumentError("section.event", f"should be {listed(KINDS, ' or ')}, got {asked.event!r}")
        if isinstance(asked.contact, bool) or asked.contact not in range(1, contacts + 1):
            raise ArgumentError("section.contact", f"should be 1 to {contacts}, got {asked.contact!r}")
        return asked
    useful = [name for name in (*system.state_names, *equations(system).observables) if name != system.cyclic]
    if asked.observable not in useful:
        why = f"{asked.observable!r} is none that comes back; {suggestion(asked.observable, useful)}"
        raise ArgumentError("section.observable", why)
    if not is_number(asked.value) or not math.isfinite(asked.value):
        raise ArgumentError("section.value", f"should be a finite number, got {asked.value!r}")
    if asked.direction not in (1, -1):
        raise ArgumentError("section.direction", f"should be 1 (upward) or -1 (downward), got {asked.direction!r}")
    return asked


def returns_of(motion: Trajectory, section: Section | None) -> Iterator[np.ndarray]:
    """Times of the returns to a section; to each of the default ones that is met often enough where there is none."""
    if section is not None:
        yield section.times(motion)
        return
    for default_section in default_sections(motion):
        times = default_section.times(motion)
        if len(times) > FEWEST:
            yield times


def default_sections(motion: Trajectory) -> Iterator[Section]:
    """Where a motion may return: places of what turns, then sticks, slips and reversals of each contact.

    Behind them the middle of each other state that moves: a cycle passes it even where nothing sticks or turns round.
    """
    for name, turn in motion.system.turns.items():
        if len(motion.piece_start) and abs(np.ptp(motion.at([0.0, motion.end], name))) > FEWEST * turn:
            ends = motion.at([0.0, motion.end], name)
            marks = [event.time for event in motion.events][-2:]
            here = 0.5 * sum(marks) if len(marks) == 2 else motion.end
            direction = 1 if ends[-1] > ends[0] else -1
            yield Section(observable=name, value=float(motion.at(here, name)[0]), direction=direction)
    for kind in KINDS:
        yield from (Section(kind, k) for k in range(1, motion.piece_sides.shape[1] + 1))
    late = motion.states(motion.piece_start[len(motion.piece_start) // 2 :])
    for name, values, size in zip(motion.state_names, late, motion.system.scales(), strict=True):
        stays = name in (motion.system.cyclic, *motion.system.turns, *motion.system.switched)
        if not stays and np.ptp(values) > ARRIVED * size:
            yield Section(observable=name, value=float(0.5 * (np.min(values) + np.max(values))))


def recurrence(motion: Trajectory, times: np.ndarray, most: int) -> tuple[int, float]:
    """(returns after which the last passage repeats, how far the states are apart); the least number that counts.

    times: [returns + 1] of the passages; most: returns of a cycle. Distances are over the range of each state in the
    second half of the motion, which does not depend on natural sizes.
    """
    sizes = np.array(motion.system.scales(), dtype=float)
    late = motion.piece_start[len(motion.piece_start) // 2 :]
    extents = np.ptp(section_states(motion.system, motion.states(late).T, sizes), axis=0)
    where = section_states(motion.system, motion.states(times[-1 - most :]).T, sizes)
    extents[extents == 0.0] = 1.0
    away = np.max(np.abs(where[-2::-1] - where[-1]) / extents, axis=1)
    n = int(np.flatnonzero(away <= max(2.0 * np.min(away), ARRIVED))[0])
    return n + 1, float(away[n])


SIMULATED = 1e-10  # tolerance of the run that looks for a cycle
MOST_RETURNS = 64  # of a cycle, unless told otherwise
QUIET = 3.0  # longest times between returns without one, after which a section is no longer met
LOOKS = 64  # instants at which a motion at rest is looked at
STEADY = 1e-3  # of its own value, by which a velocity may change that is constant
BESIDE = 1e-6  # of a cycle: an event so soon after a return belongs to it
STOPS = 4  # the last ones, that have to go on alike
NEARER = 0.95  # share of the rates at a stop that is left at the next one, at most
ALIKE = 1e-3  # by which this share may change from stop to stop
EXCESS = 1e-12  # of what a contact can hold, that it may hold more than it rubs in the slowest slide


def autonomous_orbit(
    system: System,
    start: np.ndarray,
    settle_periods: int,
    tolerance: float = 1e-12,
    section: Section | None = None,
    returns: int = MOST_RETURNS,
) -> PeriodicSolution:
    """The cycle that a start leads to, of a system whose equations do not contain the time.

    It is closed from a guess (`closed`), modulo travel and whole turns. The guess comes from a simulation: the motion
    returns to a section, and the cycle is as many returns as bring its last passage back. Without a section several are
    tried (`default_sections`), and that is taken at which the motion comes back best. The multiplier 1 of the direction
    along the motion is left out. Where the motion ends at an equilibrium, the status is SLIDES_STEADILY, CARRIED or
    COMES_TO_REST, the last also in the limit by ever smaller stops.

    settle_periods: length of that simulation in `drive.period`; returns: most of them in a cycle
    """
    map_ = StroboscopicMap(system, tolerance)
    motion = simulate(system, periods=settle_periods, initial=named_states(system, start), tolerance=SIMULATED)
    guess = _turn(motion, section, returns)
    if isinstance(guess, OrbitStatus):
        unknown, none = np.full((map_.states,) * 2, np.nan), np.empty(0, dtype=complex)
        ended = named_states(system, state_vector(system, motion.state))
        return PeriodicSolution(system, ended, 0.0, 0, None, none, np.inf, None, unknown, guess, 0, tolerance)
    state, side, period, passed = guess
    cycle = closed(map_, state, period=period, side=side)
    return dataclasses.replace(cycle, returns=passed) if cycle.closes else cycle


def near_cycle(system: System, state: np.ndarray, period: float, tolerance: float = 1e-12) -> PeriodicSolution:
    """The cycle near a state [states] and a period, stable or not, by Newton's method as in `autonomous_orbit`."""
    map_ = StroboscopicMap(system, tolerance)
    return closed(map_, state, period=period, side=map_.contact_side(state, map_.parameters()))


def _turn(motion: Trajectory, section: Section | None, most: int) -> tuple[np.ndarray, Any, float, int] | OrbitStatus:
    """(state, sides, time, returns) of the last turn of a simulation, amid the phase that begins at a return.

    A section that was met before, but no longer is, belongs to what the motion has left: a rotor that has stopped.
    """
    if not motion.run_status.ok:
        return OrbitStatus.RUN_FAILED
    if (equilibrium := _equilibrium(motion)) is not None:
        return equilibrium
    points = []
    for times in returns_of(motion, section):
        if len(times) > 1 and motion.end - times[-1] <= QUIET * np.max(np.diff(times)):
            count, away = recurrence(motion, times, most)
            points.append((away, count, times))
        if points and points[-1][0] <= ARRIVED:
            break
    if not points:
        return OrbitStatus.NOT_SETTLED if section is None else OrbitStatus.SECTION_NOT_MET
    away, count, times = min(points, key=lambda pair: pair[0])
    if away > RECURRENT:
        return OrbitStatus.COMES_TO_REST if comes_to_rest(motion) else OrbitStatus.MORE_RETURNS
    return *_within(motion, times[-1 - count], times[-1]), count


def _equilibrium(motion: Trajectory) -> OrbitStatus | None:
    """What a motion has become of which nothing but the cyclic coordinate moves in the last tenth; None of another.

    A velocity that tends to zero, as of a contact that creeps, changes by a share of itself.
    """
    times = np.linspace(0.9 * motion.end, motion.end, LOOKS)
    late = section_states(motion.system, motion.states(times).T, np.array(motion.system.scales(), dtype=float))
    if not stands_still(np.ptp(late, axis=0), SETTLED):
        return None
    names = [numbered("contact_velocity", k + 1) for k in range(motion.piece_sides.shape[1])]
    slides = [_even(motion.at(times, name)) for name in names]
    if any(slides):
        return OrbitStatus.SLIDES_STEADILY
    places = () if motion.system.cyclic is None else motion.at(times, motion.system.cyclic)
    return OrbitStatus.CARRIED if _even(np.diff(places)) else OrbitStatus.COMES_TO_REST


def _even(gains: np.ndarray) -> bool:
    """Whether each is the same way, and of the same size to a share."""
    return bool(len(gains)) and float(np.ptp(gains)) < STEADY * abs(float(gains[-1]))


def _within(motion: Trajectory, begin: float, end: float) -> tuple[np.ndarray, Any, float]:
    """A state soon after a return, amid the phase that begins there, its sides, and the time between two returns."""
    marks = [event.time for event in motion.events if begin + BESIDE * (end - begin) < event.time <= end]
    middle = 0.5 * (begin + (marks[0] if marks else end))
    state = motion.states([middle])[:, 0]
    sides = tuple(float(side) for side in motion.piece_sides[motion.piece_at(np.array([middle]))[0]])
    for contact, side in zip(equations(motion.system).contacts, sides, strict=True):
        if side == 0.0 and contact.is_state:
            state[contact.state] = 0.0
    return state, sides[0] if len(sides) == 1 else sides, end - begin


def comes_to_rest(motion: Trajectory) -> bool:
    """Whether a motion continues to rest by smaller and smaller stops, of which none is the last.

    So ends a linear loop with integral action around a contact that holds no more than it rubs: each slide is the one
    before on a smaller scale, turned round, so that stops shrink by one share, while the time that the integral needs
    to push the contact loose grows as much. So the rates at the last stops of all contacts fall by one share below 1,
    and they grow longer. A contact that holds more than it rubs has a smallest slide: there is a cycle.
    """
    system = motion.system
    if not _rubs_as_it_holds(system):
        return False
    kinds = {f"{STICK}{number}" for number in ("", *(f"_{i}" for i in range(2, 1 + len(system.laws))))}
    stops = [event for event in motion.events if event.kind in kinds]
    at_rest = [not motion.piece_sides[motion.piece_at(np.array([stop.time]))[0]].any() for stop in stops]
    stops = [stop for stop, rests in zip(stops, at_rest, strict=True) if rests][-1 - STOPS :]
    if len(stops) <= STOPS:
        return False
    sizes = np.array(system.scales(), dtype=float)
    kept = [i for i, name in enumerate(system.state_names) if name != system.cyclic]
    rates = [system.rates(stop.time, tuple(stop.state.values()), (0,) * len(system.laws)) for stop in stops]
    speeds = np.max(np.abs(np.array(rates, dtype=float) / sizes)[:, kept], axis=1)
    lengths = np.diff([stop.time for stop in stops])
    if not np.all(speeds > 0.0):
        return False
    shares = speeds[1:] / speeds[:-1]
    return bool(np.all(shares <= NEARER) and np.ptp(shares) <= ALIKE * shares[-1] and np.all(np.diff(lengths) > 0.0))


def _rubs_as_it_holds(system: System) -> bool:
    """Whether contacts hold no more at rest than they rub in the slowest slide, which alone is set-valued then."""
    for law, load in zip(system.laws, system.law_loads, strict=True):
        if law.kind != "set-valued":
            return False
        limit, middle = law.holding_limit(load), law.holding_centre(load)
        slowest = [law.force(0.0, (0.0,) * len(law.internal), side, load)[0] for side in (1, -1)]
        if max(middle + limit - slowest[0], slowest[1] - (middle - limit)) > EXCESS * limit:
            return False
    return True
