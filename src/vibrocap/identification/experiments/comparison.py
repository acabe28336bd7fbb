"""Laws compared: on the same records, by their held-out error and information criteria; and one matched to another."""

import dataclasses
import math
import time as clock
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.identification.experiments.experiment_design import Motion, checked_range, synthetic_record
from vibrocap.identification.fit import fit, split_records, steady_fit
from vibrocap.identification.fit_result import Fit, FittedParameter, relative_rmse, table
from vibrocap.identification.problem.parametrisation import law_class
from vibrocap.identification.problem.prediction import steady_force
from vibrocap.identification.problem.samples import Samples
from vibrocap.identification.search import SearchStatus
from vibrocap.physics.friction.law import Law
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.ranges import values_between

FEW = 8  # records up to which each one is left out in turn
KEPT = 2 / 3  # of a single record, which is fitted; the rest is held out


@dataclasses.dataclass(frozen=True, eq=False)
class ComparedLaw:
    """One law of a comparison.

    parameters: number of searched ones, those of the measurement included; relative_rmse: of the fit to all records;
    held_out: relative RMSE where the law was not fitted, NaN where that failed; aic, bic: see `compare`, their least
    among the laws is 0; seconds: of all its fits; fit: to all records.
    """

    law: str
    parameters: int
    relative_rmse: float
    held_out: float
    aic: float
    bic: float
    seconds: float
    fit: Fit

    in_record = "law held_out relative_rmse parameters aic bic seconds status fitted"

    @property
    def status(self) -> SearchStatus:
        """How its fit to all records ended."""
        return self.fit.status

    @property
    def fitted(self) -> tuple[FittedParameter, ...]:
        """The parameters of that fit."""
        return self.fit.parameters


@dataclasses.dataclass(frozen=True, eq=False)
class Comparison:
    """Laws ranked by their held-out error, the best first; those that failed stand last.

    method: the held-out data. effective_samples: number of independent samples that the criteria used.
    """

    laws: tuple[ComparedLaw, ...]
    method: str
    effective_samples: float

    @property
    def best(self) -> ComparedLaw:
        """The law with the least held-out error."""
        return self.laws[0]

    def summary(self) -> str:
        """The comparison as text."""
        head = ("law", "held out", "fitted", "parameters", "AIC", "BIC", "time")
        rows = []
        for law in self.laws:
            errors = [f"{100 * x:.1f} %" if math.isfinite(x) else "failed" for x in (law.held_out, law.relative_rmse)]
            criteria = f"{law.aic:+.1f}", f"{law.bic:+.1f}"
            rows.append((law.law, *errors, str(law.parameters), *criteria, f"{law.seconds:.1f} s"))
        over = f"over the least, for {self.effective_samples:.0f} effective samples"
        tail = f"Held out: {self.method}. AIC and BIC: {over}."
        return "\n".join([*table([head, *rows]), "", tail])


@shows_progress("Comparing laws")
def compare(
    records: Any,
    laws: Sequence[Any],
    *,
    held_out: Any = (),
    load: float | None = None,
    progress: Progress = None,
    options: Mapping[str, Mapping[str, Any]] | None = None,
    **settings: Any,
) -> Comparison:
    """Fit several laws to the same records and rank them by the error where they were not fitted.

    held_out: records (or names of some) that no fit sees; without: each record is left out in turn where there are 2
        to 8, the last third of a single record otherwise.
    progress: True for a bar, or a function that is called with the share that is done
    options: settings of `fit` for single laws, by law name; **settings: of `fit` for all.
    With n_eff independent samples, p parameters and the mean square error s^2 (over the records' units)

        AIC = n_eff ln s^2 + 2 p        BIC = n_eff ln s^2 + p ln n_eff                      Akaike 1974, Schwarz 1978

    n_eff is that of the law that fits best: its errors are nearest to noise. It is the same for all laws, as the
    criteria ask for. They hold where the errors are noise; held-out error holds where they are the law's own, too.
    """
    if not laws:
        raise ArgumentError("laws", "there is none to compare")
    names = [law_class(law).name for law in laws]
    for i, name in enumerate(names):
        if name in names[:i]:
            raise ArgumentError("laws", f"{name!r} is given twice")
    fitted, unseen = split_records(records, held_out, load)
    folds, method = _folds(fitted, unseen)
    report = told(progress) or (lambda _: None)
    rows, done, total = [], 0, len(laws) * (1 + len(folds))
    for law, name in zip(laws, names, strict=True):
        begin = clock.perf_counter()
        own = {"intervals": "covariance", **settings, **(options or {}).get(name, {})}
        fits = []
        for visible, hidden in [(fitted, unseen), *folds]:
            fits.append(fit(visible, law, held_out=hidden, **own))
            done += 1
            report(done / total)
        results = [r for r in fits[0].records if r.held_out]
        measured, predicted = [r.measured for r in results], [r.predicted for r in results]
        for part, (_, hidden) in zip(fits[1:], folds, strict=True):
            results = [r for r in part.records if r.held_out]
            measured += [r.measured for r in results] or [record.force for record in hidden]
            predicted += [r.predicted for r in results] or [np.full(len(record), math.nan) for record in hidden]
        rows.append((name, fits[0], relative_rmse(measured, predicted)[0], clock.perf_counter() - begin))
    return _ranked(rows, method)


def _folds(fitted: list[Samples], unseen: list[Samples]) -> tuple[list[tuple[list[Samples], list[Samples]]], str]:
    """(seen, hidden) records of each further fit, and what that is called."""
    if unseen:
        return [], "records " + ", ".join(record.name for record in unseen)
    if len(fitted) == 1:
        (only,) = fitted
        cut = int(KEPT * len(only))
        tail = dataclasses.replace(only.kept(slice(cut, None)), name=f"{only.name}, last third")
        return [([only.kept(slice(cut))], [tail])], "the last third of the record"
    split = [fitted[i::FEW] for i in range(min(FEW, len(fitted)))]
    folds = [([record for record in fitted if record not in hidden], hidden) for hidden in split]
    return folds, "each record in turn" if len(fitted) <= FEW else f"an {FEW}th of the records in turn"


def _ranked(rows: list[tuple[str, Fit, float, float]], method: str) -> Comparison:
    good = [whole for _, whole, _, _ in rows if whole.ok]
    effective = min(good, key=lambda law: law.cost).effective_samples if good else math.nan
    counts = np.array([len(whole.problem.best.u) if whole.problem else 0 for _, whole, _, _ in rows])
    squares = [2.0 * whole.cost / whole.samples if whole.ok else math.nan for _, whole, _, _ in rows]
    terms = np.array([effective * math.log(square) if square > 0 else math.nan for square in squares])
    aic, bic = terms + 2 * counts, terms + counts * math.log(max(effective, 2.0))
    aic, bic = (column - min(column[np.isfinite(column)], default=0.0) for column in (aic, bic))
    compared = [
        ComparedLaw(name, int(counts[k]), whole.relative_rmse, held, float(aic[k]), float(bic[k]), seconds, whole)
        for k, (name, whole, held, seconds) in enumerate(rows)
    ]
    compared.sort(key=lambda law: law.held_out if math.isfinite(law.held_out) else math.inf)
    return Comparison(tuple(compared), method, effective)


CURVE = 400  # points of a matched steady curve
AT_REST = 1e-9  # of the largest speed: rounding


@dataclasses.dataclass(frozen=True, eq=False)
class Match:
    """A law matched to another.

    law: with the parameters that bring it closest to `to`; over: the velocity range or the motion in words
    relative_rmse: root mean square difference over the root mean square of the target's force
    largest: largest difference, in units of the force; where: velocity at which it occurs
    time [n] (empty for a velocity range), velocity [n], target [n], matched [n]: the curves
    """

    law: Law
    to: Law
    over: str
    relative_rmse: float
    largest: float
    where: float
    time: np.ndarray
    velocity: np.ndarray
    target: np.ndarray
    matched: np.ndarray
    fit: Fit


def match(
    law: Any,
    to: Law,
    *,
    velocity: tuple[float, float] | None = None,
    motion: Motion | None = None,
    spacing: str = "even",
    load: float = 1.0,
    free: Iterable[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    starts: int = 8,
    seed: int = 0,
) -> Match:
    """The parameters of a law that bring its force closest to that of another, in least squares.

    The paper compares two laws with parameters that are alike by name; whether they differ as laws shows once one is
    brought as close to the other as it can be.

    law: a law, its class or its name; to: the target, with its parameters
    velocity: (lowest, highest) > 0, where the steady curves are matched, at points of "even" or "logarithmic" spacing
    motion: in place of a velocity: both laws are driven by it from rest
    Parameters that the curves do not show keep the values of `law`. Raises ValueError for input that makes no sense,
    and where the law cannot be driven through the motion.
    """
    if (velocity is None) == (motion is None):
        raise ArgumentError("velocity", "give either a velocity range or a motion")
    if not isinstance(to, Law):
        raise ArgumentError("to", f"should be a friction law with its parameters, got {to!r}")
    how: dict[str, Any] = {"free": free, "fixed": fixed, "starts": starts, "seed": seed, "intervals": "covariance"}
    if motion is not None:
        fitted = fit(synthetic_record(to, motion, load=load), law, start="relaxed", **how)
        over = f"the motion {motion.name}"
    else:
        assert velocity is not None
        low, high = checked_range("velocity", velocity)
        if spacing not in ("even", "logarithmic"):
            raise ArgumentError("spacing", f"should be 'even' or 'logarithmic', got {spacing!r}")
        speeds = values_between(low, high, CURVE, spacing == "logarithmic")
        target = steady_force(to, speeds, load)
        deviation, none = float(np.std(target)) or 1.0, np.zeros(CURVE)
        points = Samples("curve", np.arange(float(CURVE)), speeds, target, none, load, deviation, none)
        fitted = steady_fit([points], law, **how)
        over = f"velocities from {low:g} to {high:g}"
    if fitted.law is None:
        raise ArgumentError("law", f"{fitted.law_name} cannot be matched: {fitted.status}")
    of_record = fitted.records[0]
    time, speeds = np.empty(0) if motion is None else of_record.time, of_record.velocity
    target, matched = of_record.measured, of_record.predicted
    difference = np.abs(matched - target)
    at = int(np.argmax(difference))
    relative = float(np.sqrt(np.mean(difference**2) / np.mean(target**2)))
    where = float(speeds[at]) if abs(speeds[at]) > AT_REST * np.abs(speeds).max() else 0.0
    curves = time, speeds, target, matched
    return Match(fitted.law, to, over, relative, float(difference[at]), where, *curves, fitted)
