"""What a machine says besides its equations, recorded on a graph that begins with theirs: its shapes and its room."""

import copy
import dataclasses
import math
from collections.abc import Iterable

from vibrocap.motion.recording.equations import equations, put_on_segment, with_symbols
from vibrocap.numerics.expressions.graph import Expression, Graph
from vibrocap.physics.dimensions.scales import SIScales
from vibrocap.physics.mechanics.pictures import Shape
from vibrocap.physics.system import System

FAR = 1e300  # a bound that is none


def drawn_length(system: System) -> float:
    """The length by which a machine is drawn, about the width of a body: the unit of its equations.

    Where that says nothing of its size, as in SI: how far it moves by its natural sizes, but no more than the length
    over which its parts lie and no less than a tenth of that; of these the next in 1, 2, 5, 10, 20, ...
    """
    if system.machine.si_scales is not SIScales:
        return 1.0
    units = system.machine.state_units
    moved = [size for name, size in zip(system.state_names, system.scales(), strict=True) if units.get(name) == "m"]
    machine = system.placed
    try:
        shapes = machine.scene(0.0, (0.0,) * len(machine.states))
    except (ArithmeticError, ValueError):  # there may be no such state
        shapes = ()
    places = zip(*(point for shape in shapes for point in shape.points), strict=True)
    reach = max((max(each) - min(each) for each in places), default=0.0)
    length = min(moved, default=1.0) or 1.0
    length = min(max(length, 0.1 * reach), reach) if reach else length
    decade = 10.0 ** math.floor(math.log10(length))
    return min((step * decade for step in (1.0, 2.0, 5.0, 10.0)), key=lambda each: abs(math.log(each / length)))


def recorded_scene(system: System) -> tuple[tuple[Shape, ...], dict[int, Expression], Expression]:
    """(shapes of the machine, drifts, its constant or mean load), on a graph that begins with the equations' own.

    Points are where they are drawn in the first period, in units of `drawn_length`. Drifts: how much farther some of
    their coordinates, by number, are in each period than in the one before, as a table that turns evenly moves on.
    """
    graph, recorded = _recorded_system(system)
    machine, own = recorded.placed, recorded.machine
    length = drawn_length(system)
    y = tuple(graph.node("state", i) for i in range(len(system.machine.states)))

    def coordinates(shapes: Iterable[Shape]) -> list[Expression]:
        return [graph.expression(x) for shape in shapes for point in shape.places(length) for x in point]

    shapes = machine.scene(graph.node("time"), y)
    drawn = iter(coordinates(shapes))
    places = tuple(
        dataclasses.replace(shape, points=tuple((next(drawn), next(drawn)) for _ in shape.points), aside=())
        for shape in shapes
    )
    still = own.driven_by(None, (None,) * len(own.signals))  # what moves by itself
    period = graph.expression(recorded.drive.period)
    pairs = zip(coordinates(still.scene(0.0, y)), coordinates(still.scene(period, y)), strict=True)
    drifts = {i: later - first for i, (first, later) in enumerate(pairs) if later.index != first.index}
    return places, drifts, graph.expression(machine.loads()[0])


def recorded_room(system: System) -> dict[str, tuple[Expression, Expression]]:
    """Between which values states may begin, by name (`Machine.room`), recorded on such a graph too."""
    graph, recorded = _recorded_system(system)
    return {
        name: (graph.expression(max(low, -FAR) if isinstance(low, float) else low), graph.expression(high))
        for name, (low, high) in recorded.placed.room().items()
    }


def _recorded_system(system: System) -> tuple[Graph, System]:
    """A system with symbols for its numbers, on a graph that begins with the equations' own."""
    recording = equations(system)
    graph = copy.deepcopy(recording.graph)  # what is drawn is none of the equations' business
    symbols = {path: graph.node("parameter", i) for i, path in enumerate(recording.parameter_paths)}
    recorded = System.unchecked({part: with_symbols(part, values, symbols) for part, values in system.parts.items()})
    if recording.corners is not None:
        put_on_segment(recorded, graph, recording.corners.place)
    return graph, recorded
