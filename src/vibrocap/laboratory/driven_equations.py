"""The equations of a law under an imposed motion, recorded for the numerics."""

import functools
from collections.abc import Sequence
from typing import Any

from vibrocap.motion.equations import is_recorded
from vibrocap.numerics.api import DrivenEquations, sharpness
from vibrocap.numerics.expressions.graph import Graph
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table


def driven_equations(law: Law, free: tuple[str, ...]) -> DrivenEquations:
    """Recorded equations of a law; laws of one form share them. free: parameters that are recorded in any case."""
    recorded, fixed = [], []
    for info in parameter_table(law):
        value = getattr(law, info.name)
        if info.name in free or is_recorded(law, info.name, value):
            recorded.append(info.name)
        else:
            fixed.append((info.name, value))
    return _recorded(type(law), tuple(recorded), tuple(fixed))


@functools.lru_cache(maxsize=64)
def _recorded(kind: type[Law], names: tuple[str, ...], fixed: tuple) -> DrivenEquations:
    graph = Graph()
    law = object.__new__(kind)
    for i, name in enumerate(names):
        object.__setattr__(law, name, graph.node("parameter", i))
    for name, value in fixed:
        object.__setattr__(law, name, value)
    moving = [name for name in law.internal if name not in law.switched]
    sorted_names = moving + [name for name in law.internal if name in law.switched]
    order = [sorted_names.index(name) for name in law.internal]
    k = len(order)
    states = [graph.node("state", i) for i in range(k)]
    velocity, load, side = graph.node("state", k), graph.node("state", k + 1), graph.node("side")
    internal = tuple(states[i] for i in order)

    def in_order(values: Sequence[Any]) -> tuple:
        return tuple(graph.expression(values[order.index(i)]) for i in range(k))

    force, rates = law.force(velocity, internal, side, load)
    moved = in_order(rates)[: len(moving)]
    sharp = sharpness(graph, moved, velocity, states[: len(moving)])
    guards = law.switches(velocity, internal, side, load)
    return DrivenEquations(
        graph=graph,
        parameter_names=names,
        order=tuple(order),
        moving=len(moving),
        rates=moved,
        force=graph.expression(force),
        guards=tuple(graph.expression(guard) for guard in guards),
        after_switch=tuple(
            in_order(law.after_switch(which, velocity, internal, side, load)) for which in range(len(guards))
        ),
        after_reversal=in_order(law.after_reversal(internal, side, load)),
        scales=in_order(law.internal_scales(load)),
        sharp=sharp.arguments,
        sharp_internal=sharp.internal,
        set_valued=law.kind == "set-valued",
    )
