"""What there is to choose from: every law, machine, drive and controller, under the `name` of its class.

A new file in friction/, machines/, drives/ or controllers/ appears here by itself. So do the parts of installed
packages, which announce them under the entry points `vibrocap.parts`, and those that a script registers.
"""

import functools
import importlib
import importlib.metadata
import inspect
import pkgutil
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType, ModuleType
from typing import Any, TypeVar

from pydantic.dataclasses import is_pydantic_dataclass

from vibrocap.physics.controllers.controller import Controller
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.mechanics.parts import MechanicsError

GROUP = "vibrocap.parts"  # of entry points
PART_NAME = r"[a-z0-9]+(-[a-z0-9]+)*"
# contract: (what it is called, its folder, what every class must have, functions that it must say anew)
CONTRACTS: dict[type, tuple[str, str, tuple[str, ...], tuple[str, ...]]] = {
    Law: ("law", "vibrocap.physics.friction", ("kind",), ("force", "steady_force", "passive")),
    Machine: ("machine", "vibrocap.physics.machines", (), ("parts",)),
    Drive: ("drive", "vibrocap.physics.drives", (), ("value", "period", "odd")),
    Controller: ("controller", "vibrocap.physics.controllers", ("reference",), ("measures", "command")),
}
Part = TypeVar("Part", bound=type)
_registered: dict[str, type] = {}  # by contract and name, such as "law hyperbolic"


class Parts(Mapping[str, Any]):
    """The parts that keep a contract, in alphabetical order; asked for by name, it answers for the endless others too.

    So "lugre" is listed, and "backlash-anisotropic-lugre" is found; so are rows of more bodies, and scheduled drives.
    All are imported where they are listed. Of one that is asked for by name only the file that writes this name is: a
    command on a case needs one machine, one law and one drive.
    """

    def __init__(self, contract: type, other: Callable[[str], Any] | None = None):
        """other: the part of a name that is not listed; KeyError or ValueError where there is none"""
        self._contract, self._other = contract, other

    @functools.cached_property
    def _listed(self) -> dict[str, type]:
        return dict(sorted(_known(self._contract).items()))

    def listed(self, name: Any) -> Any:
        """The part that is listed under a name; None where there is none."""
        is_name = isinstance(name, str) and re.fullmatch(PART_NAME, name)
        kind = _where_named(self._contract, name) if is_name and "_listed" not in vars(self) else None
        return self._listed.get(name) if kind is None else kind

    def __getitem__(self, name: str) -> Any:
        part = self.listed(name)
        if part is None and self._other is None:
            raise KeyError(name)
        try:
            return part or self._other(name)  # type: ignore[misc]
        except ValueError:
            raise KeyError(name) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._listed)

    def __len__(self) -> int:
        return len(self._listed)


@functools.cache
def laws() -> Parts:
    """Friction laws by name."""
    return Parts(Law, law)


@functools.cache
def wrappers() -> Mapping[str, Callable[[type[Law]], type[Law]]]:
    """What can be put around a law, by the word before its name: a function from the class to the new class."""
    from vibrocap.physics.friction.wrappers import anisotropic, backlash, smoothed, viscous

    return MappingProxyType({wrapper.__name__: wrapper for wrapper in (anisotropic, backlash, smoothed, viscous)})


def law(name: str) -> Any:
    """The friction law of a name, wrapped ones such as "backlash-anisotropic-lugre" included.

    Raises KeyError for a name that is none, ValueError for a wrapper around a law that it does not fit.
    """
    if (plain := laws().listed(name)) is not None:
        return plain
    prefix, _, rest = str(name).partition("-")
    if prefix in wrappers():
        return wrappers()[prefix](law(rest))
    raise KeyError(
        f"no friction law is called {name!r}; there is {', '.join(laws())}; "
        f"before them may stand {' or '.join(f'{word!r}' for word in wrappers())} and a hyphen"
    )


@functools.cache
def machines() -> Mapping[str, type[Machine]]:
    """Machines by name."""
    return Parts(Machine, _row)


def _row(name: str) -> Any:
    """The row of more bodies of a name; KeyError where it is none."""
    from vibrocap.physics.machines.rows import BlockRow, Crawler, Worm, row_called

    return row_called(name, (Crawler, Worm, BlockRow))


@functools.cache
def drives() -> Mapping[str, type[Drive]]:
    """Drives by name, scheduled ones such as "scheduled-harmonic" besides."""
    return Parts(Drive, _scheduled)


def _scheduled(name: str) -> Any:
    """The scheduled drive of a name; KeyError where it is none, ValueError for a drive that has no schedule."""
    from vibrocap.physics.drives.scheduled import scheduled

    prefix, _, rest = str(name).partition("-")
    if prefix != scheduled.__name__:
        raise KeyError(name)
    return scheduled(drives()[rest])


@functools.cache
def controllers() -> Mapping[str, type[Controller]]:
    """Controllers by name."""
    return Parts(Controller)


# --- parts of one's own -----------------------------------------------------------------------------------------------
def register(part: Part) -> Part:
    """Make a part of one's own (law, machine, drive, controller) known by its name, to cases, sweeps, fits and tests.

    Returns the class, so that it may stand above it as a decorator. To register a class again changes nothing; one that
    was defined anew under the same name in the same module takes the place of the old one.
    Raises TypeError for a class that is no part, ValueError for the name of another part, with advice.
    """
    contract = contract_of(part)
    faults = complaints(part)
    if faults:
        raise TypeError(f"{part.__name__} cannot be registered: {'; '.join(faults)}")
    what, name = CONTRACTS[contract][0], part.name  # type: ignore[attr-defined]
    other = (laws() if contract is Law else _known(contract)).get(name)  # wrapped laws have names, too
    if other is not None and other is not part and not (_is_own(other) and _place(other) == _place(part)):
        raise ValueError(f"{part.__name__}: the {what} {name!r} exists already, {_place(other)}; give it another name")
    if other is None or _is_own(other):
        _registered[f"{what} {name}"] = part
        _forget()
    return part


def unregister(part: type) -> None:
    """Forget a part that was registered; one that was not is left as it is."""
    for key, known in list(_registered.items()):
        if known is part:
            del _registered[key]
    _forget()


def registered() -> tuple[type, ...]:
    """The parts that were registered, in order."""
    return tuple(_registered.values())


def contract_of(part: Any) -> type:
    """Law, Machine, Drive or Controller: the contract that a class is to keep. TypeError for what is none of them."""
    contract = next((contract for contract in CONTRACTS if isinstance(part, type) and issubclass(part, contract)), None)
    if contract is None or part in CONTRACTS:
        what = f"an instance of {type(part).__name__}" if isinstance(part, tuple(CONTRACTS)) else repr(part)
        raise TypeError(f"should be a class that extends Law, Machine, Drive or Controller, got {what}")
    return contract


def complaints(part: type) -> list[str]:
    """What stands in the way of a class that is to be a part; empty where nothing does."""
    contract = contract_of(part)
    what, _, constants, functions = CONTRACTS[contract]
    texts = []
    name = getattr(part, "name", None)
    if not isinstance(name, str) or not re.fullmatch(PART_NAME, name):
        wanted = f'a ClassVar of small letters, digits and hyphens, such as "my-{what}"'
        texts.append(f"name: should be {wanted}, got {name!r}")
    if not is_pydantic_dataclass(part):
        return [*texts, "is no record of parameters; write @parameters above the class"]
    try:
        part.states  # type: ignore[attr-defined] # noqa: B018, of a machine that is described it follows from its parts
    except AttributeError:
        pass
    except Exception as error:  # whatever the parts of one's own are
        fault = error if isinstance(error, MechanicsError) else f"{type(error).__name__}: {error}"
        return [*texts, f"parts: {fault}"]
    required = [name for name, field in part.__pydantic_fields__.items() if field.is_required()]
    texts += [f"{name}: every parameter needs a default" for name in required]
    missing = [
        constant for constant in constants if not hasattr(part, constant) and constant not in part.__pydantic_fields__
    ]
    texts += [f"{name}: is missing; see the contract, {contract.__module__}" for name in missing]
    if contract is Law and "kind" not in missing:
        kind = part.kind  # type: ignore[attr-defined]
        if kind not in ("set-valued", "kinked", "smooth"):
            texts.append(f"kind: should be 'set-valued', 'kinked' or 'smooth', got {kind!r}")
        functions = (*functions, "holding_limit") if kind == "set-valued" else functions
    texts += [
        f"{function}: is missing, which every {what} defines; see the contract, {contract.__module__}"
        for function in functions
        if getattr(part, function) is getattr(contract, function)
    ]
    return texts


def parts_in(module: ModuleType, contract: type | None = None) -> list[type]:
    """The parts that a module defines: classes of its own that fulfil a contract, or any, and have a name."""
    contracts = tuple(CONTRACTS) if contract is None else (contract,)
    return [
        thing
        for thing in vars(module).values()
        if inspect.isclass(thing)
        and issubclass(thing, contracts)
        and thing.__module__ == module.__name__
        and "name" in vars(thing)
    ]


@functools.cache  # files are read once, not for each case of a search
def _where_named(contract: type, name: str) -> type | None:
    """The part of the package of a name, from the file that writes `name = "..."` of a class; no other is imported."""
    for info in _modules(CONTRACTS[contract][1]):
        loader: Any = info.module_finder.find_spec(info.name, None).loader  # type: ignore[union-attr]
        if re.search(rf'^    name\b.*= "{name}"$', loader.get_source(info.name) or "", re.MULTILINE):
            for part in parts_in(importlib.import_module(info.name), contract):
                if part.name == name:  # type: ignore[attr-defined]
                    return part
    return None


def _known(contract: type) -> dict[str, type]:
    what, folder, *_ = CONTRACTS[contract]
    own = {part.name: part for key, part in _registered.items() if key.startswith(f"{what} ")}  # type: ignore[attr-defined]
    return {**own, **_installed(contract), **_found(folder, contract)}


def _forget() -> None:
    for catalogue in (laws, machines, drives, controllers):
        catalogue.cache_clear()


def _is_own(part: type) -> bool:
    return part in _registered.values()


def _place(part: type) -> str:
    return f"{part.__module__}.{part.__qualname__}"


@functools.cache
def _installed(contract: type) -> dict[str, type]:
    """Parts of installed packages; what is wrong with one is a warning that names its package, and no more."""
    parts: dict[str, type] = {}
    built_in = _found(CONTRACTS[contract][1], contract)
    for part, package in _announced():
        if issubclass(part, contract):
            name = part.name  # type: ignore[attr-defined]
            if name in built_in or parts.get(name, part) is not part:
                _warn(package, f"{_place(part)} is left out: its name {name!r} is taken")
            else:
                parts[name] = part
    return parts


@functools.cache
def _announced() -> tuple[tuple[type, str], ...]:
    """The parts that entry points lead to, classes or whole modules of them, each with its package."""
    pairs: list[tuple[type, str]] = []
    for entry in importlib.metadata.entry_points(group=GROUP):
        package = entry.dist.name if entry.dist is not None else entry.value
        try:
            thing = entry.load()
            parts = parts_in(thing) if isinstance(thing, ModuleType) else [thing]
            faults = [f"{part.__name__}: {fault}" for part in parts if contract_of(part) for fault in complaints(part)]
        except Exception as error:  # whatever a foreign module does
            _warn(package, f"the entry point {entry.name!r} cannot be loaded: {type(error).__name__}: {error}")
            continue
        if faults:
            _warn(package, f"the entry point {entry.name!r} is left out: {'; '.join(faults)}")
        else:
            pairs += [(part, package) for part in parts]
    return tuple(pairs)


def _warn(package: str, text: str) -> None:
    warnings.warn(f"parts of the package {package}: {text}", RuntimeWarning, stacklevel=2)


def _found(folder: str, contract: type) -> Mapping[str, type]:
    """Classes that fulfil a contract and have a name, from every module of a folder."""
    parts: dict[str, Any] = {}
    for info in _modules(folder):
        for thing in parts_in(importlib.import_module(info.name), contract):
            name = thing.name  # type: ignore[attr-defined]
            if name in parts:
                raise ImportError(f"{name!r} names two classes in {folder}: {parts[name]} and {thing}")
            parts[name] = thing
    return MappingProxyType(parts)


def _modules(folder: str) -> Iterator[pkgutil.ModuleInfo]:
    return pkgutil.iter_modules(importlib.import_module(folder).__path__, f"{folder}.")
