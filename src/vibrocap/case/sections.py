"""The sections of a case: how their keys choose parts, which units they carry, and values by path put in their place.

A case is in SI where a key carries a unit (`frequency_Hz = 5`) or where it says units = "SI"; then every quantity is. A
case without units may have a section [scales] that says what its units are. Changes are values by path that are put
into the sections before they are read, another kind of part among them.
"""

import collections
import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

from vibrocap.arguments import Complaint, Complaints, restated, shown
from vibrocap.physics.catalogue import controllers, drives, laws, machines
from vibrocap.physics.closed_loop.actuator import Actuator
from vibrocap.physics.dimensions.carry_over import carried_names, lacking
from vibrocap.physics.dimensions.conversion import (
    constant_load,
    part_without_units,
    states_without_units,
    with_coefficients,
    with_gravity,
)
from vibrocap.physics.dimensions.scales import EFFORTS, TURNING, Scales
from vibrocap.physics.dimensions.units import (
    Key,
    effort_of,
    keys_of,
    one_way,
    parameter_keys,
    same_without_units,
    state_keys,
    state_units,
    units_of,
)
from vibrocap.physics.environment import Environment
from vibrocap.physics.names import NAMED_LAW, SIGNAL, number_in, split_path
from vibrocap.physics.parameters import parameter_table

# section of a case file: (the key that chooses the kind of part, what there is to choose from)
CHOICES = {"machine": ("kind", machines), "friction": ("law", laws), "drive": ("waveform", drives)}
OPTIONAL: dict[str, Any] = {"environment": Environment, "actuator": Actuator}  # sections that may be left out, no kinds
CHOICES_LEFT_OUT = {"controller": ("kind", controllers)}  # the same of sections that may be left out
# and [friction_2], ... for the laws of further contacts
SECTIONS = (*CHOICES, *OPTIONAL, *CHOICES_LEFT_OUT, "mechanism", "scales", "initial", "run")

SI, DIMENSIONLESS = "SI", "dimensionless"
WORDS = (SI, DIMENSIONLESS)
Sections = Mapping[str, Mapping[str, Any]]
Classes = Mapping[str, Any]  # of parts, by section


def of_further_contact(section: object) -> bool:
    """Whether a section has the law of a further contact, as [friction_2] has."""
    return number_in(section, "friction") > 1


def is_section(section: object) -> bool:
    """Whether a case may have a section of that name."""
    named = isinstance(section, str) and section.startswith((SIGNAL, NAMED_LAW))
    return named or section in SECTIONS or of_further_contact(section)


def is_part(section: str) -> bool:
    return _pattern(section) in {*CHOICES, *OPTIONAL, *CHOICES_LEFT_OUT}


def kind_key(section: str) -> str:
    """The key that chooses the kind of part of a section, such as "law"; empty for a section without kinds."""
    return _choice(section)[0]


def kinds_of(section: str) -> Mapping[str, Any]:
    """What there is to choose from in a section, by name; nothing for a section without kinds."""
    return _choice(section)[1]()


def kind_path(section: str) -> str:
    """The path that chooses the kind of part of a section, such as "friction.law"; empty where there are no kinds."""
    return f"{section}.{key}" if (key := kind_key(section)) else ""


def kind_paths(sections: Iterable[str]) -> tuple[str, ...]:
    """The paths that choose kinds, of those sections that have kinds."""
    return tuple(filter(None, map(kind_path, sections)))


def is_kind(path: object) -> bool:
    """Whether a path chooses a kind of part, as "friction.law" and "friction_2.law" do."""
    return isinstance(path, str) and path != "" and path == kind_path(split_path(path)[0])


def chosen_classes(data: Mapping[str, Any]) -> dict[str, Any]:
    """The class of part of each section that is there and says one; those that may be left out always have theirs."""
    classes: dict[str, Any] = dict(OPTIONAL)
    for section, values in data.items():
        kind = values.get(kind_key(section)) if isinstance(values, Mapping) else None
        part = kinds_of(section).get(kind) if isinstance(kind, str) else None
        if section == "machine" and part is None and "mechanism" in data:
            part = described_machine(data)
        if part is not None:
            classes[section] = part
    return classes


def described_machine(data: Mapping[str, Any], complaints: Complaints | None = None) -> Any:
    """The class of machine that the section [mechanism] describes, which [machine] chooses; None with complaints."""
    from vibrocap.case.mechanism import KIND
    from vibrocap.case.mechanism_reading import mechanism

    problems = Complaints() if complaints is None else complaints
    with problems.collected():
        part, machine = mechanism(data["mechanism"]), data.get("machine", {})
        kind = machine.get("kind") if isinstance(machine, Mapping) else part.name
        if kind in (KIND, part.name):
            return part
        problems.add("machine.kind", f"should be {KIND!r}, described in [{KIND}], got {shown(kind)}")
    return None


def _choice(section: str) -> tuple[str, Any]:
    return (CHOICES | CHOICES_LEFT_OUT).get(_pattern(section), ("", dict))


def _pattern(section: str) -> str:
    """The section after which one is made: [friction] of [friction_2], [drive] of [drives.clamp]."""
    if of_further_contact(section) or section.startswith(NAMED_LAW):
        return "friction"
    return "drive" if section.startswith(SIGNAL) else section


@dataclasses.dataclass
class Form:
    """In which units a case is given.

    said: what it says of its units, "" where nothing. keys: those that carry a unit, "machine.capsule_mass_kg".
    """

    classes: Mapping[str, Any]
    said: str
    keys: list[str]

    @property
    def si(self) -> bool:
        return self.said == SI or (not self.said and bool(self.keys))

    def keys_of(self, name: str, parameters: Iterable[str]) -> dict[str, str]:
        """Under which keys parameters of a part stand in the case; in SI with the unit of results."""
        known = keys_of(name, self.classes)
        keys = {own: one_way(known, own) for own in parameters}
        return {own: own if key is None or not self.si else key.key for own, key in keys.items()}

    def check(self, sections: Sections, complaints: Complaints) -> bool:
        """Complaints about what does not go together; whether there are any."""
        before = len(complaints)
        if self.said == DIMENSIONLESS:
            for key in self.keys:
                complaints.add(key, 'has a unit in a case that says units = "dimensionless"')
        if self.si and sections["scales"]:
            where = f"in SI [machine] has to give its units: {', '.join(scale_fields(self.classes))}"
            complaints.add("scales", f"belongs to a case without units; {where}")
        return len(complaints) > before

    def scales_of(self, sections: Sections) -> tuple[str, dict[str, Any]]:
        """(section, values) of the scales."""
        if not self.si:
            return "scales", dict(sections["scales"])
        fields = scale_fields(self.classes)
        return "machine", {name: x for name, x in sections["machine"].items() if name in fields}


def form_of(sections: Sections, classes: Classes, word: Any) -> Form:
    """In which units a case is given; classes: of the parts, None where none is of that kind.

    Where a kind is unknown, so is what the drive exerts: a key carries a unit if it does under any effort.
    """
    form = Form(classes, word if word in WORDS else "", [])
    known = {name: cls for name, cls in classes.items() if cls is not None}
    complete = len(known) == len(classes) and set(CHOICES) <= set(classes)
    keys: dict[str, Any] = {"initial": state_keys(state_units(classes)) if complete else {}}
    for name, cls in known.items():
        any_effort = collections.ChainMap(*(dict(parameter_keys(cls, effort)) for effort in (*EFFORTS, TURNING)))
        keys[name] = keys_of(name, classes) if complete else any_effort
    for name, those in keys.items():
        own = scale_fields(classes) if name == "machine" else ()
        form.keys += [f"{name}.{key}" for key in sections[name] if key in own or (key in those and those[key].has_unit)]
    return form


def without_units(
    sections: Sections, form: Form, scales: Scales, complaints: Complaints
) -> tuple[dict[str, dict[str, Any]], dict[str, tuple[str, Any]]]:
    """(the sections without units, under which key and with which value each field was given)."""
    units = units_of(form.classes, scales)
    plain, originals, there = {}, {}, dict[str, Any]()
    for name in sorted((*form.classes, "initial"), key=lambda section: section not in ("machine", "environment")):
        aside = {kind_key(name), *(scale_fields(form.classes) if name == "machine" else ())}
        values = {key: value for key, value in sections[name].items() if key not in aside}
        if name not in ("machine", "environment") and not there:
            there = _machine(form.classes, plain)
        bare, asked, own_units = form.said == SI, {}, units.of_part(name)
        if _pattern(name) == "friction":
            load = constant_load(there, number_in(name, "friction"), scales) if there else 1.0
            own_units = dataclasses.replace(units, effort=effort_of(name, {**form.classes, **there}))
            known = with_coefficients(values, form.classes[name], load, own_units.effort)
            values, asked = known.values, known.keys
            complaints += [complaint.about(f"{name}.{complaint.field}") for complaint in known.complaints]  # type: ignore[attr-defined]
        if name == "environment":
            values = with_gravity(values, form.classes["machine"])
        if name == "initial":
            own = state_units({**form.classes, **there})
            states = states_without_units(values, dataclasses.replace(units, states=own), bare=bare)
        else:
            states = part_without_units(form.classes[name], values, own_units, bare=bare)
        complaints += [complaint.about(f"{name}.{complaint.field}") for complaint in states.complaints]  # type: ignore[attr-defined]
        plain[name] = {key: sections[name][key] for key in (kind_key(name),) if key} | states.values
        for own, key in states.keys.items():
            key = asked.get(key, key)
            originals[f"{name}.{own}"] = (f"{name}.{key}", sections[name].get(key, values.get(key)))
    return plain, originals


def _machine(classes: Mapping[str, Any], plain: Mapping[str, Any]) -> dict[str, Any]:
    """The machine and its environment, if any; nothing where a part refuses its values, which is complained of."""
    there = [name for name in ("machine", "environment") if name in plain]
    values = {name: {key: x for key, x in plain[name].items() if key != kind_key(name)} for name in there}
    try:
        return {name: classes[name](**values[name]) for name in there}
    except (ValueError, TypeError):
        return {}


def as_given(complaint: str, originals: Mapping[str, tuple[str, Any]], plain: Mapping[str, Mapping[str, Any]]) -> str:
    """A complaint about a value without units, about what was given."""
    if not isinstance(complaint, Complaint) or complaint.field not in originals:
        return complaint
    key, value = originals[complaint.field]
    section, name = split_path(complaint.field)
    return Complaint(key, restated(complaint.text, plain[section][name], value))


def check_word(word: Any, complaints: Complaints) -> None:
    """A complaint about units = ... that are none."""
    if word is not None and word not in WORDS:
        complaints.add("units", f'should be "SI" or "dimensionless", got {shown(word)}')


def change(data: dict[str, Any], changes: Mapping[str, Any]) -> Complaints:
    """Put values by path into the sections of a case; what parts of other kinds lack then in SI.

    A part of another kind keeps the parameters that both kinds have (`dimensions.carry_over`), a start only states that
    there still are. A further contact that is spoken of has a law of its own from then on, as yet that of
    the first. What a change gives replaces the same quantity in another unit.
    """
    for section in dict.fromkeys(split_path(path)[0] for path in changes):
        if of_further_contact(section) and section not in data and isinstance(data.get("friction"), dict):
            data[section] = dict(data["friction"])
    kinds = {split_path(path)[0]: kind for path, kind in changes.items() if is_kind(path)}
    other = [name for name, kind in kinds.items() if _differs(data, name, kind)]
    si = _in_si(data)
    before = chosen_classes(data)
    for section in other:
        data.setdefault(section, {})
        data[section] = {**data[section], kind_key(section): kinds[section]}
    if "machine" in other and isinstance(kind := kinds["machine"], str) and kind in kinds_of("machine"):
        for name in [name for name in data if name == "mechanism" or name.startswith(SIGNAL)]:
            del data[name]  # a kind of the package takes its place
    after = chosen_classes(data)
    for section in other:
        kept = _kept(data[section], section, before, after, si)
        data[section] = {kind_key(section): kinds[section]} | kept
    if other:
        _keep_states(data, before, after)
    for path, value in changes.items():
        _put(data, path, value, after, changes)
    complaints = Complaints()
    if si and "machine" in after:
        for section in other:
            if section in after:
                missing = lacking(after[section], effort_of(section, after), _said(data[section], section, after))
                complaints += [name.about(f"{section}.{name.field}") for name in missing]
    return complaints


def _differs(data: Mapping[str, Any], section: str, kind: Any) -> bool:
    keys = data.get(section, {})
    return isinstance(keys, dict) and keys.get(kind_key(section)) != kind


def _in_si(data: Mapping[str, Any]) -> bool:
    """Whether a case is in SI, as far as it can be told."""
    classes = chosen_classes(data)
    sections = {name: section if isinstance(section := data.get(name), dict) else {} for name in (*classes, "initial")}
    return form_of(sections, classes, data.get("units")).si


def _kept(section_data: Mapping[str, Any], section: str, before: Classes, after: Classes, si: bool) -> dict[str, Any]:
    """What a section keeps as its part becomes another, by the keys of that one."""
    if not {section, "machine"} <= set(before) or not {section, "machine"} <= set(after):
        return {}
    keys = keys_of(section, after)
    places = _said(section_data, section, before)
    defaults = {info.name: info.default for info in parameter_table(before[section])}
    values = {}
    for name, old in carried_names(before[section], after[section]).items():
        first = one_way(keys, name)
        if old in places:
            key, entry = places[old]
            same = [key.key for key in keys.values() if key.name == name and entry and key.unit == entry.unit]
            if entry is None:
                same = [name if first is None or not si else first.stem]
            values |= dict.fromkeys(same[:1], section_data[key])
        elif not si or first is None or same_without_units(keys, name):
            values |= {} if defaults[old] is None else {name: defaults[old]}
        elif defaults[old] == 0.0:
            values[first.key] = 0.0
    if section == "machine":  # what its units are
        values |= {name: section_data[name] for name in scale_fields(after) if name in section_data}
    return values


def _said(values: Mapping[str, Any], section: str, classes: Classes) -> dict[str, tuple[str, Key | None]]:
    """The parameters of a part that its section gives: the key, and the way in SI where it says its unit."""
    keys = keys_of(section, classes)
    names = {info.name for info in parameter_table(classes[section])}
    stems = {key.stem: key.name for key in keys.values()}
    stated: dict[str, tuple[str, Key | None]] = {}
    for key in values:
        entry = keys.get(key)
        if entry is not None and entry.has_unit:
            stated[entry.name] = key, entry
        elif key in names or key in stems:
            stated[key if key in names else stems[key]] = key, None
    return stated


def scale_fields(classes: Classes) -> list[str]:
    """The keys that say what the units of the machine are."""
    return [info.name for info in parameter_table(classes["machine"].si_scales)]


def _keep_states(data: dict[str, Any], before: Classes, after: Classes) -> None:
    """Leave out of the start what the old parts have and the new ones have not."""
    start = data.get("initial")
    if isinstance(start, dict) and set(CHOICES) <= set(before) and set(CHOICES) <= set(after):
        there = [{name: part for name, part in system.items() if name in data} for system in (before, after)]
        old, new = map(state_units, there)
        lost = {*old}.difference(new)
        lost |= {key for key, state_key in state_keys(old).items() if state_key.name in lost}
        data["initial"] = {key: x for key, x in start.items() if key not in lost}


def _put(data: dict[str, Any], path: str, value: Any, classes: Classes, changes: Mapping[str, Any]) -> None:
    """A value in its section, in place of the same quantity under another key, such as frequency_Hz."""
    section, key = split_path(path)
    values = data.setdefault(section, {})
    if not isinstance(values, dict):  # is complained of
        return
    values[key] = value
    if not set(CHOICES) <= set(classes) or not (section in classes or section == "initial"):
        return
    if section == "initial":
        keys = state_keys(state_units(classes))
    else:
        keys = keys_of(section, classes)
    for other, stated in keys.items():
        if key in keys and stated.name == keys[key].name and other != key and f"{section}.{other}" not in changes:
            values.pop(other, None)
