"""SciPy on the exponential law's named motion: with hand-written stick-slip events, and as one would at first.

`prepare_events`: DOP853, one `solve_ivp` per mode up to its terminal event; the loosest tolerance found to meet the
error asked for with something to spare.
`prepare_naive`: RK45 at its defaults with sign(v). It reports success, and its last position is off by 5 to 8 where
6.86 is right: it chatters through every sticking phase, so that even its sign hangs on how the equations are rounded.
Six algebraically equal ways to write them gave 0.14, 1.88, -0.74, 0.96, 0.73 and 2.17, the one below -1.03.
"""

import math
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.named_motions import EXPONENTIAL_40, FIRST_SET

MOST_MODES = 1_000  # of a motion


def _moment(t, theta, rate, p):
    return p.amplitude * math.cos(p.frequency * t) + math.sin(theta) - p.stiffness * theta - p.damping * rate


def _holding_force(t, y, p):
    return math.cos(y[0]) * _moment(t, y[0], y[1], p) - math.sin(y[0]) * y[1] * y[1]


def _sliding(t, y, side, p):
    theta, rate, _, velocity = y.tolist()
    sine, cosine = math.sin(theta), math.cos(theta)
    moment = p.amplitude * math.cos(p.frequency * t) + sine - p.stiffness * theta - p.damping * rate
    drop = p.static_coefficient - p.coulomb_coefficient
    force = side * p.normal_load * (p.coulomb_coefficient + drop * math.exp(-p.decay_rate * abs(velocity)))
    push = (cosine * moment - sine * rate * rate - force) / (p.mass_ratio + 1.0 - cosine * cosine)
    return rate, moment + cosine * push, velocity, push


def _stuck(t, y, _side, p):
    theta, rate, _, _ = y.tolist()
    return rate, _moment(t, theta, rate, p), 0.0, 0.0


def _stopped(_t, y, side, _p):
    return side * y[3]


def _broken_away(t, y, _side, p):
    return p.normal_load * p.static_coefficient - abs(_holding_force(t, y, p))


for _event in (_stopped, _broken_away):
    _event.terminal, _event.direction = True, -1


def moved_on(p: SimpleNamespace, t: float, end: float, y, side: int, relative: float, absolute: float):
    """(state, side) at time end of the system with parameters p, mode by mode from state y at time t.

    side: +1 or -1 where the capsule slides, 0 where it is stuck. RuntimeError where events follow one another at one
    instant: `solve_ivp` then goes round in circles
    """
    limit = p.normal_load * p.static_coefficient
    for _ in range(MOST_MODES):
        solution = solve_ivp(
            _sliding if side else _stuck,
            (t, end),
            y,
            "DOP853",
            events=_stopped if side else _broken_away,
            args=(side, p),
            rtol=relative,
            atol=absolute,
        )
        t, y = solution.t[-1], solution.y[:, -1]
        if solution.status != 1:
            assert solution.success, solution.message
            return y, side
        y[3] = 0.0
        needed = _holding_force(t, y, p)
        # Only a sliding capsule may stick: at break-away the force stands at the limit, give or take rounding.
        side = 0 if side and abs(needed) < limit else math.copysign(1, needed)
    raise RuntimeError(f"more than {MOST_MODES} modes, at time {t}")


def first_side(p: SimpleNamespace, y) -> float:
    """Whether and whither a capsule at rest slides at the start."""
    needed = _holding_force(0.0, y, p)
    return 0 if abs(needed) < p.normal_load * p.static_coefficient else math.copysign(1, needed)


def prepare_events(relative: float = 5e-12, absolute: float = 5e-13) -> Callable[[], np.ndarray]:
    """Returns a function that runs the motion mode by mode and returns its final state."""
    motion = EXPONENTIAL_40

    def run() -> np.ndarray:
        side = first_side(FIRST_SET, motion.initial)
        return moved_on(FIRST_SET, 0.0, motion.end, np.array(motion.initial), side, relative, absolute)[0]

    return run


def prepare_naive() -> Callable[[], np.ndarray]:
    """Returns a function that runs the motion with sign(v) and RK45 at its defaults and returns its final state."""
    motion = EXPONENTIAL_40

    def rates(t, y):
        return _sliding(t, y, float(np.sign(y[3])), FIRST_SET)

    def run() -> np.ndarray:
        solution = solve_ivp(rates, (0.0, motion.end), motion.initial)
        assert solution.success, solution.message
        return solution.y[:, -1]

    return run
