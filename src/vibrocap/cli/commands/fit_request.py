"""What `vibrocap fit` is asked for: records, parameters and files, every fault found before any work."""

import re
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.arguments import Complaints, suggestion
from vibrocap.cli.options import pairs, split

if TYPE_CHECKING:
    from vibrocap.physics.machines.capsule_with_bob import PendulumScales
    from vibrocap.records.record import Record

# a field that a fit or a reader complains of: the option that sets it
OPTIONS = {
    "held_out": "hold-out",
    "sampling_rate": "sampling-rate",
    "dt, sampling_rate": "sampling-rate",
    "normal_force": "load",
    "least_speed": "least-speed",
    "laws": "compare",
    "program": "spring",
    "machine_stiffness": "spring",
    **{name: name for name in ("law", "free", "fixed", "loss", "starts", "weights", "start", "intervals", "seed")},
    **{name: name for name in ("columns", "units", "cutoff", "load")},
}
PENDULUM = "written as mass=0.5,length=0.3"


def read(
    data: tuple[Path, ...], columns: Any, units: Any, rate: float | None, load: float | None, cutoff: float | None,
    complaints: Complaints,
) -> "tuple[list[Record], list[str]]":  # fmt: skip
    """The records ready for a fit, and what looks wrong with their units."""
    from vibrocap.records.checks import RecordError, RecordWarning
    from vibrocap.records.preparation import prepared
    from vibrocap.records.reading.readers import read_records

    named: dict[str, str | int] = {}
    for quantity, name in pairs("columns", split(columns), complaints, "written as force=F1").items():
        named[quantity] = int(name) if name.isdigit() else name
    units = pairs("units", split(units), complaints, "written as force=kN")
    found: list[Record] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RecordWarning)
        try:
            if data:
                found = read_records(list(data), named, units, sampling_rate=rate, normal_force=load)
        except RecordError as error:
            complaints += [f"{error.source}:", *(f"  {by_option(each)}" for each in error.complaints)]
        except (OSError, UnicodeDecodeError) as error:
            complaints.append(str(error))
        try:
            found = [prepared(record, cutoff=cutoff) for record in found]
        except ValueError as error:
            complaints.append(by_option(str(error)))
    return found, [str(each.message) for each in caught if issubclass(each.category, RecordWarning)]


def held_parameters(laws: list[str], fixed: Any, free: Any, complaints: Complaints) -> dict[str, float]:
    """Parameters that are held, checked against the laws."""
    from vibrocap.identification.problem.parametrisation import law_class
    from vibrocap.physics.parameters import parameter_table

    known: dict[str, Any] | None = {}  # names, in the order of the laws
    for law in laws:
        try:
            names = {info.name: info for info in parameter_table(law_class(law))}
            known = known | names if known is not None else None
        except ValueError as error:
            complaints.append(by_option(str(error)))
            known = None
    held: dict[str, float] = {}
    for name, text in pairs("fixed", split(fixed), complaints, "written as stribeck_velocity=0.01").items():
        try:
            held[name] = float(text)
        except ValueError:
            complaints.append(f"--fixed {name}={text}: should be a number")
    for option, given in (("fixed", held), ("free", split(free))):
        for name in given:
            if known and name not in known:
                near = suggestion(name, known, there_is="there are")
                complaints.append(f"--{option}: {', '.join(laws)} has no parameter {name!r}; {near}")
    return held


def own_settings(law: str, settings: dict[str, Any]) -> dict[str, Any]:
    """The parameters held and searched that a law has, where several laws are asked for with the same."""
    from vibrocap.identification.problem.parametrisation import law_class
    from vibrocap.physics.parameters import parameter_table

    names = [info.name for info in parameter_table(law_class(law))]
    free = [name for name in settings["free"] or () if name in names]
    return {"fixed": {k: v for k, v in settings["fixed"].items() if k in names}, "free": free or None}


def held_out(patterns: Any, records: "list[Record]", complaints: Complaints) -> list[str]:
    """Names of the records that are held out."""
    from fnmatch import fnmatchcase

    names = [record.name for record in records]
    hidden = []
    for pattern in split(patterns):
        found = [name for name in names if fnmatchcase(name, pattern)]
        if not found and names:
            complaints.append(f"--hold-out: no record is called {pattern!r}; there is {', '.join(names)}")
        hidden += [name for name in found if name not in hidden]
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
    from vibrocap.physics.machines.capsule_with_bob import PendulumScales

    if not texts:
        return None
    if out is None:
        complaints.append("--pendulum: is for the friction.toml of --out FOLDER")
    loose = [record.name for record in records if record.normal_force is None]
    if loose:
        complaints.append(f"--pendulum: needs the normal force of {', '.join(loose)}; give it by --load")
    if any(record.rotary for record in records):
        complaints.append("--pendulum: is for a contact that slides; the records are of one that turns")
    given = pairs("pendulum", split(texts), complaints, PENDULUM)
    unknown = [name for name in given if name not in ("mass", "length")]
    if unknown or len(given) < 2:
        complaints.append(f"--pendulum {','.join(texts)}: should be {PENDULUM}")
        return None
    try:
        return PendulumScales(pendulum_mass_kg=float(given["mass"]), pendulum_length_m=float(given["length"]))
    except ValueError:
        complaints.append(f"--pendulum {','.join(texts)}: mass (kg) and length (m) should be numbers > 0")
        return None


def is_refusal(text: str) -> bool:
    """Whether a message is about what was asked for or measured: it begins with its field, or its record."""
    return re.match(rf"({'|'.join(map(re.escape, OPTIONS))}|records?)\b", text) is not None


def by_option(text: str) -> str:
    """A message that names options instead of fields and arguments."""
    text = re.sub(r"columns=\{'(\w+)': \.\.\.\}", r"--columns \1=NAME", text)
    text = text.replace(", or dt=;", ", or --sampling-rate;")
    fields = "|".join(sorted(map(re.escape, OPTIONS), key=len, reverse=True))
    named = rf"^(\s*)({fields})(?::| (?=should)) ?"
    return re.sub(named, lambda match: f"{match[1]}--{OPTIONS[match[2]]}: ", text, flags=re.MULTILINE)
