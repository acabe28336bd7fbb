"""A friction law under an imposed motion, by SciPy and the law's scalar functions alone: nothing of the engine.

A stroke has one direction; within it the guards of the law's pieces are events of the solver.
"""

import dataclasses
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from vibrocap.contracts.samples import settled_pieces


@dataclasses.dataclass(frozen=True)
class Stroke:
    """What a law did over a stroke: time [n], displacement [n] since its start, friction [n], internal [n, states]."""

    time: np.ndarray
    displacement: np.ndarray
    friction: np.ndarray
    internal: np.ndarray
    switches: tuple[tuple, ...]  # (time, which, internal states before, after)
    end: tuple


def stroke(
    law: Any,
    velocity: float | Callable[[float], float],
    duration: float,
    internal: tuple | None = None,
    *,
    side: int | None = None,
    load: float = 1.0,
    turned: bool = False,
    samples: int = 200,
    tolerance: float = 1e-10,
) -> Stroke:
    """Slide to one side for a duration. turned: a reversal stands before it. Two samples or less: its end alone."""
    speed = velocity if callable(velocity) else lambda _t, v=velocity: v
    side = side or (1 if speed(0.5 * duration) > 0 else -1)
    internal = (0.0,) * len(law.internal) if internal is None else internal
    if turned:
        internal = law.after_reversal(internal, side, load)
    start, count = 0.0, len(law.internal)
    scales = np.array([1.0, *law.internal_scales(load)])
    grid = np.linspace(0.0, duration, samples)
    displacement, times, states, switches = 0.0, [], [], []
    while True:
        internal = settled_pieces(law, speed(start), internal, side, load)

        def rates(t, y):
            v = speed(t)
            return [v, *law.force(v, tuple(y[1:]), side, load)[1]]

        def guard_of(which):
            def guard(t, y):
                return law.switches(speed(t), tuple(y[1:]), side, load)[which]

            guard.terminal, guard.direction = True, -1
            return guard

        guards = [guard_of(i) for i in range(len(law.switches(speed(start), internal, side, load)))]
        solution = solve_ivp(
            rates,
            (start, duration),
            [displacement, *internal],
            method="LSODA",
            rtol=tolerance,
            atol=tolerance * 1e-2 * scales,
            events=guards or None,
            dense_output=samples > 2,
        )
        assert solution.success, solution.message
        if samples > 2:
            inside = grid[(grid >= start) & (grid <= solution.t[-1])]
            times.extend(inside)
            states.extend(solution.sol(inside).T if len(inside) else ())
        start, displacement, internal = solution.t[-1], solution.y[0, -1], tuple(solution.y[1:, -1].tolist())
        if solution.status != 1:
            break
        which = next(i for i, event in enumerate(solution.t_events) if len(event))
        before, internal = internal, law.after_switch(which, speed(start), internal, side, load)
        switches.append((start, which, before, internal))
        assert len(switches) < 100, "the pieces of the law chatter"
    if samples <= 2:
        times, states = [duration], [np.array([displacement, *internal])]
    states = np.array(states)
    friction = np.array(
        [law.force(speed(t), tuple(y[1:].tolist()), side, load)[0] for t, y in zip(times, states, strict=True)]
    )
    return Stroke(np.array(times), states[:, 0], friction, states[:, 1 : count + 1], tuple(switches), internal)
