"""Operators, comparisons, choices and calls of a function in the typed tree."""

import ast
import functools
import operator
from collections.abc import Callable

from vibrocap.numerics.compiler import kinds
from vibrocap.numerics.compiler.kinds import (
    BOOL,
    ELEMENTS,
    FLOAT,
    FLOATS,
    INT,
    INTS,
    NOTHING,
    PLACES,
    SCALARS,
    TABLE,
    Kind,
)
from vibrocap.numerics.compiler.typed import lanes, nodes
from vibrocap.numerics.compiler.typed.nodes import Typed, known, named
from vibrocap.numerics.compiler.typed.values import Values

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
ARITHMETIC = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.FloorDiv, ast.Mod)
BITWISE = (ast.BitAnd, ast.BitOr, ast.BitXor, ast.LShift, ast.RShift)
COMPARISONS = (ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq)
FUNCTIONS = ("sin", "cos", "exp", "log", "sqrt", "tanh", "atan")  # of math, besides floor
WRITTEN_OUT = 0x10000  # up to which a known exponent is


class Expressions(Values):
    """The expressions of one function."""

    def _of_BinOp(self, node: ast.BinOp) -> Typed:
        left = self.value(node.left)
        return self.binary(node, node.op, left, self.value(node.right))

    def binary(self, node: ast.AST, op: ast.operator, left: Typed, right: Typed) -> Typed:
        """left op right."""
        if left.constant is not None and right.constant is not None:
            folded = self._folded(op, left, right)
            if folded is not None:
                return folded
        if left.kind.lanes or right.kind.lanes:
            return lanes.binary(self, node, op, left, right)
        if PLACES in (left.kind, right.kind):
            return lanes.moved(self, node, op, left, right)
        if left.kind not in SCALARS or right.kind not in SCALARS:
            raise self.refusal(node, f"no {named(op)} of {left.kind.name} and {right.kind.name}")
        if isinstance(op, BITWISE):
            return self._bitwise(node, op, left, right)
        if BOOL in (left.kind, right.kind):
            raise self.refusal(node, "yes and no are no numbers; write 1.0 if ... else 0.0")
        if isinstance(op, ast.Pow):
            return self._power(node, left, right)
        if not isinstance(op, ARITHMETIC):
            raise self.refusal(node, f"no kernel has {named(op)}")
        kind = INT if left.kind is right.kind is INT and not isinstance(op, ast.Div) else FLOAT
        if kind is FLOAT and isinstance(op, (ast.FloorDiv, ast.Mod)):
            raise self.refusal(node, "// and % are of ints; write np.floor(x / y) of floats")
        return nodes.Binary(kind, type(op).__name__, kind, left, right)

    def _folded(self, op: ast.AST, *values: Typed) -> Typed | None:
        """What is known already, from constants alone, as Python has it."""
        if any(value.constant is None or value.kind not in SCALARS for value in values):
            return None
        try:
            number = PYTHON[type(op)](*(value.constant for value in values))
        except (ArithmeticError, KeyError, TypeError, ValueError):
            return None
        return None if isinstance(number, complex) else known(number)

    def _bitwise(self, node: ast.AST, op: ast.operator, left: Typed, right: Typed) -> Typed:
        if left.kind is right.kind is BOOL and isinstance(op, (ast.BitAnd, ast.BitOr, ast.BitXor)):
            return nodes.Binary(BOOL, type(op).__name__, BOOL, left, right)
        if FLOAT in (left.kind, right.kind):
            raise self.refusal(node, f"no {named(op)} of floats; take their bits by np.float64(x).view(np.int64)")
        return nodes.Binary(INT, type(op).__name__, INT, left, right)

    def _power(self, node: ast.AST, base: Typed, exponent: Typed) -> Typed:
        if exponent.kind is FLOAT:
            base = self.converted(node, base, FLOAT)
            own = self._own(node, "pow")
            return self._of_kernel(node, own, [base, exponent]) if own else nodes.FloatPower(FLOAT, base, exponent)
        if base.kind is INT and (exponent.constant is None or exponent.constant > WRITTEN_OUT):
            raise self.refusal(node, "the power of an int has a constant exponent; take float(...) of the int")
        if base.kind is INT and exponent.constant < 0:
            raise self.refusal(node, "a power of an int that is no int; take float(...) of the int")
        if exponent.constant is None or abs(exponent.constant) > WRITTEN_OUT:
            return nodes.Call(FLOAT, self.program.whole_power(), (base, exponent))
        return nodes.Power(base.kind, base, exponent)

    def _of_UnaryOp(self, node: ast.UnaryOp) -> Typed:
        value = self.condition(node.operand) if isinstance(node.op, ast.Not) else self.value(node.operand)
        folded = self._folded(node.op, value)
        if folded is not None:
            return folded
        if value.kind.lanes:
            return lanes.unary(self, node, node.op, value)
        if isinstance(node.op, ast.Not):
            return nodes.Unary(BOOL, "Not", value)
        if value.kind not in (INT, FLOAT) or (isinstance(node.op, ast.Invert) and value.kind is FLOAT):
            raise self.refusal(node, f"no {named(node.op)} of {value.kind.name}; use `not` of a bool")
        return value if isinstance(node.op, ast.UAdd) else nodes.Unary(value.kind, type(node.op).__name__, value)

    def _of_Compare(self, node: ast.Compare) -> Typed:
        left = self.value(node.left)

        def pair(i: int) -> Typed:
            nonlocal left
            op, right = node.ops[i], node.comparators[i]
            if isinstance(op, (ast.In, ast.NotIn)):
                outcome = self._within(node, left, right)
                opposite = self._folded(ast.Not(), outcome) or nodes.Unary(BOOL, "Not", outcome)
                return outcome if isinstance(op, ast.In) else opposite
            before, behind = left, self.value(right)
            if i + 1 < len(node.ops):
                left = behind = self.shared(behind)
            return self._compared(node, op, before, behind)

        return self.one_after_another(node, [functools.partial(pair, i) for i in range(len(node.ops))], True)

    def _compared(self, node: ast.AST, op: ast.cmpop, left: Typed, right: Typed) -> Typed:
        """left op right."""
        folded = self._folded(op, left, right)
        if folded is not None:
            return folded
        if not isinstance(op, COMPARISONS):
            raise self.refusal(node, f"no kernel has {named(op)}")
        if left.kind.lanes or right.kind.lanes:
            return lanes.compared(self, node, op, left, right)
        kind = kinds.joined(left.kind, right.kind)
        if kind not in SCALARS or kind is None:
            raise self.refusal(node, f"{left.kind.name} and {right.kind.name} are not compared")
        if kind is BOOL and not isinstance(op, (ast.Eq, ast.NotEq)):
            raise self.refusal(node, "yes and no have no order")
        return nodes.Compared(BOOL, type(op).__name__, kind, left, right)

    def _within(self, node: ast.AST, left: Typed, right: ast.expr) -> Typed:
        if not isinstance(right, ast.Tuple):
            raise self.refusal(node, "`in` asks a tuple that is written there")
        left = self.shared(left)
        equal = [self._compared(node, ast.Eq(), left, self.value(item)) for item in right.elts]
        if any(part.constant is True for part in equal):
            return nodes.Number(BOOL, constant=True)
        asked = tuple(part for part in equal if part.constant is None)
        if not asked:
            return nodes.Number(BOOL, constant=False)
        return asked[0] if len(asked) == 1 else nodes.Within(BOOL, asked)

    def _of_BoolOp(self, node: ast.BoolOp) -> Typed:
        parts = [functools.partial(self._choice, part) for part in node.values]
        return self.one_after_another(node, parts, isinstance(node.op, ast.And))

    def _choice(self, node: ast.expr) -> Typed:
        value = self.value(node)
        if value.kind is not BOOL:
            raise self.refusal(node, f"`and`, `or` join yes and no, not {value.kind.name}; use & and | of lanes")
        return value

    def _of_IfExp(self, node: ast.IfExp) -> Typed:
        condition = self.condition(node.test)
        if condition.constant is not None:
            return self.value(node.body if condition.constant else node.orelse)
        one, other = self.value(node.body), self.value(node.orelse)
        kind = kinds.joined(one.kind, other.kind)
        if kind is None or kind in (NOTHING, TABLE, FLOATS, INTS):
            raise self.refusal(node, f"{one.kind.name} or {other.kind.name}: both are to be of one kind")
        return nodes.Choice(kind, condition, one, other)

    # --- calls -------------------------------------------------------------------------------------------------------

    def _of_Call(self, node: ast.Call) -> Typed:
        value = self.call(node)
        if value.kind is NOTHING:
            raise self.refusal(node, "this call returns nothing")
        return value

    def call(self, node: ast.Call) -> Typed:
        """A call, of which there may be no result."""
        if node.keywords:
            raise self.refusal(node, "arguments are positional; leave their names out")
        called = node.func
        if isinstance(called, ast.Attribute):
            return self._of_library(node, called)
        if not isinstance(called, ast.Name):
            raise self.refusal(node, "call a function by its name")
        arguments = [self.value(argument) for argument in node.args]
        name = called.id
        if name in self.program.kernel.functions:
            return self._of_kernel(node, name, arguments)
        if name in ("min", "max") and len(arguments) >= 2:
            return self._extreme(node, name, arguments)
        if name in self.program.kernel.primitives:
            return lanes.primitive(self, node, name, arguments)
        if name in ("abs", "float", "int") and len(arguments) == 1:
            return getattr(self, f"_{name}")(node, arguments[0])
        raise self.refusal(node, f"no kernel can call `{name}` with {len(arguments)} arguments")

    def _of_kernel(self, node: ast.AST, name: str, arguments: list[Typed]) -> Typed:
        """A call of one of the kernel's own functions."""
        wanted = len(self.program.kernel.functions[name].args.args)
        if len(arguments) != wanted:
            raise self.refusal(node, f"`{name}` takes {wanted} arguments, not {len(arguments)}")
        own = [argument for argument in arguments if isinstance(argument, nodes.Argument)]
        arrays = [argument.name for argument in own if argument.kind in ELEMENTS]
        if len(set(arrays)) < len(arrays):
            raise self.refusal(node, "the arrays of a call are different ones; pass each once")
        if any(argument.kind in (TABLE, NOTHING) for argument in arguments):
            raise self.refusal(node, "a table is no argument; name it in the function that reads it")
        asked = functools.partial(self.refusal, node)
        function = self.program.function(name, tuple(argument.kind for argument in arguments), asked)
        return nodes.Call(function.result, function, tuple(arguments))

    def _extreme(self, node: ast.AST, name: str, parts: list[Typed]) -> Typed:
        op = ast.Gt() if name == "max" else ast.Lt()
        first, *rest = parts
        while rest:
            kind = self._numbers_of(node, name, first, rest[0])
            better = self._folded(op, rest[0], first)
            if better is None:
                break
            first = self.converted(node, rest[0] if better.constant else first, kind)
            del rest[0]
        kind = first.kind
        for part in rest:
            kind = self._numbers_of(node, name, nodes.Number(kind), part)
        return nodes.Extreme(kind, type(op).__name__, (first, *rest)) if rest else first

    def _numbers_of(self, node: ast.AST, name: str, one: Typed, other: Typed) -> Kind:
        kind = kinds.joined(one.kind, other.kind)
        if kind is None or (kind not in (INT, FLOAT) and kind != kinds.numbers(kind.lanes)):
            raise self.refusal(node, f"`{name}` of {one.kind.name} and {other.kind.name}; it takes numbers")
        if kind.lanes and name not in self.program.kernel.primitives:
            raise self.refusal(node, f"import `{name}` of lanes from plain_vectors: that of Python takes none")
        return kind

    def _abs(self, node: ast.AST, value: Typed) -> Typed:
        if value.constant is not None and value.kind in (INT, FLOAT):
            return known(abs(value.constant)) or value
        if value.kind.lanes:
            return lanes.magnitude(self, node, value)
        value = value if value.kind is INT else self.converted(node, value, FLOAT)
        return nodes.Magnitude(value.kind, value)

    def _float(self, node: ast.AST, value: Typed) -> Typed:
        return self.converted(node, value, FLOAT)

    def _int(self, node: ast.AST, value: Typed) -> Typed:
        if value.kind is not FLOAT:
            return self.converted(node, value, INT)
        if value.constant is not None:
            return known(int(value.constant)) or value
        return nodes.Truncated(INT, value)

    def _own(self, node: ast.AST, function: str) -> str | None:
        """The kernel's own function that stands for one of `math`; None where the target has one."""
        name = self.program.library.get(function)
        if name is not None and name not in self.program.kernel.functions:
            raise self.refusal(node, f"this kernel has no polynomials for `{function}`, and this target's own differ")
        return name

    def _of_library(self, node: ast.Call, called: ast.Attribute) -> Typed:
        """math.x(...), np.x(...), and numbers seen as bits."""
        name = ast.unparse(called)
        if called.attr == "view" and isinstance(called.value, ast.Call) and len(node.args) == 1:
            return self._viewed(node, self.value(called.value), ast.unparse(node.args[0]))
        if len(node.args) != 1:
            raise self.refusal(node, f"no kernel can call `{name}` with {len(node.args)} arguments")
        value = self.value(node.args[0])
        module, _, function = name.rpartition(".")
        if name in ("np.float64", "np.int64"):
            return (self._float if name == "np.float64" else self._int)(node, value)
        if name in ("np.floor", "math.floor"):
            floor = nodes.Library(FLOAT, "floor", self.converted(node, value, FLOAT))
            return floor if module == "np" else nodes.Truncated(INT, floor)
        if module == "math" and function in FUNCTIONS:
            value, own = self.converted(node, value, FLOAT), self._own(node, function)
            return self._of_kernel(node, own, [value]) if own else nodes.Library(FLOAT, function, value)
        raise self.refusal(node, f"no kernel can call `{name}`; of math it knows {', '.join((*FUNCTIONS, 'floor'))}")

    def _viewed(self, node: ast.Call, value: Typed, kind: str) -> Typed:
        if (kind, value.kind) in (("np.int64", FLOAT), ("np.float64", INT)):
            return nodes.Viewed(INT if value.kind is FLOAT else FLOAT, value)
        raise self.refusal(node, "view a np.float64 as np.int64 or a np.int64 as np.float64")
