"""Motions of capsules with stops in closed form: between two events they are linear.

Nothing of the package is used but, of steady motions, the order of the events. With z, z', X' and the drive's cosine
and sine as states a piece is y(t) = exp(M t) y(0); events are roots of a row of y, found by Newton's method. All this
is analytic, so that derivatives come from a small imaginary part, exact to rounding.
"""

import numpy as np
from scipy.linalg import expm
from scipy.optimize import brentq

SMALL = 1e-30  # imaginary part
NEXT = {"stick": ("side", 0), "slip_forward": ("side", 1), "slip_back": ("side", -1), "impact": ("touch", 1)}
NEXT["stop_opened"] = ("touch", 0)


class ExactCapsule:
    """A two-mass capsule with an elastic stop (`stop_stiffness`) or a rigid one (`restitution`), pulled from outside.

    values: numbers of machine, friction and drive by name; kinds: of the events of one response, in order
    side, touch: contact and stop at the start; periods: of the response
    """

    def __init__(self, values, kinds, side, touch, periods=1):
        self.values = dict(values)
        self.rigid = "restitution" in values
        self.kinds, self.start, self.periods = kinds, (side, touch), periods

    def _piece(self, values, side, touch):
        """(M, force between the masses as a row) of a piece."""
        stop = values["stop_stiffness"] if touch and not self.rigid else 0.0
        pull = [values["stiffness"] + stop, values["damping"], 0, 0, 0, -stop * values["gap"]]
        level = values["normal_load"] * values["coulomb_coefficient"]
        body = [0] * 6 if side == 0 else [each / values["mass_ratio"] for each in pull]
        if side != 0:
            body[5] -= side * level / values["mass_ratio"]
        matrix = np.zeros((6, 6), dtype=complex)
        matrix[0, 1] = 1
        for j in range(6):
            matrix[1, j] = -pull[j] + (values["amplitude"] if j == 3 else 0) - body[j]
            matrix[2, j] = body[j]
        matrix[3, 4], matrix[4, 3] = -values["frequency"], values["frequency"]
        return matrix, np.array(pull, dtype=complex)

    def events(self, state, periods, steps=600):
        """[(time, kind)] of the events of a motion past an elastic stop, in order.

        Guards are looked at in so many instants of a period, so that two of their zeros between neighbours are missed.
        """
        values, y, numbers = self.values, np.array([*state, 1.0, 0.0, 1.0]), []
        limit = values["normal_load"] * values["static_coefficient"]
        interval = 2 * np.pi / values["frequency"] / steps
        side, touch = self.start
        pieces = {}
        for n in range(periods * steps):
            left = interval
            while True:
                if (side, touch) not in pieces:
                    matrix, pull = (each.real for each in self._piece(values, side, touch))
                    pieces[side, touch] = matrix, pull, expm(matrix * interval)
                matrix, pull, whole = pieces[side, touch]
                end = (whole if left == interval else expm(matrix * left)) @ y
                sign = -1.0 if touch else 1.0
                guards = {
                    "stop_opened" if touch else "impact": (np.array([-sign, 0, 0, 0, 0, 0]), sign * values["gap"])
                }
                if side:
                    guards["rest"] = np.array([0, 0, side, 0, 0, 0]), 0.0
                else:
                    guards |= {"slip_forward": (-pull, limit), "slip_back": (pull, limit)}
                passed = [kind for kind, (row, level) in guards.items() if row @ end + level < 0.0]
                if not passed:
                    y = end
                    break
                later, kind = min((_passing(matrix, y, *guards[kind], left), kind) for kind in passed)
                y, left = expm(matrix * later) @ y, left - later
                if kind == "rest":
                    y[2], push = 0.0, pull @ y
                    kind, side = ("stick", 0) if abs(push) < limit else ("reversal", int(np.sign(push)))
                elif kind.startswith("slip"):
                    side = NEXT[kind][1]
                else:
                    touch = NEXT[kind][1]
                numbers.append(((n + 1) * interval - left, kind))
        return numbers

    def image(self, state, values, times, dip=None):
        """(state after a response, times of the events, least distance from the stop near the time `dip`)."""
        y, t, found, least = np.array([*state, 1.0, 0.0, 1.0], dtype=complex), 0.0, [], None
        side, touch = self.start
        end = self.periods * 2 * np.pi / values["frequency"]
        limit = values["normal_load"] * values["static_coefficient"]
        for kind, guess in (*zip(self.kinds, times, strict=True), ("end", end)):
            matrix, pull = self._piece(values, side, touch)
            if dip is not None and np.real(t) < dip < np.real(guess):
                turned, _ = _root(matrix, expm(matrix * (dip - t)) @ y, [0, 1, 0, 0, 0, 0], 0)
                least = values["gap"] - turned[0]
            y = expm(matrix * (guess - t)) @ y
            if kind == "end":
                break
            row, level = [0, 0, 1, 0, 0, 0], 0.0
            if kind in ("impact", "stop_opened"):
                row, level = [1, 0, 0, 0, 0, 0], values["gap"]
            elif kind.startswith("slip"):
                row, level = pull, limit if kind == "slip_forward" else -limit
            y, later = _root(matrix, y, row, level)
            t = guess + later
            found.append(t.real)
            if kind == "impact" and self.rigid:
                blow = (1 + values["restitution"]) * y[1]
                y[1], y[2] = y[1] - blow, y[2] + blow / (values["mass_ratio"] + 1)
                side = int(np.sign(y[2].real)) if side else side
            elif kind == "reversal":
                side = -side
            else:
                what, value = NEXT[kind]
                side, touch = (value, touch) if what == "side" else (side, value)
            if kind == "stick":
                y[2] = 0.0
        return y[:3], found, least

    def solved(self, state, path, times, dip=None):
        """(state and parameter where the motion closes and grazes near `dip`, or flips where that is None; error)."""
        unknown = np.array([*state, self.values[path]])
        for _ in range(8):
            gap, times = self._gap(unknown, path, times, dip)
            columns = []
            for j in range(4):
                moved = unknown + 1e-7 * (np.arange(4) == j)
                columns.append((self._gap(moved, path, times, dip)[0] - gap) / 1e-7)
            unknown = unknown - np.linalg.solve(np.array(columns).T, gap)
            if np.max(np.abs(gap)) < 1e-13:
                break
        return unknown.tolist(), float(np.max(np.abs(gap)))

    def _gap(self, unknown, path, times, dip):
        values = self.values | {path: unknown[3]}
        after, times, least = self.image(unknown[:3], values, times, dip)
        last = least if dip is not None else self._flips(unknown[:3], values, times)
        return np.real([*(after - unknown[:3]), last]), times

    def _flips(self, state, values, times):
        """det(J + 1), J the derivative of the image by the state."""
        moved = [state + 1j * SMALL * (np.arange(3) == j) for j in range(3)]
        columns = [self.image(each, values, times)[0].imag / SMALL for each in moved]
        return np.linalg.det(np.array(columns).T + np.eye(3))


def _root(matrix, y, row, level):
    """(state, time) at which a row of the state is at a level, near the state given; complex as the state may be."""
    t, row = 0.0, np.asarray(row)
    for _ in range(12):
        step = (level - row @ y) / (row @ (matrix @ y))
        y, t = expm(matrix * step) @ y, t + step
        if abs(step) < 1e-15:
            break
    return y, t


def _passing(matrix, y, row, level, longest):
    """Time at which row @ y + level falls to zero on a piece; 0 where it begins there."""

    def guard(t):
        return row @ expm(matrix * t) @ y + level

    first = 1e-9 * longest
    return brentq(guard, first, longest, xtol=1e-15, rtol=1e-14) if guard(first) > 0.0 else 0.0
