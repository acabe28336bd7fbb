"""Writes what `kernel/observe/evidence.py` asks of the equations."""

from typing import Any

from vibrocap.numerics.codegen.source import ScalarWriter


def evidence_source(equations: Any) -> str:
    """`evidence` of one lane, and what there is to ask."""
    writer = ScalarWriter(equations.graph)
    held = [value for _, hold, limit in equations.holds for value in (hold, limit)]
    asked = (*equations.rates[: equations.base], *held, *equations.further_slides)
    body = [f"floats[out + {i}] = {writer.name(value)}" for i, value in enumerate(asked)]
    constants = {
        "HOLDS": len(equations.holds),
        "HOLD_SIDES": tuple(side for side, _, _ in equations.holds) or (-1,),
        "FURTHER_SLIDES": len(equations.further_slides),
    }
    lines = [f"{name} = {value!r}" for name, value in constants.items()]
    lines += ["", "def evidence(floats, t, point, side, lane, out):"]
    return "\n".join([*lines, *(f"    {line}" for line in (*writer.lines, *body)), ""])
