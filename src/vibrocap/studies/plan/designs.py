"""Designs: runs spread over ranges, by chance or so that they fill the space evenly."""

import dataclasses
import functools
import math
import warnings
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np

from vibrocap.arguments import Complaint, Complaints, check_whole, is_number, shown, suggestion
from vibrocap.case.sections import is_kind
from vibrocap.studies.plan.runs import Block, Runs, end_complaints, range_of

# kind: most runs. A Sobol sequence has that many points; a Latin hypercube has to be drawn as a whole.
KINDS_OF_DESIGN = {"sobol": 2**30, "halton": 2**40, "latin-hypercube": 10**7, "random": 2**60}


@dataclasses.dataclass(frozen=True)
class Design:
    """How to spread runs over ranges.

    kind: "sobol" or "halton" (low discrepancy, scrambled by the seed: any further runs fill the gaps; a power of two
    suits Sobol best), "latin-hypercube" (each quantity evenly, in random company), "random" (independent).
    runs: how many. seed: the same seed gives the same runs.
    """

    kind: str
    runs: int
    seed: int = 0

    def complaints(self) -> list[str]:
        complaints = Complaints()
        if self.kind not in KINDS_OF_DESIGN:
            complaints.add("design.kind", f"there is no {shown(self.kind)}; {suggestion(self.kind, KINDS_OF_DESIGN)}")
        with complaints.collected():
            check_whole("design.runs", self.runs, 1, KINDS_OF_DESIGN.get(str(self.kind), 2**60))
        with complaints.collected():
            check_whole("design.seed", self.seed, 0, 2**63 - 1)
        return complaints


@dataclasses.dataclass(frozen=True)
class Range:
    """What varies, by its path, between which ends; even in the logarithm where it is `logarithmic`."""

    path: str
    low: float
    high: float
    logarithmic: bool = False

    is_text: ClassVar = False

    def at(self, share: np.ndarray) -> np.ndarray:
        if not self.logarithmic:
            return self.low + (self.high - self.low) * share
        # one by one: an array's exponential may depend, in the last digit, on where in the array a number stands
        start, width = math.log(self.low), math.log(self.high) - math.log(self.low)
        return np.array([min(max(math.exp(start + width * x), self.low), self.high) for x in share.tolist()])

    def slope(self, share: float) -> float:
        """d(value)/d(share)."""
        if not self.logarithmic:
            return self.high - self.low
        ratio = math.log(self.high / self.low)
        return ratio * math.exp(math.log(self.low) + ratio * share)


@dataclasses.dataclass(frozen=True)
class Drawn(Runs):
    """The runs of a design over ranges, along the dimension "run"."""

    design: Design
    ranges: tuple[Range, ...]

    kind = "design"
    dim = "run"

    @property
    def varied(self) -> tuple[Range, ...]:
        return self.ranges

    @property
    def shape(self) -> tuple[int, ...]:
        return (self.design.runs,)

    def values(self, block: Block) -> dict[str, np.ndarray]:
        """Values of the runs in a block: for each run the same, whatever the block."""
        start, stop, _ = block[0].indices(self.design.runs)
        shares = _shares(self.design, len(self.ranges), start, stop)
        return {drawn_range.path: drawn_range.at(shares[:, i]) for i, drawn_range in enumerate(self.ranges)}

    def record(self) -> dict[str, Any]:
        ranges = [dataclasses.asdict(drawn_range) for drawn_range in self.ranges]
        return {"kind": self.kind, "design": dataclasses.asdict(self.design), "ranges": ranges}

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> "Drawn":
        return cls(Design(**record["design"]), tuple(Range(**drawn_range) for drawn_range in record["ranges"]))


def range_from(path: str, asked: Any) -> tuple[Range, list[str]]:
    """The range that text LOW:HIGH or log:LOW:HIGH, or a pair of numbers, describes, and what is wrong with it."""
    nothing = Range(path, 0.0, 1.0)
    if is_kind(path):
        return nothing, [Complaint(path, "a design spreads numbers; run a study for each kind")]
    if isinstance(asked, str):
        ends, complaints = range_of(asked, counted=False)
        ranged = nothing if ends is None else Range(path, *ends[:3])
        return ranged, [Complaint(path, complaint) for complaint in complaints]
    pair = list(asked) if isinstance(asked, (tuple, list, np.ndarray)) else []
    if len(pair) != 2 or not all(map(is_number, pair)):
        return nothing, [Complaint(path, f"a design needs a range, (low, high) or LOW:HIGH, got {shown(asked)}")]
    low, high = float(pair[0]), float(pair[1])
    complaints = end_complaints(low, high, False, (low, high))
    return Range(path, low, high), [Complaint(path, complaint) for complaint in complaints]


def _shares(design: Design, dimensions: int, start: int, stop: int) -> np.ndarray:
    """Points start to stop of a design in the unit cube: array [points, dimensions]."""
    from scipy.stats import qmc

    if design.kind == "random":
        stream = np.random.PCG64(design.seed)
        stream.advance(start * dimensions)  # one draw per number
        return np.random.Generator(stream).random((stop - start, dimensions))
    if design.kind == "latin-hypercube":
        return _hypercube(design, dimensions)[start:stop]
    engine = qmc.Sobol if design.kind == "sobol" else qmc.Halton
    sequence = engine(dimensions, scramble=True, rng=np.random.default_rng(design.seed))
    with warnings.catch_warnings():  # that a block is no power of two does not matter, the study is what is balanced
        warnings.simplefilter("ignore", UserWarning)
        if start:
            sequence.fast_forward(start)
        return sequence.random(stop - start)


@functools.lru_cache(maxsize=1)
def _hypercube(design: Design, dimensions: int) -> np.ndarray:
    from scipy.stats import qmc

    return qmc.LatinHypercube(dimensions, rng=np.random.default_rng(design.seed)).random(design.runs)
