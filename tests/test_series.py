"""The generated series, rates and Jacobians against equations typed again in mpmath, and against themselves.

A series y(s) = sum c_k s^k is right if y' - f(t + s, y(s)) vanishes to its order. That residual is expanded in 50-digit
arithmetic by numerical differentiation, which knows nothing of the recurrences; what is left is their rounding, which
is measured in units of the largest coefficient at the same distance from the singularity.
"""

import math
import re

import mpmath as mp
import numpy as np
import pytest

import vibrocap as vc
from plain_kernels import PlainKernel, kernel_of
from thinned import slow_but
from vibrocap.numerics.codegen.jets import JetWriter
from vibrocap.numerics.expressions.graph import Graph, derivative, evaluate
from vibrocap.numerics.kernel.arithmetic.plain_vectors import where
from vibrocap.physics.elementary import atan, cos, exp, log, power, sin, sqrt, tanh

EPSILON = float(np.finfo(float).eps)
ORDER = 12
ROUNDING = 16  # operations behind a coefficient, per order
MACHINE = vc.PendulumCapsule(mass_ratio=1.7, stiffness=2.3, damping=0.9, normal_load=0.8)
HARMONIC = vc.Harmonic(amplitude=1.4, frequency=1.3)
BIHARMONIC = vc.Biharmonic(amplitude=1.4, frequency=1.3, second_amplitude=0.6, second_phase=0.5)
EXPONENTIAL = vc.Exponential(coulomb_coefficient=0.15, static_coefficient=0.4, decay_rate=3.0)


def lugre(exponent):
    return vc.LuGre(
        bristle_stiffness=20.0,
        bristle_damping=2.0,
        viscous_damping=0.3,
        coulomb_coefficient=0.15,
        static_coefficient=0.4,
        stribeck_velocity=0.4,
        stribeck_exponent=exponent,
    )


WEIGHT = vc.PendulumCapsule(mass_ratio=1.7, stiffness=2.3, damping=0.9, normal_load="weight")
SYSTEMS = {
    "exponential": vc.System(MACHINE, EXPONENTIAL, HARMONIC),
    "exponential, biharmonic": vc.System(MACHINE, EXPONENTIAL, BIHARMONIC),
    "exponential, weight": vc.System(WEIGHT, EXPONENTIAL, HARMONIC),
    "lugre": vc.System(MACHINE, lugre(2.0), HARMONIC),
    "lugre, alpha 1": vc.System(MACHINE, lugre(1.0), HARMONIC),
    "lugre, alpha 1.5, biharmonic": vc.System(MACHINE, lugre(1.5), BIHARMONIC),
    "lugre, alpha 3, biharmonic": vc.System(MACHINE, lugre(3.0), BIHARMONIC),
}
TIME, STATE = 0.7, (0.6, -0.8, 0.2, 0.25, 0.003)
CASES = [(name, side) for name, system in SYSTEMS.items() for side in (1, -1, 0) if side or "exp" in name]


def typed_again(system, t, y, side):
    """y' of docs/model.md, in mpmath; side 0 is the stuck capsule. Also the force that would hold it."""
    m, f, d = system.machine, system.friction, system.drive
    theta, rate, v = y[0], y[1], y[3]
    load = m.mass_ratio + 1 if m.normal_load == "weight" else m.normal_load
    drive = d.amplitude * mp.cos(d.frequency * t)
    if d.name == "biharmonic":
        drive += d.second_amplitude * mp.cos(2 * d.frequency * t + d.second_phase)
    torque = drive + mp.sin(theta) - m.stiffness * theta - m.damping * rate
    hold = mp.cos(theta) * torque - mp.sin(theta) * rate**2
    eta_c, eta_s = f.coulomb_coefficient, f.static_coefficient
    bristle_rate = []
    if f.name == "exponential":
        force = side * load * (eta_c + (eta_s - eta_c) * mp.exp(-f.decay_rate * side * v)) if side else hold
    else:
        xi = y[4]
        shape = mp.exp(-((side * v / f.stribeck_velocity) ** mp.mpf(f.stribeck_exponent)))
        g = load / f.bristle_stiffness * (eta_c + (eta_s - eta_c) * shape)
        bristle_rate = [v - side * v * xi / g]
        force = f.bristle_stiffness * xi + f.bristle_damping * bristle_rate[0] + f.viscous_damping * v
    b = m.mass_ratio + 1 - mp.cos(theta) ** 2
    turn = ((m.mass_ratio + 1) * torque - mp.sin(theta) * mp.cos(theta) * rate**2 - force * mp.cos(theta)) / b
    return [rate, turn, v, (hold - force) / b, *bristle_rate], hold


def state_of(system, side):
    y = list(STATE[: len(system.state_names)])
    y[3] *= side
    return y


def expanded(system, side) -> PlainKernel:
    """A kernel with the series of STATE in its memory."""
    kernel = kernel_of(system, ORDER)
    kernel.fill("TIME", TIME)
    kernel.fill("SIDE", side)
    kernel.fill("STATE", state_of(system, side))
    kernel["jet"](kernel.floats)
    return kernel


def sizes(coefficients):
    """M/r^k, a bound on coefficients [rows, order + 1]: what their rounding is relative to.

    M is the largest of the first three orders, since one alone may nearly vanish.
    """
    largest = np.abs(coefficients).max(axis=0)
    k = np.flatnonzero(largest)
    k = k[k > 2]
    start = largest[:3].max()
    radius = np.min((start / largest[k]) ** (1.0 / k), initial=1.0 if not k.size else np.inf)
    return start / radius ** np.arange(largest.size)


@pytest.mark.parametrize(("name", "side"), slow_but([0, 5, 10, 15], CASES))
def test_series_solves_the_equations(name, side):
    system = SYSTEMS[name]
    kernel = expanded(system, side)
    states = len(system.state_names)
    c = np.array([kernel.series(i) for i in range(states)])
    assert c[:, 0].tolist() == state_of(system, side)
    with mp.workdps(50):
        polynomials = [[mp.mpf(float(value)) for value in row] for row in c]

        def y(s):
            return [mp.polyval(row[::-1], s) for row in polynomials]

        allowed = sizes(c)
        for i in range(states):
            rate = mp.taylor(lambda s, i=i: typed_again(system, TIME + s, y(s), side)[0][i], 0, ORDER - 1)
            for k in range(ORDER):
                error = abs((k + 1) * polynomials[i][k + 1] - rate[k])
                assert error <= ROUNDING * (k + 1) * EPSILON * allowed[k + 1], (system.state_names[i], k + 1)
        assert kernel["VELOCITY_OF"][0] == kernel["SERIES"] + 3 * (ORDER + 1)  # the contact velocity is X'
        if system.friction.name == "exponential":
            # while the contact slides the series only begins with the force that would hold it
            hold = mp.taylor(lambda s: typed_again(system, TIME + s, y(s), side)[1], 0, ORDER - 1)
            for k in range(1 if side else ORDER):
                assert abs(kernel.series(states + 1)[k] - hold[k]) <= ROUNDING * (k + 1) * EPSILON * allowed[k + 1], k
            limit = system.machine.loads()[0] * system.friction.static_coefficient
            assert kernel.series(states + 2)[0] == pytest.approx(limit, rel=2 * EPSILON)
            assert not kernel.series(states + 2)[1:ORDER].any()


def test_stuck_contact_stays_exactly_at_rest():
    """With the holding force in place of R, every coefficient of X' after the first is exactly zero."""
    kernel = expanded(SYSTEMS["exponential, biharmonic"], 0)
    assert not kernel.series(4).any()
    assert kernel.series(2)[0] == STATE[2]
    assert not kernel.series(2)[1:].any()


# One expression per recurrence and per short cut of the writer; x is a state with x' = 1 + x/3, t the time.
EXPRESSIONS = {
    "sin": lambda x, t: sin(2.0 * x),
    "cos": lambda x, t: cos(x * x),
    "sin and cos of time": lambda x, t: sin(1.3 * t) * cos(1.3 * t + 0.2),
    "exp": lambda x, t: exp(-x * t),
    "exp of a square": lambda x, t: exp(-(x / 0.7) * (x / 0.7)),
    "log": lambda x, t: log(x * x + 0.3),
    "sqrt": lambda x, t: sqrt(1.0 + x * x),
    "tanh": lambda x, t: tanh(1.4 * x - 0.5 * t),
    "tanh of a square": lambda x, t: tanh(x * x),
    "atan": lambda x, t: atan(2.0 * x - t),
    "atan of a square": lambda x, t: atan(x * x),
    "power 1.7": lambda x, t: power(x / 0.9, 1.7),
    "power 3": lambda x, t: power(x / 0.9, 3.0),
    "power below": lambda x, t: 1.0 / power(x / 0.9, 1.7),
    "sqrt below": lambda x, t: 1.0 / sqrt(1.0 + x * x),
    "quotient": lambda x, t: (1.0 + t) / (2.0 + cos(x)),
    "inverse": lambda x, t: 0.7 / (1.0 + x),
    "multiple over": lambda x, t: (3.0 - 2.0 * x) / (1.0 + x * x),
    "constant divisor": lambda x, t: (x * t) / 3.0,
    "polynomial in time": lambda x, t: (2.0 * t * t - t + 1.0) * (t - 0.3),
    "linear forms": lambda x, t: -(4.0 - 3.0 * (x + 2.0)) * 0.5 - (0.5 - x),
    "sum minus itself": lambda x, t: x * t - (x * t + cos(x)),
    "square of a sum": lambda x, t: (x + t) * (x + t),
    "negated product": lambda x, t: -(x * (t - 2.0)) - (-1.0 * (-(x * cos(t)))),
    "of a constant": lambda x, t: sin(x - x) + 2.0 * t,
}


class Real:
    """A 50-digit number with the methods that `vibrocap.physics.elementary` asks of what is no float."""

    def __init__(self, value):
        self.value = mp.mpf(value)

    def _with(self, other, operation):
        return Real(operation(self.value, other.value if isinstance(other, Real) else mp.mpf(other)))

    def __add__(self, other):
        return self._with(other, lambda a, b: a + b)

    def __sub__(self, other):
        return self._with(other, lambda a, b: a - b)

    def __rsub__(self, other):
        return self._with(other, lambda a, b: b - a)

    def __mul__(self, other):
        return self._with(other, lambda a, b: a * b)

    def __truediv__(self, other):
        return self._with(other, lambda a, b: a / b)

    def __rtruediv__(self, other):
        return self._with(other, lambda a, b: b / a)

    def __pow__(self, other):
        return self._with(other, lambda a, b: abs(a) ** b)

    def __neg__(self):
        return Real(-self.value)

    __radd__, __rmul__ = __add__, __mul__

    def sin(self):
        return Real(mp.sin(self.value))

    def cos(self):
        return Real(mp.cos(self.value))

    def exp(self):
        return Real(mp.exp(self.value))

    def log(self):
        return Real(mp.log(self.value))

    def sqrt(self):
        return Real(mp.sqrt(self.value))

    def tanh(self):
        return Real(mp.tanh(self.value))

    def atan(self):
        return Real(mp.atan(self.value))


@pytest.mark.parametrize("name", EXPRESSIONS)
@pytest.mark.parametrize("x0", [0.8, 0.35])
def test_recurrences(name, x0):
    """x' = 1 + x/3 has the solution (x0 + 3) exp(s/3) - 3, so every expression is a known function of s.

    Its partial derivative is that of the same function, too.
    """
    expression, t0 = EXPRESSIONS[name], 0.4
    graph = Graph()
    x, t = graph.node("state", 0), graph.node("time")
    recorded = graph.expression(expression(x, t))
    writer = JetWriter(graph, [1.0 + x / 3.0])
    coefficients = [writer.coefficient(recorded.index, k) for k in range(ORDER + 1)]
    names = {"math": math, "floats": [x0], "STATE": 0, "LANES": 1, "lane": 0, "time": t0, "sliding_0": 1.0}
    names["where"] = where
    exec("\n".join(writer.code.lines), names)
    coefficients = [eval(value.text, names) for value in coefficients]
    with mp.workdps(50):
        exact = mp.taylor(
            lambda s: expression(Real((x0 + 3) * mp.exp(s / 3) - 3), Real(t0 + s)).value, mp.mpf(0), ORDER
        )
        slope = mp.diff(lambda y: expression(Real(y), Real(t0)).value, x0)
    assert evaluate([derivative(recorded, 0)], t0, [x0], 1.0, ())[0] == pytest.approx(
        float(slope), rel=1e-13, abs=1e-14
    )
    exact = np.array([float(value) for value in exact])
    intermediate = np.zeros((len(graph.nodes), ORDER + 1))  # rounding is relative to what the terms were made of
    for key, value in names.items():
        if node := re.fullmatch(r"n(\d+)_(\d+)", key):
            intermediate[int(node[1]), int(node[2])] = value
    assert np.all(
        np.abs(np.array(coefficients) - exact) <= 16 * np.arange(1, ORDER + 2) * EPSILON * sizes(intermediate)
    )


@pytest.mark.parametrize(("name", "side"), CASES)
def test_jacobian_is_exact(name, side):
    """Generated partial derivatives, time included, against 50-digit differences of the equations typed again."""
    system = SYSTEMS[name]
    kernel = kernel_of(system, ORDER)
    states, y = len(system.state_names), state_of(system, side)
    point, out = kernel["WORK"], kernel["WORK"] + 50
    kernel.floats[point : point + states] = y
    kernel.fill("SIDE", float(side))
    kernel["jacobian"](kernel.floats, TIME, point, 0, out)
    reshape = kernel.floats[out : out + states * (states + 1)].reshape(states, states + 1)
    with mp.workdps(50):
        for i in range(states):
            for j in range(states + 1):

                def moved(x, i=i, j=j):
                    z = [x if k == j else mp.mpf(value) for k, value in enumerate(y)]
                    return typed_again(system, x if j == states else mp.mpf(TIME), z, side)[0][i]

                exact = mp.diff(moved, mp.mpf([*y, TIME][j]))
                assert abs(reshape[i, j] - exact) <= 64 * EPSILON * np.abs(reshape).max(), (i, j)
    kernel["rates"](kernel.floats, TIME, point, 0, out)
    rates = [float(value) for value in typed_again(system, mp.mpf(TIME), [mp.mpf(v) for v in y], side)[0]]
    assert kernel.floats[out : out + states] == pytest.approx(rates, rel=64 * EPSILON)
