"""Returns to a section: where in the state space the turns of a motion are counted, and after how many it repeats."""

import dataclasses
import math
from collections.abc import Iterator
from typing import Annotated, Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_number, listed, suggestion
from vibrocap.motion.recording.equations import equations
from vibrocap.motion.recording.section import section_states
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.events import CONTACT, IMPACT
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
        """When a motion passes the section."""
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
            asked = Section(
                observable=observable.strip(), value=float(value), direction=WAYS[direction.strip() or "up"]
            )
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
    known = (*system.state_names, *equations(system).observables)
    if asked.observable not in known or asked.observable == system.cyclic:
        useful = [name for name in known if name != system.cyclic]
        why = suggestion(asked.observable, useful)
        raise ArgumentError("section.observable", f"{asked.observable!r} is none that comes back; {why}")
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

    times: [returns + 1] of the passages; most: returns of a cycle
    Distances are over the range of each state in the second half of the motion, which does not depend on natural sizes.
    """
    sizes = np.array(motion.system.scales(), dtype=float)
    late = motion.piece_start[len(motion.piece_start) // 2 :]
    extents = np.ptp(section_states(motion.system, motion.states(late).T, sizes), axis=0)
    where = section_states(motion.system, motion.states(times[-1 - most :]).T, sizes)
    extents[extents == 0.0] = 1.0
    away = np.max(np.abs(where[-2::-1] - where[-1]) / extents, axis=1)
    n = int(np.flatnonzero(away <= max(2.0 * np.min(away), ARRIVED))[0])
    return n + 1, float(away[n])
