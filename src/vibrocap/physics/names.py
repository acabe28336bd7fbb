"""Names: of what belongs to one of several contacts, bodies or gaps, of the states of a system, and of its parts.

What belongs to the first contact has no number in its name, what belongs to another ends in its: "friction_2". States
are named in the order of the state vector, of the parts of a system by name, or of their classes.
"""

import re
from collections.abc import Iterable, Mapping
from typing import Any

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.physics.parameters import PartInSI

_NUMBERED = re.compile(r"(.+)_([2-9]|[1-9][0-9]{1,8})")  # "friction_2", not "friction_1" or "friction_02"
NAMED_LAW, SIGNAL = "frictions.", "drives."  # before the name of a contact, of a signal: parts of a system


def numbered(name: str, number: int) -> str:
    """What a quantity, part or parameter of one of several is called: "friction" of the first, "friction_2"."""
    return name if number == 1 else f"{name}_{number}"


def name_and_number(name: str) -> tuple[str, int]:
    """What it is called of the first one, and whose it is: ("friction", 2) of "friction_2", ("friction", 1) without."""
    match = _NUMBERED.fullmatch(name)
    return (name, 1) if match is None else (match[1], int(match[2]))


def number_in(name: object, first: str) -> int:
    """Whose a name is that is `first` for the first one: 1 of "friction", 2 of "friction_2", 0 where it is neither."""
    stem, number = name_and_number(name) if isinstance(name, str) else ("", 0)
    return number if stem == first else 0


def split_path(path: str) -> tuple[str, str]:
    """(part, name) of the path of a parameter: ("drives.clamp", "amplitude") of "drives.clamp.amplitude"."""
    if not isinstance(path, str):
        raise ArgumentError(str(path), 'should be a path such as "machine.mass_ratio"')
    part, _, name = path.rpartition(".")
    return (part, name) if part else (path, "")


def plain_path(path: str, machine: Any) -> str:
    """The path of a law that its contact names: "friction_2.law" of "frictions.bit.law" where the bit is second."""
    part, name = split_path(path)
    contact = part.removeprefix(NAMED_LAW).strip("\"'")
    if not part.startswith(NAMED_LAW) or contact not in machine.contact_names:
        return path
    return f"{numbered('friction', 1 + machine.contact_names.index(contact))}.{name}"


def own_laws(parts: Mapping[str, Any], paths: Iterable[str]) -> dict[str, Any]:
    """Laws of contacts that paths speak of and that have none of their own yet: that of the first.

    Where a path names the first contact, "frictions.bit", all others keep the law that they had of it.
    """
    machine, laws = parts["machine"], set()
    contacts = range(2, 1 + len(machine.contact_states))
    for path in paths:
        number = number_in(split_path(plain_path(path, machine))[0], "friction")
        laws |= {*contacts} if number == 1 and path.startswith(NAMED_LAW) else {number}
    names = (numbered("friction", contact) for contact in contacts if contact in laws)
    return {name: parts["friction"] for name in names if name not in parts}


def owner_of(name: str, parts: Mapping[str, Any]) -> str:
    """Whose a part is: the signal of a waveform, or the body that rubs under a law where contacts have their own."""
    number = number_in(name, "friction")
    if number and any(number_in(other, "friction") > 1 for other in parts):
        return parts["machine"].contact_names[number - 1]
    return name.removeprefix(SIGNAL) if name.startswith(SIGNAL) else ""


OUTPUT, SATURATED, CLIPPED = "actuator_output", "saturated", "clipped"  # states of an actuator


def laws_of(parts: Mapping[str, Any]) -> tuple[Any, ...]:
    """The law of each contact of a machine: its own where there is one, else that of the first contact."""
    numbers = range(1, 1 + len(parts["machine"].contact_states))
    return tuple(parts.get(numbered("friction", i), parts["friction"]) for i in numbers)


def laws_by_state(parts: Mapping[str, Any]) -> tuple[tuple[int, Any], ...]:
    """(number of the contact, its law), in the order in which their internal states stand: the first contact last."""
    first, *further = enumerate(laws_of(parts), start=1)
    return (*further, first)


def state_names(parts: Mapping[str, Any]) -> tuple[str, ...]:
    """All states: of machine, actuator and controller, of the laws of further contacts, and of that of the first.

    Of the class of an actuator or a controller all that one may have.
    """
    actuator, controller = parts.get("actuator"), parts.get("controller")
    between: tuple[str, ...] = ()
    if actuator is not None:
        between += (OUTPUT, SATURATED, CLIPPED) if isinstance(actuator, type) else actuator.states
    if controller is not None:
        between += controller.all_states if isinstance(controller, type) else controller.states
    internal = (numbered(name, i) for i, law in laws_by_state(parts) for name in law.internal)
    return (*parts["machine"].states, *between, *internal)


# --- parts by name become the fields of a system ----------------------------------------------------------------------


def fields_of(parts: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a system by its parts: the laws of further contacts are one field, the waves of signals another."""
    numbers = {name: number for name in parts if (number := number_in(name, "friction")) > 1}
    most = max(numbers.values(), default=1)
    check_contacts(parts["machine"], most)  # before so many are written down
    laws: list[Any] = [None] * (most - 1)
    for name, number in numbers.items():
        laws[number - 2] = parts[name]
    kind = kind_of(parts["machine"])
    drives = {name: parts[SIGNAL + name] for name in kind.signals if SIGNAL + name in parts}
    single = {name: part for name, part in parts.items() if name not in numbers and not name.startswith(SIGNAL)}
    return single | {"further": tuple(laws), "drives": waves_of(kind, drives)}


def kind_of(machine: Any) -> Any:
    """A machine; its class where it is given in SI."""
    return machine.part if isinstance(machine, PartInSI) else machine


def waves_of(kind: Any, waves: Any) -> tuple[Any, ...]:
    """The waveform of each signal of a machine, or of its class: as given, else that of the class."""
    own = {name: signal.default for name, signal in kind.signals.items()}
    waves = waves if isinstance(waves, Mapping) else dict(zip(own, waves, strict=False))
    return by_name(waves, own, "drives", "signal", own)


def by_name(values: Mapping[str, Any], known: Iterable[str], field: str, what: str, usual: Mapping[str, Any]) -> tuple:
    """What is given by the names of contacts or signals, in their order; ArgumentError for a name that is none."""
    names = tuple(known)
    if strange := [name for name in values if name not in names]:
        raise ArgumentError(f"{field}.{strange[0]}", f"there is no such {what}; {suggestion(strange[0], names)}")
    return tuple(values.get(name, usual.get(name)) for name in names)


def check_contacts(machine: Any, number: int) -> None:
    """ArgumentError for the law of a contact that the machine does not have."""
    kind = kind_of(machine)
    contacts = len(kind.contact_states)
    if number > contacts:
        count = "one contact" if contacts == 1 else f"{contacts} contacts"
        raise ArgumentError(numbered("friction", number), f"should be left out: the {kind.name} has {count}")
