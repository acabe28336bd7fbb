"""Hysteresis: the loop of friction against velocity and against displacement over one period."""

import dataclasses

import numpy as np

from vibrocap.measures.branches import Branches, Excursion, branches
from vibrocap.measures.stretch import Stretch, contact_place, stretches
from vibrocap.measures.windows import period_times
from vibrocap.motion.trajectory import BACK, FORWARD, STUCK, Trajectory

# Friction differences below this share of the peak, or below so many tolerances of the run, count as none.
NO_DIFFERENCE = 1e-9
NO_DIFFERENCE_TOLERANCES = 100.0
STEEP = 1e-6  # of the greatest acceleration: below it a point is a turning point of the velocity, not an offset point
CURVE_POINTS = 8  # per piece


@dataclasses.dataclass(frozen=True)
class LoopPoint:
    """A point of the loop; displacement counts from the window's start, accelerating means that |v| grows."""

    time: float
    velocity: float
    displacement: float
    friction: float
    accelerating: bool


@dataclasses.dataclass(frozen=True)
class LoopSide:
    """The loop on one side, of which points and branches are those of the widest slide of the period.

    excursion: (start, end) of that slide, the one of greatest speed; it may begin before the period
    escape: M1 of the paper's Fig. 8, where the capsule escapes from presliding and enters pure sliding: here the first
        local maximum of |R| along the slide while it accelerates, from which on bristles slip more than they stretch.
        With a set-valued law, the point where it leaves rest. None where friction rises up to the turning point
    offset_points: all points of the slide with dR/dv = 0, M1 included
    crossings: speeds at which the accelerating and the decelerating branch change places; slow sliding has v* there
    presliding, pure_sliding: the branches below and above the boundary speed; None where the slide does not come there
    """

    excursion: tuple[float, float]
    escape: LoopPoint | None
    offset_points: tuple[LoopPoint, ...]
    crossings: tuple[float, ...]
    presliding: Branches | None
    pure_sliding: Branches | None


@dataclasses.dataclass(frozen=True)
class FrictionLoop:
    """Friction over one period.

    boundary: speed that parts presliding (below) from pure sliding (above)
    velocity_area: oint R dv, positive if clockwise: friction larger while accelerating
    displacement_area: oint R dx, the work done against friction, all that the contact lost or stored
    peak: where |R| is largest; peak_force: that |R|
    """

    window: tuple[float, float]
    boundary: float
    velocity_area: float
    displacement_area: float
    peak_force: float
    peak: LoopPoint
    forward: LoopSide | None
    back: LoopSide | None


@dataclasses.dataclass(frozen=True)
class FrictionCurve:
    """Points along one period, several on every piece and both its ends, so that jumps stand upright. All [points]."""

    time: np.ndarray
    velocity: np.ndarray
    displacement: np.ndarray
    friction: np.ndarray
    side: np.ndarray


def friction_loop(motion: Trajectory, period: int = -1, *, boundary: float | None = None) -> FrictionLoop:
    """The friction loop of one whole period, the last unless named.

    Friction that remembers takes different ways up and down in velocity. Areas are Gauss sums over the pieces of the
    motion, cut where |v| passes the boundary, so they are exact to rounding for the motion as computed: oint R dx is
    what the energy channels say was lost and stored.

    boundary: speed between presliding and pure sliding. By default that of M1 (`LoopSide.escape`), the greater of both
        directions; where no direction escapes, the greatest speed, and all is presliding; 0 for a law that only sticks
        or slides.

    A clockwise loop in pure sliding is what the paper finds; at its printed delta1 the loop runs the other way above
    v* (`limits.boundary_velocity`, erratum 7). Raises ValueError where the motion has no such period, or for a boundary
    that is not a number >= 0.
    """
    start, end = period_times(motion, period)
    if boundary is not None and not 0.0 <= boundary < np.inf:
        raise ValueError(f"boundary should be a speed >= 0, got {boundary!r}")
    parts = stretches(motion, start, end)
    origin = float(contact_place(motion, np.array([start]))[0])
    peak = _peak(parts, origin)
    least = max(NO_DIFFERENCE, NO_DIFFERENCE_TOLERANCES * motion.tolerance) * abs(peak.friction)
    excursions = {side: _widest_excursion(motion, parts, start, end, side) for side in (FORWARD, BACK)}
    escapes = {side: _escape(slide, origin, least) for side, slide in excursions.items() if slide is not None}
    if boundary is None:
        boundary = _default_boundary(motion, excursions, escapes)
    areas, lost = _areas(parts, boundary)
    sides = {
        side: LoopSide(
            excursion=(slide.stretch.start, slide.stretch.end),
            escape=escapes[side],
            offset_points=_offset_points(slide.stretch, origin, least),
            crossings=slide.crossings(least),
            presliding=branches(slide, areas[side, True], 0.0, boundary, least),
            pure_sliding=branches(slide, areas[side, False], boundary, np.inf, least),
        )
        for side, slide in excursions.items()
        if slide is not None
    }
    return FrictionLoop(
        window=(start, end),
        boundary=float(boundary),
        velocity_area=sum(areas.values()),
        displacement_area=lost,
        peak_force=abs(peak.friction),
        peak=peak,
        forward=sides.get(FORWARD),
        back=sides.get(BACK),
    )


def friction_curve(motion: Trajectory, period: int = -1) -> FrictionCurve:
    """Friction, velocity and displacement along one whole period, for drawing its loops."""
    start, end = period_times(motion, period)
    origin = contact_place(motion, np.array([start]))[0]
    share = np.linspace(0.0, 1.0, CURVE_POINTS)
    rows = []
    for part in stretches(motion, start, end):
        first, last = part.edges
        # The shared end of two pieces of one stretch is kept once.
        t = np.unique((first[:, None] + (last - first)[:, None] * share).ravel())
        rows.append((t, part.velocity(t), part.position(t) - origin, part.friction(t), np.full(len(t), part.side)))
    return FrictionCurve(*(np.concatenate(columns) for columns in zip(*rows, strict=True)))


def _widest_excursion(
    motion: Trajectory, parts: list[Stretch], start: float, end: float, side: int
) -> Excursion | None:
    """The slide to a side that comes to rest in the window and reaches the greatest speed.

    Where none does (the contact slides one way all the time) it is what the window shows of it.
    """
    phases = motion.phases[:-1]  # the last is cut off by the end of the run
    whole = [Stretch(motion, p.start, p.end, p.side) for p in phases if p.side == side and start < p.end <= end]
    slides = [Excursion(stretch) for stretch in whole or parts if stretch.side == side and len(stretch.pieces)]
    return max(slides, key=lambda slide: slide.speeds[1], default=None)


def _point(stretch: Stretch, t: float, origin: float) -> LoopPoint:
    at = np.array([t])
    velocity, rate = float(stretch.velocity(at)[0]), float(stretch.acceleration(at)[0])
    position, friction = float(stretch.position(at)[0]), float(stretch.friction(at)[0])
    side = stretch.side or 1
    return LoopPoint(float(t), velocity, position - origin, friction, side * rate > 0.0)


def _escape(slide: Excursion, origin: float, least: float) -> LoopPoint | None:
    stretch = slide.stretch
    if stretch.motion.system.friction.kind == "set-valued":
        return dataclasses.replace(_point(stretch, stretch.start, origin), accelerating=True)
    for point in _offset_points(stretch, origin, least):
        before = float(stretch.friction_rate(np.array([0.5 * (stretch.start + point.time)]))[0])
        if point.accelerating:
            return point if stretch.side * before > 0.0 else None
    return None


def _offset_points(stretch: Stretch, origin: float, least: float) -> tuple[LoopPoint, ...]:
    times = stretch.roots(stretch.friction_rate)
    if not len(times):
        return ()
    heights = stretch.friction(np.concatenate(([stretch.start], times, [stretch.end])))
    apart = np.abs(np.diff(heights)) > least  # flat stretches have extrema by rounding
    steep = STEEP * float(np.max(np.abs(stretch.acceleration(stretch.nodes().time))))
    turning = np.abs(stretch.acceleration(times)) <= steep
    return tuple(_point(stretch, float(t), origin) for t in times[apart[1:] & apart[:-1] & ~turning])


def _peak(parts: list[Stretch], origin: float) -> LoopPoint:
    points = []
    for part in parts:
        times = np.concatenate(([part.start], part.roots(part.friction_rate), [part.end]))
        best = times[np.argmax(np.abs(part.friction(times)))]
        points.append(_point(part, float(best), origin))
    return max(points, key=lambda point: abs(point.friction))


def _default_boundary(motion: Trajectory, excursions: dict, escapes: dict) -> float:
    if motion.system.friction.kind == "set-valued":
        return 0.0
    speeds = [abs(point.velocity) for point in escapes.values() if point is not None]
    if speeds:
        return max(speeds)
    return max((slide.speeds[1] for slide in excursions.values() if slide is not None), default=0.0)


def _areas(parts: list[Stretch], boundary: float) -> tuple[dict[tuple[int, bool], float], float]:
    """(oint R dv by (side, whether presliding), oint R dx) over the stretches of a window."""
    areas = {(side, slow): 0.0 for side in (FORWARD, BACK) for slow in (True, False)}
    lost = 0.0
    for part in parts:
        if part.side == STUCK:
            continue
        cuts = part.roots(lambda t, part=part: part.side * part.velocity(t) - boundary)
        nodes = part.nodes(cuts)
        lost += float(np.sum(nodes.weight * nodes.friction * nodes.velocity))
        slow = part.side * nodes.velocity < boundary
        turning = nodes.weight * nodes.friction * nodes.acceleration
        areas[part.side, True] += float(np.sum(turning[slow]))
        areas[part.side, False] += float(np.sum(turning[~slow]))
    return areas, lost
