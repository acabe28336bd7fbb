"""Values in JavaScript: how a number, a name or a tuple is written, and how one kind of value becomes another."""

import ast
import functools
import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING

from vibrocap.numerics.compiler.code import named
from vibrocap.numerics.compiler.kinds import BOOL, FLOAT, INT, TABLE, Kind, Value, joined, tuple_of
from vibrocap.numerics.compiler.subset import names_assigned

if TYPE_CHECKING:
    from vibrocap.numerics.compiler.javascript import Module

BITS = Kind("int", "i64")  # an int as a BigInt
LARGEST = 2**53  # up to which every int is a float
SIMPLE = re.compile(r"[\w$]+|\(-?[\d.e+-]+\)")  # what may be written twice
RESERVED = re.compile(  # names that Python lets be variables and JavaScript does not, and those used below
    "arguments|case|catch|const|debugger|default|delete|do|enum|eval|export|extends|false|function|implements|"
    "instanceof|interface|let|new|null|package|private|protected|public|static|super|switch|this|throw|true|typeof|"
    "undefined|var|void|Math|Number|Object|BigInt|Infinity|NaN|Float64Array|BigInt64Array"
)
# Names with two $ are of these; the kernel's own functions have one before them, a variable none.
HELPERS = {
    "least": "const $$least = (a, b) => b < a ? b : a;",
    "greatest": "const $$greatest = (a, b) => b > a ? b : a;",
    "whole": "const $$whole = (x) => Math.abs(x) < 9223372036854775808 ? Math.trunc(x) + 0 : -9223372036854775808;",
    "bits": "const $$bits = (x) => Math.abs(x) < 9223372036854775808 ? BigInt(x) : -9223372036854775808n;",
    "cell": "const $$cell = new Float64Array(1), $$cell_bits = new BigInt64Array($$cell.buffer);",
    "bits_of": "const $$bits_of = (x) => { $$cell[0] = x; return $$cell_bits[0]; };",
    "float_of": "const $$float_of = (k) => { $$cell_bits[0] = k; return $$cell[0]; };",
    "floor_rest": """const $$floor_rest = (x, y) => {
  if (y === 0) return 0;
  const r = x % y;
  return (r !== 0 && (r < 0) !== (y < 0) ? r + y : r) + 0;
};""",
    "bits_floor_rest": """const $$bits_floor_rest = (x, y) => {
  if (y === 0n) return 0n;
  const r = x % y;
  return r !== 0n && (r < 0n) !== (y < 0n) ? r + y : r;
};""",
    "bits_floor_divided": """const $$bits_floor_divided = (x, y) =>
  y === 0n ? 0n : BigInt.asIntN(64, (x - $$bits_floor_rest(x, y)) / y);""",
    "floor_divided": "const $$floor_divided = (x, y) => y === 0 ? 0 : (x - $$floor_rest(x, y)) / y + 0;",
    "float_floor_rest": """const $$float_floor_rest = (x, y) => {
  const r = x % y;
  if (r === 0) return y < 0 || Object.is(y, -0) ? -0 : 0;
  return (y < 0) !== (r < 0) ? r + y : r;
};""",
    "float_floor_divided": """const $$float_floor_divided = (x, y) => {
  if (y === 0) return x / y;
  const r = x % y;
  let q = (x - r) / y;
  if (r !== 0 && (y < 0) !== (r < 0)) q = q - 1;
  if (q === 0) return x / y < 0 || Object.is(x / y, -0) ? -0 : 0;
  const whole = Math.floor(q);
  return q - whole > 0.5 ? whole + 1 : whole;
};""",
    "whole_power": """const $$whole_power = (x, k) => {
  let left = Math.abs(k), power = 1, square = x;
  while (left !== 0) {
    if (left % 2 === 1) power = power * square;
    left = Math.floor(left / 2);
    if (left !== 0) square = square * square;
  }
  return k < 0 ? 1 / power : power;
};""",
}
NEEDS = {
    "floor_divided": ("floor_rest",),
    "bits_floor_divided": ("bits_floor_rest",),
    "bits_of": ("cell",),
    "float_of": ("cell",),
}


def variable_name(name: str) -> str:
    """A name of Python's as one of JavaScript's."""
    return name + "$" if RESERVED.fullmatch(name) else name


def float_literal(number: float) -> str:
    """A float as JavaScript reads it, all its bits."""
    if math.isnan(number):
        return "NaN"
    if math.isinf(number):
        return "Infinity" if number > 0.0 else "(-Infinity)"
    shown = repr(number).removesuffix(".0")
    return f"({shown})" if shown.startswith("-") else shown


def joined_kind(one: Kind, other: Kind) -> Kind | None:
    """The kind that holds values of both; an int that is taken as bits stays so."""
    if BITS in (one, other):
        rest = {one, other} - {BITS}
        return BITS if rest <= {INT, BOOL} else FLOAT if rest == {FLOAT} else None
    if one.items and len(one.items) == len(other.items):
        items = [joined_kind(a, b) for a, b in zip(one.items, other.items, strict=True)]
        return None if None in items else tuple_of(tuple(item for item in items if item is not None))
    return joined(one, other)


class Values:
    """Writes the values of one function."""

    def __init__(self, module: "Module", node: ast.FunctionDef, kinds: tuple[Kind, ...]):
        self.module, self.node, self.kinds = module, node, kinds
        self.variables: dict[str, Kind] = {}
        self.result: Kind | None = None
        self.text = ""
        self.lines: list[str] = []
        self.bound: dict[str, Value] = {}  # arguments that stay what they are, and names that are known constants
        self.depth = self.count = 0
        self.loops: list[bool] = []  # whether break was used
        self._assigned, self._once = names_assigned(node)

    def refusal(self, node: ast.AST, what: str) -> Exception:
        """What to raise at a place of this function."""
        return self.module.kernel.refusal(node, self.node.name, what)

    def do(self, code: str) -> None:
        """A line of code."""
        self.lines.append("  " * self.depth + code)

    def once(self, value: Value) -> tuple[Value, Value]:
        """(the value where it is first needed, and wherever again): what is no name or number is given a name."""
        if value.items is not None or SIMPLE.fullmatch(self.written_out(value)):
            return value, value
        self.count += 1
        name = f"${self.count}"
        return Value(value.kind, f"({name} = {self.written_out(value)})"), Value(value.kind, name)

    def value(self, node: ast.expr) -> Value:
        """The value of an expression."""
        handler = getattr(self, f"_of_{type(node).__name__}", None)
        if handler is None:
            raise self.refusal(node, f"no kernel has {named(node)}; see compiler/subset.py for what it has")
        return handler(node)

    def written_out(self, value: Value) -> str:
        """A value in JavaScript."""
        if value.items is not None:
            return f"[{', '.join(self.written_out(item) for item in value.items)}]"
        if value.constant is None or value.kind == TABLE:
            return value.text
        if value.kind == BOOL:
            return "true" if value.constant else "false"
        if value.kind == BITS:
            return f"{value.constant}n" if value.constant >= 0 else f"({value.constant}n)"
        return float_literal(value.constant) if value.kind == FLOAT else self._whole_text(value.constant)

    def _whole_text(self, number: int) -> str:
        if abs(number) > LARGEST:
            raise self.refusal(self.node, f"{number} is beyond 2^53; use it as bits only, or as a float")
        return str(number) if number >= 0 else f"({number})"

    def as_kind(self, node: ast.AST, value: Value, kind: Kind) -> Value:
        """A value as one of another kind that can hold it; bits are an int wherever one is asked for."""
        if value.kind == kind:
            return value
        if kind.items and len(kind.items) == len(value.kind.items):
            if value.items is None:
                first, again = self.once(value)
                texts = [first.text, *[again.text] * (len(kind.items) - 1)]
                pairs = zip(texts, value.kind.items, strict=True)
                items = tuple(Value(part, f"{text}[{i}]") for i, (text, part) in enumerate(pairs))
            else:
                items = value.items
            made = tuple(self.as_kind(node, item, part) for item, part in zip(items, kind.items, strict=True))
            return Value(kind, "", None, made)
        if (value.kind, kind) != (BITS, INT) and joined_kind(value.kind, kind) != kind:
            raise self.refusal(node, f"{value.kind.name} where {kind.name} is needed; convert it")
        if value.constant is not None:
            return Value(kind, "", float(value.constant) if kind == FLOAT else int(value.constant))
        if value.kind == BITS:
            return Value(kind, f"Number({value.text})")
        text = f"({value.text} ? 1 : 0)" if value.kind == BOOL else value.text
        return Value(kind, f"{self.module.helper('bits')}({text})" if kind == BITS else text)

    def texts(self, node: ast.AST, kind: Kind, *values: Value) -> list[str]:
        """Values of one kind in JavaScript."""
        return [self.written_out(self.as_kind(node, value, kind)) for value in values]

    def condition(self, node: ast.expr) -> Value:
        """An expression as yes or no."""
        if isinstance(node, ast.BoolOp):  # of which only the truth is asked, so that its parts may be numbers
            parts = [functools.partial(self.condition, part) for part in node.values]
            return self.one_after_another(parts, isinstance(node.op, ast.And))
        value = self.value(node)
        if value.kind == BOOL:
            return value
        if value.kind not in (INT, BITS, FLOAT):
            raise self.refusal(node, f"{value.kind.name} is neither yes nor no")
        if value.constant is not None:
            return Value(BOOL, "", bool(value.constant))
        return Value(BOOL, f"({value.text} !== {'0n' if value.kind == BITS else '0'})")

    def one_after_another(self, parts: list[Callable[[], Value]], all_of: bool) -> Value:
        """Conditions of which the next is asked only while all (or none) so far hold."""
        texts: list[str] = []
        for part in parts:
            value = part()
            if value.constant is not None and value.constant == all_of:
                continue  # decides nothing
            if value.constant is not None and not texts:
                return value
            texts.append(self.written_out(value))
            if value.constant is not None:
                break
        return Value(BOOL, f"({(' && ' if all_of else ' || ').join(texts)})") if texts else Value(BOOL, "", all_of)
