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
import functools
import math
import re
from collections.abc import Callable

from vibrocap.numerics.compiler.code import named
from vibrocap.numerics.compiler.expressions import BITWISE, PYTHON
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
    joined,
    literal,
    tuple_of,
)
from vibrocap.numerics.compiler.subset import LIBRARY, Kernel, names_assigned, parsed

BITS = Kind("int", "i64")  # an int as a BigInt
LARGEST = 2**53  # up to which every int is a float
ARITHMETIC = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
SIGNS = {ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^", ast.LShift: "<<", ast.RShift: ">>"}
COMPARED = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "===", ast.NotEq: "!=="}
SIMPLE = re.compile(r"[\w$]+|\(-?[\d.e+-]+\)")  # what may be written twice
RESERVED = re.compile(  # names that Python lets be variables and JavaScript does not, and those used below
    "arguments|case|catch|const|debugger|default|delete|do|enum|eval|export|extends|false|function|implements|"
    "instanceof|interface|let|new|null|package|private|protected|public|static|super|switch|this|throw|true|typeof|"
    "undefined|var|void|Math|Number|Object|BigInt|Infinity|NaN|Float64Array|BigInt64Array"
)
# What a kernel of one motion does not define itself (`numerics/card.py` does so for a card).
OWN = {
    "sine": "def sine(x):\n    return sine_cosine(x)[0]\n",
    "cosine": "def cosine(x):\n    return sine_cosine(x)[1]\n",
    "power": "def power(x, y):\n    return exponential(y * logarithm(x))\n",
}
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


def javascript_text(text: str, entry: str, arguments: tuple[Kind, ...] = (FLOATS, INTS, FLOATS, INT)) -> str:
    """A kernel as the text of a JavaScript module, which exports the function `entry`.

    It takes arrays as Float64Array, those of ints too, and returns a number (0 for nothing).
    arguments: kinds of the arguments of the entry
    Raises Refused where the text is no kernel of one motion.
    """
    kernel = parsed(text)
    missing = [own for name, own in OWN.items() if name not in kernel.functions and "sine_cosine" in kernel.functions]
    if missing:
        kernel = parsed("\n\n".join([text, "# From compiler/javascript.py", *missing]))
    if entry not in kernel.functions:
        raise kernel.refusal(ast.Pass(), "", f"there is no function `{entry}`")
    module = Module(kernel)
    made, result = module.function(entry, arguments, lambda what: kernel.refusal(ast.Pass(), entry, what))
    if result not in (NOTHING, INT, BITS, BOOL):
        raise kernel.refusal(kernel.functions[entry], entry, "what is called from outside returns an int or nothing")
    names = ", ".join(_variable(argument.arg) for argument in kernel.functions[entry].args.args)
    call = f"{made}({names})"
    found = f"{call};\n  return 0" if result == NOTHING else f"return Number({call})"
    exported = f"export function {entry}({names}) {{\n  {found};\n}}"
    return "\n".join([*module.needed, *module.bodies.values(), exported, ""])


def _variable(name: str) -> str:
    """A name of Python's as one of JavaScript's."""
    return name + "$" if RESERVED.fullmatch(name) else name


def _float(number: float) -> str:
    """A float as JavaScript reads it, all its bits."""
    if math.isnan(number):
        return "NaN"
    if math.isinf(number):
        return "Infinity" if number > 0.0 else "(-Infinity)"
    shown = repr(number).removesuffix(".0")
    return f"({shown})" if shown.startswith("-") else shown


def _joined(one: Kind, other: Kind) -> Kind | None:
    """The kind that holds values of both; an int that is taken as bits stays so."""
    if BITS in (one, other):
        rest = {one, other} - {BITS}
        return BITS if rest <= {INT, BOOL} else FLOAT if rest == {FLOAT} else None
    if one.items and len(one.items) == len(other.items):
        items = [_joined(a, b) for a, b in zip(one.items, other.items, strict=True)]
        return None if None in items else tuple_of(tuple(item for item in items if item is not None))
    return joined(one, other)


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
                content = ", ".join(_float(float(number)) for number in value.constant.ravel().tolist())
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


class Function:
    """One function of a kernel for one combination of kinds of arguments."""

    def __init__(self, module: Module, node: ast.FunctionDef, kinds: tuple[Kind, ...]):
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
            value = Value(kind, _variable(argument))
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
        locals_ = [_variable(name) for name in self.variables if name not in names]
        locals_ += [f"${i + 1}" for i in range(self.count)]
        head = f"function {name}({', '.join(map(_variable, names))}) {{"
        self.text = "\n".join([head, *([f"  let {', '.join(locals_)};"] if locals_ else []), *self.lines, "}"])

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

    # --- statements --------------------------------------------------------------------------------------------------

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
            both = _joined(self.variables[name], kind)
            if both is None:
                before = self.variables[name].name
                raise self.refusal(node, f"`{name}` is {before} elsewhere, {kind.name} here; use two names")
            kind = both
        self.variables[name] = kind
        text = self.written_out(self.as_kind(node, value, kind))
        if text != _variable(name):
            self.do(f"{_variable(name)} = {text};")

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
        both = value.kind if self.result is None else _joined(self.result, value.kind)
        if both is None or value.kind in (FLOATS, INTS, TABLE):
            raise self.refusal(node, f"returns {value.kind.name}, elsewhere {(self.result or NOTHING).name}")
        self.result = both
        self.do("return;" if both == NOTHING else f"return {self.written_out(self.as_kind(node, value, both))};")
        return False

    # --- values ------------------------------------------------------------------------------------------------------

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
        return _float(value.constant) if value.kind == FLOAT else self._whole_text(value.constant)

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
        if (value.kind, kind) != (BITS, INT) and _joined(value.kind, kind) != kind:
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
            return self._one_after_another(parts, isinstance(node.op, ast.And))
        value = self.value(node)
        if value.kind == BOOL:
            return value
        if value.kind not in (INT, BITS, FLOAT):
            raise self.refusal(node, f"{value.kind.name} is neither yes nor no")
        if value.constant is not None:
            return Value(BOOL, "", bool(value.constant))
        return Value(BOOL, f"({value.text} !== {'0n' if value.kind == BITS else '0'})")

    def _one_after_another(self, parts: list[Callable[[], Value]], all_of: bool) -> Value:
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

    # --- expressions -------------------------------------------------------------------------------------------------

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
            return Value(self.variables[name], _variable(name))
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

        return self._one_after_another([functools.partial(pair, i) for i in range(len(node.ops))], True)

    def _compared(self, node: ast.AST, op: ast.cmpop, left: Value, right: Value) -> Value:
        folded = self._folded(op, left, right)
        if folded is not None:
            return folded
        if type(op) not in COMPARED:
            raise self.refusal(node, f"no kernel has {named(op)}")
        kind = _joined(left.kind, right.kind)
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
        return self._one_after_another(parts, False)

    def _negated(self, value: Value) -> Value:
        return self._folded(ast.Not(), value) or Value(BOOL, f"(!{value.text})")

    def _of_BoolOp(self, node: ast.BoolOp) -> Value:
        parts = [functools.partial(self._choice, part) for part in node.values]
        return self._one_after_another(parts, isinstance(node.op, ast.And))

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
        kind = _joined(one.kind, other.kind)
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
        kind = _joined(one.kind, other.kind)
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
