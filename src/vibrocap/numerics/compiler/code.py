"""The LLVM code of one function as it is written: instructions, blocks, expressions, and values of other kinds."""

import functools
from typing import TYPE_CHECKING

from vibrocap.numerics.compiler import kinds, lanes
from vibrocap.numerics.compiler.kinds import BOOL, ELEMENTS, FLOAT, FLOATS, INT, NOTHING, PLACES, Kind, Value
from vibrocap.numerics.compiler.typed import nodes
from vibrocap.numerics.compiler.typed.nodes import WRITERS, Function, Typed

if TYPE_CHECKING:
    from vibrocap.numerics.compiler.lowering import Module

ARITHMETIC = {"Add": "add", "Sub": "sub", "Mult": "mul", "Div": "div"}
BITWISE = {"BitAnd": "and", "BitOr": "or", "BitXor": "xor", "LShift": "shl", "RShift": "ashr"}
COMPARED = {"Lt": "lt", "LtE": "le", "Gt": "gt", "GtE": "ge", "Eq": "eq", "NotEq": "ne"}
DIVIDED = {"FloorDiv": "floor_divided", "Mod": "floor_rest"}
OF_C = ("tanh", "atan")  # functions that are called by name; LLVM has intrinsics for the others
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
            pairs = zip(self.items(value), kind.items, strict=True)
            return self.packed(self.tupled([self.as_kind(item, part) for item, part in pairs]))
        if value.kind == PLACES:
            return value
        assert kinds.joined(value.kind, kind) == kind
        if kind.lanes:
            return self.spread(self.as_kind(value, INT if kind is kinds.ints(kind.lanes) else FLOAT), kind)
        if value.constant is not None:
            return kinds.literal(float(value.constant) if kind == FLOAT else int(value.constant))
        if kind == INT:
            return self.emit(INT, f"zext i1 {value.text} to i64")
        return self.emit(FLOAT, f"{'uitofp i1' if value.kind == BOOL else 'sitofp i64'} {value.text} to double")

    def spread(self, value: Value, kind: Kind) -> Value:
        """A number in every lane."""
        if value.constant is not None:
            return Value(kind, f"<{', '.join([f'{value.kind.llvm} {value.text}'] * kind.lanes)}>")
        first = self.emit(kind, f"insertelement {kind.llvm} poison, {value.kind.llvm} {value.text}, i32 0")
        places = f"<{kind.lanes} x i32> zeroinitializer"
        return self.emit(kind, f"shufflevector {kind.llvm} {first.text}, {kind.llvm} poison, {places}")

    def tupled(self, items: list[Value]) -> Value:
        """A tuple of values."""
        return Value(kinds.tuple_of(tuple(item.kind for item in items)), "", None, tuple(items))

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
                code = f"insertvalue {value.kind.llvm} {text}, {part.kind.llvm} {part.text}, {i}"
                text = self.emit(value.kind, code).text
            return Value(value.kind, text, value.constant, value.items)
        return value

    def read(self, kind: Kind, pointer: str) -> Value:
        """What stands at a pointer; of all lanes, side by side."""
        return self.emit(kind, f"load {kind.llvm}, ptr {pointer}{ALIGNED if kind.lanes else ''}")

    def pointer(self, array: Value, place: Value) -> str:
        """Pointer to an entry of an array."""
        element = ELEMENTS[array.kind].llvm
        return self.emit(FLOATS, f"getelementptr inbounds {element}, ptr {array.text}, i64 {place.text}").text

    # --- expressions -------------------------------------------------------------------------------------------------

    def _of_Number(self, node: nodes.Number) -> Value:
        return kinds.literal(node.constant)

    def _of_Argument(self, node: nodes.Argument) -> Value:
        return Value(node.kind, f"%a.{node.name}")

    def _of_Variable(self, node: nodes.Variable) -> Value:
        return self.emit(node.kind, f"load {node.kind.llvm}, ptr %v.{node.name}")

    def _again(self, node: nodes.Typed) -> Value:
        return self.known[node]

    _of_Let = _of_Counter = _of_Held = _again

    def _of_Shared(self, node: nodes.Shared) -> Value:
        if node not in self.known:
            self.known[node] = self.value(node.value)
        return self.known[node]

    def _of_Tuple(self, node: nodes.Tuple) -> Value:
        value = self.tupled([self.value(item) for item in node.items])
        value.constant = node.constant
        return value

    def _of_Item(self, node: nodes.Item) -> Value:
        return self.items(self.value(node.base))[node.place]

    def _of_Entry(self, node: nodes.Entry) -> Value:
        return self.read(node.kind, self.pointer(self.value(node.array), self.value(node.place)))

    def _of_TableEntry(self, node: nodes.TableEntry) -> Value:
        table, places = self.module.table(node.table), [self.value(place) for place in node.places]
        place = places[0]
        if len(places) == 2:
            row = self.emit(INT, f"mul nsw i64 {place.text}, {node.table.constant.shape[1]}")
            place = self.emit(INT, f"add nsw i64 {row.text}, {places[1].text}")
        return self._of_memory(node.kind, table, place)

    def _of_Chosen(self, node: nodes.Chosen) -> Value:
        kind = node.kind
        name = "@tuple." + "".join(c if c.isalnum() else "_" for c in repr(node.base.constant))
        items = [kinds.literal(item.constant) for item in node.base.items]
        content = ", ".join(f"{kind.llvm} {item.text}" for item in items)
        array = f"[{len(items)} x {kind.llvm}]"
        self.need(f"{name} = internal unnamed_addr constant {array} [{content}], align 8")
        return self._of_memory(kind, name, self.value(node.place))

    def _of_memory(self, kind: Kind, start: str, place: Value) -> Value:
        pointer = self.emit(FLOATS, f"getelementptr inbounds {kind.llvm}, ptr {start}, i64 {place.text}")
        return self.emit(kind, f"load {kind.llvm}, ptr {pointer.text}")

    def _of_Converted(self, node: nodes.Converted) -> Value:
        return self.as_kind(self.value(node.value), node.kind)

    def _of_Truncated(self, node: nodes.Truncated) -> Value:
        return self.emit(INT, f"fptosi double {self.value(node.value).text} to i64")

    def _of_Viewed(self, node: nodes.Viewed) -> Value:
        value = self.value(node.value)
        return self.emit(node.kind, f"bitcast {value.kind.llvm} {value.text} to {node.kind.llvm}")

    def _of_Truth(self, node: nodes.Truth) -> Value:
        value = self.value(node.value)
        zero = "icmp ne i64" if value.kind == INT else "fcmp une double"
        return self.emit(BOOL, f"{zero} {value.text}, {'0' if value.kind == INT else '0.0'}")

    # --- operators ---------------------------------------------------------------------------------------------------

    def _of_Binary(self, node: nodes.Binary) -> Value:
        kind, op = node.operands, node.operator
        left = self.value(node.left)
        right = self.value(node.right)
        left, right = self.as_kind(left, kind), self.as_kind(right, kind)
        if kind.lanes:
            return lanes.binary(self, op, left, right)
        if op in BITWISE:
            return self.emit(kind, f"{BITWISE[op]} {kind.llvm} {left.text}, {right.text}")
        if op not in ARITHMETIC:
            name = self.module.helper(DIVIDED[op])
            return self.emit(INT, f"call i64 {name}(i64 {left.text}, i64 {right.text})")
        code = f"{ARITHMETIC[op]} i64" if kind == INT else f"f{ARITHMETIC[op]} contract double"
        return self.emit(node.kind, f"{code} {left.text}, {right.text}")

    def _of_FloatPower(self, node: nodes.FloatPower) -> Value:
        base, exponent = self.value(node.base), self.value(node.exponent)
        self.need("declare double @llvm.pow.f64(double, double)")
        return self.emit(FLOAT, f"call double @llvm.pow.f64(double {base.text}, double {exponent.text})")

    def _of_Power(self, node: nodes.Power) -> Value:
        base, exponent = self.value(node.base), self.value(node.exponent)
        left = abs(exponent.constant)
        kind, times = base.kind, "mul i64" if base.kind == INT else "fmul contract double"
        power = Value(kind, "1" if kind == INT else kinds.float_text(1.0))
        while left != 0:  # in this order to the last bit
            if left & 1:
                power = self.emit(kind, f"{times} {power.text}, {base.text}")
            left >>= 1
            if left:
                base = self.emit(kind, f"{times} {base.text}, {base.text}")
        if exponent.constant < 0:
            power = self.emit(FLOAT, f"fdiv contract double {kinds.float_text(1.0)}, {power.text}")
        return power

    def _of_Unary(self, node: nodes.Unary) -> Value:
        value, op = self.value(node.value), node.operator
        if value.kind.lanes:
            return lanes.unary(self, op, value)
        if op == "Not":
            return self.emit(BOOL, f"xor i1 {value.text}, true")
        if op == "Invert":
            return self.emit(INT, f"xor i64 {value.text}, -1")
        negated = f"sub i64 0, {value.text}" if value.kind == INT else f"fneg contract double {value.text}"
        return self.emit(value.kind, negated)

    def _of_Compared(self, node: nodes.Compared) -> Value:
        left = self.value(node.left)
        right = self.value(node.right)
        left, right = self.as_kind(left, node.operands), self.as_kind(right, node.operands)
        return self._compared(node.operator, left, right)

    def _compared(self, op: str, left: Value, right: Value) -> Value:
        """left op right, of one kind."""
        name, kind = COMPARED[op], left.kind
        if kind.lanes:
            return lanes.compared(self, name, left, right)
        if kind == FLOAT:
            return self.emit(BOOL, f"fcmp {'une' if name == 'ne' else 'o' + name} double {left.text}, {right.text}")
        signed = name if op in ("Eq", "NotEq") else f"s{name}"
        return self.emit(BOOL, f"icmp {signed} {kind.llvm} {left.text}, {right.text}")

    def _of_Within(self, node: nodes.Within) -> Value:
        equal = [self.value(part) for part in node.parts]
        return functools.reduce(lambda one, other: self.emit(BOOL, f"or i1 {one.text}, {other.text}"), equal)

    def _of_Junction(self, node: nodes.Junction) -> Value:
        after, decided = self.label(), "false" if node.all_of else "true"
        *first, last = node.parts
        incoming: list[str] = []
        for part in first:
            value, following = self.value(part), self.label()
            incoming.append(f"[ {decided}, %{self.block} ]")
            self._fork(value, *((following, after) if node.all_of else (after, following)))
            self.start(following)
        value = self.value(last)
        incoming.append(f"[ {value.text}, %{self.block} ]")
        self._jump(after)
        self.start(after)
        return self.emit(BOOL, f"phi i1 {', '.join(incoming)}")

    def _of_Choice(self, node: nodes.Choice) -> Value:
        condition = self.value(node.condition)
        yes, no, after = self.label(), self.label(), self.label()
        self._fork(condition, yes, no)
        incoming: list[str] = []
        for label, part in ((yes, node.one), (no, node.other)):
            self.start(label)
            value = self.as_kind(self.value(part), node.kind)
            incoming.append(f"[ {value.text}, %{self.block} ]")
            self._jump(after)
        self.start(after)
        return self.emit(node.kind, f"phi {node.kind.llvm} {', '.join(incoming)}")

    def _of_Extreme(self, node: nodes.Extreme) -> Value:
        return functools.reduce(functools.partial(self._extreme, node.operator), map(self.value, node.parts))

    def _extreme(self, op: str, one: Value, other: Value) -> Value:
        kind = kinds.joined(one.kind, other.kind) or FLOAT
        one, other = self.as_kind(one, kind), self.as_kind(other, kind)
        better = self._compared(op, other, one)
        values = f"{kind.llvm} {other.text}, {kind.llvm} {one.text}"
        return self.emit(kind, f"select {better.kind.llvm} {better.text}, {values}")

    def _of_Magnitude(self, node: nodes.Magnitude) -> Value:
        value = self.value(node.value)
        if value.kind.lanes or value.kind == FLOAT:
            return lanes.intrinsic(self, "fabs", value)
        negative = self.emit(BOOL, f"icmp slt i64 {value.text}, 0")
        minus = self.emit(INT, f"sub i64 0, {value.text}")
        return self.emit(INT, f"select i1 {negative.text}, i64 {minus.text}, i64 {value.text}")

    # --- calls -------------------------------------------------------------------------------------------------------

    def _of_Library(self, node: nodes.Library) -> Value:
        value = self.value(node.value)
        if node.function not in OF_C:
            return lanes.intrinsic(self, node.function, value)
        self.need(f"declare double @{node.function}(double) nounwind willreturn memory(none)")
        return self.emit(FLOAT, f"call double @{node.function}(double {value.text})")

    def _of_Call(self, node: nodes.Call) -> Value:
        arguments = [self.value(argument) for argument in node.arguments]
        name = self.module.written(node.function)
        packed = [self.packed(argument) if argument.kind.items else argument for argument in arguments]
        passed = ", ".join(f"{argument.kind.llvm} {argument.text}" for argument in packed)
        if node.kind == NOTHING:
            self.do(f"call void {name}({passed})")
            return Value(NOTHING, "")
        return self.emit(node.kind, f"call {node.kind.llvm} {name}({passed})")

    def _of_Primitive(self, node: nodes.Primitive) -> Value:
        arguments = [self.value(argument) for argument in node.arguments]
        return lanes.PRIMITIVES[node.name](self, *map(self.as_kind, arguments, node.kinds))
