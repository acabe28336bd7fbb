"""Choice of the step of a motion alone whose bristles may be on a slow manifold: explicit, or of the manifold.

See `slow_manifold.py`. A step on a manifold is implicit in what is slaved. It ends before its contact may turn, so that
every event of that is found by explicit steps. Events of other contacts are found in the series, as of any step.
"""

import math

from vibrocap.numerics.kernel.arithmetic.roots import later_terms
from vibrocap.numerics.kernel.generated.ensemble import GUESS, OWN_DECAY, PAUSE, SLOW, SWEEPS, WAIT
from vibrocap.numerics.kernel.generated.equations import jacobian, jet, slow_jet
from vibrocap.numerics.kernel.generated.facts import (
    FOLLOWS_LOAD,
    KINKS,
    MANIFOLDS,
    SEVERAL,
    SHARP,
    SHARP_INTERNAL,
    SLOW_CONTACT,
    SLOW_STATE,
    STATE_OF,
)
from vibrocap.numerics.kernel.generated.lane import DECAY_RATE, IMPLICIT_STEP, SIDE, STATE, STIFF, TIME
from vibrocap.numerics.kernel.generated.rows import VELOCITY, VELOCITY_OF
from vibrocap.numerics.kernel.generated.sizes import CONTACTS, LANES, ORDER, ROWS
from vibrocap.numerics.kernel.step.linear_system import JACOBIAN, POINT, WIDTH
from vibrocap.numerics.kernel.step.resolved import excursion, resolved, seen
from vibrocap.numerics.kernel.step.slow_manifold import (
    ENTERING,
    LONGEST_PAUSE,
    PAYING,
    follow_manifolds,
    settled_lanes,
    slow_lanes,
)
from vibrocap.numerics.kernel.step.stabilised import series_step

WORTH = 20.0  # fastest of several rates times the length of a step: from there on it is worth some sweeps
TOGETHER = 6.0  # ratio of rates up to which manifolds of several contacts are entered together
CUTS, CUT = 6, 0.6  # of a step within which a contact may turn, and their factor


def next_series(floats, ints):
    """Make the series of the present state: of the motion on its manifold, once its sweeps have settled, or of any."""
    while slow_lanes(floats):
        slow_jet(floats, 0)
        h = manifold_step(floats, ints)
        if h > 0.0:
            floats[IMPLICIT_STEP] = h
            return
    jet(floats)


def manifold_step(floats, ints):
    """Length of the step on the manifold of the series in memory; 0 where that is not a motion yet."""
    longest, _ = series_step(floats, ints, 0, math.inf)
    lasting = False
    for _ in range(CUTS):
        lasting = slides_last(floats, longest) and resolved_for_long(floats, longest)
        if lasting:
            break
        longest *= CUT
    if SEVERAL and leave_some(floats, longest):
        return 0.0  # the others on their own
    settled, near, far = settled_lanes(floats, longest, longest)
    far = far or fastest_decay(floats) * longest < WORTH
    if lasting and settled and near and not far and longest > 0.0:
        return longest
    follow_manifolds(floats, True, settled, near, far or not lasting, False, longest)
    return 0.0


def resolved_for_long(floats, h):
    """Whether the series sees all that the law holds over a step of length h, which may be long.

    A load that the motion makes has no bounds over ranges of speed: what is known of those says nothing then.
    """
    if not resolved(floats, 0, h):
        return False
    if SHARP_INTERNAL or not FOLLOWS_LOAD or not SHARP or floats[SIDE] == 0.0:
        return True
    return seen(floats, 0, h, excursion(floats, VELOCITY, h))


def leave_some(floats, h):
    """Whether a manifold is left that does not last a step of length h, or whose sweeps would not settle within it."""
    left = False
    for m in range(MANIFOLDS):
        if floats[SLOW + m] > 0.0 and not (slide_lasts_on(floats, m, h) and floats[OWN_DECAY + m] * h >= PAYING):
            left = True
            pause = max(floats[PAUSE + m], 1.0)
            floats[SLOW + m] = 0.0
            floats[SWEEPS + m] = 0.0
            floats[WAIT + m] = pause
            floats[PAUSE + m] = min(2.0 * pause, LONGEST_PAUSE)
    return left


def chosen_step(floats, ints, lane, remaining):
    """Length of the step of the series in memory."""
    ints[STIFF + lane] = 0
    if not slow_lanes(floats):
        return series_step(floats, ints, lane, remaining)[0]
    ints[STIFF + lane] = 1
    return floats[IMPLICIT_STEP + lane]


def follow_step(floats, event, h):
    """After a step of length h: whether a manifold is entered; what the series of the next step is guessed to be."""
    if slow_lanes(floats):
        follow_manifolds(floats, True, True, True, False, True, h)
    elif event == 0 and floats[DECAY_RATE] * h >= ENTERING:  # next to an event steps are explicit
        ready = True
        for m in range(MANIFOLDS):
            floats[WAIT + m] -= 1.0
            ready = ready and floats[WAIT + m] <= 0.0
        if ready:
            enter_manifolds(floats, h)


def enter_manifolds(floats, h):
    """Let the next series be that of manifolds, where decays towards them bound the length h of steps.

    Of several contacts the slower ones would bound the steps next: those whose rate is near the fastest enter with it.
    """
    for i in range(ROWS):
        floats[POINT + i] = floats[STATE + i]
    jacobian(floats, floats[TIME], POINT, floats[SIDE], 0, JACOBIAN)
    least = ENTERING
    if SEVERAL:
        fastest = 0.0
        for m in range(MANIFOLDS):
            fastest = max(fastest, -floats[JACOBIAN + SLOW_STATE[m] * (WIDTH + 1)] * h)
        if fastest >= ENTERING:
            least = fastest / TOGETHER
    for m in range(MANIFOLDS):
        rate = -floats[JACOBIAN + SLOW_STATE[m] * (WIDTH + 1)]
        if rate * h >= least and (SEVERAL or not slow_lanes(floats)):
            floats[SLOW + m] = 1.0
            floats[SWEEPS + m] = 0.0
            for k in range(ORDER + 1):
                floats[GUESS + m * (ORDER + 1) + k] = 0.0


def fastest_decay(floats):
    """Largest rate of decay to a manifold that the motion is on."""
    fastest = 0.0
    for m in range(MANIFOLDS):
        if floats[SLOW + m] > 0.0:
            fastest = max(fastest, floats[OWN_DECAY + m])
    return fastest


def slides_last(floats, h):
    """Whether no contact that is on a manifold may turn within a step of length h."""
    last = True
    for m in range(MANIFOLDS):
        last = last and (floats[SLOW + m] == 0.0 or slide_lasts_on(floats, m, h))
    return last


def slide_lasts_on(floats, m, h):
    """Whether no contact may turn whose bristles, or whose velocity, manifold m slaves."""
    last = True
    for c in range(CONTACTS):
        if KINKS[c] == 1 and (c == SLOW_CONTACT[m] or STATE_OF[c] == SLOW_STATE[m]):
            last = last and slide_lasts(floats, VELOCITY_OF[c], floats[SIDE + c * LANES], h)
    return last


def slide_lasts(floats, row, side, h):
    """Whether side times a velocity stays above zero over a step: its first four terms above the sum of all others.

    As Bernstein coefficients those four are a bound from below, see `roots.py`.
    """
    others = later_terms(floats, row, ORDER, 4, h) * h * h
    first, second = side * floats[row], side * floats[row + LANES] * h
    third, fourth = side * floats[row + 2 * LANES] * h * h, side * floats[row + 3 * LANES] * h**3 - others
    early = first + second * (1.0 / 3.0)
    late = early + (second + third) * (1.0 / 3.0)
    return min(first, early) > 0.0 and min(late, first + second + third + fourth) > 0.0
