"""The fingerprint of a function: what it computes with, so that a measure of one's own that was edited is noticed."""

import hashlib
from types import CodeType
from typing import Any


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
