"""Series on a slow manifold, in lanes or alone: bristles that have relaxed follow the velocity and bound no step.

Bristles relax at rates far above those of the motion. Once they have, they are a function of the slow states, whose
series is found by sweeps (see `codegen/slow_manifold.py`), each from the one before; an accepted step leaves the series
of its end as the guess of the next. A lane whose sweeps have not settled does not advance. A contact is taken to its
manifold where stability bounds the step, contact by contact, and leaves it where it may turn, where anything else is to
be decided, or where

- the sweeps do not settle: two in a row differ by more than a share of the tolerance;
- the state is not on the manifold, but off by more than the tolerance: it has not relaxed yet;
- it does not pay.
"""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import bits, load, store, where
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import at, lanes
from vibrocap.numerics.kernel.step.taylor import unlike

# A motion alone costs some sweeps before its step. Lanes that are not on manifolds wait for the sweeps of those that
# are, so that those of one contact, where explicit steps are longest, are slow to try again. Of several contacts
# explicit steps are shorter, and one that creeps changes that often.
KIND = (2 if LANES > 1 else 0) + (1 if SEVERAL else 0)  # alone with one contact, with several; in lanes likewise
ENTERING = (10.0, 4.0, 10.0, 8.0)[KIND]  # rate times length of an explicit step from which on the manifold is tried
PAYING = (60.0, 8.0, 60.0, 20.0)[KIND]  # that of a step on the manifold from which it pays
LONGEST_PAUSE = (64.0, 16.0, 128.0, 64.0)[KIND]  # steps after failures
FIRST_PAUSE = (1.0, 1.0, 16.0, 1.0)[KIND]
KEPT_PAUSE = (0.0, 0.0, 0.5, 0.0)[KIND]  # share of a pause that a step that pays leaves
LIKELY_STEP = (1.0, 1.0, 0.01, 1.0)[KIND]  # of a period: the step that would have to pay, few are longer
SETTLED = 0.3  # of the tolerance: by how much a sweep may differ from the next
EARLY, FAR_OFF = 4.0, 1e3  # sweeps after which it is clear that the state is so many tolerances off
MOST_SWEEPS = ORDER + 3.0
CUT = 0.6  # of a step within which a contact may turn, or which does not see all of the law


def slow_lanes(floats):
    """Lanes on the manifold of any contact."""
    slow = lanes.tolerance < 0.0
    for m in range(MANIFOLDS):
        if SLOW_STATE[m] >= 0:
            slow = slow | (lanes.slow[m] > 0.0)
    return slow


def settled_lanes(floats, h, longest):
    """(lanes whose sweeps have settled, lanes that are on their manifolds, lanes that are far off or do not pay)."""
    settled = lanes.tolerance > 0.0
    near = settled
    far = unlike(settled)
    for m in range(MANIFOLDS):
        if SLOW_STATE[m] >= 0:
            slow = lanes.slow[m] > 0.0
            row, guess = at.row[SLOW_STATE[m]], at.guess_row[m]
            allowed = lanes.tolerance * lanes.scale[SLOW_STATE[m]]
            change = abs(load(floats, row + ORDER * LANES) - load(floats, guess + ORDER * LANES))
            for k in range(ORDER - 1, 0, -1):
                change = change * h + abs(load(floats, row + k * LANES) - load(floats, guess + k * LANES))
            gap = abs(load(floats, row) - lanes.state[SLOW_STATE[m]])
            rate = lanes.own_decay[m]
            far = far | (slow & unlike(rate * longest >= PAYING))
            tight, on = change * ORDER <= SETTLED * allowed * rate, gap <= allowed
            close = gap <= FAR_OFF * allowed
            # all other states keep to the tolerance, too
            bound, kick = lanes.tolerance * rate, gap * lanes.kick[m]
            tight = tight & (change * h * lanes.drift[m] * ORDER <= SETTLED * bound)
            on, close = on & (kick <= bound), close & (kick <= FAR_OFF * bound)
            settled = settled & (unlike(slow) | tight)
            near = near & (unlike(slow) | on)
            late = lanes.sweeps[m]
            far = far | (slow & (late >= EARLY) & unlike(close)) | (slow & (late >= MOST_SWEEPS))
    return settled, near, far


def follow_manifolds(floats, slow, judged, plain, h, free):
    """After a step of length h of the lanes `plain`: who enters a manifold or leaves it; guesses of the next series.

    judged: what `settled_lanes` tells; free: length that the error alone allows a lane that is on a manifold, else 0. A
    contact on none bounds the steps of its lane by its own rate: by those steps it would never enter, see worms of five
    bodies.
    """
    for m in range(MANIFOLDS):
        if SLOW_STATE[m] >= 0:
            was, wait = lanes.slow[m] > 0.0, lanes.wait[m]
            rate = lanes.own_decay[m]
            worth = (rate * h >= ENTERING) | (rate * free >= PAYING)
            enters = plain & unlike(was) & (wait <= 0.0) & worth
            if LIKELY_STEP < 1.0:
                enters = enters & (LIKELY_STEP * rate * lanes.period >= PAYING)
            if bits(slow | enters) == 0:
                store(floats, at.wait[m], where(plain, wait - 1.0, wait))
            else:
                follow_manifold(floats, m, slow, judged, plain, enters, h)


def follow_manifold(floats, m, slow, judged, plain, enters, h):
    """The same of one manifold that some lane is on or enters."""
    settled, near, far = judged
    was, wait = lanes.slow[m] > 0.0, lanes.wait[m]
    waiting = slow & unlike(settled | far)
    left = slow & unlike(plain | waiting)
    pays = plain & was
    pause = lanes.pause[m]
    pause = where(pause > 0.0, pause, FIRST_PAUSE)
    failed = was & left & (far | unlike(settled & near))
    moved = where(plain, wait - 1.0, wait)
    moved = where(was & left, 1.0, moved)
    moved = where(failed, pause, moved)
    store(floats, at.wait[m], moved)
    longer = where(2.0 * pause < LONGEST_PAUSE, 2.0 * pause, LONGEST_PAUSE)
    shorter = where(KEPT_PAUSE * pause > 1.0, KEPT_PAUSE * pause, 1.0)
    store(floats, at.pause[m], where(failed, longer, where(pays, shorter, pause)))
    stays = was & unlike(left)
    sweeps = lanes.sweeps[m]
    store(floats, at.sweeps[m], where(waiting, sweeps + 1.0, 0.0))
    store(floats, at.slow[m], where(stays | enters, 1.0, 0.0))
    guess_series(floats, m, was & waiting, was & plain, enters, h)


def guess_series(floats, m, again, moved, enters, h):
    """The guess of the next sweep: the present series, the same from the end of a step of length h on, or none."""
    row, guess = at.row[SLOW_STATE[m]], at.guess_row[m]
    if bits(again | moved | enters) == 0:
        return
    for k in range(ORDER + 1):
        kept = where(again | moved, load(floats, row + k * LANES), load(floats, guess + k * LANES))
        store(floats, guess + k * LANES, where(enters, 0.0, kept))
    if bits(moved) != 0:
        shift = where(moved, h, 0.0)
        for first in range(ORDER):
            upper = load(floats, guess + ORDER * LANES)
            for k in range(ORDER - 1, first - 1, -1):
                upper = load(floats, guess + k * LANES) + shift * upper
                store(floats, guess + k * LANES, upper)
