"""A course: a record, or a segment of it, as a case lives through it under the measured force."""

import dataclasses
import functools
import itertools
from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from vibrocap.identification.problem.differing import LOAD
from vibrocap.motion.simulate import initial_state
from vibrocap.physics.dimensions.units import state_keys, state_units
from vibrocap.physics.drives.table import DriveTable
from vibrocap.physics.system import System
from vibrocap.records.record import Record

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
    return COLUMN_OF.get(_unit(system, predict))


def turns(system: System, predict: str) -> bool:
    """Whether a state is an angle or its rate, which only the record of a contact that turns holds."""
    return _unit(system, predict).startswith("rad")


def _unit(system: System, name: str) -> str:
    """The SI unit of a state, of a system without units too; "" of a state without one."""
    return state_units(system.parts).get(name, "")


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
    system = course.system
    scaled = whole / system.result_units.factor(predict)
    rates, scales = np.gradient(scaled, course.time), dict(zip(system.state_names, system.scales(), strict=True))
    start, steps, guessed = dict(course.start), [], []
    for name in sought:
        first, step = 0.0, 1.0 if name in system.machine.states else float(scales[name])
        if name == predict:
            first, step = float(scaled[course.first]), float(np.std(scaled))
        elif _unit(system, name) == f"{_unit(system, predict)}/s":
            first, step = float(rates[course.first]), float(np.std(rates))
        else:
            guessed.append(name)
        start[name] = first
        steps.append(step)
    return dataclasses.replace(course, start=start, free=tuple(sought), steps=np.array(steps), guessed=tuple(guessed))
