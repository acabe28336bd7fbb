"""Trust: whether a number may be derived from a motion, decided in one place.

A motion that did not finish, is not certified or has not settled has numbers, but no direction of travel, slope, index,
interval or optimum; nor has a number that is smaller than its residue, what the motion may still be away from the
steady one. The record is made where the motions are made and goes with their results.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np

from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.status import Status
from vibrocap.numerics.expressions.graph import evaluated
from vibrocap.physics.system import System

RESIDUE = 10.0  # thresholds of settling by which a measure of a settled motion may be off, over its natural size
ZERO = 1e-6  # of travel without units: none where motions were not to settle, so that their residue is not known
NOT_SETTLED = "not settled"
TRAVEL = ("mean_velocity", "drift", "displacement")  # measures with a direction, which the mirror image turns
FINISHED, NOT_CERTIFIED = (list(Status).index(status) for status in (Status.FINISHED, Status.NOT_CERTIFIED))


@dataclasses.dataclass(frozen=True)
class Trust:
    """Whether numbers may be derived from motions; every field a number for one motion or an array [runs].

    status: index into list(Status); a run that finished without a certificate has that of "not certified"
    settled: whether it has settled; None where the question is not about a steady motion
    residue: how far a measure of the motion may be from that of the steady one; 0 of a closed orbit
    """

    status: Any
    settled: Any = None
    residue: Any = 0.0

    @classmethod
    def of_runs(cls, runs: Mapping[str, Any], residue: Any = 0.0) -> "Trust":
        """Of the runs of an ensemble that were to settle, by their columns "status" and "settled"."""
        return cls(np.asarray(runs["status"]), np.asarray(runs["settled"], dtype=bool), residue)

    @property
    def finished(self) -> Any:
        return (self.status == FINISHED) | (self.status == NOT_CERTIFIED)

    @property
    def ok(self) -> Any:
        """Whether numbers may be derived: finished, certified and, where it counts, settled."""
        good = np.asarray(self.status) == FINISHED
        return good if self.settled is None else good & np.asarray(self.settled, dtype=bool)

    def known(self, values: Any) -> Any:
        """The values, NaN where they are not to be trusted."""
        return np.where(self.ok, values, np.nan)

    def direction(self, values: Any) -> Any:
        """+1, 0 (not larger than the residue) or -1; NaN where a value is not to be trusted."""
        known = self.known(values)
        return np.where(np.abs(known) <= self.residue, 0.0, np.sign(known))

    def differ(self, values: Any) -> bool:
        """Whether all values are finite, to be trusted and differ by more than their residues: so have a variance."""
        good = bool(np.all(self.ok)) and bool(np.all(np.isfinite(values)))
        return good and bool(np.ptp(values) > 2.0 * np.max(self.residue))

    def doubt(self, run: Any) -> str:
        """Why the numbers of a run are not to be trusted: its status, or "not settled"; empty where they are."""
        if self.status[run] != FINISHED:
            return list(Status)[self.status[run]].value
        return "" if self.ok[run] else NOT_SETTLED

    @property
    def doubts(self) -> dict[str, float]:
        """Share of the runs by the reason why they are not to be trusted; empty where all are."""
        words = [self.doubt(run) for run in np.flatnonzero(~self.ok)]
        return {word: words.count(word) / len(self.ok) for word in sorted(set(words))}

    def __getitem__(self, runs: slice) -> "Trust":
        settled = None if self.settled is None else self.settled[runs]
        return Trust(self.status[runs], settled, np.broadcast_to(self.residue, self.status.shape)[runs])


def stands_still(changes: Any, threshold: float) -> Any:
    """Whether changes [..., states] over natural sizes are but the residue of motions that settled to a threshold."""
    return np.max(np.abs(changes), axis=-1, initial=0.0) <= RESIDUE * threshold


def residue(system: System, measure: str, threshold: float, parameters: np.ndarray | None = None) -> Any:
    """How far a measure of a run that settled to a threshold may be from that of the steady motion, without units.

    Of travel: RESIDUE thresholds of the natural size of the coordinate that travels, over the period of the drive where
    it is a speed (of that of its rate where nothing drives the system in time), each of the run's own parameters. Of
    other measures 0: their natural size is not known.

    parameters: None, the system's own, which gives a number; or [runs, parameters], which gives an array [runs]
    """
    rows = np.array([parameter_values(system)]) if parameters is None else parameters
    left = np.zeros(len(rows))
    if measure in TRAVEL and system.cyclic is not None:
        recording = equations(system)
        scales = dict(zip(system.state_names, recording.scales, strict=True))
        sizes = scales[system.cyclic], recording.period, scales[system.machine.rate_states[system.cyclic]]
        size, period, speed = evaluated(sizes, 0.0, [], 1.0, rows.T, left.shape)
        if measure == "mean_velocity":
            size = size / period if recording.timed else speed
        left = RESIDUE * threshold * size
    return float(left[0]) if parameters is None else left
