"""Terms of a fit, chosen by the error where it was not fitted: each alone and in pairs, one step after the other."""

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.identification.fit import fit, strongest_wave
from vibrocap.identification.fit_result import Chapter, Fit
from vibrocap.identification.inference.uncertainty import correlation_time, inverse
from vibrocap.identification.problem.prediction import ADHESION, DELAY, Prediction, nuisances
from vibrocap.identification.problem.samples import data_scales
from vibrocap.identification.problem.terms import RIPPLES, TERMS, WAVES, checked_terms
from vibrocap.identification.search import finite
from vibrocap.progress import Progress, shows_progress, told
from vibrocap.results import Result

SURE = 3.5  # standard errors of the held-out gain, from which a term is no chance of some fifty tried
BLOCKS = 5  # stretches of a single record, each held out once
BEGIN = 0.1  # share of a held-out record that may tell of its start
MOST = 4  # steps


@dataclasses.dataclass(frozen=True)
class TriedTerms:
    """Terms that were tried: their held-out error over the deviation of the force, and the gain over none of them, in
    its standard errors."""

    terms: tuple[str, ...]
    held_out: float
    gain: float


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class TermChoice(Result):
    """Terms that predict the held-out data, and the fit with them.

    terms: chosen, in the order of choice; tried: the best of each step, the chosen ones first
    """

    terms: tuple[str, ...]
    tried: tuple[TriedTerms, ...]
    fit: Fit

    in_record = "terms tried"

    @property
    def heading(self) -> str:
        return f"terms beside {self.fit.law_name}: {', '.join(self.terms) or 'none'}"

    @property
    def facts(self) -> dict[str, str]:
        return {", ".join(t.terms): f"held out {t.held_out:.2%}, {t.gain:+.1f} standard errors" for t in self.tried}

    @property
    def chapter(self) -> Chapter:
        """What was tried, in words."""
        return Chapter("terms that were tried", ("held out",), list(self.facts.items()))


@shows_progress("Choosing terms")
def choose_terms(
    records: Any, law: Any, *, among: Sequence[str] | None = None, progress: Progress = None, **settings: Any
) -> TermChoice:
    """The terms, of all that the contact may have or of `among`, that lower the held-out error by more than chance.

    Each record in turn is held out, or each fifth of a single one. A step fits law and terms so far, straightens the
    prediction there and solves for all parameters together with each further term and each pair, on what is not held
    out; so gravity is found with inertia where one alone gains nothing. No mass or damping is negative. The step takes
    the single term or, where that is better beyond chance, the pair with the least error, and then really fits it.

    **settings: of `fit`. Returns a `TermChoice`, whose `fit` has the chosen terms.
    """
    report = told(progress) or (lambda _: None)
    settings = {"intervals": "covariance", **settings}
    if "terms" in settings:
        raise ArgumentError("terms", "are chosen here; name the candidates in among")
    terms: list[str] = []
    tried: list[TriedTerms] = []
    best_fit = fit(records, law, terms=terms, **settings)
    for k in range(MOST if best_fit.ok else 0):
        report(k / MOST)
        step = _step(best_fit, terms, among)
        tried += step[:3]
        if not step or not step[0].gain > SURE:
            break
        terms += step[0].terms
        best_fit = fit(records, best_fit.law, terms=terms, **settings)
    return TermChoice(tuple(terms), tuple(tried), best_fit)


def _step(best_fit: Fit, terms: Sequence[str], among: Sequence[str] | None) -> list[TriedTerms]:
    """What further terms gain, that to take first."""
    assert best_fit.problem is not None
    prediction, u = best_fit.problem.prediction, best_fit.problem.best.u
    errors = finite(prediction.errors(u))
    wide, groups = _widened(prediction, errors, terms, among)
    if not groups:
        return []
    point = wide.space.begun(u)
    slopes = np.nan_to_num(wide.slopes(point, errors))
    own = list(range(len(u)))
    counted = np.concatenate([*wide.counts, np.ones(len(wide.priors), bool)])
    folds = [(train & counted, test & counted) for train, test in _folds(wide)]

    def held_out(extra: Sequence[int]) -> np.ndarray | None:
        columns = [*own, *extra]
        negative, left = False, []
        for train, test in folds:
            some = slopes[train][:, columns]
            change = -inverse(some.T @ some) @ (some.T @ errors[train])
            moved = point[columns] + change
            negative |= bool(np.any(moved[len(own) :] < wide.space.low[columns[len(own) :]]))
            left.append(errors[test] + slopes[test][:, columns] @ change)
        return None if negative else np.concatenate(left)

    base = held_out([])
    assert base is not None

    def tried(many: int) -> list[tuple[TriedTerms, np.ndarray]]:
        """(what they gain, held-out errors) of so many terms at once, where these are possible; the best first."""
        fits = []
        for names in itertools.combinations(groups, many):
            if (left := held_out([column for name in names for column in groups[name]])) is not None:
                fits.append((TriedTerms(names, math.sqrt(float(np.mean(left**2))), _gain(base, left)), left))
        return sorted(fits, key=lambda one: one[0].held_out)

    singles, pairs = tried(1), tried(2)
    first = best = next(iter(singles), None)
    if pairs and pairs[0][0].gain > SURE:
        sure = best is None or best[0].gain <= SURE or _gain(best[1], pairs[0][1]) > SURE
        first = pairs[0] if sure else best
    others = sorted((one[0] for one in (*singles, *pairs) if one is not first), key=lambda terms: terms.held_out)
    return [first[0], *others] if first else []


def _gain(before: np.ndarray, after: np.ndarray) -> float:
    """By how much squared errors are less, in standard errors.

    With before = after + d the gain is 2 after d + d^2, of which noise makes the first part alone; its samples are
    correlated as the errors are.
    """
    change = before - after
    product = after * change
    spread = 2.0 * float(np.sqrt(np.mean(product**2)))
    if not spread > 0.0:
        return 0.0
    mean = float(np.mean(before**2 - after**2))
    return mean / spread * math.sqrt(len(product) / correlation_time(product - np.mean(product)))


def _folds(prediction: Prediction) -> list[tuple[np.ndarray, np.ndarray]]:
    """(rows to fit, rows to judge by) of each fold; priors are always fitted."""
    ends, begin = np.cumsum([0, *(len(record) for record in prediction.records)]), BEGIN
    if len(prediction.records) == 1:
        ends, begin = np.linspace(0, prediction.size, BLOCKS + 1).astype(int), 0.0
    folds = []
    for low, high in itertools.pairwise(ends.tolist()):
        test = np.zeros(prediction.size + len(prediction.priors), bool)
        test[low + int(begin * (high - low)) : high] = True
        folds.append((~test, test))
    return folds


def _widened(
    prediction: Prediction, errors: np.ndarray, terms: Sequence[str], among: Sequence[str] | None
) -> tuple[Prediction, dict[str, list[int]]]:
    """The prediction with all further terms at nothing, and the coordinates of each."""
    records = prediction.records
    turning = all(record.rotary for record in records)
    known = [name for name, term in TERMS.items() if term.wave is None and (turning or not term.turning)]
    loads = np.concatenate([np.atleast_1d(record.load) for record in records])
    known += [DELAY, *RIPPLES, *([ADHESION] if np.ptp(loads) > 0.0 else [])]
    candidates = known if among is None else checked_terms(among, known, records)
    candidates = [name for name in candidates if name not in terms]
    waves = {name: strongest_wave(name, prediction, errors) for name in RIPPLES if name in candidates}
    how: dict[str, Any] = {
        "level": data_scales(records).level,
        "lengths": {name: x for name, x in waves.items() if x > 0.0},
    }
    more = nuisances(prediction.template, records, terms=candidates, start="relaxed", **how)
    wide = dataclasses.replace(prediction, space=prediction.space.with_more(more))
    names = wide.space.names
    parts = {name: [f"{name}_{wave}" for wave in WAVES] if name in RIPPLES else [name] for name in candidates}
    return wide, {name: [*map(names.index, of)] for name, of in parts.items() if {*of} <= {*names}}
