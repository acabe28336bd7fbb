"""The corners of a drive as its parameters make them, recorded, and the segment that holds at a time.

The equations of a system whose drive has corners are recorded with the coefficients of one segment as numbers, behind
the parameters of the system: (period of the drive, start of the segment, coefficients in powers of time). Which numbers
these are, at any time and for any parameters, is told here.
"""

from typing import Any

from vibrocap.numerics.expressions.corners import Corners
from vibrocap.numerics.expressions.graph import Graph
from vibrocap.physics.closed_loop.sampling import SampledReference
from vibrocap.physics.drives.drive import Piecewise

PATHS = ("segment.period", "segment.start", "segment.coefficient_")


def segment_paths(drive: Piecewise) -> tuple[str, ...]:
    """Names of the numbers of the present segment in the parameter vector."""
    period, start, coefficient = PATHS
    return (period, start, *(f"{coefficient}{k}" for k in range(drive.degree + 1)))


def recorded_corners(drive: Any, graph: Graph, place: int) -> Corners | None:
    """The corners of a drive whose parameters are symbols on a graph; None for one that has none."""
    if not isinstance(drive, Piecewise):
        return None
    sampled = isinstance(drive, SampledReference)
    segments = drive.segments(graph.node("time")) if sampled else drive.segments()
    return Corners(
        place=place,
        coefficients=drive.degree + 1,
        period=graph.expression(drive.period),
        lengths=tuple(graph.expression(segment.length) for segment in segments),
        shapes=tuple(tuple(map(graph.expression, segment.coefficients)) for segment in segments),
        parts=graph.expression(drive.parts if sampled else 1.0),
    )
