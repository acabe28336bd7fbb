"""Hysteresis: the loop of friction against velocity and against displacement over one period."""

import dataclasses
import functools
import itertools
from typing import Annotated

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.measures.recorded.sticking import law_of
from vibrocap.measures.recorded.stretch import Stretch, bisected, contact_place, stretches
from vibrocap.measures.recorded.windows import period_times
from vibrocap.motion.trajectory import BACK, FORWARD, STUCK, Trajectory
from vibrocap.quantities.declared import Force, Forces, In, Length, Lengths, Numbers, Speed, Speeds, Time, Times, Work
from vibrocap.quantities.dimensional import Dimensional

SPEEDS = 256  # at which the branches are compared
LoopArea = Annotated[float, In("N m/s")]  # oint R dv
MINORITY = 0.05  # of the integral of |difference|: with more than this of either sign the branches are mixed


@dataclasses.dataclass(frozen=True)
class Branches(Dimensional):
    """Accelerating against decelerating friction in one direction and one regime.

    The difference is side (R_accelerating - R_decelerating) at equal speed: positive where friction is larger in
    magnitude on the way up, the paper's clockwise loop.

    direction: "accelerating above", "decelerating above", "mixed" (neither has 95 % of it) or "coincide"
    area: oint R dv over that part of the loop, the integral of the difference over speed; positive clockwise
    mean_difference: area over the range of speeds
    largest_difference: the difference of greatest magnitude, with its sign; None where no speed is passed both ways
    speeds: the range of speeds compared
    """

    direction: str
    area: LoopArea
    mean_difference: Force
    largest_difference: Force | None
    speeds: tuple[Speed, Speed]


@dataclasses.dataclass(frozen=True)
class Excursion:
    """A slide from rest to rest, cut into its monotone ways up and down."""

    stretch: Stretch

    @functools.cached_property
    def ways(self) -> list[tuple[float, float, bool]]:
        """(start, end, accelerating) of each monotone way."""
        turns = self.stretch.roots(self.stretch.acceleration)
        marks = np.concatenate(([self.stretch.start], turns, [self.stretch.end]))
        speeds = self.stretch.side * self.stretch.velocity(marks)
        return [
            (float(marks[i]), float(marks[i + 1]), bool(speeds[i + 1] > speeds[i]))
            for i in range(len(marks) - 1)
            if marks[i + 1] > marks[i]
        ]

    @functools.cached_property
    def speeds(self) -> tuple[float, float]:
        marks = np.array([self.ways[0][0], *(end for _, end, _ in self.ways)])
        speeds = self.stretch.side * self.stretch.velocity(marks)
        return max(0.0, float(speeds.min())), float(speeds.max())

    def branch(self, speeds: np.ndarray, accelerating: bool) -> np.ndarray:
        """side R at the given speeds, the mean over the ways up (or down) that pass it; NaN where none does."""
        side, stretch = self.stretch.side, self.stretch
        total, passes = np.zeros_like(speeds), np.zeros_like(speeds)
        for start, end, up in self.ways:
            if up != accelerating:
                continue
            ends = side * stretch.velocity(np.array([start, end]))
            inside = (speeds >= ends.min()) & (speeds <= ends.max())
            wanted = speeds[inside]
            low, high = np.full(len(wanted), start), np.full(len(wanted), end)
            times = bisected(low, high, lambda t, wanted=wanted: (side * stretch.velocity(t) < wanted) == accelerating)
            total[inside] += side * stretch.friction(times)
            passes[inside] += 1.0
        return np.divide(total, passes, out=np.full_like(speeds, np.nan), where=passes > 0)

    def difference(self, speeds: np.ndarray) -> np.ndarray:
        """Accelerating less decelerating friction (times side) at equal speed; NaN where either is missing."""
        return self.branch(speeds, True) - self.branch(speeds, False)

    def crossings(self, least: float) -> tuple[float, ...]:
        """Speeds at which the branches change places, where they do so by more than a least difference."""
        from scipy.optimize import brentq

        def known_difference(speed: float) -> float:
            return float(np.nan_to_num(self.difference(np.array([speed]))[0]))

        low, high = self.speeds
        # Denser towards rest, where a branch may change steeply.
        grid = low + (high - low) * np.linspace(0.0, 1.0, SPEEDS + 2)[1:-1] ** 2
        difference = self.difference(grid)
        known = np.flatnonzero(np.abs(difference) > least)
        crossings = []
        for i, j in itertools.pairwise(known):
            if difference[i] * difference[j] < 0.0:
                speed, _ = brentq(known_difference, grid[i], grid[j], xtol=1e-14, full_output=True)
                # Where a way begins or ends the mean over ways jumps or is missing, which is no crossing.
                if abs(self.difference(np.array([speed]))[0]) <= 1e-6 * (abs(difference[i]) + abs(difference[j])):
                    crossings.append(float(speed))
        return tuple(crossings)


def branches(excursion: Excursion, area: float, low: float, high: float, least: float) -> Branches | None:
    """Compare both branches of an excursion at speeds from low to high; None where it does not come there.

    area: the part of oint R dv that belongs to it; least: mean difference that counts as none
    """
    slowest, fastest = excursion.speeds
    low, high = max(low, slowest), min(high, fastest)
    if not high > low:
        return None
    centres = low + (high - low) * (np.arange(SPEEDS) + 0.5) / SPEEDS
    difference = excursion.difference(centres)
    difference = difference[np.isfinite(difference)]
    mean = area / (high - low)
    largest = float(difference[np.argmax(np.abs(difference))]) if len(difference) else None
    total = float(np.abs(difference).sum())
    minority = min(float(difference[difference > 0].sum()), float(-difference[difference < 0].sum()))
    if largest is None or abs(largest) <= least:
        direction = "coincide"
    elif minority > MINORITY * total:
        direction = "mixed"
    else:
        direction = "accelerating above" if difference.sum() > 0.0 else "decelerating above"
    return Branches(direction, area, mean, largest, (low, high))


# Friction differences below this share of the peak, or below so many tolerances of the run, count as none.
NO_DIFFERENCE = 1e-9
NO_DIFFERENCE_TOLERANCES = 100.0
STEEP = 1e-6  # of the greatest acceleration: below it a point is a turning point of the velocity, not an offset point
CURVE_POINTS = 8  # per piece


@dataclasses.dataclass(frozen=True)
class LoopPoint(Dimensional):
    """A point of the loop; displacement counts from the window's start, accelerating means that |v| grows."""

    time: Time
    velocity: Speed
    displacement: Length
    friction: Force
    accelerating: bool


@dataclasses.dataclass(frozen=True)
class LoopSide(Dimensional):
    """The loop on one side, of which points and branches are those of the widest slide of the period.

    excursion: (start, end) of that slide, the one of greatest speed; it may begin before the period
    escape: M1 of the paper's Fig. 8, where the capsule escapes from presliding and enters pure sliding: here the first
        local maximum of |R| along the slide while it accelerates, from which on bristles slip more than they stretch.
        With a set-valued law, the point where it leaves rest. None where friction rises up to the turning point
    offset_points: all points of the slide with dR/dv = 0, M1 included
    crossings: speeds at which the accelerating and the decelerating branch change places; slow sliding has v* there
    presliding, pure_sliding: the branches below and above the boundary speed; None where the slide does not come there
    """

    excursion: tuple[Time, Time]
    escape: LoopPoint | None
    offset_points: tuple[LoopPoint, ...]
    crossings: tuple[Speed, ...]
    presliding: Branches | None
    pure_sliding: Branches | None


@dataclasses.dataclass(frozen=True)
class FrictionLoop(Dimensional):
    """Friction over one period.

    boundary: speed that parts presliding (below) from pure sliding (above)
    velocity_area: oint R dv, positive if clockwise: friction larger while accelerating
    displacement_area: oint R dx, the work done against friction, all that the contact lost or stored
    peak: where |R| is largest; peak_force: that |R|
    """

    window: tuple[Time, Time]
    boundary: Speed
    velocity_area: LoopArea
    displacement_area: Work
    peak_force: Force
    peak: LoopPoint
    forward: LoopSide | None
    back: LoopSide | None


@dataclasses.dataclass(frozen=True)
class FrictionCurve(Dimensional):
    """Points along one period, several on every piece and both its ends, so that jumps stand upright. All [points]."""

    time: Times
    velocity: Speeds
    displacement: Lengths
    friction: Forces
    side: Numbers


def friction_loop(
    motion: Trajectory, period: int = -1, *, boundary: Speed | None = None, contact: int = 1
) -> FrictionLoop:
    """The friction loop of a contact over one whole period, the last unless named.

    Friction with memory has different branches for rising and falling velocity. Areas are Gauss sums over the pieces of
    the motion, cut where |v| passes the boundary, exact to rounding for the motion as computed: oint R dx is the energy
    lost and stored in the contact.

    boundary: speed between presliding and pure sliding. By default that of M1 (`LoopSide.escape`), the greater of both
        directions; where no direction escapes, the greatest speed; 0 for a law that only sticks or slides.

    The paper finds a clockwise loop in pure sliding; at its printed delta1 the loop runs anticlockwise above
    v* (`limits.boundary_velocity`, erratum 7). Raises ValueError where the motion has no such period or contact, or for
    a boundary that is not a number >= 0.
    """
    start, end = period_times(motion, period)
    if boundary is not None and not 0.0 <= boundary < np.inf:
        raise ArgumentError("boundary", f"should be a speed >= 0, got {boundary!r}")
    law = law_of(motion, contact)
    parts = stretches(motion, start, end, contact)
    origin = float(contact_place(motion, contact, np.array([start]))[0])
    peak = _peak(parts, origin)
    least = max(NO_DIFFERENCE, NO_DIFFERENCE_TOLERANCES * motion.tolerance) * abs(peak.friction)
    excursions = {side: _widest_excursion(parts, start, end, side) for side in (FORWARD, BACK)}
    escapes = {side: _escape(slide, origin, least) for side, slide in excursions.items() if slide is not None}
    if boundary is None:
        boundary = 0.0 if law.kind == "set-valued" else _default_boundary(excursions, escapes)
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


def friction_curve(motion: Trajectory, period: int = -1, contact: int = 1) -> FrictionCurve:
    """Friction, velocity and displacement of a contact along one whole period, for drawing its loops."""
    start, end = period_times(motion, period)
    origin = contact_place(motion, contact, np.array([start]))[0]
    share = np.linspace(0.0, 1.0, CURVE_POINTS)
    rows = []
    for part in stretches(motion, start, end, contact):
        first, last = part.edges
        # The shared end of two pieces of one stretch is kept once.
        t = np.unique((first[:, None] + (last - first)[:, None] * share).ravel())
        rows.append((t, part.velocity(t), part.position(t) - origin, part.friction(t), np.full(len(t), part.side)))
    return FrictionCurve(*(np.concatenate(columns) for columns in zip(*rows, strict=True)))


def _widest_excursion(parts: list[Stretch], start: float, end: float, side: int) -> Excursion | None:
    """The slide to a side that comes to rest in the window and reaches the greatest speed.

    Where none does (the contact slides one way all the time) it is what the window shows of it.
    """
    motion, contact = parts[0].motion, parts[0].contact
    phases = [p for p in motion.phases_of(contact)[:-1] if p.side == side]  # the last is cut off by the end of the run
    whole = [Stretch(motion, contact, p.start, p.end, side) for p in phases if start < p.end <= end]
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
    if law_of(stretch.motion, stretch.contact).kind == "set-valued":
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


def _default_boundary(excursions: dict, escapes: dict) -> float:
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
