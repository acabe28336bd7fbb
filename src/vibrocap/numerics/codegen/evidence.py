"""Writes what `kernel/observe/evidence.py` asks of the equations."""

from vibrocap.numerics.codegen.source import ScalarWriter
from vibrocap.numerics.expressions.equations import Equations


def evidence_source(equations: Equations) -> str:
    """`evidence` of one lane."""
    writer = ScalarWriter(equations.graph)
    zero, asked = equations.graph.constant(0.0), list(equations.rates[: equations.base])
    for each in equations.contacts:
        further = each is not equations.contacts[0] and each.kind != "smooth"
        pair = (each.hold, each.limit) if each.sticks else (zero, zero)
        asked += [*pair, each.velocity if further else zero]
    body = [f"floats[out + {i}] = {writer.name(value)}" for i, value in enumerate(asked)]
    return "\n".join(
        ["def evidence(floats, t, point, side, lane, out):", *(f"    {line}" for line in (*writer.lines, *body)), ""]
    )
