"""The limit of marks, from their last five: reduced-rank extrapolation, which sees several slow modes at once.

Near a steady motion marks x_j, a stride of periods apart, follow a linear map with a few multipliers. Of the last five,
with the steps u_j = x_{j+1} - x_j, the weights g of sum 1 are taken for which |sum g_j u_j| is least (Sidi 2017); the
limit is the same mean of the marks behind the steps,

    s = sum g_j x_{j+1} = x_last + sum b_i u_{3-i},     j = 0 ... 3

and the roots of p(z) = sum g_j z^j are the multipliers that the marks show, those near -1 too.
"""

import math

from vibrocap.numerics.kernel.generated.places import WORK
from vibrocap.numerics.kernel.generated.sizes import LANES, MARK_COUNT, MARK_SIZE, STATES

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
