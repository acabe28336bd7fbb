"""The mode of a contact, and all ways from one to another.

    side    transition      the contact
    +1, -1  MODE_HOLDS      slides
    +1, -1  k = 1 .. ORDER  leaves rest, or turns: the first k coefficients of its velocity vanish
    0       MODE_HOLDS      sticks
    0       ARRIVED         rests; forces are to decide whether it sticks (`decision.py`; of one alone, its series)
    0       TIED            rests; forces are too near a limit, so the series of the sticking force decides
    0       TIED - k        rests beside others at a distance that changes: k coefficients of its velocity vanish

    from            by                                     to
    slides          `arrive`: its velocity vanishes        ARRIVED
    slides          `slide`: a kinked law passes rest      k = 1 of the other side
    sticks          `await_decision`: its force jumped     ARRIVED
    sticks          `give_way`: its limit is reached       k = 2
    TIED            its distance to others changes         TIED - k
    any below 0     the decision                           TIED, sticks, or `give_way` with k = 1 or more
    leaves rest     the velocity grows to the other side   ARRIVED, or k = 1 of the other side
    any             `settle`: a step                       MODE_HOLDS

Two memories of the instant: `came_from`, the side of one that has arrived, until it is decided; and of several contacts
`gave_way`, by which the largest force that friction can hold is the kinetic one until time advances.
"""

from vibrocap.numerics.kernel.codes import REVERSAL, SLIP_BACK, SLIP_FORWARD, STICK, TOO_MANY_EVENTS
from vibrocap.numerics.kernel.generated import *

MODE_HOLDS, ARRIVED, TIED = 0, -1, -2
UNRECORDED = 9.0  # a side that is none: the sides at the start are no events


def await_decision(floats, ints, lane, c):
    """A contact rests, and is to be decided."""
    lane.side[c] = 0.0
    lane.transition[c] = ARRIVED


def arrive(floats, ints, lane, c):
    """A contact that slides has come to rest, and is to be decided."""
    lane.came_from[c] = lane.side[c]
    await_decision(floats, ints, lane, c)


def slide(floats, ints, lane, c, side, vanishing):
    """A contact at rest starts to slide; vanishing: how many leading coefficients of its velocity vanish."""
    lane.side[c] = side
    lane.transition[c] = vanishing


def give_way(floats, ints, lane, c, side, vanishing):
    """The same of a contact that rested; of several, the others find it with kinetic friction at this instant."""
    slide(floats, ints, lane, c, side, vanishing)
    if SEVERAL:
        lane.gave_way[c] = 1


def settle(ints, lane):
    """Time has advanced: nothing is known of the velocities but their signs."""
    for c in range(CONTACTS):
        lane.transition[c] = MODE_HOLDS
        if SEVERAL:
            lane.gave_way[c] = 0


def open_arrivals(ints, lane):
    """Whether a contact has come to rest, or parts from others, and is still to be decided."""
    arrived = False
    for c in range(CONTACTS):
        arrived = arrived or is_open(ints, lane, c)
    return arrived


def is_open(ints, lane, c):
    """Whether the decision is to be asked about a contact at rest."""
    return lane.transition[c] < MODE_HOLDS and lane.transition[c] != TIED


def change_of_side(floats, lane, c):
    """The kind of event by which a contact has come to its side from the one that was told last; -1: by none."""
    now, before = lane.side[c], lane.recorded_side[c]
    lane.recorded_side[c] = now
    if now == before or before == UNRECORDED or STICKS[c] + KINKS[c] == 0:
        return -1
    if now == 0.0:
        return STICK
    if before == 0.0:
        return SLIP_FORWARD if now > 0.0 else SLIP_BACK
    return REVERSAL


def too_many_events(ints, lane):
    """Count an event of the period; whether it is one too many, which ends the run."""
    lane.events += 1
    if lane.events > lane.event_limit:
        lane.status = TOO_MANY_EVENTS
    return lane.events > lane.event_limit
