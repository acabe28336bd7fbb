"""Changes: values by path, put into the sections of a case before it is read, another kind of part among them."""

from collections.abc import Mapping
from typing import Any

from vibrocap.arguments import Complaints
from vibrocap.case.sections import CHOICES, chosen_classes, is_kind, is_part, kind_key, of_further_contact
from vibrocap.case.units import form_of
from vibrocap.physics.carry_over import carried_names, lacking
from vibrocap.physics.dimensions.units import (
    Key,
    effort_of,
    one_way,
    parameter_keys,
    same_without_units,
    state_keys,
    state_units,
)
from vibrocap.physics.parameters import parameter_table

Classes = Mapping[str, Any]


def change(data: dict[str, Any], changes: Mapping[str, Any]) -> Complaints:
    """Put values by path into the sections of a case; what parts of other kinds lack then in SI.

    A part of another kind keeps the parameters that both kinds have (`vibrocap.physics.carry_over`), a start only
    states that there still are. A further contact that is spoken of has a law of its own from then on, as yet that of
    the first. What a change gives replaces the same quantity in another unit.
    """
    for section in dict.fromkeys(path.partition(".")[0] for path in changes):
        if of_further_contact(section) and section not in data and isinstance(data.get("friction"), dict):
            data[section] = dict(data["friction"])
    kinds = {path.partition(".")[0]: kind for path, kind in changes.items() if is_kind(path)}
    other = [name for name, kind in kinds.items() if _differs(data, name, kind)]
    si = _in_si(data)
    before = chosen_classes(data)
    for section in other:
        data.setdefault(section, {})
        data[section] = {**data[section], kind_key(section): kinds[section]}
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
                found = lacking(after[section], effort_of(section, after), _said(data[section], section, after))
                complaints += [each.about(f"{section}.{each.field}") for each in found]
    return complaints


def _differs(data: Mapping[str, Any], section: str, kind: Any) -> bool:
    given = data.get(section, {})
    return isinstance(given, dict) and given.get(kind_key(section)) != kind


def _in_si(data: Mapping[str, Any]) -> bool:
    """Whether a case is in SI, as far as it can be told."""
    classes = chosen_classes(data)
    sections = {name: given if isinstance(given := data.get(name), dict) else {} for name in (*classes, "initial")}
    return set(CHOICES) <= set(classes) and form_of(sections, classes, data.get("units")).si


def _kept(given: Mapping[str, Any], section: str, before: Classes, after: Classes, si: bool) -> dict[str, Any]:
    """What a section keeps as its part becomes another, by the keys of that one."""
    if not {section, "machine"} <= set(before) or not {section, "machine"} <= set(after):
        return {}
    keys = parameter_keys(after[section], effort_of(section, after))
    said = _said(given, section, before)
    defaults = {info.name: info.default for info in parameter_table(before[section])}
    found = {}
    for name, old in carried_names(before[section], after[section]).items():
        first = one_way(keys, name)
        if old in said:
            key, way = said[old]
            same = [each.key for each in keys.values() if each.name == name and way and each.unit == way.unit]
            if way is None:
                same = [name if first is None or not si else first.stem]
            found |= dict.fromkeys(same[:1], given[key])
        elif not si or first is None or same_without_units(keys, name):
            found |= {} if defaults[old] is None else {name: defaults[old]}
        elif defaults[old] == 0.0:
            found[first.key] = 0.0
    if section == "machine":  # what its units are
        found |= {info.name: given[info.name] for info in _scale_fields(after) if info.name in given}
    return found


def _said(given: Mapping[str, Any], section: str, classes: Classes) -> dict[str, tuple[str, Key | None]]:
    """The parameters of a part that its section gives: the key, and the way in SI where it says its unit."""
    keys = parameter_keys(classes[section], effort_of(section, classes))
    names = {info.name for info in parameter_table(classes[section])}
    stems = {each.stem: each.name for each in keys.values()}
    found: dict[str, tuple[str, Key | None]] = {}
    for key in given:
        way = keys.get(key)
        if way is not None and way.has_unit:
            found[way.name] = key, way
        elif key in names or key in stems:
            found[key if key in names else stems[key]] = key, None
    return found


def _scale_fields(classes: Classes) -> tuple[Any, ...]:
    return parameter_table(classes["machine"].si_scales)


def _keep_states(data: dict[str, Any], before: Classes, after: Classes) -> None:
    """Leave out of the start what the old parts have and the new ones have not."""
    start = data.get("initial")
    if isinstance(start, dict) and set(CHOICES) <= set(before) and set(CHOICES) <= set(after):
        there = [{name: part for name, part in each.items() if name in data} for each in (before, after)]
        old, new = map(state_units, there)
        lost = {*old}.difference(new)
        lost |= {key for key, each in state_keys(old).items() if each.name in lost}
        data["initial"] = {key: x for key, x in start.items() if key not in lost}


def _put(data: dict[str, Any], path: str, value: Any, classes: Classes, changes: Mapping[str, Any]) -> None:
    """A value in its section, in place of the same quantity under another key, such as frequency_Hz."""
    section, _, key = path.partition(".")
    given = data.setdefault(section, {})
    if not isinstance(given, dict):  # is complained of
        return
    given[key] = value
    if not set(CHOICES) <= set(classes) or not (is_part(section) or section == "initial"):
        return
    if section == "initial":
        keys = state_keys(state_units(classes))
    elif section in classes:
        keys = parameter_keys(classes[section], effort_of(section, classes))
    else:
        return
    for other, each in keys.items():
        if key in keys and each.name == keys[key].name and other != key and f"{section}.{other}" not in changes:
            given.pop(other, None)
