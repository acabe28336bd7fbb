"""Runs that do not wait: the limit of the period marks (`settle.py`), tried for one period.

A limit is tried where the last two agree to within the threshold, the motion has taken the same events in the same
modes for two periods, the multipliers that the marks show are all within a circle of radius SLOWEST (a saddle that a
run passes has one outside), and what they do not explain of the last step would go no farther than the threshold if it
were as slow.

The run stands at s for one period, and is measured over it. It has settled if that period has the events of the one
before, returns to s within RETURN of the threshold, and if what is left, d r/(1 - r) for the return d and the largest
multiplier r, is at most LEFT_TO_GO of the threshold. Otherwise all that the lane carries is put back, and the run goes
on as if nothing had been tried, for at least 1, 2, 4 ... periods before the next trial.
"""

from vibrocap.numerics.kernel.events.transitions import MODE_HOLDS
from vibrocap.numerics.kernel.generated import *
from vibrocap.numerics.kernel.lane import shared
from vibrocap.numerics.kernel.observe.settle import (
    RANK,
    REMAINDER,
    SLOWEST,
    WEIGHTS,
    difference,
    distance_to_limit,
    mark_entry,
    unexplained_step,
    weights_of,
)
from vibrocap.numerics.kernel.step.resolved import forget

RETURN = 0.5  # of the threshold: how far a trial may end from its start, as what is measured over it is off by as much
LEFT_TO_GO = 0.25  # of the threshold: what may be left to go from the end of a trial, by the multipliers of the marks
FARTHEST_LIMIT = 0.1  # natural sizes from the last mark
MOST_DOUBLINGS = 20  # of the wait between two trials
MODULUS = 2147483647  # of the numbers that stand for a period's events


def begin_marks(ints, lane):
    lane.modes = 0
    lane.last_modes = 0
    lane.steady_mark = 0
    lane.next_trial = RANK + 2
    lane.on_trial = 0
    lane.refused_trials = 0


def note_event(floats, ints, lane, event, c):
    """Add an event of contact c, in the present mode, to those of the period."""
    number = event + 3 + 256 * c + 65536 * int(lane.side[c] + 1.0)
    lane.modes = (lane.modes * 8191 + number) % MODULUS


def starts_trial(floats, ints, lane):
    mark = lane.period_count
    same = lane.modes == lane.last_modes
    lane.last_modes = lane.modes
    lane.modes = present_sides(floats, lane)
    if shared.extrapolate == 0 or not same or mark < RANK + 1 or mark < lane.next_trial - 1:
        return False
    if mark >= lane.whole_periods or not at_ease(ints, lane):
        return False
    if difference(floats, MARKS, lane, mark, mark - 1) > difference(floats, MARKS, lane, mark - RANK, mark - RANK - 1):
        return False
    rank, apart, unexplained = next_limit(floats, lane, mark)
    known = lane.steady_mark == mark - 1
    lane.steady_mark = mark
    if not known or mark < lane.next_trial or not (apart <= lane.threshold):
        return False
    if not (unexplained <= (1.0 - SLOWEST) * lane.threshold):
        return False
    if not (limit_distance(floats, lane, mark) <= FARTHEST_LIMIT) or not multipliers_within(floats, rank, SLOWEST):
        return False
    if not same_sides(floats, lane, mark):
        return False
    keep_lane(floats, ints, lane)
    go_to_limit(floats, lane, mark)
    lane.on_trial = 1
    return True


def trial_fails(floats, ints, lane):
    if lane.on_trial != 1:
        return False
    mark = lane.period_count - 1
    away = 0.0
    for i in range(STATES):
        if i != CYCLIC:
            now = lane.state[i] / lane.scale[i]
            away = max(away, abs(now - lane.steady[i]))
    left = LEFT_TO_GO * lane.threshold
    if away <= RETURN * lane.threshold and lane.modes == lane.last_modes:
        rank = weights_of(floats, MARKS, lane, mark, 1)
        if multipliers_within(floats, rank, left / (away + left)):
            lane.on_trial = 2
            return False
    put_back(floats, ints, lane)
    return True


def ends_trial(floats, ints, lane):
    if lane.on_trial != 1:
        return False
    put_back(floats, ints, lane)
    return True


def at_ease(ints, lane):
    """Whether no contact is just about to be decided."""
    settled = True
    for c in range(CONTACTS):
        settled = settled and lane.transition[c] == MODE_HOLDS
    return settled


def present_sides(floats, lane):
    """A number for the sides of all contacts."""
    number = 0
    for c in range(CONTACTS):
        number = (3 * number + int(lane.side[c] + 1.0)) % MODULUS
    return number


def next_limit(floats, lane, mark):
    """Write the limit of the marks up to this one: (rank, distance from the limit before, what is left of u_3)."""
    rank = weights_of(floats, MARKS, lane, mark, 1)
    apart = 0.0
    for i in range(MARK_SIZE):
        limit = mark_entry(floats, MARKS, lane, mark, i) + distance_to_limit(floats, rank, i)
        apart = max(apart, abs(limit - lane.steady[i]))
        lane.steady[i] = limit
    return rank, apart, unexplained_step(floats)


def limit_distance(floats, lane, mark):
    """Distance of the limit from the mark."""
    largest = 0.0
    for i in range(MARK_SIZE):
        largest = max(largest, abs(lane.steady[i] - mark_entry(floats, MARKS, lane, mark, i)))
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
        to_go = lane.steady[i] - mark_entry(floats, MARKS, lane, mark, i)
        floats[WORK + i] = lane.state[i] + to_go * lane.scale[i]


def same_sides(floats, lane, mark):
    """Whether contacts that slide do so at the limit too."""
    to_point(floats, lane, mark)
    for c in range(CONTACTS):
        if STICKS[c] + KINKS[c] > 0:
            side = lane.side[c]
            if side != 0.0 and not (side * contact_velocity(floats, lane.time, WORK, c, lane) > 0.0):
                return False
    return True


def go_to_limit(floats, lane, mark):
    """Put the lane at the limit; contacts that stick have no velocity there."""
    to_point(floats, lane, mark)
    for c in range(CONTACTS):
        if STICKS[c] == 1 and lane.side[c] == 0.0:
            floats[WORK + STATE_OF[c]] -= contact_velocity(floats, lane.time, WORK, c, lane)
    for i in range(STATES):
        lane.state[i] = floats[WORK + i]
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


def put_back(floats, ints, lane):
    """Put back what was kept, as a trial has been refused."""
    refused = lane.refused_trials + 1
    place = KEPT + lane
    for entry in range(0, KEPT, LANES):
        floats[entry + lane] = floats[place]
        place += LANES
    for entry in range(0, PERIOD_BUDGET, LANES):
        ints[entry + lane] = int(floats[place])
        place += LANES
    lane.refused_trials = refused
    lane.next_trial = lane.period_count + 1 + (1 << min(refused - 1, MOST_DOUBLINGS))
