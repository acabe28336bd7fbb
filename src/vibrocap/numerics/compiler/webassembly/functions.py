"""Functions of the typed tree in WebAssembly: statements, loops as blocks that are left by their depth, and exports."""

from typing import Any

from vibrocap.numerics.compiler.kinds import ELEMENTS, FLOAT, INT, Kind
from vibrocap.numerics.compiler.typed import nodes
from vibrocap.numerics.compiler.typed.program import Program
from vibrocap.numerics.compiler.webassembly.encoding import (
    F64,
    I32,
    I64,
    RETURN,
    Assembly,
    Calling,
    Get,
    Local,
    Set,
    body,
    flattened,
    signed,
    unsigned,
)
from vibrocap.numerics.compiler.webassembly.expressions import COMPARED, SIMPLE, STORE, Expressions

# Of ints: (x, y) on two locals, a third beside them. An int divided by 0 gives 0, and nothing traps.
_REST = b"\x20\x00\x20\x01\x81\x22\x02\x50\x45\x20\x02\x20\x01\x85\x42\x00\x53\x71"  # x rem y; whether y is added
_ZERO = b"\x01\x01\x7e\x20\x01\x50\x04\x7e\x42\x00\x05"  # if y is 0: 0, else
WHOLE_OPERATORS = {
    "Mod": b"\x01\x01\x7e\x20\x01\x50\x04\x7e\x42\x00\x05"
    + _REST
    + b"\x04\x7e\x20\x02\x20\x01\x7c\x05\x20\x02\x0b\x0b\x0b",
    "FloorDiv": b"\x01\x01\x7e\x20\x01\x50\x04\x7e\x42\x00\x05\x20\x01\x42\x7f\x51\x04\x7e\x42\x00\x20\x00\x7d\x05"
    b"\x20\x00\x20\x01\x7f" + _REST + b"\xad\x7d\x0b\x0b\x0b",
}
BLOCK, LOOP, IF, ELSE, END, BRANCH, BRANCH_IF = (
    b"\x02\x40",
    b"\x03\x40",
    b"\x04\x40",
    b"\x05",
    b"\x0b",
    b"\x0c",
    b"\x0d",
)
UNREACHABLE, DROP = b"\x00", b"\x1a"
SMALL = 30  # nodes of the tree up to which a function is written where it is called


class Kernel:
    """The functions of a kernel that are written into a module so far."""

    def __init__(self, assembly: Assembly, program: Program):
        self.assembly, self.program = assembly, program
        self._written: dict[nodes.Function, int] = {}
        self._small: dict[nodes.Function, bool] = {}

    def written(self, function: nodes.Function) -> int:
        """The number of a function, which is written when first called."""
        if function not in self._written:
            self._written[function] = Function(self, function).written()
        return self._written[function]

    def is_written_in_place(self, function: nodes.Function) -> bool:
        """Whether a function stands where it is called: browsers do not do that."""
        if function not in self._small:
            self._small[function] = _count(function.body) <= SMALL
        return self._small[function]

    def call_operator(self, code: Expressions, of_floats: str, kind: Kind, operator: str) -> None:
        """A call of what stands for // or %."""
        if kind is FLOAT:
            self.call_helper(code, of_floats, (FLOAT, FLOAT))
        else:
            number = self.assembly.function(operator, [I64, I64], [I64], [WHOLE_OPERATORS[operator]])
            code.code.append(Calling(number))

    def call_helper(self, code: Expressions, name: str, kinds: tuple[Kind, ...]) -> None:
        """A call of a function of `OPERATORS`."""
        function = self.program.function(name, kinds, ValueError)
        code.code.append(Calling(self.written(function)))

    def export(self, name: str, function: nodes.Function) -> None:
        """Let a function be seen from outside, with ints of 32 bits."""
        arguments: list[int] = []
        code: list[bytes | Calling] = [b"\x00"]
        for i, (_, kind) in enumerate(function.arguments):
            arguments.append(F64 if kind is FLOAT else I32)
            code.append(b"\x20" + unsigned(i) + (b"\xac" if kind is INT else b""))
        code.append(Calling(self.written(function)))
        results = flattened(function.result)
        code.append((b"\xa7" if results == [I64] else b"" if results else b"\x41\x00") + END)
        self.assembly.export(name, self.assembly.function("", arguments, [I32], code))


class Function(Expressions):
    """Writes the statements of one function."""

    def written(self) -> int:
        """The number of the function in the module."""
        arguments: list[Local] = []
        for name, kind in self.function.arguments:
            locals_ = [Local(each, len(arguments) + i) for i, each in enumerate(flattened(kind))]
            arguments += locals_
            self.arguments[name] = locals_
        self._begin(0, None)
        reached = self._block(self.function.body)
        if not reached and self.code[-1:] != [RETURN]:
            self.code.append(UNREACHABLE)
        types = [local.type for local in arguments]
        results, code = flattened(self.function.result), body(arguments, self.code)
        return self.kernel.assembly.function(self.function.name, types, results, code)

    def _begin(self, depth: int, end: int | None) -> None:
        """The variables have places. end: how deep the block is that a return leaves, if not the function."""
        kinds = dict(self.function.arguments)
        for name, kind in self.function.variables.items():
            own = self.arguments[name] if name in kinds and kinds[name] is kind else None
            self.variables[name] = own or [Local(each) for each in flattened(kind)]
        self.loops: list[tuple[int, int]] = []  # how deep the blocks are that break and continue leave
        self.depth, self.end = depth, end

    def in_place(self, node: nodes.Call) -> None:
        """A call as the code of what is called."""
        called = node.function
        inner = Function(self.kernel, called)
        inner.code = self.code
        given: list[Local] = []
        for (name, kind), argument in zip(called.arguments, node.arguments, strict=True):
            places = None if name in called.assigned else self.places(argument)
            if places is None:
                self.value(argument)
                places = [Local(each) for each in flattened(kind)]
                given += places
            inner.arguments[name] = places
        self.code += map(Set, reversed(given))
        results = flattened(called.result)
        returns = _returns(called.body)
        if returns == 1 and isinstance(called.body[-1], nodes.Return):
            inner._begin(self.depth, -1)
            inner._block(called.body)
            return
        kind = b"\x40" if not results else bytes(results)
        if len(results) > 1:
            kind = signed(self.kernel.assembly.type((), results))
        inner._begin(self.depth + 1, self.depth + 1)
        self.code.append(b"\x02" + kind)
        if not inner._block(called.body):
            self.code.append(UNREACHABLE)
        self.code.append(END)

    def _block(self, statements: list[Any] | tuple[Any, ...]) -> bool:
        """Write statements; whether their end is reached."""
        reached = True
        for statement in statements:
            reached = getattr(self, f"_do_{type(statement).__name__}")(statement) is not False
        return reached

    def _open(self, code: bytes) -> int:
        """A block begins; how deep it is."""
        self.code.append(code)
        self.depth += 1
        return self.depth

    def _close(self) -> None:
        self.code.append(END)
        self.depth -= 1

    def _leave(self, depth: int, code: bytes = BRANCH) -> None:
        """A jump to the end of a block, or the beginning of a loop."""
        self.code.append(code + unsigned(self.depth - depth))

    def _do_Evaluate(self, node: nodes.Evaluate) -> None:
        self.value(node.value)
        self.code += [DROP] * len(flattened(node.value.kind))

    def _do_Bind(self, node: nodes.Bind) -> None:
        self.value(node.let.value)
        self.known[node.let] = self.take(node.let.kind)

    def _do_Assign(self, node: nodes.Assign) -> None:
        places = self.variables[node.name]
        if self.places(node.value) is not places:
            self.value(node.value, node.kind)
            self.code += map(Set, reversed(places))

    def _do_Unpack(self, node: nodes.Unpack) -> None:
        self._hold(node.items, node.value)
        self._block(node.statements)

    def _hold(self, held: tuple[nodes.Typed, ...], value: nodes.Typed) -> None:
        """The items of a value where they can be read while names are given other values."""
        if isinstance(value, nodes.Tuple):
            pairs = [pair for pair in _pairs(held, value.items) if isinstance(pair[0], nodes.Held)]
            for _, item in pairs:
                self.value(item)
            for each, _ in reversed(pairs):
                self.known[each] = self.take(each.kind)
            return
        places = None if isinstance(value, nodes.Variable) else self.places(value)
        if places is None:
            self.value(value)
            places = self.take(value.kind)
        start = 0
        for each, kind in zip(held, value.kind.items, strict=True):
            size = len(flattened(kind))
            self.known[each] = places[start : start + size]
            start += size

    def _do_Store(self, node: nodes.Store) -> None:
        kind = ELEMENTS[node.array.kind]
        if _reads(node.place) and _calls(node.value):  # which may write what the place is read from
            self.value(node.value, kind)
            (value,) = self.take(kind)
            beside = self.address(node.array, node.place)
            self.code.append(Get(value))
        else:
            beside = self.address(node.array, node.place)
            self.value(node.value, kind)
        self.code.append(bytes([STORE[kind]]) + beside)

    def _do_Augment(self, node: nodes.Augment) -> None:
        kind = ELEMENTS[node.array.kind]
        beside = self.address(node.array, node.place)
        address = Local(I32)
        self.code += [Set(address), Get(address), Get(address), bytes([0x2B if kind is FLOAT else 0x29]) + beside]
        (self.known[node.held],) = [self.take(kind)]
        self.value(node.value, kind)
        self.code.append(bytes([STORE[kind]]) + beside)

    def _do_If(self, node: nodes.If) -> bool:
        self.value(node.condition)
        self._open(IF)
        reached = self._block(node.body)
        if node.orelse:
            self.code.append(ELSE)
            reached = self._block(node.orelse) or reached
        self._close()
        return reached or not node.orelse

    def _do_While(self, node: nodes.While) -> bool:
        forever = node.condition.constant is True
        left = self._open(BLOCK) if _has(node.body, nodes.Break) or not forever else 0
        begin = self._open(LOOP)
        if not forever:
            self.value(node.condition)
            self.do(0x45)
            self._leave(left, BRANCH_IF)
        self.loops.append((left, begin))
        if self._block(node.body):
            self._leave(begin)
        self.loops.pop()
        self._close()
        if left:
            self._close()
        return node.left

    def _do_For(self, node: nodes.For) -> None:
        self.value(node.first)
        (counter,) = self.known[node.counter] = self.take(INT)
        last = node.last
        if not isinstance(last, SIMPLE) or isinstance(last, nodes.Variable):
            last = nodes.Held(INT)
            self.value(node.last)
            self.known[last] = self.take(INT)
        left = self._open(BLOCK) if _has(node.body, nodes.Break) else 0
        begin = self._open(LOOP)
        self.code.append(Get(counter))
        self.value(last)
        self.do(COMPARED[INT]["Lt" if node.step > 0 else "Gt"])
        self._open(IF)
        following = self._open(BLOCK) if _has(node.body, nodes.Continue) else 0
        self.loops.append((left, following))
        self._block(node.body)
        self.loops.pop()
        if following:
            self._close()
        self.code += [Get(counter), b"\x42" + signed(node.step) + b"\x7c", Set(counter)]
        self._leave(begin)
        self._close()
        self._close()
        if left:
            self._close()

    def _do_Break(self, node: nodes.Break) -> bool:
        self._leave(self.loops[-1][0])
        return False

    def _do_Continue(self, node: nodes.Continue) -> bool:
        self._leave(self.loops[-1][1])
        return False

    def _do_Return(self, node: nodes.Return) -> bool:
        if node.value is not None:
            self.value(node.value, self.function.result)
        if self.end is None:
            self.code.append(RETURN)
        elif self.end > 0:
            self._leave(self.end)
        return False


def _pairs(held: tuple[nodes.Typed, ...], items: tuple[nodes.Typed, ...]) -> list[tuple[nodes.Typed, nodes.Typed]]:
    """What is held beside what it is to be, of tuples in tuples, too."""
    found = []
    for each, item in zip(held, items, strict=True):
        if isinstance(each, nodes.Tuple) and isinstance(item, nodes.Tuple):
            found += _pairs(each.items, item.items)
        else:
            found.append((each, item))
    return found


def _returns(statements: list[Any]) -> int:
    """How many returns there are."""
    found = 0
    for each in statements:
        if isinstance(each, nodes.If):
            found += _returns(each.body) + _returns(each.orelse)
        elif isinstance(each, (nodes.While, nodes.For)):
            found += _returns(each.body)
        else:
            found += isinstance(each, nodes.Return)
    return found


def _count(part: Any) -> int:
    """How many nodes a part of the tree has; of one with more than SMALL, only that there are more."""
    if isinstance(part, (list, tuple)):
        parts, found = part, 0
    elif isinstance(part, (nodes.Function, Kind)) or not hasattr(part, "__dataclass_fields__"):
        return 0
    elif isinstance(part, nodes.Bind):
        parts, found = (part.let.value,), 1
    elif isinstance(part, (nodes.Let, nodes.Table)):
        return 1
    else:
        parts, found = (getattr(part, name) for name in type(part).__dataclass_fields__), 1
    for each in parts:
        found += _count(each)
        if found > SMALL:
            break
    return found


def _has(statements: list[Any], kind: type) -> bool:
    """Whether a break or continue of this loop is among statements."""
    return any(
        isinstance(each, kind) or (isinstance(each, nodes.If) and (_has(each.body, kind) or _has(each.orelse, kind)))
        for each in statements
    )


def _any(node: Any, kinds: tuple[type, ...]) -> bool:
    if isinstance(node, kinds):
        return True
    if isinstance(node, (nodes.Let, nodes.Table)) or not isinstance(node, nodes.Typed):
        return False
    for name in type(node).__dataclass_fields__:
        part = getattr(node, name)
        if isinstance(part, nodes.Typed) and _any(part, kinds):
            return True
        if isinstance(part, tuple) and any(_any(each, kinds) for each in part):
            return True
    return False


def _reads(node: nodes.Typed) -> bool:
    """Whether memory is read for a value."""
    return _any(node, (nodes.Entry, nodes.Call))


def _calls(node: nodes.Typed) -> bool:
    """Whether a function is called for a value."""
    return _any(node, (nodes.Call,))
