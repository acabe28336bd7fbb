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

if TYPE_CHECKING:
    from vibrocap.numerics.compiler import Compiled

# Modules of the kernel, in the order in which they use each other.
COMMON = ("roots", "taylor", "stabilised", "resolved")
STEPS = {False: (*COMMON, "explicit"), True: (*COMMON, "implicit", "switching")}  # maybe stiff?
TANGENTS = {False: "no_tangents", True: "tangents"}
PIECES = {False: "one_piece", True: "pieces"}  # of the law, on each side
RECORDING, MEASURING = ("record",), ("settle", "window")  # the hooks of one motion, of an ensemble
# of one motion, of an ensemble one by one, of an ensemble abreast
LOOPS = {
    "single": ("one_number", "elementary_polynomials", "contact", "loop", "one_by_one"),
    "ensemble": ("contact", "loop", "one_by_one", "feed"),
    "card": (  # of a thread of a graphics card
        *("one_number", "elementary_polynomials", "contact", "loop", "one_by_one", "feed", "card"),
    ),
    "abreast": (
        "elementary_polynomials",
        "contact",
        "loop",
        "taylor_abreast",
        "stabilised_abreast",
        "resolved_abreast",
        "abreast",
        "feed",
    ),
}
PLAIN_VECTORS = "from vibrocap.numerics.plain_vectors"
VECTOR_NAMES = (
    *("align_stack", "bits", "exponent", "floor", "load", "mantissa", "power_of_two", "square_root", "store", "where"),
    *("whole_above", "whole_add", "whole_equal", "whole_reached", "whole_set"),
)
GENERATED = "# From the equations"  # as `compiler/subset.py` reads it
ENTRIES = ("advance", "advance_ensemble", "follow")  # the last one of a kernel is called from outside


@functools.cache
def kernel_source(name: str) -> str:
    """Source of a kernel module without its imports and its docstring."""
    return f"# From numerics/{name}.py\n{_body(importlib.import_module(f'vibrocap.numerics.{name}'))}"


@functools.cache
def _lane_constants() -> str:
    """The status and event numbers of `lanes.py`."""
    module = importlib.import_module("vibrocap.numerics.lanes")
    numbers = {name: value for name, value in vars(module).items() if name.isupper() and isinstance(value, int)}
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
    return "\n\n\n".join(_written(lines, node) for node in kept)


def _written(lines: list[str], node: ast.stmt) -> str:
    """The text of a statement of a module; `ast.get_source_segment` would split the whole text for each."""
    last = (node.end_lineno or node.lineno) - 1
    end = lines[last].encode()[: node.end_col_offset].decode()
    return "\n".join([*lines[node.lineno - 1 : last], end])


def linked_source(generated: str, maybe_stiff: bool, pieces: bool, loop: str = "single", tangent: bool = False) -> str:
    """Text of the kernel module of a system, without decorators: plain Python.

    pieces: whether the law has switched states; tangent: whether the tangents of motions are carried along (abreast)
    loop: "single": the entry is `one_by_one.advance`, which records one motion; "ensemble" or "abreast":
    `feed.advance_ensemble`, which measures many, one by one or all lanes at once (of `generated` abreast).
    """
    head = "import math\n\nimport numpy as np\n"
    if loop in ("abreast", "card"):
        head += f"{PLAIN_VECTORS} import {', '.join(VECTOR_NAMES if loop == 'abreast' else ('take', 'whole_equal'))}\n"
    hooks = RECORDING if loop == "single" else MEASURING
    kernel = [
        kernel_source(name) for name in (*STEPS[maybe_stiff], *hooks, PIECES[pieces], TANGENTS[tangent], *LOOPS[loop])
    ]
    return "\n\n".join([head, _lane_constants(), GENERATED, generated, *kernel]) + "\n"


def driven_text(generated: str) -> str:
    """Text of the kernel module of a law under an imposed motion; the entry is `driven.follow`."""
    head = "import math\n\nimport numpy as np\n"
    return "\n\n".join([head, _lane_constants(), GENERATED, generated, kernel_source("driven")]) + "\n"


def plain_kernel(text: str) -> dict[str, Any]:
    """The functions of a linked kernel as plain Python."""
    names: dict[str, Any] = {}
    exec(compile(text, "<kernel>", "exec"), names)
    return names


def compiled_kernel(linked: str) -> "Compiled":
    """The entry of a linked kernel as machine code, kept on disk for the next process."""
    from vibrocap.numerics.compiler import compiled  # only here, as it imports LLVM

    entry = next(name for name in reversed(ENTRIES) if f"\ndef {name}(" in linked)
    return compiled(linked, entry, short=entry != "advance_ensemble")
