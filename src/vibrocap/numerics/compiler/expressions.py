"""Expressions: names, entries of arrays and tables, operators, comparisons, choices."""

import ast
import functools
import math
import operator
from collections.abc import Callable

from vibrocap.numerics.compiler import lanes
from vibrocap.numerics.compiler.code import Code, named
from vibrocap.numerics.compiler.kinds import (
    BOOL,
    ELEMENTS,
    FLOAT,
    FLOATS,
    INT,
    INTS,
    NOTHING,
    SCALARS,
    TABLE,
    Value,
    float_text,
    joined,
    literal,
)

PYTHON: dict[type, Callable] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
    ast.Invert: operator.invert,
    ast.Not: operator.not_,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
}
ARITHMETIC = {ast.Add: "add", ast.Sub: "sub", ast.Mult: "mul", ast.Div: "div"}
BITWISE = {ast.BitAnd: "and", ast.BitOr: "or", ast.BitXor: "xor", ast.LShift: "shl", ast.RShift: "ashr"}
COMPARED = {ast.Lt: "lt", ast.LtE: "le", ast.Gt: "gt", ast.GtE: "ge", ast.Eq: "eq", ast.NotEq: "ne"}


class Expressions(Code):
    """Writes the code of expressions."""

    def _of_Constant(self, node: ast.Constant) -> Value:
        value = literal(node.value)
        if value is None:
            raise self.refusal(node, "a constant in a kernel is a float, an int of 64 bits or a bool")
        return value

    def _of_Name(self, node: ast.Name) -> Value:
        return self._name(node, node.id)

    def _name(self, node: ast.AST, name: str) -> Value:
        if name in self.bound:
            return self.bound[name]
        if name in self.variables:
            kind = self.variables[name]
            return self.emit(kind, f"load {kind.llvm}, ptr %v.{name}")
        if name in self._assigned:
            raise self.refusal(node, f"`{name}` is read where it need not have a value yet; assign it before")
        value = self.module.constant(name)
        if value is None:
            what = "cannot be used as a value" if name in self.module.kernel.constants else "is not known"
            raise self.refusal(node, f"`{name}` {what}")
        return value

    def _of_Tuple(self, node: ast.Tuple) -> Value:
        return self.tupled([self.value(item) for item in node.elts])

    def _of_Attribute(self, node: ast.Attribute) -> Value:
        if isinstance(node.value, ast.Name) and node.value.id == "math" and node.attr in ("inf", "nan", "pi", "e"):
            return Value(FLOAT, float_text(getattr(math, node.attr)), getattr(math, node.attr))
        raise self.refusal(node, f"no kernel has `{ast.unparse(node)}`")

    def _of_Subscript(self, node: ast.Subscript) -> Value:
        base = self.value(node.value)
        if base.kind in ELEMENTS:
            _, place = self._entry(node)
            kind = ELEMENTS[base.kind]
            return self.emit(kind, f"load {kind.llvm}, ptr {place}")
        if base.kind == TABLE:
            return self._of_table(node, base)
        if base.kind.items:
            place = self.value(node.slice).constant
            items = self.items(base) or ()
            if not isinstance(place, int) or isinstance(place, bool) or not -len(items) <= place < len(items):
                return self._of_varying(node, base, items)
            return items[place]
        raise self.refusal(node, f"{base.kind.name} has no items")

    def _of_varying(self, node: ast.Subscript, base: Value, items: tuple[Value, ...]) -> Value:
        """An item of a constant tuple at a place that is not known yet."""
        if base.constant is None or len({item.kind for item in items}) != 1 or items[0].kind not in (INT, FLOAT):
            raise self.refusal(node, "the place of an item of a tuple is a constant within it")
        kind = items[0].kind
        name = "@tuple." + "".join(c if c.isalnum() else "_" for c in repr(base.constant))
        content = ", ".join(f"{kind.llvm} {item.text}" for item in items)
        array = f"[{len(items)} x {kind.llvm}]"
        self.need(f"{name} = internal unnamed_addr constant {array} [{content}], align 8")
        place = self._place(node.slice)
        pointer = self.emit(FLOATS, f"getelementptr inbounds {kind.llvm}, ptr {name}, i64 {place.text}")
        return self.emit(kind, f"load {kind.llvm}, ptr {pointer.text}")

    def _of_table(self, node: ast.Subscript, base: Value) -> Value:
        table = base.constant
        parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(parts) != table.ndim:
            raise self.refusal(node, f"a table of {table.ndim} dimensions needs as many places")
        places = [self._place(part) for part in parts]
        if all(place.constant is not None for place in places):
            found = literal(table[tuple(place.constant for place in places)])
            if found is not None:
                return found
        place = places[0]
        if table.ndim == 2:
            row = self.emit(INT, f"mul nsw i64 {place.text}, {table.shape[1]}")
            place = self.emit(INT, f"add nsw i64 {row.text}, {places[1].text}")
        kind = FLOAT if table.dtype.kind == "f" else INT
        pointer = self.emit(FLOATS, f"getelementptr inbounds {kind.llvm}, ptr {base.text}, i64 {place.text}")
        return self.emit(kind, f"load {kind.llvm}, ptr {pointer.text}")

    def _place(self, node: ast.expr) -> Value:
        place = self.value(node)
        if place.kind != INT:
            raise self.refusal(node, f"a place in an array is an int, not {place.kind.name}")
        return place

    def _entry(self, node: ast.Subscript) -> tuple[Value, str]:
        """(array, pointer to an entry of it)."""
        array = self.value(node.value)
        if array.kind not in ELEMENTS:
            raise self.refusal(node, f"an entry of {array.kind.name} cannot be set")
        if isinstance(node.slice, (ast.Slice, ast.Tuple)):
            raise self.refusal(node, "an array has one place at a time; write a loop")
        return array, self.pointer(array, self._place(node.slice))

    # --- operators ---------------------------------------------------------------------------------------------------

    def _of_BinOp(self, node: ast.BinOp) -> Value:
        left = self.value(node.left)
        return self._binary(node, node.op, left, self.value(node.right))

    def _binary(self, node: ast.AST, op: ast.operator, left: Value, right: Value) -> Value:
        folded = self._folded(op, left, right)
        if folded is not None:
            return folded
        if left.kind.lanes or right.kind.lanes:
            return lanes.binary(self, node, op, left, right)
        if left.kind not in SCALARS or right.kind not in SCALARS:
            raise self.refusal(node, f"no {named(op)} of {left.kind.name} and {right.kind.name}")
        if type(op) in BITWISE:
            return self._bitwise(node, op, left, right)
        if BOOL in (left.kind, right.kind):
            raise self.refusal(node, "yes and no are no numbers; write 1.0 if ... else 0.0")
        if isinstance(op, ast.Pow):
            return self._power(node, left, right)
        whole = left.kind == right.kind == INT and not isinstance(op, ast.Div)
        kind = INT if whole else FLOAT
        left, right = self.as_kind(node, left, kind), self.as_kind(node, right, kind)
        if isinstance(op, (ast.FloorDiv, ast.Mod)):
            names = ("floor_divided", "floor_rest") if whole else ("float_floor_divided", "float_rest")
            name = self.module.helper(names[isinstance(op, ast.Mod)])
            return self.emit(kind, f"call {kind.llvm} {name}({kind.llvm} {left.text}, {kind.llvm} {right.text})")
        if type(op) not in ARITHMETIC:
            raise self.refusal(node, f"no kernel has {named(op)}")
        code = f"{ARITHMETIC[type(op)]} i64" if whole else f"f{ARITHMETIC[type(op)]} contract double"
        return self.emit(kind, f"{code} {left.text}, {right.text}")

    def _folded(self, op: ast.AST, *values: Value) -> Value | None:
        """What is known already, from constants alone, as Python has it."""
        constants = [value.constant for value in values]
        if any(
            constant is None or value.kind not in SCALARS for constant, value in zip(constants, values, strict=True)
        ):
            return None
        try:
            found = PYTHON[type(op)](*constants)
        except (ArithmeticError, KeyError, TypeError, ValueError):
            return None
        return None if isinstance(found, complex) else literal(found)

    def _bitwise(self, node: ast.AST, op: ast.operator, left: Value, right: Value) -> Value:
        name = BITWISE[type(op)]
        if left.kind == right.kind == BOOL and name in ("and", "or", "xor"):
            return self.emit(BOOL, f"{name} i1 {left.text}, {right.text}")
        if FLOAT in (left.kind, right.kind):
            raise self.refusal(node, f"no {named(op)} of floats; take their bits by np.float64(x).view(np.int64)")
        left, right = self.as_kind(node, left, INT), self.as_kind(node, right, INT)
        return self.emit(INT, f"{name} i64 {left.text}, {right.text}")

    def _power(self, node: ast.AST, base: Value, exponent: Value) -> Value:
        if exponent.kind == FLOAT and "pow" in self.module.library:
            return self.of_kernel(node, self.module.library["pow"], [self.as_kind(node, base, FLOAT), exponent])
        if exponent.kind == FLOAT:
            self.need("declare double @llvm.pow.f64(double, double)")
            base = self.as_kind(node, base, FLOAT)
            return self.emit(FLOAT, f"call double @llvm.pow.f64(double {base.text}, double {exponent.text})")
        if exponent.constant is None or abs(exponent.constant) > 0x10000:
            if base.kind != FLOAT:
                raise self.refusal(node, "the power of an int has a constant exponent; take float(...) of the int")
            name = self.module.helper("whole_power")
            return self.emit(FLOAT, f"call double {name}(double {base.text}, i64 {exponent.text})")
        left = abs(exponent.constant)
        if base.kind == INT and exponent.constant < 0:
            raise self.refusal(node, "a power of an int that is no int; take float(...) of the int")
        kind, times = base.kind, "mul i64" if base.kind == INT else "fmul contract double"
        power = Value(kind, "1", None) if kind == INT else Value(kind, float_text(1.0))
        while left != 0:  # in this order to the last bit
            if left & 1:
                power = self.emit(kind, f"{times} {power.text}, {base.text}")
            left >>= 1
            if left:
                base = self.emit(kind, f"{times} {base.text}, {base.text}")
        if exponent.constant < 0:
            power = self.emit(FLOAT, f"fdiv contract double {float_text(1.0)}, {power.text}")
        return power

    def _of_UnaryOp(self, node: ast.UnaryOp) -> Value:
        value = self.condition(node.operand) if isinstance(node.op, ast.Not) else self.value(node.operand)
        folded = self._folded(node.op, value)
        if folded is not None:
            return folded
        if value.kind.lanes:
            return lanes.unary(self, node, node.op, value)
        if isinstance(node.op, ast.Not):
            return self.emit(BOOL, f"xor i1 {value.text}, true")
        if value.kind not in (INT, FLOAT) or (isinstance(node.op, ast.Invert) and value.kind == FLOAT):
            raise self.refusal(node, f"no {named(node.op)} of {value.kind.name}; use `not` of a bool")
        if isinstance(node.op, ast.UAdd):
            return value
        if isinstance(node.op, ast.Invert):
            return self.emit(INT, f"xor i64 {value.text}, -1")
        return self.emit(
            value.kind, f"sub i64 0, {value.text}" if value.kind == INT else f"fneg contract double {value.text}"
        )

    def _of_Compare(self, node: ast.Compare) -> Value:
        left = self.value(node.left)

        def pair(i: int) -> Callable[[], Value]:
            def compared() -> Value:
                nonlocal left
                op, right = node.ops[i], node.comparators[i]
                if isinstance(op, (ast.In, ast.NotIn)):
                    found = self._within(node, left, right)
                    return found if isinstance(op, ast.In) else self._negated(found)
                known = left
                left = self.value(right)
                return self.compared(node, op, known, left)

            return compared

        return self.one_after_another(node, [pair(i) for i in range(len(node.ops))], True)

    def compared(self, node: ast.AST, op: ast.cmpop, left: Value, right: Value) -> Value:
        """left op right."""
        folded = self._folded(op, left, right)
        if folded is not None:
            return folded
        if type(op) not in COMPARED:
            raise self.refusal(node, f"no kernel has {named(op)}")
        if left.kind.lanes or right.kind.lanes:
            return lanes.compared(self, node, COMPARED[type(op)], left, right)
        kind = joined(left.kind, right.kind)
        if kind not in SCALARS:
            raise self.refusal(node, f"{left.kind.name} and {right.kind.name} are not compared")
        name, equal = COMPARED[type(op)], type(op) in (ast.Eq, ast.NotEq)
        if kind == BOOL and not equal:
            raise self.refusal(node, "yes and no have no order")
        left, right = self.as_kind(node, left, kind), self.as_kind(node, right, kind)
        if kind == FLOAT:
            return self.emit(BOOL, f"fcmp {'une' if name == 'ne' else 'o' + name} double {left.text}, {right.text}")
        return self.emit(BOOL, f"icmp {name if equal else 's' + name} {kind.llvm} {left.text}, {right.text}")

    def _within(self, node: ast.AST, left: Value, right: ast.expr) -> Value:
        if not isinstance(right, ast.Tuple):
            raise self.refusal(node, "`in` asks a tuple that is written there")
        equal = [self.compared(node, ast.Eq(), left, self.value(item)) for item in right.elts]
        if not equal:
            return Value(BOOL, "false", False)

        def either(one: Value, other: Value) -> Value:
            folded = self._folded(ast.BitOr(), one, other)
            return folded or self.emit(BOOL, f"or i1 {one.text}, {other.text}")

        return functools.reduce(either, equal)

    def _negated(self, value: Value) -> Value:
        return self._folded(ast.Not(), value) or self.emit(BOOL, f"xor i1 {value.text}, true")

    def _of_BoolOp(self, node: ast.BoolOp) -> Value:
        parts = [functools.partial(self._choice, part) for part in node.values]
        return self.one_after_another(node, parts, isinstance(node.op, ast.And))

    def _choice(self, node: ast.expr) -> Value:
        value = self.value(node)
        if value.kind != BOOL:
            raise self.refusal(node, f"`and`, `or` join yes and no, not {value.kind.name}; use & and | of lanes")
        return value

    def one_after_another(self, node: ast.AST, parts: list[Callable[[], Value]], all_of: bool) -> Value:
        """Conditions of which the next is asked only while all (or none) so far hold."""
        after, decided = self.label(), "false" if all_of else "true"
        incoming: list[str] = []
        for i, part in enumerate(parts):
            value = part()
            last = i == len(parts) - 1
            if value.kind != BOOL:  # choices of lanes
                if len(parts) > 1:
                    raise self.refusal(node, "choices of lanes are joined by & and |, two at a time")
                return value
            if value.constant is not None and not last:
                if value.constant == all_of:
                    continue  # decides nothing
                if not incoming:
                    return value
                last = True  # decides all
            if last:
                if not incoming:
                    return value
                incoming.append(f"[ {value.text}, %{self.block} ]")
                self._jump(after)
                break
            following = self.label()
            incoming.append(f"[ {decided}, %{self.block} ]")
            self._fork(value, *((following, after) if all_of else (after, following)))
            self.start(following)
        self.start(after)
        return self.emit(BOOL, f"phi i1 {', '.join(incoming)}")

    def _of_IfExp(self, node: ast.IfExp) -> Value:
        condition = self.condition(node.test)
        if condition.constant is not None:
            return self.value(node.body if condition.constant else node.orelse)
        yes, no, after = self.label(), self.label(), self.label()
        self._fork(condition, yes, no)
        self.start(yes)
        one = self.value(node.body)
        one_block, one_end = self.block, len(self.lines)
        self.start(no)
        other = self.value(node.orelse)
        kind = joined(one.kind, other.kind)
        if kind is None or kind in (NOTHING, TABLE, FLOATS, INTS):
            raise self.refusal(node, f"{one.kind.name} or {other.kind.name}: both are to be of one kind")
        other = self.as_kind(node, other, kind)
        other_block = self.block
        self._jump(after)
        behind = self.lines[one_end:]
        del self.lines[one_end:]
        self.block = one_block
        one = self.as_kind(node, one, kind)
        self._jump(after)
        self.lines += behind
        self.start(after)
        return self.emit(kind, f"phi {kind.llvm} [ {one.text}, %{one_block} ], [ {other.text}, %{other_block} ]")
