"""What there is to choose from: every law, machine and drive, found by looking into their folders.

A new file in friction/, machines/ or drives/ appears here by itself, under the `name` of the class in it.
"""

import functools
import importlib
import pkgutil
from collections.abc import Mapping
from types import MappingProxyType

from vibrocap.drives.drive import Drive
from vibrocap.friction.law import Law
from vibrocap.machines.machine import Machine


@functools.cache
def laws() -> Mapping[str, type[Law]]:
    """Friction laws by name."""
    return _found("vibrocap.friction", Law)


@functools.cache
def machines() -> Mapping[str, type[Machine]]:
    """Machines by name."""
    return _found("vibrocap.machines", Machine)


@functools.cache
def drives() -> Mapping[str, type[Drive]]:
    """Drives by name."""
    return _found("vibrocap.drives", Drive)


def _found(folder: str, contract: type) -> Mapping[str, type]:
    """Classes that fulfil a contract and have a name, from every module of a folder, in alphabetical order."""
    found: dict[str, type] = {}
    for module in pkgutil.iter_modules(importlib.import_module(folder).__path__, folder + "."):
        for thing in vars(importlib.import_module(module.name)).values():
            own = isinstance(thing, type) and issubclass(thing, contract) and thing.__module__ == module.name
            if own and "name" in vars(thing):
                if thing.name in found:
                    raise ImportError(f"{thing.name!r} names two classes in {folder}: {found[thing.name]} and {thing}")
                found[thing.name] = thing
    return MappingProxyType(dict(sorted(found.items())))
