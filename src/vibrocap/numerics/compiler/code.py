"""The LLVM code of one function as it is written: instructions, blocks, and values turned into other kinds."""

from typing import TYPE_CHECKING

from vibrocap.numerics.compiler.kinds import (
    BOOL,
    ELEMENTS,
    FLOAT,
    FLOATS,
    INT,
    PLACES,
    Kind,
    Value,
    joined,
    literal,
    numbers,
    tuple_of,
)
from vibrocap.numerics.compiler.typed.nodes import WRITERS, Function, Typed

if TYPE_CHECKING:
    from vibrocap.numerics.compiler.lowering import Module

ALIGNED = ", align 8"  # of all lanes, of which the first may stand anywhere


class Code:
    """One function of the typed tree in LLVM's language."""

    def __init__(self, module: "Module", function: Function):
        self.module, self.function = module, function
        self.attributes = "nounwind"
        self.lines: list[str] = []
        self.known: dict[Typed, Value] = {}  # what is evaluated once and read again
        self.count = 0
        self.open = True  # whether what is written next can be reached
        self.block = "start"
        self.loops: list[tuple[str, str]] = []  # where continue goes, where break goes

    def emit(self, kind: Kind, code: str) -> Value:
        """An instruction with a result."""
        self.count += 1
        name = f"%t{self.count}"
        self.lines.append(f"  {name} = {code}")
        return Value(kind, name)

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

    def value(self, node: Typed) -> Value:
        """The code of a value of the typed tree."""
        return getattr(self, WRITERS[type(node)])(node)

    def as_kind(self, value: Value, kind: Kind) -> Value:
        """A value as one of another kind that can hold it."""
        if value.kind == kind:
            return self.packed(value) if kind.items else value
        if kind.items and len(kind.items) == len(value.kind.items):
            items = self.items(value) or ()
            return self.packed(
                self.tupled([self.as_kind(item, part) for item, part in zip(items, kind.items, strict=True)]),
            )
        if value.kind == PLACES:
            return value
        assert joined(value.kind, kind) == kind
        if kind.lanes:
            return self.spread(self.as_kind(value, FLOAT))
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

    def items(self, value: Value) -> tuple[Value, ...]:
        """The items of a tuple."""
        if value.items is None:
            code = f"extractvalue {value.kind.llvm} {value.text}"
            value.items = tuple(self.emit(kind, f"{code}, {i}") for i, kind in enumerate(value.kind.items))
        return value.items

    def packed(self, value: Value) -> Value:
        """A tuple as one value of LLVM's."""
        if not value.text:
            text = "poison"
            for i, item in enumerate(value.items or ()):
                part = self.packed(item) if item.kind.items else item
                text = self.emit(
                    value.kind, f"insertvalue {value.kind.llvm} {text}, {part.kind.llvm} {part.text}, {i}"
                ).text
            return Value(value.kind, text, value.constant, value.items)
        return value

    def read(self, kind: Kind, pointer: str) -> Value:
        """What stands at a pointer; of all lanes, side by side."""
        return self.emit(kind, f"load {kind.llvm}, ptr {pointer}{ALIGNED if kind.lanes else ''}")

    def pointer(self, array: Value, place: Value) -> str:
        """Pointer to an entry of an array."""
        element = ELEMENTS[array.kind].llvm
        return self.emit(FLOATS, f"getelementptr inbounds {element}, ptr {array.text}, i64 {place.text}").text
