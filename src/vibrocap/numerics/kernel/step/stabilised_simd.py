"""Stabilised Taylor steps of all lanes at once, see `stabilised.py`."""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import bits, load, store, where
from vibrocap.numerics.kernel.generated.branches import BRANCHES, SWITCH, SWITCHES
from vibrocap.numerics.kernel.generated.ensemble import INVERSE_SCALE
from vibrocap.numerics.kernel.generated.facts import STATE_OF
from vibrocap.numerics.kernel.generated.lane import SERIES, TOLERANCE
from vibrocap.numerics.kernel.generated.rows import VELOCITY_OF
from vibrocap.numerics.kernel.generated.sizes import CONTACTS, LANES, ORDER, ROWS, STATES
from vibrocap.numerics.kernel.step.stabilised import (
    DAMPED_REACH,
    DAMPING,
    FILTER,
    FIRST_DAMPED,
    LENGTHS,
    LONGEST,
    PLAIN_REACH,
    SHARE,
    SHORTER,
)
from vibrocap.numerics.kernel.step.taylor_simd import clear_of_bounds_simd, greater, lesser


def stabilised_steps(floats, rate, longest, wanted):
    """(step lengths, lanes whose series have been damped for them), of the lanes `wanted`; `longest` of all others."""
    damped = wanted & ~wanted
    open_still = wanted & (rate * longest > PLAIN_REACH)
    h = lesser(DAMPED_REACH / rate, LONGEST * longest)
    longest = where(open_still, PLAIN_REACH / rate, longest)
    tolerance = SHARE * load(floats, TOLERANCE)
    for _ in range(LENGTHS):
        if bits(open_still) == 0:
            break
        found = open_still & (damping_errors(floats, h) <= tolerance)
        if BRANCHES < SWITCHES:
            found = found & clear_of_bounds_simd(floats, h)
        longest = where(found, h, longest)
        damped = damped | found
        open_still = open_still & ~found
        h = SHORTER * h
    if bits(damped) != 0:
        damp_simd(floats, damped)
    return longest, damped


def damping_errors(floats, h):
    """`stabilised.damping_error` of all lanes."""
    worst = 0.0 * h
    for i in range(STATES):
        row = SERIES + (i * (ORDER + 1) + FIRST_DAMPED) * LANES
        two = h * (FILTER[2] * load(floats, row + 2 * LANES))
        total = FILTER[0] * load(floats, row) + h * (FILTER[1] * load(floats, row + LANES) + two)
        worst = greater(abs(total) * load(floats, INVERSE_SCALE + i * LANES), worst)
    power = h * h
    for _ in range(FIRST_DAMPED - 2):
        power = power * h
    return worst * power


def damp_simd(floats, damped):
    """`stabilised.damp_series` of the lanes `damped`."""
    for i in range(ROWS):
        damp_rows(floats, SERIES + i * (ORDER + 1) * LANES, damped)
    for c in range(CONTACTS):
        if VELOCITY_OF[c] != SERIES + STATE_OF[c] * (ORDER + 1) * LANES:
            damp_rows(floats, VELOCITY_OF[c], damped)
    for i in range(SWITCHES):
        damp_rows(floats, SWITCH + i * (ORDER + 1) * LANES, damped)


def damp_rows(floats, row, damped):
    """`stabilised.damp_row` of the lanes `damped`."""
    for k in range(3):
        place = row + (FIRST_DAMPED + k) * LANES
        store(floats, place, load(floats, place) * where(damped, DAMPING[k], 1.0))
