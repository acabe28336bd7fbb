"""A variation: the same system with other values at some paths, its kinds of machine, law and drive included.

A path names a parameter ("machine.mass_ratio"), a kind ("friction.law") or an initial state ("initial.angle").
"""

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, Complaint, Complaints, suggestion
from vibrocap.case.case import CaseError, case_from_dict
from vibrocap.case.sections import as_given, is_kind, is_part, kind_key, kind_paths, kinds_of
from vibrocap.motion.trust import residue
from vibrocap.physics.dimensions.carry_over import carried, lacking, lacking_per_load
from vibrocap.physics.dimensions.conversion import INITIAL, path_in_si, paths_in_si, values_without_units
from vibrocap.physics.dimensions.scales import Scales
from vibrocap.physics.dimensions.units import effort_of
from vibrocap.physics.environment import Environment
from vibrocap.physics.names import number_in, own_laws, plain_path, split_path, state_names
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.system import System

ALL = "vary a parameter of all kinds, run a study for each, or give a list of cases"
CURE = "give it in a list of cases, or begin with a case whose {} is of this kind"


def with_varied_parts(system: System, paths: Iterable[str]) -> System:
    """The system with each part that a path speaks of and that it leaves out: a further contact then has a law of its
    own, as yet that of the first, and an environment is one of nothing. Its motions are the same."""
    paths = [*map(str, paths)]
    left_out = own_laws(system.parts, paths)
    if system.environment is None and any(split_path(path)[0] == "environment" for path in paths):
        left_out["environment"] = Environment()
    return System.of_parts(system.parts | left_out, system.units) if left_out else system


def plainly(values: Mapping[str, Any], system: System) -> dict[str, Any]:
    """The same values, laws that their contacts name by the numbers of these: of "friction_2" for "frictions.bit"."""
    return {plain_path(str(path), system.machine): value for path, value in values.items()}


def kinds_chosen(system: System, values: Mapping[str, Any]) -> dict[str, Any]:
    """The parts of a system by name; of one that gets another kind the class, for what it lacks may be given yet."""
    parts: dict[str, Any] = dict(system.parts)
    for path in kind_paths(parts):
        section = split_path(path)[0]
        if path in values and values[path] != parts[section].name:
            parts[section] = kinds_of(section)[values[path]]
    return parts


def values_chosen(system: System, kinds: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """The parameters of each part by name, before values are given; kinds: as `kinds_chosen` has them."""
    chosen_values = {}
    for name, part in system.parts.items():
        kind = kinds[name] if isinstance(kinds[name], type) else type(part)
        chosen_values[name] = {info.name: info.default for info in parameter_table(kind)} | carried(part, kind)
    return chosen_values


def varied(system: System, values: Mapping[str, Any]) -> System:
    """The system with other kinds and parameters; values of initial states are passed over.

    A part of another kind keeps the parameters that both kinds have (`vibrocap.physics.dimensions.carry_over`).
    What else it has is given by values, or by its defaults, which in SI are none.
    Raises ValueError for a value that a part, or the system, refuses, CaseError for one that is missing in SI.
    """
    parts = kinds_chosen(system, values)
    fields = _fields(values_without_units(values, system.units, parts))
    missing = Complaints()
    for name, part in parts.items():
        new = fields.get(name, {})
        if isinstance(part, type):
            new = carried(system.parts[name], part) | new
            for field in () if system.units is None else lacking(part, effort_of(name, parts), new):
                missing.append(field.about(f"{name}.{field.field}"))
            if not missing:
                parts[name] = part(**new)
        else:
            effort = effort_of(name, parts)
            if system.units is not None and number_in(name, "friction") and effort != effort_of(name, system.parts):
                missing += [field.about(f"{name}.{field.field}") for field in lacking_per_load(part, effort, new)]
            parts[name] = dataclasses.replace(part, **new) if new else part
    if missing:
        raise CaseError(missing, "the system")
    return System.of_parts(parts, system.units)


def kinds_apart(
    system: System, values: Mapping[str, np.ndarray], runs: int
) -> Iterator[tuple[System, dict[str, np.ndarray], np.ndarray]]:
    """(system, what varies, places of these runs) for each group of runs of the same kinds, with values at the same."""
    labels: dict[str, list[str | None]] = {}  # the kind; for other paths whether there is a value
    for path, array in values.items():
        if array.dtype == object or np.isnan(array).any():
            label = [None if x is None or x != x else x if is_kind(path) else "given" for x in array.tolist()]
            labels |= {path: label} if is_kind(path) or None in label else {}
    groups: dict[tuple, list[int]] = {(): list(range(runs))} if not labels else {}
    for place, words in enumerate(zip(*labels.values(), strict=True)):
        groups.setdefault(words, []).append(place)
    for words, places in groups.items():
        members, chosen = np.array(places), dict(zip(labels, words, strict=True))
        kinds = {path: word for path, word in chosen.items() if is_kind(path) and word is not None}
        missing = {path for path, word in chosen.items() if word is None}
        over = {path: array[members] for path, array in values.items() if not is_kind(path) and path not in missing}
        yield varied(system, kinds | {path: array[0] for path, array in over.items()}), over, members


def residues(system: System, values: Mapping[str, np.ndarray], runs: int, measure: str, threshold: float) -> np.ndarray:
    """The residue (`motion.trust`) of a measure of runs with these values that settled to a threshold: array [runs]."""
    from vibrocap.measures import ensemble

    left = np.empty(runs)
    for one, over, members in kinds_apart(system, values, runs):
        own = ensemble.residues(one, over, measure, threshold) if over else residue(one, measure, threshold)
        left[members] = own
    return left


def refusal(system: System, values: Mapping[str, Any]) -> tuple[str, ...]:
    """What is wrong with these values, in the words of a case file; empty where nothing is."""
    try:
        varied(system, values)
    except CaseError as error:
        complaints = [complaint for complaint in error.complaints if isinstance(complaint, Complaint)]
        cures = [CURE.format(split_path(complaint.field)[0]) for complaint in complaints]
        return tuple(Complaint(old.field, f"{old.text}; {cure}") for old, cure in zip(complaints, cures, strict=True))
    except (ValueError, TypeError):
        pass
    else:
        return ()
    kinds = kinds_chosen(system, values)
    sections = values_chosen(system, kinds)
    for name, part in kinds.items():
        if key := kind_key(name):
            sections[name][key] = part.name
    if (description := getattr(kinds["machine"], "description", None)) is not None:
        sections["mechanism"] = description
    try:
        plain = values_without_units(values, system.units, kinds)
    except ArgumentError as error:
        return error.complaints
    for part, new in _fields(plain).items():
        sections[part] |= new
    try:
        case_from_dict(sections)
    except CaseError as error:
        named = {new: (old, values[old]) for old, new in zip(values, plain, strict=True)}
        return tuple(as_given(complaint, named, sections) for complaint in error.complaints)
    raise AssertionError(f"a system refused {dict(values)}, a case file with them is accepted")


def _fields(values: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    fields: dict[str, dict[str, Any]] = {}
    for path, value in values.items():
        part, name = split_path(path)
        if is_part(part) and not is_kind(path):
            fields.setdefault(part, {})[name] = value
    return fields


def paths(parts: Mapping[str, Any]) -> tuple[str, ...]:
    """Every path that can be varied while the kinds of these parts stay as they are."""
    parameters = (f"{name}.{info.name}" for name, part in parts.items() for info in parameter_table(part))
    return (*parameters, *(INITIAL + state for state in state_names(parts)))


def path_complaints(asked: Iterable[str], choices: Iterable[Mapping[str, Any]], units: Scales | None) -> list[str]:
    """Complaints about paths that are none, or that are unknown for one of the choices of kinds (parts by name).

    units: of the system; paths that carry a unit need to know them
    """
    choices = list(choices)
    of_kinds = dict.fromkeys(path for parts in choices for path in kind_paths(parts))
    plain = [*dict.fromkeys(path for parts in choices for path in paths(parts)), *of_kinds]
    in_si = dict.fromkeys(path for parts in choices for path in paths_in_si(parts))
    known = [*plain, *(in_si if units is not None else ())]
    complaints = Complaints()
    for path in asked:
        if units is None and path in in_si:
            place_in_si = next(place for parts in choices if (place := path_in_si(path, parts)) is not None)
            complaints.add(path, f"the case does not give its units; add {place_in_si[0]}, or a case in SI")
        elif units is not None and path == "machine.kind":
            complaints.add(path, "machines count in units of their own; in SI run a study for each")
        elif path in in_si:
            if any(path_in_si(path, parts) is None for parts in choices):
                complaints.add(path, f"not all kinds have it; {ALL}")
        elif path.startswith("actuator.") and not any("actuator" in parts for parts in choices):
            complaints.add(path, "the system has no actuator; give the case a section [actuator]")
        elif path.startswith("controller.") and not any("controller" in parts for parts in choices):
            complaints.add(path, "the system has no controller; give the case a section [controller]")
        elif path not in known:
            complaints.add(path, f"there is no such quantity here; {suggestion(path, known)}")
        elif path not in of_kinds and (lacking := [parts for parts in choices if path not in paths(parts)]):
            part = lacking[0][split_path(path)[0].replace("initial", "friction")]
            complaints.add(path, f"{part.name!r} has none; {ALL}")
    return complaints
