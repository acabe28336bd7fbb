"""sin, cos, exp, log, tanh and atan, of all lanes at once or of one motion alone.

The C library's functions take one number at a time, which would keep a kernel from vector registers, and a call of them
empties the registers. These polynomials are those of fdlibm (sin, cos), Taylor polynomials (exp, tanh), the series of
artanh (log) and the rational function of the Cephes library (atan; S. L. Moshier, Methods and Programs for Mathematical
Functions, 1989): right to about an ulp. Those of every step are summed by pairs, so that little waits for them long.
"""

import math

from vibrocap.numerics.kernel.arithmetic.plain_vectors import exponent, floor, mantissa, power_of_two, where

LARGEST_EXPONENT = 709.782712893384  # exp of more overflows


def sine_cosine(x):
    """(sin x, cos x). Beyond |x| of about 1e6 the error grows like the rounding of x itself."""
    k = floor(x * 0.6366197723675814 + 0.5)
    r = x - k * 1.5707963267341256  # pi/2 in three parts, the first two short enough for exact products
    r = r - k * 6.077100506303966e-11
    r = r - k * 2.0222662487959506e-21
    z = r * r
    w = z * z
    s = (-1.66666666666666324348e-01 + 8.33333333332248946124e-03 * z) + w * (
        (-1.98412698298579493134e-04 + 2.75573137070700676789e-06 * z)
        + w * (-2.50507602534068634195e-08 + 1.58969099521155010221e-10 * z)
    )
    sine = r + r * z * s
    c = (4.16666666666666019037e-02 - 1.38888888888741095749e-03 * z) + w * (
        (2.48015872894767294178e-05 - 2.75573143513906633035e-07 * z)
        + w * (2.08757232129817482790e-09 - 1.13596475577881948265e-11 * z)
    )
    cosine = 1.0 - (0.5 * z - w * c)
    quadrant = k - 4.0 * floor(0.25 * k)
    odd = (quadrant == 1.0) | (quadrant == 3.0)
    first = where(odd, cosine, sine)
    second = where(odd, sine, cosine)
    first = where(quadrant >= 2.0, -first, first)
    second = where((quadrant == 1.0) | (quadrant == 2.0), -second, second)
    return first, second


def exponential(x):
    """exp x; below the smallest normal number zero."""
    k, rest = exponential_parts(x)
    p = (2.0 + 2.0 * rest) * power_of_two(k - 1.0)  # of the largest x, 2^k itself would be none
    return where(x < -708.0, 0.0, where(x > LARGEST_EXPONENT, math.inf, p))


def exponential_parts(x):
    """(k, y) with exp x = (1 + y) 2^k, |y| < 0.42."""
    k = floor(x * 1.4426950408889634 + 0.5)
    r = x - k * 0.6931471803691238
    r = r - k * 1.9082149292705877e-10
    z = r * r
    w = z * z
    low = (0.5 + 1.6666666666666666e-01 * r) + z * (4.1666666666666664e-02 + 8.333333333333333e-03 * r)
    middle = (1.388888888888889e-03 + 1.984126984126984e-04 * r) + z * (
        2.48015873015873e-05 + 2.7557319223985893e-06 * r
    )
    high = (2.755731922398589e-07 + 2.505210838544172e-08 * r) + z * (2.08767569878681e-09 + 1.6059043836821613e-10 * r)
    return k, r + z * (low + w * (middle + w * high))


def logarithm(x):
    """log x for x > 0; -inf at 0, nan below."""
    m = mantissa(x)
    e = exponent(x)
    high = m > 1.4142135623730951
    m = where(high, 0.5 * m, m)
    e = where(high, e + 1.0, e)
    f = (m - 1.0) / (m + 1.0)
    z = f * f
    p = 1.0 / 23.0 * z + 1.0 / 21.0
    p = p * z + 1.0 / 19.0
    p = p * z + 1.0 / 17.0
    p = p * z + 1.0 / 15.0
    p = p * z + 1.0 / 13.0
    p = p * z + 1.0 / 11.0
    p = p * z + 1.0 / 9.0
    p = p * z + 1.0 / 7.0
    p = p * z + 1.0 / 5.0
    p = p * z + 1.0 / 3.0
    p = 2.0 * f + 2.0 * f * z * p
    p = e * 0.6931471803691238 + (e * 1.9082149292705877e-10 + p)
    return where(x > 0.0, p, where(x == 0.0, -math.inf, math.nan))


def hyperbolic_tangent(x):
    """tanh x = m/(m + 2) with m = exp(2x) - 1, which keeps its digits near zero; beyond |x| = 20 it is +-1."""
    a = abs(x)
    y = where(a > 20.0, 40.0, 2.0 * a)
    k, p = exponential_parts(y)
    scale = power_of_two(k)
    m = scale * p + (scale - 1.0)
    t = m / (m + 2.0)
    return where(x < 0.0, -t, t)


def arc_tangent(x):
    """atan x, from the arc tangent of x, of -1/x or of (x - 1)/(x + 1), whichever is nearest to zero."""
    a = abs(x)
    steep, middle = a > 2.414213562373095, a > 0.66  # tan(3 pi/8)
    t = where(steep, -1.0 / where(steep, a, 1.0), where(middle, (a - 1.0) / (a + 1.0), a))
    start = where(steep, 1.5707963267948966, where(middle, 0.7853981633974483, 0.0))
    rest = where(steep, 6.123233995736766e-17, where(middle, 3.061616997868383e-17, 0.0))  # of pi/2, pi/4
    z = t * t
    p = -8.750608600031904122785e-01 * z - 1.615753718733365076637e01
    p = p * z - 7.500855792314704667340e01
    p = p * z - 1.228866684490136173410e02
    p = p * z - 6.485021904942025371773e01
    q = z + 2.485846490142306297962e01
    q = q * z + 1.650270098316988542046e02
    q = q * z + 4.328810604912902668951e02
    q = q * z + 4.853903996359136964868e02
    q = q * z + 1.945506571482613964425e02
    y = start + (t + (t * (z * p / q) + rest))
    return where(x < 0.0, -y, y)
