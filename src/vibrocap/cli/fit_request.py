"""The options of `vibrocap fit`: records, parameters and files, every fault of them before any work."""

import dataclasses
import functools
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.arguments import ArgumentError, Complaints, Refusal, by_option, check_whole, suggestion
from vibrocap.cli import completers
from vibrocap.cli.command import Drawn, WithParts
from vibrocap.cli.options import (
    COLUMN_UNITS,
    COLUMNS,
    JSON,
    SAMPLING_RATE,
    SEED,
    flag,
    folder,
    needs,
    option,
    own_names,
    picture,
)
from vibrocap.cli.texts import column_names, pairs, priors, range_of, split

if TYPE_CHECKING:
    from vibrocap.physics.dimensions.scales import PendulumScales
    from vibrocap.records.record import Record

# what a fit writes into --out
OF_FIT = ("fit.json", "friction.toml", "residuals.csv", "fit.png", "residuals.png", "report.html", "posterior.json")
OF_LAW = (  # options that say nothing to --machine
    *("fixed", "free", "pendulum", "least_speed", "loss"),
    *("weights", "start", "intervals", "bootstrap", "design"),
)
OF_ONE = ("bootstrap", "design", "posterior")  # of a fit of one law
DRIVEN = ("prior", "by_record", "along")  # of laws that are driven
RIG = "amplitude=1e-5:1e-2,frequency=0.2:5"
BOUNDS = "coulomb_coefficient=1:20"
TERM_NAMES = (
    "offset, mass, spring, damping, damping_forward, damping_back, drag, gravity, gravity_cosine, delay, gain, "
    "adhesion, ripple, friction_ripple"
)
ALONG = "NAME=CONDITION, such as viscous_damping=temperature_C"
PENDULUM = "written as mass=0.5,length=0.3"


def rig(option: str, text: str) -> dict[str, Any]:
    """The ranges of amplitude and frequency of --design."""
    bounds = {name: (low, high) for name, low, high in (range_of(part, option, RIG) for part in split([text]))}
    if sorted(bounds) != ["amplitude", "frequency"] or not all(0 < low < high for low, high in bounds.values()):
        raise Refusal(f"{option} should have 0 < LOW < HIGH of both, such as {RIG}, got {text!r}")
    return bounds


@dataclasses.dataclass(frozen=True)
class FitPlan:
    """What `vibrocap fit` runs: records ready for a fit, its settings, units of a case, and doubts about units."""

    records: "list[Record]"
    settings: dict[str, Any]
    scales: "PendulumScales | None"
    doubts: list[str]


class FitRequest(WithParts, Drawn):
    data: tuple[Path, ...] = option(
        "FILE.csv, .txt, .xlsx, .json, .npz or .mat: force with velocity, displacement or both; may be several",
        (),
        place=True,
    )
    law: str | None = option("a law, see `vibrocap list laws`", offers=completers.law_names)
    compare: list[str] | None = option(
        "LAW,LAW,... instead of --law: rank them by their error on data that they were not fitted to",
        sets=("laws",),
        offers=completers.law_names,
    )
    machine: Path | None = option(
        "a case instead of --law: machine and law together, fitted to its motion under the measured force"
    )
    predict: str = option("of --machine: the quantity to compare, such as angle or velocity", "position")
    segments: int | None = option(
        "of --machine: segments of a record, each with a start of its own [default: as many as changes of it ask for]",
        check=lambda name, value: check_whole(name, value, 1),
        advanced=True,
    )
    over: list[str] | None = option(
        "NAME=LEAST:LARGEST, bounds of a parameter; of --machine an unknown, such as machine.mass_kg=1:10; may be "
        "repeated",
        sets=("bounds",),
    )
    columns: list[str] | None = COLUMNS
    units: list[str] | None = COLUMN_UNITS
    sampling_rate: float | None = SAMPLING_RATE
    load: float | None = option(
        "normal force in N; without it and such a column, coefficients are forces in N", sets=("normal_force",)
    )
    cutoff: float | None = option("of the low-pass filter of the motion in Hz [default: no filter]")
    fixed: list[str] | None = option(
        "NAME=VALUE, a parameter that is not fitted; may be repeated", offers=completers.law_parameters
    )
    free: list[str] | None = option(
        "NAME,NAME,... the fitted parameters [default: all but those fixed by convention]",
        offers=completers.law_parameters,
    )
    terms: list[str] | None = option("TERM,TERM,... that the sensor measures too, or search: " + TERM_NAMES)
    by_record: list[str] | None = option(
        "NAME,NAME,... parameters and terms with a value in each record", advanced=True
    )
    along: list[str] | None = option(
        "NAME=CONDITION, a parameter that changes with a number of the record, or load; may be repeated", advanced=True
    )
    prior: list[str] | None = option(
        "NAME=MEAN+-DEVIATION, known of a parameter, a term or an unknown beforehand, such as mass=95+-1; may be "
        "repeated",
        sets=("priors",),
    )
    hold_out: list[str] | None = option(
        "RECORD,RECORD,... that are predicted and not fitted; eq_* for all that begin with eq_", sets=("held_out",)
    )
    steady: bool = option("fit only force over velocity, without the memory of the contact", False)
    spring: str | None = option(
        "of rate-and-state laws: stiffness of the machine in N/m, measured (from the data), or searched (fitted)",
        sets=("program", "machine_stiffness"),
    )
    out: Path | None = folder(
        "folder for fit.json, friction.toml, residuals.csv and pictures; with --compare one for each law"
    )
    pendulum: list[str] | None = option(
        "mass=KG,length=M of the pendulum whose weight and length are the units of a case"
    )
    report: bool = option(
        "write report.html into the folder: curves, parameters, errors, how to run it again", False, needs="out"
    )
    design: str | None = option(
        "amplitude=LOW:HIGH,frequency=LOW:HIGH (m or rad, Hz) that the rig can do: the experiments to do next",
        check=rig,
    )
    plot: Path | None = picture("measured and fitted force, loops and intervals")
    json: bool = JSON
    least_speed: float = option("slowest samples of --steady, in m/s", 0.0, advanced=True)
    loss: str = option(
        "linear, soft_l1, huber, cauchy or arctan; all but linear weigh outliers less", "linear", advanced=True
    )
    weights: str = option(
        "power: records count alike at any force; equal: samples have the same noise", "power", advanced=True
    )
    start: str = option("the contact at the first sample: fitted, or relaxed", "fitted", advanced=True)
    intervals: str | None = option(
        "profile (of the likelihood) or covariance, quicker [default: profile, comparing covariance]", advanced=True
    )
    bootstrap: int | None = option(
        "refits of records, or of stretches of them, drawn with replacement",
        check=lambda name, value: check_whole(name, value, 10),
        advanced=True,
    )
    posterior: int | None = option(
        "samples of all parameters jointly; with --out posterior.json, which robust takes (needs emcee)",
        check=lambda name, value: check_whole(name, value, 100),
        advanced=True,
    )
    starts: int = option("searches from different starting points", 8, advanced=True)
    seed: int = SEED

    def changed(self, name: str) -> bool:
        """Whether an option is not its default."""
        return getattr(self, name) != type(self).__dataclass_fields__[name].default

    @property
    def searches_terms(self) -> bool:
        """Whether terms are chosen by held-out error."""
        return split(self.terms) == ["search"]

    @property
    def laws(self) -> list[str]:
        """The law that is fitted, or those that are compared."""
        return split([self.law]) if self.law else split(self.compare)

    @functools.cached_property
    def plan_and_complaints(self) -> tuple[FitPlan, Complaints]:
        """The fit that the options ask for, and everything that is wrong with them."""
        wrong = Complaints()
        bounds: dict[str, tuple[float, float]] = {}
        if self.machine is None:
            with wrong.collected():
                ranges = [range_of(part, "--over", BOUNDS) for part in split(self.over)]
                bounds = {name: (low, high) for name, low, high in ranges}
        held = held_parameters(self.laws, self.fixed, self.free, bounds, wrong)
        if self.machine is not None and (self.law or self.compare or self.steady or self.spring):
            wrong.append("--machine: has its own law: give it without --law, --compare, --steady and --spring")
        elif self.machine is not None and (others := [flag(name) for name in OF_LAW if self.changed(name)]):
            wrong.append(f"{others[0]}: is for --law; with --machine name the unknowns by --over")
        elif self.machine is None and bool(self.law) == bool(self.compare):
            wrong.append("--law: give one law, or several with --compare, or a case with --machine")
        if self.compare and (others := [name for name in OF_ONE if self.changed(name)]):
            wrong.append(f"{flag(others[0])}: is for --law, not for --compare")
        if self.compare and self.steady:
            wrong.append("--steady: is for --law; laws are compared by driving them through the records")
        if (self.steady or self.spring) and (others := [name for name in DRIVEN if self.changed(name)]):
            wrong.append(f"{flag(others[0])}: is for fits without --steady and --spring")
        if self.searches_terms and (self.machine or self.compare or self.steady or self.spring):
            wrong.append("--terms: search is for --law, without --steady and --spring")
        if self.spring and self.terms:
            wrong.append("--terms: are for fits without --spring")
        other = self.compare or self.steady
        stiffness = machine_stiffness(self.spring, other, self.hold_out, self.data, wrong)
        if not self.data:
            wrong.append("DATA: give at least one file with force and motion")
        with wrong.collected():
            if self.out is not None and self.compare:
                own_names("--out", self.out, "comparison.json", "comparison.png", "report.html")
            folders = [] if self.out is None else [self.out / law for law in self.laws] if self.compare else [self.out]
            for folder in folders:
                own_names("--out", folder, *OF_FIT)
        records, doubts = read(self, wrong)
        hidden = held_out(self.hold_out, records, wrong)
        scales = units_of_case(self.pendulum, self.out, records, wrong)
        settings: dict[str, Any] = {"fixed": held, "free": split(self.free) or None, "bounds": bounds}
        settings |= self.given("loss", "starts", "seed", "intervals")
        if self.prior:
            settings["priors"] = priors(self.prior, wrong)
        if self.spring is not None:
            settings["machine_stiffness"] = stiffness
        else:
            settings |= {"held_out": hidden, "weights": self.weights, "terms": split(self.terms)}
            settings |= self.given("least_speed" if self.steady else "start")
            settings |= {"by_record": split(self.by_record)} if self.by_record else {}
            settings |= {"along": pairs("along", split(self.along), wrong, ALONG)} if self.along else {}
        return FitPlan(records, settings, scales, doubts), wrong

    def plan(self, refused: Complaints) -> None:
        """Everything that is wrong with records, parameters and files."""
        if self.posterior:
            needs("--posterior", "emcee")
        if self.report:
            needs("--report", "matplotlib")
        refused += self.plan_and_complaints[1]


def read(request: FitRequest, complaints: Complaints) -> "tuple[list[Record], list[str]]":
    """The records ready for a fit, and what looks wrong with their units."""
    from vibrocap.records.preparation import prepared
    from vibrocap.records.reading.readers import read_records
    from vibrocap.records.record import RecordError, RecordWarning

    options = FitRequest.flags()
    named = column_names(request.columns, complaints)
    for path in dict.fromkeys(path for path in request.data if list(request.data).count(path) > 1):
        complaints.append(f"DATA: {path} is given twice")
    units = pairs("units", split(request.units), complaints, "written as force=kN")
    records: list[Record] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RecordWarning)
        try:
            if request.data:
                rate, load = request.sampling_rate, request.load
                records = read_records(list(request.data), named, units, sampling_rate=rate, normal_force=load)
        except RecordError as error:
            complaints += [f"{error.source}:", *(f"  {text}" for text in by_option(error.complaints, options))]
        except (OSError, UnicodeDecodeError) as error:
            complaints.append(str(error))
        try:
            records = [prepared(record, cutoff=request.cutoff) for record in records]
        except ArgumentError as error:
            complaints += by_option(error.complaints, options)
    return records, [str(warning.message) for warning in caught if issubclass(warning.category, RecordWarning)]


def held_parameters(laws: list[str], fixed: Any, free: Any, bounds: Any, complaints: Complaints) -> dict[str, float]:
    """Parameters that are held, checked against the laws."""
    from vibrocap.identification.problem.parametrisation import law_class
    from vibrocap.physics.parameters import parameter_table

    known: dict[str, Any] | None = {}  # names, in the order of the laws
    for law in laws:
        try:
            names = {info.name: info for info in parameter_table(law_class(law))}
            known = known | names if known is not None else None
        except ArgumentError as error:
            complaints += by_option(error.complaints, FitRequest.flags())
            known = None
    held: dict[str, float] = {}
    for name, text in pairs("fixed", split(fixed), complaints, "written as stribeck_velocity=0.01").items():
        try:
            held[name] = float(text)
        except ValueError:
            complaints.append(f"--fixed {name}={text}: should be a number")
    for flagged, parameters in (("fixed", held), ("free", split(free)), ("over", bounds)):
        for name in parameters:
            if known and name not in known:
                near = suggestion(name, known, there_is="there are")
                complaints.append(f"--{flagged}: {', '.join(laws)} has no parameter {name!r}; {near}")
    return held


def own_settings(law: str, settings: dict[str, Any]) -> dict[str, Any]:
    """The parameters held and searched that a law has, where several laws are asked for with the same."""
    from vibrocap.identification.problem.parametrisation import law_class
    from vibrocap.physics.parameters import parameter_table

    names = [info.name for info in parameter_table(law_class(law))]
    free = [name for name in settings["free"] or () if name in names]
    own = {what: {k: v for k, v in settings[what].items() if k in names} for what in ("fixed", "bounds")}
    return own | {"free": free or None}


def held_out(patterns: Any, records: "list[Record]", complaints: Complaints) -> list[str]:
    """Names of the records that are held out."""
    from fnmatch import fnmatchcase

    names, hidden = [record.name for record in records], []
    for pattern in split(patterns):
        matching = [name for name in names if fnmatchcase(name, pattern)]
        if not matching and names:
            complaints.append(f"--hold-out: no record is called {pattern!r}; there is {', '.join(names)}")
        hidden += [name for name in matching if name not in hidden]
    if names and len(hidden) == len(names):
        complaints.append("--hold-out: leaves no record to fit")
    return hidden


def machine_stiffness(
    text: str | None, other: Any, hold_out: Any, data: tuple[Path, ...], complaints: Complaints
) -> "float | str | None":
    """The stiffness of the machine's spring: N/m, "measured", or None where it is searched."""
    if text is None:
        return None
    if other or hold_out or len(data) > 1:
        complaints.append("--spring: is for one law and one record, without --compare, --steady and --hold-out")
    if text in ("measured", "searched"):
        return "measured" if text == "measured" else None
    try:
        return float(text)
    except ValueError:
        complaints.append(f"--spring {text}: should be measured, searched or a stiffness in N/m")
        return None


def units_of_case(
    texts: "list[str] | None", out: Path | None, records: "list[Record]", complaints: Complaints
) -> "PendulumScales | None":
    """The units of the case that a law is written for, if it is to be in such."""
    from vibrocap.physics.dimensions.scales import PendulumScales

    if not texts:
        return None
    if out is None:
        complaints.append("--pendulum: is for the friction.toml of --out FOLDER")
    loose = [record.name for record in records if record.normal_force is None]
    if loose:
        complaints.append(f"--pendulum: needs the normal force of {', '.join(loose)}; give it by --load")
    if any(record.rotary for record in records):
        complaints.append("--pendulum: is for a contact that slides; the records are of one that turns")
    entries = pairs("pendulum", split(texts), complaints, PENDULUM)
    unknown = [name for name in entries if name not in ("mass", "length")]
    if unknown or len(entries) < 2:
        complaints.append(f"--pendulum {','.join(texts)}: should be {PENDULUM}")
        return None
    try:
        return PendulumScales(pendulum_mass_kg=float(entries["mass"]), pendulum_length_m=float(entries["length"]))
    except ValueError:
        complaints.append(f"--pendulum {','.join(texts)}: mass (kg) and length (m) should be numbers > 0")
        return None
