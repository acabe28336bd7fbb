"""Powers of a contact velocity where it vanishes: steps end there, and start as v = c t^2 from stick, else as v = c t.

A power that is not whole has no series there. It is constant in the first step, in which it is negligible; v then grows
by a factor of 3 at most a step until the power is resolved (`resolution.py`). A whole power |v|^m, m > 1, has a series
with gaps, whose last terms may vanish or tell nothing: four of them bound the first step from stick (`taylor_step`),
and for m > 2 so does the first one that is left out (`resolution.py`). Where a contact leaves stick the error of v is
held to less than the tolerance, for a power that is not whole or from the third on (`taylor.leaving`).
"""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, Graph, evaluate, reachable

AT_REST = 1e-10  # base of a power that is zero but for rounding, where parts of a velocity cancel
SLOW = 2.0**-5  # of the two speeds at which an argument is looked at, one twice the other


@dataclasses.dataclass(frozen=True)
class Speed:
    """A velocity of a contact, or an internal state: where its series stands, and whose natural size it has."""

    expression: Expression
    row: str
    state: int
    sticks: bool  # whether it is exactly zero at times


def speeds(equations: Equations) -> list[Speed]:
    """All on which sharp functions may depend: the velocities of the contacts and the states of their laws."""
    contacts, node = equations.contacts, equations.graph.node
    velocities = [Speed(own.velocity, f"VELOCITY_OF[{i}]", own.state, own.sticks) for i, own in enumerate(contacts)]
    internal = [i for contact in contacts for i in contact.internal]
    return velocities + [Speed(node("state", i), f"SERIES + {i} * (ORDER + 1) * LANES", i, False) for i in internal]


def zero_of_base(graph: Graph, base: int) -> float:
    """Size of its base up to which a power has no series: rounding, of which a single state at rest has none."""
    varying = [i for i in reachable(graph, [base]) if graph.nodes[i][0] in ("state", "time")]
    return 0.0 if len(varying) == 1 else AT_REST


def no_series_at_rest(velocity: Expression, expressions: Sequence[Expression]) -> bool:
    """Whether these contain a power of the velocity that is not whole, and so has no series where it vanishes."""
    graph = velocity.graph
    reached = reachable(graph, [expression.index for expression in expressions])
    return velocity.index in reachable(graph, [i for i in reached if graph.nodes[i][0] == "power"])


def gaps(equations: Equations, sharp: Sequence[int]) -> dict[int, tuple[Speed, int]]:
    """The sharp nodes whose argument vanishes at rest like |v|^m, m = 2, 3 ..., the velocity v and this m.

    From v = c t, or c t^2, their series is one in t^m, or t^2m: the last terms may vanish, or no term be left.
    """
    graph, gaps_by_node = equations.graph, {}
    draw = np.random.default_rng(0)
    states = list(draw.uniform(0.1, 0.9, len(equations.rates)))
    values = draw.uniform(0.5, 1.5, len(equations.parameter_paths))
    for node in sharp:
        argument = Expression(graph, graph.nodes[node][-1])
        below = reachable(graph, [argument.index])
        rough = graph.nodes[node][0] in ("log", "power") or any(graph.nodes[i][0] == "power" for i in below)
        for speed in () if rough else speeds(equations):
            if speed.expression.index not in below:
                continue
            states[speed.state], before = 0.0, states[speed.state]
            (shift,) = evaluate([speed.expression], 0.3, states, 1.0, values)
            with np.errstate(all="ignore"):
                near = []
                for v in (0.0, SLOW, 2.0 * SLOW):
                    states[speed.state] = v - shift
                    near.append(evaluate([argument], 0.3, states, 1.0, values)[0])
            states[speed.state] = before
            one, two = abs(near[1] - near[0]), abs(near[2] - near[0])
            if 0.0 < one < two < math.inf and math.log2(two / one) > 1.5:
                gaps_by_node[node] = speed, round(math.log2(two / one))
    return gaps_by_node
