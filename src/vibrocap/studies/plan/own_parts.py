"""Parts of one's own in a study: what tells them apart in its identity.

A part from outside the package can be edited while a study is stored, so the study remembers it by its file's digest,
or, for one that was registered by a script, by a fingerprint of its functions.
"""

import hashlib
from collections.abc import Mapping
from types import CodeType
from typing import Any

from vibrocap.case.case import Case
from vibrocap.case.sections import kind_paths, kinds_of
from vibrocap.physics.part_files import file_of

OWN_FUNCTIONS = ("__post_init__",)  # with two underscores; all others of these are made by Python


def own_parts(case: Case, plan: Mapping[str, Any]) -> dict[str, type]:
    """The parts of a study that are not of this package, such as {"friction.law = own": Own}; plan: its record."""
    entries = {entry["path"]: entry for entry in plan.get("axes") or plan.get("columns") or ()}
    found: dict[str, type] = {}
    for path in kind_paths(case.system.parts):
        section = path.partition(".")[0]
        kinds = [type(case.system.parts[section])]
        kinds += [kinds_of(section)[name] for name in entries.get(path, {}).get("values", ()) if isinstance(name, str)]
        for kind in kinds:
            part = getattr(kind, "wrapped", None) or kind
            if not part.__module__.startswith("vibrocap."):
                found[f"{path} = {part.name}"] = part
    return found


def part_fingerprint(part: type) -> str:
    """SHA-256 of the file that a part was loaded from; else of its functions and constants."""
    if (place := file_of(part)) is not None:
        return place[1]
    own = [each for each in part.__mro__ if not each.__module__.startswith(("vibrocap.", "builtins"))]
    described = [(each.__qualname__, sorted(_functions(each).items())) for each in own]
    return hashlib.sha256(repr(described).encode()).hexdigest()


def _functions(part: type) -> dict[str, str]:
    found = {}
    for name, value in vars(part).items():
        if name.startswith("__") and name not in OWN_FUNCTIONS:
            continue
        inner = (getattr(value, holder, None) for holder in ("fget", "func", "__func__", "wrapped"))
        function = next((each for each in inner if each is not None), value)
        if hasattr(function, "__code__"):
            found[name] = function_fingerprint(function)
        elif isinstance(value, (int, float, str, tuple, type(None))):
            found[name] = repr(value)
    return found


def function_fingerprint(function: Any) -> str:
    """SHA-256 of a function's compiled code, of the values it closes over and of the globals it names.

    Functions of the same module that it calls count too, what comes from other modules by name only. Another version of
    Python compiles differently: then the fingerprint is another one.
    """
    return hashlib.sha256(repr(_described(function, set())).encode()).hexdigest()


def _described(value: Any, seen: set[int]) -> Any:
    """Nested tuples of texts and numbers that stand for a value, without addresses in memory."""
    if isinstance(value, CodeType):
        constants = [_described(constant, seen) for constant in value.co_consts]
        return ("code", value.co_code.hex(), constants, value.co_names, value.co_varnames, value.co_freevars)
    code = getattr(value, "__code__", None)
    if code is None:
        plain = isinstance(value, (int, float, complex, str, bytes, tuple, list, dict, frozenset, type(None)))
        return repr(value) if plain else f"{type(value).__module__}.{type(value).__qualname__}"
    if id(value) in seen:
        return "itself"
    seen.add(id(value))
    cells = [_described(cell.cell_contents, seen) for cell in value.__closure__ or ()]
    defaults = [_described(default, seen) for default in value.__defaults__ or ()]
    used = {name: value.__globals__[name] for name in _names(code) if name in value.__globals__}
    own = {name: _described(thing, seen) for name, thing in sorted(used.items()) if _is_own(thing, value.__module__)}
    return (_described(code, seen), cells, defaults, own)


def _names(code: CodeType) -> set[str]:
    """Names that some code, or code within it, asks for."""
    inner = (_names(constant) for constant in code.co_consts if isinstance(constant, CodeType))
    return set(code.co_names).union(*inner)


def _is_own(thing: Any, module: str) -> bool:
    """Whether a global is a plain value, or a function of the module itself."""
    return getattr(thing, "__module__", module) == module
