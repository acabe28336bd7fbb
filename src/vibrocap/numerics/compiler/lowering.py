"""From the language of kernels to LLVM's: one function for every function and combination of kinds it is called with.

The text is read once from top to bottom. A name that turns out to be of another kind further down, as in a loop, starts
the function anew with what is known by then, until nothing changes. LLVM puts variables into registers.
"""

import ast
from collections.abc import Callable, Mapping
from types import MappingProxyType

from vibrocap.numerics.compiler.calls import Calls
from vibrocap.numerics.compiler.code import named
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
    float_text,
    joined,
    literal,
)
from vibrocap.numerics.compiler.machine import SHORT
from vibrocap.numerics.compiler.snippets import HELPERS
from vibrocap.numerics.compiler.subset import Kernel, parsed

NO_LIBRARY: Mapping[str, str] = MappingProxyType({})


class Module:
    """A kernel on its way to one LLVM module: the functions made so far and what they need."""

    def __init__(self, kernel: Kernel, width: int, library: Mapping[str, str]):
        self.kernel, self.width, self.library = kernel, width, library
        self.bodies: dict[str, str] = {}
        self.needed: dict[str, None] = {}  # declarations and helpers
        self._made: dict[tuple, tuple[str, Kind] | None] = {}
        self._values: dict[str, Value | None] = {}

    def constant(self, name: str) -> Value | None:
        """A constant of the kernel; a table is written into the module when first asked for."""
        if name not in self._values:
            value = literal(self.kernel.constants[name]) if name in self.kernel.constants else None
            if value is not None and value.kind == TABLE:
                flat = value.constant.ravel()
                kind = "double" if flat.dtype.kind == "f" else "i64"
                texts = (float_text(x) if kind == "double" else str(int(x)) for x in flat.tolist())
                items = ", ".join(f"{kind} {text}" for text in texts)
                self.need(f"@{name} = internal unnamed_addr constant [{flat.size} x {kind}] [{items}], align 64")
                value.text = f"@{name}"
            self._values[name] = value
        return self._values[name]

    def need(self, text: str) -> None:
        """Something to stand in the module once."""
        self.needed[text] = None

    def helper(self, name: str) -> str:
        """A helper, put into the module; its name."""
        definition, *declarations = HELPERS[name].split("\ndeclare ")
        self.need(definition)
        for declaration in declarations:
            self.need(f"declare {declaration}")
        return f"@{name}"

    def function(self, name: str, kinds: tuple[Kind, ...], asked: "Callable[[str], Exception]") -> tuple[str, Kind]:
        """(name in the module, kind of the result) of a function of the kernel for arguments of these kinds."""
        key = (name, kinds)
        if key in self._made:
            found = self._made[key]
            if found is None:
                raise asked(f"`{name}` calls itself; write a loop")
            return found
        self._made[key] = None
        number = sum(known == name for known, _ in self._made)
        made = f"@{name}" if number == 1 else f"@{name}.{number}"
        lowered = Function(self, self.kernel.functions[name], kinds)
        result = lowered.lowered(made)
        self.bodies[made] = lowered.text
        self._made[key] = made, result
        return made, result

    @property
    def text(self) -> str:
        """All of it."""
        return "\n".join([*self.needed, *self.bodies.values()])


def lowered(
    text: str,
    entry: str,
    width: int,
    short: bool = False,
    arguments: tuple[Kind, ...] = (FLOATS, INTS, FLOATS, INT),
    library: Mapping[str, str] = NO_LIBRARY,
) -> str:
    """LLVM's text of a kernel, whose one function seen from outside is called `kernel_entry` and returns an int.

    width: lanes side by side where the text does not say (LANES); short: to be made quickly
    arguments: kinds of the arguments of the entry
    library: functions of the kernel that stand for those of `math`, and for `pow`
    """
    kernel = parsed(text)
    if entry not in kernel.functions:
        raise kernel.refusal(ast.Pass(), "", f"there is no function `{entry}`")
    wide = kernel.constants.get("LANES", width) if kernel.primitives else width
    module = Module(kernel, wide, library)
    name, result = module.function(entry, arguments, lambda what: kernel.refusal(ast.Pass(), entry, what))
    if result not in (NOTHING, INT, BOOL):
        raise kernel.refusal(kernel.functions[entry], entry, "what is called from outside returns an int or nothing")
    return (SHORT if short else "") + module.text + entry_text(name, result, arguments)


def entry_text(name: str, result: Kind, arguments: tuple[Kind, ...]) -> str:
    """The function that is called from outside."""
    head = ", ".join(f"{_argument(kind)} %a{i}" for i, kind in enumerate(arguments))
    passed = ", ".join(f"{kind.llvm} %a{i}" for i, kind in enumerate(arguments))
    lines = [f"\ndefine i64 @kernel_entry({head}) nounwind {{"]
    if result == NOTHING:
        lines += [f"  call void {name}({passed})", "  ret i64 0"]
    else:
        lines += [f"  %found = call {result.llvm} {name}({passed})"]
        lines += ["  %wide = zext i1 %found to i64"] if result == BOOL else []
        lines += [f"  ret i64 {'%wide' if result == BOOL else '%found'}"]
    return "\n".join([*lines, "}", ""])


def _argument(kind: Kind) -> str:
    """The arrays of a call share no memory."""
    return "ptr noalias nocapture" if kind in ELEMENTS else kind.llvm


class Function(Calls):
    """One function of a kernel for one combination of kinds of arguments: its statements."""

    def lowered(self, name: str) -> Kind:
        """Write the function; the kind of its result."""
        arguments = [argument.arg for argument in self.node.args.args]
        while True:
            before = dict(self.variables), self.result
            self._write(name, arguments)
            if before == (self.variables, self.result):
                return self.result or NOTHING

    def _write(self, name: str, arguments: list[str]) -> None:
        self.begin()
        for argument, kind in zip(arguments, self.kinds, strict=True):
            value = Value(kind, f"%a.{argument}")
            if argument in self._assigned:
                if kind in ELEMENTS:
                    raise self.refusal(self.node, f"the array `{argument}` cannot be given another value")
                self._assign(self.node, argument, value)
            else:
                self.bound[argument] = value
        self._block(self.node.body)
        if self.open:
            if self.result not in (None, NOTHING):
                raise self.refusal(self.node, "its end can be reached without a return; return a value there too")
            self.result = NOTHING
            self._end("ret void")
        head = ", ".join(f"{_argument(k)} %a.{a}" for a, k in zip(arguments, self.kinds, strict=True))
        places = [f"  %v.{variable} = alloca {kind.llvm}" for variable, kind in self.variables.items()]
        result = (self.result or NOTHING).llvm
        first = f"define internal {result} {name}({head}) {self.attributes} {{\nstart:"
        self.text = "\n".join([first, *places, *self.lines, "}"])

    # --- statements --------------------------------------------------------------------------------------------------

    def _block(self, statements: list[ast.stmt]) -> None:
        for statement in statements:
            if not self.open:
                return  # nothing leads here
            handler = getattr(self, f"_do_{type(statement).__name__}", None)
            if handler is None:
                raise self.refusal(
                    statement, f"no kernel has {named(statement)}; see compiler/subset.py for what it has"
                )
            handler(statement)

    def _do_Pass(self, node: ast.Pass) -> None:
        """Nothing."""

    def _do_Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Constant):
            return  # a docstring
        if not isinstance(node.value, ast.Call):
            raise self.refusal(node, "a statement that is an expression calls a function; leave it out")
        self._call(node.value)

    def _do_Assign(self, node: ast.Assign) -> None:
        if len(node.targets) != 1:
            raise self.refusal(node, "assign to one target at a time; write a line for each")
        self._put(node, node.targets[0], self.value(node.value))

    def _put(self, node: ast.AST, target: ast.expr, value: Value) -> None:
        if isinstance(target, ast.Name):
            self._assign(node, target.id, value)
        elif isinstance(target, ast.Tuple):
            items = self.items(value)
            if items is None or len(items) != len(target.elts):
                raise self.refusal(node, f"{len(target.elts)} names cannot take {value.kind.name}")
            for part, item in zip(target.elts, items, strict=True):
                self._put(node, part, item)
        elif isinstance(target, ast.Subscript):
            array, place = self._entry(target)
            self._store(node, array, place, value)
        else:
            raise self.refusal(node, "assign to a name, an entry of an array or a tuple of these")

    def _assign(self, node: ast.AST, name: str, value: Value) -> None:
        if value.kind in (NOTHING, FLOATS, INTS, TABLE):
            raise self.refusal(node, f"`{name}` cannot stand for {value.kind.name}; use it where it is")
        if name in self._once:
            self.bound[name] = value
            return
        kind = value.kind
        if name in self.variables:
            both = joined(self.variables[name], kind)
            if both is None:
                before = self.variables[name].name
                raise self.refusal(node, f"`{name}` is {before} elsewhere, {kind.name} here; use two names")
            kind = both
        self.variables[name] = kind
        self.do(f"store {kind.llvm} {self.as_kind(node, value, kind).text}, ptr %v.{name}")

    def _do_AugAssign(self, node: ast.AugAssign) -> None:
        if isinstance(node.target, ast.Subscript):
            array, place = self._entry(node.target)
            kind = ELEMENTS[array.kind]
            before = self.emit(kind, f"load {kind.llvm}, ptr {place}")
            self._store(node, array, place, self._binary(node, node.op, before, self.value(node.value)))
            return
        if not isinstance(node.target, ast.Name):
            raise self.refusal(node, "augment a name or an entry of an array")
        before = self._name(node, node.target.id)
        self._assign(node, node.target.id, self._binary(node, node.op, before, self.value(node.value)))

    def _store(self, node: ast.AST, array: Value, place: str, value: Value) -> None:
        kind = ELEMENTS[array.kind]
        if value.kind not in SCALARS or (kind == INT and value.kind == FLOAT):
            raise self.refusal(node, f"an {array.kind.name} takes no {value.kind.name}; convert it")
        self.do(f"store {kind.llvm} {self.as_kind(node, value, kind).text}, ptr {place}")

    def _do_If(self, node: ast.If) -> None:
        condition = self.condition(node.test)
        if condition.constant is not None:
            self._block(node.body if condition.constant else node.orelse)
            return
        yes, no, after = self.label(), self.label(), self.label()
        self._fork(condition, yes, no)
        reached = False
        for label, statements in ((yes, node.body), (no, node.orelse)):
            self.start(label)
            self._block(statements)
            if self.open:
                self._jump(after)
                reached = True
        if reached:
            self.start(after)

    def _do_While(self, node: ast.While) -> None:
        if node.orelse:
            raise self.refusal(node, "a loop has no else; use a bool")
        head, body, after = self.label(), self.label(), self.label()
        self._jump(head)
        self.start(head)
        condition = self.condition(node.test)
        self.loops.append([head, after, not condition.constant])
        if condition.constant is None:
            self._fork(condition, body, after)
        else:
            self._jump(body if condition.constant else after)
        self.start(body)
        self._block(node.body)
        if self.open:
            self._jump(head)
        if self.loops.pop()[2]:
            self.start(after)

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
        head, body, following, after = (self.label() for _ in range(4))
        before = self.block
        counter = f"%i{self.count}"
        self._jump(head)
        self.start(head)
        place = len(self.lines)
        going = self.emit(BOOL, f"icmp {'slt' if step > 0 else 'sgt'} i64 {counter}, {last.text}")
        self._fork(going, body, after)
        self.start(body)
        self._assign(node, node.target.id, Value(INT, counter))
        self.loops.append([following, after, True])
        self._block(node.body)
        if self.open:
            self._jump(following)
        self.loops.pop()
        self.start(following)
        moved = self.emit(INT, f"add nsw i64 {counter}, {step}")
        self._jump(head)
        self.lines.insert(place, f"  {counter} = phi i64 [ {first.text}, %{before} ], [ {moved.text}, %{following} ]")
        self.start(after)

    def _do_Break(self, node: ast.Break) -> None:
        self.loops[-1][2] = True
        self._jump(self.loops[-1][1])

    def _do_Continue(self, node: ast.Continue) -> None:
        self._jump(self.loops[-1][0])

    def _do_Return(self, node: ast.Return) -> None:
        value = Value(NOTHING, "") if node.value is None else self.value(node.value)
        both = value.kind if self.result is None else joined(self.result, value.kind)
        if both is None or value.kind in (FLOATS, INTS, TABLE):
            raise self.refusal(node, f"returns {value.kind.name}, elsewhere {(self.result or NOTHING).name}")
        self.result = both
        self._end("ret void" if both == NOTHING else f"ret {both.llvm} {self.as_kind(node, value, both).text}")
