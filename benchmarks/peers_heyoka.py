"""heyoka.py on the named motions, as fast as we could make it: a peer to be fair to.

heyoka compiles a Taylor integrator of our equations and locates events on its step polynomials. It knows no sticking,
so the modes are written by hand. What was tried, one motion of the exponential law over 40 periods within 1e-9, on an
x86-64 server with AVX-512:

    one integrator, stick flag and side as parameters, modes switched in the event's callback             0.88 ms, used
    two integrators (sliding, stuck), slip to slip in a callback, the state handed over for sticking      0.90 ms
    two integrators, every event ends `propagate_until` and Python goes on                                0.94 ms
    the first without fast_math                                                                           1.1 ms
    the first with compact_mode, or at the default tolerance of 2e-16 (both without fast_math)            2.1 ms
    SLP vectorisation, forced AVX-512                                                                     no gain

One event that means "the mode ends" for both modes beats two or three events, as each costs in every step. It is caught
in the falling direction only, with cooldown 0: a restart has the velocity at zero and growing and does not fire again.
"""

import math
from collections.abc import Callable

import heyoka as hy
import numpy as np

from benchmarks.named_motions import EXPONENTIAL_40, FIRST_SET, LUGRE_100

# A capsule that leaves stick has zero velocity *and* zero acceleration; where rounding makes the latter negative, the
# event at zero velocity would fire at once. It starts that much inside its mode instead.
NUDGE = 1e-15


def _equations():
    """Variables, side (a parameter of the integrator), P, holding force and B of docs/model.md."""
    p = FIRST_SET
    theta, rate, position, velocity, bristle = hy.make_vars("theta", "rate", "position", "velocity", "bristle")
    cosine = hy.cos(theta)
    moment = p.amplitude * hy.cos(p.frequency * hy.time) + hy.sin(theta) - p.stiffness * theta - p.damping * rate
    hold = cosine * moment - hy.sin(theta) * rate**2
    inertia = p.mass_ratio + 1.0 - cosine * cosine
    return (theta, rate, position, velocity, bristle), hy.par[0], cosine, moment, hold, inertia


def _holding_force(t: float, theta: float, rate: float) -> float:
    p = FIRST_SET
    sine = math.sin(theta)
    moment = p.amplitude * math.cos(p.frequency * t) + sine - p.stiffness * theta - p.damping * rate
    return math.cos(theta) * moment - sine * rate * rate


def prepare_exponential(tolerance: float = 1e-10, **options) -> Callable[[], np.ndarray]:
    """Compiles; returns a function that runs the exponential law's motion to its final state, which it returns."""
    p, motion = FIRST_SET, EXPONENTIAL_40
    (theta, rate, position, velocity, _), side, cosine, moment, hold, inertia = _equations()
    slipping, limit = hy.par[1], p.normal_load * p.static_coefficient
    drop = p.static_coefficient - p.coulomb_coefficient
    force = side * p.normal_load * (p.coulomb_coefficient + drop * hy.exp(-p.decay_rate * side * velocity))
    push = slipping * (hold - force) / inertia
    mode_left = slipping * side * velocity + (1.0 - slipping) * (limit * limit - hold * hold)

    def switch(_integrator, _direction) -> bool:
        angle, angle_rate, _, _ = state.tolist()
        needed = _holding_force(integrator.time, angle, angle_rate)
        if parameters[1] == 1.0 and abs(needed) < limit:
            parameters[1], state[3] = 0.0, 0.0
        else:
            new_side = math.copysign(1.0, needed)
            parameters[0], parameters[1], state[3] = new_side, 1.0, new_side * NUDGE
        return True

    integrator = hy.taylor_adaptive(
        [(theta, rate), (rate, moment + cosine * push), (position, velocity), (velocity, push)],
        [0.0] * 4,
        pars=[1.0, 1.0],
        tol=tolerance,
        t_events=[hy.t_event(mode_left, callback=switch, direction=hy.event_direction.negative, cooldown=0.0)],
        **{"fast_math": True, **options},
    )
    state, parameters = integrator.state, integrator.pars
    end = motion.end

    def run() -> np.ndarray:
        integrator.time = 0.0
        state[:] = motion.initial
        parameters[1] = 1.0
        switch(None, None)
        outcome = integrator.propagate_until(end)[0]
        assert outcome == hy.taylor_outcome.time_limit, outcome
        return state.copy()

    return run


def prepare_lugre(tolerance: float = 1e-8, **options) -> Callable[[], np.ndarray]:
    """Compiles; returns a function that runs the LuGre law's motion, restarted at reversals, to its final state."""
    p, motion = FIRST_SET, LUGRE_100
    (theta, rate, position, velocity, bristle), side, cosine, moment, hold, inertia = _equations()
    drop = p.static_coefficient - p.coulomb_coefficient
    level = p.normal_load * (p.coulomb_coefficient + drop * hy.exp(-((velocity / p.stribeck_velocity) ** 2)))
    bristle_rate = velocity - side * velocity * bristle * p.bristle_stiffness / level
    force = p.bristle_stiffness * bristle + p.bristle_damping * bristle_rate + p.viscous_damping * velocity
    push = (hold - force) / inertia

    def reverse(_integrator, _direction) -> bool:
        parameters[0] = -parameters[0]
        return True

    integrator = hy.taylor_adaptive(
        [
            (theta, rate),
            (rate, moment + cosine * push),
            (position, velocity),
            (velocity, push),
            (bristle, bristle_rate),
        ],
        [0.0] * 5,
        pars=[1.0],
        tol=tolerance,
        t_events=[hy.t_event(side * velocity, callback=reverse, direction=hy.event_direction.negative, cooldown=0.0)],
        **{"fast_math": True, **options},
    )
    state, parameters = integrator.state, integrator.pars
    end, start = motion.end, motion.initial
    first_push = _holding_force(0.0, start[0], start[1]) - p.bristle_stiffness * start[4]
    first_side = math.copysign(1.0, first_push)

    def run() -> np.ndarray:
        integrator.time = 0.0
        state[:] = start
        parameters[0] = first_side
        outcome = integrator.propagate_until(end)[0]
        assert outcome == hy.taylor_outcome.time_limit, outcome
        return state.copy()

    return run
