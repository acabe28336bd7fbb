"""The sections of a case file, and the keys by which its parts are chosen."""

from collections.abc import Mapping
from typing import Any

from vibrocap.physics.actuator import Actuator
from vibrocap.physics.catalogue import drives, laws, machines
from vibrocap.physics.environment import Environment
from vibrocap.physics.states import FURTHER

# section of a case file: (the key that chooses the kind of part, what there is to choose from)
CHOICES = {"machine": ("kind", machines), "friction": ("law", laws), "drive": ("waveform", drives)}
CATALOGUES = {section: catalogue for section, (_, catalogue) in CHOICES.items()} | dict.fromkeys(FURTHER, laws)
KEYS = {section: key for section, (key, _) in CHOICES.items()} | dict.fromkeys(FURTHER, "law")
KINDS = {f"{section}.{key}": section for section, key in KEYS.items()}  # such as "friction.law": "friction"
OPTIONAL: dict[str, Any] = {"environment": Environment, "actuator": Actuator}  # sections that may be left out, no kinds
PARTS = (*CHOICES, *OPTIONAL, *FURTHER)
SECTIONS = (*CHOICES, *OPTIONAL, "scales", "initial", "run", *FURTHER)


def chosen_classes(data: Mapping[str, Any]) -> dict[str, Any]:
    """The class of part of each section that is there and says one; those that may be left out always have theirs."""
    found: dict[str, Any] = dict(OPTIONAL)
    for section, key in KEYS.items():
        given = data.get(section)
        kind = given.get(key) if isinstance(given, Mapping) else None
        if isinstance(kind, str) and (part := CATALOGUES[section]().get(kind)) is not None:
            found[section] = part
    return found
