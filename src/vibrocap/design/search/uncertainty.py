"""Uncertain quantities of machine, friction, ground or drive, and samples of them.

A fit leaves the parameters of a friction law uncertain jointly. Near its minimum it knows combinations of parameters,
prod p_i^e_i, each with a standard deviation s of its logarithm (`identifiability`). They are orthogonal there, so

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
from vibrocap.design.search.variables import FACTOR, factored, twice
from vibrocap.inputs import read_input
from vibrocap.physics.dimensions.conversion import quantity, quantity_in_si
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.system import System
from vibrocap.studies.plan.variation import path_complaints

PREFIX = "fit:"  # before the name of a file fit.json
LARGEST = 2**28  # bytes of it
APART = 1e-3  # relative difference from which a value of the case is not that of the fit


def _combinations_of_fit(
    system: System, section: str, fitted: str, parameters: Sequence[tuple], directions: Sequence[tuple]
) -> "list[Uncertain] | Complaint":
    """What a fit of the law in a section (friction, friction_2, ...) leaves uncertain, or what is wrong.

    fitted: name of the law; parameters: (name, value, unit); directions: (exponents by name, deviation)
    """
    from scipy import stats

    law = system.parts.get(section)
    if law is None or not section.startswith("friction"):
        sections = ", ".join(part for part in system.parts if part.startswith("friction"))
        return Complaint(section, f"has no fitted law; give the fit for {sections}")
    if fitted != law.name:
        return Complaint(section, f"is {law.name!r} in the case, and {fitted!r} in the fit")
    if not directions:
        return Complaint(section, "should be a fit with intervals; this one has determined nothing")
    for name, value, unit in parameters:
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
        nominal = tuple(float(system.parameter(path)) for path in paths)
        name, deviation = f"{section}: {words}", float(deviation)
        law, record = stats.lognorm(deviation), f"{name}=lognormal:1:{deviation!r}"
        combinations.append(Uncertain(paths, law, record, nominal, tuple(moving.values()), name))
    return combinations


def _read(record: Mapping[str, Any]) -> Any:
    """A posterior, or what `_combinations_of_fit` wants of a fit, from its record in a file."""
    if {"law_name", "units", "settled"} <= {*record}:
        return SimpleNamespace(**{**record, "values": np.array(record["values"], dtype=float)})
    directions, parameters = [], []
    for row in (record["identifiability"] or {"directions": []})["directions"]:
        directions.append(({str(name): float(e) for name, e in row["exponents"].items()}, row["deviation"]))
    for row in record["parameters"]:
        value = row["value"] if isinstance(row["value"], dict) else {"value": row["value"], "unit": "1"}
        parameters.append((row["name"], float(value["value"]), value["unit"]))
    return str(record["law_name"]), parameters, directions


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


def _joint(system: System, key: str, asked: Any) -> "Sequence[Uncertain] | Complaint | None":
    """What a posterior or a fit says of the law in the section `key`, or of a case; or what is wrong; None for neither.

    Either is given as it is or as "fit:FILE.json", as `vibrocap fit --out` writes it.
    """
    known: Any = asked
    if isinstance(asked, str) and asked.startswith(PREFIX):
        path = asked.removeprefix(PREFIX)
        try:
            known = _read(json.loads(read_input(path, LARGEST)))
        except OSError as error:
            return Complaint(key, f"{shown(path)} cannot be read ({error.strerror or error})")
        except (ValueError, KeyError, TypeError, AttributeError):
            return Complaint(key, f"{shown(path)} is no fit.json as `vibrocap fit --out` writes it")
    elif hasattr(known, "identifiability"):
        directions = known.identifiability.directions if known.identifiability is not None else ()
        parameters = [(parameter.name, parameter.value, parameter.unit) for parameter in known.parameters]
        known = known.law_name, parameters, [(one.exponents, one.deviation) for one in directions]
    elif not (hasattr(known, "law_name") and hasattr(known, "coordinates")):
        return None
    if isinstance(known, tuple):
        return _combinations_of_fit(system, key, *known)
    drawn = _drawn_quantity(system, key, known)
    return drawn if isinstance(drawn, Complaint) else [drawn]


def _drawn_quantity(system: System, key: str, posterior: Any) -> Drawn | Complaint:
    """The samples of a posterior, of the law in the section `key`, or of a case that was fitted; or what is wrong."""
    from scipy import stats

    if not posterior.settled:
        return Complaint(key, "the chain of samples is shorter than fifty correlation times: it gives no distribution")
    if posterior.law_name and (key not in system.parts or system.parts[key].name != posterior.law_name):
        return Complaint(key, f"should be the section of the law {posterior.law_name!r}, the law of the samples")
    known = [info.name for info in parameter_table(system.parts[key])] if posterior.law_name else []
    paths, columns = [], []
    for name, unit, column in zip(posterior.names, posterior.units, posterior.values.T, strict=True):
        if posterior.law_name and name in known:
            place = quantity_in_si(f"{key}.{name}", system)
        elif posterior.law_name or name.startswith(("start[", "drive.")):
            continue  # of the measurement, or a start
        elif "," in name:
            advice = "its samples are a factor of values that they do not hold; give distributions of these parameters"
            return Complaint(name, f"is shared by several parameters of the fitted case: {advice}")
        elif wrong := path_complaints([name], [system.parts], system.units):
            return Complaint(key, f"the samples are of another case: {wrong[0]}")
        else:
            place = quantity(name, system)
            place = quantity_in_si(place.plain, system) if place.unit == "1" else place
        if unit != place.unit:
            case, fit = ("without unit" if of == "1" else f"in {of}" for of in (place.unit, unit))
            return Complaint(place.path, f"is {case} in the case, and {fit} in the fit")
        paths.append(place.path)
        columns.append(column)
    draws = np.array(columns).T
    digest = hashlib.sha256(np.ascontiguousarray(draws).tobytes()).hexdigest()[:16]
    return Drawn(tuple(paths), stats.uniform(), f"samples {digest}", label=f"posterior of {key}", draws=draws)


def uncertain_quantities(
    system: System, asked: Any, complaints: Complaints, own: bool = False
) -> tuple[Uncertain, ...]:
    """The uncertain quantities that `uncertain` of `robustness` or `optimise` describes; complaints are added.

    own: whether they are quantities of one's own, by name, which are no parameters of the system
    """
    if not isinstance(asked, Mapping) or not asked:
        such_as = "such as machine.damping=0.9:1.1"
        complaints.add("uncertain", f"should name at least one quantity with its distribution, {such_as}")
        return ()
    wrong = Complaints()
    quantities = _quantities(system, asked, wrong, own)
    complaints += [Complaint("uncertain", text) for text in wrong]
    return quantities


def _quantities(system: System, asked: Mapping[Any, Any], complaints: Complaints, own: bool) -> tuple[Uncertain, ...]:
    """The same of what is asked by name; each complaint begins with a name."""
    quantities: list[Uncertain] = []
    named: list[str] = []
    for key, text in asked.items():
        paths, factor, law, wrong = factored(key, text)
        if own:
            one = _quantity(system, (str(key),), factor, law)
            if not isinstance(one, str) and not str(key).isidentifier():
                one = "should be a name such as 'mu', as it is an argument of `through`"
        elif (joint := _joint(system, ",".join(paths), text)) is not None:
            one = joint
            named += [] if isinstance(joint, Complaint) else dict.fromkeys(path for x in joint for path in x.paths)
        else:
            named += paths
            if kinds := [path for path in paths if is_kind(path) or path.startswith("initial.")]:
                complaints.add(kinds[0], "is no uncertain quantity; give the path of a number")
                continue
            complaints += [*wrong, *path_complaints(paths, [system.parts], system.units)]
            for path in paths if not complaints else ():
                if not is_number(system.parameter(path)):
                    got = shown(system.parameter(path))
                    complaints.add(path, f"should be a number to be uncertain, got {got}")
            if complaints:
                continue
            one = _quantity(system, paths, factor, law)
        if isinstance(one, Complaint):
            complaints.append(one)
        elif isinstance(one, str):
            complaints.add(str(key) if own else ",".join(paths), one)
        else:
            quantities += [one] if isinstance(one, Uncertain) else one
    if not complaints and (again := twice([*named], system)):
        complaints.add(again[0], "is given twice; give it once")
    return tuple(quantities)


def _quantity(system: System, paths: tuple[str, ...], factor: bool, asked: Any) -> Uncertain | str:
    """An uncertain quantity, or what is wrong with its distribution; factor: whether that is of a factor."""
    words = asked if isinstance(asked, str) else type(asked).__name__
    if not isinstance(asked, str) and isinstance(asked, Sequence) and len(asked) == 2 and all(map(is_number, asked)):
        words = asked = f"{asked[0]!r}:{asked[1]!r}"
    law = _distribution(asked) if isinstance(asked, str) else asked if hasattr(asked, "ppf") else None
    if law is None or isinstance(law, str):
        return law or f"should be {FORM}, a pair of ends, or a distribution of scipy.stats, got {shown(asked)}"
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
    for i, one in enumerate(quantities):  # combinations of a fit share their paths: each multiplies what is there
        samples |= one.columns(shares[:, i], {**own, **samples})
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
        values = np.array([*sampled(self.quantities, self.points).values()])
        digest = hashlib.sha256(values.tobytes()).hexdigest()
        return [self.criterion, str(len(self)), *(quantity.words for quantity in self.quantities), digest]


def samples_of(quantities: Sequence[Uncertain], samples: int, criterion: str) -> Samples:
    """The samples of a search: Sobol points, and for the worst of a box of few dimensions its corners besides."""
    points = sample_points(len(quantities), samples, 0)
    bounded = all(np.all(np.isfinite(quantity.distribution.support())) for quantity in quantities)
    if criterion == "worst" and bounded and 2 ** len(quantities) <= MOST_CORNERS:
        points = np.concatenate([np.array(list(itertools.product((0.0, 1.0), repeat=len(quantities)))), points])
    return Samples(tuple(quantities), points, criterion)
