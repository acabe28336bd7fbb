"""Gradients of a steady motion: how its measures change with the parameters, exactly.

The orbit is a fixed point y = P(y, p) of the map over its response. So

    (I - P_y) dy/dp = P_p            dm/dp = m_y dy/dp + m_p

with P_y, P_p and the derivatives of a measure m by tangents: one lane for each state and for each parameter, carried
through the events by saltation (`orbits/maps/variations.py`). Works have their integrals along the tangent. Where an
instant itself moves with a parameter, the end of the period or a corner of the drive at t_c, the tangent takes on
(f- - f+) dt_c/dp, with the rates f before and after it.
"""

import dataclasses
from collections.abc import Iterable
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.measures.of_measure import MeasureInUnit, SlopeInUnit
from vibrocap.motion.recording.equations import equations
from vibrocap.motion.trajectory import Trajectory
from vibrocap.motion.trust import residue
from vibrocap.numerics.api import Budget, EnsembleStart, Form, ensemble_run
from vibrocap.numerics.expressions.graph import Expression, evaluate, evaluated, sensitivity
from vibrocap.orbits.closing.periodic_solution import PeriodicSolution
from vibrocap.orbits.maps.stroboscopic_map import (
    MOST_EVENTS,
    MOST_STEPS,
    ORDER,
    StroboscopicMap,
    is_driven,
    state_vector,
)
from vibrocap.orbits.maps.variations import carried, variational_equations, with_integrals
from vibrocap.orbits.parameter_range import repeats_at
from vibrocap.physics.dimensions.conversion import quantity, quantity_in_si
from vibrocap.physics.system import System
from vibrocap.quantities.declared import Number
from vibrocap.quantities.dimensional import Dimensional
from vibrocap.results import Result

TRAVEL = ("mean_velocity", "drift")
BESIDE = 1e-3  # of a value: how far away another one is
DEGENERATE = 1e-9  # least singular value of I - P_y, over natural sizes: below it the orbit is one of a continuum
ON_CORNER = 1e-8  # of the period, by which an event may be from a corner of the drive on which it falls
SHORT = 1e-13  # share of the period: a segment that is no longer has no length


@dataclasses.dataclass(frozen=True)
class Slope(Dimensional):
    """How a measure of a steady motion changes with a parameter.

    value: of the measure; slope: d(measure)/d(parameter) in `unit`; elasticity: d(ln measure)/d(ln parameter), relative
    change for relative change; NaN where the measure or the parameter is zero
    """

    measure: str
    parameter: str
    value: MeasureInUnit
    slope: SlopeInUnit
    unit: str
    elasticity: Number

    in_record = "measure parameter value slope elasticity"


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Gradients(Result):
    """The slopes of measures of a steady motion over parameters, in SI where the system knows its scales.

    kinks: kinds of the events of the motion that fall on a corner of the drive: slopes hold to one side only there
    """

    system: System
    slopes: tuple[Slope, ...]
    kinks: tuple[str, ...] = ()

    rows = "slopes"

    @property
    def heading(self) -> str:
        measures = dict.fromkeys(slope.measure for slope in self.slopes)
        return f"gradients of {', '.join(measures)}"

    @property
    def facts(self) -> dict[str, str]:
        largest = max(self.slopes, key=lambda slope: abs(np.nan_to_num(slope.elasticity)))
        return {
            "slopes": f"{len(self.slopes)} slopes",
            "largest": f"largest elasticity {largest.elasticity:.4g}, of {largest.measure} by {largest.parameter}",
            **({"kinks": f"to one side only: {', '.join(self.kinks)} on a corner of the drive"} if self.kinks else {}),
        }

    def __getitem__(self, asked: tuple[str, str]) -> Slope:
        """The slope of (measure, parameter); KeyError for what was not asked for."""
        for slope in self.slopes:
            if (slope.measure, slope.parameter) == asked:
                return slope
        raise KeyError(asked)


def measures_with_gradients(system: System) -> tuple[str, ...]:
    """The measures that have a gradient: travel, works per drive period and the cost of transport."""
    works = [f"{name}_work" for name in carried(equations(system))]
    travel = list(TRAVEL) if system.cyclic is not None else []
    return (*travel, *works, *(["cost_of_transport"] if travel and "drive_work" in works else []))


def gradients(
    orbit: PeriodicSolution, over: Iterable[str] | str | None = None, measures: Iterable[str] | str | None = None
) -> Gradients:
    """The slopes of measures of a closed orbit over parameters, exact to the tolerance of its runs.

    over: paths of parameters, in SI such as "drive.frequency_Hz" of a system in SI; None: every parameter that is a
        number, but for those that a segment of the drive without length keeps from having a slope to both sides, and
        those at other values of which the machine does not repeat in the drive's period
    measures: of `measures_with_gradients`; None: the mean velocity, or the work of the drive of what cannot travel
    They are those of the mode sequence of the orbit: at a change of it they hold to one side. Raises ArgumentError for
    what is asked, for a system that has no gradients (`check_gradients`), and for an orbit that is not closed or is one
    of a continuum.
    """
    system = orbit.system
    check_gradients(system)
    known = measures_with_gradients(system)
    wanted = [measures] if isinstance(measures, str) else list(measures or known[:1])
    for name in wanted:
        if name not in known:
            raise ArgumentError("measures", f"there is no gradient of {name!r}; {suggestion(name, known)}")
    if orbit.failed or not orbit.response_period:
        why = f"should be closed: this one is {orbit.status.value}, so nothing is a measure of it"
        raise ArgumentError("orbit", why)
    every = over is None
    one = isinstance(over, str) or not isinstance(over, Iterable)
    numbers = [path for path in system.parameter_paths if isinstance(system.parameter(path), float)]  # no counts
    paths: Any = numbers if over is None else [over] if one else over
    asked = list(dict.fromkeys(quantity(path, system).plain for path in paths))
    asked = [path for path in asked if _repeats_beside(system, path, every)]
    ends = _Ends(orbit, asked, any(name not in TRAVEL for name in wanted), every)
    values, slopes = _measured(ends, orbit)
    pairs = [(name, i) for name in wanted for i in range(len(ends.asked))]
    slope_records = tuple(_slope(system, name, ends.asked[i], values[name], slopes[name][i]) for name, i in pairs)
    return Gradients(system, slope_records, tuple(ends.kinks))


def check_gradients(system: System) -> None:
    """ArgumentError for a system whose steady motions have no gradients here, by what stands in the way."""
    if not is_driven(system):
        raise ArgumentError("system", "nothing drives it in time: its period is its own, and would move too")
    if system.machine.imposes_distances:
        name = system.machine.name
        raise ArgumentError("system", f"contacts of a {name} turn at one instant, through which no tangent is carried")


def _repeats_beside(system: System, path: str, every: bool) -> bool:
    """Whether the machine repeats in the drive's period beside the value of a parameter too.

    every: all that is none is left out; else ArgumentError
    """
    value = system.parameter(path)
    if not isinstance(value, float) or repeats_at(system, path, value + BESIDE * (abs(value) or 1.0)):
        return True
    if not every:
        why = f"{path} decides whether the machine repeats in the drive's period: at other values there is no orbit"
        raise ArgumentError("over", why)
    return False


class _Ends:
    """What becomes of the states and integrals over a response, and how that changes with the parameters.

    end: [states + integrals]; by_parameter: [states + integrals, parameters], all that a parameter does, with the start
    on the orbit of its value; period, period_by: of the drive, and [parameters] its derivative
    """

    def __init__(self, orbit: PeriodicSolution, asked: list[str], works: bool, every: bool):
        system = orbit.system
        form = system
        for path in asked:
            form = _recorded(form, path)
        self.map = map_ = StroboscopicMap(form, orbit.tolerance, 1)
        paths = map_.equations.parameter_paths
        self.row = map_.parameters()
        self.places = [paths.index(path) for path in asked]
        self.row[self.places] = [float(system.parameter(path)) for path in asked]
        self.row = map_.equations.filled(self.row)
        if every:
            kept = ~_opening(map_, self.row, self.places)
            asked = [path for path, keep in zip(asked, kept, strict=True) if keep]
            self.places = [place for place, keep in zip(self.places, kept, strict=True) if keep]
        self.asked = asked
        self.steps = np.array([abs(self.row[j]) or 1.0 for j in self.places])  # in which tangents are of usual size
        stretches = _Stretches(map_, self.row, self.places)
        self.period, self.period_by = stretches.period, stretches.moves[-1]
        own = with_integrals(map_.equations) if works else map_.equations
        self.recording = variational_equations(own, True)
        state, moving = state_vector(system, orbit.state), map_.smooth_states
        sizes = map_.scales(self.row)
        n, m = own.base, len(moving)
        self.size = n
        lanes = np.zeros((m + len(asked), n))
        free = map_.free(state[None], self.row[None])[0]
        lanes[np.arange(m), moving] = (sizes * free)[moving]
        here = np.zeros(n)
        here[: map_.states] = state
        motion = orbit.motion()
        ends = [0.0, *stretches.ends] if len(stretches.ends) > 1 else []
        corners = np.add.outer(self.period * np.arange(orbit.response_period), ends).ravel()
        near = [np.any(np.abs(corners - event.time) <= ON_CORNER * self.period) for event in motion.events]
        self.kinks = dict.fromkeys(event.kind for event, on in zip(motion.events, near, strict=True) if on)
        for turn in range(orbit.response_period):
            for k in range(len(stretches.ends)):
                here, lanes = self._over(stretches, k, turn * self.period, here, lanes, motion, m)
        self.end = here
        jacobian = lanes[:m].T / sizes[moving]
        direct = lanes[m:].T / self.steps
        matrix = np.eye(m) - jacobian[moving]
        least = np.linalg.svd(matrix * sizes[moving] / sizes[moving, None], compute_uv=False)[-1] if m else 1.0
        if least < DEGENERATE:
            raise ArgumentError("orbit", "is one of a continuum, or at a fold: no gradient of it is determined")
        self.by_parameter = direct + jacobian @ np.linalg.solve(matrix, direct[moving])

    def _over(
        self,
        stretches: "_Stretches",
        k: int,
        begun: float,
        here: np.ndarray,
        lanes: np.ndarray,
        motion: Trajectory,
        m: int,
    ) -> tuple[np.ndarray, np.ndarray]:
        """(states, tangents) at the end of a stretch between corners, from those at its start."""
        n, count, own = self.size, len(lanes), len(self.row)
        start, end = stretches.starts[k], stretches.ends[k]
        delay = np.concatenate((np.zeros(m), stretches.moves[k] * self.steps))
        rows = np.zeros((count, 2 * own))
        rows[:, :own] = stretches.rows[k]
        rows[m:, own:] = stretches.directions[k] * self.steps[:, None]
        states = np.concatenate((np.tile(here, (count, 1)), lanes), axis=1)
        budget = Budget(1, self.map.tolerance, MOST_EVENTS, MOST_STEPS)
        times = np.full(count, start), np.full(count, end), delay
        begin = EnsembleStart(self.recording, rows, states, *times)
        ended = ensemble_run(begin, budget, Form(order=ORDER), threads=1)
        if not np.all(ended.finished):
            raise ArgumentError(
                "orbit", "a run along it did not return; simulate it to see why, or ask for fewer parameters"
            )
        lanes = ended.state[:, n:].copy()
        if np.any(moves := stretches.moves[k + 1]):
            lanes[m:] += np.outer(moves * self.steps, _rates(motion, begun + end, n))
        return ended.state[0, :n].copy(), lanes


class _Stretches:
    """The stretches of a drive's period between its corners: one where it has none.

    starts, ends: times; rows: [stretches] parameter vectors with the numbers of the segment; directions: [stretches,
    asked, parameters] their derivative by each parameter that is asked for; moves: [stretches + 1, asked] derivatives
    of the times at which they begin and end
    """

    def __init__(self, map_: StroboscopicMap, row: np.ndarray, places: list[int]):
        corners, count = map_.equations.corners, len(places)
        for path in np.flatnonzero(_opening(map_, row, places)):
            name = map_.equations.parameter_paths[places[path]]
            why = f"{name} gives a length to a segment of the drive that has none: to one side only"
            raise ArgumentError("over", why)
        unit = np.zeros((count, len(row)))
        unit[np.arange(count), places] = 1.0
        if corners is None:
            self.period = map_.period(row)
            ends = [self.period]
            self.rows, self.directions = [row], [unit]
            moves = [_by(map_.equations.period, row, places)]
        else:
            self.period = float(corners.periods(row[None])[0])
            longer = _by(corners.period, row, places)
            table = corners.tables(row[None])[0]
            size, parts = corners.row_size, corners.count(row)
            begins = np.arange(parts) * (self.period / parts)
            # [numbers, asked, parts]
            slopes = np.array([_by(number, row, places, begins) for number in corners.numbers])
            slopes = slopes.reshape(-1, size, count, parts).transpose(3, 0, 1, 2)
            shares, moved = table[:, 0], np.cumsum(slopes[:, :, 0], axis=1)
            moved[:, -1] = 0.0
            slopes, moved = slopes.reshape(-1, size, count), moved.reshape(-1, count)
            before = np.concatenate(([0.0], shares[:-1]))
            ends, moves, self.rows, self.directions = [], [], [], []
            power = np.arange(corners.coefficients)
            start, start_moves = 0.0, np.zeros(count)
            for i, share in enumerate(shares):
                if share - before[i] <= SHORT:
                    continue
                scale = self.period ** -power.astype(float)
                numbers, own = table[i, 1:], row.copy()
                own[corners.place :] = [self.period, start, *(numbers * scale)]
                along = unit.copy()
                along[:, corners.place] = longer
                along[:, corners.place + 1] = start_moves
                of_scale = -power * numbers * scale / self.period
                along[:, corners.place + 2 :] = slopes[i, 1:].T * scale + np.outer(longer, of_scale)
                self.rows.append(own)
                self.directions.append(along)
                start, start_moves = share * self.period, moved[i] * self.period + share * longer
                ends.append(start)
                moves.append(start_moves)
        self.ends, self.starts = ends, [0.0, *ends[:-1]]
        self.moves = [np.zeros(count), *moves]


def _opening(map_: StroboscopicMap, row: np.ndarray, places: list[int]) -> np.ndarray:
    """[parameters] whether a parameter gives a length to a segment of the drive that has none."""
    opens, corners = np.zeros(len(places), dtype=bool), map_.equations.corners
    for length in () if corners is None else corners.lengths:
        if float(evaluate([length], 0.0, (), 1.0, row)[0]) <= SHORT:
            opens |= _by(length, row, places) != 0.0
    return opens


def _by(expression: Expression, row: np.ndarray, places: list[int], times: Any = 0.0) -> np.ndarray:
    """Derivatives [places, times] of an expression of the parameters alone, or of these and of time, by parameters."""
    graph = expression.graph
    slopes = [sensitivity(expression, graph.node("parameter", j).index) for j in places]
    return evaluated(slopes, times, (), 1.0, row, np.shape(times))


def _rates(motion: Trajectory, time: float, size: int) -> np.ndarray:
    """Rates [states + integrals] of a motion just before a time at which a piece ends."""
    near = 1e-11 * motion.period
    starts, lengths = motion.piece_start, motion.piece_length
    index = int(np.flatnonzero((starts + lengths < time + near) & (lengths > near))[-1])
    at = np.array([index]), np.array([lengths[index]])
    rates = motion.piece_slopes(*at)[:, 0]
    if size == len(rates):
        return rates
    recorded = equations(motion.system)
    powers = tuple(f"{name}_work" for name in carried(recorded))
    return np.concatenate((rates, motion.piece_observables(powers, *at)[:, 0]))


def _recorded(system: System, path: str) -> System:
    """The system with the parameter as a number of the equations; ArgumentError for what is none."""
    from vibrocap.orbits.maps.closing_map import recorded_with

    if not isinstance(value := system.parameter(path), float):
        kind = "the count " if isinstance(value, int) else ""
        raise ArgumentError("over", f"{path} should be a number to have a gradient, it is {kind}{value!r}")
    return recorded_with(system, path)


def _measured(ends: _Ends, orbit: PeriodicSolution) -> tuple[dict[str, float], dict[str, np.ndarray]]:
    """(values, slopes [parameters]) of all measures that have gradients, by name."""
    turns, values, slopes = orbit.response_period, {}, {}
    n = ends.map.states
    for k, name in enumerate(carried(ends.map.equations) if len(ends.end) > n else ()):
        values[f"{name}_work"] = float(ends.end[n + k] / turns)
        slopes[f"{name}_work"] = ends.by_parameter[n + k] / turns
    if (cyclic := ends.map.cyclic) >= 0:
        drift = float(ends.end[cyclic] / turns)
        if orbit.symmetric or abs(drift) <= residue(orbit.system, "drift", orbit.tolerance):
            drift = 0.0
        by = ends.by_parameter[cyclic] / turns
        values["drift"], slopes["drift"] = drift, by
        values["mean_velocity"] = drift / ends.period
        slopes["mean_velocity"] = (by - values["mean_velocity"] * ends.period_by) / ends.period
        if "drive_work" in values:
            work = values["drive_work"]
            values["cost_of_transport"] = work / abs(drift) if drift else float("inf")
            rate = (slopes["drive_work"] - work / drift * by) / abs(drift) if drift else np.full(len(by), np.nan)
            slopes["cost_of_transport"] = rate
    return values, slopes


def _slope(system: System, measure: str, plain: str, value: float, slope: float) -> Slope:
    """The record of one slope, in SI where the system knows its scales."""
    from vibrocap.measures.standard import known_measure

    known, place, size, unit = known_measure(measure, system), quantity_in_si(plain, system), 1.0, "1"
    assert known is not None
    if system.units is not None:
        unit = system.si.of_contact(known.si_unit)
        size = system.si.factor_of(unit)
    at = float(system.parameter(plain))
    elasticity = slope * at / value if value and at else float("nan")
    below = f"({place.unit})" if " " in place.unit or "/" in place.unit else place.unit
    over = "" if place.unit == "1" else f"/{below}"
    whole = f"({unit})" if over and "/" in unit else unit
    scaled = value * size, float(slope * size / place.scale)
    return Slope(measure, place.path, *scaled, f"{whole}{over}", float(elasticity))
