"""Samples: the columns of records as a fit uses them, on their own clock, thinned where a draft is enough; and their
scales: levels, speed, length, stiffness and noise, from which fits start and get their bounds.
"""

import dataclasses
import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.physics.parameters import Dimension
from vibrocap.records.preparation import prepared
from vibrocap.records.record import integral

MOTION_LOST = 0.01  # share of the velocity (root mean square) that thinning may change
FEWEST_SAMPLES = 8
COLUMNS = ("time", "velocity", "force", "acceleration", "load", "position")


@dataclasses.dataclass(frozen=True, eq=False)
class Samples:
    """One record, ready to be fitted.

    time [n] s from the first sample; velocity [n] m/s; force [n] N; acceleration [n] m/s^2; load N: a number or [n],
    1 where the normal force is not known, so that friction coefficients are then forces.
    deviation: standard deviation of the force, over which errors are relative.
    rotary: the contact turns (N m, rad, rad/s); guessed_units: those that the record's file did not say.
    position [n] m: displacement, from the first sample where it was not measured
    velocity_made: whether the velocity was made from it.
    conditions: numbers that the record was made with, by name.
    """

    name: str
    time: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    acceleration: np.ndarray
    load: Any
    deviation: float
    position: np.ndarray
    rotary: bool = False
    guessed_units: Mapping[str, str] = dataclasses.field(default_factory=dict)
    velocity_made: bool = False
    conditions: Mapping[str, float] = dataclasses.field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.time)

    @property
    def displacement(self) -> np.ndarray:
        """Displacement from the first sample, the integral of the velocity (trapezoids)."""
        return integral(self.time, self.velocity)

    def thinned(self, every: int) -> "Samples":
        """Means of blocks of `every` samples."""
        blocks = len(self) // every
        return self._each(lambda column: column[: blocks * every].reshape(blocks, every).mean(axis=1))

    def kept(self, which: Any) -> "Samples":
        """The samples of a slice or a mask."""
        return self._each(lambda column: column[which])

    def _each(self, change: Callable[[np.ndarray], np.ndarray]) -> "Samples":
        """The same with each column changed; a load that is one number stays."""
        columns = {name: np.asarray(getattr(self, name)) for name in COLUMNS}
        return dataclasses.replace(self, **{name: change(column) for name, column in columns.items() if column.ndim})


def samples(record: Any, load: float | None = None) -> Samples:
    """The samples of a `Record`; velocity is made from displacement where it was not measured.

    load: normal force in N for a record that does not know its own.
    """
    if isinstance(record, Samples):
        return record
    velocity_made = record.velocity is None
    if velocity_made or record.acceleration is None:
        record = prepared(record)
    time, force, velocity = record.time, record.force, record.velocity
    known = record.normal_force if record.normal_force is not None else (1.0 if load is None else load)
    if not np.any(velocity):
        raise ArgumentError(f"record {record.name!r}", "nothing moves in it; friction needs a motion")
    return Samples(
        record.name,
        time=time - time[0],
        velocity=np.ascontiguousarray(velocity),
        force=force,
        acceleration=np.gradient(velocity, time) if record.acceleration is None else record.acceleration,
        load=float(known) if np.ndim(known) == 0 else np.ascontiguousarray(known, dtype=float),
        deviation=float(np.std(force)),
        position=integral(time, velocity) if record.displacement is None else record.displacement,
        rotary=record.rotary,
        guessed_units=record.guessed_units,
        velocity_made=velocity_made,
        conditions=record.conditions,
    )


def drafts(all_samples: Sequence[Samples], target: int) -> list[Samples]:
    """Thinned samples, about `target` in all, fewer only as long as the motion stays what it is."""
    total = sum(len(sample) for sample in all_samples)
    thinned = []
    for full in all_samples:
        every, thin = max(1, total // target), full
        while every > 1:
            thin = full.thinned(every)
            if len(thin) >= FEWEST_SAMPLES:  # how much the velocity changes when they are joined by straight lines
                change = np.interp(full.time, thin.time, thin.velocity) - full.velocity
                if float(np.sqrt(np.mean(change**2) / np.mean(full.velocity**2))) <= MOTION_LOST:
                    break
            every, thin = max(1, every * 2 // 3), full
        thinned.append(thin)
    return thinned


@dataclasses.dataclass(frozen=True)
class DataScales:
    """What a look at the data tells before any law is fitted.

    level N: median |force| above half of `speed`; forward, backward N: the same by direction (level where there is
    none); peak: 98 % quantile of |force| over level; load N: typical normal force; speed m/s: 95 % quantile of |v|;
    length m: half the range of displacement; stiffness N/m: slope of force against displacement after reversals, or
    none where there is no reversal; step m: displacement between samples where it is small (5 % quantile of |v| dt);
    noise N: standard deviation of what changes from sample to sample.
    """

    level: float
    forward: float
    backward: float
    peak: float
    load: float
    speed: float
    length: float
    stiffness: float | None
    step: float
    interval: float
    noise: float
    drop_speed: float | None

    def natural(self, dimension: Dimension) -> float:
        """Product of the scales of coefficient, force, length and time to the exponents of a dimension."""
        scales = (self.level / self.load, self.level, self.length, self.length / self.speed)
        powers = zip(scales, dimension.exponents[:4], strict=True)
        return float(np.prod([scale**exponent for scale, exponent in powers]))


def data_scales(all_samples: Sequence[Samples]) -> DataScales:
    """The scales of records together."""
    velocity = np.concatenate([sample.velocity for sample in all_samples])
    force = np.concatenate([sample.force for sample in all_samples])
    load = np.concatenate([np.broadcast_to(sample.load, len(sample)) for sample in all_samples])
    speed = max(float(np.quantile(np.abs(velocity), 0.95)), 1e-300)
    fast = np.abs(velocity) >= 0.5 * speed
    level = max(float(np.median(np.abs(force[fast]))), 1e-3 * float(np.sqrt(np.mean(force**2))))
    sides = [force[fast & (np.sign(velocity) == side)] * side for side in (1, -1)]
    forward, backward = (max(float(np.median(side)), 0.05 * level) if len(side) else level for side in sides)
    steps = np.concatenate([np.abs(sample.velocity[1:]) * np.diff(sample.time) for sample in all_samples])
    return DataScales(
        level=level,
        forward=forward,
        backward=backward,
        peak=max(1.0, float(np.quantile(np.abs(force), 0.98)) / level),
        load=max(float(np.median(load)), 1e-300),
        speed=speed,
        length=max(max(float(np.ptp(sample.displacement)) for sample in all_samples) / 2, 1e-300),
        stiffness=_stiffness(all_samples, level),
        step=max(float(np.quantile(steps[steps > 0], 0.05)), 1e-300),
        interval=float(np.median(np.concatenate([np.diff(sample.time) for sample in all_samples]))),
        noise=noise_of(np.concatenate([np.diff(sample.force, 2) for sample in all_samples])),
        drop_speed=_drop_speed(velocity, force, speed, level),
    )


def noise_of(second: np.ndarray) -> float:
    """Standard deviation of white noise of which these are second differences, which a smooth force does not have.

    From their median.
    """
    return float(np.median(np.abs(second)) / 0.6745 / np.sqrt(6.0))


def turns(side: np.ndarray) -> np.ndarray:
    """Samples at which a direction of motion (-1, 0 at rest, 1) has turned."""
    moving = np.flatnonzero(side)
    return moving[1:][side[moving][1:] != side[moving][:-1]]


def _stiffness(all_samples: Sequence[Samples], level: float) -> float | None:
    """Median slope of force against displacement from a reversal until the force has changed by half the level."""
    slopes = []
    for sample in all_samples:
        displacement, reversals = sample.displacement, turns(np.sign(sample.velocity))
        for turn, following in itertools.pairwise([*reversals, len(sample) - 1]):
            change = np.abs(sample.force[turn : following + 1] - sample.force[turn])
            reached = np.flatnonzero(change >= 0.5 * level)
            if len(reached):
                path = abs(displacement[turn + reached[0]] - displacement[turn])
                if path > 0:
                    slopes.append(change[reached[0]] / path)
    return float(np.median(slopes)) if slopes else None


def _drop_speed(velocity: np.ndarray, force: np.ndarray, speed: float, level: float) -> float | None:
    """Speed at which the force has lost half of its excess over the level, from medians over bins of speed.

    None where friction does not drop by more than 5 % of the level.
    """
    sliding = (np.sign(velocity) * force > 0.5 * level) & (np.abs(velocity) > 1e-4 * speed)
    if sliding.sum() < 40:
        return None
    edges = np.quantile(np.abs(velocity[sliding]), np.linspace(0, 1, 21))
    places = np.clip(np.searchsorted(edges, np.abs(velocity[sliding])) - 1, 0, 19)
    filled = np.unique(places)
    medians = np.array([np.median(np.abs(force[sliding][places == i])) for i in filled])
    centres = 0.5 * (edges[1:] + edges[:-1])[filled]
    top = int(np.argmax(medians))
    excess = medians - medians[top:].min()
    if excess[top] < 0.05 * level:
        return None
    below = np.flatnonzero((np.arange(len(medians)) > top) & (excess <= 0.5 * excess[top]))
    return float(centres[below[0]]) if len(below) else None
