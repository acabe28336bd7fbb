"""Maps with known branches, in closed form: what the continuation is tested on without a single motion."""

import numpy as np

from vibrocap.orbits.maps.closing_map import OrbitClosing
from vibrocap.orbits.walk.residual import Residual
from vibrocap.orbits.walk.special_points import special_points_of_maps


class PlainMap(Residual):
    """A map u -> function(u, p) over a range of p, n times; derivatives by complex steps.

    mode_sequence: of (u, p), where pieces are to be told apart; breaks: of p, where no run finishes
    """

    def __init__(self, function, between=(0.0, 1.0), times=1, half=False, mode_sequence=None, breaks=None):
        self.function, self.between, self.times, self.half = function, between, times, half
        self.mode_sequence, self.breaks = mode_sequence or (lambda u, p: ""), breaks or (lambda p: False)

    special_points = staticmethod(special_points_of_maps)

    def point(self, u, p):
        return np.append(np.asarray(u, dtype=float), self.share(p))

    def image(self, x):
        u, p = x[:-1], self.between[0] + x[-1] * self.width  # complex, too
        for _ in range(self.times):
            u = np.asarray(self.function(u, p))
        return u

    def attempt(self, x, like=None):
        m = len(x) - 1
        columns = []
        for i in range(m + 1):
            moved = x.astype(complex)
            moved[i] += 1e-30j
            columns.append(np.imag(self.image(moved)) / 1e-30)
        derivative = np.column_stack(columns)
        image = np.real(self.image(x))
        return OrbitClosing(
            x=x,
            mismatch=image - x[:-1],
            jacobian=derivative[:, :m],
            slope=derivative[:, m],
            at_rest=np.zeros(m, dtype=bool),
            finished=not self.breaks(self.parameter(x)),
            mode_sequence=self.mode_sequence(x[:-1], self.parameter(x)),
            drift=float(x[0]),
            image=image,
        )

    def described(self, found):
        return {"state": dict(enumerate(found.point.x[:-1]))}

    def coarser(self):
        if self.half or self.times == 1:
            return None
        return PlainMap(self.function, self.between, self.times // 2, self.times == 2 and self.odd, self.mode_sequence)

    def finer(self):
        return PlainMap(self.function, self.between, 2 * self.times, False, self.mode_sequence)

    odd = False  # whether half of two applications is a half period


class OddMap(PlainMap):
    """The same for a half-period map: two applications are a period."""

    odd = True

    def coarser(self):
        if self.half or self.times == 1:
            return None
        return OddMap(self.function, self.between, self.times // 2, self.times == 2, self.mode_sequence)

    def finer(self):
        return OddMap(self.function, self.between, 2 * self.times, False, self.mode_sequence)


def henon(u, p, b=0.3):
    """x' = p - x^2 + b y, y' = x: fold at p = -(1-b)^2/4, flip at 3(1-b)^2/4, the next one at (1-b)^2 + (1+b)^2/4."""
    return p - u[0] ** 2 + b * u[1], u[0]


def delayed_logistic(u, p):
    """x' = p x (1 - y), y' = x: a pair of multipliers exp(+-i pi/3) at p = 2."""
    return p * u[0] * (1.0 - u[1]), u[0]


def transcritical(u, p):
    """Fixed points 0 and p, of which the larger is stable."""
    return ((1.0 + p - u[0]) * u[0],)


def odd_cubic(u, p):
    """u' = -p u + u^3: symmetric orbit u = 0 with multiplier -p, twins u = +-sqrt(p - 1)."""
    return (-p * u[0] + u[0] ** 3,)


def isola(u, p):
    """Fixed points on the ellipse x^2 + 4 (p - 1/2)^2 = 0.04."""
    return (u[0] + 0.5 * (u[0] ** 2 + 4.0 * (p - 0.5) ** 2 - 0.04),)


def bent(left, right, jump=0.0):
    """u' = p + left u for u < 0, p + right u + jump for u > 0: a corner at p = 0."""

    def function(u, p):
        return (p + (left * u[0] if np.real(u[0]) < 0.0 else right * u[0] + jump),)

    return function
