"""Starts at any phase of the drive: the first part of a period, up to the next section."""

import dataclasses
import functools
from typing import Any

import numpy as np

from vibrocap.motion.equations import Equations
from vibrocap.numerics.api import Budget, memory
from vibrocap.numerics.expressions.graph import Expression, Graph
from vibrocap.orbits.maps.stroboscopic_map import MOST_EVENTS, MOST_STEPS, StroboscopicMap

PHASE_TIME = "start.time"  # path of the parameter that the shifted equations have more than the others
TOLERANCE = 1e-9


@functools.lru_cache(maxsize=32)
def shifted_equations(equations: Equations) -> Equations:
    """The same equations with t + t0 for the time t, where t0 is one parameter more, the last.

    A run of them that begins at t = 0 begins at the time t0 of the drive. No drive needs a phase of its own for that,
    and no other run pays for it.
    """
    graph = Graph()
    graph.nodes.extend(equations.graph.nodes)
    graph._known.update(equations.graph._known)
    late = graph.node("time") + graph.node("parameter", len(equations.parameter_paths))
    moved: dict[int, int] = {}

    def index_of(index: int) -> int:
        """The node that takes the place of one."""
        if index not in moved:
            op, *operands = equations.graph.nodes[index]
            if op == "time":
                moved[index] = late.index
            elif op in ("constant", "side", "state", "parameter"):
                moved[index] = index
            else:
                moved[index] = graph.node(op, *map(index_of, operands)).index
        return moved[index]

    def shifted(value: Any) -> Any:
        if isinstance(value, Expression):
            return Expression(graph, index_of(value.index))
        if isinstance(value, tuple):
            return tuple(map(shifted, value))
        return {name: shifted(each) for name, each in value.items()} if isinstance(value, dict) else value

    fields = {field.name: shifted(getattr(equations, field.name)) for field in dataclasses.fields(equations)}
    fields |= {"graph": graph, "parameter_paths": (*equations.parameter_paths, PHASE_TIME)}
    return Equations(**fields)


def at_next_section(
    map_: StroboscopicMap, states: np.ndarray, parameters: np.ndarray, phase: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(states at the next start of a drive period [runs, states], numbers of `memory_layout` for how each run ended).

    phase: [runs] where in the drive's period each run starts, as a share of it (whole parts do not matter); a run that
        starts at the section is there already
    """
    share = phase - np.floor(phase)
    waiting = np.flatnonzero(share)
    ends, ended = states.copy(), np.full(len(states), memory.DONE)
    if not len(waiting):
        return ends, ended
    period = np.array([map_.period(row) for row in np.unique(parameters, axis=0)])
    length = period[0] if len(period) == 1 else np.array([map_.period(row) for row in parameters[waiting]])
    found = map_.run(
        Budget(1, 1, 0.0, TOLERANCE, MOST_EVENTS, MOST_STEPS),
        states[waiting],
        np.column_stack((parameters[waiting], share[waiting] * length)),
        recording=shifted_equations(map_.equations),
        mark_distance=(1.0 - share[waiting]) * length,
    )
    ends[waiting], ended[waiting] = found.state, found.status
    return ends, ended
