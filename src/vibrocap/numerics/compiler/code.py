"""The code of one function as it is written: instructions, blocks, and values turned into other kinds."""

import ast
import functools
from collections.abc import Callable
from typing import TYPE_CHECKING

from vibrocap.numerics.compiler.kinds import (
    BOOL,
    ELEMENTS,
    FLOAT,
    FLOATS,
    INT,
    Kind,
    Value,
    joined,
    literal,
    numbers,
    tuple_of,
)
from vibrocap.numerics.compiler.subset import names_assigned

if TYPE_CHECKING:
    from vibrocap.numerics.compiler.lowering import Module


class Code:
    """One function for one combination of kinds of arguments."""

    def __init__(self, module: "Module", node: ast.FunctionDef, kinds: tuple[Kind, ...]):
        self.module, self.node, self.kinds = module, node, kinds
        self.variables: dict[str, Kind] = {}  # those that live in memory until LLVM makes them registers
        self.result: Kind | None = None
        self.attributes = "nounwind"
        self.text = ""
        self.lines: list[str] = []
        self.bound: dict[str, Value] = {}  # names that are a value, no variable
        self.count = 0
        self.open = True  # whether what is written next can be reached
        self.block = "start"
        self.loops: list[list] = []  # [where continue goes, where break goes, whether break was used]
        self._assigned, self._once = names_assigned(node)

    def refusal(self, node: ast.AST, what: str) -> Exception:
        """What to raise at a place of this function."""
        return self.module.kernel.refusal(node, self.node.name, what)

    def emit(self, kind: Kind, code: str) -> Value:
        """An instruction with a result."""
        self.count += 1
        name = f"%t{self.count}"
        self.lines.append(f"  {name} = {code}")
        return Value(kind, name)

    def begin(self) -> None:
        """The function is written anew."""
        self.lines, self.bound, self.count = [], {}, 0
        self.block, self.open, self.loops = "start", True, []

    def do(self, code: str) -> None:
        """An instruction without one."""
        self.lines.append(f"  {code}")

    def need(self, text: str) -> None:
        """Something to stand in the module once."""
        self.module.need(text)

    def label(self) -> str:
        """A name for a block."""
        self.count += 1
        return f"b{self.count}"

    def start(self, label: str) -> None:
        """A block begins."""
        self.lines.append(f"{label}:")
        self.block, self.open = label, True

    def _end(self, code: str) -> None:
        self.do(code)
        self.open = False

    def _jump(self, label: str) -> None:
        self._end(f"br label %{label}")

    def _fork(self, condition: Value, yes: str, no: str) -> None:
        self._end(f"br i1 {condition.text}, label %{yes}, label %{no}")

    # --- values as other kinds ---------------------------------------------------------------------------------------

    def value(self, node: ast.expr) -> Value:
        """The value of an expression."""
        handler = getattr(self, f"_of_{type(node).__name__}", None)
        if handler is None:
            raise self.refusal(node, f"no kernel has {named(node)}; see compiler/subset.py for what it has")
        return handler(node)

    def condition(self, node: ast.expr) -> Value:
        """An expression as yes or no."""
        if isinstance(node, ast.BoolOp):  # of which only the truth is asked, so that its parts may be numbers
            parts = [functools.partial(self.condition, part) for part in node.values]
            return self.one_after_another(node, parts, isinstance(node.op, ast.And))
        value = self.value(node)
        if value.kind == BOOL:
            return value
        if value.kind not in (INT, FLOAT):
            raise self.refusal(node, f"{value.kind.name} is neither yes nor no; use bits(...) != 0 of choices")
        if value.constant is not None:
            return literal(bool(value.constant)) or value
        zero = "icmp ne i64" if value.kind == INT else "fcmp une double"
        return self.emit(BOOL, f"{zero} {value.text}, {'0' if value.kind == INT else '0.0'}")

    def one_after_another(self, node: ast.AST, parts: list[Callable[[], Value]], all_of: bool) -> Value:
        """Conditions of which the next is asked only while all (or none) so far hold."""
        raise NotImplementedError

    def of_kernel(self, node: ast.AST, name: str, arguments: list[Value]) -> Value:
        """A call of one of the kernel's own functions."""
        raise NotImplementedError

    def as_kind(self, node: ast.AST, value: Value, kind: Kind) -> Value:
        """A value as one of another kind that can hold it."""
        if value.kind == kind:
            return self.packed(node, value) if kind.items else value
        if kind.items and len(kind.items) == len(value.kind.items):
            items = self.items(value) or ()
            return self.packed(
                node,
                self.tupled([self.as_kind(node, item, part) for item, part in zip(items, kind.items, strict=True)]),
            )
        if joined(value.kind, kind) != kind:
            raise self.refusal(node, f"{value.kind.name} where {kind.name} is needed; convert it")
        if kind.lanes:
            return self.spread(self.as_kind(node, value, FLOAT))
        if value.constant is not None:
            return literal(float(value.constant) if kind == FLOAT else int(value.constant)) or value
        if kind == INT:
            return self.emit(INT, f"zext i1 {value.text} to i64")
        return self.emit(FLOAT, f"{'uitofp i1' if value.kind == BOOL else 'sitofp i64'} {value.text} to double")

    def spread(self, value: Value) -> Value:
        """A float in every lane."""
        kind, width = numbers(self.module.width), self.module.width
        if value.constant is not None:
            return Value(kind, f"<{', '.join([f'double {value.text}'] * width)}>")
        first = self.emit(kind, f"insertelement {kind.llvm} poison, double {value.text}, i32 0")
        places = f"<{width} x i32> zeroinitializer"
        return self.emit(kind, f"shufflevector {kind.llvm} {first.text}, {kind.llvm} poison, {places}")

    def tupled(self, items: list[Value]) -> Value:
        """A tuple of values."""
        return Value(tuple_of(tuple(item.kind for item in items)), "", None, tuple(items))

    def items(self, value: Value) -> tuple[Value, ...] | None:
        """The items of a tuple."""
        if value.items is None and value.kind.items:
            code = f"extractvalue {value.kind.llvm} {value.text}"
            value.items = tuple(self.emit(kind, f"{code}, {i}") for i, kind in enumerate(value.kind.items))
        return value.items

    def packed(self, node: ast.AST, value: Value) -> Value:
        """A tuple as one value of LLVM's."""
        if not value.text:
            text = "poison"
            for i, item in enumerate(value.items or ()):
                part = self.packed(node, item) if item.kind.items else item
                text = self.emit(
                    value.kind, f"insertvalue {value.kind.llvm} {text}, {part.kind.llvm} {part.text}, {i}"
                ).text
            return Value(value.kind, text, value.constant, value.items)
        return value

    def pointer(self, array: Value, place: Value) -> str:
        """Pointer to an entry of an array."""
        element = ELEMENTS[array.kind].llvm
        return self.emit(FLOATS, f"getelementptr inbounds {element}, ptr {array.text}, i64 {place.text}").text


def named(node: ast.AST) -> str:
    """What a construct is called."""
    return f"`{type(node).__name__}`"
