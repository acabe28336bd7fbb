"""What a fit found: parameters with intervals, errors by record, text, JSON and a section [friction] of a case file."""

import dataclasses
import json
import math
import platform
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.files import made_folder, write_text
from vibrocap.identification.inference.identifiability import Identifiability, Verdict
from vibrocap.identification.inference.intervals import ReachedLimit
from vibrocap.identification.inference.residuals import ResidualReport
from vibrocap.identification.inference.uncertainty import Problem
from vibrocap.identification.problem.parametrisation import with_values
from vibrocap.identification.search import SearchStatus, Start
from vibrocap.physics.dimensions.scales import PendulumScales
from vibrocap.physics.dimensions.units import force_keys, one_way, parameter_keys, turned
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table
from vibrocap.quantities.declared import AsGiven, Context, NumberInUnit, WithUnit
from vibrocap.quantities.json_text import json_text
from vibrocap.results import Result

IN_SI = """\
# In SI, as fitted: it goes into a case in SI as it is. For a case without units of the pendulum give its mass and
# length (`--pendulum`, or `fit.save(folder, scales=...)`).
"""
FORCES = """\
# The normal force of the records is not known: the levels of the law are forces. A case makes coefficients of them by
# its constant normal_load_N; for other loads fit with the normal force of the records.
"""
TURNING_IN_SI = """\
# In the units of the records, which are SI for a contact that turns: N m, rad, s. No case has such a contact.
"""


def dimensionless(law: Law, scales: PendulumScales, known_load: bool) -> Law:
    """The law that was fitted in SI, in the dimensionless units of a case.

        stiffness l/(m g)     damping l/(m g sqrt(l/g))     velocity sqrt(g l)     length l     coefficients as they are

    known_load: whether coefficients are over the normal force; without it they are forces in N, from which no
    coefficient follows: raises ValueError, as for a parameter that declares neither a role nor a unit.
    """
    values = {}
    for info in parameter_table(law):
        value = getattr(law, info.name)
        if not isinstance(value, float):
            continue
        if info.dimension is None:
            declared = f'as in parameter(..., unit="N s/m"), unit="1" for a pure number, in {type(law).__name__}'
            unknown = "has no known dimension, so that it cannot be converted"
            raise ArgumentError(info.name, f"{unknown}; declare its role or its unit, {declared}")
        if info.dimension.coefficient and not known_load:
            advice = "give the normal force of the records for a law in the units of a case"
            raise ArgumentError("normal_force", f"is not known, so that {info.name} is a force in N; {advice}")
        values[info.name] = value / scales.of(info.dimension)
    return with_values(law, values)


def heading(scales: PendulumScales | None, rotary: bool = False, known_load: bool = True) -> str:
    """Lines of comment that say in which units a section of a case file stands."""
    if rotary:
        return TURNING_IN_SI
    if scales is None:
        return IN_SI + ("" if known_load else FORCES)
    return (
        f"# Dimensionless, for a pendulum of {scales.pendulum_mass_kg:g} kg and {scales.pendulum_length_m:g} m: "
        "forces over its weight, lengths over its length.\n"
    )


def case_section(law: Any, in_si: bool = False, known_load: bool = True) -> str:
    """The section [friction] of a case file, every parameter written out; in SI with its unit.

    known_load: whether coefficients are over the normal force; without it they stand as forces.
    """
    keys = parameter_keys(type(law), "force") if in_si else {}
    forces = {} if known_load or not in_si else {info.name: key for key, info in force_keys(type(law)).items()}
    lines = ["[friction]", f"law = {json.dumps(law.name)}"]
    for info in parameter_table(law):
        value = getattr(law, info.name)
        if value is None:  # a part of the law that is not there
            continue
        key = one_way(keys, info.name)
        text = json.dumps(value, ensure_ascii=False) if isinstance(value, (bool, int, str)) else repr(float(value))
        lines.append(f"{forces.get(info.name, info.name if key is None else key.key)} = {text}")
    return "\n".join(lines) + "\n"


@dataclasses.dataclass(frozen=True)
class MeasuredUnits:
    """What the columns of a fit's records are called and measured in."""

    force_name: str
    force: str
    displacement_name: str
    displacement: str
    velocity_name: str
    velocity: str
    heading: str  # of the force in tables and JSON

    def of_parameter(self, unit: str) -> str:
        """The unit of a parameter of which `unit` is that in N, m and s: N s/m is N m s/rad where the contact turns."""
        return unit if self is SLIDING else turned(unit)


SLIDING = MeasuredUnits("force", "N", "displacement", "m", "velocity", "m/s", "N")
TURNING = MeasuredUnits("torque", "N m", "angle", "rad", "angular velocity", "rad/s", "Nm")


NOTHING = 1e-9  # of an interval's larger end: a number that is rounding


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
    value: NumberInUnit
    low: NumberInUnit
    high: NumberInUnit
    standard_error: NumberInUnit
    verdict: Verdict
    curve: tuple[tuple[float, float], ...] = ()
    threshold: float = math.nan

    in_record = "name symbol meaning value low high standard_error verdict"

    @property
    def determined(self) -> bool:
        return self.verdict == Verdict.DETERMINED

    def __contains__(self, value: float) -> bool:
        return self.low <= value <= self.high


class InForce(AsGiven):
    """A force or a torque, in the unit of the fit's records."""

    def seen(self, value: Any, context: Context) -> Any:
        fit = next(owner for owner in context.around if isinstance(owner, Fit))
        return WithUnit(value, fit.units.force)


MeasuredForce = Annotated[float, InForce()]


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
    rmse: MeasuredForce
    relative_rmse: float
    correlation_time: float

    in_record = "name held_out samples rmse relative_rmse correlation_time"

    @property
    def samples(self) -> int:
        return len(self.time)


@dataclasses.dataclass(frozen=True)
class Chapter:
    """A part of what a fit tells: rows of cells, of which the head names all but the first; or sentences."""

    title: str
    head: tuple[str, ...] = ()
    rows: Sequence[tuple[str, ...]] = ()
    sentences: Sequence[str] = ()

    def lines(self) -> list[str]:
        """As text, for a terminal."""
        if self.rows:
            return table([(self.title, *self.head), *self.rows])
        return [f"{self.title}:", *(f"- {sentence}" for sentence in self.sentences)]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """A friction law fitted to records.

    law: with the fitted parameters, ready for a case; None where every start failed (`status` says why)
    parameters: of the law, searched ones and held ones; nuisances: of the measurement (offset, mass, states at start)
    records: results by record, the held-out ones last
    relative_rmse, held_out_relative_rmse: over all fitted records together, and over the held-out ones (NaN where there
        are none), root mean square error over the standard deviation of the force
    samples, effective_samples: number of samples, and of independent ones; cost, unit: least cost and its unit s^2 (see
        `uncertainty`)
    starts: where the search began and ended; seconds: time it took; options: how the fit was asked for
    limits: at which parameters stand, those of the search included; they open intervals that they would hold closed
    residuals: whether the errors are noise, and if not, what is wrong with the data or the law
    problem: what was minimised, for profiles, bootstraps and designs that start from here

    Two fits are equal if all of this is but the time they took and `problem`, which the other fields follow from.
    """

    law: Law | None
    law_name: str
    status: SearchStatus
    parameters: tuple[FittedParameter, ...]
    nuisances: tuple[FittedParameter, ...]
    records: tuple[RecordResult, ...]
    relative_rmse: float
    rmse: MeasuredForce
    held_out_relative_rmse: float
    samples: int
    effective_samples: float
    cost: float
    unit: float
    identifiability: Identifiability | None
    starts: tuple[Start, ...]
    seconds: float = dataclasses.field(compare=False)
    options: Mapping[str, Any]
    problem: Problem | None = dataclasses.field(default=None, compare=False)
    limits: tuple[ReachedLimit, ...] = ()
    residuals: ResidualReport | None = None

    rows = "parameters"
    in_record = (
        "law_name status units parameters nuisances relative_rmse rmse held_out_relative_rmse samples "
        "effective_samples records identifiability residuals limits starts options seconds provenance"
    )

    @property
    def provenance(self) -> dict[str, str]:
        """Versions of what made it."""
        versions = {name: version(name) for name in ("vibrocap", "numpy", "scipy")}
        return versions | {"python": platform.python_version()}

    @property
    def heading(self) -> str:
        return f"{self.law_name} friction fitted to {len(self.records)} record(s)"

    @property
    def facts(self) -> dict[str, str]:
        if not self.ok:
            return {"status": str(self.status)}
        free = [p for p in self.parameters if p.name in self.free]
        return {
            "error": f"relative RMSE {_percent(self.relative_rmse)} ({self.rmse:.4g} N)",
            "parameters": " ".join(f"{p.name}={number(p.value, 4)}" for p in free),
            "status": str(self.status),
        }

    @property
    def units(self) -> MeasuredUnits:
        """What the records' columns are called and measured in."""
        return TURNING if self.options.get("rotary") else SLIDING

    @property
    def ok(self) -> bool:
        """Whether a law was found."""
        return self.law is not None

    def __getitem__(self, name: str) -> FittedParameter:
        by_name = {parameter.name: parameter for parameter in (*self.parameters, *self.nuisances)}
        if name not in by_name:
            raise KeyError(f"{name!r}; there are {', '.join(by_name)}")
        return by_name[name]

    @property
    def free(self) -> tuple[str, ...]:
        """Names of the law's searched parameters."""
        return tuple(p.name for p in self.parameters if p.verdict != Verdict.HELD)

    @property
    def chapters(self) -> list[Chapter]:
        """What it tells, part by part: parameters, records, what is not determined, errors, limits."""
        head = ("value", "95 % interval", "unit", "")
        records = []
        for r in self.records:
            seen = "held out" if r.held_out else "fitted"
            records.append((r.name, f"{r.samples:,} samples", _percent(r.relative_rmse), seen))
        left = self.identifiability.sentences if self.identifiability is not None else ()
        chapters = (
            Chapter("parameter", head, [_row(parameter) for parameter in self.parameters]),
            Chapter("of the measurement", head, [_row(nuisance) for nuisance in self.nuisances]),
            Chapter("record", ("", "relative RMSE", ""), records),
            Chapter("What these data do not determine", sentences=left),
            Chapter("The errors", sentences=self.residuals.sentences() if self.residuals is not None else ()),
            Chapter("Limits that were reached", sentences=[f"{limit}." for limit in self.limits]),
        )
        return [chapter for chapter in chapters if chapter.rows or chapter.sentences]

    def summary(self) -> str:
        """The fit as text, for a terminal."""
        if not self.ok:
            return f"{self.law_name}: {self.status}"
        head = f"{self.law_name}: {self.status}, relative RMSE {_percent(self.relative_rmse)}"
        head += f" ({self.rmse:.4g} {self.units.force})"
        if not math.isnan(self.held_out_relative_rmse):
            head += f", held out {_percent(self.held_out_relative_rmse)}"
            head += " (worse than a constant)" if self.held_out_relative_rmse >= 1.0 else ""
        parts = [head, *("\n".join(chapter.lines()) for chapter in self.chapters)]
        if hidden := ", ".join(self.options.get("not_shown", ())):
            parts.append(f"The steady curve does not show {hidden}: held at the values that the law came with.")
        if (spring := self.options.get("machine_stiffness")) is not None:
            parts.append(f"Pulled through a spring of {number(spring, 4)} N/m, which was held.")
        if guessed := self.options.get("guessed_units"):
            units = ", ".join(f"{name} in {unit}" for name, unit in guessed.items())
            parts.append(f"Units assumed to be SI, as neither files nor settings give them: {units}.")
        parts.append(
            f"Relative to the standard deviation of the {self.units.force_name}. {self.samples:,} samples, "
            f"{len(self.starts)} starts, {self.seconds:.1f} s."
        )
        return "\n\n".join(parts)

    def save(self, folder: str | Path, scales: PendulumScales | None = None) -> tuple[Path, Path]:
        """Write fit.json and friction.toml into a folder, which is made; their paths.

        scales: of the pendulum in whose units friction.toml is written, as a case without units wants it; None: in SI.
        Raises ValueError where the fit found no law, and for scales where the normal force is not known; WriteError
        where the folder does not take them.
        """
        if self.law is None:
            raise ArgumentError("fit", f"has no law to save; {self.status}")
        rotary, known_load = (bool(self.options.get(name)) for name in ("rotary", "known_load"))
        if scales is not None and rotary:
            raise ArgumentError("scales", "are for a contact that slides; the records are of one that turns")
        law = self.law if scales is None else dimensionless(self.law, scales, known_load)
        folder = made_folder(folder)
        paths = folder / "fit.json", folder / "friction.toml"
        write_text(paths[0], json_text(self) + "\n")
        section = case_section(law, in_si=scales is None and not rotary, known_load=known_load)
        write_text(paths[1], heading(scales, rotary, known_load) + section)
        return paths


def relative_rmse(measured: Sequence[np.ndarray], predicted: Sequence[np.ndarray]) -> tuple[float, float]:
    """(relative, absolute) root mean square error of all records together.

    Relative is over the standard deviation of the measured force about its mean: sqrt(1 - R^2) of the regression.
    """
    if not measured:
        return math.nan, math.nan
    force = np.concatenate(measured)
    rmse = float(np.sqrt(np.mean((np.concatenate(predicted) - force) ** 2)))
    return rmse / float(np.std(force)), rmse


def number(value: float, digits: int) -> str:
    """A number to so many digits, without an exponent where it is of a common size."""
    return f"{float(f'{value:.{digits}g}'):.6g}"


def _row(p: FittedParameter) -> tuple[str, ...]:
    if p.verdict == Verdict.HELD:
        return p.name, number(p.value, 5), "held", p.unit, ""
    size = max((abs(end) for end in (p.low, p.high) if math.isfinite(end)), default=abs(p.value))
    value, low, high = (0.0 if abs(x) < NOTHING * size else x for x in (p.value, p.low, p.high))
    low, high = (number(end, 4) if math.isfinite(end) else "open" for end in (low, high))
    note = "" if p.verdict == Verdict.DETERMINED else str(p.verdict)
    return p.name, number(value, 5), f"{low} to {high}", p.unit, note


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def table(rows: list[tuple[str, ...]]) -> list[str]:
    """Rows of cells as lines, in columns."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return [("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))).rstrip() for row in rows]
