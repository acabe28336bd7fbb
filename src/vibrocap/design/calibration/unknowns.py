"""What a fit of motions searches beside their starts: parameters of a case and of its force sensor, by record too."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, Complaints, suggestion
from vibrocap.design.calibration.course import Course, Sensor
from vibrocap.design.search.variables import DesignSpace, design_space
from vibrocap.identification.problem.differing import condition_among, own_name, slope_name
from vibrocap.identification.problem.prediction import LARGEST_GAIN, LATEST, LATEST_SHARE
from vibrocap.physics.system import System
from vibrocap.studies.plan.designs import Range

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
        return [*(unknown for unknown in self.ranges if unknown.path not in self.by_record), *self.slopes]

    def own(self, record: str) -> list[Range]:
        """Those of one record: the first has the gain 1."""
        ranges = [unknown for unknown in self.ranges if unknown.path in self.by_record]
        if record == self.first:
            return [unknown for unknown in ranges if unknown.path != "gain"]
        return [dataclasses.replace(unknown, path=own_name(unknown.path, record)) for unknown in ranges]

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
            argument = "along" if name in along else "by_record"
            names = [unknown.path for unknown in ranges]
            if name not in names:
                raise ArgumentError(argument, f"{name!r} is not searched; {suggestion(name, names)}")
            if name in by_record and (name in along or list(by_record).count(name) > 1):
                raise ArgumentError(argument, f"{name} is named twice")
            if len(courses) < 2:
                raise ArgumentError(argument, "needs several records to fit")
            if name in along:
                of_records = [condition_among(course.conditions, along[name], course.name) for course in courses]
                half = 0.5 * (max(of_records) - min(of_records))
                if not half > 0.0:
                    raise ArgumentError(argument, f"{along[name]} is the same in all records")
                own = ranges[names.index(name)]
                reach = (own.high - own.low) / half
                conditions[name] = along[name], float(np.mean(of_records))
                slopes.append(Range(slope_name(name, along[name]), -reach, reach))
    return Unknowns(
        space, tuple(ranges), tuple(by_record), conditions, tuple(slopes), courses[0].name, force, time
    )  # fmt: skip


def _range(name: str, courses: Sequence[Course], force: float, time: float) -> Range:
    """Within which a term of the sensor is searched, in the units of the records."""
    if name == "gain":
        return Range(name, 1.0 / LARGEST_GAIN, LARGEST_GAIN, logarithmic=True)
    if name == "offset":
        largest = force * max(float(np.max(np.abs(course.force))) for course in courses)
        return Range(name, -largest, largest)
    interval = float(np.median(np.concatenate([np.diff(course.time) for course in courses])))
    reach = time * max(LATEST * interval, LATEST_SHARE * min(float(course.time[-1]) for course in courses))
    return Range(name, -reach, reach)
