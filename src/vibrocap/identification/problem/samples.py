"""Samples: the columns of records as a fit uses them, on their own clock, thinned where a draft is enough."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.records.checks import integral
from vibrocap.records.preparation import prepared

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
        if every <= 1:
            return self
        blocks = len(self) // every

        def means(column: Any) -> Any:
            if np.ndim(column) == 0:
                return column
            return np.ascontiguousarray(np.asarray(column)[: blocks * every].reshape(blocks, every).mean(axis=1))

        return dataclasses.replace(self, **{name: means(getattr(self, name)) for name in COLUMNS})

    def between(self, start: int, stop: int) -> "Samples":
        return self.kept(slice(start, stop))

    def kept(self, which: Any) -> "Samples":
        """The samples of a slice or a mask."""
        columns = {name: getattr(self, name) for name in COLUMNS}
        return dataclasses.replace(self, **{name: x[which] for name, x in columns.items() if np.ndim(x)})


def samples(record: Any, load: float | None = None) -> Samples:
    """The samples of a `Record`; velocity is made from displacement where it was not measured.

    load: normal force in N for a record that does not know its own.
    """
    if isinstance(record, Samples):
        return record
    velocity_made = record.velocity is None
    if record.velocity is None or record.acceleration is None:
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
    for sample in all_samples:
        every = max(1, total // target)
        while every > 1 and _motion_lost(sample, every) > MOTION_LOST:
            every = max(1, every * 2 // 3)
        thinned.append(sample.thinned(every))
    return thinned


def _motion_lost(full: Samples, every: int) -> float:
    """Relative root mean square of the velocity's change when thinned samples are joined by straight lines."""
    thin = full.thinned(every)
    if len(thin) < FEWEST_SAMPLES:
        return np.inf
    change = np.interp(full.time, thin.time, thin.velocity) - full.velocity
    return float(np.sqrt(np.mean(change**2) / np.mean(full.velocity**2)))
