"""The implicit step for stiff laws: Rodas5P (Steinebach 2023), a Rosenbrock method of order 5 with dense output.

    (1/(gamma h) - J) k_i = f(t + c_i h, y + sum_j a_ij k_j) + sum_j (C_ij/h) k_j + h d_i df/dt
    y_new = y + sum_j b_j k_j

with the exact Jacobian J. The last stage is the error estimate.
"""

import math

import numpy as np

from vibrocap.numerics.kernel import hook
from vibrocap.numerics.kernel.arithmetic.roots import HUGE, value_and_rate
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import at
from vibrocap.numerics.kernel.step.linear_system import (
    JACOBIAN,
    MATRIX,
    POINT,
    RATE,
    REFERENCE,
    STAGE,
    STAGES,
    WIDTH,
    factorise,
    solve,
)
from vibrocap.numerics.kernel.step.resolved import resolved
from vibrocap.numerics.kernel.step.taylor import NO_SPEED, series_state, series_value, through_points, write_state

GAMMA = 0.21193756319429014
# fmt: off
LAST_WEIGHTS = [-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946]
STAGE_WEIGHTS = np.array([[*row, *[0.0] * (STAGES - len(row))] for row in [
    [],
    [3.0],
    [2.849394379747939, 0.45842242204463923],
    [-6.954028509809101, 2.489845061869568, -10.358996098473584],
    [2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641],
    LAST_WEIGHTS,
    [*LAST_WEIGHTS, 1.0],
    [*LAST_WEIGHTS, 1.0, 1.0],
]])
COUPLING = np.array([[*row, *[0.0] * (STAGES - len(row))] for row in [
    [],
    [-14.155112264123755],
    [-17.97296035885952, -2.859693295451294],
    [147.12150275711716, -1.41221402718213, 71.68940251302358],
    [165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306],
    [24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471],
    [30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783, -19.097331116725623,
     -28.087943162872662],
    [37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047, -40.06618937091002,
     -54.66780262877968, -9.48861652309627],
]])
DENSE = np.array([
    [25.948786856663858, -2.5579724845846235, 10.433815404888879, -2.3679251022685204, 0.524948541321073,
     1.1241088310450404, 0.4272876194431874, -0.17202221070155493],
    [-9.91568850695171, -0.9689944594115154, 3.0438037242978453, -24.495224566215796, 20.176138334709044,
     15.98066361424651, -6.789040303419874, -6.710236069923372],
    [11.419903575922262, 2.8879645146136994, 72.92137995996029, 80.12511834622643, -52.072871366152654,
     -59.78993625266729, -0.15582684282751913, 4.883087185713722],
])
TIME_WEIGHTS = np.array([
    0.21193756319429014, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734, 2.325825639765069,
    0.0, 0.0, 0.0,
])
# fmt: on
NODES = np.array([0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0, 1.0, 1.0])

SURE = 0.03  # share of a velocity that its error may have where its sign counts
BEYOND_DOUBT = 1e9
ROUNDING_NOISE = 1e-14  # of a state, over its natural size


def implicit_stages(floats, ints, lane, h):
    """The stages of a step of length h; returns the error estimate over the tolerance."""
    t = lane.time
    inverse = 1.0 / (GAMMA * h)
    factorise(floats, inverse)
    before, slope, curvature = 0.0, 0.0, 0.0
    if SHIFTS > 0:
        choose_reference(floats, lane)
        before, slope, curvature = reference_at(floats, t, lane)
    for stage in range(STAGES):
        for i in range(STATES):
            total = lane.state[i]
            for j in range(stage):
                total += STAGE_WEIGHTS[stage, j] * floats[STAGE + j * STATES + i]
            floats[POINT + i] = total
        if SHIFTS > 0:  # p = v - g, p' = v' - g'
            now, rate, _ = reference_at(floats, t + NODES[stage] * h, lane)
            floats[POINT + STATE_OF[0]] += before - now
            rates(floats, t + NODES[stage] * h, POINT, lane, RATE)
            floats[RATE + STATE_OF[0]] += rate + h * TIME_WEIGHTS[stage] * curvature
            for i in range(STATES):
                floats[RATE + i] -= h * TIME_WEIGHTS[stage] * floats[JACOBIAN + i * WIDTH + STATE_OF[0]] * slope
        else:
            rates(floats, t + NODES[stage] * h, POINT, lane, RATE)
        start = STAGE + stage * STATES
        for i in range(STATES):
            total = floats[RATE + i] + h * TIME_WEIGHTS[stage] * floats[JACOBIAN + i * WIDTH + STATES]
            for j in range(stage):
                total += COUPLING[stage, j] / h * floats[STAGE + j * STATES + i]
            floats[start + i] = total
        solve(floats, start)
    error = 0.0
    for i in range(STATES):
        estimate = abs(floats[STAGE + (STAGES - 1) * STATES + i]) / lane.scale[i]
        if not (estimate <= HUGE):
            return math.inf
        error = max(error, estimate)
    return error / lane.tolerance


def implicit_series(floats, ints, lane, h):
    """Write the dense output of the step as a series in s (degree 4) to c, the contact velocity included.

    With x = s/h: y = (1-x) y0 + x [y1 + (1-x) (K1 + x (K2 + x K3))].
    """
    for i in range(STATES):
        y0 = lane.state[i]
        change = 0.0  # y1 - y0
        k1, k2, k3 = 0.0, 0.0, 0.0
        for j in range(STAGES):
            stage = floats[STAGE + j * STATES + i]
            weight = 1.0 if j >= STAGES - 3 else STAGE_WEIGHTS[STAGES - 1, j]
            change += weight * stage
            k1 += DENSE[0, j] * stage
            k2 += DENSE[1, j] * stage
            k3 += DENSE[2, j] * stage
        start = i * (ORDER + 1)
        for k in range(5, ORDER + 1):
            lane.series[start + k] = 0.0
        lane.series[start] = y0
        lane.series[start + 1] = (change + k1) / h
        lane.series[start + 2] = (k2 - k1) / (h * h)
        lane.series[start + 3] = (k3 - k2) / (h * h * h)
        lane.series[start + 4] = -k3 / (h * h * h * h)


def velocity_series(floats, ints, lane, h):
    """Write contact velocities along the step to their rows, interpolated at five points of the dense output."""
    for c in range(CONTACTS):
        if at.velocity_row[c] != at.row[STATE_OF[c]]:  # it is no state
            for point in range(5):
                floats[WORK + point] = velocity_at(floats, ints, lane, c, 0.25 * point * h)
            through_points(floats, lane.velocity_row[c], WORK, 1, h)


def velocity_at(floats, ints, lane, c, s):
    """Velocity of a contact at time s of the present series."""
    for i in range(STATES):
        floats[POINT + i] = value_and_rate(floats, lane.row[i], LANES, 4, s, False)[0]
    return contact_velocity(floats, lane.time + s, POINT, c, lane)


def dense_output(floats, ints, lane, h):
    """Write the dense output of a step of length h: states, contact velocities and guards."""
    if SHIFTS > 0:
        moving_series(floats, ints, lane, h)
    else:
        implicit_series(floats, ints, lane, h)
        velocity_series(floats, ints, lane, h)
    hook.interpolated_guards(floats, lane, h)
    if SEVERAL:
        holding_series(floats, lane, h)


def holding_series(floats, lane, h):
    """The forces that hold several contacts, and their limits, along a step: through five points of its dense output.

    Those of a contact at rest beside stiff ones decide.
    """
    out = WORK + STATES
    for point in range(5):
        s = 0.25 * point * h
        series_state(floats, lane, s, WORK)
        holding(floats, lane.time + s, WORK, lane, out + 2 * CONTACTS * point)
    for c in range(CONTACTS):
        if STICKS[c] == 1:
            through_points(floats, lane.sticking_force_row[c], out + 2 * c, 2 * CONTACTS, h)
            through_points(floats, lane.limit_row[c], out + 2 * c + 1, 2 * CONTACTS, h)


def moving_series(floats, ints, lane, h):
    """The states and the contact velocities, v_i = p + g_i(t), of a step that was made in the coordinates of one v_i.

    Of g_i the series in memory know all terms, whatever p.
    """
    implicit_series(floats, ints, lane, h)
    state = lane.row[STATE_OF[0]]
    followed = SHIFT + int(floats[REFERENCE]) * (ORDER + 1) * LANES + lane
    for k in range(1, ORDER + 1):
        floats[state + k * LANES] -= floats[followed + k * LANES]
    for i in range(SHIFTS):
        for k in range(1, ORDER + 1):
            shift = floats[SHIFT + (i * (ORDER + 1) + k) * LANES + lane]
            floats[at.velocity_row[i] + k * LANES + lane] = floats[state + k * LANES] + shift


def choose_reference(floats, lane):
    """Choose the velocity in whose coordinates a step is made: the slowest of those whose contact may be stiff.

    Where a contact creeps, so slowly that it holds its body, p follows -g(t) and all that counts is their difference.
    """
    slowest, largest = math.inf, 0.0
    for i in range(SHIFTS):
        speed = abs(lane.velocity[i])
        if STICKS[i] == 0 and speed < slowest:
            slowest, largest = speed, float(i)
    floats[REFERENCE] = largest


def reference_at(floats, t, lane):
    """(g, g', g'') of the velocity v = p + g(t) in whose coordinates the step is made."""
    shifts(floats, t, lane, REFERENCE + 1)
    place = REFERENCE + 1 + 3 * int(floats[REFERENCE])
    return floats[place], floats[place + 1], floats[place + 2]


def doubt_of_signs(floats, lane, h):
    """Largest error of a velocity by which a contact turns, over what leaves its sign beyond doubt.

    Of a contact that creeps, more slowly than the tolerance, the sign counts still: see `taylor.taylor_step`.
    """
    doubt = 0.0
    for c in range(CONTACTS):
        if KINKS[c] == 1:
            row, side = lane.velocity_row[c], lane.side[c]
            start, end = floats[row], series_value(floats, row, h)
            doubt = max(doubt, doubt_of_sign(floats, STATE_OF[c], lane, start, end))
            none = NO_SPEED * lane.scale[STATE_OF[c]]
            if SEVERAL and not (side * start > 0.0) and side * end < -none:
                doubt = BEYOND_DOUBT  # it turned where the step starts, which rounding hid: explicit steps tell
    return doubt


def doubt_of_sign(floats, state, lane, start, end):
    """The same of one, from `start` to `end`, which moves as the state does."""
    error = abs(floats[STAGE + (STAGES - 1) * STATES + state])
    return error / (SURE * (abs(start) + abs(end - start)) + ROUNDING_NOISE * lane.scale[state])


def implicit_step(floats, ints, lane, longest):
    """Take the series of an implicit step of at most `longest`; returns its length, or 0 where none succeeds."""
    return attempted_step(floats, ints, lane, longest, 60)


def attempted_step(floats, ints, lane, longest, tries):
    """The same in at most so many attempts, each shorter than the one before."""
    write_state(floats, lane, POINT)
    jacobian(floats, lane.time, POINT, lane, JACOBIAN)
    h = min(lane.implicit_step, longest)
    for _ in range(tries):
        error = implicit_stages(floats, ints, lane, h)
        factor = 0.9 * error ** (-0.2) if error > 1e-10 else 6.0
        factor = min(6.0, max(0.2, factor))
        if error <= 1.0:
            if h < longest or factor < 1.0:
                lane.implicit_step = h * factor
            if SEVERAL:
                dense_output(floats, ints, lane, h)
                doubt = doubt_of_signs(floats, lane, h)
                if doubt <= 1.0 and resolved(floats, lane, h):
                    return h
                factor = max(0.2, min(0.5, 0.9 * doubt ** (-0.2)))
            else:
                implicit_series(floats, ints, lane, h)
                velocity_series(floats, ints, lane, h)
                if resolved(floats, lane, h):
                    hook.interpolated_guards(floats, lane, h)
                    return h
                factor = 0.5
        h *= factor
    return 0.0


def spectral_radius(floats, ints, lane):
    """Estimate of the largest |eigenvalue| of the Jacobian: the eighth root of a norm of its eighth power."""
    write_state(floats, lane, POINT)
    jacobian(floats, lane.time, POINT, lane, JACOBIAN)
    for i in range(STATES):
        for j in range(STATES):
            floats[MATRIX + i * STATES + j] = floats[JACOBIAN + i * WIDTH + j]
    scaling = 0.0  # logarithm of what was divided out
    for squaring in range(3):
        largest = largest_entry(floats)
        if not (0.0 < largest <= HUGE):
            return 0.0
        scaling += math.log(largest) * 2.0 ** (-squaring)
        for i in range(STATES):
            for j in range(STATES):
                total = 0.0
                for k in range(STATES):
                    total += floats[MATRIX + i * STATES + k] * floats[MATRIX + k * STATES + j]
                floats[STAGE + i * STATES + j] = total / (largest * largest)
        for i in range(STATES * STATES):
            floats[MATRIX + i] = floats[STAGE + i]
    largest = largest_entry(floats)
    return math.exp(scaling + math.log(largest) / 8.0) if largest > 0.0 else 0.0


def largest_entry(floats):
    """Largest magnitude in the matrix."""
    largest = 0.0
    for i in range(STATES * STATES):
        largest = max(largest, abs(floats[MATRIX + i]))
    return largest
