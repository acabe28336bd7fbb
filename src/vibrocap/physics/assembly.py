"""How parts by name become the fields of a system: the laws of contacts and the waveforms of signals, in order."""

from collections.abc import Iterable, Mapping
from typing import Any

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.physics.names import SIGNAL, number_in, numbered
from vibrocap.physics.parameters import PartInSI


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
