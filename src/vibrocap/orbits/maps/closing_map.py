"""What vanishes along a branch: the mismatch of an orbit's start and its image, with a parameter among the unknowns."""

import dataclasses
from typing import Protocol

import numpy as np

from vibrocap.measures.gathered import Gathered
from vibrocap.motion.recording.equations import equations, turning_states
from vibrocap.motion.recording.section import whole_turns, winding
from vibrocap.numerics.api import Budget, RunResults, codes
from vibrocap.orbits.maps.differences import BACKWARDS, keeps_order
from vibrocap.orbits.maps.itinerary import closed_sequence, same_cycle
from vibrocap.orbits.maps.stroboscopic_map import MOST_EVENTS, MOST_STEPS, ORDER, StroboscopicMap
from vibrocap.orbits.maps.variations import variational_equations
from vibrocap.physics.events import BOUNDS, IMPACT, LIFT_OFF
from vibrocap.physics.system import System

NO_STOPS = -1.0
APART = 0.1  # of their sum, by which the slopes to both sides differ where something changes between them
NUDGE = 1e-6  # share of the parameter's range by which the derivative by the parameter is taken


@dataclasses.dataclass(frozen=True, eq=False)
class Closing:
    """What the map makes of a point x = (states over their natural sizes, share q of the parameter's range).

    mismatch: [m] image less start; jacobian: [m, m] of the image by the start; slope: [m] of the image by q
    at_rest: [m] whether the image is exactly zero for good: the velocity of a contact that sticks at the section
    mode_sequence: phases over the whole response; drift: what the cyclic coordinate gains over it; winding: whole
        turns of each coordinate that turns
    turns: length of a whole turn along each unknown, infinite where it does not turn; None: none of them does
    image: whole state vector at the end, which carries what the law has switched
    impacts: on stops over the response of the map; infinite where they accumulate, NO_STOPS where there are none
    lifts_off: whether the run, or one beside it, ended as a contact lost its load
    certified: whether the evidence of its response is within the bounds of a certificate, see `motion.run_evidence`
    """

    x: np.ndarray
    mismatch: np.ndarray
    jacobian: np.ndarray
    slope: np.ndarray
    at_rest: np.ndarray
    finished: bool
    mode_sequence: str
    drift: float
    image: np.ndarray
    winding: tuple[int, ...] = dataclasses.field(default=(), kw_only=True)
    turns: np.ndarray | None = dataclasses.field(default=None, kw_only=True)
    impacts: float = dataclasses.field(default=NO_STOPS, kw_only=True)
    certified: bool = dataclasses.field(default=True, kw_only=True)
    lifts_off: bool = dataclasses.field(default=False, kw_only=True)

    def alike(self, other: "Closing") -> bool:
        """Whether the same happens in both: the same cycle of phases, and as many impacts."""
        return same_cycle(self.mode_sequence, other.mode_sequence) and self.impacts == other.impacts

    def away(self, x: np.ndarray) -> np.ndarray:
        """Points [..., m + 1] less this one, modulo whole turns."""
        gained = x - self.x
        if self.turns is None:
            return gained
        turning = np.isfinite(self.turns)
        gained[..., turning] -= self.turns[turning] * np.round(gained[..., turning] / self.turns[turning])
        return gained

    @property
    def residual(self) -> float:
        """Largest mismatch; infinite where the run did not finish."""
        largest = float(np.max(np.abs(self.mismatch)))
        return largest if self.finished and np.isfinite(largest) else np.inf

    @property
    def derivative(self) -> np.ndarray:
        """Of the mismatch by x, [m, m + 1]."""
        return np.column_stack((self.jacobian - np.eye(len(self.mismatch)), self.slope))


class Closure(Protocol):
    """What can be followed: implement `attempt`, and branches, their special points and their switching work.

    half: whether the map is S P_(T/2), whose multipliers are the roots of those of the orbit
    """

    half: bool

    def attempt(self, x: np.ndarray, like: Closing | None = None) -> Closing:
        """The closing of a point; `like`: of a neighbour, whose switched states are taken over."""
        ...

    def parameter(self, x: np.ndarray) -> float:
        """The parameter's value at a point."""
        ...

    def coarser(self) -> "Closure | None":
        """The map of which this one is the square: its fixed points are where a branch of this one bifurcates."""
        ...

    def finer(self) -> "Closure":
        """The square of this map: what bifurcates at a multiplier -1 of this one closes under it."""
        ...


class ClosingMap:
    """P^n (or, with `half`, S P_(nT/2)) of one form of system, as a function of the start and of one parameter.

    All states but the cyclic one and what the law switches are unknowns. A contact that sticks at the section needs no
    other set of them: its velocity is 0 in the image, does not depend on anything, and nothing depends on it, so that
    its equation is v = 0 itself. Thus a branch continues where its section passes from sticking to sliding.

    The derivative by the start is exact (tangents through events); that by the parameter is a difference of two runs
    that share the lanes of the tangents (one-sided beside a change of modes): it turns the tangent of a branch,
    never what closes.
    """

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
        """between: range of the parameter; mirrored: whether the half-period symmetry holds all over it.

        plain: as plain Python, not compiled
        """
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
        self.switched = np.array([i for i, name in enumerate(names) if name in system.switched], dtype=int)
        self.mirror = self.map.mirror if half else np.ones(len(names))
        turning = {place: period for place, period in turning_states(system) if place in self.unknowns}
        self.turns = np.array([turning.get(i, np.inf) for i in self.unknowns.tolist()]) / self.sizes[self.unknowns]

    def parameter(self, x: np.ndarray) -> float:
        low, high = self.between
        return float(low + x[-1] * (high - low))

    def point(self, state: np.ndarray, parameter: float, period: float | None = None) -> np.ndarray:
        """x of a whole state vector and a value of the parameter; the period is that of the drive."""
        low, high = self.between
        return np.append(state[self.unknowns] / self.sizes[self.unknowns], (parameter - low) / (high - low))

    def state(self, x: np.ndarray, like: Closing | None = None) -> np.ndarray:
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
        """Length of the response at a point."""
        row = self.row.copy()
        row[self.index] = self.parameter(x)
        return self.response_period * self.map.period(row)

    def drift(self, closing: Closing) -> float:
        """What the cyclic coordinate gains over a response; NaN where there is none."""
        return closing.drift if self.map.cyclic >= 0 else float("nan")

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

    def tangents_and_neighbours(self, x: np.ndarray, state: np.ndarray, nudge: float) -> tuple[np.ndarray, np.ndarray]:
        """(parameters, starts) of m + 2 runs: with the tangent along each unknown, and two beside in the parameter."""
        m, n = len(self.unknowns), self.map.states
        rows = np.tile(self.row, (m + 2, 1))
        rows[:, self.index] = self.parameter(x)
        rows[m:, self.index] += (nudge, -nudge)
        start = np.zeros((m + 2, 2 * n))
        start[:, :n] = state
        free = self.map.free(state[None], rows[:1])[0]
        start[np.arange(m), n + self.unknowns] = (self.sizes * free)[self.unknowns]
        return rows, start

    def attempt(self, x: np.ndarray, like: Closing | None = None) -> Closing:
        map_, m, n = self.map, len(self.unknowns), self.map.states
        state = self.state(x, like)
        nudge = NUDGE * (self.between[1] - self.between[0])
        rows, start = self.tangents_and_neighbours(x, state, nudge)
        response = 0.5 * self.response_period if self.half else float(self.response_period)
        lengths = np.full(m + 2, response * map_.period(rows[0]))
        if self.path.startswith("drive."):
            lengths[m:] = [response * map_.period(row) for row in rows[m:]]
        budget = Budget(1, 1, 0.0, self.tolerance, MOST_EVENTS, MOST_STEPS, codes.ASK_MODES, evidence=1)
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
        image = ends[:, self.unknowns] / sizes
        at_rest = np.isin(self.unknowns, map_.resting) & (image[0] == 0.0)
        words, impacts = self._words(ended, [0, m, m + 1]), self.impacts_of(ended)
        alike = [f"{word} {impacts[run]}" for word, run in zip(words, (0, m, m + 1), strict=True)]
        turned = whole_turns(self.system, ends[0, :n] - state)
        jacobian = ends[:m, n + self.unknowns].T / sizes[:, None]
        possible = not keeps_order(map_) or bool(np.all(self.mirror[self.unknowns] * jacobian >= BACKWARDS))
        return Closing(
            x=x,
            mismatch=image[0] - x[:-1] - turned[self.unknowns] / sizes,
            jacobian=jacobian,
            slope=nudged_slope(image[0], image[m], image[m + 1], alike, like=None if like is None else like.slope),
            at_rest=at_rest,
            finished=bool(np.all(ended.finished)) and possible,
            mode_sequence=words[0],
            drift=0.0 if self.half or map_.cyclic < 0 else float(ends[0, map_.cyclic]),
            image=ends[0, :n],
            winding=tuple(winding(self.system, np.zeros(n) if self.half else turned).values()),
            turns=np.append(self.turns, np.inf),
            impacts=impacts[0],
            certified=bool(map_.certified(ended[:1], rows[:1])[0]),
            lifts_off=self.lifts_off(ended),
        )

    def lifts_off(self, ended: RunResults) -> bool:
        """Whether a run ended as a contact lost its load."""
        kinds = [BOUNDS[kind] for kind in self.map.equations.bound_kinds]
        bound = [codes.BEYOND_BOUND + i for i, kind in enumerate(kinds) if kind == LIFT_OFF]
        return bool(np.any(np.isin(ended.status, bound)))

    def impacts_of(self, ended: RunResults) -> list[float]:
        """Impacts of runs over the response of the map."""
        if IMPACT not in self.system.machine.switch_events:
            return [NO_STOPS] * len(ended)
        return self._gathered(ended).impacts.tolist()

    def _gathered(self, ended: RunResults) -> Gathered:
        ones = np.ones(len(ended))
        return Gathered(self.system, ended, ones, lambda: ones > 0.0, 0.0)

    def _words(self, ended: RunResults, runs: list[int]) -> list[str]:
        """The words of runs over the whole response; empty for a smooth law, whose changes of side are not seen."""
        if self.system.friction.kind == "smooth":
            return [""] * len(runs)
        gathered = self._gathered(ended[runs])
        return [closed_sequence(str(word), self.half) for word in gathered.mode_sequences]


def nudged_slope(
    image: np.ndarray,
    above: np.ndarray,
    below: np.ndarray,
    words: list[str],
    nudge: float = NUDGE,
    like: np.ndarray | None = None,
) -> np.ndarray:
    """Derivative of the image by the parameter, from the side on which the modes are those of the image itself.

    like: of a neighbour, which tells the side where words do not: those of a further contact, or a motion that grazes
    """
    here, up, down = words
    onward, back = (above - image) / nudge, (image - below) / nudge
    apart = np.linalg.norm(onward - back) > APART * (np.linalg.norm(onward) + np.linalg.norm(back))
    if up == here and (down != here or (apart and like is not None and _nearer(onward, back, like))):
        return onward
    if down == here and (up != here or (apart and like is not None)):
        return back
    return 0.5 * (onward + back)


def _nearer(one: np.ndarray, other: np.ndarray, like: np.ndarray) -> bool:
    """Whether a slope is nearer to a neighbour's than another is."""
    return bool(np.linalg.norm(one - like) <= np.linalg.norm(other - like))


def recorded_with(system: System, path: str) -> System:
    """The system, or one whose equations hold the parameter as a number where its value decides their form."""
    value = float(system.parameter(path))
    if path in equations(system).parameter_paths and (value != 0.0 or system.cyclic == system.machine.cyclic):
        return system
    return system.with_parameters({path: value + 0.3819660112501051})
