"""JavaScript: a kernel as a module that a browser runs, with the bits of plain Python.

The text is translated function by function for the kinds of its arguments, as for LLVM. Every number is one of
JavaScript's floats of 64 bits, which it neither fuses nor reorders: sums and products have the bits of Python's. The
functions of `math` are the kernel's own polynomials, since those of a browser are its own affair; sqrt and floor are
exact everywhere.

Ints are floats too, exact up to 2^53: counts and places, no more. Only what is taken as bits (`view`, `& | ^ << >>`) is
a BigInt of 64 bits, until it is a float, a place or an entry of an array again. A result of ints is never -0.

Tuples are arrays where a function returns one, and names of their own otherwise. An array of ints is a Float64Array.
"""

import ast
from collections.abc import Callable, Mapping

from vibrocap.numerics.compiler.code import named
from vibrocap.numerics.compiler.javascript_expressions import Expressions
from vibrocap.numerics.compiler.javascript_values import (
    BITS,
    HELPERS,
    NEEDS,
    SIMPLE,
    float_literal,
    joined_kind,
    variable_name,
)
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
    Kind,
    Value,
    literal,
)
from vibrocap.numerics.compiler.subset import Kernel, parsed

# What a kernel of one motion does not define itself (`numerics/card.py` does so for a card).
OWN = {
    "sine": "def sine(x):\n    return sine_cosine(x)[0]\n",
    "cosine": "def cosine(x):\n    return sine_cosine(x)[1]\n",
    "power": "def power(x, y):\n    return exponential(y * logarithm(x))\n",
}


def javascript_text(text: str, entry: str, arguments: tuple[Kind, ...] = (FLOATS, INTS, FLOATS, INT)) -> str:
    """A kernel as the text of a JavaScript module, which exports the function `entry`.

    It takes arrays as Float64Array, those of ints too, and returns a number (0 for nothing).
    arguments: kinds of the arguments of the entry
    Raises Refused where the text is no kernel of one motion.
    """
    return "\n".join([*javascript_statements(text, {entry: arguments}), ""])


def javascript_statements(text: str, entries: Mapping[str, tuple[Kind, ...]]) -> tuple[str, ...]:
    """The statements of a module that exports several functions: what kernels have in common can be sent once.

    entries: kinds of the arguments, by the name of the function; the exports are the last statements, in this order
    """
    module = Module(parsed(with_own_functions(text)))
    exported = [_export(module, entry, arguments) for entry, arguments in entries.items()]
    return (*module.needed, *module.bodies.values(), *exported)


def with_own_functions(text: str) -> str:
    """A kernel that has polynomials, with all functions of `math` made of them."""
    known = parsed(text).functions
    missing = [own for name, own in OWN.items() if name not in known and "sine_cosine" in known]
    return "\n\n".join([text, "# From compiler/javascript.py", *missing]) if missing else text


def _export(module: "Module", entry: str, arguments: tuple[Kind, ...]) -> str:
    """The statement that exports a function of a kernel."""
    kernel = module.kernel
    if entry not in kernel.functions:
        raise kernel.refusal(ast.Pass(), "", f"there is no function `{entry}`")
    made, result = module.function(entry, arguments, lambda what: kernel.refusal(ast.Pass(), entry, what))
    if result not in (NOTHING, INT, BITS, BOOL):
        raise kernel.refusal(kernel.functions[entry], entry, "what is called from outside returns an int or nothing")
    names = ", ".join(variable_name(argument.arg) for argument in kernel.functions[entry].args.args)
    call = f"{made}({names})"
    found = f"{call};\n  return 0" if result == NOTHING else f"return Number({call})"
    return f"export function {entry}({names}) {{\n  {found};\n}}"


class Module:
    """A kernel on its way to one module: the functions made so far and what they need."""

    def __init__(self, kernel: Kernel):
        self.kernel = kernel
        self.bodies: dict[str, str] = {}
        self.needed: dict[str, None] = {}  # helpers and tables
        self._made: dict[tuple, tuple[str, Kind] | None] = {}
        self._values: dict[str, Value | None] = {}

    def helper(self, name: str) -> str:
        """A helper, put into the module with those it calls; its name."""
        for other in (*NEEDS.get(name, ()), name):
            self.needed[HELPERS[other]] = None
        return f"$${name}"

    def constant(self, name: str) -> Value | None:
        """A constant of the kernel; a table is written into the module when first asked for."""
        if name not in self._values:
            value = literal(self.kernel.constants[name]) if name in self.kernel.constants else None
            if value is not None and value.kind == TABLE:
                value.text = f"$${name}"
                content = ", ".join(float_literal(float(number)) for number in value.constant.ravel().tolist())
                self.needed[f"const {value.text} = Float64Array.of({content});"] = None
            self._values[name] = value
        return self._values[name]

    def function(self, name: str, kinds: tuple[Kind, ...], asked: Callable[[str], Exception]) -> tuple[str, Kind]:
        """(name in the module, kind of the result) of a function of the kernel for arguments of these kinds."""
        key = (name, kinds)
        if key in self._made:
            found = self._made[key]
            if found is None:
                raise asked(f"`{name}` calls itself; write a loop")
            return found
        self._made[key] = None
        number = sum(known == name for known, _ in self._made)
        made = f"${name}" if number == 1 else f"${name}${number}"
        written = Function(self, self.kernel.functions[name], kinds)
        result = written.written(made)
        self.bodies[made] = written.text
        self._made[key] = made, result
        return made, result


class Function(Expressions):
    """One function of a kernel for one combination of kinds of arguments: its statements."""

    def written(self, name: str) -> Kind:
        """Write the function, anew until the kinds of its names stay the same; the kind of its result."""
        while True:
            before = dict(self.variables), self.result
            self._write(name)
            if before == (self.variables, self.result):
                return self.result or NOTHING

    def _write(self, name: str) -> None:
        self.lines, self.bound, self.depth, self.count, self.loops = [], {}, 1, 0, []
        names = [argument.arg for argument in self.node.args.args]
        for argument, kind in zip(names, self.kinds, strict=True):
            value = Value(kind, variable_name(argument))
            if argument not in self._assigned:
                self.bound[argument] = value
            elif kind in ELEMENTS:
                raise self.refusal(self.node, f"the array `{argument}` cannot be given another value")
            else:
                self._assign(self.node, argument, value)
        if self._block(self.node.body):
            if self.result not in (None, NOTHING):
                raise self.refusal(self.node, "its end can be reached without a return; return a value there too")
            self.result = NOTHING
        locals_ = [variable_name(name) for name in self.variables if name not in names]
        locals_ += [f"${i + 1}" for i in range(self.count)]
        head = f"function {name}({', '.join(map(variable_name, names))}) {{"
        self.text = "\n".join([head, *([f"  let {', '.join(locals_)};"] if locals_ else []), *self.lines, "}"])

    def _block(self, statements: list[ast.stmt]) -> bool:
        """Write statements; whether what follows them can be reached."""
        for statement in statements:
            handler = getattr(self, f"_do_{type(statement).__name__}", None)
            if handler is None:
                raise self.refusal(
                    statement, f"no kernel has {named(statement)}; see compiler/subset.py for what it has"
                )
            if handler(statement) is False:
                return False
        return True

    def _inner(self, statements: list[ast.stmt]) -> bool:
        self.depth += 1
        reached = self._block(statements)
        self.depth -= 1
        return reached

    def _do_Pass(self, node: ast.Pass) -> None:
        """Nothing."""

    def _do_Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Constant):
            return  # a docstring
        if not isinstance(node.value, ast.Call):
            raise self.refusal(node, "a statement that is an expression calls a function; leave it out")
        self.do(f"{self._call(node.value).text};")

    def _do_Assign(self, node: ast.Assign) -> None:
        if len(node.targets) != 1:
            raise self.refusal(node, "assign to one target at a time; write a line for each")
        self._put(node, node.targets[0], self.value(node.value))

    def _put(self, node: ast.AST, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            self._assign(node, target.id, value)
        elif isinstance(target, ast.Tuple):
            if len(value.kind.items) != len(target.elts):
                raise self.refusal(node, f"{len(target.elts)} names cannot take {value.kind.name}")
            for part, item in zip(target.elts, self._held(value), strict=True):
                self._put(node, part, item)
        elif isinstance(target, ast.Subscript):
            array, place = self._entry(target)
            if "(" in value.text and not SIMPLE.fullmatch(place):  # a call may write what the place is read from
                first, value = self.once(value)
                self.do(f"{first.text};")
            self._store(node, array, place, value)
        else:
            raise self.refusal(node, "assign to a name, an entry of an array or a tuple of these")

    def _held(self, value: Value) -> list[Value]:
        """The items of a tuple, each evaluated by now and untouched by assignments to names."""
        if value.items is None:
            first, value = self.once(value)
            if first is not value:
                self.do(f"{first.text};")
            return [Value(kind, f"{value.text}[{i}]") for i, kind in enumerate(value.kind.items)]
        held = []
        for item in value.items:
            if item.constant is not None:
                held.append(item)
            elif item.items is not None:
                held.append(Value(item.kind, "", None, tuple(self._held(item))))
            else:
                self.count += 1
                self.do(f"${self.count} = {item.text};")
                held.append(Value(item.kind, f"${self.count}"))
        return held

    def _assign(self, node: ast.AST, name: str, value: Value) -> None:
        if value.kind in (NOTHING, FLOATS, INTS, TABLE):
            raise self.refusal(node, f"`{name}` cannot stand for {value.kind.name}; use it where it is")
        if name in self._once and value.constant is not None:
            self.bound[name] = value
            return
        kind = value.kind
        if name in self.variables:
            both = joined_kind(self.variables[name], kind)
            if both is None:
                before = self.variables[name].name
                raise self.refusal(node, f"`{name}` is {before} elsewhere, {kind.name} here; use two names")
            kind = both
        self.variables[name] = kind
        text = self.written_out(self.as_kind(node, value, kind))
        if text != variable_name(name):
            self.do(f"{variable_name(name)} = {text};")

    def _do_AugAssign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Name):
            before = self._name(node, node.target.id)
            self._assign(node, node.target.id, self._binary(node, node.op, before, self.value(node.value)))
        elif isinstance(node.target, ast.Subscript):
            array, place = self._entry(node.target)
            first, again = self.once(Value(INT, place))
            if first is not again:
                self.do(f"{first.text};")
            before = Value(ELEMENTS[array.kind], f"{array.text}[{again.text}]")
            self._store(node, array, again.text, self._binary(node, node.op, before, self.value(node.value)))
        else:
            raise self.refusal(node, "augment a name or an entry of an array")

    def _store(self, node: ast.AST, array: Value, place: str, value: Value) -> None:
        kind = ELEMENTS[array.kind]
        if value.kind not in (*SCALARS, BITS) or (kind == INT and value.kind == FLOAT):
            raise self.refusal(node, f"an {array.kind.name} takes no {value.kind.name}; convert it")
        self.do(f"{array.text}[{place}] = {self.written_out(self.as_kind(node, value, kind))};")

    def _do_If(self, node: ast.If) -> bool:
        condition = self.condition(node.test)
        if condition.constant is not None:
            return self._block(node.body if condition.constant else node.orelse)
        self.do(f"if ({condition.text}) {{")
        reached = self._inner(node.body)
        if not node.orelse:
            self.do("}")
            return True
        self.do("} else {")
        reached = self._inner(node.orelse) or reached
        self.do("}")
        return reached

    def _do_While(self, node: ast.While) -> bool:
        if node.orelse:
            raise self.refusal(node, "a loop has no else; use a bool")
        condition = self.condition(node.test)
        if condition.constant is False:
            return True
        self.loops.append(condition.constant is None)
        self.do(f"while ({self.written_out(condition)}) {{")
        self._inner(node.body)
        self.do("}")
        return self.loops.pop()

    def _do_For(self, node: ast.For) -> None:
        if node.orelse:
            raise self.refusal(node, "a loop has no else; use a bool")
        call = node.iter
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and isinstance(node.target, ast.Name)):
            raise self.refusal(node, "loop with one name over range(...)")
        if call.func.id != "range" or call.keywords or not 1 <= len(call.args) <= 3:
            raise self.refusal(node, "loop with one name over range(...)")
        bounds = [self.as_kind(node, self.value(argument), INT) for argument in call.args]
        first = bounds[0] if len(bounds) > 1 else Value(INT, "0", 0)
        last = bounds[min(1, len(bounds) - 1)]
        step = bounds[2].constant if len(bounds) == 3 else 1
        if not step:
            raise self.refusal(node, "the step of a range is a constant other than 0; write it as one")
        if first.constant is not None and last.constant is not None and not range(first.constant, last.constant, step):
            return
        self.count += 1
        counter = f"i${self.count}"
        begin, end = f"{counter} = {self.written_out(first)}", self.written_out(last)
        if last.constant is None:
            begin, end = f"{begin}, end{counter} = {end}", f"end{counter}"
        going = f"{counter} {'<' if step > 0 else '>'} {end}"
        self.do(f"for (let {begin}; {going}; {counter} += {step}) {{")
        self.depth += 1
        self._assign(node, node.target.id, Value(INT, counter))
        self.depth -= 1
        self.loops.append(True)
        self._inner(node.body)
        self.loops.pop()
        self.do("}")

    def _do_Break(self, node: ast.Break) -> bool:
        self.loops[-1] = True
        self.do("break;")
        return False

    def _do_Continue(self, node: ast.Continue) -> bool:
        self.do("continue;")
        return False

    def _do_Return(self, node: ast.Return) -> bool:
        value = Value(NOTHING, "") if node.value is None else self.value(node.value)
        both = value.kind if self.result is None else joined_kind(self.result, value.kind)
        if both is None or value.kind in (FLOATS, INTS, TABLE):
            raise self.refusal(node, f"returns {value.kind.name}, elsewhere {(self.result or NOTHING).name}")
        self.result = both
        self.do("return;" if both == NOTHING else f"return {self.written_out(self.as_kind(node, value, both))};")
        return False
