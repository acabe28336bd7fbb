"""Uncertain quantities: what is not known exactly of machine, friction, ground or drive, and samples of it.

What a fit leaves uncertain: the parameters of a friction law jointly, as the data determine them.

Near its minimum a fit knows combinations of parameters, prod p_i^e_i, each with a standard deviation s of its logarithm
(`identifiability`). The combinations are orthogonal in the logarithms, so

    ln p_i = ln p_i0 + sum_k e_ki s_k z_k        with independent normal z_k

is the joint distribution: parameters that the data confuse vary together. It is taken about the values of the case.
"""

import dataclasses
import hashlib
import itertools
import json
import math
from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

from vibrocap.arguments import Complaint, Complaints, is_number, shown
from vibrocap.case.sections import is_kind
from vibrocap.design.search.goal import twice
from vibrocap.design.search.variables import FACTOR, factored
from vibrocap.inputs import read_input
from vibrocap.physics.dimensions.conversion import quantity_in_si
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.system import System
from vibrocap.studies.plan.variation import path_complaints

PREFIX = "fit:"  # before the name of a file fit.json
LARGEST = 2**28  # bytes of it
APART = 1e-3  # relative difference from which a value of the case is not that of the fit


@dataclasses.dataclass(frozen=True)
class Combination:
    """A combination of parameters: paths, powers, and the standard deviation of its logarithm."""

    name: str
    paths: tuple[str, ...]
    powers: tuple[float, ...]
    deviation: float


def is_fit(given: Any) -> bool:
    """Whether the joint uncertainty of a fit is given: a `Fit`, or "fit:FILE.json"."""
    return hasattr(given, "identifiability") or (isinstance(given, str) and given.startswith(PREFIX))


def combinations_of_fit(system: System, section: str, given: Any) -> list[Combination] | Complaint:
    """What a fit of the law in a section (friction, friction_2, ...) leaves uncertain, or what is wrong.

    given: a `Fit`, or "fit:FILE.json" as `vibrocap fit --out` writes it
    """
    law = system.parts.get(section)
    if law is None or not section.startswith("friction"):
        sections = ", ".join(part for part in system.parts if part.startswith("friction"))
        return Complaint(section, f"has no fitted law; give the fit for {sections}")
    known = _read(given)
    if isinstance(known, str):
        return Complaint(section, known)
    if known["law"] != law.name:
        return Complaint(section, f"is {law.name!r} in the case, and {known['law']!r} in the fit")
    directions = known["directions"]
    if not directions:
        return Complaint(section, "should be a fit with intervals; this one has determined nothing")
    for name, value, unit in known["parameters"]:
        place = quantity_in_si(f"{section}.{name}", system)
        own = system.parameter(place.path)
        if unit == place.unit and not math.isclose(own, value, rel_tol=APART):
            advice = "put friction.toml of the fit into the case"
            return Complaint(place.path, f"is {own:g} in the case, and {value:g} in the fit; {advice}")
    combinations = []
    for exponents, deviation in directions:
        moving = {name: e for name, e in exponents.items() if e != 0.0}
        words = " ".join(f"{name}^{e:.2g}" for name, e in moving.items() if abs(e) >= 0.1)
        if deviation is None or not math.isfinite(deviation):
            advice = f"give distributions of {', '.join(moving)} instead"
            return Complaint(section, f"the data of the fit do not determine {words}; {advice}")
        paths = tuple(quantity_in_si(f"{section}.{name}", system).path for name in moving)
        combinations.append(Combination(f"{section}: {words}", paths, tuple(moving.values()), float(deviation)))
    return combinations


def _read(given: Any) -> dict[str, Any] | str:
    """Law, parameters as (name, value, unit) and directions as (exponents, deviation) of a fit, or what is wrong."""
    if not isinstance(given, str):
        report = given.identifiability
        return {
            "law": given.law_name,
            "parameters": [(parameter.name, parameter.value, parameter.unit) for parameter in given.parameters],
            "directions": []
            if report is None
            else [(direction.exponents, direction.deviation) for direction in report.directions],
        }
    path = given.removeprefix(PREFIX)
    try:
        record = json.loads(read_input(path, LARGEST))
        report = record["identifiability"] or {"directions": []}
        return {
            "law": str(record["law_name"]),
            "parameters": [(parameter["name"], *_with_unit(parameter["value"])) for parameter in record["parameters"]],
            "directions": [
                (_numbers(direction["exponents"]), direction["deviation"]) for direction in report["directions"]
            ],
        }
    except OSError as error:
        return f"{shown(path)} cannot be read ({error.strerror or error})"
    except (ValueError, KeyError, TypeError):
        return f"{shown(path)} is no fit.json as `vibrocap fit --out` writes it"


def _with_unit(given: Any) -> tuple[float, str]:
    """A number of a JSON record, and its unit."""
    return (float(given["value"]), given["unit"]) if isinstance(given, dict) else (float(given), "1")


def _numbers(given: Mapping[str, Any]) -> dict[str, float]:
    return {str(name): float(value) for name, value in given.items()}


FORM = (
    "LOW:HIGH, normal:MEAN:DEVIATION or lognormal:MEDIAN:SIGMA, with factor: before it for factors of the case's own, "
    "or for a law fit:FILE.json"
)


@dataclasses.dataclass(frozen=True)
class Uncertain:
    """One uncertain quantity.

    paths: of the parameters that it sets, as they were given; several share one factor
    distribution: a frozen one of `scipy.stats`, of the values or of the factor; words: it and the paths in a line
    nominal: values of the system itself, by path, which a factor multiplies; empty where it is none
    powers: of the factor, by path, where it is not the factor itself; label: what it is called, by default its paths
    """

    paths: tuple[str, ...]
    distribution: Any = dataclasses.field(compare=False)
    words: str
    nominal: tuple[float, ...] = ()
    powers: tuple[float, ...] = ()
    label: str = ""

    @property
    def name(self) -> str:
        """What it is called."""
        return self.label or ",".join(self.paths)

    def columns(self, shares: np.ndarray, own: Mapping[str, Any] = {}) -> dict[str, np.ndarray]:
        """Values by path at cumulative probabilities [n] from 0 to 1; own: values in place of the system's."""
        values = np.asarray(self.distribution.ppf(shares), dtype=float)
        if not self.nominal:
            return {self.paths[0]: values}
        known = zip(self.paths, self.nominal, self.powers or (1.0,) * len(self.paths), strict=True)
        return {path: own.get(path, nominal) * values**power for path, nominal, power in known}


@dataclasses.dataclass(frozen=True)
class Drawn(Uncertain):
    """The samples of a posterior, all parameters of each together: a share of their number stands for a sample."""

    draws: np.ndarray = dataclasses.field(kw_only=True, compare=False)

    def columns(self, shares: np.ndarray, own: Mapping[str, Any] = {}) -> dict[str, np.ndarray]:
        """Values by path at shares [n] from 0 to 1."""
        del own
        rows = self.draws[np.minimum((shares * len(self.draws)).astype(int), len(self.draws) - 1)]
        return dict(zip(self.paths, rows.T, strict=True))


def _posterior(given: Any) -> Any:
    """A `Posterior`, given as it is or as "fit:posterior.json"; None where it is none."""
    if not (isinstance(given, str) and given.startswith(PREFIX)):
        return given if hasattr(given, "law_name") and hasattr(given, "coordinates") else None
    try:
        record = json.loads(read_input(given.removeprefix(PREFIX), LARGEST))
        values = np.array(record["values"], dtype=float)
        return SimpleNamespace(**record | {"values": values}) if {"law_name", "units", "settled"} <= {*record} else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def drawn_quantity(system: System, key: str, posterior: Any) -> Drawn | Complaint:
    """The samples of a posterior, of the law in the section `key`, or of a case that was fitted; or what is wrong."""
    from scipy import stats

    if not posterior.settled:
        return Complaint(key, "the chain of the samples is short of fifty correlation times: it tells no distribution")
    if posterior.law_name and (key not in system.parts or system.parts[key].name != posterior.law_name):
        return Complaint(key, f"should be the section of the law {posterior.law_name!r}, of which the samples are")
    known = [info.name for info in parameter_table(system.parts[key])] if posterior.law_name else []
    paths, columns = [], []
    for name, unit, column in zip(posterior.names, posterior.units, posterior.values.T, strict=True):
        if name in known:
            place = quantity_in_si(f"{key}.{name}", system)
            if unit != place.unit:
                case, fit = ("without unit" if each == "1" else f"in {each}" for each in (place.unit, unit))
                return Complaint(place.path, f"is {case} in the case, and {fit} in the fit")
            paths.append(place.path)
        elif not posterior.law_name and "[" not in name and not name.startswith("drive."):
            paths.append(name)
        else:
            continue  # of the measurement, or a start
        columns.append(column)
    draws = np.array(columns).T
    seen = hashlib.sha256(np.ascontiguousarray(draws).tobytes()).hexdigest()[:16]
    return Drawn(tuple(paths), stats.uniform(), f"samples {seen}", label=f"posterior of {key}", draws=draws)


def uncertain_quantities(
    system: System, given: Any, complaints: Complaints, own: bool = False
) -> tuple[Uncertain, ...]:
    """The uncertain quantities that `uncertain` of `robustness` or `optimise` describes; complaints are added.

    own: whether they are quantities of one's own, by name, which are no parameters of the system
    """
    if not isinstance(given, Mapping) or not given:
        complaints.add(
            "uncertain", "should name at least one quantity with its distribution, such as machine.damping=0.9:1.1"
        )
        return ()
    quantities: list[Uncertain] = []
    begun = len(complaints)
    named: list[str] = []
    for key, text in given.items():
        paths, factor, law, wrong = factored(key, text)
        if own:
            quantity = _quantity(system, (str(key),), factor, law)
            if not isinstance(quantity, str) and not str(key).isidentifier():
                quantity = "should be a name such as 'mu', as it is an argument of `through`"
            if isinstance(quantity, str):
                complaints.add(str(key), quantity)
            else:
                quantities.append(quantity)
            continue
        if posterior := _posterior(text):
            joint = drawn_quantity(system, ",".join(paths), posterior)
            if isinstance(joint, Complaint):
                complaints += [joint]
            else:
                named += joint.paths
                quantities.append(joint)
            continue
        if is_fit(text):
            joint = combinations_of_fit(system, ",".join(paths), text)
            if isinstance(joint, Complaint):
                complaints += [joint]
                continue
            named += dict.fromkeys(path for combination in joint for path in combination.paths)
            quantities += [_of_fit(system, combination) for combination in joint]
            continue
        named += paths
        kinds = [path for path in paths if is_kind(path) or path.startswith("initial.")]
        if kinds:
            complaints.add(kinds[0], "is no uncertain quantity; give the path of a number")
            continue
        complaints += [*wrong, *path_complaints(paths, [system.parts], system.units)]
        if len(complaints) == begun:
            complaints += [
                Complaint(path, f"should be a number to be uncertain, got {shown(system.parameter(path))}")
                for path in paths
                if not is_number(system.parameter(path))
            ]
        if len(complaints) == begun:
            quantity = _quantity(system, paths, factor, law)
            if isinstance(quantity, str):
                complaints.add(",".join(paths), quantity)
            else:
                quantities.append(quantity)
    if len(complaints) == begun and (again := twice([*named], system)):
        complaints.add(again, "is given twice; give it once")
    return tuple(quantities)


def _of_fit(system: System, joint: Combination) -> Uncertain:
    """A combination of parameters that a fit leaves uncertain, as a factor with a power for each."""
    from scipy import stats

    nominal = tuple(float(system.parameter(path)) for path in joint.paths)
    words = f"{joint.name}=lognormal:1:{joint.deviation!r}"
    return Uncertain(joint.paths, stats.lognorm(joint.deviation), words, nominal, joint.powers, joint.name)


def _quantity(system: System, paths: tuple[str, ...], factor: bool, given: Any) -> Uncertain | str:
    """An uncertain quantity, or what is wrong with its distribution; factor: whether that is of a factor."""
    if isinstance(given, str):
        law, words = _distribution(given), given
    elif hasattr(given, "ppf"):
        law, words = given, type(given).__name__
    elif isinstance(given, Sequence) and len(given) == 2 and all(map(is_number, given)):
        law, words = _distribution(f"{given[0]!r}:{given[1]!r}"), f"{given[0]!r}:{given[1]!r}"
    else:
        law, words = None, ""
    if law is None or isinstance(law, str):
        return law or f"should be {FORM}, a pair of ends, or a distribution of scipy.stats, got {shown(given)}"
    if factor and not all("." in path for path in paths):
        return "has no value of the system's own to multiply; give its distribution"
    nominal = tuple(float(system.parameter(path)) for path in paths) if factor else ()
    return Uncertain(paths, law, f"{','.join(paths)}={FACTOR if factor else ''}{words}", nominal)


def _distribution(text: str) -> Any:
    """The distribution that a text describes; None where it describes none, a text where its numbers do not suit."""
    from scipy import stats

    kind, _, rest = text.partition(":") if text.startswith(("normal:", "lognormal:")) else ("", "", text)
    try:
        first, second = (float(number) for number in rest.split(":"))
    except ValueError:
        return None
    if not (math.isfinite(first) and math.isfinite(second)):
        return None
    if kind == "":
        if not first < second:
            return f"should have its lower end first, and two different ends, got {text}"
        return stats.uniform(first, second - first)
    if not second > 0.0:
        return f"should have a positive {'deviation' if kind == 'normal' else 'sigma'}, got {second:g}"
    if kind == "normal":
        return stats.norm(first, second)
    return stats.lognorm(second, scale=first) if first > 0.0 else f"should have a positive median, got {first:g}"


def sampled(quantities: Sequence[Uncertain], shares: np.ndarray, own: Mapping[str, Any] = {}) -> dict[str, np.ndarray]:
    """Values [samples] by path at points [samples, quantities] of the unit cube; own: see `Uncertain.columns`."""
    samples: dict[str, np.ndarray] = {}
    for i, quantity in enumerate(quantities):  # combinations of a fit share their paths: each multiplies what is there
        samples |= quantity.columns(shares[:, i], {**own, **samples})
    return samples


def sample_points(quantities: int, samples: int, seed: int) -> np.ndarray:
    """Scrambled Sobol points [samples, quantities] within the unit cube, none of them on its border."""
    from scipy.stats import qmc

    points = qmc.Sobol(quantities, rng=np.random.default_rng(seed)).random(samples)
    return np.clip(points, 1e-12, 1.0 - 1e-12)


MOST_CORNERS = 64  # of a box that are samples of their own
TAIL = 0.1  # share of the worst samples of which "cvar" is the mean
CRITERIA = ("worst", "mean", "cvar")


@dataclasses.dataclass(frozen=True)
class Samples:
    """Samples of uncertain quantities with which every design of a search is run, and what of them counts.

    points: [samples, quantities] of the unit cube, the same for all designs
    criterion: the "worst" sample, their "mean", or the mean of the worst tenth ("cvar", Rockafellar and Uryasev 2000)
    """

    quantities: tuple[Uncertain, ...]
    points: np.ndarray = dataclasses.field(compare=False)
    criterion: str

    def __len__(self) -> int:
        return len(self.points)

    def spread(self, values: Mapping[str, np.ndarray], runs: int) -> dict[str, np.ndarray]:
        """Values [runs] by path, each with all samples: [runs * samples], the samples of one run side by side."""
        many = len(self)
        own = {path: np.repeat(column, many) for path, column in values.items()}
        return own | sampled(self.quantities, np.tile(self.points, (runs, 1)), own)

    def variants(self, design: Mapping[str, Any]) -> list[dict[str, Any]]:
        """The values of a design with each sample."""
        columns = sampled(self.quantities, self.points, design)
        return [{**design, **{path: float(x[k]) for path, x in columns.items()}} for k in range(len(self))]

    def chosen(self, merits: np.ndarray) -> np.ndarray:
        """What counts of merits [..., samples], of which large ones are good; NaN where one of them is."""
        if self.criterion == "mean":
            return np.mean(merits, axis=-1)
        many = 1 if self.criterion == "worst" else math.ceil(TAIL * len(self))
        return np.mean(np.sort(merits, axis=-1)[..., :many], axis=-1) + 0.0 * np.sum(merits, axis=-1)

    @property
    def words(self) -> list[str]:
        """All that decides the samples, for the record of a search."""
        return [self.criterion, str(len(self)), *(quantity.words for quantity in self.quantities)]


def samples_of(quantities: Sequence[Uncertain], samples: int, criterion: str) -> Samples:
    """The samples of a search: Sobol points, and for the worst of a box of few dimensions its corners besides."""
    points = sample_points(len(quantities), samples, 0)
    bounded = all(np.all(np.isfinite(quantity.distribution.support())) for quantity in quantities)
    if criterion == "worst" and bounded and 2 ** len(quantities) <= MOST_CORNERS:
        points = np.concatenate([np.array(list(itertools.product((0.0, 1.0), repeat=len(quantities)))), points])
    return Samples(tuple(quantities), points, criterion)
