"""What vanishes along a branch: the mismatch of an orbit's start and its image, with a parameter among the unknowns."""

import dataclasses
import functools
from collections.abc import Callable, Hashable, Sequence
from typing import Any

import numpy as np

from vibrocap.measures.gathered import Gathered
from vibrocap.measures.recorded.sticking import joined
from vibrocap.motion.recording.equations import equations, turning_states
from vibrocap.motion.recording.section import whole_turns, winding
from vibrocap.motion.simulate import simulate, within_room
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.api import Budget, RunResults, codes
from vibrocap.orbits.maps.grazing import grazing_beyond
from vibrocap.orbits.maps.stroboscopic_map import (
    BACKWARDS,
    MOST_EVENTS,
    MOST_STEPS,
    ORDER,
    StroboscopicMap,
    named_states,
)
from vibrocap.orbits.maps.variations import variational_equations
from vibrocap.orbits.walk.kinds import BranchEnd, ModeChange, SpecialKind, closed_sequence, same_cycle
from vibrocap.orbits.walk.residual import BranchPoint, Closing, Residual
from vibrocap.orbits.walk.segment import Segment
from vibrocap.orbits.walk.special_points import Found, special_points_of_maps
from vibrocap.physics.events import BOUNDS, IMPACT, LIFT_OFF
from vibrocap.physics.system import System

NO_STOPS = -1.0
FINER_NUDGE = 1e-2  # times the nudge, where what it gives differs to both sides; below it rounding shows
APART = 0.1  # of their sum, by which the slopes to both sides differ where something changes between them


@dataclasses.dataclass(frozen=True, eq=False)
class OrbitClosing(Closing):
    """A closing of a motion: the mismatch of its start and its image after the response.

    mode_sequence: phases of all contacts over the whole response; drift: what the cyclic coordinate gains over it
    winding: whole turns of each coordinate that turns
    image: whole state vector at the end, which carries what the law has switched
    impacts: on stops over the response of the map; infinite where they accumulate, NO_STOPS where there are none
    lifts_off: whether the run, or one beside it, ended as a contact lost its load; judge: makes `certified`
    """

    drift: float = 0.0
    image: np.ndarray = dataclasses.field(kw_only=True)
    winding: tuple[int, ...] = dataclasses.field(default=(), kw_only=True)
    impacts: float = dataclasses.field(default=NO_STOPS, kw_only=True)
    judge: Callable[[], np.ndarray] | None = dataclasses.field(default=None, kw_only=True)
    lifts_off: bool = dataclasses.field(default=False, kw_only=True)

    @functools.cached_property
    def certified(self) -> bool:
        """Whether the evidence of its response is within the bounds of a certificate, see `motion.evidence`."""
        return self.judge is None or bool(self.judge().all())

    @property
    def itinerary(self) -> Hashable:
        return super().itinerary, self.impacts

    def change_to(self, other: Closing) -> tuple[SpecialKind, ModeChange | None, str]:
        assert isinstance(other, OrbitClosing)
        impacts = "" if self.impacts == other.impacts else f"impacts {self.impacts:g} -> {other.impacts:g}"
        if impacts and same_cycle(self.mode_sequence, other.mode_sequence):
            return SpecialKind.CHATTER if np.isinf(self.impacts + other.impacts) else SpecialKind.GRAZING, None, impacts
        kind, change, phases = super().change_to(other)
        return kind, change, "; ".join(filter(None, (phases, impacts)))

    @functools.cached_property
    def boundary(self) -> BranchEnd | None:
        return BranchEnd.LIFT_OFF if self.lifts_off else None


class ClosingMap(Residual):
    """P^n (or, with `half`, S P_(nT/2)) of one form of system, as a function of the start and of one parameter.

    All states but the cyclic one and what the law switches are unknowns. A contact that sticks at the section needs no
    other set of them: its velocity is 0 in the image and nothing depends on it, so that its equation is v = 0 itself.
    Thus a branch continues where its section passes from sticking to sliding.

    The derivative by the start is exact (tangents through events); that by the parameter is a difference of two runs
    that share the lanes of the tangents (one-sided beside a change of modes): it turns the tangent of a branch,
    never what closes.
    """

    nudge = 1e-6  # share of the parameter's range by which the derivative by the parameter is taken

    def __init__(
        self,
        system: System,
        path: str,
        between: tuple[float, float],
        response_period: int = 1,
        half: bool = False,
        tolerance: float = 1e-12,
        mirrored: bool | None = None,
        plain: bool = False,
    ):
        """between: range of the parameter; mirrored: whether the half-period symmetry holds there; plain: uncompiled"""
        self.mirrored = system.mirrored if mirrored is None else mirrored
        self.system, self.path, self.between = system, path, between
        self.response_period, self.half, self.tolerance = response_period, half, tolerance
        self.map = StroboscopicMap(recorded_with(system, path), tolerance, 1, plain)
        self.index = self.map.equations.parameter_paths.index(path)
        self.row = self.map.parameters()
        self.row[self.index] = system.parameter(path)
        self.sizes = self.map.scales(self.row)  # the same along the whole branch
        names = system.state_names
        self.unknowns = self.map.smooth_states
        self.resting = np.isin(self.unknowns, self.map.resting)
        self.switched = np.array([i for i, name in enumerate(names) if name in system.switched], dtype=int)
        self.mirror = self.map.mirror if half else np.ones(len(names))
        turning = {place: period for place, period in turning_states(system) if place in self.unknowns}
        self.turns = np.array([turning.get(i, np.inf) for i in self.unknowns.tolist()]) / self.sizes[self.unknowns]

    def point(self, state: np.ndarray, parameter: float, period: float | None = None) -> np.ndarray:
        """x of a whole state vector and a value of the parameter; the period is that of the drive."""
        return np.append(state[self.unknowns] / self.sizes[self.unknowns], self.share(parameter))

    def state(self, x: np.ndarray, like: OrbitClosing | None = None) -> np.ndarray:
        """The whole state vector of x: position zero, switched states as they came."""
        state = np.zeros(self.map.states)
        state[self.unknowns] = x[:-1] * self.sizes[self.unknowns]
        if like is not None:
            state[self.switched] = like.image[self.switched]
        return state

    @property
    def symmetric(self) -> bool | None:
        """Whether the orbits are their own mirror images; None where nothing is."""
        return self.half if self.mirrored else None

    def period(self, x: np.ndarray) -> float:
        return self.response_period * self.map.period(self.row_at(x))

    def place(self, point: BranchPoint) -> tuple[np.ndarray, float, float]:
        """(state, parameter, period) of a point of a branch."""
        return self.state(point.x, point.closing), self.parameter(point.x), self.period(point.x)

    def row_at(self, x: np.ndarray) -> np.ndarray:
        row = self.row.copy()
        row[self.index] = self.parameter(x)
        return row

    def lengths(self, x: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Of runs from a point with parameters [runs, parameters], over what the map takes of the response."""
        return (0.5 if self.half else 1.0) * self.response_period * self.map.periods(rows)

    def drift(self, closing: OrbitClosing) -> float:
        """What the cyclic coordinate gains over a response; NaN where there is none."""
        return closing.drift if self.map.cyclic >= 0 else float("nan")

    def special_points(self, segment: Segment, left: float, right: float, at_parent: bool) -> list[Found]:
        return special_points_of_maps(segment, left, right, at_parent)

    def described(self, record: Found) -> dict[str, Any]:
        point, drift = record.point, self.drift(record.point.closing)
        state = named_states(self.system, self.state(point.x, point.closing))
        numbers = {"drift": None if np.isnan(drift) else drift, "frequency": record.frequency or None}
        return {"state": state, "multipliers": point.multipliers(self.half), **numbers}

    def motion(self, closing: Any) -> Trajectory:
        """The motion from a point, over the response of the map, or a cycle; of a guess beyond a stop from the stop."""
        system = self.system.with_parameters({self.path: self.parameter(closing.x)})
        start = within_room(system, named_states(system, self.state(closing.x, closing)))
        periods = self.response_period * (0.5 if self.half else 1.0) or self.period(closing.x) / system.drive.period
        return simulate(system, periods=periods, initial=start, tolerance=self.tolerance)

    def differ(self, one: Closing, other: Closing) -> bool:
        """Whether other events happen along two driven motions, at any contact: words are those of one."""
        if super().differ(one, other) or self.response_period == 0:
            return super().differ(one, other)
        kinds = ([(event.kind, event.contact) for event in self.motion(closing).events] for closing in (one, other))
        return next(kinds) != next(kinds)

    def ending(self, points: list[BranchPoint], end: BranchEnd) -> tuple[BranchEnd, Found | None]:
        """A branch that ends where its motion grazes a stop says so."""
        last, grazed = points[-1], None
        if len(points) >= 3 and last.closing.impacts != NO_STOPS:
            at = [self.parameter(point.x) for point in points[-3:]]
            motions = [self.motion(point.closing) for point in points[-3:]]
            grazed = grazing_beyond(motions, at, self.width)
        if grazed is None:
            return end, None
        place, error = grazed
        text = "with a square root: the branch ends here"
        return BranchEnd.GRAZING, Found.at_end(SpecialKind.GRAZING, 1.0, last, error, text, place)

    def with_section(self, state: np.ndarray, parameter: float) -> "ClosingMap":
        """The same where orbits pass the section at a state: that of the drive's period is the same everywhere."""
        return self

    def coarser(self) -> "ClosingMap | None":
        if self.half:
            return None
        if self.response_period % 2 == 0:
            return self._with(self.response_period // 2, False)
        return self._with(self.response_period, True) if self.mirrored else None

    def finer(self) -> "ClosingMap":
        return self._with(self.response_period, False) if self.half else self._with(2 * self.response_period, False)

    def _with(self, response_period: int, half: bool) -> "ClosingMap":
        options = self.tolerance, self.mirrored, self.map.plain
        return ClosingMap(self.system, self.path, self.between, response_period, half, *options)

    def tangents_and_neighbours(self, x: np.ndarray, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(parameters, starts) of m + 2 runs: with the tangent along each unknown, and two beside in the parameter."""
        m, n = len(self.unknowns), self.map.states
        rows = np.tile(self.row_at(x), (m + 2, 1))
        rows[m:, self.index] += self.nudge * self.width * np.array((1.0, -1.0))
        start = np.zeros((m + 2, 2 * n))
        start[:, :n] = state
        free = self.map.free(state[None], rows[:1])[0]
        start[np.arange(m), n + self.unknowns] = (self.sizes * free)[self.unknowns]
        return rows, start

    def attempt(self, x: np.ndarray, like: OrbitClosing | None = None) -> OrbitClosing:
        map_, m, n = self.map, len(self.unknowns), self.map.states
        state = self.state(x, like)
        rows, start = self.tangents_and_neighbours(x, state)
        lengths = self.lengths(x, rows)
        budget = Budget(1, self.tolerance, MOST_EVENTS, MOST_STEPS, asked=codes.ASK_MODES, evidence=1)
        recording = variational_equations(map_.equations)
        ended = map_.run(budget, start, rows, recording=recording, order=ORDER, mark_distance=lengths)
        ends = ended.state
        if self.system.machine.imposes_distances:
            whole = np.zeros((1, n, n))
            whole[0][:, self.unknowns] = ends[:m, n:].T / self.sizes[self.unknowns]
            map_.through_joint_turns(whole, state[None], rows[:1], budget, lengths[:1])
            ends[:m, n:] = (whole[0][:, self.unknowns] * self.sizes[self.unknowns]).T
        ends = ends * np.tile(self.mirror, 2)
        sizes = self.sizes[self.unknowns]
        images, alike = self._seen(ended[[0, m, m + 1]], rows[0])
        near = None if like is None else like.slope[:m]
        slope, apart = nudged_slope(images, alike, self.nudge, near)
        if apart:  # as near a grazing motion, where a nudge leads too far
            beside = rows[0] + FINER_NUDGE * (rows[m:] - rows[0])
            again = map_.run(budget, start[m:], beside, recording=recording, order=ORDER, mark_distance=lengths[m:])
            if np.all(again.finished):
                finer, happens = self._seen(again, rows[0])
                slope, _ = nudged_slope([images[0], *finer], [alike[0], *happens], self.nudge * FINER_NUDGE, near)
        turned = whole_turns(self.system, ends[0, :n] - state)
        jacobian = ends[:m, n + self.unknowns].T / sizes[:, None]
        possible = not map_.keeps_order or bool(np.all(self.mirror[self.unknowns] * jacobian >= BACKWARDS))
        return OrbitClosing(
            x=x,
            mismatch=images[0] - x[:m] - turned[self.unknowns] / sizes,
            jacobian=jacobian,
            slope=slope,
            at_rest=self.resting & (images[0] == 0.0),
            finished=bool(np.all(ended.finished)) and possible,
            mode_sequence=alike[0][0],
            drift=0.0 if self.half or map_.cyclic < 0 else float(ends[0, map_.cyclic]),
            image=ends[0, :n],
            winding=tuple(winding(self.system, np.zeros(n) if self.half else turned).values()),
            turns=np.append(self.turns, np.inf),
            impacts=alike[0][1],
            judge=functools.partial(map_.certified, ended[:1], rows[:1]),
            lifts_off=self.lifts_off(ended),
        )

    def _seen(self, ended: RunResults, row: np.ndarray) -> tuple[np.ndarray, list[tuple]]:
        """(images of runs [runs, unknowns] over natural sizes, what happens along each: words, impacts, sides)."""
        ends, count = ended.state[:, : self.map.states] * self.mirror, len(ended)
        stops = IMPACT in self.system.machine.switch_events
        gathered = Gathered(self.system, ended, np.ones(count), lambda: np.ones(count, dtype=bool), 0.0)
        impacts = gathered.impacts.tolist() if stops else [NO_STOPS] * count
        sides = np.atleast_2d(self.map.contact_side(ends.T, row)).T
        seen = zip(self._words(gathered), impacts, sides, ends[:, self.switched], strict=True)
        alike = [(word, struck, *side, *switched) for word, struck, side, switched in seen]
        return ends[:, self.unknowns] / self.sizes[self.unknowns], alike

    def lifts_off(self, ended: RunResults) -> bool:
        """Whether a run ended as a contact lost its load."""
        kinds = enumerate(self.map.equations.bound_kinds, codes.BEYOND_BOUND)
        return any(BOUNDS[kind] == LIFT_OFF and bool(np.any(ended.status == code)) for code, kind in kinds)

    def _words(self, gathered: Gathered) -> list[str]:
        """The words of runs over the whole response, of all contacts; none of smooth laws, whose side is not seen."""
        words = []
        for k, law in enumerate(self.system.laws):
            sequences, smooth = gathered.mode_sequences(k), law.kind == "smooth"
            words.append(["" if smooth else closed_sequence(str(word), self.half) for word in sequences])
        return [joined(run) for run in zip(*words, strict=True)]


def nudged_slope(
    images: Sequence[np.ndarray] | np.ndarray, happens: Sequence[Hashable], nudge: float, like: np.ndarray | None = None
) -> tuple[np.ndarray, bool]:
    """(derivative of the image by the parameter, whether it differs to both sides though the same happens there).

    From the side on which the same happens as along the image itself. images, happens: its own, and those of a nudge
    up and down; like: of a neighbour, which tells the side where events do not: those of a motion that grazes
    """
    (image, above, below), (here, up, down) = images, happens
    onward, back = (above - image) / nudge, (image - below) / nudge
    apart = np.linalg.norm(onward - back) > APART * (np.linalg.norm(onward) + np.linalg.norm(back))
    nearer = like is not None and np.linalg.norm(onward - like) <= np.linalg.norm(back - like)
    slope = 0.5 * (onward + back)
    if up == here and (down != here or (apart and nearer)):
        slope = onward
    elif down == here and (up != here or (apart and like is not None)):
        slope = back
    return slope, bool(apart and up == down == here)


def recorded_with(system: System, path: str) -> System:
    """The system, or one whose equations hold the parameter as a number where its value decides their form."""
    value = float(system.parameter(path))
    if path in equations(system).parameter_paths and (value != 0.0 or system.cyclic == system.machine.cyclic):
        return system
    return system.with_parameters({path: value + 0.3819660112501051})
