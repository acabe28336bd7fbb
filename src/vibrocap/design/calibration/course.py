"""A course: a record, or a segment of it, as a case lives through it under the measured force; and what a fit searches
beside the starts of courses: parameters of the case and of its force sensor, by record too.
"""

import dataclasses
import functools
import itertools
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np

from vibrocap.arguments import ArgumentError, Complaints, suggestion
from vibrocap.design.search.variables import DesignSpace, design_space
from vibrocap.identification.problem.coordinates import (
    LOAD,
    check_differing,
    condition_among,
    condition_range,
    own_name,
    slope_name,
)
from vibrocap.identification.problem.prediction import LARGEST_GAIN, latest
from vibrocap.motion.simulate import initial_state
from vibrocap.physics.dimensions.units import state_keys, state_units
from vibrocap.physics.drives.table import DriveTable
from vibrocap.physics.system import System
from vibrocap.records.record import Record
from vibrocap.studies.plan.designs import Range

COLUMN_OF = {"m": "displacement", "rad": "displacement", "m/s": "velocity", "rad/s": "velocity"}


@dataclasses.dataclass(frozen=True)
class Sensor:
    """What the force sensor makes of a force F(t): it reads gain (F(t - delay) + offset), in the case's own units."""

    offset: float = 0.0
    delay: float = 0.0
    gain: float = 1.0


@dataclasses.dataclass(frozen=True, eq=False)
class Course:
    """A record, or a segment of it, with its own start.

    name: of the record; system: the case; time, force [n]: of the whole record, in the case's own units
    first: sample at which the course begins; measured [m]: from there on, in the unit of the results
    size: of the errors, that of what was measured in all records
    start: initial states; free: names of those that are sought; steps [free]: their sizes; guessed: names of those of
        which nothing was measured
    conditions: numbers of the record; follows: whether the course continues the one before
    """

    name: str
    system: System
    time: np.ndarray
    force: np.ndarray
    first: int
    measured: np.ndarray
    size: float
    start: Mapping[str, float]
    free: tuple[str, ...]
    steps: np.ndarray
    guessed: tuple[str, ...]
    conditions: Mapping[str, float]
    follows: bool = False

    @property
    def instants(self) -> np.ndarray:
        """Times [m] of the samples, from the start of the course."""
        return self.time[self.first : self.first + len(self.measured)] - self.time[self.first]

    @property
    def joint(self) -> float:
        """Time from the start of the course to that of the next one of the same record."""
        return float(self.time[self.first + len(self.measured)] - self.time[self.first])

    @functools.cached_property
    def interpolation(self) -> Literal["cubic", "linear"]:
        """Between samples of the force: cubic where its neighbours tell each sample better so than by straight lines,
        as of a smooth force, not of one with jumps or much noise."""
        f = self.force
        lines = 0.5 * (f[2:-4] + f[4:-2])
        curves = 1.125 * lines - (f[:-6] + f[6:]) / 16.0
        return "cubic" if np.sum((f[3:-3] - curves) ** 2) < np.sum((f[3:-3] - lines) ** 2) else "linear"

    def driven(self, sensor: Sensor = Sensor()) -> System:
        """The case under the force, behind whose end the course is over."""
        begin, last = self.time[self.first], min(self.first + len(self.measured), len(self.time) - 1)
        end = self.time[last]
        moments, values = (2.0 * np.pad(x, 1, "edge") - np.pad(x, 1, "reflect") for x in (self.time, self.force))
        moments, values = moments - sensor.delay, values / sensor.gain - sensor.offset
        within = (moments > begin) & (moments < end)
        before, after = begin - moments[1] + moments[0], end + moments[-1] - moments[-2]
        knots = np.array([begin, *moments[within], end, after])
        first, *forces = np.interp([before, *knots], moments, values)
        close = 2.0 * after - end - begin  # behind the end: the neighbours of both ends, between which nothing is asked
        times, values = (*(knots - begin), close, close + begin - before), (*forces, first, forces[0])
        drive = DriveTable(times=times, values=values, interpolation=self.interpolation)
        return dataclasses.replace(self.system, drive=drive)


def measured_column(system: System, predict: str) -> str | None:
    """The column of a record that holds a state of a motion; None where records have no such column."""
    return COLUMN_OF.get(state_units(system.parts).get(predict, ""))


def turns(system: System, predict: str) -> bool:
    """Whether a state is an angle or its rate, which only the record of a contact that turns holds."""
    return state_units(system.parts).get(predict, "").startswith("rad")


def courses(system: System, records: Sequence[Record], predict: str, known: Mapping[str, float]) -> list[Course]:
    """Records as a case lives through them. Errors of all count alike: they have been measured by one sensor."""
    column, units = str(measured_column(system, predict)), system.result_units
    size = float(np.sqrt(np.mean([np.var(getattr(record, column)) for record in records])))
    keys = state_keys(units.states)
    known_names = {keys[name].name if name in keys else name for name in known}
    sought = [name for name in system.machine.states if name not in known_names and name not in system.switched]
    whole = []
    for record in records:
        time = (record.time - record.time[0]) / units.factor("time")
        load = {} if record.normal_force is None else {LOAD: float(np.mean(record.normal_force))}
        course = Course(
            record.name, system, time, record.force / units.factor("drive"), 0, getattr(record, column), size,
            initial_state(system, known), (), np.empty(0), (), load | dict(record.conditions),
        )  # fmt: skip
        whole.append(_begun(course, course.measured, predict, sought))
    return whole


def segments(course: Course, predict: str, count: int) -> list[Course]:
    """A record in so many courses, of which each continues the one before from a start of its own.

    A start is guessed by what was measured there; all its states are sought, bristles of a law too.
    """
    cuts = np.linspace(0, len(course.measured), count + 1).astype(int)
    parts = []
    for begin, end in itertools.pairwise(map(int, cuts)):
        part = dataclasses.replace(course, first=begin, measured=course.measured[begin:end], follows=begin > 0)
        parts.append(_begun(part, course.measured, predict, course.system.state_names) if begin else part)
    return parts


def _begun(course: Course, whole: np.ndarray, predict: str, sought: Sequence[str]) -> Course:
    """The course with its start: what is predicted by its sample, its rate by differences; whole [n]: the record."""
    system, units = course.system, state_units(course.system.parts)  # in SI, of a system without units too
    scaled = whole / system.result_units.factor(predict)
    rates, scales = np.gradient(scaled, course.time), dict(zip(system.state_names, system.scales(), strict=True))
    start, steps, guessed = dict(course.start), [], []
    for name in sought:
        first, step = 0.0, 1.0 if name in system.machine.states else float(scales[name])
        if name == predict:
            first, step = float(scaled[course.first]), float(np.std(scaled))
        elif units.get(name, "") == f"{units.get(predict, '')}/s":
            first, step = float(rates[course.first]), float(np.std(rates))
        else:
            guessed.append(name)
        start[name] = first
        steps.append(step)
    return dataclasses.replace(course, start=start, free=tuple(sought), steps=np.array(steps), guessed=tuple(guessed))


TERMS = tuple(field.name for field in dataclasses.fields(Sensor))


@dataclasses.dataclass(frozen=True, eq=False)
class Unknowns:
    """Unknowns by name, each with its range.

    space: of the parameters of the case; ranges: of these and of the terms of the sensor
    by_record: names with a value in each record, p[record]; that of the first record is p
    along: {name: (condition, its middle)} of p + p.condition (x - middle) in a record with the condition x, within the
        range of p; slopes: their ranges
    first: name of the first record; force, time: units of offset and delay, by the case's own
    """

    space: DesignSpace
    ranges: tuple[Range, ...]
    by_record: tuple[str, ...]
    along: Mapping[str, tuple[str, float]]
    slopes: tuple[Range, ...]
    first: str
    force: float
    time: float

    @property
    def shared(self) -> list[Range]:
        """Those that all records have in common."""
        return [*(x for x in self.ranges if x.path not in self.by_record), *self.slopes]

    def own(self, record: str) -> list[Range]:
        """Those of one record: the first has the gain 1."""
        ranges = [x for x in self.ranges if x.path in self.by_record]
        if record == self.first:
            return [x for x in ranges if x.path != "gain"]
        return [dataclasses.replace(x, path=own_name(x.path, record)) for x in ranges]

    def in_record(self, values: Mapping[str, float], course: Course) -> tuple[dict[str, Any], Sensor]:
        """(parameters of the case by path, the sensor) in a record, from the values of the unknowns by name."""
        own = {}
        for unknown in self.ranges:
            name = unknown.path
            at = own_name(name, course.name) if name in self.by_record and course.name != self.first else name
            own[name] = values.get(at, 1.0)  # the first gain
            if name in self.along:
                condition, middle = self.along[name]
                change = condition_among(course.conditions, condition, course.name) - middle
                changed = own[name] + values[slope_name(name, condition)] * change
                own[name] = min(max(changed, unknown.low), unknown.high)
        terms = {name: own.pop(name) for name in TERMS if name in own}
        for name, unit in (("offset", self.force), ("delay", self.time)):
            if name in terms:
                terms[name] /= unit
        return self.space.made(own), Sensor(**terms)


def unknowns(
    system: System,
    courses: Sequence[Course],
    over: Mapping[str, Any],
    terms: Sequence[str],
    by_record: Sequence[str],
    along: Mapping[str, str],
    complaints: Complaints,
) -> Unknowns:
    """The unknowns of records that are fitted; what is wrong with them is added to the complaints.

    over: as in `calibrate`; terms: of the sensor, "offset" (N), "delay" (s) and "gain"; by_record, along: as in `fit`
    """
    space = design_space(courses[0].driven(), over, complaints)
    space.require_numbers(complaints)
    units: Any = system.result_units
    force, time = units.factor("drive"), units.factor("time")
    with complaints.collected():
        for name in terms:
            if name not in TERMS:
                raise ArgumentError("terms", f"there is no term {name!r}; {suggestion(name, TERMS)}")
        if "gain" in terms and "gain" not in by_record:
            raise ArgumentError("terms", "gain of all records is drive.amplitude: name it in by_record too")
    ranges: list[Any] = [*space.variables, *(_range(name, courses, force, time) for name in terms if name in TERMS)]
    conditions, slopes = {}, []
    with complaints.collected():
        for name in (*by_record, *along):
            names = [unknown.path for unknown in ranges]
            check_differing(name, names, by_record, along, len(courses))
            if name in along:
                of_records = [condition_among(course.conditions, along[name], course.name) for course in courses]
                middle, half = condition_range(along[name], of_records)
                own = ranges[names.index(name)]
                reach = (own.high - own.low) / half
                conditions[name] = along[name], middle
                slopes.append(Range(slope_name(name, along[name]), -reach, reach))
    of_records = tuple(by_record), conditions, tuple(slopes), courses[0].name
    return Unknowns(space, tuple(ranges), *of_records, force, time)


def _range(name: str, courses: Sequence[Course], force: float, time: float) -> Range:
    """Within which a term of the sensor is searched, in the units of the records."""
    if name == "gain":
        return Range(name, 1.0 / LARGEST_GAIN, LARGEST_GAIN, logarithmic=True)
    if name == "offset":
        largest = force * max(float(np.max(np.abs(course.force))) for course in courses)
        return Range(name, -largest, largest)
    reach = time * latest([course.time for course in courses])[1]
    return Range(name, -reach, reach)
