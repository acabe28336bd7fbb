"""Where the word changes between two neighbouring points of a branch: each change bracketed to rounding."""

import itertools

from vibrocap.orbits.continuation.segment import Lost, Segment
from vibrocap.orbits.maps.itinerary import cycle

MOST_CHANGES = 12  # within one step of a branch
SHORTEST = 1e-6  # share of a segment within which no further changes are looked for
PROBES = (0.08, 0.17, 0.26, 0.35, 0.43, 0.54, 0.63, 0.72, 0.81, 0.9, 0.97)  # shares of a step that is looked at closely
TOO_MANY = "the word changes more often than it can be located"
NOT_CLOSED = "the word changes, but orbits in between do not close"
JUMPS = "the word changes where the orbits jump"


def word_cuts(segment: Segment, closely: bool = False) -> tuple[list[tuple[float, float]], str]:
    """(changes as pairs of shares as near as can be, why there may be others: empty if all were located).

    A change is bracketed by bisection. Bisection sees one where there are three: the middle of each stretch that it
    leaves is looked at too, and if its word is another, the search goes on there.

    closely: look between points of the same word too, since there were too many changes here for a longer step
    """
    found: list[tuple[float, float]] = []
    try:
        marks = (0.0, *(PROBES if closely else ()), 1.0)
        complaint = next(filter(None, (_cut(segment, *pair, found) for pair in itertools.pairwise(marks))), "")
    except Lost:
        complaint = NOT_CLOSED
    return sorted(found), complaint


def _cut(segment: Segment, left: float, right: float, found: list[tuple[float, float]]) -> str:
    """Bracket the changes between two shares whose words differ; returns why it was given up."""
    here, there = _word(segment, left), _word(segment, right)
    if here == there:
        return ""
    if len(found) >= MOST_CHANGES:
        return TOO_MANY
    before, after = segment.change(lambda point: cycle(point.closing.word) == here, left, right)
    if segment.torn(before, after):
        return JUMPS
    found.append((before, after))
    for first, last in ((left, before), (after, right)):
        middle = 0.5 * (first + last) if last - first > SHORTEST else first
        for begin, end in ((first, middle), (middle, last)):
            if begin < end and (complaint := _cut(segment, begin, end, found)):
                return complaint
    return ""


def _word(segment: Segment, share: float) -> str:
    return cycle(segment.point(share).closing.word)
