"""Sticking: how much of the time, how often, how long, and the mode sequence of a period."""

import dataclasses
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_number, shown
from vibrocap.measures.recorded.windows import period_times, window_times
from vibrocap.motion.trajectory import BACK, FORWARD, STUCK, Phase, Trajectory
from vibrocap.numerics import api as numerics
from vibrocap.physics.names import numbered
from vibrocap.quantities.declared import Number, Speed, Time
from vibrocap.quantities.dimensional import Dimensional

LETTERS = {FORWARD: "F", STUCK: "S", BACK: "B"}


@dataclasses.dataclass(frozen=True)
class StickPhases(Dimensional):
    """Stretches of sticking within a window; those that it cuts count with the part inside."""

    number: int
    lengths: tuple[Time, ...]
    total: Time
    longest: Time


def stick_phases(
    motion: Trajectory, window: tuple[Time, Time] | None = None, *, periods: int | None = None, contact: int = 1
) -> StickPhases | None:
    """Number and lengths of the phases in which the contact sticks, over a window (`windows.window_times`).

    None where the law cannot stick: with a law that gives a force for every velocity (LuGre), rest is passed through at
    an instant and never held, so "0" would claim something that was not looked at.
    contact: which of the contacts of the machine
    """
    start, end = window_times(motion, window, periods)
    if law_of(motion, contact).kind != "set-valued":
        return None
    lengths = tuple(phase.length for phase in _phases(motion, start, end, contact) if phase.side == STUCK)
    return StickPhases(len(lengths), lengths, sum(lengths), max(lengths, default=0.0))


def stick_fraction(
    motion: Trajectory,
    window: tuple[Time, Time] | None = None,
    *,
    periods: int | None = None,
    contact: int = 1,
    below: Speed | None = None,
) -> Number | None:
    """Share of a window in which a contact sticks; None where its law cannot stick (`stick_phases`).

    below: a sliding speed; the share of the window in which the contact is slower is then the answer, for any law
    """
    start, end = window_times(motion, window, periods)
    if below is not None:
        if not (is_number(below) and 0.0 < below < math.inf):
            raise ArgumentError("below", f"should be a sliding speed greater than 0, got {shown(below)}")
        law_of(motion, contact)  # there is one
        name = numbered("contact_velocity", contact)
        passed = np.concatenate([motion.crossings(name, value) for value in (below, -below)])
        times = np.array([start, *np.sort(passed[(passed > start) & (passed < end)]), end])
        slow = np.abs(motion.at((times[:-1] + times[1:]) / 2.0, name)) < below
        return float(np.sum(np.diff(times)[slow]) / (end - start))
    phases = stick_phases(motion, (start, end), contact=contact)
    return None if phases is None else phases.total / (end - start)


def mode_sequence(motion: Trajectory, period: int = -1, *, contact: int = 1) -> str:
    """The mode sequence of one whole period: F sliding forward, S stuck, B sliding back, such as "FSBS".

    It is read as a cycle from the period's start: a last phase on the side of the first is the same phase of a steady
    motion, cut by the period's mark, and is left out. A law that cannot stick spells with F and B alone.

    contact: which, of a machine with several
    Raises ValueError for a contact that there is not, and for a smooth law, whose motion passes through rest unnoticed.
    """
    law = law_of(motion, contact)
    if law.kind == "smooth":
        raise ValueError(f"the {law.name} law is smooth: changes of its side are not recorded")
    return spelled(motion, *period_times(motion, period), contact)


def spelled(motion: Trajectory, start: float, end: float, contact: int) -> str:
    """The mode sequence of the phases of a contact from start to end, read as a cycle (`mode_sequence`)."""
    return as_cycle([LETTERS[phase.side] for phase in _phases(motion, start, end, contact)])


def spelled_all(motion: Trajectory) -> str:
    """The mode sequences of all contacts over a motion as one text, see `joined`."""
    return joined(
        "" if law.kind == "smooth" else spelled(motion, 0.0, motion.end, contact)
        for contact, law in enumerate(motion.system.laws, 1)
    )


BETWEEN = "|"  # the sequences of two contacts


def joined(sequences: Iterable[str]) -> str:
    """The mode sequences of all contacts, the first one first: "FSB|FB" of two. "" where no contact has one."""
    return BETWEEN.join(value) if any(value := [*sequences]) else ""


def by_contact(sequences: str) -> list[str]:
    """The mode sequence of each contact, of those `joined`."""
    return sequences.split(BETWEEN)


def as_cycle(letters: list[str]) -> str:
    """The sequence of these letters where the last phase continues in the first one."""
    while len(letters) > 1 and letters[-1] == letters[0]:
        letters.pop()
    return "".join(letters)


def first_turned(sequence: str) -> str:
    """The same cycle of phases, begun at the place that comes first in the alphabet: alike for all sections."""
    return min((sequence[i:] + sequence[:i] for i in range(len(sequence))), default="")


def law_of(motion: Trajectory, contact: int) -> Any:
    """The law of a contact; ArgumentError for one that there is not."""
    laws = motion.system.laws
    if contact not in range(1, len(laws) + 1):
        raise ArgumentError("contact", f"should be a whole number from 1 to {len(laws)}, got {shown(contact)}")
    return laws[contact - 1]


def _phases(motion: Trajectory, start: float, end: float, contact: int) -> list[Phase]:
    cut = (Phase(max(phase.start, start), min(phase.end, end), phase.side) for phase in motion.phases_of(contact))
    return [phase for phase in cut if phase.length > numerics.SLIVER * motion.period]
