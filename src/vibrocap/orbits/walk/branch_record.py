"""What the records of all branches have in common: points over a parameter, special points between them, two ends."""

import collections
import itertools

import numpy as np

from vibrocap.orbits.walk.kinds import BranchEnd, SpecialKind
from vibrocap.orbits.walk.special_points import SpecialPoint
from vibrocap.quantities.dimensional import said
from vibrocap.results import Result


class BranchRecord(Result):
    """A branch in order along it; its subclasses are dataclasses with these fields and those of its points."""

    over: str
    parameter: np.ndarray
    stable: np.ndarray
    special_points: tuple[SpecialPoint, ...]
    ends: tuple[BranchEnd, BranchEnd]

    rows = "special_points"

    def __len__(self) -> int:
        return len(self.parameter)

    @property
    def facts(self) -> dict[str, str]:
        if not len(self):
            return {"points": "no points", "end": self.ends[0].value}
        low, high = np.min(self.parameter), np.max(self.parameter)
        kinds = collections.Counter(special.kind.value for special in self.special_points)
        return {
            "points": f"{len(self)} points from {low:.6g} to {said(high, self.unit_of('parameter'), 6)}",
            "stability": f"{np.mean(self.stable):.0%} of them stable".replace("%", " %"),
            "special points": ", ".join(f"{count} {kind}" for kind, count in kinds.items()) or "no special points",
            "ends": f"begins: {self.ends[0].value}, ends: {self.ends[1].value}",
        }

    @property
    def advice(self) -> tuple[str, ...]:
        return tuple(end.advice for end in self.ends)

    def kind(self, *kinds: SpecialKind) -> tuple[SpecialPoint, ...]:
        return tuple(special for special in self.special_points if special.kind in kinds)

    @property
    def parts(self) -> tuple[tuple[int, int, bool], ...]:
        """(first point, last point, stable) of each stretch of the branch that is all stable or all unstable."""
        if not len(self):
            return ()
        cuts = np.flatnonzero(np.diff(self.stable.astype(int))) + 1
        edges = [0, *cuts.tolist(), len(self)]
        return tuple((first, last - 1, bool(self.stable[first])) for first, last in itertools.pairwise(edges))

    def __str__(self) -> str:
        unit = self.unit_of("parameter")
        if not len(self):
            return f"No {self.heading}: {self.ends[0].advice}"
        lines = [f"{self.heading[:1].upper()}{self.heading[1:]}, {len(self)} points:"]
        for special_point in self.special_points:
            place = f"{said(special_point.parameter, unit, 12)} (error {special_point.error:.0e})"
            lines.append(f"  {special_point.kind.value:20s} {place}  {special_point.remarks}")
        for where, value, end in zip(("begins", "ends"), self.parameter[[0, -1]], self.ends, strict=True):
            lines.append(f"  {where} at {said(value, unit)}: {end.words}")
        return "\n".join(lines)
