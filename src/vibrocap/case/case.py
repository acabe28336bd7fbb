"""A case: a system and how to run it, and the TOML file that says so in the same words as Python."""

import contextlib
import dataclasses
import sys
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from vibrocap.arguments import ArgumentError, Complaint, Complaints, is_number, shown, suggestion
from vibrocap.case.drive_file import with_columns
from vibrocap.case.sections import (
    CHOICES,
    CHOICES_LEFT_OUT,
    DIMENSIONLESS,
    OPTIONAL,
    SECTIONS,
    as_given,
    change,
    check_word,
    described_machine,
    form_of,
    is_part,
    is_section,
    kind_key,
    kinds_of,
    without_units,
)
from vibrocap.case.text import as_text
from vibrocap.case.unfolding import as_named, unfolded, unfolded_changes, without_strange
from vibrocap.files import write_text
from vibrocap.inputs import read_input
from vibrocap.physics.dimensions.scales import Scales
from vibrocap.physics.dimensions.units import UNDECLARED, undeclared
from vibrocap.physics.drives.table import DriveTable
from vibrocap.physics.names import state_names
from vibrocap.physics.parameters import ParameterError, parameter_table
from vibrocap.physics.system import System
from vibrocap.quantities.declared import ByName, Context, WithoutUnits
from vibrocap.quantities.dimensional import in_si

if TYPE_CHECKING:
    from vibrocap.motion.trajectory import Trajectory

LARGEST = 2**24  # bytes of a case file


class CaseError(ValueError):
    """A case that cannot be run: `complaints` holds every one, with the field's path and what would be right."""

    def __init__(self, complaints: Iterable[str], source: str = "the case"):
        self.complaints = tuple(complaints)
        self.source = source
        super().__init__(f"{source} cannot be run:\n" + "\n".join(f"  {complaint}" for complaint in self.complaints))


@dataclasses.dataclass(frozen=True)
class Case:
    """A system and its run; the fields are the arguments of `simulate`.

    The public functions take a case in place of a system, with its initial condition and, where they simulate, its run.

    initial: without units, also of a system in SI, but under a name with its unit ("position_m")

    scales: units of a case with dimensionless results; `system.units` where results are in SI
    Raises ValueError, naming the field, for settings that make no sense.
    """

    system: System
    initial: Mapping[str, float] = dataclasses.field(default_factory=dict)
    periods: float = 40
    tolerance: float = 1e-9
    max_events_per_period: int = 10_000
    max_steps: int = 50_000_000
    scales: Scales | None = None

    is_case: ClassVar = True  # by which the public functions know one, see `quantities.opening`

    def __post_init__(self):
        from vibrocap.motion.simulate import check_run, initial_state

        start = initial_state(self.system, self.initial)
        in_si = any(name not in start for name in self.initial)
        initial = {name: value for name, value in start.items() if value} if in_si else self.initial
        object.__setattr__(self, "initial", WithoutUnits(initial))
        check_run(**self.run)

    def si_context(self) -> Context | None:
        """Where numbers of its system stand in SI; None where the results are without units."""
        return self.system.si_context()

    @property
    def run(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in RUN_DEFAULTS}

    def simulate(self, progress: Callable[[float], None] | None = None) -> "Trajectory":
        """The motion of this case, in SI where its results are."""
        from vibrocap.motion.simulate import simulate

        return in_si(simulate(self.system, initial=self.initial, **self.run, progress=progress))

    def save(self, path: str | Path, units: str | None = None) -> Path:
        """Write the case to a TOML file, in SI where its results are, or in the form `units`, "SI" or "dimensionless".

        Raises ValueError for SI where the scales of the system are not known.
        """
        path = Path(path)
        write_text(path, case_text(self, units))
        return path


RUN_DEFAULTS: dict[str, Any] = {
    field.name: field.default for field in dataclasses.fields(Case) if field.name not in ("system", "initial", "scales")
}


def read_case(path: str | Path, changes: Mapping[str, Any] | None = None, **run: Any) -> Case:
    """The case in a TOML file; `changes` and `run` replace its values, see `case_from_text`.

    Raises CaseError with every complaint at once.
    """
    path = Path(path)
    try:
        raw = read_input(path, LARGEST + 1)
        text = raw.decode("utf-8-sig").replace("\r\n", "\n")
    except FileNotFoundError:
        raise CaseError(["no such file"], str(path)) from None
    except IsADirectoryError:
        raise CaseError(["is a folder; give a case file in it"], str(path)) from None
    except UnicodeDecodeError as error:
        raise CaseError([f"is no case file (.toml): not a text in UTF-8 (byte {error.start + 1})"], str(path)) from None
    except OSError as error:
        raise CaseError([f"cannot be read: {error.strerror or error}"], str(path)) from None
    if len(raw) > LARGEST:
        raise CaseError([f"should be a case file of at most {LARGEST // 2**20} MB"], str(path))
    return case_from_text(text, str(path), changes, **run)


def case_from_text(text: str, source: str = "the case", changes: Mapping[str, Any] | None = None, **run: Any) -> Case:
    """The case that a TOML text describes; CaseError with every complaint at once, or with the line that is no TOML.

    changes: values by path that replace those of the text, such as {"machine.mass_ratio": 2.0, "initial.angle": 0.5};
        another kind of part ("friction.law") keeps the parameters that both have, see `vibrocap.case.sections`
    run: the same for settings of the section [run], by name
    """
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # besides what is no TOML: numbers and nesting beyond Python's limits
        words = "is nested too deeply" if isinstance(error, RecursionError) else str(error)
        reason, _, place = words.partition(" (at ")
        reason += ": a number such as 0.1, or words in quotation marks" if reason == "Invalid value" else ""
        raise CaseError([f"{place.rstrip(')') or 'TOML'}: {reason}"], source) from None
    data, asked = unfolded(data)
    changes, more = unfolded_changes(data, {**(changes or {}), **{f"run.{name}": x for name, x in run.items()}})
    lacking, asked = change(data, changes), asked | more
    complaints = Complaints()
    with complaints.collected():
        case = case_from_dict(data, source)
        if not lacking:
            return case
    fields = _fields(complaints)
    complaints += [complaint for complaint in lacking if getattr(complaint, "field", "") not in fields]
    raise CaseError(as_named(complaints, asked), source)


def case_from_dict(data: Mapping[str, Any], source: str = "the case") -> Case:
    """The case described by sections of keys, as a TOML parser returns them; CaseError with every complaint at once."""
    data, asked = unfolded(data)
    try:
        return _of_parts(*without_strange(data), source)
    except CaseError as error:
        raise CaseError(as_named(error.complaints, asked), source) from None


def _of_parts(data: Mapping[str, Any], complaints: Complaints, source: str) -> Case:
    """The same of sections that have the names of parts; with complaints there is none."""
    for name in data:
        if not (is_section(name) or name == "units"):
            complaints.add(name, f"no such section; {suggestion(name, SECTIONS)}")
    check_word(data.get("units"), complaints)
    sections: dict[str, Mapping[str, Any]] = {}
    further = tuple(name for name in data if name not in SECTIONS and is_part(name))
    for name in (*SECTIONS, *further):
        section_data = data.get(name, {})
        if not isinstance(section_data, Mapping):
            complaints.add(name, f"should be a section, [{name}] with its keys below it, got {shown(section_data)}")
        sections[name] = section_data if isinstance(section_data, Mapping) else {}

    wanted = (*CHOICES, *(name for name in CHOICES_LEFT_OUT if name in data), *further)
    there = [name for name in wanted if isinstance(data.get(name, {}), Mapping)]
    described = "mechanism" in data
    own = {"machine": described_machine(data, complaints)} if described else {}
    classes = own | {name: _chosen(name, sections[name], complaints) for name in there if name not in own}
    complete = len(classes) == len(wanted) and all(classes.values())
    classes |= {name: part for name, part in OPTIONAL.items() if isinstance(data.get(name), Mapping)}
    scales, section_data, count = None, {}, 0
    form = form_of(sections, classes, data.get("units"))
    if complete:
        if form.check(sections, complaints):
            raise CaseError(complaints, source)
        if form.classes["drive"] is DriveTable:
            columns = form.keys_of("drive", ("times", "values"))
            sections["drive"] = with_columns(sections["drive"], columns, Path(source).parent, complaints)
        where, values = form.scales_of(sections)
        if form.si or values:
            scales = _scales(where, form.classes["machine"].si_scales, values, complaints)
        if form.si:
            if scales is None:  # nothing can be converted
                raise CaseError(complaints, source)
            plain, section_data = without_units(sections, form, scales, complaints)
            sections |= plain
            count = len(complaints)  # about what was given; the others are about fields without units
        elif described:
            lacking = [name for name in classes["machine"].required if name not in sections["machine"]]
            complaints += [Complaint(f"machine.{name}", "is missing; it has no default") for name in lacking]
    kept = data.get("units") == DIMENSIONLESS
    if scales is not None and not kept:  # results are in SI
        about = _fields(complaints)
        fields = [f"{name}.{own}" for name, cls in classes.items() for own in undeclared(cls)]
        complaints += [Complaint(field, UNDECLARED) for field in fields if field not in about]
        count = len(complaints)
    readable = complete or not form.si  # in SI, keys of a part depend on the kinds of the others
    parts = {name: _part(name, cls, sections[name], complaints) for name, cls in classes.items() if cls and readable}
    moving = {"machine", "friction", *classes} - {"drive", "environment"}  # the parts that have states
    states = state_names(classes) if readable and all(classes.get(name) for name in moving) else None
    _check_initial(sections["initial"], states, complaints)
    _check_run(sections["run"], complaints)
    system = None
    if complete and None not in parts.values():
        with complaints.collected(), _computable() if described else contextlib.nullcontext():
            system = System.of_parts(parts, None if kept else scales)
    if complaints or system is None:
        later = [as_given(complaint, section_data, sections) for complaint in complaints[count:]]
        raise CaseError([*complaints[:count], *later], source)
    initial = {name: float(value) for name, value in sections["initial"].items()}
    try:
        case = Case(system, initial, **sections["run"], scales=scales if kept else None)
        if described:
            case.system.machine.check_start(case.system, case.initial)  # type: ignore[attr-defined]
    except ValueError as error:  # a stop stands where the motion would start, a mechanism divides by zero there
        if not (reported := getattr(error, "complaints", ())):
            raise
        raise CaseError([as_given(text, section_data, sections) for text in reported], source) from None
    return case


def case_text(case: Case, units: str | None = None) -> str:
    """The case as TOML, every parameter written out, so that it reads back equal and stays so if a default changes.

    units: "SI" or "dimensionless"; as the results of the case are where nothing is said
    Raises ValueError for SI where the scales of the system are not known.
    """
    return as_text(case.system, case.scales, case.initial, case.run, units)


def save_case(
    system: System, path: str | Path, units: str | None = None, *, initial: ByName | None = None, **run: Any
) -> Path:
    """Write a case file of a system; initial: its start, by state; run: periods=... and other fields of a `Case`.

    units: "SI" or "dimensionless"; by default in SI where the system has scales
    """
    return Case(system, initial or {}, **run).save(path, units)


def _chosen(section: str, section_data: Mapping[str, Any], complaints: Complaints) -> Any:
    """The class that a section asks for, or None with a complaint."""
    key, known = kind_key(section), kinds_of(section)
    choice = section_data.get(key)
    if isinstance(choice, str) and choice in known:
        return known[choice]
    if key not in section_data:
        complaints.add(f"{section}.{key}", f"is missing; should be {_one_of(known)}")
    elif isinstance(choice, str):
        complaints.add(f"{section}.{key}", f"no {key} is called {shown(choice)}; {suggestion(choice, known)}")
    else:
        complaints.add(f"{section}.{key}", f"should be {_one_of(known)}, got {shown(choice)}")
    return None


def _computable() -> contextlib.AbstractContextManager:
    """Where what a described machine cannot compute is a complaint."""
    from vibrocap.case.mechanism import KIND, placed

    return placed(KIND)


def _part(section: str, cls: Any, section_data: Mapping[str, Any], complaints: Complaints) -> Any:
    """The part with its good values, so that checks between fields continue; complaints about the others."""
    key = kind_key(section)
    names = _parameter_names(cls)
    values = {name: value for name, value in section_data.items() if name in names}
    for name in [name for name in section_data if name not in (key, *names)]:
        owner = next((other for other, kin in kinds_of(section).items() if name in _parameter_names(kin)), None)
        hint = f"it belongs to {key} = {owner!r}; here " if owner else ""
        kind = f" for {key} = {cls.name!r}" if key else ""
        complaints.add(f"{section}.{name}", f"no such key{kind}; {hint}{suggestion(name, names)}")
    bad: set[str] = set()
    for _ in range(2):  # all values; then the good ones, for what is to be said between them
        try:
            return cls(**values)
        except ParameterError as error:
            rest = [complaint for complaint in error.complaints if not any(name in complaint for name in bad)]
            complaints += [text.about(f"{section}.{text.field}") for text in rest]
            bad |= {text.field for text in rest}
            values = {name: value for name, value in values.items() if name not in bad}
    return cls()


def _scales(section: str, cls: Any, values: Mapping[str, Any], complaints: Complaints) -> Scales | None:
    try:
        return cls(**values)
    except ParameterError as error:
        complaints += [complaint.about(f"{section}.{complaint.field}") for complaint in error.complaints]
        return None


def _parameter_names(cls: Any) -> list[str]:
    return [info.name for info in parameter_table(cls)]


def _check_initial(values: Mapping[str, Any], states: tuple[str, ...] | None, complaints: Complaints) -> None:
    for name, value in values.items():
        if states is not None and name not in states:
            complaints.add(f"initial.{name}", f"no such state; {suggestion(name, states)}")
        elif not (is_number(value) and abs(value) <= sys.float_info.max):
            complaints.add(f"initial.{name}", f"should be a finite number, got {shown(value)}")


def _check_run(values: Mapping[str, Any], complaints: Complaints) -> None:
    from vibrocap.motion.simulate import check_run

    for name, value in values.items():
        if name not in RUN_DEFAULTS:
            complaints.add(f"run.{name}", f"no such key; {suggestion(name, RUN_DEFAULTS)}")
            continue
        try:
            check_run(**(RUN_DEFAULTS | {name: value}))
        except ArgumentError as error:
            complaints.append(error.complaint.about(f"run.{name}"))


def _fields(complaints: Iterable[str]) -> set[str]:
    return {complaint.field for complaint in complaints if isinstance(complaint, Complaint)}


def _one_of(names: Iterable[str]) -> str:
    return " or ".join(repr(name) for name in names)
