"""Calls: functions of the kernel, of Python, of `math`, and numbers seen as bits."""

import ast
import functools

from vibrocap.numerics.compiler import lanes
from vibrocap.numerics.compiler.expressions import Expressions
from vibrocap.numerics.compiler.kinds import BOOL, ELEMENTS, FLOAT, INT, NOTHING, TABLE, Value, joined, literal

INTRINSIC = ("sin", "cos", "exp", "log", "sqrt")  # of LLVM, which calls the C library for them
LIBRARY = ("tanh", "atan")


class Calls(Expressions):
    """Writes the code of calls."""

    def _of_Call(self, node: ast.Call) -> Value:
        value = self._call(node)
        if value.kind == NOTHING:
            raise self.refusal(node, "this call returns nothing")
        return value

    def _call(self, node: ast.Call) -> Value:
        if node.keywords:
            raise self.refusal(node, "arguments are positional; leave their names out")
        called = node.func
        if isinstance(called, ast.Attribute):
            return self._of_library(node, called)
        if not isinstance(called, ast.Name):
            raise self.refusal(node, "call a function by its name")
        arguments = [self.value(argument) for argument in node.args]
        name = called.id
        if name in self.module.kernel.functions:
            return self.of_kernel(node, name, arguments)
        if name in self.module.kernel.primitives:
            return lanes.primitive(self, node, name, arguments)
        if name in ("min", "max") and len(arguments) >= 2:
            return functools.reduce(functools.partial(self._extreme, node, name), arguments)
        if name in ("abs", "float", "int") and len(arguments) == 1:
            return getattr(self, f"_{name}")(node, arguments[0])
        raise self.refusal(node, f"no kernel can call `{name}` with {len(arguments)} arguments")

    def of_kernel(self, node: ast.AST, name: str, arguments: list[Value]) -> Value:
        """A call of one of the kernel's own functions."""
        wanted = len(self.module.kernel.functions[name].args.args)
        if len(arguments) != wanted:
            raise self.refusal(node, f"`{name}` takes {wanted} arguments, not {len(arguments)}")
        arrays = [argument.text for argument in arguments if argument.kind in ELEMENTS]
        if len(set(arrays)) < len(arrays):
            raise self.refusal(node, "the arrays of a call are different ones; pass each once")
        if any(argument.kind in (TABLE, NOTHING) for argument in arguments):
            raise self.refusal(node, "a table is no argument; name it in the function that reads it")
        asked = functools.partial(self.refusal, node)
        made, result = self.module.function(name, tuple(argument.kind for argument in arguments), asked)
        packed = [self.packed(node, argument) if argument.kind.items else argument for argument in arguments]
        passed = ", ".join(f"{argument.kind.llvm} {argument.text}" for argument in packed)
        if result == NOTHING:
            self.do(f"call void {made}({passed})")
            return Value(NOTHING, "")
        return self.emit(result, f"call {result.llvm} {made}({passed})")

    def _extreme(self, node: ast.AST, name: str, one: Value, other: Value) -> Value:
        """As Python: the first that no other is less (or greater) than; a NaN behind a number is passed over."""
        kind = joined(one.kind, other.kind)
        if kind not in (INT, FLOAT):
            raise self.refusal(node, f"`{name}` of {one.kind.name} and {other.kind.name}; for lanes, use where(...)")
        one, other = self.as_kind(node, one, kind), self.as_kind(node, other, kind)
        better = self.compared(node, ast.Gt() if name == "max" else ast.Lt(), other, one)
        if better.constant is not None:
            return other if better.constant else one
        return self.emit(kind, f"select i1 {better.text}, {kind.llvm} {other.text}, {kind.llvm} {one.text}")

    def _abs(self, node: ast.AST, value: Value) -> Value:
        if value.constant is not None and value.kind in (INT, FLOAT):
            return literal(abs(value.constant)) or value
        if value.kind.lanes:
            return lanes.magnitude(self, node, value)
        if value.kind == INT:
            negative = self.emit(BOOL, f"icmp slt i64 {value.text}, 0")
            minus = self.emit(INT, f"sub i64 0, {value.text}")
            return self.emit(INT, f"select i1 {negative.text}, i64 {minus.text}, i64 {value.text}")
        return self._intrinsic(node, "fabs", value)

    def _float(self, node: ast.AST, value: Value) -> Value:
        return self.as_kind(node, value, FLOAT)

    def _int(self, node: ast.AST, value: Value) -> Value:
        if value.kind != FLOAT:
            return self.as_kind(node, value, INT)
        if value.constant is not None:
            return literal(int(value.constant)) or value
        return self.emit(INT, f"fptosi double {value.text} to i64")

    def _intrinsic(self, node: ast.AST, name: str, value: Value) -> Value:
        """One of LLVM's own functions of one float."""
        value = self.as_kind(node, value, FLOAT)
        self.need(f"declare double @llvm.{name}.f64(double)")
        return self.emit(FLOAT, f"call double @llvm.{name}.f64(double {value.text})")

    def _of_library(self, node: ast.Call, called: ast.Attribute) -> Value:
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
            found = self._intrinsic(node, "floor", value)
            return found if module == "np" else self.emit(INT, f"fptosi double {found.text} to i64")
        if module == "math" and function in self.module.library:
            return self.of_kernel(node, self.module.library[function], [self.as_kind(node, value, FLOAT)])
        if module == "math" and function in INTRINSIC:
            return self._intrinsic(node, function, value)
        if module == "math" and function in LIBRARY:
            value = self.as_kind(node, value, FLOAT)
            self.need(f"declare double @{function}(double) nounwind willreturn memory(none)")
            return self.emit(FLOAT, f"call double @{function}(double {value.text})")
        known = ", ".join((*INTRINSIC, *LIBRARY, "floor"))
        raise self.refusal(node, f"no kernel can call `{name}`; of math it knows {known}")

    def _viewed(self, node: ast.Call, value: Value, kind: str) -> Value:
        if (kind, value.kind) == ("np.int64", FLOAT):
            return self.emit(INT, f"bitcast double {value.text} to i64")
        if (kind, value.kind) == ("np.float64", INT):
            return self.emit(FLOAT, f"bitcast i64 {value.text} to double")
        raise self.refusal(node, "view a np.float64 as np.int64 or a np.int64 as np.float64")
