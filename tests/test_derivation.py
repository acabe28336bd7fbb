"""From the paper's energies to the code: (2)-(5) and (9) derived with SymPy, and the code proven equal to them.

The first half is the paper on its own: the Lagrangian gives (2) and (3), the scales give (4) and (5), these solved for
the accelerations give (9), and from (9) follow the identities of docs/model.md. The second half hands the same
symbols to the functions of the package, which compute on anything that knows `+ - * /`, sin, cos and exp.
"""

from types import SimpleNamespace

import pytest
import sympy as sp

import vibrocap as vc
from thinned import slow_but

# Dimensionless, as in docs/model.md. `turn` and `push` are theta'' and X'', R is N f, D the drive's torque.
lam, rho, nu, amplitude, omega, load = sp.symbols("lambda rho nu h omega N", positive=True)
theta, rate, position, velocity, turn, push = sp.symbols("theta theta_1 X X_1 theta_2 X_2", real=True)
tau, D, R = sp.symbols("tau D R", real=True)
STATE = (theta, rate, position, velocity)

P = D + sp.sin(theta) - rho * theta - nu * rate
HOLD = sp.cos(theta) * P - sp.sin(theta) * rate**2
B = lam + 1 - sp.cos(theta) ** 2
EQUATION_4 = turn - sp.cos(theta) * push - sp.sin(theta) + rho * theta + nu * rate - D
EQUATION_5 = -sp.cos(theta) * turn + (lam + 1) * push + sp.sin(theta) * rate**2 + R
ENERGY = (
    (lam + 1) * velocity**2 / 2 + rate**2 / 2 - sp.cos(theta) * rate * velocity + rho * theta**2 / 2 + sp.cos(theta)
)
MOMENTUM = (lam + 1) * velocity - sp.cos(theta) * rate


def zero(expression) -> bool:
    return sp.simplify(expression) == 0


@pytest.fixture(scope="module")
def accelerations():
    """(theta'', X'') from (4) and (5)."""
    solved = sp.solve((EQUATION_4, EQUATION_5), (turn, push), dict=True)
    assert len(solved) == 1
    return solved[0][turn], solved[0][push]


def along(expression, accelerations):
    """d/dtau of a function of the state along the motion."""
    rates = (rate, accelerations[0], velocity, accelerations[1])
    return sum(sp.diff(expression, y) * y_rate for y, y_rate in zip(STATE, rates, strict=True))


# --- the paper -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def dimensional():
    """The two equations of motion from the Lagrangian (1), left side less right side, and their symbols."""
    M, m, l, g, k, c, A, Omega, N0, F = sp.symbols("M m l g k c A Omega N_0 F", positive=True)  # noqa: E741
    t = sp.symbols("t", real=True)
    angle, x = sp.Function("theta")(t), sp.Function("x")(t)
    dx, dangle = x.diff(t), angle.diff(t)
    kinetic = M * dx**2 / 2 + m * ((dx - l * dangle * sp.cos(angle)) ** 2 + (-l * dangle * sp.sin(angle)) ** 2) / 2
    lagrangian = kinetic - (k * angle**2 / 2 + m * g * l * sp.cos(angle))
    friction, applied = (c * dangle, N0 * F), (A * sp.cos(Omega * t), 0)
    equations = tuple(
        lagrangian.diff(q.diff(t)).diff(t) - lagrangian.diff(q) + F_i - Q_i
        for q, F_i, Q_i in zip((angle, x), friction, applied, strict=True)
    )
    return SimpleNamespace(
        equations=equations, M=M, m=m, l=l, g=g, k=k, c=c, A=A, Omega=Omega, N0=N0, F=F, t=t, angle=angle, x=x
    )


def test_equations_2_and_3_follow_from_the_lagrangian(dimensional):
    s = dimensional
    a, x, t = s.angle, s.x, s.t
    equation_2 = (
        s.m * s.l**2 * a.diff(t, 2) - s.m * s.l * sp.cos(a) * x.diff(t, 2) - s.m * s.g * s.l * sp.sin(a)
        + s.k * a + s.c * a.diff(t) - s.A * sp.cos(s.Omega * t)
    )  # fmt: skip
    equation_3 = (
        -s.m * s.l * sp.cos(a) * a.diff(t, 2) + (s.M + s.m) * x.diff(t, 2)
        + s.m * s.l * sp.sin(a) * a.diff(t) ** 2 + s.N0 * s.F
    )  # fmt: skip
    assert zero(s.equations[0] - equation_2)
    assert zero(s.equations[1] - equation_3)


def test_equations_4_and_5_are_2_and_3_in_the_scales_of_the_paper(dimensional):
    s = dimensional
    natural = sp.sqrt(s.g / s.l)  # omega_n, so that d/dt = omega_n d/dtau
    length = s.g / natural**2  # x0
    drive_torque, torque = s.A * sp.cos(s.Omega * s.t), s.m * s.l**2 * natural**2
    moved = [
        (s.angle.diff(s.t, 2), natural**2 * turn),
        (s.x.diff(s.t, 2), length * natural**2 * push),
        (s.angle.diff(s.t), natural * rate),
        (s.angle, theta),
    ]
    groups = {
        lam: s.M / s.m,
        rho: s.k / torque,
        nu: s.c / (s.m * s.l**2 * natural),
        D: drive_torque / torque,
        R: s.N0 / (s.m * s.l * natural**2) * s.F,
    }
    assert zero(s.equations[0].subs(moved) / torque - EQUATION_4.subs(groups))
    assert zero(s.equations[1].subs(moved) / (s.m * s.l * natural**2) - EQUATION_5.subs(groups))
    # h cos(omega tau) is that drive, and N = N0/(m g): one m g, not the weight on the contact (erratum 1).
    scaled = {amplitude: s.A / torque, omega: s.Omega / natural, tau: natural * s.t}
    assert zero(drive_torque / torque - (amplitude * sp.cos(omega * tau)).subs(scaled))
    assert zero(s.N0 / (s.m * s.l * natural**2) - s.N0 / (s.m * s.g))


@pytest.mark.parametrize(
    ("term", "printed_turn", "printed_push"),
    [
        ("drive", (lam + 1) * D, sp.cos(theta) * D),
        ("gravity", (lam + 1) * sp.sin(theta), sp.cos(theta) * sp.sin(theta)),
        ("spring", -(lam + 1) * rho * theta, -sp.cos(theta) * rho * theta),
        ("damper", -(lam + 1) * nu * rate, -sp.cos(theta) * nu * rate),
        ("rotation", -sp.sin(theta) * sp.cos(theta) * rate**2, -sp.sin(theta) * rate**2),
        ("friction", -R * sp.cos(theta), -R),
    ],
)
def test_equation_9_is_4_and_5_solved_term_by_term(accelerations, term, printed_turn, printed_push):
    for found, printed in zip(accelerations, (printed_turn, printed_push), strict=True):
        found = sp.expand(sp.simplify(found * B))
        without_loads = found.subs({D: 0, rho: 0, nu: 0, R: 0})
        derived = {
            "drive": found.coeff(D) * D,
            "spring": found.coeff(rho) * rho,
            "damper": found.coeff(nu) * nu,
            "friction": found.coeff(R) * R,
            "gravity": without_loads.subs(rate, 0),
            "rotation": without_loads - without_loads.subs(rate, 0),
        }
        assert zero(derived[term] - printed)
        assert zero(found - sum(derived.values()))  # nothing is left over


def test_energy_identity(accelerations):
    assert zero(along(ENERGY, accelerations) - (D * rate - nu * rate**2 - R * velocity))


def test_momentum_identity(accelerations):
    assert zero(along(MOMENTUM, accelerations) + R)
    # Without friction (lambda+1) X - sin(theta) is linear in time: its rate is the momentum.
    assert zero(along((lam + 1) * position - sp.sin(theta), accelerations) - MOMENTUM)


def test_stuck_capsule(accelerations):
    """The force for which X'' = 0 is the holding force, and with it theta'' = P."""
    (needed,) = sp.solve(accelerations[1], R)
    assert zero(needed - HOLD)
    assert zero(accelerations[0].subs(R, needed) - P)


def test_inertia_is_positive():
    """B > 0 for every angle, so that (9) can always be solved."""
    assert zero(B - (lam + sp.sin(theta) ** 2))


MIRROR = {theta: -theta, rate: -rate, position: -position, velocity: -velocity, D: -D, R: -R}


def test_half_period_symmetry(accelerations):
    """With the drive and the friction force reversed, the mirrored state has mirrored accelerations."""
    for acceleration in accelerations:
        assert zero(acceleration.subs(MIRROR, simultaneous=True) + acceleration)


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


def test_code_holding_force_stops_the_capsule():
    hold = MACHINE.contacts(TIME, WRAPPED_STATE, DRIVE)[0].holding_force
    assert zero(hold.expression - HOLD)
    turn_in_code, push_in_code = MACHINE.rates(TIME, WRAPPED_STATE, DRIVE, (hold,))[1::2]
    assert push_in_code.expression == 0  # with nothing to simplify: a stuck capsule does not creep by rounding
    assert zero(turn_in_code.expression - P)


def test_code_energy_powers_and_momentum():
    assert zero(MACHINE.energy(TIME, WRAPPED_STATE).expression - ENERGY)
    assert zero(MACHINE.momentum(TIME, WRAPPED_STATE).expression - MOMENTUM)
    powers = MACHINE.powers(TIME, WRAPPED_STATE, DRIVE, (0.0,))
    for found, derived in zip(powers, (D * rate, -nu * rate**2), strict=True):
        assert zero(found.expression - derived)


def test_code_normal_load():
    assert MACHINE.loads()[0].expression == load
    heavy = with_symbols(vc.PendulumCapsule, mass_ratio=lam, stiffness=rho, damping=nu, normal_load="weight")
    assert zero(heavy.loads()[0].expression - (lam + 1))


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


def test_code_drives():
    second, phase = sp.symbols("h_2 psi", real=True)
    harmonic = with_symbols(vc.Harmonic, amplitude=amplitude, frequency=omega)
    assert zero(harmonic.value(TIME).expression - amplitude * sp.cos(omega * tau))
    biharmonic = with_symbols(
        vc.Biharmonic, amplitude=amplitude, frequency=omega, second_amplitude=second, second_phase=phase
    )
    value = biharmonic.value(TIME).expression
    assert zero(value - amplitude * sp.cos(omega * tau) - second * sp.cos(2 * omega * tau + phase))
    # Half a period later the first harmonic has turned round and the second has not: only the first is odd.
    later = biharmonic.value(Symbolic(tau + sp.pi / omega)).expression
    assert zero(value + later - 2 * second * sp.cos(2 * omega * tau + phase))


def system_of_symbols(law):
    levels = {"coulomb_coefficient": eta_c, "static_coefficient": eta_s}
    if law is vc.Exponential:
        friction = with_symbols(law, **levels, decay_rate=decay)
    else:
        bristles = {"bristle_stiffness": stiff, "bristle_damping": damped, "viscous_damping": viscous}
        friction = with_symbols(law, **levels, **bristles, stribeck_velocity=stribeck, stribeck_exponent=2.0)
    drive = with_symbols(vc.Harmonic, amplitude=amplitude, frequency=omega)
    return vc.System(machine=MACHINE, friction=friction, drive=drive)


@pytest.mark.parametrize(
    ("law", "side"),
    slow_but([0, 3], [(vc.Exponential, 1), (vc.Exponential, -1), (vc.LuGre, 1), (vc.LuGre, -1)]),
)
def test_code_system_is_equation_9_and_balances_its_energy(accelerations, law, side):
    """The parts put together are (9) with N once (erratum 1), and the channels' powers add up to the energy's rate."""
    system = system_of_symbols(law)
    names = (*STATE, xi) if law is vc.LuGre else STATE
    flow = system.flow(TIME, tuple(Symbolic(y) for y in names), side)
    rates = tuple(y_rate.expression for y_rate in flow.rates)
    if law is vc.LuGre:
        g = load / stiff * (eta_c + (eta_s - eta_c) * sp.exp(-((velocity / stribeck) ** 2)))
        xi_rate = velocity * (1 - xi / g * side)
        force = stiff * xi + damped * xi_rate + viscous * velocity
        assert zero(rates[4] - xi_rate)
    else:
        force = side * load * (eta_c + (eta_s - eta_c) * sp.exp(-decay * side * velocity))
    applied = {D: amplitude * sp.cos(omega * tau), R: force}
    for found, derived in zip(rates, (rate, accelerations[0], velocity, accelerations[1]), strict=False):
        assert zero(found - derived.subs(applied))
    stored = flow.energy.expression + Symbolic.of(flow.contact_energy)
    gained = sum(sp.diff(stored, y) * y_rate for y, y_rate in zip(names, rates, strict=True))
    assert zero(gained - sum(Symbolic.of(power) for power in flow.powers))


def test_code_stuck_system():
    """Side 0: the capsule rests, the pendulum swings by P, and nothing slides."""
    flow = system_of_symbols(vc.Exponential).flow(TIME, WRAPPED_STATE, 0)
    rates = [Symbolic.of(y_rate) for y_rate in flow.rates]
    assert rates[3] == 0
    assert zero(rates[1] - P.subs(D, amplitude * sp.cos(omega * tau)))
    assert zero(flow.contacts[0].friction.expression - flow.contacts[0].held.expression)
    assert zero(Symbolic.of(flow.powers[2]))
