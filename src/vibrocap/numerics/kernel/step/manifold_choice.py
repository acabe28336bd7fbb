"""Choice of the step of a motion alone whose bristles may be on a slow manifold: explicit, or of the manifold.

See `slow_manifold.py`. A step on a manifold is implicit in what is slaved. It ends before its contact may turn, so that
every event of that is found by explicit steps. Events of other contacts are found in the series, as of any step.
"""

import math

from vibrocap.numerics.kernel.arithmetic.roots import later_terms
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import alone, at
from vibrocap.numerics.kernel.step.linear_system import JACOBIAN, POINT, WIDTH
from vibrocap.numerics.kernel.step.resolved import excursion, resolved, seen
from vibrocap.numerics.kernel.step.slow_manifold import (
    CUT,
    ENTERING,
    LONGEST_PAUSE,
    PAYING,
    follow_manifolds,
    settled_lanes,
    slow_lanes,
)
from vibrocap.numerics.kernel.step.stabilised import PLAIN_REACH, series_step
from vibrocap.numerics.kernel.step.taylor import least_of_four, write_state

WORTH = 20.0  # fastest of several rates times the length of a step: from there on it is worth some sweeps
TOGETHER = 6.0  # ratio of rates up to which manifolds of several contacts are entered together
LOOK = 8.0  # steps between two looks at the rates where one is refused: the Jacobian costs a tenth of a step
SHARE_OF_PERIOD = 0.125  # longest step of a motion on its slow manifold, about: a pair that does not pay over it waits


def next_series(floats, ints):
    """Make the series of the present state: of the motion on its manifold, once its sweeps have settled, or of any."""
    while slow_lanes(floats):
        slow_jet(floats, 0)
        h = manifold_step(floats, ints)
        if h > 0.0:
            alone.implicit_step = h
            return
    jet(floats)


def manifold_step(floats, ints):
    """Length of the step on the manifold of the series in memory; 0 where that is not a motion yet."""
    longest = min(series_step(floats, ints, 0, math.inf)[0], alone.period)
    lasting = lasts(floats, longest)
    while not lasting and pays(floats, longest):
        longest *= CUT
        lasting = lasts(floats, longest)
    if SEVERAL and leave_some(floats, longest):
        return 0.0  # the others on their own
    settled, near, far = settled_lanes(floats, longest, longest)
    far = far or fastest_decay(floats) * longest < WORTH
    if lasting and settled and near and not far and longest > 0.0:
        return longest
    pair = PAIR and alone.slow[0] > 0.0 and alone.slow[1] > 0.0
    wait, pause = alone.wait[0], alone.pause[0]
    follow_manifolds(floats, True, (settled, near, far or not lasting), False, longest, 0.0)
    if pair:  # creep says nothing of slides
        alone.wait[0], alone.pause[0] = wait, pause
    return 0.0


def lasts(floats, h):
    """Whether a step of length h sees all of the law, and no contact on a manifold can turn."""
    last = True
    for m in range(MANIFOLDS):
        last = last and (alone.slow[m] == 0.0 or slide_lasts_on(floats, m, h))
    return last and resolved_for_long(floats, h)


def resolved_for_long(floats, h):
    """Whether the series sees all that the law holds over a step of length h, which may be long.

    A load that the motion makes has no bounds over ranges of speed: what is known of those says nothing then.
    """
    if not resolved(floats, 0, h):
        return False
    if SHARP_INTERNAL or not FOLLOWS_LOAD or not SHARP or alone.side[SHARP_CONTACT] == 0.0:
        return True
    return seen(floats, 0, h, excursion(floats, at.velocity_row[SHARP_CONTACT], h))


def pays(floats, h):
    """Whether a step of length h pays on the manifolds that the series in memory is on."""
    enough = True
    for m in range(MANIFOLDS):
        enough = enough and (alone.slow[m] == 0.0 or alone.own_decay[m] * h >= PAYING)
    return enough


def leave_some(floats, h):
    """Whether a manifold is left that does not last a step of length h, or whose sweeps would not settle within it."""
    left = False
    for m in range(MANIFOLDS):
        if alone.slow[m] > 0.0 and not (slide_lasts_on(floats, m, h) and alone.own_decay[m] * h >= PAYING):
            left = True
            pause = max(alone.pause[m], 1.0)
            alone.slow[m] = 0.0
            alone.sweeps[m] = 0.0
            alone.wait[m] = pause
            alone.pause[m] = min(2.0 * pause, LONGEST_PAUSE)
    return left


def step_length(floats, ints, lane, remaining):
    """Length of the step of the series in memory."""
    lane.stiff = 0
    if not slow_lanes(floats):
        return series_step(floats, ints, lane, remaining)[0]
    lane.stiff = 1
    return lane.implicit_step


def follow_step(floats, event, h):
    """After a step of length h: whether a manifold is entered; what the series of the next step is guessed to be."""
    if slow_lanes(floats):
        follow_manifolds(floats, True, (True, True, False), True, h, 0.0)
    elif event == 0 and alone.decay_rate * h >= tried_from(floats):  # next to an event steps are explicit
        waiting = 0
        for m in range(MANIFOLDS):
            if alone.decay_rate * h >= ENTERING or m == 1:
                alone.wait[m] -= 1.0
            waiting += 1 if alone.wait[m] > 0.0 else 0
        if waiting == 0 or (not SEVERAL and waiting < MANIFOLDS):
            enter_manifolds(floats, h)


def tried_from(floats):
    """Rate times length of an explicit step from which on manifolds are tried.

    An oscillation is not damped to the reach of a decay; it decays at half the sum of both rates at most.
    """
    if PAIR and 0.5 * alone.decay_rate * SHARE_OF_PERIOD * alone.period >= PAYING:
        return PLAIN_REACH
    return ENTERING


def enter_manifolds(floats, h):
    """Let the next series be that of manifolds, where decays towards them bound the length h of steps.

    Of several contacts the slower ones would bound the steps next: those whose rate is near the fastest enter with it.
    Of a contact that creeps velocity and bristle may be one damped oscillation, or decay nearly as fast as each other.
    Out of such a pair none is slaved alone, as the other still bounds the step; where that would not pay, both are.
    """
    write_state(floats, 0, POINT)
    jacobian(floats, alone.time, POINT, 0, JACOBIAN)
    if PAIR:
        one, two = JACOBIAN + SLOW_STATE[0] * WIDTH, JACOBIAN + SLOW_STATE[1] * WIDTH
        trace = -floats[one + SLOW_STATE[0]] - floats[two + SLOW_STATE[1]]
        product = floats[one + SLOW_STATE[0]] * floats[two + SLOW_STATE[1]]
        product -= floats[one + SLOW_STATE[1]] * floats[two + SLOW_STATE[0]]
        pays_over = SHARE_OF_PERIOD * alone.period
        if product * PAYING > PLAIN_REACH * trace * trace and product * pays_over >= PAYING * trace:
            if alone.wait[1] <= 0.0:
                enter(floats, 0)
                enter(floats, 1)
            return
        if alone.decay_rate * h < ENTERING:
            return
    if SEVERAL:
        fastest = 0.0
        for m in range(MANIFOLDS):
            fastest = max(fastest, -floats[JACOBIAN + SLOW_STATE[m] * (WIDTH + 1)] * h)
        least = fastest / TOGETHER if fastest >= ENTERING else ENTERING
        for m in range(MANIFOLDS):
            if -floats[JACOBIAN + SLOW_STATE[m] * (WIDTH + 1)] * h >= least:
                enter(floats, m)
        return
    waits = False
    for m in range(MANIFOLDS):
        rate = -floats[JACOBIAN + SLOW_STATE[m] * (WIDTH + 1)]
        if rate * h >= ENTERING and alone.wait[m] <= 0.0:
            enter(floats, m)
            return
        waits = waits or alone.wait[m] > 0.0
    if waits:  # what bounds the step is one that has been refused
        for m in range(MANIFOLDS):
            if alone.wait[m] <= 0.0:
                alone.wait[m] = LOOK


def enter(floats, m):
    """Let the next series be that of a manifold, of which nothing is guessed."""
    alone.slow[m] = 1.0
    alone.sweeps[m] = 0.0
    for k in range(ORDER + 1):
        floats[alone.guess_row[m] + k] = 0.0


def fastest_decay(floats):
    """Largest rate of decay to a manifold that the motion is on."""
    fastest = 0.0
    for m in range(MANIFOLDS):
        if alone.slow[m] > 0.0:
            fastest = max(fastest, alone.own_decay[m])
    return fastest


def slide_lasts_on(floats, m, h):
    """Whether no contact may turn whose bristles, or whose velocity, manifold m slaves."""
    last = True
    for c in range(CONTACTS):
        if KINKS[c] == 1 and (c == SLOW_CONTACT[m] or STATE_OF[c] == SLOW_STATE[m]):
            last = last and slide_lasts(floats, at.velocity_row[c], alone.side[c], h)
    return last


def slide_lasts(floats, row, side, h):
    """Whether side times a velocity stays above zero over a step: its first four terms above the sum of all others."""
    others = later_terms(floats, row, ORDER, 4, h) * h * h
    first, second = side * floats[row], side * floats[row + LANES] * h
    third, fourth = side * floats[row + 2 * LANES] * h * h, side * floats[row + 3 * LANES] * h**3 - others
    return least_of_four(first, second, third, fourth) > 0.0
