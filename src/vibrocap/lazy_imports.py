"""Lazy imports: names of a module that are imported on first use, so that the module itself costs little.

Such a module imports its names for type checkers only, in its first `if TYPE_CHECKING` block; from there it is read
where each name stands.
"""

import ast
import importlib
import sys
from collections.abc import Callable
from types import FunctionType
from typing import Any


def lazy(public: str, through: str = "") -> Callable[[str], Any]:
    """The function `__getattr__` of a module with lazy imports, given its name.

    through: "module:function", what each of its functions is put through
    """
    module = sys.modules[public]
    with open(str(module.__file__), encoding="utf-8") as file:  # pathlib and inspect take longer than all of this
        tree = ast.parse(file.read())
    block = next(node for node in tree.body if isinstance(node, ast.If))
    imports = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    homes = {alias.name: str(node.module) for node in imports for alias in node.names}

    def asked_for(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {public!r} has no attribute {name!r}")
        home = importlib.import_module(homes[name])
        attribute = getattr(home, name) if hasattr(home, name) else importlib.import_module(f"{homes[name]}.{name}")
        if through and isinstance(attribute, FunctionType):
            place, _, around = through.partition(":")
            attribute = getattr(importlib.import_module(place), around)(attribute)
        setattr(module, name, attribute)
        return attribute

    return asked_for
