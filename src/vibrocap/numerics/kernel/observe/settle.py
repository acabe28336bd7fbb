"""Whether a motion has settled: the decision, from its stroboscopic states modulo the cyclic coordinate and turns.

The criterion and the reasons for it stand in `measures.settling`, which calls these functions with the marks of a
stored motion; a kernel calls them at every mark of a run. Mark k, the state at the start of period k over its natural
size with 0 for the cyclic coordinate, stands in a ring, in the place of mark k - MARK_COUNT. A coordinate that turns
is the point of its circle, whose ordinate stands behind the states (`motion.section`).

At least as far as it still has to go to the limit of the last five marks, by reduced-rank extrapolation, which sees
several slow modes at once. Near a steady motion marks x_j, a stride of periods apart, follow a linear map with a few
multipliers. With the steps u_j = x_{j+1} - x_j, the weights g of sum 1 are taken for which |sum g_j u_j| is least (Sidi
2017); the limit is the same mean of the marks behind the steps,

    s = sum g_j x_{j+1} = x_last + sum b_i u_{3-i},     j = 0 ... 3

and the roots of p(z) = sum g_j z^j are the multipliers that the marks show, those near -1 too.

`marks` is the place of a ring: MARKS of the starts of periods; of a system that nothing drives in time there is another
one, of its returns (`observe/returns.py`), for which "period" below means a return.
"""

import math

from vibrocap.numerics.kernel.codes import LONGEST_PERIOD
from vibrocap.numerics.kernel.generated import *

RANK = 3  # most multipliers that are looked for
LINEAR = 100.0  # times the last step: larger changes of the steps tell nothing of slow modes
DEPENDENT = 1e-9  # share of a change of the steps that is left when it depends on the later ones
# Places behind the point at WORK.
MARK_STEPS = WORK + STATES  # u_0 ... u_3
BASIS = MARK_STEPS + (RANK + 1) * MARK_SIZE  # orthonormal, of the changes u_{j+1} - u_j, the last one first
TRIANGLE = BASIS + RANK * MARK_SIZE
FACTORS = TRIANGLE + RANK * RANK  # b
WEIGHTS = FACTORS + RANK  # g
REMAINDER = WEIGHTS + RANK + 1  # what the weights leave of u_3


def mark_entry(floats, marks, lane, mark, i):
    """State i of a mark over its natural size."""
    return floats[marks + (mark % MARK_COUNT * MARK_SIZE + i) * LANES + lane]


def weights_of(floats, marks, lane, mark, stride):
    """Write b, g and what they leave of u_3, for marks a stride apart; the number of multipliers, up to RANK.

    |u_3 + sum of b_i (u_{3-i} - u_{2-i})| is made least, over changes of the steps that are not dependent, nor far
    larger than u_3: what is not linear of such a change may explain anything.
    """
    for j in range(RANK + 1):
        for i in range(MARK_SIZE):
            later = mark_entry(floats, marks, lane, mark - (RANK - j) * stride, i)
            earlier = mark_entry(floats, marks, lane, mark - (RANK + 1 - j) * stride, i)
            floats[MARK_STEPS + j * MARK_SIZE + i] = later - earlier
    for i in range(MARK_SIZE):
        floats[REMAINDER + i] = floats[MARK_STEPS + RANK * MARK_SIZE + i]
    last, rank = 0.0, 0
    for i in range(MARK_SIZE):
        last += floats[REMAINDER + i] * floats[REMAINDER + i]
    for m in range(RANK):
        if rank == m and takes_column(floats, m, LINEAR * LINEAR * last):
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


def takes_column(floats, m, most):
    """Put change m of the steps, counted from the last, into the basis, and take its share off what is left of u_3.

    Not one whose square is larger than `most`, nor one that depends on those before.
    """
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
    if whole > most or not (rest > DEPENDENT * DEPENDENT * whole):
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


def distance_to_limit(floats, rank, i):
    """What state i of the last mark still has to go to the limit."""
    to_go = 0.0
    for m in range(rank):
        to_go += floats[FACTORS + m] * floats[MARK_STEPS + (RANK - m) * MARK_SIZE + i]
    return to_go


def largest_distance(floats, marks, lane, mark, stride):
    """Distance from the last mark to the limit of the last five, a stride apart, over natural sizes."""
    rank = weights_of(floats, marks, lane, mark, stride)
    largest = 0.0
    for i in range(MARK_SIZE):
        largest = max(largest, abs(distance_to_limit(floats, rank, i)))
    return largest


def unexplained_step(floats):
    """Largest part of the last step that the multipliers do not explain, over the states."""
    largest = 0.0
    for i in range(MARK_SIZE):
        largest = max(largest, abs(floats[REMAINDER + i]))
    return largest


# Where the stroboscopic state stays within this many tolerances, its differences are errors of the integration and
# carry no rate of convergence.
STANDSTILL = 10.0
# Contraction that is assumed where the latest differences grew within a block while the blocks shrink (oscillation).
SLOWEST = 0.99
FASTEST = 0.01  # contraction that is believed when looking back for a shorter period
UNSEEN = 10.0  # times what multipliers do not explain of the last step: its way, if it keeps nine tenths each time
FARTHEST = 1e6  # natural sizes by which no two stroboscopic states differ that will settle within three blocks


def remember(floats, marks, lane, mark):
    """Keep the stroboscopic state of the period that begins."""
    place = marks + mark % MARK_COUNT * MARK_SIZE * LANES + lane
    for i in range(STATES):
        size = 0.0 if i == CYCLIC else lane.state[i] / lane.scale[i]
        floats[place + i * LANES] = size
    for k in range(TURN_COUNT):
        state = TURN_STATES[k]
        angle, radius = lane.state[state] / TURN_RADII[k], TURN_RADII[k] / lane.scale[state]
        floats[place + state * LANES] = radius * math.cos(angle)
        floats[place + (STATES + k) * LANES] = radius * math.sin(angle)


def settled_response(floats, marks, lane, mark, longest):
    """(response period, period since which it was settled, bound of the distance to go); (0, 0, 0.0): not settled.

    mark: the last one; longest: period that is looked for
    """
    threshold = lane.threshold
    for n in range(1, longest + 1):
        if mark < n + 3 * max(n, 3):
            break
        if not may_settle(floats, marks, lane, mark, n):
            continue
        ratio, remaining = distance_to_go(floats, marks, lane, mark, n)
        if ratio >= 0.0 and remaining <= threshold:
            period = shortest_period(floats, marks, lane, mark, n, ratio)
            return period, settled_since(floats, marks, lane, mark, period, threshold - remaining), remaining
    return 0, 0, 0.0


def still_settled(floats, marks, lane, mark, n):
    """Whether the marks still look settled at the end of the response that was measured.

    Meanwhile fast modes have decayed further, and a slow one that they hid shows itself.
    """
    ratio, remaining = distance_to_go(floats, marks, lane, mark, n)
    return ratio >= 0.0 and remaining <= lane.threshold


def may_settle(floats, marks, lane, mark, n):
    """Whether `distance_to_go` over n periods can be within the threshold, from two differences d.

    With q = threshold/(d + threshold) for the last one, d r/(1 - r) <= threshold asks for r <= q. Of the two bounds of
    r in `distance_to_go`, the contraction between blocks b <= r (of at least n periods each) gives differences above
    d/r^2 > d^3/threshold^2 two blocks ago: more than FARTHEST if d^3 > FARTHEST threshold^2. The contraction within
    the last block is w^(n/(block - 1)), w the ratio of its last and first difference: the exponent is 1/2, 1, or for
    n > 2 at most 3/2. Where the last states may be a standstill no rate counts, and SLOWEST may take the place of w.
    """
    threshold, tolerance = lane.threshold, lane.tolerance
    last = difference(floats, marks, lane, mark, mark - n)
    if last * last * last > FARTHEST * threshold * threshold:
        return False
    enough = threshold / (last + threshold)
    if last <= STANDSTILL * tolerance or enough >= 0.85:  # SLOWEST**16 = 0.85
        return True
    block = max(n, 3)
    first = max(difference(floats, marks, lane, mark - block + 1, mark - block + 1 - n), tolerance)
    if n == 1:
        return last <= enough * enough * first
    if n == 2:
        return last <= enough * first
    ratio = last / first
    return ratio * ratio * ratio <= enough * enough


def distance_to_go(floats, marks, lane, mark, n):
    """(contraction r over n periods, bound of the distance still to go); (-1.0, 0.0) where differences do not shrink.

    Differences are those of states n periods apart, the largest over the states; a standstill has the contraction 0.
    A slow mode hides below faster ones, most of all one near -1, whose states n = 2 periods apart hardly differ: so the
    distance is at least that to the limit which the last five marks show, n periods apart, with all their multipliers.
    """
    block, tolerance = max(n, 3), lane.tolerance
    latest = largest_difference(floats, marks, lane, mark, mark - block, n)
    if latest <= STANDSTILL * tolerance and spread(floats, marks, lane, mark, n) <= STANDSTILL * tolerance:
        farther = min(mark // (RANK + 1), LONGEST_PERIOD) // n * n  # a slow mode shows over many periods
        return 0.0, max(latest, largest_distance(floats, marks, lane, mark, farther))
    older = largest_difference(floats, marks, lane, mark - block, mark - 2 * block, n)
    oldest = largest_difference(floats, marks, lane, mark - 2 * block, mark - 3 * block, n)
    # A difference below one tolerance is no smaller than one tolerance.
    per_block = max(latest / max(older, tolerance), older / max(oldest, tolerance))
    if not per_block < 1.0:
        return -1.0, 0.0
    first = difference(floats, marks, lane, mark - block + 1, mark - block + 1 - n)
    within = (difference(floats, marks, lane, mark, mark - n) / max(first, tolerance)) ** (1.0 / (block - 1))
    ratio = max(per_block ** (n / block), min(within, SLOWEST) ** n)
    per_period = ratio ** (1.0 / n)
    distance = 0.0
    for k in range(mark - block + 1, mark + 1):  # earlier ones continued at that rate
        distance = max(distance * per_period, difference(floats, marks, lane, k, k - n))
    distance *= ratio / (1.0 - ratio)
    to_limit = largest_distance(floats, marks, lane, mark, n)
    return ratio, max(distance, to_limit, UNSEEN * unexplained_step(floats))


def shortest_period(floats, marks, lane, mark, n, ratio):
    """The smallest divisor of n that the settled motion has as its period to within the threshold.

    An alternating transient looks settled over two periods a little before it does over one. A motion that is within
    the threshold at its end was further away before, by its contraction, and perhaps on the other side.
    """
    per_period, threshold = max(ratio, FASTEST) ** (1.0 / n), lane.threshold
    before = threshold  # how far away what is within the threshold was so many periods earlier
    for divisor in range(1, n):
        before = before / per_period if ratio > 0.0 else before
        if n % divisor != 0:
            continue
        allowed = threshold + before
        repeats = True
        for k in range(mark, mark - n, -1):
            repeats = repeats and difference(floats, marks, lane, k, k - divisor) <= allowed
            allowed /= per_period
        if repeats:
            return divisor
    return n


def settled_since(floats, marks, lane, mark, n, distance):
    """First mark from which on every state is within a distance of the final one of the same phase.

    It looks back no further than the ring reaches.
    """
    first = max(0, mark - MARK_COUNT + 1)
    for k in range(mark, first - 1, -1):
        if difference(floats, marks, lane, k, mark - (mark - k) % n) > distance:
            return k + 1
    return first


def difference(floats, marks, lane, j, k):
    """Largest difference over the states between marks j and k."""
    a = marks + j % MARK_COUNT * MARK_SIZE * LANES + lane
    b = marks + k % MARK_COUNT * MARK_SIZE * LANES + lane
    largest = 0.0
    for i in range(MARK_SIZE):
        largest = max(largest, abs(floats[a + i * LANES] - floats[b + i * LANES]))
    return largest


def largest_difference(floats, marks, lane, newest, before, n):
    """Largest difference over n periods at the marks from `newest` back to that after `before`."""
    largest = 0.0
    for k in range(before + 1, newest + 1):
        largest = max(largest, difference(floats, marks, lane, k, k - n))
    return largest


def spread(floats, marks, lane, mark, n):
    """Largest extent of the states of one phase, over the marks that `distance_to_go` looks at."""
    count = 3 * max(n, 3) // n + 1
    largest = 0.0
    for phase in range(n):
        for i in range(MARK_SIZE):
            low, high = math.inf, -math.inf
            for k in range(count):
                value = floats[marks + ((mark - phase - k * n) % MARK_COUNT * MARK_SIZE + i) * LANES + lane]
                low, high = min(low, value), max(high, value)
            largest = max(largest, high - low)
    return largest
