"""Writes the implicit step of one law under an imposed motion, Rodas5P, as scalar code without loops.

The method and its coefficients are those of `implicit.py`. Written out for one law, what vanishes in its Jacobian costs
nothing, and states that only jump take no part. Of Rodas3, Rodas4P and Rodas5P this one takes the least time per sample
at any error below 1e-5 of the scale, since a law is cheap: its eight stages cost a fifth more than six.
"""

from collections.abc import Sequence

import numpy as np

from vibrocap.numerics.codegen.driven_source import (
    DrivenEquations,
    DrivenLayout,
    DrivenWriter,
    force_source,
    frozen_lines,
    frozen_source,
    guard_source,
    reversal_source,
    switch_source,
)
from vibrocap.numerics.codegen.straight_line import function_source
from vibrocap.numerics.expressions.graph import derivative
from vibrocap.numerics.kernel.step.implicit import COUPLING, GAMMA, NODES, STAGE_WEIGHTS, STAGES, TIME_WEIGHTS

Entries = set[tuple[int, int]]


def driven_source(equations: DrivenEquations) -> tuple[DrivenLayout, str]:
    """(layout, source) of everything that `driven_generated.py` promises."""
    frozen: dict[int, str] = {}
    functions = [
        *step_source(equations, frozen),
        force_source(equations, frozen),
        guard_source(equations, frozen),
        switch_source(equations, frozen),
        reversal_source(equations, frozen),
        frozen_source(equations, frozen),
    ]
    layout = DrivenLayout(equations.states, len(equations.parameter_names), len(frozen))
    constants = {
        "STATES": equations.states,
        "GUARDS": len(equations.guards),
        "SET_VALUED": equations.set_valued,
        "MOVING": equations.moving,
        "SHARP_INTERNAL": equations.sharp_internal,
        **layout.places,
    }
    return layout, "\n".join([*(f"{name} = {value!r}" for name, value in constants.items()), "", *functions])


def step_source(equations: DrivenEquations, frozen: dict[int, str]) -> list[str]:
    """`rates`, `slopes` (rates, Jacobian, derivative in time) and `attempt`, a step of the method."""
    moving, states = equations.moving, equations.states
    rates, slopes = DrivenWriter(equations, frozen), DrivenWriter(equations, frozen)
    point, slots = [f"z{i}" for i in range(states)], range(moving)
    values = [rates.name(rate) for rate in equations.rates]
    outputs, names, jacobian = _slopes(equations, slopes)
    used = [*rates.used, *(name for name in slopes.used if name not in rates.used)]
    call_of_slopes = f"slopes({', '.join([*point, 'v', 'w', 'a', 'b', 'side', *slopes.used])})"
    lines = [
        *(f"z{i} = floats[STATE + {i}]" for i in range(states)),
        "v, w, a, b = floats[VELOCITY], floats[LOAD], floats[VELOCITY_RATE], floats[LOAD_RATE]",
        *frozen_lines(used),
        *([f"{_tuple(names)} = {call_of_slopes}"] if names else []),
        f"inverse, over, dv, dw = {1.0 / GAMMA!r} / h, 1.0 / h, h * a, h * b",
    ]
    elimination, filled = decomposition(jacobian, moving)
    lines += elimination
    for stage, node in enumerate(NODES.tolist()):
        weights, coupling, time_weight = STAGE_WEIGHTS[stage], COUPLING[stage], float(TIME_WEIGHTS[stage])
        if stage > 0 and moving:
            lines += [f"u{i} = {_sum(f'z{i}', weights, f'_{i}')}" for i in slots]
            at = [f"v + {node!r} * dv" if node else "v", f"w + {node!r} * dw" if node else "w"]
            arguments = [*(f"u{i}" for i in slots), *point[moving:], *at, "side", *rates.used]
            lines += [f"{_tuple([f'f{i}' for i in slots])} = rates({', '.join(arguments)})"]
        for i in slots:
            right = f"f{i}"
            if time_weight:
                right += f" + {time_weight!r} * (h * t{i})"
            if coupling.any():
                right += f" + over * ({_sum('', coupling, f'_{i}')})"
            lines += [f"r{i} = {right}"]
        lines += solution(filled, moving, stage)
    last = STAGES - 1
    lines += [f"floats[NEW + {i}] = u{i} + k{last}_{i}" for i in slots]
    lines += [f"floats[NEW + {i}] = z{i}" for i in range(moving, states)]
    lines += ["error = 0.0"]
    for i in slots:
        lines += [f"estimate = abs(k{last}_{i}) * floats[INVERSE_SCALE + {i}]"]
        lines += ["if not (estimate <= error):", "    error = estimate if estimate <= 1e300 else math.inf"]
    return [
        function_source(f"rates({', '.join([*point, 'v', 'w', 'side', *rates.used])})", _returned(rates, values)),
        function_source(call_of_slopes, _returned(slopes, outputs)),
        function_source("attempt(floats, side, h)", [*lines, "return error"]),
    ]


def _slopes(equations: DrivenEquations, writer: DrivenWriter) -> tuple[list[str], list[str], Entries]:
    """(values, names, entries of the Jacobian that do not vanish) of what `slopes` returns."""
    graph, moving, states = equations.graph, equations.moving, equations.states
    jacobian: Entries = set()
    velocity_rate, load_rate = graph.node("state", states + 2), graph.node("state", states + 3)
    values = [writer.name(rate) for rate in equations.rates]
    names = [f"f{i}" for i in range(moving)]
    for i, rate in enumerate(equations.rates):
        for j in range(moving):
            slope = derivative(rate, j)
            if slope.value != 0.0:
                jacobian.add((i, j))
                values.append(writer.name(slope))
                names.append(f"j{i}_{j}")
        by_velocity, by_load = (derivative(rate, states + i) for i in range(2))
        values.append(writer.name(by_velocity * velocity_rate + by_load * load_rate))
        names.append(f"t{i}")
    return values, names, jacobian


def _returned(writer: DrivenWriter, values: list[str]) -> list[str]:
    return [*writer.lines, f"return {_tuple(values)}"] if values else ["return 0.0"]


def _tuple(names: Sequence[str]) -> str:
    return f"({', '.join(names)},)"


def _sum(first: str, weights: np.ndarray, suffix: str) -> str:
    """first + the sum of weights times stages."""
    terms = [f"k{j}{suffix}" if a == 1.0 else f"{a!r} * k{j}{suffix}" for j, a in enumerate(weights.tolist()) if a]
    return " + ".join([first] * bool(first) + terms)


def decomposition(jacobian: Entries, size: int) -> tuple[list[str], Entries]:
    """(lines, entries) of inverse 1 - J = L M: l below a diagonal of ones, m with the reciprocal pivots p.

    Without pivoting: 1/(gamma h) dominates the diagonal for the steps that the error control takes.
    """
    filled = jacobian | {(i, i) for i in range(size)}
    lines = []
    for i, j in sorted(filled):
        entry = f"j{i}_{j}" if (i, j) in jacobian else "0.0"
        lines.append(f"m{i}_{j} = inverse - {entry}" if i == j else f"m{i}_{j} = -{entry}")
    for j in range(size):
        lines.append(f"p{j} = 1.0 / m{j}_{j}")
        for i in range(j + 1, size):
            if (i, j) in filled:
                lines.append(f"l{i}_{j} = m{i}_{j} * p{j}")
                for k in range(j + 1, size):
                    if (j, k) in filled:
                        before = f"m{i}_{k} " if (i, k) in filled else ""
                        lines.append(f"m{i}_{k} = {before}- l{i}_{j} * m{j}_{k}")
                        filled.add((i, k))
    return lines, filled


def solution(filled: Entries, size: int, stage: int) -> list[str]:
    """Lines that solve for the right-hand sides r and leave the stage in k."""
    lines = []
    for i in range(size):
        below = [f" - l{i}_{j} * r{j}" for j in range(i) if (i, j) in filled]
        if below:
            lines.append(f"r{i} = r{i}{''.join(below)}")
    for i in range(size - 1, -1, -1):
        above = "".join(f" - m{i}_{j} * k{stage}_{j}" for j in range(i + 1, size) if (i, j) in filled)
        lines.append(f"k{stage}_{i} = (r{i}{above}) * p{i}" if above else f"k{stage}_{i} = r{i} * p{i}")
    return lines
