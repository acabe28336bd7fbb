"""The linear systems of implicit equations: their place in the work space, and elimination.

And where the law is asked on an implicit step: at the state consistent with the slopes of the dense output. That
follows the states to the tolerance, and its slopes are as exact, but friction may change by as much as the load within
the error of a velocity. At the states y* that answer the slopes y' of the dense output, to its error over the length h
of the step,

    y* = y + h [f(y*) - y'],

friction is as exact as the motion. They are found by Newton's method, whose matrix is 1/h - J. Where that leads
farther than h [f(y) - y'], disturbances grow instead of decaying, and the state is left as it is.
"""

import math

from vibrocap.numerics.kernel.arithmetic.roots import HUGE, polynomial_slope
from vibrocap.numerics.kernel.generated import *

STAGES = 8  # of the implicit step
WIDTH = STATES + 1
# Places in the work space, after that of the event search: the Jacobian outlives a search.
JACOBIAN = WORK + EVENT_WORK
MATRIX = JACOBIAN + STATES * WIDTH
STAGE = MATRIX + STATES * STATES
POINT = STAGE + STAGES * STATES
RATE = POINT + STATES
REFERENCE = RATE + STATES  # of velocities at imposed distances: number of the one that is followed, then all of them


def factorise(floats, inverse):
    """Write inverse - J to the matrix in the work space, and its LU decomposition in its place, without pivoting.

    1/(gamma h) dominates the diagonal for the steps that the error control takes; a vanishing pivot shows as a stage
    that is not finite, and the step is refused.
    """
    for i in range(STATES):
        for j in range(STATES):
            floats[MATRIX + i * STATES + j] = -floats[JACOBIAN + i * WIDTH + j]
        floats[MATRIX + i * STATES + i] += inverse
    for j in range(STATES):
        pivot = 1.0 / floats[MATRIX + j * STATES + j]
        for i in range(j + 1, STATES):
            factor = floats[MATRIX + i * STATES + j] * pivot
            floats[MATRIX + i * STATES + j] = factor
            if factor != 0.0:
                for k in range(j + 1, STATES):
                    floats[MATRIX + i * STATES + k] -= factor * floats[MATRIX + j * STATES + k]


def solve(floats, start):
    """Solve for the right-hand side at floats[start:start + STATES], in place."""
    for i in range(STATES):
        for j in range(i):
            floats[start + i] -= floats[MATRIX + i * STATES + j] * floats[start + j]
    for i in range(STATES - 1, -1, -1):
        for j in range(i + 1, STATES):
            floats[start + i] -= floats[MATRIX + i * STATES + j] * floats[start + j]
        floats[start + i] /= floats[MATRIX + i * STATES + i]


NEWTON_STEPS = 2  # the error of each is the square of that of the one before, a hundredth at most in all laws' motions
INSIDE = 1.0 - 1e-12  # share of the way to rest that is left to a state of a kinked law which was to go beyond


def consistent_state(floats, ints, lane, s, point):
    if lane.stiff == 1:
        fit_to_slopes(floats, lane, s, point)


def fit_to_slopes(floats, lane, s, point):
    time, inverse = lane.time + s, 1.0 / lane.step
    for i in range(STATES):
        floats[POINT + i] = floats[point + i]
    reach, distance = 0.0, 0.0
    for i in range(NEWTON_STEPS):
        left = newton_step(floats, lane, s, time, inverse, point)
        if not (left <= HUGE):
            return 0.0
        if i == 0:
            reach = left
        for c in range(CONTACTS):
            if KINKS[c] == 1:
                side = lane.side[c]
                before = side * contact_velocity(floats, time, point, c, lane)
                after = side * contact_velocity(floats, time, POINT, c, lane)
                if after < 0.0:
                    share = INSIDE * before / (before - after) if before > 0.0 else 0.0  # of the way, up to rest
                    for j in range(STATES):
                        floats[POINT + j] = floats[point + j] + share * (floats[POINT + j] - floats[point + j])
    for i in range(STATES):
        distance = max(distance, abs(floats[POINT + i] - floats[point + i]) / lane.scale[i])
    if not (distance <= reach):
        return 0.0
    for i in range(STATES):
        floats[point + i] = floats[POINT + i]
    return distance


def newton_step(floats, lane, s, time, inverse, point):
    """Move floats[POINT:POINT + STATES] by a step of Newton's method; returns h |f - y'| before, or infinity."""
    rates(floats, time, POINT, lane, RATE)
    jacobian(floats, time, POINT, lane, JACOBIAN)
    largest = 0.0
    for i in range(STATES):
        row = lane.row[i]
        change = floats[POINT + i] - floats[point + i]
        floats[STAGE + i] = floats[RATE + i] - polynomial_slope(floats, row, LANES, ORDER, s) - change * inverse
        largest = max(largest, abs(floats[STAGE + i]) / (inverse * lane.scale[i]))
    factorise(floats, inverse)
    solve(floats, STAGE)
    for i in range(STATES):
        if not (abs(floats[STAGE + i]) <= HUGE):
            return math.inf
    for i in range(STATES):
        floats[POINT + i] += floats[STAGE + i]
    return largest
