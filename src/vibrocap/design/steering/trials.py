"""Schedules tried side by side: where each of them leaves a machine, for every sample of what is uncertain."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.design.search.uncertainty import Uncertain, sampled
from vibrocap.measures.ensemble import FINISHED, ensemble
from vibrocap.physics.drives.scheduled import PHASES, scheduled
from vibrocap.physics.system import System

RUN = 1e-9  # tolerance of the runs
MOST_EVENTS = 10_000  # in a period of the drive, of which a schedule has many


@dataclasses.dataclass(frozen=True)
class Ends:
    """Where schedules leave a machine, arrays [schedules, samples]; the first sample is the system itself.

    position: of the cyclic coordinate, NaN where the run failed or is not certified; speed: of the contact that moves
    most, 0 where all stick; work: of the drive
    """

    position: np.ndarray
    speed: np.ndarray
    work: np.ndarray


class Trials:
    """Runs schedules of one system, each with every sample. A schedule is rows (periods of the drive, factor)."""

    def __init__(
        self,
        system: System,
        initial: Mapping[str, float],
        quantities: Sequence[Uncertain],
        points: np.ndarray,
        threads: int | None = None,
    ):
        """system: with its own drive; points: samples [samples, quantities] of the unit cube"""
        self.system, self.initial, self.threads = with_schedule(system, [(1.0, 1.0)]), dict(initial), threads
        drawn = sampled(quantities, points) if quantities else {}
        self.samples = {path: np.append(system.parameter(path), column) for path, column in drawn.items()}
        self.count = 1 + (len(points) if quantities else 0)

    def ends(self, schedules: np.ndarray, at_rest: bool = False) -> Ends:
        """The ends of schedules [schedules, phases, 2]; at_rest: begun at rest, at the place 0."""
        runs = len(schedules)
        over = {path: np.tile(column, runs) for path, column in self.samples.items()}
        for k in range(schedules.shape[1]):
            for i, name in enumerate(("periods", "factor")):
                over[f"drive.{name}_{k + 1}"] = np.repeat(schedules[:, k, i], self.count)
        found = ensemble(
            self.system,
            over,
            measures=["drive_work"],
            initial={} if at_rest else self.initial,
            periods=1,
            window=1,
            tolerance=RUN,
            threads=self.threads,
            max_events_per_period=most_events(schedules),
            final_states=True,
        )
        shape = runs, self.count
        good = found["status"] == FINISHED
        place = found[f"final.{self.system.cyclic}"]
        speeds = [np.abs(found[f"final.{name}"]) for name in self.system.machine.contact_states]
        return Ends(
            np.where(good, place, np.nan).reshape(shape),
            np.max(speeds, axis=0).reshape(shape),
            found["drive_work"].reshape(shape),
        )


def most_events(schedules: Any) -> int:
    """How many events a run over one of these schedules [..., phases, 2] may have."""
    return MOST_EVENTS * math.ceil(np.max(np.sum(np.asarray(schedules)[..., 0], axis=-1)))


def with_schedule(system: System, rows: Sequence[tuple[float, float]]) -> System:
    """A system with its drive on a schedule of rows (periods of the drive, factor).

    Raises ArgumentError for a drive that cannot be scheduled, or one whose machine does not take its jumps.
    """
    kind: Any = scheduled(type(system.drive))
    own = {field.name: getattr(system.drive, field.name) for field in dataclasses.fields(system.drive)}  # type: ignore[arg-type]
    whole = [*rows, *([(0.0, 0.0)] * (len(PHASES) - len(rows)))]
    phases = {f"{name}_{k}": row[i] for k, row in enumerate(whole, 1) for i, name in enumerate(("periods", "factor"))}
    return System.of_parts({**system.parts, "drive": kind(**own, **phases)}, system.units)
