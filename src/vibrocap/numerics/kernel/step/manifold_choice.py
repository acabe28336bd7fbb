"""Choice of the step of a motion alone whose bristles may be on a slow manifold: explicit, or of the manifold.

See `slow_manifold.py`. A step on a manifold is implicit in what is slaved. It ends before its contact may turn, so that
every event of that is found by explicit steps.
"""

from vibrocap.numerics.kernel.arithmetic.roots import later_terms
from vibrocap.numerics.kernel.generated.ensemble import GUESS, OWN_DECAY, PAUSE, SLOW, SWEEPS, WAIT
from vibrocap.numerics.kernel.generated.equations import jacobian, jet, slow_jet
from vibrocap.numerics.kernel.generated.facts import MANIFOLDS, PAIR, SLOW_STATE
from vibrocap.numerics.kernel.generated.lane import DECAY_RATE, IMPLICIT_STEP, PERIOD, SIDE, STATE, STIFF, TIME
from vibrocap.numerics.kernel.generated.rows import VELOCITY
from vibrocap.numerics.kernel.generated.sizes import LANES, ORDER, ROWS
from vibrocap.numerics.kernel.step.linear_system import JACOBIAN, POINT, WIDTH
from vibrocap.numerics.kernel.step.resolved import resolved
from vibrocap.numerics.kernel.step.slow_manifold import ENTERING, PAYING, follow_manifolds, settled_lanes, slow_lanes
from vibrocap.numerics.kernel.step.stabilised import PLAIN_REACH, series_step
from vibrocap.numerics.kernel.step.taylor import taylor_step

LOOK = 8.0  # steps between two looks at the rates where one is refused: the Jacobian costs a tenth of a step
SHARE_OF_PERIOD = 0.125  # longest step of a motion on its slow manifold, about: a pair that does not pay over it waits
CUT = 0.6  # of a step within which a contact may turn, or which does not see all of the law


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
    longest = min(taylor_step(floats, ints, 0), floats[PERIOD])
    lasting = lasts(floats, longest)
    while not lasting and pays(floats, longest):
        longest *= CUT
        lasting = lasts(floats, longest)
    settled, near, far = settled_lanes(floats, longest, longest)
    if lasting and settled and near and not far and longest > 0.0:
        return longest
    pair = PAIR and floats[SLOW] > 0.0 and floats[SLOW + 1] > 0.0
    wait, pause = floats[WAIT], floats[PAUSE]
    follow_manifolds(floats, True, settled, near, far or not lasting, False, longest)
    if pair:  # creep says nothing of slides
        floats[WAIT], floats[PAUSE] = wait, pause
    return 0.0


def lasts(floats, h):
    """Whether a step of length h sees all of the law, and its contact cannot turn."""
    return slide_lasts(floats, VELOCITY, floats[SIDE], h) and resolved(floats, 0, h)


def pays(floats, h):
    """Whether a step of length h pays on the manifolds that the series in memory is on."""
    enough = True
    for m in range(MANIFOLDS):
        enough = enough and (floats[SLOW + m] == 0.0 or floats[OWN_DECAY + m] * h >= PAYING)
    return enough


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
    elif event == 0 and floats[DECAY_RATE] * h >= tried_from(floats):  # next to an event steps are explicit
        ready = False
        for m in range(MANIFOLDS):
            if floats[DECAY_RATE] * h >= ENTERING or m == 1:
                floats[WAIT + m] -= 1.0
                ready = ready or floats[WAIT + m] <= 0.0
        if ready:
            enter_manifold(floats, h)


def tried_from(floats):
    """Rate times length of an explicit step from which on manifolds are tried.

    An oscillation is not damped to the reach of a decay; it decays at half the sum of both rates at most.
    """
    if PAIR and 0.5 * floats[DECAY_RATE] * SHARE_OF_PERIOD * floats[PERIOD] >= PAYING:
        return PLAIN_REACH
    return ENTERING


def enter_manifold(floats, h):
    """Let the next series be that of a manifold, where a decay towards it bounds the length h of steps.

    Of a contact that creeps velocity and bristle may be one damped oscillation, or decay nearly as fast as each other.
    Out of such a pair none is slaved alone, as the other still bounds the step; where that would not pay, both are.
    """
    for i in range(ROWS):
        floats[POINT + i] = floats[STATE + i]
    jacobian(floats, floats[TIME], POINT, floats[SIDE], 0, JACOBIAN)
    if PAIR:
        one, two = JACOBIAN + SLOW_STATE[0] * WIDTH, JACOBIAN + SLOW_STATE[1] * WIDTH
        trace = -floats[one + SLOW_STATE[0]] - floats[two + SLOW_STATE[1]]
        product = floats[one + SLOW_STATE[0]] * floats[two + SLOW_STATE[1]]
        product -= floats[one + SLOW_STATE[1]] * floats[two + SLOW_STATE[0]]
        pays_over = SHARE_OF_PERIOD * floats[PERIOD]
        if product * PAYING > PLAIN_REACH * trace * trace and product * pays_over >= PAYING * trace:
            if floats[WAIT + 1] <= 0.0:
                enter(floats, 0)
                enter(floats, 1)
            return
        if floats[DECAY_RATE] * h < ENTERING:
            return
    waits = False
    for m in range(MANIFOLDS):
        rate = -floats[JACOBIAN + SLOW_STATE[m] * (WIDTH + 1)]
        if rate * h >= ENTERING and floats[WAIT + m] <= 0.0:
            enter(floats, m)
            return
        waits = waits or floats[WAIT + m] > 0.0
    if waits:  # what bounds the step is one that has been refused
        for m in range(MANIFOLDS):
            if floats[WAIT + m] <= 0.0:
                floats[WAIT + m] = LOOK


def enter(floats, m):
    """Let the next series be that of a manifold, of which nothing is guessed."""
    floats[SLOW + m] = 1.0
    floats[SWEEPS + m] = 0.0
    for k in range(ORDER + 1):
        floats[GUESS + m * (ORDER + 1) + k] = 0.0


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
