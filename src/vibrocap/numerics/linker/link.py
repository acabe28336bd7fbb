"""Links a kernel: the generated source of one system and the sources of the loop become one module of their own.

Machine code is kept under a hash of the whole text (`compiler/`), so that an edited law is never served by old code.
The same text runs as plain Python, for reading and for tests.
"""

import ast
import functools
import importlib
import inspect
from types import ModuleType
from typing import TYPE_CHECKING, Any

from vibrocap.numerics.linker.checks import check
from vibrocap.numerics.linker.recipes import Recipe

if TYPE_CHECKING:
    from vibrocap.numerics.compiler import Compiled

PLAIN_VECTORS = "from vibrocap.numerics.kernel.arithmetic.plain_vectors"
GENERATED = "# From the equations"  # as `compiler/subset.py` reads it
ENTRIES = ("advance", "advance_ensemble", "follow")  # the last one of a kernel is called from outside


@functools.cache
def kernel_source(name: str) -> str:
    """Source of a kernel module, "arithmetic.roots" for example, without its imports and its docstring."""
    module = importlib.import_module(f"vibrocap.numerics.kernel.{name}")
    return f"# From numerics/kernel/{name.replace('.', '/')}.py\n{_body(module)}"


@functools.cache
def _lane_constants() -> str:
    """The numbers of `codes.py` and `memory_layout.py`."""
    modules = [importlib.import_module(f"vibrocap.numerics.kernel.{name}") for name in ("codes", "memory_layout")]
    every = {name: value for module in modules for name, value in vars(module).items()}
    numbers = {name: value for name, value in every.items() if name.isupper() and isinstance(value, int)}
    return "\n".join(f"{name} = {value}" for name, value in numbers.items())


def _body(module: ModuleType) -> str:
    """Definitions of a module, as they stand in its file."""
    text = inspect.getsource(module)
    kept = [
        node
        for node in ast.parse(text).body
        if not isinstance(node, (ast.Import, ast.ImportFrom))
        and not (isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant))
    ]
    lines = text.splitlines()
    return "\n\n\n".join(_segment(lines, node) for node in kept)


def _segment(lines: list[str], node: ast.stmt) -> str:
    """The text of a statement of a module, without a comment behind it."""
    *before, last = lines[node.lineno - 1 : node.end_lineno]
    return "\n".join([*before, last.encode()[: node.end_col_offset].decode()])


def linked_source(generated: str, recipe: Recipe) -> str:
    """Text of a kernel as plain Python: generated code and the modules of a recipe, checked (see `checks.py`)."""
    kernel = {name: kernel_source(name) for name in recipe.modules}
    parts = {
        "codes.py and memory_layout.py": _lane_constants(),
        "the generated code": generated,
        **kernel,
    }
    check(recipe, parts, kernel_source("interface"))
    head = "import math\n\nimport numpy as np\n"
    if recipe.primitives:
        head += f"{PLAIN_VECTORS} import {', '.join(recipe.primitives)}\n"
    return "\n\n".join([head, _lane_constants(), GENERATED, generated, *kernel.values()]) + "\n"


def plain_kernel(text: str) -> dict[str, Any]:
    """The functions of a linked kernel as plain Python."""
    names: dict[str, Any] = {}
    exec(compile(text, "<kernel>", "exec"), names)
    return names


def compiled_kernel(linked: str, literal: bool = False) -> "Compiled":
    """The entry of a linked kernel as machine code, kept on disk for the next process.

    literal: computed as a browser does, see `compiler.literal_ir`
    """
    from vibrocap.numerics.compiler import compiled  # only here, as it imports LLVM

    entry = next(name for name in reversed(ENTRIES) if f"\ndef {name}(" in linked)
    return compiled(linked, entry, short=entry != "advance_ensemble", literal=literal)
