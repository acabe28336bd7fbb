"""From the typed tree to LLVM's language; LLVM puts variables into registers."""

from collections.abc import Mapping
from typing import Any

from vibrocap.numerics.compiler import kinds
from vibrocap.numerics.compiler.code import ALIGNED, Code
from vibrocap.numerics.compiler.kinds import BOOL, ELEMENTS, FLOATS, INT, INTS, NOTHING, Kind, Value
from vibrocap.numerics.compiler.machine import SHORT
from vibrocap.numerics.compiler.subset import parsed, uncollected
from vibrocap.numerics.compiler.typed import nodes
from vibrocap.numerics.compiler.typed.program import NO_LIBRARY, Program

# What LLVM has no instruction for; the division of the least int by -1, which has no result, is none.
HELPERS = {
    "floor_divided": """define internal i64 @floor_divided(i64 %x, i64 %y) alwaysinline nounwind {
  %zero = icmp eq i64 %y, 0
  %minus = icmp eq i64 %y, -1
  %special = or i1 %zero, %minus
  %divisor = select i1 %special, i64 1, i64 %y
  %q = sdiv i64 %x, %divisor
  %r = srem i64 %x, %divisor
  %rest = icmp ne i64 %r, 0
  %signs = xor i64 %r, %divisor
  %opposite = icmp slt i64 %signs, 0
  %below = and i1 %rest, %opposite
  %one = zext i1 %below to i64
  %floor = sub i64 %q, %one
  %negated = sub i64 0, %x
  %ordinary = select i1 %minus, i64 %negated, i64 %floor
  %result = select i1 %zero, i64 0, i64 %ordinary
  ret i64 %result
}""",
    "floor_rest": """define internal i64 @floor_rest(i64 %x, i64 %y) alwaysinline nounwind {
  %zero = icmp eq i64 %y, 0
  %minus = icmp eq i64 %y, -1
  %special = or i1 %zero, %minus
  %divisor = select i1 %special, i64 1, i64 %y
  %r = srem i64 %x, %divisor
  %rest = icmp ne i64 %r, 0
  %signs = xor i64 %r, %divisor
  %opposite = icmp slt i64 %signs, 0
  %below = and i1 %rest, %opposite
  %added = add i64 %r, %divisor
  %result = select i1 %below, i64 %added, i64 %r
  ret i64 %result
}""",
}


class Module:
    """A kernel on its way to one LLVM module: the functions written so far and what they need."""

    def __init__(self, width: int):
        self.width = width
        self.bodies: dict[str, str] = {}
        self.names: dict[nodes.Function, str] = {}
        self.needed: dict[str, None] = {}  # declarations and helpers

    def table(self, table: nodes.Table) -> str:
        """The name of a table, which is written into the module when first asked for."""
        flat = table.constant.ravel()
        kind = "double" if flat.dtype.kind == "f" else "i64"
        texts = (kinds.float_text(x) if kind == "double" else str(int(x)) for x in flat.tolist())
        items = ", ".join(f"{kind} {text}" for text in texts)
        content = f"internal unnamed_addr constant [{flat.size} x {kind}] [{items}], align 64"
        name = self.called(table.name, content)
        self.need(f"@{name} = {content}")
        return f"@{name}"

    def need(self, text: str) -> None:
        """Something to stand in the module once."""
        self.needed[text] = None

    def helper(self, name: str) -> str:
        """A helper, put into the module; its name."""
        self.need(HELPERS[name])
        return f"@{name}"

    def written(self, function: nodes.Function) -> str:
        """The name of a function, which is written when first called."""
        if function not in self.names:
            body = LLVMFunction(self, function).written()
            name = self.names[function] = self.called(function.name, body)
            self.bodies[name] = body.replace(f"@{function.name}(", f"@{name}(", 1)
        return f"@{self.names[function]}"

    def called(self, name: str, content: str) -> str:
        """What a function or table of the kernel is called in the module."""
        return name

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
    with uncollected():
        kernel = parsed(text)
        wide = kernel.constants.get("LANES", width) if kernel.primitives else width
        function = Program(kernel, wide, library).entry(entry, arguments)
        module = Module(wide)
        name = module.written(function)
    return (SHORT if short else "") + module.text + entry_text(name, function.result, arguments)


def entry_text(
    name: str, result: Kind, arguments: tuple[Kind, ...], exported: str = "kernel_entry", whole: str = "i64"
) -> str:
    """The function that is called from outside, by ints of the type `whole`, of 64 bits or fewer."""
    same = whole == INT.llvm
    head = ", ".join(f"{whole if kind == INT else _argument(kind)} %a{i}" for i, kind in enumerate(arguments))
    widened = [i for i, kind in enumerate(arguments) if kind == INT and not same]
    passed = ", ".join(f"{kind.llvm} %{'w' if i in widened else 'a'}{i}" for i, kind in enumerate(arguments))
    lines = [f"\ndefine {whole} @{exported}({head}) nounwind {{"]
    lines += [f"  %w{i} = sext {whole} %a{i} to i64" for i in widened]
    if result == NOTHING:
        lines += [f"  call void {name}({passed})", f"  ret {whole} 0"]
    else:
        lines += [f"  %found = call {result.llvm} {name}({passed})"]
        as_is = same and result == INT
        change = "zext i1" if result == BOOL else "trunc i64"
        lines += [] if as_is else [f"  %wide = {change} %found to {whole}"]
        lines += [f"  ret {whole} {'%found' if as_is else '%wide'}"]
    return "\n".join([*lines, "}", ""])


def _argument(kind: Kind) -> str:
    """The arrays of a call share no memory."""
    return "ptr noalias nocapture" if kind in ELEMENTS else kind.llvm


class LLVMFunction(Code):
    """Writes the statements of a function."""

    def written(self) -> str:
        """All of it."""
        function = self.function
        self._block(function.body)
        head = ", ".join(f"{_argument(kind)} %a.{name}" for name, kind in function.arguments)
        places = [f"  %v.{variable} = alloca {kind.llvm}" for variable, kind in function.variables.items()]
        first = f"define internal {function.result.llvm} @{function.name}({head}) {self.attributes} {{\nstart:"
        return "\n".join([first, *places, *self.lines, "}"])

    def _block(self, statements: list[Any] | tuple[Any, ...]) -> None:
        for statement in statements:
            getattr(self, f"_do_{type(statement).__name__}")(statement)

    def _do_Evaluate(self, node: nodes.Evaluate) -> None:
        self.value(node.value)

    def _do_Bind(self, node: nodes.Bind) -> None:
        self.known[node.let] = self.value(node.let.value)

    def _do_Assign(self, node: nodes.Assign) -> None:
        value = self.as_kind(self.value(node.value), node.kind)
        self.do(f"store {node.kind.llvm} {value.text}, ptr %v.{node.name}")

    def _do_Unpack(self, node: nodes.Unpack) -> None:
        self._hold(node.items, self.value(node.value))
        self._block(node.statements)

    def _hold(self, held: tuple[nodes.Typed, ...], value: Value) -> None:
        for place, item in zip(held, self.items(value), strict=True):
            if isinstance(place, nodes.Held):
                self.known[place] = item
            elif isinstance(place, nodes.Tuple) and place.constant is None:
                self._hold(place.items, item)

    def _do_Store(self, node: nodes.Store) -> None:
        value = self.value(node.value)
        self._store(node, self.pointer(self.value(node.array), self.value(node.place)), value)

    def _do_Augment(self, node: nodes.Augment) -> None:
        pointer = self.pointer(self.value(node.array), self.value(node.place))
        self.known[node.held] = self.read(node.held.kind, pointer)
        self._store(node, pointer, self.value(node.value))

    def _store(self, node: nodes.Store | nodes.Augment, pointer: str, value: Value) -> None:
        kind = kinds.element(node.array.kind, node.place.kind, self.module.width)
        self.do(f"store {kind.llvm} {self.as_kind(value, kind).text}, ptr {pointer}{ALIGNED if kind.lanes else ''}")

    def _do_If(self, node: nodes.If) -> None:
        condition = self.value(node.condition)
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

    def _do_While(self, node: nodes.While) -> None:
        head, body, after = self.label(), self.label(), self.label()
        self._jump(head)
        self.start(head)
        if node.condition.constant is None:
            self._fork(self.value(node.condition), body, after)
        else:
            self._jump(body)
        self._round(node, body, head, after)
        if node.left:
            self.start(after)

    def _round(self, node: nodes.While | nodes.For, body: str, following: str, after: str) -> None:
        """The body of a loop; it goes on with the block `following`."""
        self.start(body)
        self.loops.append((following, after))
        self._block(node.body)
        if self.open:
            self._jump(following)
        self.loops.pop()

    def _do_For(self, node: nodes.For) -> None:
        first, last = self.value(node.first), self.value(node.last)
        head, body, following, after = (self.label() for _ in range(4))
        before = self.block
        counter = f"%i{self.count}"
        self.known[node.counter] = Value(INT, counter)
        self._jump(head)
        self.start(head)
        place = len(self.lines)
        going = self.emit(BOOL, f"icmp {'slt' if node.step > 0 else 'sgt'} i64 {counter}, {last.text}")
        self._fork(going, body, after)
        self._round(node, body, following, after)
        self.start(following)
        moved = self.emit(INT, f"add nsw i64 {counter}, {node.step}")
        self._jump(head)
        self.lines.insert(place, f"  {counter} = phi i64 [ {first.text}, %{before} ], [ {moved.text}, %{following} ]")
        self.start(after)

    def _do_Break(self, node: nodes.Break) -> None:
        self._jump(self.loops[-1][1])

    def _do_Continue(self, node: nodes.Continue) -> None:
        self._jump(self.loops[-1][0])

    def _do_Return(self, node: nodes.Return) -> None:
        kind = self.function.result
        if node.value is None:
            self._end("ret void")
        else:
            value = self.value(node.value)
            self._end(f"ret {kind.llvm} {self.as_kind(value, kind).text}")
