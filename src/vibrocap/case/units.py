"""Cases in SI: which form a case has, and the same case without units, with the keys under which each value was given.

A case is in SI where a key carries a unit (`frequency_Hz = 5`) or where it says units = "SI"; then every quantity is. A
case without units may have a section [scales] that says what its units are.
"""

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

from vibrocap.arguments import Complaint, Complaints, shown
from vibrocap.case.sections import kind_key
from vibrocap.physics.dimensions.conversion import part_without_units, states_without_units, with_gravity
from vibrocap.physics.dimensions.scales import Scales
from vibrocap.physics.dimensions.units import effort_of, one_way, parameter_keys, state_keys, state_units, units_of
from vibrocap.physics.parameters import parameter_table

SI, DIMENSIONLESS = "SI", "dimensionless"
WORDS = (SI, DIMENSIONLESS)
Sections = Mapping[str, Mapping[str, Any]]


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
        """Whether the values are in SI."""
        return self.said == SI or (not self.said and bool(self.keys))

    @property
    def scale_fields(self) -> list[str]:
        """The keys that say what the units of the machine are."""
        return [info.name for info in parameter_table(self.classes["machine"].si_scales)]

    def keys_of(self, name: str, parameters: Iterable[str]) -> dict[str, str]:
        """Under which keys parameters of a part stand in the case; in SI with the unit of results."""
        known = parameter_keys(self.classes[name], effort_of(name, self.classes))
        found = {each: one_way(known, each) for each in parameters}
        return {each: each if key is None or not self.si else key.key for each, key in found.items()}

    def check(self, sections: Sections, complaints: Complaints) -> bool:
        """Complaints about what does not go together; whether there are any."""
        before = len(complaints)
        if self.said == DIMENSIONLESS:
            for key in self.keys:
                complaints.add(key, 'has a unit in a case that says units = "dimensionless"')
        if self.si and sections["scales"]:
            where = "[machine] says what its units are"
            complaints.add("scales", f"belongs to a case without units; in SI {where}: {', '.join(self.scale_fields)}")
        return len(complaints) > before

    def scales_of(self, sections: Sections) -> tuple[str, dict[str, Any]]:
        """(section, values) of the scales."""
        if not self.si:
            return "scales", dict(sections["scales"])
        return "machine", {name: x for name, x in sections["machine"].items() if name in self.scale_fields}


def form_of(sections: Sections, classes: Mapping[str, Any], said: Any) -> Form:
    """In which units a case is given; classes: of the parts, all of them."""
    form = Form(classes, said if said in WORDS else "", [])
    keys: dict[str, Any] = {name: parameter_keys(cls, effort_of(name, classes)) for name, cls in classes.items()}
    keys["initial"] = state_keys(state_units(classes))
    for name, known in keys.items():
        own = form.scale_fields if name == "machine" else ()
        form.keys += [f"{name}.{key}" for key in sections[name] if key in own or (key in known and known[key].has_unit)]
    return form


def without_units(
    sections: Sections, form: Form, scales: Scales, complaints: Complaints
) -> tuple[dict[str, dict[str, Any]], dict[str, tuple[str, Any]]]:
    """(the sections without units, under which key and with which value each field was given)."""
    units = units_of(form.classes, scales)
    plain, given = {}, {}
    for name in (*form.classes, "initial"):
        aside = {kind_key(name), *(form.scale_fields if name == "machine" else ())}
        values = {key: value for key, value in sections[name].items() if key not in aside}
        bare = form.said == SI
        if name == "environment":
            values = with_gravity(values, form.classes["machine"])
        if name == "initial":
            found = states_without_units(values, units, bare=bare)
        else:
            found = part_without_units(form.classes[name], values, units.of_part(name), bare=bare)
        complaints += [each.about(f"{name}.{each.field}") for each in found.complaints]  # type: ignore[attr-defined]
        plain[name] = {key: sections[name][key] for key in (kind_key(name),) if key} | found.values
        given |= {f"{name}.{own}": (f"{name}.{key}", values[key]) for own, key in found.keys.items()}
    return plain, given


def as_given(complaint: str, given: Mapping[str, tuple[str, Any]], plain: Mapping[str, Mapping[str, Any]]) -> str:
    """A complaint about a value without units, about what was given."""
    if not isinstance(complaint, Complaint) or complaint.field not in given:
        return complaint
    key, value = given[complaint.field]
    section, _, name = complaint.field.partition(".")
    text, got, _ = complaint.text.rpartition(f", got {shown(plain[section][name])}")
    return Complaint(key, f"{text}, got {shown(value)}" if got else complaint.text)


def check_word(said: Any, complaints: Complaints) -> None:
    """A complaint about units = ... that are none."""
    if said is not None and said not in WORDS:
        complaints.add("units", f'should be "SI" or "dimensionless", got {shown(said)}')
