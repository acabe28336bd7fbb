"""SciPy's DOP853 on the named sweeps: one motion after another, mode by mode, events of `solve_ivp`.

As in peers_scipy.py. It is some thousand times slower than compiled code, so few motions of a sweep are timed. There is
no version for two threads: it is Python throughout.
"""

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.named_sweeps import END, INITIAL, SWEEP_SET

TOLERANCE = {"exponential": 1e-8, "lugre": 1.5e-9}
LIMIT = SWEEP_SET.normal_load * SWEEP_SET.static_coefficient


def _moment(t, theta, rate):
    p = SWEEP_SET
    return p.amplitude * math.cos(p.frequency * t) + math.sin(theta) - p.stiffness * theta - p.damping * rate


def _holding_force(t, y):
    return math.cos(y[0]) * _moment(t, y[0], y[1]) - math.sin(y[0]) * y[1] * y[1]


def _accelerated(t, theta, rate, velocity, force, mass_ratio):
    sine, cosine, moment = math.sin(theta), math.cos(theta), _moment(t, theta, rate)
    push = (cosine * moment - sine * rate * rate - force) / (mass_ratio + 1.0 - cosine * cosine)
    return rate, moment + cosine * push, velocity, push


def _exponential_rates(t, y, side, mass_ratio):
    p = SWEEP_SET
    theta, rate, _, velocity = y.tolist()
    drop = p.static_coefficient - p.coulomb_coefficient
    # Continued below zero without a kink: a trial step may look there, a motion never goes.
    force = side * p.normal_load * (p.coulomb_coefficient + drop * math.exp(-p.decay_rate * side * velocity))
    return _accelerated(t, theta, rate, velocity, force, mass_ratio)


def _stuck_rates(t, y, _side, _mass_ratio):
    return y[1], _moment(t, y[0], y[1]), 0.0, 0.0


def _lugre_rates(t, y, side, mass_ratio):
    p = SWEEP_SET
    theta, rate, _, velocity, bristle = y.tolist()
    drop = p.static_coefficient - p.coulomb_coefficient
    level = p.normal_load * (p.coulomb_coefficient + drop * math.exp(-((velocity / p.stribeck_velocity) ** 2)))
    bristle_rate = velocity - side * velocity * bristle * p.bristle_stiffness / level
    force = p.bristle_stiffness * bristle + p.bristle_damping * bristle_rate + p.viscous_damping * velocity
    return *_accelerated(t, theta, rate, velocity, force, mass_ratio), bristle_rate


def _stopped(_t, y, side, _mass_ratio):
    return side * y[3]


def _broken_away(t, y, _side, _mass_ratio):
    return LIMIT - abs(_holding_force(t, y))


for _event in (_stopped, _broken_away):
    _event.terminal, _event.direction = True, -1


def _final_state(law: str, mass_ratio: float, tolerance: float) -> np.ndarray:
    t, y, side = 0.0, np.array(INITIAL[law]), 1.0
    while True:
        needed = _holding_force(t, y) - (SWEEP_SET.bristle_stiffness * y[4] if law == "lugre" else 0.0)
        # Only a sliding capsule may stick: at break-away the force stands at the limit, give or take rounding.
        may_stick = law == "exponential" and side != 0.0
        side = 0.0 if may_stick and abs(needed) < LIMIT else math.copysign(1.0, needed)
        rates = _lugre_rates if law == "lugre" else _exponential_rates if side else _stuck_rates
        solution = solve_ivp(
            rates,
            (t, END),
            y,
            "DOP853",
            events=_stopped if side else _broken_away,
            args=(side, mass_ratio),
            rtol=tolerance,
            atol=tolerance,
        )
        t, y = solution.t[-1], solution.y[:, -1]
        if solution.status != 1:
            assert solution.success, solution.message
            return y
        y[3] = 0.0


def prepare_sweep(
    law: str, masses: np.ndarray, threads: int = 1, tolerance: float | None = None
) -> Callable[[], np.ndarray] | None:
    """Returns a function that runs the sweep and returns its final states [runs, states]; None for several threads."""
    if threads != 1:
        return None
    accuracy = tolerance or TOLERANCE[law]

    def run() -> np.ndarray:
        return np.array([_final_state(law, mass_ratio, accuracy) for mass_ratio in masses.tolist()])

    return run
