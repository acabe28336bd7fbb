"""Brute-force bifurcation diagrams: a parameter swept up and down, each point begun where the last one ended."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np

from vibrocap.arguments import ArgumentError, check_whole
from vibrocap.motion.recording.section import brought_back, whole_turns
from vibrocap.motion.simulate import initial_state, simulate
from vibrocap.orbits.attractors.starts import spread_starts, visited_ranges
from vibrocap.orbits.closing.autonomous_orbit import Section, SectionAsked, checked_section, recurrence, returns_of
from vibrocap.orbits.closing.settling_runs import NEAR, ROUGH, SettlingRuns, iterates, settling_runs
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap, is_driven, named_states, state_vector
from vibrocap.orbits.parameter_range import checked_range, system_at
from vibrocap.physics.dimensions.conversion import Parameter, Parameters, Path
from vibrocap.physics.system import System
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.quantities.declared import AlongNames, ByName, Lengths, Numbers, Over
from vibrocap.ranges import values_between
from vibrocap.results import Result

DIRECTIONS = ("up", "down")
PUSH = 1e-3  # over natural sizes: what a motion is pushed by at each point, or it would sit on what became unstable
REPEATS = 1e-4  # of the extents of a motion: what returns so near has settled to a cycle
NOT_CERTIFIED, FAILED, NOT_SETTLED = -2, -1, 0


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class BifurcationDiagram(Result):
    """What runs do over a parameter; arrays [directions, starts, points, ...], points in rising order of the parameter.

    over: path of the parameter; values: [points]; directions: "up" and "down"
    states: [..., kept, states] at the section (the starts of drive periods; of a system that nothing drives in time its
        returns to a `Section`), the cyclic coordinate from zero at the first, one that turns within
        half a turn; of a settled motion those of one response, of others `kept` of them; NaN where there are no more
    response_period: drive periods, or returns to the section, after which the motion repeats (1 also of an equilibrium,
        whose state is then recorded); 0: not settled, -1: the run failed (then it begins anew at the next point), -2:
        not certified: what it settled to, or its last period, is no motion of the equations
    drift: gain of the cyclic coordinate per drive period over these states; NaN without one. Motions are settled to
        1e-6 of natural sizes, and that is how far the drift of a symmetric one is from zero
    """

    system: System
    over: Path
    values: Annotated[Parameters, Over("over", name="over")]
    directions: tuple[str, ...]
    states: Annotated[np.ndarray, AlongNames(-1, ("state_names",)), Over("direction", "start", "over", "mark")]
    response_period: Annotated[
        Numbers,
        Over(
            *("direction", "start", "over"),
            words="drive periods after which the motion repeats",
            flags={"not_certified": NOT_CERTIFIED, "failed": FAILED, "not_settled": NOT_SETTLED},
        ),
    ]
    drift: Annotated[Lengths, Over("direction", "start", "over", words="drift per drive period")]
    state_names: tuple[str, ...]

    @property
    def direction(self) -> Annotated[Numbers, Over("direction", name="direction", words="direction of the sweep")]:
        return np.array(self.directions, dtype=str)


@shows_progress("Running over the parameter")
def bifurcation_diagram(
    system: System,
    over: Path,
    between: tuple[Parameter, Parameter],
    points: int = 200,
    *,
    directions: Sequence[str] = DIRECTIONS,
    starts: int = 4,
    initial: ByName | None = None,
    settle_periods: int = 300,
    kept: int = 64,
    section: SectionAsked = None,
    threads: int | None = None,
    progress: Progress = None,
) -> BifurcationDiagram:
    """Stroboscopic states, drift and response period over a parameter, swept in both directions.

    At each value the runs continue from their ends at the one before, pushed by a thousandth of each natural size,
    so that they follow a branch until it ends or loses its stability: where both directions differ, motions coexist.

    over: path of a parameter, such as "drive.amplitude"; between: (low, high); points: values, evenly spaced
    starts: runs side by side in each direction, from starts spread as in `attractors` (the first from `initial`); more
        of them find more coexisting motions, and up to eight cost little more than one. With the half-period symmetry
        every other run is recorded by its mirror image, which is a motion too: otherwise all runs would follow the same
        of two mirror-image solutions
    settle_periods: most drive periods at a point; kept: states kept of a motion that does not settle
    section: of a system that nothing drives in time, where its returns are recorded, see `orbit`; by default the first
        kind of event that comes again and again: sticks, slips, reversals. Runs settle for `settle_periods` drive
        periods of any length, and are recorded over as many more
    progress: True for a bar, or a function that is called at each point with the share done

    A loss of stability with a multiplier close to one shows late, since runs leave the unstable motion slowly.
    Raises ValueError naming the argument.
    """
    start = np.array(list(initial_state(system, initial).values()))
    low, high = checked_range(system, over, between)
    check_whole("points", points, 2, 1_000_000)
    section = checked_section(system, section)
    driven = is_driven(system)
    if driven and section is not None:
        raise ArgumentError("section", "should be None: the drive counts the turns of this system")
    values = values_between(low, high, points)
    check_whole("starts", starts, 1, 100_000)
    check_whole("settle_periods", settle_periods, 10, 10**7)
    check_whole("kept", kept, 16, 10**6)
    known = all(direction in DIRECTIONS for direction in directions)
    if not directions or not known or len({*directions}) < len(directions):
        raise ArgumentError("directions", f"should be {' or '.join(map(repr, DIRECTIONS))} or both, got {directions!r}")
    systems = [system_at(system, over, value) for value in values]
    shape = (len(directions), starts, len(values))
    states = np.full((*shape, kept, len(system.state_names)), math.nan)
    response = np.full(shape, FAILED)
    drift = np.full(shape, math.nan)
    first = _first_states(systems, directions, start, starts, threads)
    ends = first.copy()
    for step in range(len(values)):
        places = [step if direction == "up" else len(values) - 1 - step for direction in directions]
        for at in set(places):
            row = [k for k, place in enumerate(places) if place == at]
            group = ends[row].reshape(-1, len(start))
            here = StroboscopicMap(systems[at], ROUGH, threads)
            begun = _nudged(here, group, step)
            imaged = np.tile(system.mirrored & (np.arange(starts) % 2 == 1), len(row)) if driven else None
            point = _Point(here, begun, settle_periods, kept, imaged, section)
            at_shape = (len(row), starts)
            response[row, :, at] = point.response.reshape(at_shape)
            states[row, :, at] = point.states.reshape(*at_shape, kept, -1)
            drift[row, :, at] = point.drift.reshape(at_shape)
            moved = point.ends.reshape(*at_shape, -1)
            ends[row] = np.where(np.isfinite(moved), moved, first[row])
        if (report := told(progress)) is not None:
            report((step + 1) / len(values))
    return BifurcationDiagram(system, over, values, tuple(directions), states, response, drift, system.state_names)


class _Point:
    """What runs do at one value: response [runs], states kept [runs, kept, states], drift [runs], ends [runs, states].

    imaged: [runs] which ones are recorded by their mirror images; None of a system that nothing drives in time, whose
        returns to a `Section` are recorded
    """

    def __init__(self, map_: StroboscopicMap, states: np.ndarray, periods: int, kept: int, imaged: Any, section: Any):
        self.map, self.periods, self.kept = map_, periods, kept
        runs = settling_runs(map_, states, periods)
        self.response = np.where(runs.finished, runs.response_period if imaged is not None else NOT_SETTLED, FAILED)
        self.states = np.full((len(states), kept, map_.states), math.nan)
        self.drift = np.full(len(states), math.nan)
        self.ends = np.where(runs.finished[:, None], runs.state, math.nan)
        if imaged is None:
            self._record_returns(runs, section)
        else:
            self.ends = np.where(runs.finished[:, None], brought_back(map_.system, runs.state), math.nan)
            self._record_iterates(runs, imaged)
        self.ends = np.where(np.isfinite(self.ends), brought_back(map_.system, self.ends), math.nan)
        self.response = np.where(np.all(np.isfinite(self.ends), axis=1), self.response, FAILED)
        self.response = np.where((self.response != FAILED) & ~runs.certified, NOT_CERTIFIED, self.response)

    def _record_iterates(self, runs: SettlingRuns, imaged: np.ndarray) -> None:
        map_, cyclic, begun = self.map, self.map.cyclic, self.ends
        for wandering in (False, True):
            members = np.flatnonzero(runs.finished & ((self.response == NOT_SETTLED) == wandering))
            if not len(members):
                continue
            count = self.kept if wandering else int(self.response[members].max())
            path = iterates(map_, begun[members], count)  # [count + 1, runs, states]
            last = path.copy()
            for k in np.flatnonzero(imaged[members]):
                path[:, k] = _mirrored(map_, path[:, k])
            for k, run in enumerate(members):
                n = count if wandering else _shortest(map_, path[:, k], int(self.response[run]))
                self.response[run] = NOT_SETTLED if wandering else n
                self.states[run, :n] = path[:n, k] - whole_turns(map_.system, path[:n, k])
                self.ends[run] = last[n, k]
                if cyclic >= 0:
                    self.drift[run] = (path[n, k, cyclic] - path[0, k, cyclic]) / n

    def _record_returns(self, runs: SettlingRuns, section: Section | None) -> None:
        map_, system, cyclic = self.map, self.map.system, self.map.cyclic
        period = map_.period(map_.parameters())
        for run in np.flatnonzero(runs.finished):
            start = named_states(system, brought_back(system, runs.state[run]))
            motion = simulate(system, periods=self.periods, initial=start, tolerance=ROUGH)
            if not motion.run_status.ok:
                self.response[run] = FAILED
                continue
            self.ends[run] = state_vector(system, motion.state)
            times = next(returns_of(motion, section), np.empty(0))[-self.kept - 1 :]
            if len(times) < 2:
                if runs.response_period[run] > 0:  # at rest, or sliding steadily
                    self.response[run], self.states[run, 0] = 1, self.ends[run]
                continue
            count, away = recurrence(motion, times, len(times) - 1)
            self.response[run] = count if away <= REPEATS else NOT_SETTLED
            times = times[-(count if away <= REPEATS else len(times) - 1) - 1 :]
            path = motion.states(times).T
            self.states[run, : len(times) - 1] = path[:-1] - whole_turns(system, path[:-1])
            if cyclic >= 0:
                self.states[run, :, cyclic] -= self.states[run, 0, cyclic]
                self.drift[run] = (path[-1, cyclic] - path[0, cyclic]) * period / (times[-1] - times[0])


def _mirrored(map_: StroboscopicMap, path: np.ndarray) -> np.ndarray:
    """Mirror images of the iterates of a run [periods, states], half a period later; NaN where the run had failed."""
    whole = np.all(np.isfinite(path), axis=1)
    image = np.full_like(path, math.nan)
    images = map_.mirrored_half(path[whole], map_.parameters(), tangents=False)
    image[whole] = np.where(images.finished[:, None], images.state, math.nan)
    if map_.cyclic >= 0:
        image[:, map_.cyclic] -= image[0, map_.cyclic]
    return image


def _nudged(map_: StroboscopicMap, states: np.ndarray, step: int) -> np.ndarray:
    """States pushed a little, in every free direction and in another way at each point."""
    parameters = map_.parameters()
    push = np.random.default_rng(step).uniform(-1.0, 1.0, states.shape)
    push[1::2] = push[: len(push) // 2 * 2 : 2]  # a run and one that is recorded by its mirror image go the same way
    moved = states + push * map_.scales(parameters) * PUSH * map_.free(states, parameters[None])
    return moved if step else states


def _shortest(map_: StroboscopicMap, path: np.ndarray, periods: int) -> int:
    """The response period of a settled run from its iterates: one that alternates as it settles looks twice as long."""
    sized = map_.section(path)
    for n in range(1, periods):
        if periods % n == 0 and np.max(np.abs(sized[n : periods + 1] - sized[: periods + 1 - n])) <= NEAR:
            return n
    return periods


def _first_states(
    systems: Sequence[System], directions: Sequence[str], start: np.ndarray, starts: int, threads: int | None
) -> np.ndarray:
    """Where the runs of each direction begin: [directions, starts, states]."""
    states = np.tile(start, (len(directions), starts, 1))
    if starts > 1:
        for k, direction in enumerate(directions):
            map_ = StroboscopicMap(systems[0 if direction == "up" else -1], ROUGH, threads)
            states[k, 1:] = spread_starts(map_, start, visited_ranges(map_, start), starts - 1)
    return states
