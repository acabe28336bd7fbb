"""Prediction: the force of a law driven by the measured motions, or of its steady curve, its error and how that changes
with each parameter.
"""

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.identification.problem.coordinates import Coordinate, Differing, Space, in_record, own_name
from vibrocap.identification.problem.parametrisation import with_role
from vibrocap.identification.problem.priors import Prior, prior_errors, prior_slopes
from vibrocap.identification.problem.samples import Samples
from vibrocap.identification.problem.terms import RIPPLES, TERMS, coordinate_of, forces_of_terms, ripple_coordinates
from vibrocap.laboratory.driven import driven_forces
from vibrocap.physics.friction.law import Law

SMALL = 20_000  # samples, over all rows, below which starting threads takes longer than the work they share
START = "start"  # of a contact: its states at the first sample of a record


@dataclasses.dataclass(frozen=True, eq=False)
class Prediction:
    """The law of a fit, driven through its records, as a function of coordinates.

    Error of a sample: (predicted - measured) / (weight's unit of the record), where
    predicted = R(law; v(t - delay)) + sum of c s(t - delay) over its terms: all that the force sensor measures is late.
    The normal force is measured like the force and is late with it already.

    template: the law that carries what is not searched; space: coordinates of the law's parameters, then of the
    nuisances: `TERMS`, `BESIDE` and the internal states at the first samples over their natural sizes.
    units [records] N: error that counts as 1, of a record or of each of its samples.
    """

    template: Law
    space: Space
    records: tuple[Samples, ...]
    units: tuple[Any, ...]
    threads: int | None = None
    priors: tuple[Prior, ...] = ()
    differing: tuple[Differing, ...] = ()

    @property
    def law_names(self) -> tuple[str, ...]:
        """The searched parameters that belong to the law."""
        return tuple(coordinate.name for coordinate in self.space.coordinates if not coordinate.nuisance)

    @property
    def size(self) -> int:
        """Number of samples, those that do not count included."""
        return sum(len(record) for record in self.records)

    def of(self, records: Sequence[Samples], units: Sequence[Any]) -> "Prediction":
        """The same law and coordinates for other samples."""
        return dataclasses.replace(self, records=tuple(records), units=tuple(units))

    def law(self, u: np.ndarray) -> Law:
        """The law at coordinates, checked."""
        values = self.space.named(u)
        return dataclasses.replace(self.template, **{name: values[name] for name in self.law_names})  # type: ignore[type-var]

    def forces(self, table: np.ndarray, which: int) -> np.ndarray:
        """Predicted force [m, n] of record number `which` at coordinates [m, p]; NaN where a run failed."""
        record = self.records[which]
        names, law_names = self.space.names, self.law_names
        values, law_values = self._values(table, record)
        lawful = np.array([self._lawful(row) for row in law_values.tolist()])
        forces = np.full((len(values), len(record)), np.nan)
        if not lawful.any():
            return forces
        start = self._start(values, law_values, record)
        delays, adhesions = (self._beside(values, name, 0.0) for name in (DELAY, ADHESION))
        for delay, adhesion in np.unique(np.stack([delays, adhesions], axis=1)[lawful], axis=0):
            rows = lawful & (delays == delay) & (adhesions == adhesion)
            threads = 1 if rows.sum() * len(record) < SMALL else self.threads
            how = {"load": record.load + adhesion, "internal": start[rows] if start is not None else None}
            motion = record.time, _late(record.velocity, record.time, delay)
            driven = driven_forces(self.template, law_values[rows], law_names, *motion, **how, threads=threads)
            forces[rows] = driven.force
            late = functools.partial(_late, time=record.time, delay=delay)
            forces[rows] += forces_of_terms(names, values[rows], record, late, forces[rows])
        return forces * self._beside(values, own_name(GAIN, record.name), self._beside(values, GAIN, 1.0))[:, None]

    def _values(self, table: np.ndarray, record: Samples) -> tuple[np.ndarray, np.ndarray]:
        """(all parameters [m, p] in a record, those of the law [m, l]) at coordinates [m, p]."""
        values = in_record(self.differing, self.space.names, self.space.values(np.atleast_2d(table)), record)
        return values, values[:, [self.space.names.index(name) for name in self.law_names]]

    def _beside(self, values: np.ndarray, name: str, otherwise: Any) -> np.ndarray:
        """A parameter [m] of the measurement."""
        names = self.space.names
        return values[:, names.index(name)] if name in names else np.broadcast_to(otherwise, len(values))

    def _lawful(self, row: list[float]) -> bool:
        """Whether the law takes these parameters: some laws check them together."""
        try:
            dataclasses.replace(self.template, **dict(zip(self.law_names, row, strict=True)))  # type: ignore[type-var]
        except ValueError:
            return False
        return True

    def errors(self, u: np.ndarray) -> np.ndarray:
        """Errors [n] of all samples, over the records' units, then those of the priors."""
        return self.error_table(u[None])[0]

    def error_table(self, table: np.ndarray) -> np.ndarray:
        """Errors [m, n] at coordinates [m, p]."""
        errors = [self._over_units(self.forces(table, i), i) for i in range(len(self.records))]
        known = prior_errors(self.priors, self.space.names, self.space.values(table))
        return np.concatenate([*errors, known], axis=1)

    def by_record(self, errors: np.ndarray) -> list[np.ndarray]:
        """Errors [n] of the samples, one array a record, without those of the priors."""
        return np.split(errors[: self.size], np.cumsum([len(record) for record in self.records])[:-1])

    def slopes(self, u: np.ndarray, errors: np.ndarray | None = None, held: Sequence[int] = ()) -> np.ndarray:
        """Errors' derivatives [n, p] by coordinates, by differences into the box; zero for the `held` ones.

        All rows of one record are one call of the driven law. A state at the start changes its own record only.
        """
        low, high = self.space.low, self.space.high
        own = np.array([coordinate.step for coordinate in self.space.coordinates])
        steps = np.where(u + own <= high, own, -own)
        steps = np.where((steps < 0) & (u - own < low), 0.5 * (high - low), steps)
        jacobian = np.zeros((self.size + len(self.priors), len(u)))
        jacobian[self.size :] = prior_slopes(self.priors, self.space.names, self.space.slopes(u))
        jacobian[self.size :, list(held)] = 0.0
        begin = 0
        for i, record in enumerate(self.records):
            end = begin + len(record)
            owners = (coordinate.record for coordinate in self.space.coordinates)
            moved = [j for j, owner in enumerate(owners) if j not in held and owner in ("", record.name)]
            if moved:
                table = np.tile(u, (len(moved) + (errors is None), 1))
                table[range(len(moved)), moved] += steps[moved]
                rows = self._over_units(self.forces(table, i), i)
                base = rows[-1] if errors is None else errors[begin:end]
                for row, j in zip(rows, moved, strict=False):
                    jacobian[begin:end, j] = (row - base) / steps[j]
            begin = end
        return jacobian

    def start(self, u: np.ndarray, which: int) -> np.ndarray | None:
        """Internal states [k] at the first sample of record number `which`; None where the contact is relaxed."""
        record = self.records[which]
        states = self._start(*self._values(u, record), record)
        return None if states is None else states[0]

    @property
    def counts(self) -> list[np.ndarray]:
        """Which samples of each record count: those whose force the motion tells, and whose unit is finite."""
        return [np.isfinite(unit) & self.tells(i) for i, unit in enumerate(self.units)]

    def tells(self, which: int) -> np.ndarray:
        """Samples [n] of a record whose motion tells the force: at rest that of a set-valued law balances others."""
        return (self.records[which].velocity != 0.0) | (self.template.kind != "set-valued")

    def _over_units(self, forces: np.ndarray, which: int) -> np.ndarray:
        """Errors [m, n] of predicted forces of a record, over its units."""
        return np.where(self.tells(which), (forces - self.records[which].force) / self.units[which], 0.0)

    def _start(self, values: np.ndarray, law_values: np.ndarray, record: Samples) -> np.ndarray | None:
        """Internal states [m, k] at the first sample of a record."""
        own = {c.state: i for i, c in enumerate(self.space.coordinates) if c.state and c.record == record.name}
        if not own:
            return None
        states = self.template.internal
        load = float(np.ravel(record.load)[0])
        start_states = np.zeros((len(values), len(states)))
        for row, (value, parameters) in enumerate(zip(values, law_values, strict=True)):
            law = unchecked(self.template, dict(zip(self.law_names, parameters.tolist(), strict=True)))
            scales = start_scales(law, load)
            for state, i in own.items():
                for k in range(len(states)) if state == ALL_STATES else [states.index(state)]:
                    if states[k] not in self.template.switched:
                        start_states[row, k] = value[i] * scales[k]
        return start_states


ALL_STATES = "all"
LATE_STEP = 0.01  # of a sampling interval
DELAY = "delay"
GAIN = "gain"  # of the force sensor
ADHESION = "adhesion"  # load that the contact has of itself: mu (N + N_0) = mu N + F_0 (Derjaguin 1934)
BESIDE = (DELAY, GAIN, ADHESION, *RIPPLES)  # what a driven fit may search beside `TERMS`
LARGEST_GAIN, MOST_ADHESION, LEAST_LOAD = 10.0, 100.0, 0.05  # the latter two over loads
LATEST, LATEST_SHARE = 20.0, 0.01  # samples that a force may be late or early, or share of the shortest record
GAP = "gap_position"  # the state of a joint with play


def start_scales(law: Law, load: float) -> tuple:
    """Largest value of each internal state at the start."""
    scales = dict(zip(law.internal, law.internal_scales(load), strict=True))
    if GAP in scales:
        scales[GAP] = 0.5 * law.gap * (1 - 1e-9)  # type: ignore[attr-defined]
    return tuple(scales.values())


def unchecked(law: Law, values: Mapping[str, Any]) -> Law:
    """A law with other parameters, without the checks (which take longer than a driven step)."""
    copy = object.__new__(type(law))
    copy.__dict__.update(law.__dict__)
    copy.__dict__.update(values)
    return copy


def _late(column: np.ndarray, time: np.ndarray, delay: float) -> np.ndarray:
    """A column as it was a delay before, linear between the samples; before the first one it is that one."""
    return np.interp(time - delay, time, column) if delay else column


def latest(times: Sequence[np.ndarray]) -> tuple[float, float]:
    """(usual interval between samples of records, time by which a force may be late or early)."""
    interval = float(np.median(np.concatenate([np.diff(time) for time in times])))
    return interval, max(LATEST * interval, LATEST_SHARE * min(float(time[-1]) for time in times))


def delay_coordinate(records: Sequence[Samples]) -> Coordinate:
    """The time by which the force is late behind the motion."""
    interval, reach = latest([record.time for record in records])
    # samples are joined by straight lines, which a fine step would see
    of: dict[str, Any] = {"scale": interval, "spread": 0.0, "step": LATE_STEP, "nuisance": True}
    of |= {"meaning": "time by which the force is late behind the motion", "unit": "s"}
    return Coordinate(DELAY, "linear", -reach, reach, **of)


def _coordinates_beside(
    name: str, records: Sequence[Samples], level: float, lengths: Mapping[str, float]
) -> list[Coordinate]:
    """The coordinates of a term of a driven fit, or ArgumentError for an adhesion that no load tells from a level."""
    of: dict[str, Any] = {"nuisance": True, "spread": 0.0}
    if name == DELAY:
        return [delay_coordinate(records)]
    if name == GAIN:
        ends = 1.0 / LARGEST_GAIN, LARGEST_GAIN
        return [Coordinate(GAIN, "log", *ends, **of, meaning="factor of the force sensor", unit="1")]
    if name != ADHESION:
        return [*ripple_coordinates(name, lengths[name], records, level)] if name in lengths else []
    loads = np.concatenate([np.atleast_1d(record.load) for record in records])
    least, most = float(np.min(loads)), float(np.max(loads))
    if not least < most:
        raise ArgumentError("terms", "adhesion needs normal forces that differ; with one load it is part of a level")
    of |= {"scale": 0.1 * most, "meaning": "load that the contact has of itself", "unit": "N"}
    return [Coordinate(ADHESION, "linear", (LEAST_LOAD - 1) * least, MOST_ADHESION * most, **of)]


def nuisances(
    law: Law,
    records: Sequence[Samples],
    *,
    terms: Sequence[str],
    start: str,
    level: float,
    lengths: Mapping[str, float] = {},
) -> tuple[Coordinate, ...]:
    """Coordinates of the nuisance parameters, which start at nothing; lengths: of ripples, those that are known.

    start: "fitted": the states of the contact at the first sample of each record are searched (all by one number where
    the law has more than three); "relaxed": they are zero.
    """
    coordinates = [coordinate_of(name, records, level) for name in TERMS if name in terms]
    for name in BESIDE:
        if name in terms:
            coordinates += _coordinates_beside(name, records, level, lengths)
    signs = law.internal_symmetry or (-1,) * len(law.internal)
    states = [(s, sign) for s, sign in zip(law.internal, signs, strict=True) if s not in law.switched]
    if GAP in law.internal:  # behind a joint that starts open the contact is at rest
        states = [(GAP, -1)]
    if start == "fitted" and states:
        for record in records:
            for state, sign in states if len(states) <= 3 else [(ALL_STATES, -1)]:
                # a state that changes sign with the motion cannot exceed its natural size, another may be far from it
                reach = 1.0 if sign == -1 else 40.0
                of: dict[str, Any] = {"record": record.name, "state": state, "nuisance": True, "spread": 0.3}
                of |= {"meaning": "state of the contact at the first sample, over its natural size", "unit": "1"}
                coordinates.append(Coordinate(f"{own_name(START, record.name)}.{state}", "linear", -reach, reach, **of))
    return tuple(coordinates)


def _of_column(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    return lambda column: function(column)


class Column(np.ndarray):
    """Numbers on which the formulas of a law compute all at once."""

    exp, log, sqrt = map(_of_column, (np.exp, np.log, np.sqrt))
    sin, cos, tanh, atan = map(_of_column, (np.sin, np.cos, np.tanh, np.arctan))


def steady_force(law: Law, velocity: Any, load: Any = 1.0, values: Mapping[str, Any] | None = None) -> np.ndarray:
    """Force of a law at constant velocities [...], odd unless the law is anisotropic; 0 at rest.

    values: parameters that replace the law's, numbers or arrays that broadcast with the velocity.
    """
    velocity = np.asarray(velocity, float)
    side = np.sign(velocity)
    speed = np.where(side == 0, 1.0, np.abs(velocity)).view(Column)
    columns = {name: np.asarray(value, float).view(Column) for name, value in (values or {}).items()}
    changed = unchecked(law, columns)
    with np.errstate(all="ignore"):
        if law.kind == "smooth":
            force, _ = changed.force(velocity.view(Column), (), 1.0, load)
            return np.asarray(force) + 0.0 * velocity
        if with_role(law, "back ratio"):
            force = changed.steady_force(speed, load, side)  # type: ignore[call-arg]
        else:
            force = changed.steady_force(speed, load)
    return np.asarray(side * force) + 0.0 * velocity


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyPrediction(Prediction):
    """The steady curve of a law, at the velocity of each sample."""

    def forces(self, table: np.ndarray, which: int) -> np.ndarray:
        """Force [m, n] of record number `which` at coordinates [m, p]."""
        record, names = self.records[which], self.space.names
        values = self.space.values(np.atleast_2d(table))
        columns = {name: values[:, [names.index(name)]] for name in self.law_names}
        rows = np.broadcast_to(record.velocity, (len(values), len(record)))
        forces = steady_force(self.template, rows, record.load, columns)
        return forces + forces_of_terms(names, values, record, np.asarray, forces)
