"""The variational equations of a system: how a small change of the start grows along a motion."""

import copy
import dataclasses
import functools
from collections.abc import Sequence

from vibrocap.motion.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, derivative

# Natural size of a tangent that starts with the natural size of a state: derivatives may err by so many tolerances.
# Not without limit: what decays fast along a motion that is smooth already would be followed by steps too long for it.
LEEWAY = 100.0


@functools.lru_cache(maxsize=32)
def variational_equations(equations: Equations) -> Equations:
    """The equations of a motion together with one tangent: y' = f(t, y), delta' = (df/dy) delta.

    The states of the tangent follow those of the motion. Exact derivatives of the recorded equations; the kernel
    carries the tangent through events by saltation (`kernel/events/tangents.py`).
    """
    graph = copy.deepcopy(equations.graph)
    n = len(equations.rates)
    tangent = tuple(graph.node("state", n + i) for i in range(n))

    def moved(expression: Expression) -> Expression:
        return Expression(graph, expression.index)

    def along(expression: Expression | None) -> Expression:
        """Derivative along the tangent."""
        total = graph.constant(0.0)
        if expression is not None:
            for i in range(n):
                total = total + derivative(moved(expression), i) * tangent[i]
        return total

    def both(states: Sequence[Expression]) -> tuple[Expression, ...]:
        return (*map(moved, states), *map(along, states))

    def reset(states: Sequence[Expression]) -> tuple[Expression, ...]:
        """What an event makes of the states, which comes later by the delay in the direction of the tangent."""
        later = (derivative(moved(state), -1) * graph.node("delay") for state in states)
        return (*map(moved, states), *(along(state) + more for state, more in zip(states, later, strict=True)))

    return dataclasses.replace(
        equations,
        graph=graph,
        state_names=(*equations.state_names, *(f"{name}_tangent" for name in equations.state_names)),
        rates=both(equations.rates),
        integrals=tuple(map(moved, equations.integrals)),
        scales=(*map(moved, equations.scales), *(LEEWAY * moved(scale) for scale in equations.scales)),
        contacts=tuple(each.moved(moved, reset) for each in equations.contacts),
        rows=None if equations.rows is None else equations.rows.moved(moved),
        shifts=tuple(map(moved, equations.shifts)),
        period=moved(equations.period),
        symmetry=equations.symmetry * 2,
        switches=tuple(map(moved, equations.switches)),
        loads=tuple(map(moved, equations.loads)),
        bounds=tuple(map(moved, equations.bounds)),
        balance=None if equations.balance is None else equations.balance.on(graph),
        after_switch=tuple(map(reset, equations.after_switch)),
        observables={name: moved(value) for name, value in equations.observables.items()},
        guard_tangents=tuple(
            along(value)
            for value in (
                *(value for each in equations.contacts for value in (each.velocity, each.hold, each.limit)),
                *equations.guards,
            )
        ),
    )
