"""Steady motions of capsules with stops in 25 digits: between two events they are linear, so that they are known exactly.

Nothing of the package is used but the order of the events. With z, z', X' and the drive's cosine and sine as states a
piece is y(t) = exp(M t) y(0); events are roots of a row of y, found by Newton's method.
"""

import mpmath as mp

DIGITS = 25
NEXT = {"stick": ("side", 0), "slip_forward": ("side", 1), "slip_back": ("side", -1), "impact": ("touch", 1)}
NEXT["stop_opened"] = ("touch", 0)


class ExactCapsule:
    """A two-mass capsule with an elastic stop (`stop_stiffness`) or a rigid one (`restitution`), pulled from outside.

    values: numbers of machine, friction and drive by name; kinds: of the events of one response, in order
    side, touch: contact and stop at the start; periods: of the response
    """

    def __init__(self, values, kinds, side, touch, periods=1):
        self.values = {name: mp.mpf(value) for name, value in values.items()}
        self.rigid = "restitution" in values
        self.kinds, self.start, self.periods = kinds, (side, touch), periods

    def _piece(self, values, side, touch):
        """(M, force between the masses as a row) of a piece."""
        stop = values["stop_stiffness"] if touch and not self.rigid else mp.mpf(0)
        pull = [values["stiffness"] + stop, values["damping"], 0, 0, 0, -stop * values["gap"]]
        level = values["normal_load"] * values["coulomb_coefficient"]
        body = [0] * 6 if side == 0 else [each / values["mass_ratio"] for each in pull]
        if side != 0:
            body[5] -= side * level / values["mass_ratio"]
        matrix = mp.zeros(6)
        matrix[0, 1] = 1
        for j in range(6):
            matrix[1, j] = -pull[j] + (values["amplitude"] if j == 3 else 0) - body[j]
            matrix[2, j] = body[j]
        matrix[3, 4], matrix[4, 3] = -values["frequency"], values["frequency"]
        return matrix, pull

    def image(self, state, values, times, dip=None):
        """(state after a response, times of the events, least distance from the stop near the time `dip`)."""
        y, t, found, least = mp.matrix([*state, 1, 0, 1]), mp.mpf(0), [], None
        side, touch = self.start
        end = self.periods * 2 * mp.pi / values["frequency"]
        limit = values["normal_load"] * values["static_coefficient"]
        for kind, guess in (*zip(self.kinds, times, strict=True), ("end", end)):
            matrix, pull = self._piece(values, side, touch)
            if dip is not None and t < dip < guess:
                turned, _ = _root(matrix, _flow(matrix, y, dip - t), [0, 1, 0, 0, 0, 0], 0)
                least = values["gap"] - turned[0]
            y = _flow(matrix, y, guess - t)
            if kind == "end":
                break
            row, level = [0, 0, 1, 0, 0, 0], mp.mpf(0)
            if kind in ("impact", "stop_opened"):
                row, level = [1, 0, 0, 0, 0, 0], values["gap"]
            elif kind.startswith("slip"):
                row, level = pull, limit if kind == "slip_forward" else -limit
            y, later = _root(matrix, y, row, level)
            t = guess + later
            found.append(t)
            if kind == "impact" and self.rigid:
                blow = (1 + values["restitution"]) * y[1]
                y[1], y[2] = y[1] - blow, y[2] + blow / (values["mass_ratio"] + 1)
                side = int(mp.sign(y[2])) if side else side
            elif kind == "reversal":
                side = -side
            else:
                what, value = NEXT[kind]
                side, touch = (value, touch) if what == "side" else (side, value)
            if kind == "stick":
                y[2] = mp.mpf(0)
        return list(y[:3]), found, least

    def solved(self, state, path, times, dip=None):
        """The state and the value of a parameter at which the motion closes and grazes near `dip`; None: flips there."""
        with mp.workdps(DIGITS):
            unknown, times = [*map(mp.mpf, state), self.values[path]], [*map(mp.mpf, times)]
            for _ in range(8):
                gap, times = self._gap(unknown, path, times, dip)
                if mp.norm(gap) < mp.mpf(10) ** (8 - DIGITS):
                    break
                step = mp.mpf(10) ** -9
                columns = []
                for j in range(4):
                    moved = [value + (step if i == j else 0) for i, value in enumerate(unknown)]
                    columns.append((self._gap(moved, path, times, dip)[0] - gap) / step)
                change = mp.lu_solve(mp.matrix([[column[i] for column in columns] for i in range(4)]), -gap)
                unknown = [value + more for value, more in zip(unknown, change, strict=True)]
            return [float(value) for value in unknown], float(mp.norm(gap))

    def _gap(self, unknown, path, times, dip):
        values = self.values | {path: unknown[3]}
        after, times, least = self.image(unknown[:3], values, times, dip)
        last = least
        if dip is None:
            last = self._flips(unknown[:3], after, values, times)
        return mp.matrix([*(a - b for a, b in zip(after, unknown[:3], strict=True)), last]), times

    def _flips(self, state, after, values, times):
        """det(J + 1), J the derivative of the image by the state."""
        step, columns = mp.mpf(10) ** -12, []
        for j in range(3):
            moved = [value + (step if i == j else 0) for i, value in enumerate(state)]
            columns.append([(a - b) / step for a, b in zip(self.image(moved, values, times)[0], after, strict=True)])
        return mp.det(mp.matrix([[columns[j][i] for j in range(3)] for i in range(3)]) + mp.eye(3))


def _flow(matrix, y, t):
    """exp(M t) y, by the exponential series over short stretches."""
    stretches = max(1, int(mp.ceil(abs(t) * 4)))
    for _ in range(stretches):
        term, total, k = y.copy(), y.copy(), 0
        while mp.norm(term, mp.inf) > mp.mpf(10) ** (-DIGITS - 3):
            k += 1
            term = matrix * term * (t / stretches / k)
            total = total + term
        y = total
    return y


def _root(matrix, y, row, level):
    """(state, time) at which a row of the state is at a level, near the state given."""
    t, row = mp.mpf(0), mp.matrix([row])
    for _ in range(40):
        off = (row * y)[0] - level
        if abs(off) < mp.mpf(10) ** (3 - DIGITS):
            break
        step = -off / (row * (matrix * y))[0]
        y, t = _flow(matrix, y, step), t + step
    return y, t
