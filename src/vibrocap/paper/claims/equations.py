"""Claims about the equations of motion and the friction laws, (1)-(9): checked at random points."""

import math
from typing import Any

import numpy as np

from vibrocap.paper.claims.claim import ROUNDING, Finding, Tolerance, claim, decided, printed, restricted
from vibrocap.paper.presets import figures_5_to_8
from vibrocap.paper.runs import Runs
from vibrocap.physics.drives.harmonics import Harmonic
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.friction.curves import Exponential
from vibrocap.physics.machines.pendulum_capsules import PendulumCapsule
from vibrocap.physics.system import System

POINTS = 200  # random points per check
STEP = 1e-30  # of the complex-step derivative, which has no cancellation


def _random() -> np.random.Generator:
    return np.random.default_rng(20190404)


def _random_systems():
    """Random systems, states and sides for which every term of the equations counts."""
    random = _random()
    for i in range(POINTS):
        ratio, rho, nu, load, h, omega = random.uniform(0.3, 3.0, 6)
        law = LuGre(viscous_damping=0.4) if i % 2 else Exponential()
        system = System(PendulumCapsule(ratio, rho, nu, load), law, Harmonic(h, omega))
        velocity = float(random.uniform(0.05, 0.6) * random.choice((-1.0, 1.0)))
        y = [*map(float, random.uniform(-1.5, 1.5, 3)), velocity]
        if law.internal:
            y.append(float(random.uniform(-0.0045, 0.0045) * load))
        yield system, float(random.uniform(0.0, 6.0)), y, math.copysign(1.0, velocity)


@claim(
    "sec. 2.2, (1)-(3)",
    "The Euler-Lagrange equations (1) with the printed energies give the equations of motion (2), (3).",
    ROUNDING,
)
def lagrangian(runs: Runs, tolerance: float) -> Finding:
    """At random points in SI units: d/dt dL/dq' - dL/dq + F - Q by polarisation and complex steps against (2), (3)."""
    worst = 0.0
    for m, big, length, k, c, torque, friction, g, *rest in _random().uniform(0.5, 2.0, (POINTS, 14)):
        q, rates, accelerations = np.array(rest[:2]), np.array(rest[2:4]), np.array(rest[4:6])

        def kinetic(q, v, m=m, big=big, length=length):
            along, across = v[1] - length * v[0] * np.cos(q[0]), -length * v[0] * np.sin(q[0])
            return 0.5 * big * v[1] ** 2 + 0.5 * m * (along**2 + across**2)

        def potential(q, m=m, k=k, length=length, g=g):
            return 0.5 * k * q[0] ** 2 + m * g * length * np.cos(q[0])

        def momenta(q, v, kinetic=kinetic):
            unit = np.eye(2)
            return np.array([kinetic(q, v + e) - kinetic(q, v) - kinetic(q, e) for e in unit])

        momentum_rate = np.imag(momenta(q + 1j * STEP * rates, rates + 1j * STEP * accelerations)) / STEP
        slope = [np.imag(kinetic(q + 1j * STEP * e, rates) - potential(q + 1j * STEP * e)) / STEP for e in np.eye(2)]
        expected = momentum_rate - slope + [c * rates[0] - torque, friction]
        s, co = math.sin(q[0]), math.cos(q[0])
        pendulum = m * length**2 * accelerations[0] - m * length * co * accelerations[1]
        pendulum += -m * g * length * s + k * q[0] + c * rates[0] - torque
        capsule = -m * length * co * accelerations[0] + (big + m) * accelerations[1]
        capsule += m * length * s * rates[0] ** 2 + friction
        worst = max(worst, float(np.max(np.abs(expected - np.array([pendulum, capsule])))))
    why = "The Lagrangian gives (2) and (3) term by term; the tests prove it symbolically as well."
    return Finding(decided(worst <= tolerance), {"largest residual": worst}, why)


@claim("sec. 2.2, (4), (5)", "Scaling by omega_n, l and m turns (2), (3) into the dimensionless (4), (5).", ROUNDING)
def scaling(runs: Runs, tolerance: float) -> Finding:
    """Accelerations solved from (2), (3) in SI units at random points, scaled, against those of the code."""
    worst = 0.0
    for m, big, length, k, c, torque, wave, g, force, angle, turn in _random().uniform(0.5, 2.0, (POINTS, 11)):
        rate = math.sqrt(g / length)
        unit = m * length**2 * rate**2
        machine = PendulumCapsule(big / m, k / unit, c / (m * length**2 * rate))
        s, co = math.sin(angle), math.cos(angle)
        mass = np.array([[m * length**2, -m * length * co], [-m * length * co, big + m]])
        drive = torque * math.cos(wave)
        load = [drive + m * g * length * s - k * angle - c * turn, -m * length * s * turn**2 - force]
        si = np.linalg.solve(mass, load) / [rate**2, length * rate**2]
        ours = machine.rates(0.0, (angle, turn / rate, 0.0, 0.0), drive / unit, (force / (m * g),))[1::2]
        worst = max(worst, float(np.max(np.abs(si - ours))))
    why = (
        "With lambda, rho, nu, h, omega and N as defined, both sets say the same; the printed length g/omega_n^2 is l."
    )
    return Finding(decided(worst <= tolerance), {"largest residual": worst}, why)


@claim("sec. 2.3.2, (9)", "The accelerations (9) solve (4) and (5).", ROUNDING)
def decoupling(runs: Runs, tolerance: float) -> Finding:
    """Residuals of (4) and (5) with the accelerations and the friction force of the code, over random systems."""
    worst = 0.0
    for system, t, y, side in _random_systems():
        m: Any = system.machine
        flow = system.flow(t, y, side)
        s, co, pendulum, capsule = math.sin(y[0]), math.cos(y[0]), flow.rates[1], flow.rates[3]
        fourth = pendulum - co * capsule - s + m.stiffness * y[0] + m.damping * y[1] - flow.drive
        fifth = -co * pendulum + (m.mass_ratio + 1) * capsule + s * y[1] ** 2 + flow.contacts[0].friction
        worst = max(worst, abs(fourth), abs(fifth))
    why = "(9) follows exactly from (4), (5); all printed signs are right, if N f is read as the force R."
    return Finding(decided(worst <= tolerance), {"largest residual": worst}, why)


@claim("sec. 2.3.2, (7)", "The bristles move by (7), the same as xi' = X' - |X'| xi/g(X').", ROUNDING)
def bristle_rate(runs: Runs, tolerance: float) -> Finding:
    """(7) as printed against the code at random velocities, deflections and parameters (alpha = 2)."""
    worst = 0.0
    for velocity, deflection, load in _random().uniform((-0.5, -0.004, 0.3), (0.5, 0.004, 3.0), (POINTS, 3)):
        law, sign = LuGre(), math.copysign(1.0, velocity)
        g = load / 100.0 * (0.15 + 0.3 * math.exp(-((velocity / 0.1) ** 2)))
        _, (rate,) = law.force(velocity, (deflection,), sign, load)
        worst = max(worst, abs(rate - velocity * (1 - deflection / g * sign)))
    return Finding(decided(worst <= tolerance), {"largest residual": worst}, "X' sgn(X') is |X'|.")


@claim(
    "sec. 2.2, 2.3.2, (5), (8)-(10)",
    "The friction force in (5) and (9) is N f, with N contained in f by (8) and in g by (10).",
    ROUNDING,
)
def load_counted_twice(runs: Runs, tolerance: float) -> Finding:
    """The force of (5) with f of (8) taken literally, N^2 [...], over the force per load: sliding at X' = 0.1."""
    law = Exponential()
    literal = {n: n * law.steady_force(0.1, n) for n in (1.0, 2.0, 3.5)}
    once = {n: law.steady_force(0.1, n) for n in literal}
    ratio = {f"R as printed / R at N = {n:g}": literal[n] / once[n] for n in literal}
    same_at_one = abs(literal[1.0] - once[1.0]) <= tolerance
    everywhere = all(abs(value - 1.0) <= tolerance for value in ratio.values())
    return Finding(
        restricted(everywhere, same_at_one),
        ratio,
        "N is a factor of f in (8) and of N f in (5): taken literally friction grows with the square of the load.",
        "N = 1",
        "Friction with the factor N once; the paper's runs do not tell the difference, because they all have N = 1.",
    )


@claim("sec. 3, N = 1", "N = 1 is the normal load on the contact of the capsule.", printed("2.5"), "fig05")
def load_is_the_weight(runs: Runs, tolerance: float) -> Finding:
    """The weight on the contact in units of m g, lambda + 1, and the range of N(tau) over the settled motion (LM)."""
    period = runs.steady("lugre")
    machine: Any = period.motion.system.machine
    angle, turn, friction = period["angle"], period["angle_rate"], period["friction"]
    drive = np.array([period.motion.system.drive.value(float(t)) for t in period.time])
    rows = zip(angle, turn, period["position"], period["velocity"], drive, friction, strict=True)
    pendulum = np.array([machine.rates(0.0, tuple(row), d, (f,))[1] for *row, d, f in rows])
    dynamic = machine.mass_ratio + 1 - (pendulum * np.sin(angle) + turn**2 * np.cos(angle))
    heavy = runs.motion(figures_5_to_8("lugre").with_parameters({"machine.normal_load": "weight"}))
    return Finding(
        decided(abs(machine.mass_ratio + 1 - 1) <= tolerance),
        {
            "weight lambda + 1": machine.mass_ratio + 1,
            "least N(tau)": float(dynamic.min()),
            "largest N(tau)": float(dynamic.max()),
            "X(40T) with N = 1": float(runs.first_set("lugre").state["position"]),
            "X(40T) with N = lambda + 1": float(heavy.state["position"]),
        },
        "N is scaled by m g, so 1 is the weight of the pendulum alone; the capsule's own weight is left out.",
        nearest="N = lambda + 1 on a level floor; the load stays positive here, so the contact would not lift off.",
    )


@claim("sec. 2.3.2, 3, (8)", "The rate of the exponential law (8) is the alpha that is the exponent of (7).")
def one_alpha(runs: Runs, tolerance: float) -> Finding:
    """Friction of (8) at X' = 0.1 with its rate read as alpha = 2, against the value a = 10 given in section 3."""
    as_alpha = Exponential(decay_rate=2.0).steady_force(0.1, 1.0)
    as_a = Exponential().steady_force(0.1, 1.0)
    return Finding(
        decided(abs(as_alpha - as_a) <= tolerance * as_a),
        {"R(0.1), rate alpha = 2": as_alpha, "R(0.1), rate a = 10": as_a},
        "The symbol stands for two things: (9) calls the same rate a, and section 3 gives alpha = 2 and a = 10.",
        nearest="(8) with the rate a of (9).",
    )


@claim(
    "sec. 2.3.2, (7), (10)", "The Stribeck term is exp(-(X'/v_s)^alpha) for either direction and any alpha.", ROUNDING
)
def stribeck_term(runs: Runs, tolerance: float) -> Finding:
    """g as printed at X' = 0.1 and -0.1, for alpha = 2 and alpha = 1."""
    cases = [(power, v) for power in (2, 1) for v in (0.1, -0.1)]
    values = {f"exp(-(X'/v_s)^{power}) at X' = {v:g}": math.exp(-((v / 0.1) ** power)) for power, v in cases}
    forward, back, first, second = values.values()
    even, odd = abs(forward - back) <= tolerance, abs(first - second) <= tolerance
    return Finding(
        restricted(even and odd, even),
        values,
        "For an odd alpha g grows without bound backwards, and for a fractional alpha it is not real.",
        "even alpha",
        "exp(-|X'/v_s|^alpha), which the code uses.",
    )


@claim(
    "sec. 2.1",
    "The capsule is at rest at first and moves when the resultant force exceeds the threshold of static friction.",
    Tolerance(1e-8, "a hundred times the tolerance of the runs"),
    "fig05",
)
def start_of_motion(runs: Runs, tolerance: float) -> Finding:
    """The first slip of EM: its time, and the force needed to hold the capsule then; LM's movement until then."""
    motion = runs.first_set("exponential")
    first = motion.events[0]
    held = float(abs(motion.at([first.time], "holding_force")[0]))
    limit = motion.system.friction.holding_limit(motion.system.machine.loads()[0])
    early = float(np.max(np.abs(runs.first_set("lugre").at(np.linspace(0, first.time, 200), "velocity"))))
    sticks = first.kind.startswith("slip") and first.time > 0 and abs(held - limit) <= tolerance
    return Finding(
        restricted(sticks and early <= tolerance, sticks),
        {"EM: first slip at tau": first.time, "EM: |force| then": held, "LM: largest |X'| until then": early},
        "EM holds the capsule until N eta_s is reached; LM's bristles give way from the first instant.",
        "EM",
        "With LM the capsule creeps on its bristles before it breaks away.",
    )
