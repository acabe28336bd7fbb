"""Itineraries of steady motions: the modes of the contacts over one response in order, and what changes them.

A mode sequence is written in the letters F (forward), S (stuck) and B (back); `Orbit.mode_sequence` shows it.
"""

import enum
import itertools

from vibrocap.measures.recorded.sticking import BETWEEN, as_cycle, by_contact

MIRROR_LETTERS = str.maketrans("FB", "BF")
MOST_PHASES = 3  # that one change may take out of a sequence


class ModeChange(enum.Enum):
    """What happens where a mode sequence changes, after the phase that appears or vanishes and its neighbours."""

    CROSSING = "crossing"  # rest between sliding one way and the other: FSB, FB
    GRAZING = "grazing"  # the velocity touches zero within a slide: FSF or FBF, F
    SPLITTING = "splitting"  # a short slip within a rest: SFS, S
    SWITCHING = "switching"  # a rest is left the one way or the other: SFB, SB
    UNNAMED = "unnamed"  # more than one change at one place


def closed_sequence(sequence: str, half: bool = False) -> str:
    """The sequence of a whole response from that of a run over it, or over its first half before the mirror."""
    whole = sequence + sequence.translate(MIRROR_LETTERS) if half else sequence
    return as_cycle([letter for letter, _ in itertools.groupby(whole)])


def same_cycle(one: str, other: str) -> bool:
    """Whether two words are the same cycle of phases at each contact, begun at different sections."""
    pairs = zip(by_contact(one), by_contact(other), strict=True)
    return all(len(before) == len(after) and after in before + before for before, after in pairs)


def mode_change(before: str, after: str) -> tuple[ModeChange, str]:
    """(kind, in words) of the change from one cycle of phases to another; of several contacts, at that which changes.

    Where several change at once, it is unnamed unless all do alike.
    """
    pairs = enumerate(zip(by_contact(before), by_contact(after), strict=True), 1)
    changes = {i: _change(*pair) for i, pair in pairs if BETWEEN not in before or not same_cycle(*pair)}
    kinds = {kind for kind, _ in changes.values()}
    words = (f"{text} at contact {i}" if BETWEEN in before else text for i, (_, text) in changes.items())
    return kinds.pop() if len(kinds) == 1 else ModeChange.UNNAMED, "; ".join(words)


def _change(before: str, after: str) -> tuple[ModeChange, str]:
    """The same of one contact. A phase that vanishes takes one neighbour along where both are alike."""
    longer, shorter = (before, after) if len(before) >= len(after) else (after, before)
    verb, fewer = "vanish" if longer is before else "appear", len(longer) - len(shorter)
    alike: dict[tuple[ModeChange, bool], list[int]] = {}
    for i, letter in enumerate(longer):
        alike.setdefault((_kind(longer, i), letter == "S"), []).append(i)
    for count in range(max(1, (fewer + 1) // 2), min(fewer, MOST_PHASES) + 1):
        names = []
        for (kind, sticks), places in alike.items():
            choices = itertools.combinations(places, count)
            if phases := next((left for left in choices if same_cycle(_without(longer, left), shorter)), None):
                names.append((phases, kind, sticks))
        if names:
            _, kind, sticks = min(names, key=lambda change: change[0])
            phase = "stick phase" if sticks else "slip phase"
            if count == 1:
                return kind, f"a {phase} {verb}{'es' if verb == 'vanish' else 's'}"
            return kind, f"{('two', 'three')[count - 2]} {phase}s {verb}"
    return ModeChange.UNNAMED, "several phases change at once"


def _without(sequence: str, phases: tuple[int, ...]) -> str:
    """The cycle without these phases, whose neighbours become one where they are alike."""
    starts, ends = (0, *(i + 1 for i in phases)), (*phases, len(sequence))
    rest = "".join(sequence[start:end] for start, end in zip(starts, ends, strict=True))
    for letter in "FSB":
        while 2 * letter in rest:
            rest = rest.replace(2 * letter, letter)
    return rest[:-1] if len(rest) > 1 and rest[0] == rest[-1] else rest


def _kind(sequence: str, i: int) -> ModeChange:
    """What happens where phase i of a cycle vanishes."""
    before, phase, after = sequence[i - 1], sequence[i], sequence[(i + 1) % len(sequence)]
    if before != after:
        return ModeChange.CROSSING if phase == "S" else ModeChange.SWITCHING
    return ModeChange.SPLITTING if before == "S" else ModeChange.GRAZING
