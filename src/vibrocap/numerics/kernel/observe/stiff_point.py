"""Where the law is asked on an implicit step: at the state that fits to the slopes of the dense output.

The dense output follows the states to the tolerance, and its slopes are as exact, but friction may change by as much as
the load within the error of a velocity. At the states y* that answer the slopes y' of the dense output, to its error
over the length h of the step,

    y* = y + h [f(y*) - y'],

friction is as exact as the motion. They are found by Newton's method, whose matrix is 1/h - J. Where that leads
farther than h [f(y) - y'], disturbances grow instead of decaying, and the state is left as it is.
`motion.stiff_pieces` does the same for a stored motion.
"""

import math

from vibrocap.numerics.kernel.generated import (
    KINKED,
    LANES,
    ORDER,
    ROWS,
    SCALE,
    SERIES,
    SIDE,
    STATES,
    STEP,
    STIFF,
    TIME,
    contact_velocity,
    jacobian,
    rates,
)
from vibrocap.numerics.kernel.observe.turning_points import polynomial_slope
from vibrocap.numerics.kernel.step.implicit import JACOBIAN, MATRIX, POINT, RATE, STAGE, WIDTH, factorise, solve

NEWTON_STEPS = 2
INSIDE = 1.0 - 1e-12  # share of the way to rest that is left to a state of a kinked law which was to go beyond


def fitting_point(real, whole, lane, s, point):
    """Move the state at real[point:point + STATES], that of the series at time s, to where the law is asked."""
    if whole[STIFF + lane] == 0:
        return
    time, inverse = real[TIME + lane] + s, 1.0 / real[STEP + lane]
    for i in range(STATES):
        real[POINT + i] = real[point + i]
    reach, way = 0.0, 0.0
    for i in range(NEWTON_STEPS):
        left = newton_step(real, lane, s, time, inverse, point)
        if not (left <= 1e300):
            return
        if i == 0:
            reach = left
        if KINKED:
            before = real[SIDE + lane] * contact_velocity(real, time, point, lane)
            after = real[SIDE + lane] * contact_velocity(real, time, POINT, lane)
            if after < 0.0:
                share = INSIDE * before / (before - after) if before > 0.0 else 0.0
                for i in range(STATES):
                    real[POINT + i] = real[point + i] + share * (real[POINT + i] - real[point + i])
    for i in range(STATES):
        way = max(way, abs(real[POINT + i] - real[point + i]) / real[SCALE + i * LANES + lane])
    if way <= reach:
        for i in range(STATES):
            real[point + i] = real[POINT + i]


def newton_step(real, lane, s, time, inverse, point):
    """Move real[POINT:POINT + STATES] by a step of Newton's method; returns h |f - y'| before, infinite if it fails."""
    rates(real, time, POINT, real[SIDE + lane], lane, RATE)
    jacobian(real, time, POINT, real[SIDE + lane], lane, JACOBIAN)
    largest = 0.0
    for i in range(STATES):
        row = SERIES + i * (ORDER + 1) * LANES + lane
        change = real[POINT + i] - real[point + i]
        real[STAGE + i] = real[RATE + i] - polynomial_slope(real, row, LANES, ORDER, s) - change * inverse
        largest = max(largest, abs(real[STAGE + i]) / (inverse * real[SCALE + i * LANES + lane]))
        for j in range(STATES):
            real[MATRIX + i * STATES + j] = -real[JACOBIAN + i * WIDTH + j]
        real[MATRIX + i * STATES + i] += inverse
    for i in range(STATES, ROWS):
        real[STAGE + i] = 0.0
    factorise(real)
    solve(real, STAGE)
    for i in range(STATES):
        if not (abs(real[STAGE + i]) <= 1e300):
            return math.inf
    for i in range(STATES):
        real[POINT + i] += real[STAGE + i]
    return largest
