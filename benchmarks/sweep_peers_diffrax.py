"""diffrax on the named sweeps: `jax.vmap` over the mass ratio, on the CPU, in double precision.

diffrax stops a solve at an event and locates it; it knows no modes, so a loop of JAX (`while_loop`) goes from mode to
mode, for sticking as for the reversals of LuGre. All motions of a call take a step when one of them does and begin a
mode when all have ended theirs.

What was tried, microseconds per trajectory and drive period, on a shared x86-64 server with AVX-512:

                                                           exponential     LuGre
    Tsit5, every mode located, 99 % of errors below 1e-6           160       760, used
    Dopri8, the same at tolerance 1e-8                             290     1,320
    Tsit5, LuGre's reversals ignored: error 9e-6 at 1e-9                   1,560
    5 / 20 / 100 / 200 motions a call                  350/150/160/180    -/700/760/690
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

# One thread per call, before JAX starts: the threads of this benchmark are its own.
os.environ["XLA_FLAGS"] = os.environ.get("XLA_FLAGS", "") + " --xla_cpu_multi_thread_eigen=false"

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix

from benchmarks.named_sweeps import END, INITIAL, SWEEP_SET

TOLERANCE = {"exponential": 1e-8, "lugre": 7e-9}
MOST_STEPS, MOST_MODES = 1_000_000, 2000
NUDGE = 1e-15
FIRST_STEP = 1e-2  # of every mode
LIMIT = SWEEP_SET.normal_load * SWEEP_SET.static_coefficient


def _moment(t, theta, rate):
    p = SWEEP_SET
    return p.amplitude * jnp.cos(p.frequency * t) + jnp.sin(theta) - p.stiffness * theta - p.damping * rate


def _holding_force(t, y):
    return jnp.cos(y[0]) * _moment(t, y[0], y[1]) - jnp.sin(y[0]) * y[1] * y[1]


def _exponential_rates(t, y, mode):
    """Equations (9) with (8); side 0 is the stuck capsule."""
    p, (side, mass_ratio) = SWEEP_SET, mode
    theta, rate, _, velocity = y
    cosine, moment = jnp.cos(theta), _moment(t, theta, rate)
    drop = p.static_coefficient - p.coulomb_coefficient
    force = side * p.normal_load * (p.coulomb_coefficient + drop * jnp.exp(-p.decay_rate * side * velocity))
    push = (cosine * moment - jnp.sin(theta) * rate * rate - force) / (mass_ratio + 1.0 - cosine * cosine)
    push = jnp.abs(side) * push
    return jnp.stack([rate, moment + cosine * push, velocity, push])


def _lugre_rates(t, y, mode):
    """Equations (9) with (6), (7), (10)."""
    p, (side, mass_ratio) = SWEEP_SET, mode
    theta, rate, _, velocity, bristle = y
    cosine, moment = jnp.cos(theta), _moment(t, theta, rate)
    drop = p.static_coefficient - p.coulomb_coefficient
    level = p.normal_load * (p.coulomb_coefficient + drop * jnp.exp(-((velocity / p.stribeck_velocity) ** 2)))
    bristle_rate = velocity - side * velocity * bristle * p.bristle_stiffness / level
    force = p.bristle_stiffness * bristle + p.bristle_damping * bristle_rate + p.viscous_damping * velocity
    push = (cosine * moment - jnp.sin(theta) * rate * rate - force) / (mass_ratio + 1.0 - cosine * cosine)
    return jnp.stack([rate, moment + cosine * push, velocity, push, bristle_rate])


def _exponential_mode_at_rest(t, y, side):
    needed = _holding_force(t, y)
    # Only a sliding capsule may stick: at break-away the force stands at the limit, give or take rounding.
    return jnp.where((side != 0.0) & (jnp.abs(needed) < LIMIT), 0.0, jnp.sign(needed))


def _lugre_mode_at_rest(t, y, _side):
    return jnp.sign(_holding_force(t, y) - SWEEP_SET.bristle_stiffness * y[4])


def _mode_left(t, y, args, **_):
    side, _ = args
    return jnp.where(side == 0.0, LIMIT - jnp.abs(_holding_force(t, y)), side * y[3])


RATES = {"exponential": _exponential_rates, "lugre": _lugre_rates}
MODE_AT_REST = {"exponential": _exponential_mode_at_rest, "lugre": _lugre_mode_at_rest}


def _final_state(law: str, mass_ratio, tolerance: float, solver):
    """One `diffeqsolve` per mode up to its event, in a loop of JAX."""

    def unfinished(carry):
        t, _, _, count = carry
        return (t < END) & (count < MOST_MODES)

    def next_mode(carry):
        t, y, side, count = carry
        side = MODE_AT_REST[law](t, y, side)
        done = diffrax.diffeqsolve(
            diffrax.ODETerm(RATES[law]),
            solver,
            t,
            END,
            FIRST_STEP,
            y.at[3].set(side * NUDGE),
            (side, mass_ratio),
            stepsize_controller=diffrax.PIDController(rtol=tolerance, atol=tolerance),
            event=diffrax.Event(_mode_left, root_finder=optimistix.Newton(rtol=1e-11, atol=1e-11), direction=False),
            adjoint=diffrax.ForwardMode(),
            max_steps=MOST_STEPS,
            saveat=diffrax.SaveAt(t1=True),
            throw=False,
        )
        return done.ts[0], done.ys[0], side, count + 1

    start = (jnp.zeros(()), jnp.array(INITIAL[law]), jnp.ones(()), 0)
    return jax.lax.while_loop(unfinished, next_mode, start)[1]


def prepare_sweep(
    law: str, masses: np.ndarray, threads: int = 1, tolerance: float | None = None, solver=None
) -> Callable[[], np.ndarray]:
    """Compiles; returns a function that runs the sweep and returns its final states [runs, states]."""
    with jax.enable_x64(True):
        accuracy = tolerance or TOLERANCE[law]
        compiled = jax.jit(
            jax.vmap(lambda mass_ratio: _final_state(law, mass_ratio, accuracy, solver or diffrax.Tsit5()))
        )
        shares = [jnp.asarray(masses[share::threads]) for share in range(threads)]
        compiled = [compiled.lower(share).compile() for share in shares]

    def run() -> np.ndarray:
        final = np.empty((len(masses), len(INITIAL[law])))
        with ThreadPoolExecutor(threads) as pool:
            done = pool.map(lambda share: np.asarray(compiled[share](shares[share])), range(threads))
            for share, states in enumerate(done):
                final[share::threads] = states
        return final

    return run
