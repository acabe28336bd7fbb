"""What there is to choose from: every law, machine and drive, found by looking into their folders.

A new file in friction/, machines/ or drives/ appears here by itself, under the `name` of the class in it.
"""

import functools
import importlib
import pkgutil
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.friction.anisotropic import anisotropic
from vibrocap.physics.friction.backlash import backlash
from vibrocap.physics.friction.law import Law
from vibrocap.physics.friction.smoothed import smoothed
from vibrocap.physics.machines.machine import Machine


class Laws(Mapping[str, type[Law]]):
    """The plain laws, in alphabetical order; asked for by name, it answers for wrapped ones too.

    So "lugre" is listed, and "backlash-anisotropic-lugre" is found though there is no end of such names.
    """

    def __init__(self, plain: Mapping[str, type[Law]]):
        self._plain = plain

    def __getitem__(self, name: str) -> type[Law]:
        try:
            return self._plain[name] if name in self._plain else law(name)
        except ValueError:
            raise KeyError(name) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._plain)

    def __len__(self) -> int:
        return len(self._plain)


@functools.cache
def laws() -> Mapping[str, type[Law]]:
    """Friction laws by name."""
    return Laws(_found("vibrocap.physics.friction", Law))


@functools.cache
def wrappers() -> Mapping[str, Callable[[type[Law]], type[Law]]]:
    """What can be put around a law, by the word before its name: a function from the class to the new class."""
    return MappingProxyType({wrapper.__name__: wrapper for wrapper in (anisotropic, backlash, smoothed)})


def law(name: str) -> Any:
    """The friction law of a name, wrapped ones such as "backlash-anisotropic-lugre" included.

    Raises KeyError for a name that is none, ValueError for a wrapper around a law that it does not fit.
    """
    if name in tuple(laws()):
        return laws()[name]
    prefix, _, rest = name.partition("-")
    if prefix in wrappers():
        return wrappers()[prefix](law(rest))
    raise KeyError(
        f"no friction law is called {name!r}; there is {', '.join(laws())}; "
        f"before them may stand {' or '.join(f'{word!r}' for word in wrappers())} and a hyphen"
    )


@functools.cache
def machines() -> Mapping[str, type[Machine]]:
    """Machines by name."""
    return _found("vibrocap.physics.machines", Machine)


@functools.cache
def drives() -> Mapping[str, type[Drive]]:
    """Drives by name."""
    return _found("vibrocap.physics.drives", Drive)


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
