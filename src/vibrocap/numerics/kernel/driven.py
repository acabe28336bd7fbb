"""A friction law under an imposed motion: the kernel that follows it from sample to sample.

Velocity and load are linear between samples, so within an interval the rates of the internal states are smooth except
where the contact turns (the interval is cut there) and where a guard of the law falls to zero (the step is cut there).
Between these, an L-stable method (`driven_source.py`) takes steps under error control: of whole intervals, as a rule.

The trace holds time, velocity and load of all samples, then what is computed.
"""

import math

from vibrocap.numerics.kernel.codes import DONE, NOT_FINITE, RUNNING, STEP_UNDERFLOW, TOO_MANY_EVENTS, TOO_MANY_STEPS
from vibrocap.numerics.kernel.driven_generated import (
    GUARDS,
    MOVING,
    SET_VALUED,
    SHARP_INTERNAL,
    STATES,
    attempt,
    force,
    freeze,
    law,
    least_guard,
    reverse,
    switch,
)
from vibrocap.numerics.kernel.lane import at

JUMP_LIMIT = 1000  # in an interval between two samples
SHORTEST = 1e-14  # of the interval: below, a step is lost
EXPONENT = -0.2  # of the error in the choice of a step
RESOLVED = 0.2  # of the visible speed: the most by which a step changes a lower velocity
LEAPT = 2.0  # the error of a step over which a state changes too much to be sure of the law between
LOCATED = 1e-12  # of the interval: to which a jump is located


def switch_fallen(floats, ints):
    """Switch pieces of the law until every guard of the present one is positive."""
    while law.status == RUNNING:
        least, which = least_guard(floats, at.state, law.velocity, law.load, law.side)
        if least > 0.0:
            return
        switch(floats, at.state, which, law.velocity, law.load, law.side)
        law.jumps += 1
        if law.jumps > JUMP_LIMIT:
            law.status = TOO_MANY_EVENTS


def guard_after(floats, h):
    """The least guard at the end of a step of length h."""
    v, w = law.velocity + h * law.velocity_rate, law.load + h * law.load_rate
    return least_guard(floats, at.new, v, w, law.side)[0]


def located(floats, h, span):
    """Length within (0, h] of the step that ends where the least guard has just fallen; the step is taken.

    The guard is positive at 0 and fallen at h. Regula falsi on repeated steps (Illinois: an end that stays twice counts
    half), with a bisection now and then where that is slow.
    """
    low, high = 0.0, h
    moved = 0  # +1, -1: the end that moved last, low or high
    above = least_guard(floats, at.state, law.velocity, law.load, law.side)[0]
    below = guard_after(floats, h)
    within = LOCATED * span
    for i in range(200):
        if not (high - low > within):
            break
        x = low + (high - low) * above / (above - below) if i % 4 < 3 else 0.5 * (low + high)
        x = min(high - 0.4 * within, max(low + 0.4 * within, x))
        attempt(floats, law.side, x)
        value = guard_after(floats, x)
        if value > 0.0:
            low, above = x, value
            if moved == 1:
                below *= 0.5
            moved = 1
        else:
            high, below = x, value
            if moved == -1:
                above *= 0.5
            moved = -1
    attempt(floats, law.side, high)
    return high


def leaps(floats):
    """Whether a state changes by so much that a sharp function of it could hide between the stages of the step."""
    farthest = 0.0
    for i in range(MOVING):
        farthest = max(farthest, abs(law.new[i] - law.state[i]) * law.inverse_scale[i])
    return farthest > law.leap


def stretch(floats, ints, span, longest, v1, w1):
    """Follow the law over a time `span` on its side, to velocity v1 and load w1, by steps no longer than `longest`."""
    v0, w0 = law.velocity, law.load
    law.velocity_rate = (v1 - v0) / span
    law.load_rate = (w1 - w0) / span
    s = 0.0
    if GUARDS > 0:
        switch_fallen(floats, ints)
    while law.status == RUNNING:
        remaining = span - s
        h = min(law.step, longest)
        if h >= remaining:
            h = remaining
        elif 2.0 * h > remaining:
            h = 0.5 * remaining
        error = attempt(floats, law.side, h)
        if SHARP_INTERNAL and leaps(floats):
            error = max(error, LEAPT)
        if not (error <= 1.0):
            law.refused += 1
            law.step = h * max(0.1, 0.9 * error**EXPONENT)
            if not (law.step >= SHORTEST * span):
                law.status = STEP_UNDERFLOW if error < math.inf else NOT_FINITE
            continue
        law.steps += 1
        if law.steps > law.step_limit:
            law.status = TOO_MANY_STEPS
        if h < span or error > 0.5:
            proposed = h * min(6.0, 0.9 * max(error, 1e-10) ** EXPONENT)
            if h == law.step or error > 0.5 or proposed > law.step:  # else it was not the error that cut the step
                law.step = proposed
        fallen = False
        if GUARDS > 0:
            fallen = not (guard_after(floats, h) > 0.0)
            if fallen:
                h = located(floats, h, span)
        for i in range(STATES):
            law.state[i] = law.new[i]
        if h == remaining:
            law.velocity, law.load = v1, w1
        else:
            s += h
            law.velocity, law.load = v0 + s * law.velocity_rate, w0 + s * law.load_rate
        if fallen:
            switch_fallen(floats, ints)
        if h == remaining:
            return


def cover(floats, ints, span, v1, w1):
    """Follow the law over a time `span` on its side, to velocity v1 and load w1.

    Where the contact passes the speed below which friction drops, the time is cut: a long step from rest to far beyond
    would have no stage where friction changes, and not see it. Below that speed steps are bounded for the same reason.
    """
    visible, v0, end = law.visible_speed, law.side * law.velocity, law.side * v1
    change = abs(end - v0)
    if change <= RESOLVED * visible or min(v0, end) >= visible:
        stretch(floats, ints, span, math.inf, v1, w1)
        return
    longest = RESOLVED * visible / change * span
    share = (visible - v0) / (end - v0)
    if not (0.0 < share < 1.0):
        stretch(floats, ints, span, longest, v1, w1)
        return
    w = law.load + share * (w1 - law.load)
    stretch(floats, ints, share * span, longest if v0 < end else math.inf, law.side * visible, w)
    stretch(floats, ints, span - share * span, math.inf if v0 < end else longest, v1, w1)


def sign(v):
    """+1, -1 or 0."""
    if v > 0.0:
        return 1.0
    return -1.0 if v < 0.0 else 0.0


def first_side(trace, samples):
    """Side of the first motion; +1 where there is none."""
    for i in range(samples):
        side = sign(trace[samples + i])
        if side != 0.0:
            return side
    return 1.0


def write(floats, ints, trace, i, value):
    """Put the force and the internal states of sample i on the trace."""
    trace[law.force_start + i] = value
    start = law.internal_start
    if start >= 0:
        for j in range(STATES):
            trace[start + i * STATES + j] = law.state[j]


def follow(floats, ints, trace, samples):
    """Follow the law through all samples, from the states in memory; returns the number of samples completed."""
    law.side = first_side(trace, samples)
    freeze(floats, law.side)
    moved = not SET_VALUED
    law.velocity, law.load = trace[samples], trace[2 * samples]
    if GUARDS > 0:
        switch_fallen(floats, ints)
    for i in range(samples):
        if i > 0:
            law.jumps = 0
            span = trace[i] - trace[i - 1]
            v0, w0 = trace[samples + i - 1], trace[2 * samples + i - 1]
            v1, w1 = trace[samples + i], trace[2 * samples + i]
            before, after = sign(v0), sign(v1)
            if before * after < 0.0:  # it turns within the interval
                share = v0 / (v0 - v1)
                if share > 0.0:
                    cover(floats, ints, share * span, 0.0, w0 + share * (w1 - w0))
                law.velocity = 0.0
                span *= 1.0 - share
            present = after if after != 0.0 else before
            if present * law.side < 0.0:
                law.side = present
                freeze(floats, present)
                reverse(floats, at.state, law.load, present)
            if span > 0.0:
                cover(floats, ints, span, v1, w1)
            law.velocity, law.load = v1, w1
        if law.status != RUNNING:
            return i
        moved = moved or law.velocity != 0.0
        value = force(floats, at.state, law.velocity, law.load, law.side) if moved else 0.0
        if not (abs(value) <= 1e300):
            law.status = NOT_FINITE
            return i
        write(floats, ints, trace, i, value)
    law.status = DONE
    return samples
