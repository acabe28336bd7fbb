"""From the paper's energies to the code, with SymPy: (1) gives (2), (3); the code is (9), (8), (6), (7) and (10).

The functions of the package compute on anything that knows `+ - * /`, sin, cos and exp, so they take symbols. Scales,
signs and balances are asked of numbers: by the claims of the paper (`test_paper.py`) and by the contracts of the parts.
"""

import pytest
import sympy as sp

import vibrocap as vc

# Dimensionless, as in docs/model.md. `turn` and `push` are theta'' and X'', R is N f, D the drive's torque.
lam, rho, nu, load = sp.symbols("lambda rho nu N", positive=True)
theta, rate, position, velocity, turn, push = sp.symbols("theta theta_1 X X_1 theta_2 X_2", real=True)
tau, D, R = sp.symbols("tau D R", real=True)
STATE = (theta, rate, position, velocity)

EQUATION_4 = turn - sp.cos(theta) * push - sp.sin(theta) + rho * theta + nu * rate - D
EQUATION_5 = -sp.cos(theta) * turn + (lam + 1) * push + sp.sin(theta) * rate**2 + R


def zero(expression) -> bool:
    return sp.simplify(expression) == 0


@pytest.fixture(scope="module")
def accelerations():
    """(theta'', X'') from (4) and (5)."""
    solved = sp.solve((EQUATION_4, EQUATION_5), (turn, push), dict=True)
    assert len(solved) == 1
    return solved[0][turn], solved[0][push]


def test_equations_2_and_3_follow_from_the_lagrangian():
    M, m, l, g, k = sp.symbols("M m l g k", positive=True)  # noqa: E741
    t = sp.symbols("t", real=True)
    a, x = sp.Function("theta")(t), sp.Function("x")(t)
    along, across = x.diff(t) - l * a.diff(t) * sp.cos(a), l * a.diff(t) * sp.sin(a)
    lagrangian = M * x.diff(t) ** 2 / 2 + m * (along**2 + across**2) / 2 - k * a**2 / 2 - m * g * l * sp.cos(a)
    left = [lagrangian.diff(q.diff(t)).diff(t) - lagrangian.diff(q) for q in (a, x)]
    pendulum = m * l**2 * a.diff(t, 2) - m * l * sp.cos(a) * x.diff(t, 2) - m * g * l * sp.sin(a) + k * a
    capsule = (M + m) * x.diff(t, 2) - m * l * sp.cos(a) * a.diff(t, 2) + m * l * sp.sin(a) * a.diff(t) ** 2
    assert zero(left[0] - pendulum)
    assert zero(left[1] - capsule)


# --- the code equals the equations -----------------------------------------------------------------------------------


class Symbolic:
    """A SymPy expression in the guise of the numbers that the package computes with."""

    def __init__(self, expression):
        self.expression = expression

    @staticmethod
    def of(value):
        """The exact expression of a number or a wrapped expression."""
        return value.expression if isinstance(value, Symbolic) else sp.Rational(value)

    def __add__(self, other):
        return Symbolic(self.expression + self.of(other))

    def __sub__(self, other):
        return Symbolic(self.expression - self.of(other))

    def __rsub__(self, other):
        return Symbolic(self.of(other) - self.expression)

    def __mul__(self, other):
        return Symbolic(self.expression * self.of(other))

    def __truediv__(self, other):
        return Symbolic(self.expression / self.of(other))

    def __rtruediv__(self, other):
        return Symbolic(self.of(other) / self.expression)

    def __pow__(self, other):
        return Symbolic(self.expression ** self.of(other))

    def __neg__(self):
        return Symbolic(-self.expression)

    __radd__, __rmul__ = __add__, __mul__

    def sin(self):
        return Symbolic(sp.sin(self.expression))

    def cos(self):
        return Symbolic(sp.cos(self.expression))

    def exp(self):
        return Symbolic(sp.exp(self.expression))

    def log(self):
        return Symbolic(sp.log(self.expression))

    def sqrt(self):
        return Symbolic(sp.sqrt(self.expression))


def with_symbols(cls, **fields):
    """A record of the package with symbols for parameters; its checks, which ask for numbers, are passed by."""
    record = object.__new__(cls)
    for name, value in fields.items():
        object.__setattr__(record, name, Symbolic(value) if isinstance(value, sp.Expr) else value)
    return record


MACHINE = with_symbols(vc.PendulumCapsule, mass_ratio=lam, stiffness=rho, damping=nu, normal_load=load)
TIME, DRIVE, FORCE = Symbolic(tau), Symbolic(D), Symbolic(R)
WRAPPED_STATE = tuple(Symbolic(y) for y in STATE)


def test_code_rates_are_equation_9_in_first_order_form(accelerations):
    in_code = MACHINE.rates(TIME, WRAPPED_STATE, DRIVE, (FORCE,))
    for found, derived in zip(in_code, (rate, accelerations[0], velocity, accelerations[1]), strict=True):
        assert zero(found.expression - derived)


eta_c, drop, decay, speed = sp.symbols("eta_c Delta_eta a u", positive=True)
stiff, damped, viscous, stribeck, alpha, xi = sp.symbols("delta_0 delta_1 delta_2 v_s alpha xi", positive=True)
eta_s = eta_c + drop


@pytest.mark.parametrize("side", [1, -1])
def test_code_exponential_law_is_equation_8(side):
    law = with_symbols(vc.Exponential, coulomb_coefficient=eta_c, static_coefficient=eta_s, decay_rate=decay)
    v = side * speed
    force, internal = law.force(Symbolic(v), (), side, Symbolic(load))
    assert internal == ()
    assert zero(force.expression - load * (eta_c + (eta_s - eta_c) * sp.exp(-decay * sp.Abs(v))) * sp.sign(v))
    assert zero(law.holding_limit(Symbolic(load)).expression - load * eta_s)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("exponent", [1, 2, 3, alpha], ids=str)
def test_code_lugre_law_is_equations_6_7_and_10(side, exponent):  # a symbolic exponent is one that is not whole
    law = with_symbols(
        vc.LuGre,
        bristle_stiffness=stiff,
        bristle_damping=damped,
        viscous_damping=viscous,
        coulomb_coefficient=eta_c,
        static_coefficient=eta_s,
        stribeck_velocity=stribeck,
        stribeck_exponent=float(exponent) if isinstance(exponent, int) else exponent,
    )
    v = side * speed
    force, (xi_rate,) = law.force(Symbolic(v), (Symbolic(xi),), side, Symbolic(load))
    g = load / stiff * (eta_c + (eta_s - eta_c) * sp.exp(-(sp.Abs(v / stribeck) ** exponent)))
    printed_rate = v * (1 - xi / g * sp.sign(v))
    assert zero(xi_rate.expression - printed_rate)
    assert zero(force.expression - (stiff * xi + damped * printed_rate + viscous * v))
