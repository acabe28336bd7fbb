"""The variational equations of a system: how a small change of the start, or of a parameter, grows along a motion."""

import copy
import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, Graph, derivative, sensitivity

# Natural size of a tangent that starts with the natural size of a state: derivatives may err by so many tolerances.
# Not without limit: what decays fast along a motion that is smooth already would be followed by steps too long for it.
LEEWAY = 100.0


def carried(equations: Equations) -> tuple[str, ...]:
    """The powers whose integrals `with_integrals` carries: of all channels of energy but the loss in impacts."""
    return tuple(name for i, name in enumerate(equations.channels) if i != equations.impact)


@functools.lru_cache(maxsize=32)
def with_integrals(equations: Equations) -> Equations:
    """The same equations with the integrals of their powers as states behind those of the motion.

    So a tangent tells how the works change. What an impact loses at an instant is no part of them.
    """
    equations = _alone(equations)
    graph, n, names = equations.graph, len(equations.rates), carried(equations)
    powers = [equations.powers[equations.channels.index(name)] for name in names]
    integrals = tuple(graph.node("state", n + k) for k in range(len(powers)))
    one = graph.constant(1.0)

    def longer(states: Sequence[Expression]) -> tuple[Expression, ...]:
        return (*states, *integrals)

    return dataclasses.replace(
        equations,
        state_names=(*equations.state_names, *(f"{name}_integral" for name in names)),
        rates=(*equations.rates, *powers),
        scales=(*equations.scales, *(one for _ in powers)),
        symmetry=(*equations.symmetry, *(1 for _ in powers)),
        contacts=_changed(equations, longer),
        after_switch=tuple(map(longer, equations.after_switch)),
        base=n + len(powers),
        true_loads={},  # nothing is measured
    )


def _alone(equations: Equations) -> Equations:
    """The same equations on a graph of their own, without what was recorded since on theirs.

    So what is made of them is the same in every process: digits too, whatever kernel was written before.
    """
    graph = Graph()
    for node in equations.graph.nodes[: _needed(equations, equations.graph)]:
        graph.node(*node)
    return copy.deepcopy(equations, {id(equations.graph): graph})


def _needed(value: Any, graph: Graph) -> int:
    """How many of the first nodes of a graph a record of expressions needs."""
    if isinstance(value, Expression):
        return value.index + 1 if value.graph is graph else 0
    if dataclasses.is_dataclass(value):
        value = [getattr(value, field.name) for field in dataclasses.fields(value)]
    members = value.values() if isinstance(value, Mapping) else value if isinstance(value, (tuple, list)) else ()
    return max((_needed(member, graph) for member in members), default=0)


def _changed(equations: Equations, reset: Callable[[Sequence[Expression]], tuple[Expression, ...]]) -> tuple:
    """The equations of the contacts with what `reset` makes of the states after a reversal."""
    contacts = equations.contacts
    return tuple(dataclasses.replace(contact, after_reversal=reset(contact.after_reversal)) for contact in contacts)


@functools.lru_cache(maxsize=32)
def variational_equations(equations: Equations, directed: bool = False) -> Equations:
    """The equations of a motion together with one tangent: y' = f(t, y, p), delta' = (df/dy) delta + (df/dp) dp.

    The states of the tangent follow those of the motion. Exact derivatives of the recorded equations; the kernel
    carries the tangent through events by saltation (`kernel/events/tangents.py`).

    directed: whether a direction dp in the parameters belongs to the tangent; it stands behind the parameter vector, as
        long as that. Of a drive with corners one segment holds then, whose numbers are parameters like all others.
    """
    equations = _alone(equations)
    graph, n, own = equations.graph, len(equations.rates), len(equations.parameter_paths)
    numbers = range(own) if directed else range(0)
    tangent = tuple(graph.node("state", n + i) for i in range(n))

    def along(expression: Expression | None) -> Expression:
        """Derivative along the tangent."""
        total = graph.constant(0.0)
        if expression is not None:
            for i in range(n):
                total = total + derivative(expression, i) * tangent[i]
            for j in numbers:
                by = sensitivity(expression, graph.node("parameter", j).index)
                total = total + by * graph.node("parameter", own + j)
        return total

    def both(states: Sequence[Expression]) -> tuple[Expression, ...]:
        return (*states, *map(along, states))

    def reset(states: Sequence[Expression]) -> tuple[Expression, ...]:
        """What an event makes of the states, which comes later by the delay in the direction of the tangent."""
        later = (derivative(state, -1) * graph.node("delay") for state in states)
        return (*states, *(along(state) + more for state, more in zip(states, later, strict=True)))

    return dataclasses.replace(
        equations,
        parameter_paths=(*equations.parameter_paths, *(f"{equations.parameter_paths[j]} direction" for j in numbers)),
        corners=None if directed else equations.corners,
        state_names=(*equations.state_names, *(f"{name}_tangent" for name in equations.state_names)),
        rates=both(equations.rates),
        scales=(*equations.scales, *(LEEWAY * scale for scale in equations.scales)),
        contacts=_changed(equations, reset),
        symmetry=equations.symmetry * 2,
        after_switch=tuple(map(reset, equations.after_switch)),
        guard_tangents=tuple(
            along(value)
            for value in (
                *(value for contact in equations.contacts for value in (contact.velocity, contact.hold, contact.limit)),
                *equations.guards,
            )
        ),
    )
