"""Evidence that a run is a motion of the equations, taken of its last response while it runs: what a certificate asks.

Of a piece the equations are asked at its end, and within it where the contact is slowest or the force that holds it is
largest, by the functions of the equations themselves and not by the series that made the step; of an implicit step at
even distances, as its dense output is less exact than its end:

    defect           h |y' - f(t, y)| over the natural size of a state, h the length of the step; beyond its bound the
                     distance to the state consistent with the slopes, which is less (`linear_system.py`)
    share of a hold  |R - middle|/limit of a contact that sticks
    velocity         side v of a contact that slides, over the terms of its series where these exceed 1

Asked are the pieces on which a contact may lose half of its speed or the force that holds it come to its limit, and
every eighth of the others. `motion/evidence.py` asks the same of all pieces of a recorded motion, and holds the bounds.
"""

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import HUGE, sign_change, value_and_rate
from vibrocap.numerics.kernel.codes import DEFECT_BOUND
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.step.taylor import series_value

EVERY = 8  # steps of which one is asked whatever it does
SLOWER, CLOSER = 0.5, 0.9  # shares of the speed, and of what is left to the limit, that a decisive step may go through
IMPLICIT_POINTS = 8  # at which a step is asked whose dense output is less exact than its end
SAMPLE_STATE = WORK
SLOPE = SAMPLE_STATE + BASE
EQUATION_VALUES = SLOPE + BASE


def take_evidence(floats, ints, lane, h):
    if MAYBE_STIFF and lane.stiff == 1:
        lane.step = h
        for k in range(IMPLICIT_POINTS):
            sample(floats, ints, lane, h * (k + 1.0) / IMPLICIT_POINTS, h)
        return
    sampled = lane.taylor_steps % EVERY == 0
    lane.step = h
    if sampled:
        sample(floats, ints, lane, h, h)
    for c in range(CONTACTS):
        if decisive(floats, lane, c, h):
            if not sampled:
                sample(floats, ints, lane, h, h)
            sampled = True
            s = extreme(floats, lane, c, h)
            if 0.0 < s < h:
                sample(floats, ints, lane, s, h)


def decisive(floats, lane, c, h):
    """Whether, by the first terms of the series, a contact loses a good part of its speed within the piece, or the
    force that holds it goes through a good part of what is left to its limit."""
    row, share, level = lane.velocity_row[c], SLOWER, -lane.velocity[c]
    if STICKS[c] == 1 and lane.side[c] == 0.0:
        row, share = lane.sticking_force_row[c], CLOSER
        level = lane.limit[c] - abs(lane.sticking_force[c])
        return (abs(floats[row + LANES]) + abs(floats[row + 2 * LANES]) * h) * h >= share * level
    towards = 1.0 if level > 0.0 else -1.0
    slower = towards * floats[row + LANES]
    return max(slower, slower + towards * floats[row + 2 * LANES] * h) * h > share * abs(level)


def extreme(floats, lane, c, h):
    """Within the piece, where a contact is slowest or the force that holds it turns; -1.0 where that is at an end."""
    row, degree = lane.velocity_row[c], ORDER
    if STICKS[c] == 1 and lane.side[c] == 0.0:
        row, degree = lane.sticking_force_row[c], ORDER - 1
    end, slope = value_and_rate(floats, row, LANES, degree, h, False)
    if STICKS[c] + KINKS[c] == 0 and floats[row] * end < 0.0:
        return sign_change(floats, (row, LANES, degree), False, 0.0, h)
    if floats[row + LANES] * slope >= 0.0:
        return -1.0
    return sign_change(floats, (row, LANES, degree), True, 0.0, h)


def sample(floats, ints, lane, s, h):
    """Ask the equations at time s of the piece."""
    for i in range(BASE):
        value, slope = value_and_rate(floats, lane.row[i], LANES, ORDER, s, False)
        floats[SAMPLE_STATE + i] = value
        floats[SLOPE + i] = slope
    evidence(floats, lane.time + s, SAMPLE_STATE, lane, EQUATION_VALUES)
    left = 0.0
    for i in range(BASE):
        left = max(left, abs(floats[EQUATION_VALUES + i] - floats[SLOPE + i]) * lane.inverse_scale[i])
    left *= h
    if MAYBE_STIFF and left > DEFECT_BOUND * lane.tolerance:
        distance = hook.fit_to_slopes(floats, lane, s, SAMPLE_STATE)  # a stiff law multiplies what is left
        if distance > 0.0:
            left = distance
    if not (left <= HUGE):
        left = HUGE
    lane.defect = max(lane.defect, left)
    for c in range(CONTACTS):
        side = lane.side[c]
        if STICKS[c] == 1 and side == 0.0:
            force, limit = abs(floats[EQUATION_VALUES + BASE + 2 * c]), floats[EQUATION_VALUES + BASE + 2 * c + 1]
            if force > lane.sticking_share * limit:
                lane.sticking_share = force / limit if limit > 0.0 else HUGE
        elif STICKS[c] + KINKS[c] > 0:
            row = lane.velocity_row[c]
            v0, v1, v2 = floats[row], floats[row + LANES], floats[row + 2 * LANES]
            terms = max(1.0, abs(v0) + (abs(v1) + abs(v2) * h) * h)  # whose rounding is that of the velocity at rest
            lane.least_velocity = min(lane.least_velocity, side * series_value(floats, row, s) / terms)
