"""What a machine says besides its equations, recorded on a graph that begins with theirs: its shapes and its room."""

import copy
import dataclasses
from typing import Any

from vibrocap.motion.recording.equations import equations, put_on_segment, with_symbols
from vibrocap.numerics.expressions.graph import Expression, Graph
from vibrocap.physics.bodies import Shape
from vibrocap.physics.system import System

FAR = 1e300  # a bound that is none


def recorded_scene(system: System) -> tuple[tuple[Shape, ...], Expression]:
    """(shapes of the machine, its constant or mean load), recorded on a graph that begins with the equations' own."""
    graph, machine = _recorded_machine(system)
    y = tuple(graph.node("state", i) for i in range(len(system.machine.states)))
    shapes = tuple(
        dataclasses.replace(shape, points=tuple((graph.expression(x), graph.expression(z)) for x, z in shape.points))
        for shape in machine.scene(graph.node("time"), y)
    )
    return shapes, graph.expression(machine.loads()[0])


def recorded_room(system: System) -> dict[str, tuple[Expression, Expression]]:
    """Between which values states may begin, by name (`Machine.room`), recorded on such a graph too."""
    graph, machine = _recorded_machine(system)
    return {
        name: (graph.expression(max(low, -FAR) if isinstance(low, float) else low), graph.expression(high))
        for name, (low, high) in machine.room().items()
    }


def _recorded_machine(system: System) -> tuple[Graph, Any]:
    """The machine in its environment with symbols for its numbers, on a graph that begins with the equations' own."""
    recording = equations(system)
    graph = copy.deepcopy(recording.graph)  # what is drawn is none of the equations' business
    symbols = {path: graph.node("parameter", i) for i, path in enumerate(recording.parameter_paths)}
    recorded = System.unchecked({part: with_symbols(part, values, symbols) for part, values in system.parts.items()})
    if recording.corners is not None:
        put_on_segment(recorded, graph, recording.corners.place)
    return graph, recorded.placed
