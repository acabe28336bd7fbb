"""Expressions in JavaScript: names, entries of arrays, operators, comparisons, choices, calls."""

import ast
import functools
import math

from vibrocap.numerics.compiler.code import named
from vibrocap.numerics.compiler.expressions import BITWISE, PYTHON
from vibrocap.numerics.compiler.javascript_values import BITS, Values, joined_kind, variable_name
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
    literal,
    tuple_of,
)
from vibrocap.numerics.compiler.subset import LIBRARY

ARITHMETIC = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
SIGNS = {ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^", ast.LShift: "<<", ast.RShift: ">>"}
COMPARED = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "===", ast.NotEq: "!=="}


class Expressions(Values):
    """Writes the expressions of one function."""

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
            return Value(self.variables[name], variable_name(name))
        if name in self._assigned:
            raise self.refusal(node, f"`{name}` is read where it need not have a value yet; assign it before")
        value = self.module.constant(name)
        if value is None:
            what = "cannot be used as a value" if name in self.module.kernel.constants else "is not known"
            raise self.refusal(node, f"`{name}` {what}")
        return value

    def _of_Tuple(self, node: ast.Tuple) -> Value:
        items = tuple(self.value(item) for item in node.elts)
        return Value(tuple_of(tuple(item.kind for item in items)), "", None, items)

    def _of_Attribute(self, node: ast.Attribute) -> Value:
        if isinstance(node.value, ast.Name) and node.value.id == "math" and node.attr in ("inf", "nan", "pi", "e"):
            return Value(FLOAT, "", getattr(math, node.attr))
        raise self.refusal(node, f"no kernel has `{ast.unparse(node)}`")

    def _of_Subscript(self, node: ast.Subscript) -> Value:
        base = self.value(node.value)
        if base.kind in ELEMENTS:
            array, place = self._entry(node)
            return Value(ELEMENTS[array.kind], f"{array.text}[{place}]")
        if base.kind == TABLE:
            return self._of_table(node, base)
        if not base.kind.items:
            raise self.refusal(node, f"{base.kind.name} has no items")
        place = self.value(node.slice).constant
        kinds = base.kind.items
        if isinstance(place, int) and not isinstance(place, bool) and -len(kinds) <= place < len(kinds):
            if base.items is not None:
                return base.items[place]
            return Value(kinds[place], f"{base.text}[{place % len(kinds)}]")
        if base.constant is None or len(set(kinds)) != 1 or kinds[0] not in (INT, FLOAT):
            raise self.refusal(node, "the place of an item of a tuple is a constant within it")
        return Value(kinds[0], f"{self.written_out(base)}[{self._place(node.slice)}]")

    def _of_table(self, node: ast.Subscript, base: Value) -> Value:
        table = base.constant
        parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(parts) != table.ndim:
            raise self.refusal(node, f"a table of {table.ndim} dimensions needs as many places")
        places = [self.value(part) for part in parts]
        if all(isinstance(place.constant, int) for place in places):
            found = literal(table[tuple(place.constant for place in places)])
            if found is not None:
                return found
        texts = [self._place(part) for part in parts]
        place = texts[0] if table.ndim == 1 else f"{texts[0]} * {table.shape[1]} + {texts[1]}"
        return Value(FLOAT if table.dtype.kind == "f" else INT, f"{base.text}[{place}]")

    def _place(self, node: ast.expr) -> str:
        place = self.value(node)
        if place.kind not in (INT, BITS):
            raise self.refusal(node, f"a place in an array is an int, not {place.kind.name}")
        return self.texts(node, INT, place)[0]

    def _entry(self, node: ast.Subscript) -> tuple[Value, str]:
        """(array, place in it)."""
        array = self.value(node.value)
        if array.kind not in ELEMENTS:
            raise self.refusal(node, f"an entry of {array.kind.name} cannot be set")
        if isinstance(node.slice, (ast.Slice, ast.Tuple)):
            raise self.refusal(node, "an array has one place at a time; write a loop")
        return array, self._place(node.slice)

    def _of_BinOp(self, node: ast.BinOp) -> Value:
        left = self.value(node.left)
        return self._binary(node, node.op, left, self.value(node.right))

    def _folded(self, op: ast.AST, *values: Value) -> Value | None:
        """What is known already, from constants alone, as Python has it."""
        if any(value.constant is None or value.kind not in (*SCALARS, BITS) for value in values):
            return None
        try:
            found = PYTHON[type(op)](*(value.constant for value in values))
        except (ArithmeticError, KeyError, TypeError, ValueError):
            return None
        return None if isinstance(found, complex) else literal(found)

    def _binary(self, node: ast.AST, op: ast.operator, left: Value, right: Value) -> Value:
        folded = self._folded(op, left, right)
        if folded is not None:
            return folded
        numbers = (INT, BITS, FLOAT)
        if left.kind not in (BOOL, *numbers) or right.kind not in (BOOL, *numbers):
            raise self.refusal(node, f"no {named(op)} of {left.kind.name} and {right.kind.name}")
        if type(op) in BITWISE:
            return self._bitwise(node, op, left, right)
        if BOOL in (left.kind, right.kind):
            raise self.refusal(node, "yes and no are no numbers; write 1.0 if ... else 0.0")
        if isinstance(op, ast.Pow):
            return self._power(node, left, right)
        if isinstance(op, ast.Div) or FLOAT in (left.kind, right.kind):
            kind = FLOAT
        else:
            kind = BITS if BITS in (left.kind, right.kind) else INT
        one, other = self.texts(node, kind, left, right)
        if isinstance(op, (ast.FloorDiv, ast.Mod)):
            prefix = {FLOAT: "float_", INT: "", BITS: "bits_"}[kind]
            name = prefix + ("floor_rest" if isinstance(op, ast.Mod) else "floor_divided")
            return Value(kind, f"{self.module.helper(name)}({one}, {other})")
        if type(op) not in ARITHMETIC:
            raise self.refusal(node, f"no kernel has {named(op)}")
        text = f"{one} {ARITHMETIC[type(op)]} {other}"
        if kind == BITS:
            return Value(kind, f"BigInt.asIntN(64, {text})")
        return Value(kind, f"({text} + 0)" if kind == INT and isinstance(op, ast.Mult) else f"({text})")

    def _bitwise(self, node: ast.AST, op: ast.operator, left: Value, right: Value) -> Value:
        if left.kind == right.kind == BOOL and isinstance(op, (ast.BitAnd, ast.BitOr, ast.BitXor)):
            one, other = self.texts(node, BOOL, left, right)
            return Value(BOOL, f"(({one} {SIGNS[type(op)]} {other}) === 1)")
        if FLOAT in (left.kind, right.kind):
            raise self.refusal(node, f"no {named(op)} of floats; take their bits by np.float64(x).view(np.int64)")
        one, other = self.texts(node, BITS, left, right)
        text = f"{one} {SIGNS[type(op)]} {other}"
        return Value(BITS, f"BigInt.asIntN(64, {text})" if isinstance(op, ast.LShift) else f"({text})")

    def _power(self, node: ast.AST, base: Value, exponent: Value) -> Value:
        if exponent.kind == FLOAT:
            return self._of_kernel(node, self._own(node, "pow"), [self.as_kind(node, base, FLOAT), exponent])
        if base.kind != FLOAT and (exponent.constant is None or exponent.constant < 0):
            raise self.refusal(node, "a power of an int has a constant exponent of at least 0; take float(...) of it")
        kind = FLOAT if base.kind == FLOAT else INT
        one, times = self.texts(node, kind, base)[0], self.texts(node, INT, exponent)[0]
        text = f"{self.module.helper('whole_power')}({one}, {times})"
        return Value(kind, text if kind == FLOAT else f"({text} + 0)")

    def _of_UnaryOp(self, node: ast.UnaryOp) -> Value:
        value = self.condition(node.operand) if isinstance(node.op, ast.Not) else self.value(node.operand)
        folded = self._folded(node.op, value)
        if folded is not None:
            return folded
        if isinstance(node.op, ast.Not):
            return Value(BOOL, f"(!{value.text})")
        if value.kind not in (INT, BITS, FLOAT) or (isinstance(node.op, ast.Invert) and value.kind == FLOAT):
            raise self.refusal(node, f"no {named(node.op)} of {value.kind.name}; use `not` of a bool")
        if isinstance(node.op, ast.UAdd):
            return value
        if isinstance(node.op, ast.Invert):
            return Value(BITS, f"(~{self.texts(node, BITS, value)[0]})")
        if value.kind == BITS:
            return Value(BITS, f"BigInt.asIntN(64, -{value.text})")
        return Value(value.kind, f"(0 - {value.text})" if value.kind == INT else f"(-{value.text})")

    def _of_Compare(self, node: ast.Compare) -> Value:
        left = self.value(node.left)

        def pair(i: int) -> Value:
            nonlocal left
            op, right = node.ops[i], node.comparators[i]
            if isinstance(op, (ast.In, ast.NotIn)):
                found = self._within(node, left, right)
                return found if isinstance(op, ast.In) else self._negated(found)
            known, found = left, self.value(right)
            if i + 1 < len(node.ops):
                found, left = self.once(found)
            return self._compared(node, op, known, found)

        return self.one_after_another([functools.partial(pair, i) for i in range(len(node.ops))], True)

    def _compared(self, node: ast.AST, op: ast.cmpop, left: Value, right: Value) -> Value:
        folded = self._folded(op, left, right)
        if folded is not None:
            return folded
        if type(op) not in COMPARED:
            raise self.refusal(node, f"no kernel has {named(op)}")
        kind = joined_kind(left.kind, right.kind)
        if kind not in (*SCALARS, BITS):
            raise self.refusal(node, f"{left.kind.name} and {right.kind.name} are not compared")
        if kind == BOOL and not isinstance(op, (ast.Eq, ast.NotEq)):
            raise self.refusal(node, "yes and no have no order")
        one, other = self.texts(node, kind, left, right)
        return Value(BOOL, f"({one} {COMPARED[type(op)]} {other})")

    def _within(self, node: ast.AST, left: Value, right: ast.expr) -> Value:
        if not isinstance(right, ast.Tuple):
            raise self.refusal(node, "`in` asks a tuple that is written there")
        first, again = self.once(left)
        names = [first, *[again] * len(right.elts)]
        parts = [
            functools.partial(lambda item, name: self._compared(node, ast.Eq(), name, self.value(item)), item, name)
            for item, name in zip(right.elts, names, strict=False)
        ]
        return self.one_after_another(parts, False)

    def _negated(self, value: Value) -> Value:
        return self._folded(ast.Not(), value) or Value(BOOL, f"(!{value.text})")

    def _of_BoolOp(self, node: ast.BoolOp) -> Value:
        parts = [functools.partial(self._choice, part) for part in node.values]
        return self.one_after_another(parts, isinstance(node.op, ast.And))

    def _choice(self, node: ast.expr) -> Value:
        value = self.value(node)
        if value.kind != BOOL:
            raise self.refusal(node, f"`and`, `or` join yes and no, not {value.kind.name}")
        return value

    def _of_IfExp(self, node: ast.IfExp) -> Value:
        condition = self.condition(node.test)
        if condition.constant is not None:
            return self.value(node.body if condition.constant else node.orelse)
        one, other = self.value(node.body), self.value(node.orelse)
        kind = joined_kind(one.kind, other.kind)
        if kind is None or kind in (NOTHING, TABLE, FLOATS, INTS):
            raise self.refusal(node, f"{one.kind.name} or {other.kind.name}: both are to be of one kind")
        yes, no = self.texts(node, kind, one, other)
        return Value(kind, f"({condition.text} ? {yes} : {no})")

    # --- calls -------------------------------------------------------------------------------------------------------

    def _of_Call(self, node: ast.Call) -> Value:
        value = self._call(node)
        if value.kind == NOTHING:
            raise self.refusal(node, "this call returns nothing")
        return value

    def _call(self, node: ast.Call) -> Value:
        if node.keywords:
            raise self.refusal(node, "arguments are positional; leave their names out")
        if isinstance(node.func, ast.Attribute):
            return self._of_library(node, node.func)
        if not isinstance(node.func, ast.Name):
            raise self.refusal(node, "call a function by its name")
        name, values = node.func.id, [self.value(argument) for argument in node.args]
        if name in self.module.kernel.functions:
            return self._of_kernel(node, name, values)
        if name in ("min", "max") and len(values) >= 2:
            return functools.reduce(functools.partial(self._extreme, node, name), values)
        if name in ("abs", "float", "int") and len(values) == 1:
            return getattr(self, f"_{name}")(node, values[0])
        if name in self.module.kernel.primitives:
            raise self.refusal(node, f"`{name}` is of lanes; JavaScript runs one motion alone")
        raise self.refusal(node, f"no kernel can call `{name}` with {len(values)} arguments")

    def _of_kernel(self, node: ast.AST, name: str, values: list[Value]) -> Value:
        """A call of one of the kernel's own functions."""
        wanted = len(self.module.kernel.functions[name].args.args)
        if len(values) != wanted:
            raise self.refusal(node, f"`{name}` takes {wanted} arguments, not {len(values)}")
        arrays = [value.text for value in values if value.kind in ELEMENTS]
        if len(set(arrays)) < len(arrays):
            raise self.refusal(node, "the arrays of a call are different ones; pass each once")
        if any(value.kind in (TABLE, NOTHING) for value in values):
            raise self.refusal(node, "a table is no argument; name it in the function that reads it")
        asked = functools.partial(self.refusal, node)
        made, result = self.module.function(name, tuple(value.kind for value in values), asked)
        return Value(result, f"{made}({', '.join(map(self.written_out, values))})")

    def _extreme(self, node: ast.AST, name: str, one: Value, other: Value) -> Value:
        """As Python: the first that no other is less (or greater) than; a NaN behind a number is passed over."""
        kind = joined_kind(one.kind, other.kind)
        if kind not in (INT, BITS, FLOAT):
            raise self.refusal(node, f"`{name}` of {one.kind.name} and {other.kind.name}")
        better = self._folded(ast.Gt() if name == "max" else ast.Lt(), other, one)
        if better is not None:
            return self.as_kind(node, other if better.constant else one, kind)
        helper = self.module.helper("greatest" if name == "max" else "least")
        return Value(kind, f"{helper}({', '.join(self.texts(node, kind, one, other))})")

    def _abs(self, node: ast.AST, value: Value) -> Value:
        if value.kind not in (INT, BITS, FLOAT):
            raise self.refusal(node, f"{value.kind.name} has no magnitude")
        kind = FLOAT if value.kind == FLOAT else INT
        if value.constant is not None:
            return Value(kind, "", abs(value.constant))
        return Value(kind, f"Math.abs({self.texts(node, kind, value)[0]})")

    def _float(self, node: ast.AST, value: Value) -> Value:
        return self.as_kind(node, value, FLOAT)

    def _int(self, node: ast.AST, value: Value) -> Value:
        if value.kind == BITS:
            return value
        if value.kind != FLOAT:
            return self.as_kind(node, value, INT)
        if value.constant is not None:
            return literal(int(value.constant)) or value
        return Value(INT, f"{self.module.helper('whole')}({value.text})")

    def _own(self, node: ast.AST, function: str) -> str:
        """The kernel's own function that stands for one of `math`."""
        name = LIBRARY.get(function, "")
        if name not in self.module.kernel.functions:
            raise self.refusal(node, f"this kernel has no polynomials for `{function}`, and JavaScript's own differ")
        return name

    def _of_library(self, node: ast.Call, called: ast.Attribute) -> Value:
        """math.x(...), np.x(...), and numbers seen as bits."""
        name = ast.unparse(called)
        if called.attr == "view" and isinstance(called.value, ast.Call) and len(node.args) == 1:
            return self._viewed(node, self.value(called.value), ast.unparse(node.args[0]))
        if len(node.args) != 1:
            raise self.refusal(node, f"no kernel can call `{name}` with {len(node.args)} arguments")
        value = self.value(node.args[0])
        if name in ("np.float64", "np.int64"):
            return (self._float if name == "np.float64" else self._int)(node, value)
        if name in ("np.floor", "math.floor", "math.sqrt"):
            text = f"Math.{called.attr}({self.texts(node, FLOAT, value)[0]})"
            return Value(INT, f"({text} + 0)") if name == "math.floor" else Value(FLOAT, text)
        if name.startswith("math.") and called.attr in LIBRARY:
            return self._of_kernel(node, self._own(node, called.attr), [self.as_kind(node, value, FLOAT)])
        raise self.refusal(node, f"no kernel can call `{name}`; of math it knows {', '.join(LIBRARY)}, sqrt, floor")

    def _viewed(self, node: ast.Call, value: Value, kind: str) -> Value:
        if (kind, value.kind) == ("np.int64", FLOAT):
            return Value(BITS, f"{self.module.helper('bits_of')}({self.written_out(value)})")
        if kind == "np.float64" and value.kind in (INT, BITS):
            return Value(FLOAT, f"{self.module.helper('float_of')}({self.texts(node, BITS, value)[0]})")
        raise self.refusal(node, "view a np.float64 as np.int64 or a np.int64 as np.float64")
