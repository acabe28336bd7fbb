"""Which sharp functions have no series at rest, or one with few terms: powers of a velocity, but for the first two.

A contact leaves stick as v = c t^2 and turns as v = c t.
"""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, evaluate, reachable

SLOW = 2.0**-5  # of the two speeds at which an argument is looked at, one twice the other


@dataclasses.dataclass(frozen=True)
class Speed:
    """A velocity of a contact, or an internal state: where its series stands, and whose natural size it has."""

    expression: Expression
    row: str
    state: int
    sticks: bool  # whether it is exactly zero at times


def speeds(equations: Equations) -> list[Speed]:
    """All on which sharp functions may depend, the velocity of the first contact before the others."""
    found = [Speed(equations.contact_velocity, "VELOCITY", equations.contact_state, equations.hold is not None)]
    pinned = [velocity.index for velocity in equations.pinned]
    for i, velocity in enumerate(equations.imposed_velocities):
        row = f"IMPOSED + {i} * (ORDER + 1) * LANES"
        found.append(Speed(velocity, row, equations.contact_state, velocity.index in pinned))
    for i in equations.internal_states:
        row = f"SERIES + {i} * (ORDER + 1) * LANES"
        found.append(Speed(equations.graph.node("state", i), row, i, i in equations.resting))
    return found


def rough(equations: Equations, sharp: Sequence[int]) -> bool:
    """Whether the law of a contact that sticks has a logarithm of its velocity: a power without a series at rest."""
    graph, contact = equations.graph, equations.contact_velocity.index
    logs = [node for node in sharp if graph.nodes[node][0] == "log"]
    return equations.hold is not None and any(contact in reachable(graph, [node]) for node in logs)


def gaps(equations: Equations, sharp: Sequence[int]) -> dict[int, tuple[Speed, int]]:
    """The sharp nodes whose argument vanishes at rest like |v|^m, m = 3, 4 ..., the velocity v and this m.

    From v = c t, or c t^2, their series is one in t^m, or t^2m: the last terms may vanish, or no term be left.
    """
    graph, found = equations.graph, {}
    draw = np.random.default_rng(0)
    states = list(draw.uniform(0.1, 0.9, len(equations.rates)))
    values = draw.uniform(0.5, 1.5, len(equations.parameter_paths))
    for node in sharp:
        op, *operands = graph.nodes[node]
        argument = Expression(graph, operands[-1])
        for speed in speeds(equations):
            if op == "log" or speed.expression.index not in reachable(graph, [argument.index]):
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
            if 0.0 < one < two < math.inf and math.log2(two / one) > 2.5:
                found[node] = speed, round(math.log2(two / one))
    return found


def place_of_returns(equations: Equations) -> dict[str, float]:
    """Where a motion returns that comes to rest nowhere: a turn, or the largest value of the first coordinate."""
    turns = dict(equations.turns)
    moving = (i for i, rate in enumerate(equations.rates) if i != equations.cyclic_state and rate.value != 0.0)
    place = next(iter(turns), None)
    place = next(moving, 0) if place is None else place
    return {"PLACE": place, "PLACE_TURN": float(turns.get(place, 0.0))}
