"""Runs that do not wait: the limit of the period marks, extrapolated and tried for one period.

Near a steady motion the marks x_j, stroboscopic states over their natural sizes, follow a linear map with a few
multipliers. Of the last five, with the steps u_j = x_{j+1} - x_j, reduced-rank extrapolation (Sidi 2017) takes the
weights of sum 1 for which |sum g_j u_j| is least; the limit is the same mean of the marks behind the steps,

    s = sum g_j x_{j+1},     j = 0 ... 3

A limit is tried where the last two agree to within the threshold, the motion has taken the same events in the same
modes for two periods, the polynomial p(z) = sum g_j z^j, whose roots are the multipliers that the marks show, has all
of them within a circle of radius SLOWEST (a saddle that a run passes has one outside), and what is left of
|sum g_j u_j| would go no farther than the threshold if it were as slow.

The run stands at s for one period, and is measured over it. It has settled if that period has the events of the one
before, returns to s within RETURN of the threshold, and if what is left, d r/(1 - r) for the return d and the largest
multiplier r, is at most LEFT_TO_GO of the threshold. Otherwise all that the lane carries is put back, and the run goes
on as if nothing had been tried, for at least 1, 2, 4 ... periods before the next trial.
"""

import math

from vibrocap.numerics.kernel.generated.ensemble import (
    EXTRAPOLATE,
    KEPT,
    LAST_MODES,
    MARKS,
    MODES,
    NEXT_TRIAL,
    ON_TRIAL,
    PERIOD_BUDGET,
    REFUSED_TRIALS,
    STEADY,
    STEADY_MARK,
    THRESHOLD,
)
from vibrocap.numerics.kernel.generated.equations import contact_velocity
from vibrocap.numerics.kernel.generated.facts import CYCLIC, KINKS, STATE_OF, STICKS
from vibrocap.numerics.kernel.generated.lane import (
    PERIOD_COUNT,
    SCALE,
    SEGMENT,
    SEGMENT_COUNT,
    SIDE,
    STATE,
    TIME,
    TO_DECIDE,
    WHOLE_PERIODS,
    WORK,
    ZEROS,
)
from vibrocap.numerics.kernel.generated.sizes import CONTACTS, LANES, MARK_COUNT, MARK_SIZE, STATES
from vibrocap.numerics.kernel.observe.settle import SLOWEST, difference
from vibrocap.numerics.kernel.step.resolved import forget

RETURN = 0.5  # of the threshold: how far a trial may end from its start, as what is measured over it is off by as much
RANK = 3  # most multipliers that are looked for
LEFT_TO_GO = 0.25  # of the threshold: what may be left to go from the end of a trial, by the multipliers of the marks
FARTHEST_LIMIT = 0.1  # natural sizes from the last mark
DEPENDENT = 1e-9  # share of a change of the steps that is left when it depends on the later ones
MOST_DOUBLINGS = 20  # of the wait between two trials
MODULUS = 2147483647  # of the numbers that stand for a period's events
# Places behind the point at WORK.
MARK_STEPS = WORK + STATES  # u_0 ... u_3
BASIS = MARK_STEPS + (RANK + 1) * MARK_SIZE  # orthonormal, of the changes u_{j+1} - u_j, the last one first
TRIANGLE = BASIS + RANK * MARK_SIZE
FACTORS = TRIANGLE + RANK * RANK
WEIGHTS = FACTORS + RANK
REMAINDER = WEIGHTS + RANK + 1


def begin_marks(ints, lane):
    """A run begins."""
    ints[MODES + lane] = 0
    ints[LAST_MODES + lane] = 0
    ints[STEADY_MARK + lane] = 0
    ints[NEXT_TRIAL + lane] = RANK + 2
    ints[ON_TRIAL + lane] = 0
    ints[REFUSED_TRIALS + lane] = 0


def note_event(floats, ints, lane, event, c):
    """Add an event of contact c, in the present mode, to those of the period."""
    told = event + 3 + 256 * c + 65536 * int(floats[SIDE + c * LANES + lane] + 1.0)
    ints[MODES + lane] = (ints[MODES + lane] * 8191 + told) % MODULUS


def starts_trial(floats, ints, lane):
    """At a mark that is remembered, of a run that has not settled: whether it goes on from an extrapolated limit."""
    mark = ints[PERIOD_COUNT + lane]
    same = ints[MODES + lane] == ints[LAST_MODES + lane]
    ints[LAST_MODES + lane] = ints[MODES + lane]
    ints[MODES + lane] = present_sides(floats, lane)
    if ints[EXTRAPOLATE] == 0 or not same or mark < RANK + 1 or mark < ints[NEXT_TRIAL + lane] - 1:
        return False
    if mark >= ints[WHOLE_PERIODS + lane] or not at_ease(ints, lane):
        return False
    if difference(floats, MARKS, lane, mark, mark - 1) > difference(floats, MARKS, lane, mark - RANK, mark - RANK - 1):
        return False
    rank, apart, unexplained = next_limit(floats, lane, mark)
    known = ints[STEADY_MARK + lane] == mark - 1
    ints[STEADY_MARK + lane] = mark
    if not known or mark < ints[NEXT_TRIAL + lane] or not (apart <= floats[THRESHOLD + lane]):
        return False
    if not (unexplained <= (1.0 - SLOWEST) * floats[THRESHOLD + lane]):
        return False
    if not (limit_distance(floats, lane, mark) <= FARTHEST_LIMIT) or not multipliers_within(floats, rank, SLOWEST):
        return False
    if not same_sides(floats, lane, mark):
        return False
    keep_lane(floats, ints, lane)
    go_to_limit(floats, lane, mark)
    ints[ON_TRIAL + lane] = 1
    return True


def trial_fails(floats, ints, lane):
    """At the end of a period: whether it was a trial that is refused, so that the lane stands where it was before."""
    if ints[ON_TRIAL + lane] != 1:
        return False
    mark = ints[PERIOD_COUNT + lane] - 1
    away = 0.0
    for i in range(STATES):
        if i != CYCLIC:
            now = floats[STATE + i * LANES + lane] / floats[SCALE + i * LANES + lane]
            away = max(away, abs(now - floats[STEADY + i * LANES + lane]))
    left = LEFT_TO_GO * floats[THRESHOLD + lane]
    if away <= RETURN * floats[THRESHOLD + lane] and ints[MODES + lane] == ints[LAST_MODES + lane]:
        rank = weights_of(floats, lane, mark)
        if multipliers_within(floats, rank, left / (away + left)):
            ints[ON_TRIAL + lane] = 2
            return False
    put_back(floats, ints, lane)
    return True


def ends_trial(floats, ints, lane):
    """Of a lane that has stopped: whether that was within a trial, so that it runs on from where it was before."""
    if ints[ON_TRIAL + lane] != 1:
        return False
    put_back(floats, ints, lane)
    return True


def at_ease(ints, lane):
    """Whether no contact is just about to be decided."""
    open_contacts = 0
    for c in range(CONTACTS):
        open_contacts += ints[TO_DECIDE + c * LANES + lane] + ints[ZEROS + c * LANES + lane]
    return open_contacts == 0


def present_sides(floats, lane):
    """A number for the sides of all contacts."""
    told = 0
    for c in range(CONTACTS):
        told = (3 * told + int(floats[SIDE + c * LANES + lane] + 1.0)) % MODULUS
    return told


def mark_entry(floats, lane, mark, i):
    """State i of a mark over its natural size."""
    return floats[MARKS + (mark % MARK_COUNT * MARK_SIZE + i) * LANES + lane]


def weights_of(floats, lane, mark):
    """Write the factors b of s = x_mark + sum of b_i u_{3-i} and the weights g; the number of multipliers, up to RANK.

    |u_3 + sum of b_i (u_{3-i} - u_{2-i})| is made least, over changes of the steps that are not dependent.
    """
    for j in range(RANK + 1):
        for i in range(MARK_SIZE):
            later = mark_entry(floats, lane, mark - RANK + j, i)
            floats[MARK_STEPS + j * MARK_SIZE + i] = later - mark_entry(floats, lane, mark - RANK - 1 + j, i)
    for i in range(MARK_SIZE):
        floats[REMAINDER + i] = floats[MARK_STEPS + RANK * MARK_SIZE + i]
    rank = 0
    for m in range(RANK):
        if rank == m and takes_column(floats, m):
            rank = m + 1
    for i in range(rank - 1, -1, -1):
        factor = floats[FACTORS + i]
        for j in range(i + 1, rank):
            factor -= floats[TRIANGLE + j * RANK + i] * floats[FACTORS + j]
        floats[FACTORS + i] = factor / floats[TRIANGLE + i * RANK + i]
    floats[WEIGHTS + rank] = 1.0
    for i in range(rank):
        floats[WEIGHTS + rank - i] += floats[FACTORS + i]
        floats[WEIGHTS + rank - 1 - i] = -floats[FACTORS + i]
    return rank


def takes_column(floats, m):
    """Put change m of the steps, counted from the last, into the basis, and take its share off what is left of u_3."""
    column = BASIS + m * MARK_SIZE
    whole = 0.0
    for i in range(MARK_SIZE):
        change = floats[MARK_STEPS + (RANK - m) * MARK_SIZE + i] - floats[MARK_STEPS + (RANK - 1 - m) * MARK_SIZE + i]
        floats[column + i] = change
        whole += change * change
    for q in range(m):
        along = 0.0
        for i in range(MARK_SIZE):
            along += floats[BASIS + q * MARK_SIZE + i] * floats[column + i]
        for i in range(MARK_SIZE):
            floats[column + i] -= along * floats[BASIS + q * MARK_SIZE + i]
        floats[TRIANGLE + m * RANK + q] = along
    rest = 0.0
    for i in range(MARK_SIZE):
        rest += floats[column + i] * floats[column + i]
    if not (rest > DEPENDENT * DEPENDENT * whole):
        return False
    length = math.sqrt(rest)
    floats[TRIANGLE + m * RANK + m] = length
    along = 0.0
    for i in range(MARK_SIZE):
        floats[column + i] /= length
        along += floats[column + i] * floats[REMAINDER + i]
    for i in range(MARK_SIZE):
        floats[REMAINDER + i] -= along * floats[column + i]
    floats[FACTORS + m] = -along
    return True


def next_limit(floats, lane, mark):
    """Write the limit of the marks up to this one: (rank, distance from the limit before, what is left of u_3)."""
    rank = weights_of(floats, lane, mark)
    apart, unexplained = 0.0, 0.0
    for i in range(MARK_SIZE):
        way = 0.0
        for m in range(rank):
            way += floats[FACTORS + m] * floats[MARK_STEPS + (RANK - m) * MARK_SIZE + i]
        limit = mark_entry(floats, lane, mark, i) + way
        apart = max(apart, abs(limit - floats[STEADY + i * LANES + lane]))
        unexplained = max(unexplained, abs(floats[REMAINDER + i]))
        floats[STEADY + i * LANES + lane] = limit
    return rank, apart, unexplained


def limit_distance(floats, lane, mark):
    """Distance of the limit from the mark."""
    largest = 0.0
    for i in range(MARK_SIZE):
        largest = max(largest, abs(floats[STEADY + i * LANES + lane] - mark_entry(floats, lane, mark, i)))
    return largest


def multipliers_within(floats, rank, radius):
    """Whether all roots of the polynomial of the weights are within a circle: the test of Schur and Cohn.

    p(radius z) has them in the unit circle if its first coefficient is smaller than its last, and if the same holds of
    the polynomial, of one degree less, that is left when a multiple of the reversed one has taken the first away.
    """
    power = 1.0
    for j in range(rank + 1):
        floats[REMAINDER + j] = floats[WEIGHTS + j] * power
        power *= radius
    for degree in range(rank, 0, -1):
        first, last = floats[REMAINDER], floats[REMAINDER + degree]
        if not (abs(first) < abs(last)):
            return False
        ratio = first / last
        for j in range(degree + 1):
            floats[REMAINDER + RANK + 1 + j] = floats[REMAINDER + j]
        for j in range(degree):
            floats[REMAINDER + j] = floats[REMAINDER + RANK + 2 + j] - ratio * floats[REMAINDER + RANK + degree - j]
    return True


def to_point(floats, lane, mark):
    """Write the state at the limit to WORK; a coordinate that does not change at the marks stays as it is."""
    for i in range(STATES):
        way = floats[STEADY + i * LANES + lane] - mark_entry(floats, lane, mark, i)
        floats[WORK + i] = floats[STATE + i * LANES + lane] + way * floats[SCALE + i * LANES + lane]


def same_sides(floats, lane, mark):
    """Whether contacts that slide do so at the limit too."""
    to_point(floats, lane, mark)
    for c in range(CONTACTS):
        if STICKS[c] + KINKS[c] > 0:
            side = floats[SIDE + c * LANES + lane]
            if side != 0.0 and not (side * contact_velocity(floats, floats[TIME + lane], WORK, c, lane) > 0.0):
                return False
    return True


def go_to_limit(floats, lane, mark):
    """Put the lane at the limit; contacts that stick have no velocity there."""
    to_point(floats, lane, mark)
    for c in range(CONTACTS):
        if STICKS[c] == 1 and floats[SIDE + c * LANES + lane] == 0.0:
            floats[WORK + STATE_OF[c]] -= contact_velocity(floats, floats[TIME + lane], WORK, c, lane)
    for i in range(STATES):
        floats[STATE + i * LANES + lane] = floats[WORK + i]
    forget(floats, lane)


def keep_lane(floats, ints, lane):
    """Keep all that the lane carries, but for its marks and the series of the step."""
    place = KEPT + lane
    for entry in range(0, KEPT, LANES):
        floats[place] = floats[entry + lane]
        place += LANES
    for entry in range(0, PERIOD_BUDGET, LANES):
        floats[place] = float(ints[entry + lane])
        place += LANES
    for entry in range(SEGMENT, SEGMENT_COUNT, LANES):
        floats[place] = float(ints[entry + lane])
        place += LANES


def put_back(floats, ints, lane):
    """Put back what was kept, as a trial has been refused."""
    refused = ints[REFUSED_TRIALS + lane] + 1
    place = KEPT + lane
    for entry in range(0, KEPT, LANES):
        floats[entry + lane] = floats[place]
        place += LANES
    for entry in range(0, PERIOD_BUDGET, LANES):
        ints[entry + lane] = int(floats[place])
        place += LANES
    for entry in range(SEGMENT, SEGMENT_COUNT, LANES):
        ints[entry + lane] = int(floats[place])
        place += LANES
    ints[REFUSED_TRIALS + lane] = refused
    ints[NEXT_TRIAL + lane] = ints[PERIOD_COUNT + lane] + 1 + (1 << min(refused - 1, MOST_DOUBLINGS))
