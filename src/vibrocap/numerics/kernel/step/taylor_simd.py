"""The Taylor step of all lanes at once, see `taylor.py`: its length, and a value of a series.

To the last bit as there, but for what LLVM fuses: the lengths of stiff steps hang on the last coefficients, which hang
on what is left of disturbances that have decayed, and a cycle is one whether its steps were taken together or alone.
"""

from vibrocap.numerics.kernel.arithmetic.plain_vectors import bits, exponent, load, mantissa, power_of_two, where
from vibrocap.numerics.kernel.generated.branches import BRANCHES, LAW_BRANCHES, LOCATED, SWITCH, SWITCHES
from vibrocap.numerics.kernel.generated.ensemble import INVERSE_SCALE
from vibrocap.numerics.kernel.generated.facts import STATE_OF, STICKS
from vibrocap.numerics.kernel.generated.lane import HOLD_RATE, PERIOD, SERIES, SIDE, TOLERANCE
from vibrocap.numerics.kernel.generated.rows import HOLD_OF, LIMIT_OF, VELOCITY_OF
from vibrocap.numerics.kernel.generated.sizes import CONTACTS, LANES, ORDER, STATES
from vibrocap.numerics.kernel.step.taylor import NEAREST, OMITTED, SAFETY


def lesser(x, y):
    """The lesser of two numbers per lane; y where x is not a number."""
    return where(x < y, x, y)


def greater(x, y):
    """The greater of two numbers per lane; y where x is not a number."""
    return where(x > y, x, y)


def taylor_steps(floats, side):
    """(`taylor.taylor_step`, last term, last but one, where no bound is near) of all lanes.

    The step is 0 where a coefficient is not a number.
    """
    last = 0.0 * side
    before = 0.0 * side
    for i in range(STATES):
        inverse = load(floats, INVERSE_SCALE + i * LANES)
        last = greater(abs(load(floats, SERIES + (i * (ORDER + 1) + ORDER) * LANES)) * inverse, last)
        before = greater(abs(load(floats, SERIES + (i * (ORDER + 1) + ORDER - 1) * LANES)) * inverse, before)
    for c in range(CONTACTS):
        if VELOCITY_OF[c] != SERIES + STATE_OF[c] * (ORDER + 1) * LANES:
            inverse = load(floats, INVERSE_SCALE + STATE_OF[c] * LANES)
            last = greater(abs(load(floats, VELOCITY_OF[c] + ORDER * LANES)) * inverse, last)
            before = greater(abs(load(floats, VELOCITY_OF[c] + (ORDER - 1) * LANES)) * inverse, before)
    for c in range(CONTACTS):
        if STICKS[c] == 1:
            limit = load(floats, LIMIT_OF[c])
            holding = (load(floats, SIDE + c * LANES) == 0.0) & (limit > 0.0)
            inverse = 1.0 / where(holding, limit, 1.0)
            share = abs(load(floats, HOLD_OF[c] + (ORDER - 1) * LANES)) * inverse
            before = where(holding, greater(share, before), before)
            share = abs(load(floats, HOLD_OF[c] + (ORDER - 2) * LANES)) * inverse * load(floats, HOLD_RATE)
            last = where(holding, greater(share, last), last)
    newest, decisive, earlier = last, before, 0.0 * side
    for i in range(LAW_BRANCHES, BRANCHES):
        row = SWITCH + i * (ORDER + 1) * LANES
        newest = greater(abs(load(floats, row + ORDER * LANES)), newest)
        decisive = greater(abs(load(floats, row + (ORDER - 1) * LANES)), decisive)
    for i in range(LAW_BRANCHES):
        row = SWITCH + i * (ORDER + 1) * LANES
        decisive = greater(abs(load(floats, row + (ORDER - 1) * LANES)), decisive)
        earlier = greater(abs(load(floats, row + (ORDER - 2) * LANES)), earlier)
    wanted = rough_logarithms(load(floats, TOLERANCE))
    one = (wanted * (1.0 / ORDER) + SAFETY) - rough_logarithms(newest) * (1.0 / ORDER)
    other = (wanted * (1.0 / (ORDER - 1)) + SAFETY) - rough_logarithms(decisive) * (1.0 / (ORDER - 1))
    h = rough_powers(lesser(one, other))
    if LAW_BRANCHES:
        h = lesser(h, reaches(wanted, earlier, ORDER - 2))
    clear = side == side
    if BRANCHES < SWITCHES:
        clear = clear_of_bounds_simd(floats, h)
        if bits(~clear) != 0:
            for i in range(BRANCHES, SWITCHES):
                if LOCATED[i] == 1:
                    row = SWITCH + i * (ORDER + 1) * LANES
                    bound = lesser(h, reaches(wanted, abs(load(floats, row + (ORDER - 1) * LANES)), ORDER - 1))
                    bound = lesser(bound, reaches(wanted, abs(load(floats, row + (ORDER - 2) * LANES)), ORDER - 2))
                    h = where(clear, h, bound)
    return where(newest <= 1e300, h, 0.0), last, before, clear


def reaches(wanted, terms, k):
    """`taylor.reach` of all lanes."""
    return rough_powers((wanted * (1.0 / k) + SAFETY) - rough_logarithms(terms) * (1.0 / k))


def clear_of_bounds_simd(floats, h):
    """Where every bound of the equations holds over steps of length h beyond doubt, see `taylor.stays_positive`."""
    h = lesser(h, load(floats, PERIOD))
    clear = h == h
    for i in range(BRANCHES, SWITCHES):
        row = SWITCH + i * (ORDER + 1) * LANES
        if LOCATED[i] == 1:
            others = OMITTED * abs(load(floats, row + (ORDER - 1) * LANES)) * h
            others = others + OMITTED * abs(load(floats, row + (ORDER - 2) * LANES))
            for k in range(ORDER - 3, 3, -1):
                others = others * h + abs(load(floats, row + k * LANES))
            clear = clear & (least_of_cubic(floats, row, others, h) > 0.0)
        else:
            clear = clear & (load(floats, row) > 0.0)
    return clear


def least_of_cubic(floats, row, others, h):
    """A bound from below of a series over a step: the Bernstein coefficients of its first four terms.

    others: of all others, over h^4, which are largest at the end of the step
    """
    first = load(floats, row)
    second = load(floats, row + LANES) * h
    third = load(floats, row + 2 * LANES) * h * h
    fourth = (load(floats, row + 3 * LANES) - others * h) * h * h * h
    return least_of_four(first, second, third, fourth)


def least_of_four(first, second, third, fourth):
    """The least Bernstein coefficient over the unit interval of a polynomial of these coefficients."""
    early = first + second * (1.0 / 3.0)
    late = early + (second + third) * (1.0 / 3.0)
    return lesser(lesser(first, early), lesser(late, first + second + third + fourth))


def rough_logarithms(x):
    """`taylor.rough_logarithm` of all lanes."""
    return exponent(x) + (mantissa(x) - 1.0)


def rough_powers(y):
    """`taylor.rough_power` of all lanes."""
    ints = (y + NEAREST) - NEAREST
    g = y - ints
    return (1.00044 + g * (0.70345 + 0.23843 * g)) * power_of_two(ints)


def series_values(floats, row, h):
    """`taylor.series_value` of all lanes."""
    square = h * h
    one = load(floats, row + ORDER * LANES)
    other = load(floats, row + (ORDER - 1) * LANES)
    for k in range(ORDER - 2, 0, -2):
        one = one * square + load(floats, row + k * LANES)
        other = other * square + load(floats, row + (k - 1) * LANES)
    if ORDER % 2:
        return other + h * one
    return load(floats, row) + h * (other + h * one)
