"""Identifiability: what the data determine of a law's parameters, what they do not, and which experiment would."""

import dataclasses
import enum
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.identification.inference.intervals import Interval
from vibrocap.identification.problem.parametrisation import role

WIDE = 10.0  # an interval whose ends differ by more than this factor does not determine a positive parameter
LOOSE = 0.5  # standard deviation of the logarithm of a combination from which it counts as undetermined
MEMBER = 0.3  # least share of a parameter in a combination that is named
NO_EFFECT = 1e-9  # change of the errors (root mean square) per e-fold below which a parameter does nothing
ROUNDING = 1e-12  # exponent of a combination that is rounding


class Verdict(enum.StrEnum):
    """What the data say about one parameter.

    Doubted: the data pin it down, but what the errors show (a wrong law, a fault of the data) says that the interval
    does not hold.
    """

    DETERMINED = "determined"
    BOUNDED_ABOVE = "only bounded above"
    BOUNDED_BELOW = "only bounded below"
    WIDE = "loosely determined"
    UNDETERMINED = "not determined"
    NO_EFFECT = "not determined: without effect in these data"
    TOO_FEW = "not determined: too few samples"
    PRIOR = "as known beforehand: the prior outweighs the data"
    DOUBTED = "doubted: the errors are no noise"
    UNTRUSTED = "not determined: not all motions can be trusted"
    HELD = "held"


@dataclasses.dataclass(frozen=True)
class Direction:
    """A combination of parameters, prod p_i^e_i, and the standard deviation of its logarithm (Fisher information).

    exponents: by name, of unit length; determined: whether the deviation is below LOOSE.
    """

    exponents: Mapping[str, float]
    deviation: float

    @property
    def determined(self) -> bool:
        """Whether the data determine this combination."""
        return self.deviation < LOOSE

    @property
    def members(self) -> dict[str, float]:
        """The parameters that it is of."""
        return {name: e for name, e in self.exponents.items() if abs(e) >= MEMBER}

    def __str__(self) -> str:
        largest = max(map(abs, self.members.values()), default=1.0)
        powers = {name: e / largest for name, e in self.members.items()}
        return " ".join(
            f"{name}^{e:.2g}" if not math.isclose(e, 1.0, abs_tol=0.05) else name for name, e in powers.items()
        )


@dataclasses.dataclass(frozen=True)
class Identifiability:
    """What the data determine.

    verdicts: by parameter; directions: combinations, the best determined first; effects: change of the force (root mean
    square, over the force's standard deviation) per e-fold of each parameter; sentences: all of it in words;
    experiments: by parameter that is not determined, what would determine it.
    """

    verdicts: Mapping[str, Verdict]
    directions: tuple[Direction, ...]
    effects: Mapping[str, float]
    sentences: tuple[str, ...]
    experiments: Mapping[str, str]

    in_record = "verdicts sentences experiments directions"

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Parameters that the data leave open on at least one side or within a factor of WIDE, or that are doubted."""
        firm = (Verdict.DETERMINED, Verdict.HELD)
        return tuple(name for name, verdict in self.verdicts.items() if verdict not in firm)


def identifiability(
    law: Any,
    names: Sequence[str],
    slopes: np.ndarray,
    nuisances: np.ndarray,
    unit: float,
    inflation: float,
    intervals: Mapping[str, Interval],
) -> Identifiability:
    """The report for parameters of a law.

    slopes [n, p]: change of the errors per e-fold of each parameter (at a parameter of zero: per its smallest visible
    amount); nuisances [n, q]: change with the nuisance parameters, which take their share of the information first;
    unit, inflation: s^2 and the median correlation time of `uncertainty`; intervals: by name.
    """
    root = math.sqrt(len(slopes))
    effects = {name: float(np.linalg.norm(slopes[:, i]) / root) for i, name in enumerate(names)}
    if nuisances.shape[1]:
        slopes = beside(slopes, nuisances)
    directions = combinations(names, slopes, unit * inflation, NO_EFFECT * root)
    verdicts, sentences, experiments = {}, [], {}
    for name in names:
        telling, one = role(law, name).experiment, intervals[name]
        bounds = one.low, one.high, one.low_open, one.high_open
        verdicts[name] = Verdict.NO_EFFECT if effects[name] < NO_EFFECT else verdict_within(*bounds)
        sentences.append(_sentence(name, telling, verdicts[name], one))
        if verdicts[name] != Verdict.DETERMINED:
            experiments[name] = f"{telling.rstrip(',')} would determine {name}"
    combined = [direction for direction in directions if len(direction.members) > 1]
    firm = [direction for direction in combined if direction.determined]
    for loose in (direction for direction in combined if not direction.determined):
        best = next((other for other in firm if {*other.members} <= {*loose.members}), None)  # of the same parameters
        sentences.append(
            f"The combination {loose} is not determined (its logarithm has a standard deviation of "
            f"{_number(loose.deviation)})" + (f"; the data determine {best}." if best else ".")
        )
    return Identifiability(verdicts, directions, effects, tuple(filter(None, sentences)), experiments)


def beside(slopes: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Slopes [n, p] less what other columns [n, q] explain of them."""
    basis, _ = np.linalg.qr(others)
    return slopes - basis @ (basis.T @ slopes)


def combinations(names: Sequence[str], slopes: np.ndarray, unit: float, least: float) -> tuple[Direction, ...]:
    """Combinations of parameters, the best determined first, of slopes [n, p] by their logarithms.

    unit: variance of an error; least: singular value below which a combination does nothing
    """
    _, singular, right = np.linalg.svd(slopes, full_matrices=False)
    directions = []
    for value, row in zip(singular, right, strict=True):
        row = np.where(np.abs(row) > ROUNDING, row * np.sign(row[np.argmax(np.abs(row))]), 0.0)
        deviation = math.sqrt(unit) / value if value > least else math.inf
        directions.append(Direction(dict(zip(names, row.tolist(), strict=True)), float(deviation)))
    return tuple(directions)


def verdict_within(low: float, high: float, low_open: bool, high_open: bool, whole: Verdict | None = None) -> Verdict:
    """The verdict on an interval, and on which sides it is open; whole: on a closed one, whatever its ends."""
    if low_open or high_open:
        open_ends = {(True, True): Verdict.UNDETERMINED, (False, True): Verdict.BOUNDED_BELOW}
        return open_ends.get((low_open, high_open), Verdict.BOUNDED_ABOVE)
    if whole is not None:
        return whole
    return Verdict.WIDE if low > 0 and high > WIDE * low else Verdict.DETERMINED


def _sentence(name: str, telling: str, verdict: Verdict, interval: Interval) -> str:
    if verdict == Verdict.NO_EFFECT:
        return f"{name} is not determined: it does not change the force here; {telling} would show it."
    if verdict == Verdict.DETERMINED:
        return ""
    experiment = f"{telling} would determine it."
    if interval.limit and verdict in (Verdict.UNDETERMINED, Verdict.BOUNDED_ABOVE, Verdict.BOUNDED_BELOW):
        end = _number(interval.low if interval.high_open else interval.high)
        by = "" if interval.low_open == interval.high_open else f", by {end}"
        return f"{name} is {verdict}{by}: {interval.limit}, beyond which the data pull; {experiment}"
    low, high = _number(interval.low), _number(interval.high)
    reason = {
        Verdict.UNDETERMINED: ": the data agree with any value of the search's range",
        Verdict.BOUNDED_BELOW: f", by {low}: any larger value agrees",
        Verdict.BOUNDED_ABOVE: f", by {high}: any smaller value agrees",
        Verdict.WIDE: f", {low} to {high}",
    }[verdict]
    return f"{name} is {verdict}{reason}; {experiment}"


def _number(value: float) -> str:
    return f"{float(f'{value:.3g}'):g}"
