"""Links a kernel: the generated source of one system and the sources of the loop become one module of their own.

The module is a file in a cache folder, named by a hash of all it contains, so that Numba's cache beside it can never
serve an edited law: another text is another file. The same text runs as plain Python, for reading and for tests.
"""

import ast
import contextlib
import functools
import hashlib
import importlib.metadata
import importlib.util
import inspect
import os
import pathlib
import platform
import sys
import tempfile
import threading
from collections.abc import Iterator
from types import ModuleType
from typing import Any

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
PLAIN_VECTORS, VECTORS = "from vibrocap.numerics.plain_vectors", "from vibrocap.numerics.vectors"
VECTOR_NAMES = (
    *("align_stack", "bits", "exponent", "floor", "load", "mantissa", "power_of_two", "square_root", "store", "where"),
    *("whole_above", "whole_add", "whole_equal", "whole_reached", "whole_set"),
)
ENTRIES = ("advance", "advance_ensemble", "follow")  # the last one of a kernel is called from outside
# Nothing is allocated in a kernel; without its runtime (_nrt), Numba counts no references to the arrays that are passed
# around, atomic operations that took a third of the time.
OPTIONS = 'fastmath={"contract"}, error_model="numpy", nogil=True, _nrt=False'
WITHOUT_WRAPPERS = "no_cpython_wrapper=True, no_cfunc_wrapper=True"
DECORATORS = "one_version", f"numba.njit({OPTIONS}, {WITHOUT_WRAPPERS}, pipeline_class=PartCompiler)"
ENTRY_DECORATOR = f"numba.njit({OPTIONS}, cache=True, pipeline_class=WholeCompiler)"


@functools.cache
def kernel_source(name: str) -> str:
    """Source of a kernel module without its imports and its docstring."""
    return _body(importlib.import_module(f"vibrocap.numerics.{name}"))


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
    return "\n\n\n".join(ast.get_source_segment(text, node) or "" for node in kept)


def linked_source(generated: str, maybe_stiff: bool, pieces: bool, loop: str = "single", tangent: bool = False) -> str:
    """Text of the kernel module of a system, without decorators: plain Python.

    pieces: whether the law has switched states; tangent: whether the tangents of motions are carried along (abreast)
    loop: "single": the entry is `one_by_one.advance`, which records one motion; "ensemble" or "abreast":
    `feed.advance_ensemble`, which measures many, one by one or all lanes at once (of `generated` abreast).
    """
    head = "import math\n\nimport numpy as np\n"
    if loop == "abreast":
        head += f"{PLAIN_VECTORS} import {', '.join(VECTOR_NAMES)}\n"
    hooks = RECORDING if loop == "single" else MEASURING
    kernel = [
        kernel_source(name) for name in (*STEPS[maybe_stiff], *hooks, PIECES[pieces], TANGENTS[tangent], *LOOPS[loop])
    ]
    return "\n\n".join([head, _lane_constants(), generated, *kernel]) + "\n"


def driven_text(generated: str) -> str:
    """Text of the kernel module of a law under an imposed motion; the entry is `driven.follow`."""
    head = "import math\n\nimport numpy as np\n"
    return "\n\n".join([head, _lane_constants(), generated, kernel_source("driven")]) + "\n"


def plain_kernel(text: str) -> dict[str, Any]:
    """The functions of a linked kernel as plain Python."""
    names: dict[str, Any] = {}
    exec(compile(text, "<kernel>", "exec"), names)
    return names


SIGNATURE = "(float64[::1], int64[::1], float64[::1], int64)"
LINKING = threading.Lock()  # Python 3.11 parses syntax trees in one thread at a time


def compiled_kernel(linked: str) -> Any:
    """The entry of a linked kernel, compiled by Numba on first use and kept on disk for the next process."""
    with LINKING:
        return _compiled_kernel(linked)


def _compiled_kernel(linked: str) -> Any:
    from vibrocap.numerics.inference import asked_once  # only here, as it imports Numba

    entry = next(name for name in reversed(ENTRIES) if f"\ndef {name}(" in linked)
    head = (
        "import numba\nfrom vibrocap.numerics.one_module import PartCompiler, WholeCompiler\n"
        "from vibrocap.numerics.inference import one_version\n"
    )
    text = head + _decorated(linked, entry)
    if PLAIN_VECTORS in text:  # their code is part of what is compiled
        vectors = importlib.import_module("vibrocap.numerics.vectors")
        code = hashlib.sha256(inspect.getsource(vectors).encode()).hexdigest()
        text = text.replace(PLAIN_VECTORS, VECTORS) + f"\n# {code}\n"
    version = f"{platform.python_version()} {importlib.metadata.version('numba')}"
    name = hashlib.sha256(f"{version}\n{text}".encode()).hexdigest()[:24]
    compiled = loaded(name, text, entry)
    with _one_process_at_a_time(name), _instructions_in_the_order_written(), asked_once():
        compiled.compile(SIGNATURE)
    return compiled


@contextlib.contextmanager
def _instructions_in_the_order_written() -> Iterator[None]:
    """Within this context LLVM leaves the instructions of a block in the order of the source.

    The series are written in an order in which few numbers wait; LLVM's scheduler of machine instructions, which counts
    latencies, makes more of them wait, in memory, and the series cost an eighth more. The option is one of the whole
    process, so no other thread may compile meanwhile.
    """
    import llvmlite.binding
    from numba.core.compiler_lock import global_compiler_lock

    with global_compiler_lock:
        llvmlite.binding.set_option("", "-enable-misched=false")
        try:
            yield
        finally:
            llvmlite.binding.set_option("", "-enable-misched=true")  # as without


@contextlib.contextmanager
def _one_process_at_a_time(name: str) -> Iterator[None]:
    """Processes that want the same kernel wait for the first to compile it (where the system can lock files)."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    with open(_cache_folder() / f"kernel_{name}.lock", "w") as file:
        with contextlib.suppress(OSError):  # a folder on a network that has no locks
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


@functools.lru_cache(maxsize=128)
def loaded(name: str, text: str, entry: str) -> Any:
    folder = _cache_folder()
    path = folder / f"kernel_{name}.py"
    if not path.exists():
        handle, temporary = tempfile.mkstemp(dir=folder, suffix=".tmp")
        with os.fdopen(handle, "w") as file:
            file.write(text)
        os.replace(temporary, path)
    module_name = f"vibrocap_kernel_{name}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    spec.loader.exec_module(module)
    return getattr(module, entry)


class UnsignedIndices(ast.NodeTransformer):
    """Index the memory by unsigned numbers: a signed one may be negative and count from the end, and the code that
    Numba adds for that case doubles the time of a step."""

    def visit_Subscript(self, node: ast.Subscript) -> ast.Subscript:
        self.generic_visit(node)
        if isinstance(node.value, ast.Name) and node.value.id in ("real", "whole", "tape"):
            unsigned = ast.Attribute(ast.Name("np", ast.Load()), "uintp", ast.Load())
            node.slice = ast.Call(unsigned, [node.slice], [])
        return node


def _decorated(text: str, entry: str) -> str:
    """The kernel's text as Numba gets it."""
    tree = ast.fix_missing_locations(UnsignedIndices().visit(ast.parse(text)))
    lines = []
    for line in ast.unparse(tree).splitlines():
        if line.startswith("def "):
            decorators = (ENTRY_DECORATOR,) if line.startswith(f"def {entry}(") else DECORATORS
            lines.extend(f"@{decorator}" for decorator in decorators)
        lines.append(line)
    return "\n".join(lines) + "\n"


@functools.cache
def _cache_folder() -> pathlib.Path:
    """Where kernels are kept: VIBROCAP_CACHE, else the user's cache folder, else a temporary one."""
    default = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "vibrocap"
    for folder in (os.environ.get("VIBROCAP_CACHE"), default):
        if folder:
            with contextlib.suppress(OSError):
                path = pathlib.Path(folder)
                path.mkdir(parents=True, exist_ok=True)
                if os.access(path, os.W_OK):
                    return path
    return pathlib.Path(tempfile.mkdtemp(prefix="vibrocap-"))
