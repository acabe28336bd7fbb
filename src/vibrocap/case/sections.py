"""The sections of a case file, and the keys by which its parts are chosen."""

from collections.abc import Iterable, Mapping
from typing import Any

from vibrocap.physics.catalogue import controllers, drives, laws, machines
from vibrocap.physics.closed_loop.actuator import Actuator
from vibrocap.physics.environment import Environment
from vibrocap.physics.names import number_in

# section of a case file: (the key that chooses the kind of part, what there is to choose from)
CHOICES = {"machine": ("kind", machines), "friction": ("law", laws), "drive": ("waveform", drives)}
OPTIONAL: dict[str, Any] = {"environment": Environment, "actuator": Actuator}  # sections that may be left out, no kinds
CHOICES_LEFT_OUT = {"controller": ("kind", controllers)}  # the same of sections that may be left out
SECTIONS = (
    *CHOICES,
    *OPTIONAL,
    *CHOICES_LEFT_OUT,
    "scales",
    "initial",
    "run",
)  # and [friction_2], ... for the laws of further contacts


def of_further_contact(section: object) -> bool:
    """Whether a section has the law of a further contact, as [friction_2] has."""
    return number_in(section, "friction") > 1


def is_section(section: object) -> bool:
    """Whether a case may have a section of that name."""
    return section in SECTIONS or of_further_contact(section)


def is_part(section: str) -> bool:
    """Whether a section describes a part."""
    return section in CHOICES or section in OPTIONAL or section in CHOICES_LEFT_OUT or of_further_contact(section)


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
    return isinstance(path, str) and path != "" and path == kind_path(path.partition(".")[0])


def chosen_classes(data: Mapping[str, Any]) -> dict[str, Any]:
    """The class of part of each section that is there and says one; those that may be left out always have theirs."""
    found: dict[str, Any] = dict(OPTIONAL)
    for section, given in data.items():
        kind = given.get(kind_key(section)) if isinstance(given, Mapping) else None
        if isinstance(kind, str) and (part := kinds_of(section).get(kind)) is not None:
            found[section] = part
    return found


def _choice(section: str) -> tuple[str, Any]:
    return (CHOICES | CHOICES_LEFT_OUT).get(_pattern(section), ("", dict))


def _pattern(section: str) -> str:
    """The section after which one is made: [friction] of [friction_2]."""
    return "friction" if of_further_contact(section) else section
