"""A variation: the same system with other values at some paths, its kinds of machine, law and drive included.

A path names a parameter ("machine.mass_ratio"), a kind ("friction.law") or an initial state ("initial.angle").
"""

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

from vibrocap.arguments import ArgumentError, Complaints, suggestion
from vibrocap.case.case import CATALOGUES, KEYS, PARTS, CaseError, case_from_dict
from vibrocap.case.units import as_given
from vibrocap.physics.conversion import INITIAL, path_in_si, paths_in_si, values_without_units
from vibrocap.physics.environment import Environment
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.scales import Scales
from vibrocap.physics.states import FURTHER, state_names
from vibrocap.physics.system import System

# path of a kind: (part of the system, what there is to choose from), such as "friction.law": ("friction", laws)
KINDS = {f"{part}.{key}": (part, CATALOGUES[part]) for part, key in KEYS.items()}


def with_varied_parts(system: System, paths: Iterable[str]) -> System:
    """The system with each part that a path speaks of and that it leaves out: a further contact then has a law of its
    own, as yet that of the first, and an environment is one of nothing. Its motions are the same."""
    named = {str(path).partition(".")[0] for path in paths} - {*system.parts}
    laws = dict.fromkeys(named.intersection(FURTHER[: len(system.machine.contacts)]), system.friction)
    around: dict[str, Any] = {"environment": Environment()} if "environment" in named else {}
    return dataclasses.replace(system, **laws, **around) if laws or around else system


def kinds_chosen(system: System, values: Mapping[str, Any]) -> dict[str, Any]:
    """The parts of a system by name; those that get another kind have that kind's defaults."""
    parts: dict[str, Any] = dict(system.parts)
    for path, (part, catalogue) in KINDS.items():
        if path in values and part in parts and values[path] != parts[part].name:
            parts[part] = catalogue()[values[path]]()
    return parts


def varied(system: System, values: Mapping[str, Any]) -> System:
    """The system with other kinds and parameters; values of initial states are passed over.

    A part of another kind has that kind's defaults where no value is given.
    Raises ValueError for a value that a part, or the system, refuses.
    """
    parts = kinds_chosen(system, values)
    for part, new in _fields(values_without_units(values, system.units, parts)).items():
        parts[part] = dataclasses.replace(parts[part], **new)
    return System(**parts, units=system.units)


def refusal(system: System, values: Mapping[str, Any]) -> tuple[str, ...]:
    """What is wrong with these values, in the words of a case file; empty where nothing is."""
    try:
        varied(system, values)
    except (ValueError, TypeError):
        pass
    else:
        return ()
    sections: dict[str, dict[str, Any]] = {}
    parts = kinds_chosen(system, values)
    for name, part in parts.items():
        sections[name] = {info.name: getattr(part, info.name) for info in parameter_table(part)}
        if name in KEYS:
            sections[name][KEYS[name]] = part.name
    try:
        plain = values_without_units(values, system.units, parts)
    except ArgumentError as error:
        return error.complaints
    for part, new in _fields(plain).items():
        sections[part] |= new
    try:
        case_from_dict(sections)
    except CaseError as error:
        given = {new: (old, values[old]) for old, new in zip(values, plain, strict=True)}
        return tuple(as_given(complaint, given, sections) for complaint in error.complaints)
    raise AssertionError(f"a system refused {dict(values)}, a case file with them is accepted")


def _fields(values: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Parameters by part and name."""
    fields: dict[str, dict[str, Any]] = {}
    for path, value in values.items():
        part, _, name = path.partition(".")
        if path not in KINDS and part in PARTS:
            fields.setdefault(part, {})[name] = value
    return fields


def paths(parts: Mapping[str, Any]) -> tuple[str, ...]:
    """Every path that can be varied while the kinds of these parts stay as they are."""
    parameters = (f"{name}.{info.name}" for name, part in parts.items() for info in parameter_table(part))
    return (*parameters, *(INITIAL + state for state in state_names(parts)))


def path_complaints(given: Iterable[str], choices: Iterable[Mapping[str, Any]], units: Scales | None) -> list[str]:
    """Complaints about paths that are none, or that are unknown for one of the choices of kinds (parts by name).

    units: of the system; paths that carry a unit need to know them
    """
    choices = list(choices)
    kinds = [path for path, (part, _) in KINDS.items() if any(part in parts for parts in choices)]
    plain = [*dict.fromkeys(path for parts in choices for path in paths(parts)), *kinds]
    in_si = dict.fromkeys(path for parts in choices for path in paths_in_si(parts))
    known = [*plain, *(in_si if units is not None else ())]
    complaints = Complaints()
    for path in given:
        if units is None and path in in_si:
            found = next(place for parts in choices if (place := path_in_si(path, parts)) is not None)
            complaints.add(path, f"the case does not say what its units are; give {found[0]}, or a case in SI")
        elif units is not None and path == "machine.kind":
            complaints.add(path, "machines count in units of their own; in SI do a study for each")
        elif path in in_si:
            if any(path_in_si(path, parts) is None for parts in choices):
                complaints.add(path, "not all kinds have it; vary what they have, or do a study for each")
        elif path.startswith("actuator.") and not any("actuator" in parts for parts in choices):
            complaints.add(path, "the system has no actuator; give the case a section [actuator]")
        elif path not in known:
            complaints.add(path, f"there is no such quantity here; {suggestion(path, known)}")
        elif path not in KINDS and (lacking := [parts for parts in choices if path not in paths(parts)]):
            part = lacking[0][path.partition(".")[0].replace("initial", "friction")]
            complaints.add(path, f"{part.name!r} has none; vary what all kinds have, or do a study for each")
    return complaints
