"""Where the shapes of a machine are along a motion."""

import dataclasses

import numpy as np

from vibrocap.motion.recording.recorded_machine import recorded_scene
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.expressions.graph import evaluated
from vibrocap.physics.mechanics.pictures import Shape


@dataclasses.dataclass(frozen=True, eq=False)
class MovingShape:
    """A shape of the machine's scene with its places: points [points, 2, times], in units of `drawn_length`."""

    shape: Shape
    points: np.ndarray


def moving_shapes(motion: Trajectory, times: np.ndarray) -> list[MovingShape]:
    """The shapes of the machine at times of a motion, in the order in which they are drawn."""
    shapes, drifts, _ = recorded_scene(motion.system)
    index = motion.piece_at(times)
    local, parameters = motion.drive_at(index, times - motion.piece_start[index])
    periods = np.rint((times - motion.start_time - local) / motion.period + motion.start_phase)
    drawn = [coordinate for shape in shapes for point in shape.points for coordinate in point]
    rows = evaluated(drawn, local, motion.states(times), 1.0, parameters, times.shape)
    for i, drift in drifts.items():
        rows[i] += periods * evaluated([drift], local, motion.states(times), 1.0, parameters, times.shape)[0]
    ends = np.cumsum([2 * len(shape.points) for shape in shapes])
    moving = [
        MovingShape(shape, own.reshape(len(shape.points), 2, len(times)))
        for shape, own in zip(shapes, np.split(rows, ends[:-1]), strict=True)
    ]
    for box in [moved for moved in moving if moved.shape.kind == "box"]:
        inside = [moved for moved in moving if moved.shape.kind == "disc" and moved.shape.box == box.shape.name]
        far = [float(np.abs(shape.points[0, 0] - box.points[0, 0]).max()) + shape.shape.size[0] for shape in inside]
        more = max(far, default=0.0) - 0.5 * box.shape.size[0]
        if more > 0.0:
            moving = [
                _widened(moved, more) if box.shape.name in (moved.shape.name, moved.shape.box) else moved
                for moved in moving
            ]
    return moving


def _widened(moved: MovingShape, more: float) -> MovingShape:
    """A box, or what belongs to it, with its walls so much farther out."""
    if moved.shape.kind in ("box", "contact"):
        width, height = moved.shape.size
        return dataclasses.replace(moved, shape=dataclasses.replace(moved.shape, size=(width + 2.0 * more, height)))
    if moved.shape.kind == "spring":
        moved.points[0, 0] -= more
    return moved
