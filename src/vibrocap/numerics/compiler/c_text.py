"""C99: a kernel as the text of functions in C, from the typed tree, with the bits of plain Python.

Every sum and product is rounded, none are fused, and the functions of `math` are the kernel's own polynomials; of
math.h only floor, sqrt and fabs are called, which are exact everywhere. A compiler that was told to compute otherwise
(-ffast-math, registers of 80 bits) is refused by the text itself. Ints wrap around, as in the other targets.
"""

from collections.abc import Sequence
from typing import Any

from vibrocap.numerics.compiler.c_functions import CFunction, number_text
from vibrocap.numerics.compiler.kinds import BOOL, ELEMENTS, FLOAT, FLOATS, INT, INTS, NOTHING, Kind
from vibrocap.numerics.compiler.subset import LIBRARY, Refused, parsed, uncollected, with_own_functions
from vibrocap.numerics.compiler.typed import nodes
from vibrocap.numerics.compiler.typed.program import Program

GUARDS = """#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || defined(_M_FP_FAST)
#error "Compile this file without -ffast-math: its contact decisions need IEEE arithmetic."
#endif
#if !defined(FLT_EVAL_METHOD) || FLT_EVAL_METHOD != 0
#error "This file needs doubles of 64 bits throughout; on 32-bit x86 compile with -msse2 -mfpmath=sse."
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-but-set-variable"
#endif
"""
# What C has no operator for; its name in braces gets the prefix. An int divided by 0 gives 0.
HELPERS = {
    "add": "int64_t {add}(int64_t x, int64_t y) { return (int64_t)((uint64_t)x + (uint64_t)y); }",
    "sub": "int64_t {sub}(int64_t x, int64_t y) { return (int64_t)((uint64_t)x - (uint64_t)y); }",
    "mul": "int64_t {mul}(int64_t x, int64_t y) { return (int64_t)((uint64_t)x * (uint64_t)y); }",
    "shl": "int64_t {shl}(int64_t x, int64_t y) { return (int64_t)((uint64_t)x << y); }",
    "shr": "int64_t {shr}(int64_t x, int64_t y) { return x < 0 ? ~(~x >> y) : x >> y; }",
    "magnitude": "int64_t {magnitude}(int64_t x) { return x < 0 ? (int64_t)(0 - (uint64_t)x) : x; }",
    "bits": "int64_t {bits}(double x) { int64_t n; memcpy(&n, &x, sizeof n); return n; }",
    "float_of": "double {float_of}(int64_t n) { double x; memcpy(&x, &n, sizeof x); return x; }",
    # what no int64_t holds, such as the exponent of an infinite power, becomes what processors make of it
    "truncated": """int64_t {truncated}(double x) {
  return x >= -9223372036854775808.0 && x < 9223372036854775808.0 ? (int64_t)x : INT64_MIN;
}""",
    "floor_divided": """int64_t {floor_divided}(int64_t x, int64_t y) {
  if (y == 0) return 0;
  if (y == -1) return (int64_t)(0 - (uint64_t)x);
  return x / y - (x % y != 0 && (x % y < 0) != (y < 0));
}""",
    "floor_rest": """int64_t {floor_rest}(int64_t x, int64_t y) {
  int64_t r = y == 0 || y == -1 ? 0 : x % y;
  return r != 0 && (r < 0) != (y < 0) ? r + y : r;
}""",
}


TYPES = {FLOAT: "double", INT: "int64_t", BOOL: "int", NOTHING: "void"}
ARRAYS = {FLOATS: "double *restrict ", INTS: "int64_t *restrict "}


def c_source(
    text: str, entries: Sequence[str], prefix: str, arguments: tuple[Kind, ...] = (FLOATS, INTS, FLOATS, INT)
) -> str:
    """The C of a kernel, all of whose functions are static; those that the caller is to call are `PREFIX_ENTRY`.

    prefix: of every name, a C identifier
    Raises Refused where the text is no kernel of one motion.
    """
    with uncollected():
        program, written = Program(parsed(with_own_functions(text)), 0, LIBRARY), Module(prefix)
        for entry in entries:
            written.written(program.entry(entry, arguments))
    return written.text


class Module:
    """A kernel on its way to C: what is written so far, in the order in which C wants it."""

    def __init__(self, prefix: str):
        self.prefix = prefix
        self.tuples: dict[Kind, str] = {}
        self.types: list[str] = []
        self.needed: dict[str, str] = {}  # helpers and tables
        self.bodies: list[str] = []
        self.names: dict[nodes.Function, str] = {}

    @property
    def text(self) -> str:
        """All of it."""
        return "\n".join([GUARDS, *self.types, *self.needed.values(), *self.bodies])

    def type(self, kind: Kind) -> str:
        """The C type of a kind."""
        if kind.items:
            if kind not in self.tuples:
                items = " ".join(f"{self.type(item)} i{i};" for i, item in enumerate(kind.items))
                self.tuples[kind] = f"{self.prefix}_tuple{len(self.tuples)}"
                self.types.append(f"typedef struct {{ {items} }} {self.tuples[kind]};")
            return self.tuples[kind]
        if kind not in TYPES:
            raise Refused(f"C has no {kind.name}; write the kernel for one lane")
        return TYPES[kind]

    def helper(self, name: str) -> str:
        """The name of a helper, put into the text."""
        if name not in self.needed:
            self.needed[name] = "static " + HELPERS[name].replace(f"{{{name}}}", f"{self.prefix}_c_{name}")
        return f"{self.prefix}_c_{name}"  # a function of the kernel may have the same name

    def table(self, name: str, numbers: list[Any]) -> str:
        """The name of a constant array, put into the text."""
        kind = FLOAT if isinstance(numbers[0], float) else INT
        items = ", ".join(number_text(number) for number in numbers)
        content = f"static const {TYPES[kind]} {self.prefix}_{name}[{len(numbers)}] = {{{items}}};"
        self.needed.setdefault(f"table {name}", content)
        return f"{self.prefix}_{name}"

    def head(self, function: nodes.Function, name: str) -> str:
        """A function's first line."""
        kinds = (ARRAYS[kind] if kind in ELEMENTS else f"{self.type(kind)} " for _, kind in function.arguments)
        passed = ", ".join(f"{kind}a_{argument}" for kind, (argument, _) in zip(kinds, function.arguments, strict=True))
        return f"{self.type(function.result)} {name}({passed or 'void'})"

    def written(self, function: nodes.Function) -> str:
        """The name of a function, which is written when first called."""
        if function not in self.names:
            name = f"{self.prefix}_{function.name.replace('.', '_')}"
            body = CFunction(self, function).written()
            self.names[function] = name
            self.bodies.append(f"static {self.head(function, name)} {{\n{body}\n}}\n")
        return self.names[function]
