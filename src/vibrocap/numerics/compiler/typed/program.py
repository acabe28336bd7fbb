"""The functions of a kernel as typed trees: one for every function and combination of kinds it is called with.

The text is read once from top to bottom. A name that turns out to be of another kind further down, as in a loop, starts
the function anew with what is known by then, until nothing changes.
"""

import ast
import hashlib
import re
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from vibrocap.numerics.compiler import kinds
from vibrocap.numerics.compiler.kinds import BOOL, ELEMENTS, FLOAT, FLOATS, INT, INTS, NOTHING, SCALARS, TABLE, Kind
from vibrocap.numerics.compiler.subset import WHOLE_POWER, Kernel, Refused, names_assigned, parsed
from vibrocap.numerics.compiler.typed import nodes
from vibrocap.numerics.compiler.typed.expressions import Expressions
from vibrocap.numerics.compiler.typed.nodes import Typed, known, named
from vibrocap.numerics.compiler.typed.values import AT_HAND, known_item

WORD = re.compile(r"\b[A-Za-z_]\w*")
NO_LIBRARY: Mapping[str, str] = MappingProxyType({})


class Program:
    """A kernel and the functions of it that are typed so far.

    width: lanes side by side, 0 where a target has none
    library: functions of the kernel that stand for those of `math`, and for `pow`
    shared: functions typed before, of kernels with this width and library; those that are the same are not typed anew
    """

    def __init__(
        self,
        kernel: Kernel,
        width: int,
        library: Mapping[str, str] = NO_LIBRARY,
        shared: dict[tuple, nodes.Function] | None = None,
    ):
        self.kernel, self.width, self.library = kernel, width, library
        self._shared = shared
        self._whole_power: nodes.Function | None = None
        self._contents: dict[str, bytes] = {}
        self._functions: dict[tuple, nodes.Function | None] = {}
        self._values: dict[str, Typed | None] = {}
        self._assigned: dict[str, tuple[set[str], set[str]]] = {}

    def entry(self, name: str, kinds: tuple[Kind, ...]) -> nodes.Function:
        """A function that is called from outside."""
        kernel = self.kernel
        if name not in kernel.functions:
            raise kernel.refusal(ast.Pass(), "", f"there is no function `{name}`")
        function = self.function(name, kinds, lambda what: kernel.refusal(ast.Pass(), name, what))
        if function.result not in (NOTHING, INT, BOOL):
            raise kernel.refusal(kernel.functions[name], name, "what is called from outside returns an int or nothing")
        return function

    def constant(self, name: str) -> Typed | None:
        """A constant of the kernel."""
        if name not in self._values:
            value = known(self.kernel.constants[name]) if name in self.kernel.constants else None
            if isinstance(value, nodes.Table):
                value.name = name
            self._values[name] = value
        return self._values[name]

    def assigned(self, name: str) -> tuple[set[str], set[str]]:
        """The names that a function assigns, see `names_assigned`."""
        if name not in self._assigned:
            self._assigned[name] = names_assigned(self.kernel.functions[name])
        return self._assigned[name]

    def function(self, name: str, kinds: tuple[Kind, ...], asked: Callable[[str], Exception]) -> nodes.Function:
        """A function of the kernel for arguments of these kinds; asked: what to raise where it is asked for."""
        key = (name, kinds)
        if key in self._functions:
            typed = self._functions[key]
            if typed is None:
                raise asked(f"`{name}` calls itself; write a loop")
            return typed
        shared = {} if self._shared is None else self._shared
        content = (name, kinds, b"" if self._shared is None else self._content(name))
        if content in shared:
            self._functions[key] = shared[content]
            return shared[content]
        self._functions[key] = None
        number = sum(before == name for before, *_ in self._functions)
        statements = Statements(self, self.kernel.functions[name], kinds)
        typed = statements.typed(name if number == 1 else f"{name}.{number}")
        self._functions[key] = shared[content] = typed
        return typed

    def whole_power(self) -> nodes.Function:
        """The function for a power that is not known; a function of the kernel may have its name."""
        if self._whole_power is None:
            self._whole_power = Program(parsed(WHOLE_POWER), 0).function("whole_power", (FLOAT, INT), Refused)
            self._whole_power.name = "whole_power.0"
        return self._whole_power

    def _content(self, name: str) -> bytes:
        """A digest of all that decides a function: its text, the constants that it names, the functions that it calls.

        Not those that its words or its names happen to be: a circle of such would leave out what is called within it.
        """
        if name not in self._contents:
            kernel, node = self.kernel, self.kernel.functions[name]
            text = "\n".join(kernel.lines[node.lineno - 1 : node.end_lineno])
            digest = hashlib.sha256(text.encode())
            self._contents[name] = b""  # what calls itself is refused when it is typed
            for word in sorted(set(WORD.findall(text)).intersection(kernel.constants)):
                value = kernel.constants[word]
                digest.update(f"{word}={getattr(value, 'tolist', lambda value=value: value)()!r}".encode())
            calls = (each.func for each in ast.walk(node) if isinstance(each, ast.Call))
            for called in sorted(
                {each.id for each in calls if isinstance(each, ast.Name)}.intersection(kernel.functions)
            ):
                digest.update(self._content(called))
            self._contents[name] = digest.digest()
        return self._contents[name]


VISITORS = {subclass: f"_do_{subclass.__name__}" for subclass in ast.stmt.__subclasses__()}


class Statements(Expressions):
    """The statements of one function; each `_do` says whether what follows can be reached, unless it always can."""

    def typed(self, name: str) -> nodes.Function:
        """The function, typed anew until no name that has been read becomes one of another kind."""
        arguments = [argument.arg for argument in self.node.args.args]
        body = self._typed(arguments)
        while self.widened:
            body = self._typed(arguments)
        pairs = tuple(zip(arguments, self.kinds, strict=True))
        return nodes.Function(name, pairs, self.variables, self.result or NOTHING, body)

    def _typed(self, arguments: list[str]) -> list[Any]:
        self.bound, self.loops, self.widened = {}, [], False
        body: list[Any] = []
        for argument, kind in zip(arguments, self.kinds, strict=True):
            value = nodes.Argument(kind, argument)
            if argument not in self._assigned:
                self.bound[argument] = value
            elif kind in ELEMENTS:
                raise self.refusal(self.node, f"the array `{argument}` cannot be given another value")
            else:
                body += self._assign(self.node, argument, value)
        if self._block(self.node.body, body):
            if self.result not in (None, NOTHING):
                raise self.refusal(self.node, "its end can be reached without a return; return a value there too")
            self.result = NOTHING
            body.append(nodes.Return(None))
        return body

    def _block(self, statements: list[ast.stmt], into: list[Any]) -> bool:
        """Type statements; whether what follows them can be reached."""
        for statement in statements:
            handler = getattr(self, VISITORS.get(type(statement), ""), None)
            if handler is None:
                raise self.refusal(
                    statement, f"no kernel has {named(statement)}; see compiler/subset.py for what it has"
                )
            if handler(statement, into) is False:
                return False
        return True

    def _inner(self, statements: list[ast.stmt]) -> tuple[list[Any], bool]:
        body: list[Any] = []
        reached = self._block(statements, body)
        return body, reached

    def _do_Pass(self, node: ast.Pass, into: list[Any]) -> None:
        """Nothing."""

    def _do_Expr(self, node: ast.Expr, into: list[Any]) -> None:
        if isinstance(node.value, ast.Constant):
            return  # a docstring
        if not isinstance(node.value, ast.Call):
            raise self.refusal(node, "a statement that is an expression calls a function; leave it out")
        into.append(nodes.Evaluate(self.call(node.value)))

    def _do_Assign(self, node: ast.Assign, into: list[Any]) -> None:
        if len(node.targets) != 1:
            raise self.refusal(node, "assign to one target at a time; write a line for each")
        into += self._put(node, node.targets[0], self.value(node.value))

    def _put(self, node: ast.AST, target: ast.expr, value: Typed) -> list[Any]:
        """Statements that give a target a value."""
        if isinstance(target, ast.Name):
            return self._assign(node, target.id, value)
        if isinstance(target, ast.Subscript):
            array, place = self.entry(target)
            return [nodes.Store(array, place, self._stored(node, array, place, value))]
        if not isinstance(target, ast.Tuple):
            raise self.refusal(node, "assign to a name, an entry of an array or a tuple of these")
        if len(value.kind.items) != len(target.elts):
            raise self.refusal(node, f"{len(target.elts)} names cannot take {value.kind.name}")
        held = tuple(self._held(value, i) for i in range(len(target.elts)))
        puts = [self._put(node, part, item) for part, item in zip(target.elts, held, strict=True)]
        return [nodes.Unpack(value, held, tuple(statement for put in puts for statement in put))]

    def _held(self, value: Typed, place: int) -> Typed:
        """An item of a tuple that is being unpacked."""
        item = known_item(value, place)
        if item is not None:
            return item
        if isinstance(value, nodes.Tuple) and isinstance(value.items[place], nodes.Tuple):
            inner = value.items[place]
            return nodes.Tuple(inner.kind, tuple(self._held(inner, i) for i in range(len(inner.kind.items))))
        return nodes.Held(value.kind.items[place])

    def _assign(self, node: ast.AST, name: str, value: Typed) -> list[Any]:
        if value.kind in (NOTHING, FLOATS, INTS, TABLE):
            raise self.refusal(node, f"`{name}` cannot stand for {value.kind.name}; use it where it is")
        if name in self._once:
            if isinstance(value, (*AT_HAND, nodes.Held, nodes.Counter)) or value.constant is not None:
                self.bound[name] = value
                return []
            self.bound[name] = let = nodes.Let(value.kind, value)
            return [nodes.Bind(let)]
        kind = value.kind
        if name in self.variables:
            both = kinds.joined(self.variables[name], kind)
            if both is None:
                before = self.variables[name].name
                raise self.refusal(node, f"`{name}` is {before} elsewhere, {kind.name} here; use two names")
            self.widened = self.widened or both is not self.variables[name]
            kind = both
        self.variables[name] = kind
        return [nodes.Assign(name, kind, self.fitting(node, value, kind))]

    def _do_AugAssign(self, node: ast.AugAssign, into: list[Any]) -> None:
        if isinstance(node.target, ast.Subscript):
            array, place = self.entry(node.target)
            held = nodes.Held(kinds.element(array.kind, place.kind, self.program.width))
            value = self.binary(node, node.op, held, self.value(node.value))
            into.append(nodes.Augment(array, place, held, self._stored(node, array, place, value)))
            return
        if not isinstance(node.target, ast.Name):
            raise self.refusal(node, "augment a name or an entry of an array")
        before = self.name(node, node.target.id)
        into += self._assign(node, node.target.id, self.binary(node, node.op, before, self.value(node.value)))

    def _stored(self, node: ast.AST, array: nodes.Argument, place: Typed, value: Typed) -> Typed:
        kind = kinds.element(array.kind, place.kind, self.program.width)
        if kind.lanes:
            return self.fitting(node, value, kind)
        if value.kind not in SCALARS or (kind is INT and value.kind not in (INT, BOOL)):
            raise self.refusal(node, f"an {array.kind.name} takes no {value.kind.name}; convert it")
        return value

    def _do_If(self, node: ast.If, into: list[Any]) -> bool:
        condition = self.condition(node.test)
        if condition.constant is not None:
            return self._block(node.body if condition.constant else node.orelse, into)
        body, reached = self._inner(node.body)
        orelse, also = self._inner(node.orelse)
        into.append(nodes.If(condition, body, orelse))
        return reached or also

    def _do_While(self, node: ast.While, into: list[Any]) -> bool:
        if node.orelse:
            raise self.refusal(node, "a loop has no else; use a bool")
        condition = self.condition(node.test)
        if condition.constant is False:
            return True
        loop = nodes.While(condition, [], condition.constant is None)
        into.append(loop)
        self.loops.append(loop)
        self._block(node.body, loop.body)
        self.loops.pop()
        return loop.left

    def _do_For(self, node: ast.For, into: list[Any]) -> bool | None:
        if node.orelse:
            raise self.refusal(node, "a loop has no else; use a bool")
        call = node.iter
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and isinstance(node.target, ast.Name)):
            raise self.refusal(node, "loop with one name over range(...)")
        if call.func.id != "range" or call.keywords or not 1 <= len(call.args) <= 3:
            raise self.refusal(node, "loop with one name over range(...)")
        bounds = [self.converted(node, self.value(argument), INT) for argument in call.args]
        first = bounds[0] if len(bounds) > 1 else nodes.Number(INT, constant=0)
        last = bounds[min(1, len(bounds) - 1)]
        step = bounds[2].constant if len(bounds) == 3 else 1
        if not step:
            raise self.refusal(node, "the step of a range is a constant other than 0; write it as one")
        if first.constant is not None and last.constant is not None and not range(first.constant, last.constant, step):
            return None
        counter = nodes.Counter(INT)
        loop = nodes.For(counter, first, last, step, self._assign(node, node.target.id, counter))
        into.append(loop)
        self.loops.append(loop)
        self._block(node.body, loop.body)
        self.loops.pop()
        return None

    def _do_Break(self, node: ast.Break, into: list[Any]) -> bool:
        self.loops[-1].left = True
        into.append(nodes.Break())
        return False

    def _do_Continue(self, node: ast.Continue, into: list[Any]) -> bool:
        into.append(nodes.Continue())
        return False

    def _do_Return(self, node: ast.Return, into: list[Any]) -> bool:
        value = None if node.value is None else self.value(node.value)
        kind = NOTHING if value is None else value.kind
        both = kind if self.result is None else kinds.joined(self.result, kind)
        if both is None or kind in (FLOATS, INTS, TABLE):
            raise self.refusal(node, f"returns {kind.name}, elsewhere {(self.result or NOTHING).name}")
        self.result = both
        into.append(nodes.Return(value))
        return False
