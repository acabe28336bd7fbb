"""Writes the equations of one instant as a kernel of its own: for integrators that are not ours, which ask for rates.

The memory is one array of floats: what is given (parameters, states, time, side), then what the equations say.
"""

import dataclasses
import itertools
from collections.abc import Mapping, Sequence

from vibrocap.numerics.codegen.straight_line import ScalarWriter, chosen_source, function_source
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, derivative

ARGUMENTS = "floats, ints, trace, number"
START = ("lane, point, side = 0, STATE, floats[SIDE]", "t = floats[TIME] - floats[ORIGIN]")


@dataclasses.dataclass(frozen=True)
class Instant:
    """The equations of one contact at an instant: where each quantity stands in the memory, by name, and the source.

    sizes: numbers of each entry, in their order. Given: PARAMETER, STATE, TIME, ORIGIN (of the present period of the
    drive) and SIDE (+1, -1; 0 at rest). Written by `period` and `table`: PERIOD, and TABLE (of each segment of a drive
    with corners its length and its coefficients, in the part of the period that begins at TIME). Written by `instant`:
    RATE (of the states), VELOCITY of the contact, HOLD (the force that would hold it, over the middle of what it can
    hold) and LIMIT (how far that reaches), BOUND (positive while the equations hold), SWITCH (positive within the
    present branches), SCALE (natural sizes of the states) and OBSERVED. Written by `after_switch`: NEXT, the states
    after a guard of SWITCH has fallen to zero.
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


def instant_source(equations: Equations, own_drive: bool) -> Instant:
    """The functions, each of (floats, ints, trace, number), of equations with one contact that can rest.

    own_drive: whether the drive is that of the case, so that its segments, if it has corners, follow one another
    """
    contact, observed, corners = equations.contacts[0], equations.observables, equations.corners
    rates = list(equations.rates)
    if contact.is_state or derivative(contact.velocity, -1).value == 0.0:  # exactly zero at rest, as in every kernel
        side = equations.graph.node("side")
        rates[contact.state] = side * side * rates[contact.state]
    period = {"PERIOD": (equations.period,)}
    table = {"TABLE": () if corners is None or not own_drive else tuple(corners.numbers)}
    instant = {
        "RATE": tuple(rates),
        "VELOCITY": (contact.velocity,),
        "HOLD": (contact.hold,),
        "LIMIT": (contact.limit,),
        "BOUND": equations.bounds,
        "SWITCH": equations.switches,
        "SCALE": equations.scales,
        "OBSERVED": tuple(observed.values()),
    }
    given = {"PARAMETER": len(equations.parameter_paths), "STATE": len(rates), "TIME": 1, "ORIGIN": 1, "SIDE": 1}
    sizes = given | {name: len(values) for name, values in (period | table | instant).items()}
    sizes["NEXT"] = len(rates)
    found = Instant(sizes, tuple(observed), "")
    after = [ScalarWriter(equations.graph).stores(states, "NEXT") for states in equations.after_switch]
    text = [
        *(f"{name} = {place}" for name, place in {**found.places, "LANES": 1}.items()),
        "",
        _function("period", period),
        _function("table", table),
        _function("instant", instant),
        chosen_source(f"after_switch({ARGUMENTS})", "number", after, START),
    ]
    return dataclasses.replace(found, text="\n".join(text))


def _function(name: str, written: Mapping[str, Sequence[Expression]]) -> str:
    """A function that writes the values of expressions of one graph to their entries."""
    values = [value for each in written.values() for value in each]
    writer = ScalarWriter(values[0].graph if values else None)
    named = [(entry, i, writer.name(value)) for entry, each in written.items() for i, value in enumerate(each)]
    stores = [f"floats[{entry} + {i}] = {value}" for entry, i, value in named]
    return function_source(f"{name}({ARGUMENTS})", [*START, *writer.lines, *stores])
