"""What a fit found: parameters with intervals, errors by record, and what the data do not determine."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.friction.law import Law
from vibrocap.identification.inference.identifiability import Identifiability, Verdict
from vibrocap.identification.inference.uncertainty import Uncertainty
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.identification.search.loss import Loss, Minimum, SearchStatus
from vibrocap.identification.search.multistart import Start


@dataclasses.dataclass(frozen=True)
class FittedParameter:
    """One parameter: value, 95 % interval [low, high] (0, -inf or inf at an end that the data leave open), verdict.

    unit: of the data, in SI. standard_error: from the covariance, in that unit. curve: (value, rise) of the profile;
    the interval ends where the rise reaches `threshold`.
    """

    name: str
    symbol: str
    meaning: str
    unit: str
    value: float
    low: float
    high: float
    standard_error: float
    verdict: Verdict
    curve: tuple[tuple[float, float], ...] = ()
    threshold: float = math.nan

    @property
    def determined(self) -> bool:
        """Whether the data determine it."""
        return self.verdict == Verdict.DETERMINED

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high


@dataclasses.dataclass(frozen=True, eq=False)
class RecordResult:
    """How a fit does on one record: measured and predicted force [n] in N over time [n] in s.

    relative_rmse: root mean square error over the standard deviation of the measured force, so that 1 is what a
    constant force would reach. held_out: the fit did not see this record. correlation_time: of the errors, in samples.
    """

    name: str
    held_out: bool
    time: np.ndarray
    velocity: np.ndarray
    measured: np.ndarray
    predicted: np.ndarray
    rmse: float
    relative_rmse: float
    correlation_time: float


@dataclasses.dataclass(frozen=True, eq=False)
class Fit:
    """A friction law fitted to records.

    law: with the fitted parameters, ready for a case; None where every start failed (`status` says why)
    parameters: of the law, searched ones and held ones; nuisances: of the measurement (offset, mass, states at start)
    records: results by record, the held-out ones last
    relative_rmse: over all fitted records together, root mean square error over the standard deviation of the force;
    held_out_relative_rmse: the same over the held-out ones, NaN where there are none
    samples, effective_samples: number of samples, and of independent ones (see `uncertainty`)
    cost, unit: least cost and its unit s^2 (see `uncertainty`)
    starts: where the search began and ended; seconds: time it took; options: how the fit was asked for
    problem: what was minimised, for profiles, bootstraps and designs that start from here
    """

    law: Law | None
    law_name: str
    status: SearchStatus
    parameters: tuple[FittedParameter, ...]
    nuisances: tuple[FittedParameter, ...]
    records: tuple[RecordResult, ...]
    relative_rmse: float
    rmse: float
    held_out_relative_rmse: float
    samples: int
    effective_samples: float
    cost: float
    unit: float
    identifiability: Identifiability | None
    starts: tuple[Start, ...]
    seconds: float
    options: Mapping[str, Any]
    problem: "Problem | None" = None

    @property
    def ok(self) -> bool:
        """Whether a law was found."""
        return self.law is not None

    def __getitem__(self, name: str) -> FittedParameter:
        for parameter in (*self.parameters, *self.nuisances):
            if parameter.name == name:
                return parameter
        raise KeyError(f"{name!r}; there are {', '.join(p.name for p in (*self.parameters, *self.nuisances))}")

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the law's searched parameters."""
        return tuple(p.name for p in self.parameters if p.verdict != Verdict.HELD)

    def summary(self) -> str:
        """The fit as text, for a terminal."""
        from vibrocap.identification.result.fit_summary import summary

        return summary(self)

    def save(self, folder: Any, scales: Any = None) -> tuple[Any, Any]:
        """Write fit.json and friction.toml (a [friction] section for a case file) into a folder; their paths.

        scales: `Scales` of the pendulum of the case, which is dimensionless; None: friction.toml is in SI, as fitted.
        """
        from vibrocap.identification.result.saving import save

        return save(self, folder, scales)


@dataclasses.dataclass(frozen=True, eq=False)
class Problem:
    """What a fit minimised: the prediction on all samples and on few, the loss, the minimum and its uncertainty.

    Of a law whose force jumps, without the samples beside jumps (see `jumps`): its minimum is a little off the fit's.
    """

    prediction: Prediction
    draft: Prediction
    loss: Loss
    best: Minimum
    uncertainty: Uncertainty


def relative_rmse(measured: Sequence[np.ndarray], predicted: Sequence[np.ndarray]) -> tuple[float, float]:
    """(relative, absolute) root mean square error of all records together.

    Relative is over the standard deviation of the measured force about its mean: sqrt(1 - R^2) of the regression.
    """
    if not measured:
        return math.nan, math.nan
    force = np.concatenate(measured)
    rmse = float(np.sqrt(np.mean((np.concatenate(predicted) - force) ** 2)))
    return rmse / float(np.std(force)), rmse
