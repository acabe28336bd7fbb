"""heyoka.py on the named sweeps: its batch integrator and its ensemble propagation; and the reference states.

A batch advances 8 motions side by side (`recommended_simd_size` of a machine with AVX-512), each with its own step; a
terminal event shortens the step of its own lane. Neighbouring mass ratios share a batch, so that few lanes wait for the
slowest. As in peers_heyoka.py the modes are written by hand, with one event that means "the mode ends".

What was tried, ns per trajectory and drive period, error 1e-6, one thread of a shared x86-64 server with AVX-512:

                                                                          exponential    LuGre
    batch of 8, fast_math, callback on memoryviews of the integrator's arrays  7,600    8,300, used
    the same in plain functions, one for all integrators                       7,100    7,950, batch of 16 alike
    the same, batch of 4                                                       7,900
    the same, callback on NumPy arrays asked for in each call                 14,000    9,800
    `ensemble_propagate_until_batch`                                          10,400   10,400

Callbacks are Python's, four events a period and motion with the exponential law, two with LuGre: what they do is as
important as the integrator. They hold the interpreter's lock, so two threads gained nothing with the exponential law.
The ensemble copies its integrator for every batch, 0.8 ms each. The tolerance of heyoka sets the order of
its series and hardly the step, so the error moves in leaps: each tolerance here is the largest of the lowest order
that meets the error asked for.
"""

import functools
import math
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from types import SimpleNamespace

import heyoka as hy
import numpy as np

from benchmarks.named_sweeps import END, INITIAL, SWEEP_SET

TOLERANCE = {"exponential": 8e-7, "lugre": 1.1e-7}  # series of order 9 and 10
SHARES = 16  # tasks of a sweep in several processes
# A capsule that leaves stick starts this much inside its mode, see peers_heyoka.py.
NUDGE = 1e-15
# Parameters of the integrators: what the mode is, and what varies over the sweep.
SIDE, SLIPPING, MASS_RATIO = range(3)


LIMIT = SWEEP_SET.normal_load * SWEEP_SET.static_coefficient


def _holding_force(t, theta, rate, library=math):
    p, sine = SWEEP_SET, library.sin(theta)
    moment = p.amplitude * library.cos(p.frequency * t) + sine - p.stiffness * theta - p.damping * rate
    return library.cos(theta) * moment - sine * rate * rate


def _equations(law: str, number: type = float):
    """Equations (9) of the paper with the mode as parameters, and the function that turns negative where it ends."""
    p = SimpleNamespace(**{name: number(value) for name, value in vars(SWEEP_SET).items()})
    side, slipping, one = hy.par[SIDE], hy.par[SLIPPING], number(1)
    theta, rate, position, velocity, bristle = hy.make_vars("theta", "rate", "position", "velocity", "bristle")
    cosine = hy.cos(theta)
    moment = p.amplitude * hy.cos(p.frequency * hy.time) + hy.sin(theta) - p.stiffness * theta - p.damping * rate
    hold = cosine * moment - hy.sin(theta) * rate**2
    inertia = hy.par[MASS_RATIO] + one - cosine * cosine
    drop = p.static_coefficient - p.coulomb_coefficient
    if law == "exponential":
        limit = p.normal_load * p.static_coefficient
        force = side * p.normal_load * (p.coulomb_coefficient + drop * hy.exp(-p.decay_rate * side * velocity))
        push = slipping * (hold - force) / inertia
        mode_left = slipping * side * velocity + (one - slipping) * (limit * limit - hold * hold)
        bristles = []
    else:
        level = p.normal_load * (p.coulomb_coefficient + drop * hy.exp(-((velocity / p.stribeck_velocity) ** 2)))
        bristle_rate = velocity - side * velocity * bristle * p.bristle_stiffness / level
        force = p.bristle_stiffness * bristle + p.bristle_damping * bristle_rate + p.viscous_damping * velocity
        push = (hold - force) / inertia
        mode_left = side * velocity
        bristles = [(bristle, bristle_rate)]
    rates = [(theta, rate), (rate, moment + cosine * push), (position, velocity), (velocity, push), *bristles]
    return rates, mode_left


class Reversal:
    """The callback of an event with LuGre: the other side. Bound to the arrays of its own integrator.

    The ensemble copies its integrator, callback included, so a copy starts unbound.
    """

    def bind(self, integrator) -> None:
        """Look at the arrays of this integrator: rows as memoryviews, which are read and written quickest."""
        self.side = memoryview(integrator.pars[SIDE])

    def release(self) -> None:
        """Forget the arrays: an integrator that holds a callback that holds it would never be freed."""
        self.__dict__.clear()

    def __deepcopy__(self, _memo):
        return type(self)()

    def __call__(self, _integrator, _direction, lane: int) -> bool:
        self.side[lane] = -self.side[lane]
        return True


class StickSlip(Reversal):
    """The callback of an event with the exponential law: stuck, or sliding to either side."""

    def bind(self, integrator) -> None:
        """Look at the arrays of this integrator."""
        super().bind(integrator)
        state = integrator.state
        self.slipping, self.time = memoryview(integrator.pars[SLIPPING]), memoryview(integrator.time)
        self.angle, self.rate, self.velocity = memoryview(state[0]), memoryview(state[1]), memoryview(state[3])

    def __call__(self, _integrator, _direction, lane: int) -> bool:
        needed = _holding_force(self.time[lane], self.angle[lane], self.rate[lane])
        if self.slipping[lane] and -LIMIT < needed < LIMIT:
            self.slipping[lane] = self.velocity[lane] = 0.0
        else:
            side = 1.0 if needed > 0.0 else -1.0
            self.side[lane], self.slipping[lane], self.velocity[lane] = side, 1.0, side * NUDGE
        return True


CALLBACK = {"exponential": StickSlip, "lugre": Reversal}


def _batch_integrator(law: str, tolerance: float):
    rates, mode_left = _equations(law)
    lanes = hy.recommended_simd_size()
    event = hy.t_event_batch(mode_left, callback=CALLBACK[law](), direction=hy.event_direction.negative, cooldown=0.0)
    return hy.taylor_adaptive_batch(
        rates,
        np.zeros((len(rates), lanes)),
        pars=np.ones((3, lanes)),
        tol=tolerance,
        t_events=[event],
        fast_math=True,
    )


def _start(law: str, integrator, masses: np.ndarray) -> None:
    """Put the integrator at the start of the motions of these mass ratios; the last one fills up the batch."""
    integrator.set_time(0.0)
    integrator.state[:] = np.reshape(INITIAL[law], (-1, 1))
    integrator.pars[MASS_RATIO] = masses[-1]
    integrator.pars[MASS_RATIO, : len(masses)] = masses
    integrator.pars[SIDE], integrator.pars[SLIPPING] = _first_side(law), 1.0
    callback = integrator.t_events[0].callback
    if law == "exponential":
        for lane in range(integrator.batch_size):
            callback(None, None, lane)


def _first_side(law: str) -> float:
    start, p = INITIAL[law], SWEEP_SET
    bristle = start[4] if law == "lugre" else 0.0
    return math.copysign(1.0, _holding_force(0.0, start[0], start[1]) - p.bristle_stiffness * bristle)


def _checked(integrator) -> None:
    outcomes = {result[0] for result in integrator.propagate_res}
    assert outcomes == {hy.taylor_outcome.time_limit}, outcomes


def _batches(law: str, tolerance: float) -> Callable[[np.ndarray], np.ndarray]:
    """Compiles; returns the function from mass ratios to final states, batch by batch."""
    integrator = _batch_integrator(law, tolerance)
    integrator.t_events[0].callback.bind(integrator)
    lanes = integrator.batch_size
    ends = np.full(lanes, END)

    def final_states(masses: np.ndarray) -> np.ndarray:
        final = np.empty((len(masses), len(INITIAL[law])))
        for begin in range(0, len(masses), lanes):
            batch = masses[begin : begin + lanes]
            _start(law, integrator, batch)
            integrator.propagate_until(ends)
            _checked(integrator)
            final[begin : begin + lanes] = integrator.state.T[: len(batch)]
        return final

    return final_states


def _start_worker(*arguments) -> None:
    global _worker
    _worker = _batches(*arguments)


def _work(masses: np.ndarray) -> np.ndarray:
    return _worker(masses)


@functools.cache  # kept to the end: an executor that is collected while Python exits complains
def _pool(threads: int, *arguments) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(threads, get_context("spawn"), _start_worker, arguments)


def prepare_sweep(
    law: str, masses: np.ndarray, threads: int = 1, tolerance: float | None = None
) -> Callable[[], np.ndarray]:
    """Compiles; returns a function that runs the sweep and returns its final states [runs, states].

    Several threads are so many processes, which live on: in threads the callbacks would wait for one another.
    """
    arguments = law, tolerance or TOLERANCE[law]
    if threads == 1:
        final_states = _batches(*arguments)
        return lambda: final_states(masses)
    pool = _pool(threads, *arguments)
    lanes = hy.recommended_simd_size()
    share = -(-len(masses) // (SHARES * lanes)) * lanes
    shares = [masses[begin : begin + share] for begin in range(0, len(masses), share)]

    def run() -> np.ndarray:
        return np.concatenate(list(pool.map(_work, shares)))

    run()
    return run


def prepare_ensemble(
    law: str, masses: np.ndarray, threads: int = 1, tolerance: float | None = None
) -> Callable[[], np.ndarray]:
    """The same by heyoka's own `ensemble_propagate_until_batch`."""
    template = _batch_integrator(law, tolerance or TOLERANCE[law])
    lanes = template.batch_size
    batches = [masses[begin : begin + lanes] for begin in range(0, len(masses), lanes)]

    def started(integrator, number: int):
        integrator.t_events[0].callback.bind(integrator)
        _start(law, integrator, batches[number])
        return integrator

    def run() -> np.ndarray:
        done = hy.ensemble_propagate_until_batch(template, END, len(batches), started, max_workers=threads)
        for integrator, *_ in done:
            _checked(integrator)
            integrator.t_events[0].callback.release()
        return np.concatenate([integrator.state.T for integrator, *_ in done])[: len(masses)]

    return run


def reference_states(law: str, masses: np.ndarray, number: type = np.float64) -> np.ndarray:
    """Final states [runs, states] from one motion at a time, at the rounding level of the kind of number.

    Compared at every tenth mass ratio: doubles are within 6e-13 of long doubles (`np.longdouble`, nine times slower),
    and those within 2e-12 of tests/independent.py (four motions of each law).
    """
    rates, mode_left = _equations(law, number)
    limit = number(LIMIT)

    def switch(_integrator, _direction) -> bool:
        needed = _holding_force(integrator.time, state[0], state[1], np)
        if law == "lugre":
            parameters[SIDE] = -parameters[SIDE]
        elif parameters[SLIPPING] and -limit < needed < limit:
            parameters[SLIPPING] = state[3] = 0
        else:
            side = np.sign(needed)
            parameters[SIDE], parameters[SLIPPING], state[3] = side, 1, side * number(NUDGE)
        return True

    integrator = hy.taylor_adaptive(
        rates,
        np.zeros(len(rates), number),
        pars=np.ones(3, number),
        tol=np.finfo(number).eps,
        t_events=[
            hy.t_event(
                mode_left,
                callback=switch,
                direction=hy.event_direction.negative,
                cooldown=number(0),
                fp_type=number,
            )
        ],
        fp_type=number,
    )
    state, parameters = integrator.state, integrator.pars
    final = np.empty((len(masses), len(rates)))
    for row, mass_ratio in enumerate(masses):
        integrator.time = number(0)
        state[:] = INITIAL[law]
        parameters[:] = _first_side(law), 1, mass_ratio
        if law == "exponential":
            switch(None, None)
        outcome = integrator.propagate_until(number(END))[0]
        assert outcome == hy.taylor_outcome.time_limit, outcome
        final[row] = state
    return final
