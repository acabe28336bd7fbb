"""The language of kernels: a small part of Python with fixed types. What it means is what Python makes of it.

A kernel is one text: constants, then functions, of which one is called from outside.

- Imports: `import math`, `import numpy as np`, and names of `vibrocap.numerics.kernel.arithmetic.plain_vectors`.
- Constants: statements between the functions are executed as they are; a number, a tuple of numbers or a NumPy array of
  one or two dimensions can then be used in functions. Functions do not change them.
- Functions: positional arguments without defaults, no recursion, no nested functions. One machine function is made of
  each for every combination of kinds of arguments that occurs.
- Kinds: float (64 bits), int (64 bits, wraps around), bool, tuples, flat arrays of floats or ints, constant tables, and
  the numbers and choices of all lanes side by side. A name keeps one kind in a function; int and float join to float.
- Places of all lanes (`all_lanes()`), to which an int may be added, are an index, too: such an entry of an array of
  floats is the numbers of all lanes. So one function serves one lane, given an int, and all of them.
- Arrays are arguments and stay so: they have no name but that of the argument, and the arrays of one call are different
  ones that share no memory. An index counts from 0, and nothing checks it.
- Statements: assignment to one name, entry or tuple of these; augmented assignment; if, while, `for ... in range(...)`
  (the step is a constant), break, continue, return, pass, calls. No else after a loop, no try, with, assert, import.
- Expressions: + - * / **, of ints // and %, & | ^ << >> ~, comparisons (chains too), `x in (a, b)`, and, or, not,
  `a if c else b`, tuples and their items at constant places.
- Calls: functions of the kernel; abs, min, max, float, int; sin, cos, exp, log, sqrt, tanh, atan, floor of math;
  np.floor, np.float64(x).view(np.int64) and back; what `lanes.py` of this package lists.
- A condition that is known from constants alone is decided before types are: the other branch need not compile.

What differs from Python, as errors are none: a division by zero gives inf, nan or, of ints, 0; log and sqrt of a
negative number are nan. Sums of products may be contracted to fused ones. `x ** k` with an int k is repeated squaring.
"""

import ast
import bisect
import contextlib
import dataclasses
import gc
import re
from collections.abc import Iterator
from typing import Any

PLAIN_VECTORS = "vibrocap.numerics.kernel.arithmetic.plain_vectors"
ORIGIN = re.compile(r"^# From (.+)$", re.MULTILINE)  # a line of the text above what another file gave
# Functions of `elementary_polynomials.py` and `own_functions.py`, for those of `math` where a target has none.
LIBRARY = {
    "sin": "sine",
    "cos": "cosine",
    "exp": "exponential",
    "log": "logarithm",
    "tanh": "hyperbolic_tangent",
    "atan": "arc_tangent",
    "pow": "power",
}


class Refused(ValueError):
    """A construct outside the language of kernels."""


@dataclasses.dataclass(frozen=True)
class Kernel:
    """The parts of a kernel's text."""

    functions: dict[str, ast.FunctionDef]
    constants: dict[str, Any]
    primitives: frozenset[str]  # names of `plain_vectors` that are imported
    lines: list[str]
    origins: tuple[list[int], list[str]]  # lines of the text, and the files that gave what follows

    def refusal(self, node: ast.AST, function: str, what: str) -> Refused:
        """What to raise at a place of the text."""
        line = getattr(node, "lineno", 1)
        starts, files = self.origins
        index = bisect.bisect_right(starts, line) - 1
        within = ""
        if function in self.functions:
            within = f", function `{function}`, line {line - self.functions[function].lineno + 1} of it"
        text = self.lines[line - 1].strip() if line <= len(self.lines) else ""
        file = files[index] if index >= 0 else "kernel"
        return Refused(f"{file}{within} (line {line} of the kernel): `{text[:100]}`: {what}")


@contextlib.contextmanager
def uncollected() -> Iterator[None]:
    """While this lasts, Python does not look for circles of objects that nothing else needs.

    The trees of a kernel are hundreds of thousands of objects, of which none can go before its code is made: to look
    through them again and again took a third of the time.
    """
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.enable()


def defines(text: str, name: str) -> bool:
    """Whether a kernel's text defines a function."""
    return f"\ndef {name}(" in f"\n{text}"


def parsed(text: str) -> Kernel:
    """The parts of a kernel's text; raises Refused where it is no kernel."""
    functions: dict[str, ast.FunctionDef] = {}
    constants: list[ast.stmt] = []
    primitives: set[str] = set()
    lines = text.splitlines()
    marks = list(ORIGIN.finditer(text))
    origins = ([text.count("\n", 0, mark.start()) + 1 for mark in marks], [mark[1] for mark in marks])
    kernel = Kernel(functions, {}, frozenset(), lines, origins)
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef):
            if node.name in functions:
                raise kernel.refusal(node, "", f"`{node.name}` is defined twice; give one of the two another name")
            _check_head(kernel, node)
            functions[node.name] = node
        elif isinstance(node, ast.ImportFrom) and node.module == PLAIN_VECTORS:
            primitives.update(alias.name for alias in node.names)
            if any(alias.asname for alias in node.names):
                raise kernel.refusal(node, "", "import the names of lanes as they are, without `as`")
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            if ast.unparse(node) not in ("import math", "import numpy as np"):
                raise kernel.refusal(node, "", "a kernel imports math, numpy as np and plain_vectors only")
            constants.append(node)
        else:
            constants.append(node)
    names: dict[str, Any] = {}
    exec(compile(ast.Module(constants, []), "<constants of a kernel>", "exec"), names)
    return dataclasses.replace(kernel, constants=names, primitives=frozenset(primitives - functions.keys()))


def _check_head(kernel: Kernel, node: ast.FunctionDef) -> None:
    arguments = node.args
    if node.decorator_list:
        raise kernel.refusal(node, "", "a kernel's function has no decorator; leave it out")
    if arguments.defaults or arguments.kwonlyargs or arguments.vararg or arguments.kwarg or arguments.posonlyargs:
        raise kernel.refusal(node, "", "arguments are positional and have no defaults; write them out at every call")


def names_assigned(function: ast.FunctionDef) -> tuple[set[str], set[str]]:
    """(all names that are assigned, those at one place and read only behind it in the same block).

    A name of the latter is a value, no variable.
    """
    assigned: dict[str, list[tuple[int, ...]]] = {}
    read: dict[str, list[tuple[int, ...]]] = {}
    blocks = 0

    def visit(node: ast.AST, path: tuple[int, ...]) -> None:
        nonlocal blocks
        kind = type(node)
        if kind is ast.Name:
            (read if type(node.ctx) is ast.Load else assigned).setdefault(node.id, []).append(path)  # pyright: ignore
        elif kind is ast.BinOp:  # most of what there is, and all that is within
            visit(node.left, path)  # pyright: ignore
            visit(node.right, path)  # pyright: ignore
        elif kind is ast.Assign:
            for target in node.targets:  # pyright: ignore
                visit(target, path)
            visit(node.value, path)  # pyright: ignore
        elif kind is not ast.Constant:
            further(node, kind, path)

    def further(node: ast.AST, kind: type, path: tuple[int, ...]) -> None:
        nonlocal blocks
        if kind is ast.AugAssign and isinstance(node.target, ast.Name):  # pyright: ignore
            assigned.setdefault(node.target.id, []).append(path)  # pyright: ignore
        nested = kind in (ast.If, ast.For, ast.While, ast.FunctionDef)
        for name in node._fields:
            field = getattr(node, name, None)
            if type(field) is list:
                inner = path
                if nested and name in ("body", "orelse"):
                    blocks += 1
                    inner = (*path, blocks)
                for child in field:
                    if isinstance(child, ast.AST):
                        visit(child, inner)
            elif isinstance(field, ast.AST) and name not in ("ctx", "op"):
                # A loop's variable is one of its body; its condition is asked again behind the body.
                visit(field, (*path, blocks + 1) if kind is ast.For and name == "target" else path)

    visit(function, ())
    arguments = {argument.arg for argument in function.args.args}
    once = {
        name
        for name, places in assigned.items()
        if len(places) == 1
        and name not in arguments
        and all(path[: len(places[0])] == places[0] for path in read.get(name, ()))
    }
    return set(assigned), once


OWN = {
    "sine": "def sine(x):\n    return sine_cosine(x)[0]\n",
    "cosine": "def cosine(x):\n    return sine_cosine(x)[1]\n",
    "power": "def power(x, y):\n    return exponential(y * logarithm(x))\n",
}
# A power whose exponent is not known: repeated squaring, in the order in which a known one is written out.
WHOLE_POWER = """
def whole_power(x, k):
    power, left = 1.0, abs(k)
    while left != 0:
        if left & 1:
            power = power * x
        x = x * x
        left >>= 1
    return 1.0 / power if k < 0 else power
"""


def with_own_functions(text: str) -> str:
    """A kernel that has polynomials, with all functions of `math` made of them."""
    missing = [own for name, own in OWN.items() if not defines(text, name) and defines(text, "sine_cosine")]
    return "\n\n".join([text, "# From compiler/own_functions", *missing]) if missing else text
