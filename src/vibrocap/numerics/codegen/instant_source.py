"""Writes the equations of one instant as a kernel of its own: for integrators that are not ours, which ask for rates.

The memory is one array of floats: what is given (parameters, states, time, side), then what the equations say.
"""

import dataclasses
import itertools
from typing import Any

from vibrocap.numerics.codegen.driven_source import function_source
from vibrocap.numerics.codegen.source import ScalarWriter
from vibrocap.numerics.expressions.graph import derivative

START = (
    "lane, point, side = 0, STATE, floats[SIDE]",
    "period = period_of_drive(floats, lane)",
    "t = floats[TIME] - math.floor(floats[TIME] / period) * period",
)


@dataclasses.dataclass(frozen=True)
class Instant:
    """The equations of one contact at an instant: where each quantity stands in the memory, by name, and the source.

    sizes: numbers of each entry, in their order. Given: PARAMETER, STATE, TIME and SIDE (+1, -1; 0 at rest). Written:
    RATE (of the states), VELOCITY of the contact, HOLD (the force that would hold it, over the middle of what it can
    hold) and LIMIT (how far that reaches), BOUND (positive while the equations hold), SCALE (natural sizes of the
    states) and OBSERVED.
    """

    sizes: dict[str, int]
    observed: tuple[str, ...]
    text: str

    @property
    def places(self) -> dict[str, int]:
        """Where each entry begins."""
        starts = itertools.accumulate(self.sizes.values(), initial=0)
        return dict(zip(self.sizes, starts, strict=False))

    @property
    def size(self) -> int:
        """Floats of the memory."""
        return sum(self.sizes.values())


def instant_source(equations: Any) -> Instant:
    """`instant(floats, ints, trace, steps)` of equations with one contact that can rest."""
    contact, observed = equations.contacts[0], equations.observables
    rates = list(equations.rates)
    if contact.is_state or derivative(contact.velocity, -1).value == 0.0:  # exactly zero at rest, as in every kernel
        side = equations.graph.node("side")
        rates[contact.state] = side * side * rates[contact.state]
    written = {
        "RATE": tuple(rates),
        "VELOCITY": (contact.velocity,),
        "HOLD": (contact.hold,),
        "LIMIT": (contact.limit,),
        "BOUND": equations.bounds,
        "SCALE": equations.scales,
        "OBSERVED": tuple(observed.values()),
    }
    given = {"PARAMETER": len(equations.parameter_paths), "STATE": len(rates), "TIME": 1, "SIDE": 1}
    sizes = given | {name: len(values) for name, values in written.items()}
    instant = Instant(sizes, tuple(observed), "")
    writer = ScalarWriter(equations.graph)
    stores = [
        f"floats[{name} + {i}] = {writer.name(value)}" for name, each in written.items() for i, value in enumerate(each)
    ]
    of_period = ScalarWriter(equations.graph)
    period = of_period.name(equations.period)
    text = [
        *(f"{name} = {place}" for name, place in {**instant.places, "LANES": 1}.items()),
        "",
        function_source("period_of_drive(floats, lane)", [*of_period.lines, f"return {period}"]),
        function_source("instant(floats, ints, trace, steps)", [*START, *writer.lines, *stores]),
    ]
    return dataclasses.replace(instant, text="\n".join(text))
