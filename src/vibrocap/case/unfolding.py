"""Sections that are named by what they belong to, [drives.clamp] and [frictions.bit], as the parts of a system are.

A signal of a machine has its waveform in [drives.NAME], a contact its law in [frictions.NAME], by the name of the body
that rubs; the law of all others is [friction].
"""

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from vibrocap.arguments import Complaint, Complaints, suggestion
from vibrocap.case.sections import chosen_classes, kind_key, kinds_of
from vibrocap.physics.drives.drive import Piecewise, Wave
from vibrocap.physics.names import NAMED_LAW, SIGNAL, numbered, own_laws, plain_path, split_path
from vibrocap.physics.parameters import given_parameters

FREQUENCY = "frequency"


def unfolded(data: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """(the sections by part: "drives.clamp", "friction_2" of [frictions.bit]; what each law is called in the case).

    A signal without a section has the waveform that the class of machine gives it; one whose frequency is left out,
    that of the drive.
    """
    sections: dict[str, Any] = {}
    for name, section in data.items():
        folded = name in ("drives", "frictions") and isinstance(section, Mapping)
        sections |= {f"{name}.{own}": value for own, value in section.items()} if folded else {name: section}
    if (machine := _machine(sections)) is None:
        return sections, {}
    asked = {plain_path(f"{name}.", machine)[:-1]: name for name in sections if name.startswith(NAMED_LAW)}
    asked = {part: name for part, name in asked.items() if part not in (name, *data) or part == "friction"}
    laws = {part: sections.pop(name) for part, name in asked.items()}
    if "friction" in laws and isinstance(usual := sections.get("friction"), Mapping):
        others = (numbered("friction", i) for i in range(2, 1 + len(machine.contact_states)))
        sections |= {name: dict(usual) for name in others if name not in sections}
    sections |= laws
    for name, signal in machine.signals.items():
        values = {key: x for key, x in given_parameters(signal.default).items() if x != 0.0}
        part, usual = SIGNAL + name, {kind_key("drive"): signal.default.name, **values}
        sections[part] = _in_step(sections.get(part, usual))
    return sections, asked


def _in_step(section: Any) -> Any:
    """The section of a signal; its frequency is None where it is left out."""
    if not isinstance(section, Mapping) or any(key.partition("_")[0] == FREQUENCY for key in section):
        return section
    kind = kinds_of("drive").get(section.get(kind_key("drive"), ""))
    waves = kind is not None and issubclass(kind, Wave) and not issubclass(kind, Piecewise)
    return {**section, FREQUENCY: None} if waves else section


def unfolded_changes(data: dict[str, Any], changes: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """The same of values by path; a contact that a path names has a law of its own from then on."""
    machine = _machine(data)
    named = [path for path in changes if path.startswith(NAMED_LAW)] if machine is not None else []
    if named and isinstance(data.get("friction"), dict):
        data |= {name: dict(law) for name, law in own_laws({**data, "machine": machine}, named).items()}
    plain = {path: plain_path(path, machine) for path in named}
    asked = {split_path(new)[0]: split_path(path)[0] for path, new in plain.items()}
    return {plain.get(path, path): value for path, value in changes.items()}, asked


def _machine(data: Mapping[str, Any]) -> Any:
    """The class of machine of a case; None where there is none, which is complained of elsewhere."""
    with contextlib.suppress(ValueError):
        return chosen_classes(data).get("machine")
    return None


def without_strange(data: Mapping[str, Any]) -> tuple[dict[str, Any], Complaints]:
    """(the sections of signals and contacts that the machine has and all others, complaints about the rest)."""
    complaints, machine = Complaints(), _machine(data)
    if machine is None:
        return dict(data), complaints
    for name in data:
        if name.startswith(SIGNAL) and name.removeprefix(SIGNAL) not in machine.signals:
            complaints.add(name, f"there is no such signal; {suggestion(name.removeprefix(SIGNAL), machine.signals)}")
        elif name.startswith(NAMED_LAW):
            own = name.removeprefix(NAMED_LAW)
            there = "is there already, by its number" if own in machine.contact_names else "there is no such contact"
            complaints.add(name, f"{there}; {suggestion(own, machine.contact_names)}")
    strange = {complaint.field for complaint in complaints if isinstance(complaint, Complaint)}
    return {name: section for name, section in data.items() if name not in strange}, complaints


def as_named(complaints: Iterable[Any], asked: Mapping[str, str]) -> Iterator[Any]:
    """Complaints about laws under the names that these have in the case."""
    for complaint in complaints:
        part, _, name = complaint.field.partition(".") if isinstance(complaint, Complaint) else ("", "", "")
        yield complaint.about(f"{asked[part]}.{name}") if part in asked else complaint
