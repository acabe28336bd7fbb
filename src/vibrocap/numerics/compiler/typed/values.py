"""Names, constants, entries and tuples of a function in the typed tree, and values that are to be of another kind."""

import ast
import functools
import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from vibrocap.numerics.compiler.kinds import BOOL, ELEMENTS, FLOAT, FLOATS, INT, PLACES, Kind, element, joined, tuple_of
from vibrocap.numerics.compiler.typed import nodes
from vibrocap.numerics.compiler.typed.nodes import Typed, known, named

if TYPE_CHECKING:
    from vibrocap.numerics.compiler.typed.program import Program

AT_HAND = (nodes.Number, nodes.Argument, nodes.Let)  # values that may be read again and again
VISITORS = {subclass: f"_of_{subclass.__name__}" for subclass in ast.expr.__subclasses__()}


class Values:
    """One function for one combination of kinds of arguments, on its way into the typed tree."""

    def __init__(self, program: "Program", node: ast.FunctionDef, kinds: tuple[Kind, ...]):
        self.program, self.node, self.kinds = program, node, kinds
        self.variables: dict[str, Kind] = {}
        self.result: Kind | None = None
        self.bound: dict[str, Typed] = {}  # names that are a value, no variable
        self.loops: list[nodes.While | nodes.For] = []
        self.widened = False  # whether a name became one of another kind after it had been read, perhaps, as the former
        self._assigned, self._once = program.assigned(node.name)

    def refusal(self, node: ast.AST, what: str) -> Exception:
        """What to raise at a place of this function."""
        return self.program.kernel.refusal(node, self.node.name, what)

    def value(self, node: ast.expr) -> Typed:
        """The value of an expression."""
        handler = getattr(self, VISITORS.get(type(node), ""), None)
        if handler is None:
            raise self.refusal(node, f"no kernel has {named(node)}; see compiler/subset.py for what it has")
        return handler(node)

    def fitting(self, node: ast.AST, value: Typed, kind: Kind) -> Typed:
        """The value, if it can become one of this kind."""
        if value.kind is kind:
            return value
        if kind.items and len(kind.items) == len(value.kind.items) and joined(value.kind, kind) is kind:
            return value
        if joined(value.kind, kind) != kind:
            raise self.refusal(node, f"{value.kind.name} where {kind.name} is needed; convert it")
        return value

    def converted(self, node: ast.AST, value: Typed, kind: Kind) -> Typed:
        """A value as one of another kind that can hold it."""
        self.fitting(node, value, kind)
        if value.kind is kind:
            return value
        if value.constant is not None and kind in (INT, FLOAT):
            return known(float(value.constant) if kind is FLOAT else int(value.constant)) or value
        return nodes.Converted(kind, value)

    def condition(self, node: ast.expr) -> Typed:
        """An expression as yes or no."""
        if isinstance(node, ast.BoolOp):  # of which only the truth is asked, so that its parts may be numbers
            parts = [functools.partial(self.condition, part) for part in node.values]
            return self.one_after_another(node, parts, isinstance(node.op, ast.And))
        value = self.value(node)
        if value.kind is BOOL:
            return value
        if value.kind not in (INT, FLOAT):
            raise self.refusal(node, f"{value.kind.name} is neither yes nor no; use bits(...) != 0 of choices")
        return nodes.Truth(BOOL, value) if value.constant is None else nodes.Number(BOOL, constant=bool(value.constant))

    def one_after_another(self, node: ast.AST, parts: list[Callable[[], Typed]], all_of: bool) -> Typed:
        """Conditions of which the next is asked only while all (or none) so far hold."""
        asked: list[Typed] = []
        for i, part in enumerate(parts):
            value = part()
            last = i == len(parts) - 1
            if value.kind is not BOOL:  # choices of lanes
                if len(parts) > 1:
                    raise self.refusal(node, "choices of lanes are joined by & and |, two at a time")
                return value
            if value.constant is not None and not last:
                if value.constant == all_of:
                    continue  # decides nothing
                last = True  # decides all
            asked.append(value)
            if last:
                break
        return asked[0] if len(asked) == 1 else nodes.Junction(BOOL, all_of, tuple(asked))

    def shared(self, value: Typed) -> Typed:
        """A value that is read at two places, evaluated once."""
        return value if isinstance(value, AT_HAND) else nodes.Shared(value.kind, value)

    def _of_Constant(self, node: ast.Constant) -> Typed:
        value = known(node.value)
        if value is None:
            raise self.refusal(node, "a constant in a kernel is a float, an int of 64 bits or a bool")
        return value

    def _of_Name(self, node: ast.Name) -> Typed:
        return self.name(node, node.id)

    def name(self, node: ast.AST, name: str) -> Typed:
        """What a name stands for."""
        if name in self.bound:
            return self.bound[name]
        if name in self.variables:
            return nodes.Variable(self.variables[name], name)
        if name in self._assigned:
            raise self.refusal(node, f"`{name}` is read where it need not have a value yet; assign it before")
        value = self.program.constant(name)
        if value is None:
            what = "cannot be used as a value" if name in self.program.kernel.constants else "is not known"
            raise self.refusal(node, f"`{name}` {what}")
        return value

    def _of_Tuple(self, node: ast.Tuple) -> Typed:
        items = tuple(self.value(item) for item in node.elts)
        return nodes.Tuple(tuple_of(tuple(item.kind for item in items)), items)

    def _of_Attribute(self, node: ast.Attribute) -> Typed:
        if isinstance(node.value, ast.Name) and node.value.id == "math" and node.attr in ("inf", "nan", "pi", "e"):
            return nodes.Number(FLOAT, constant=getattr(math, node.attr))
        raise self.refusal(node, f"no kernel has `{ast.unparse(node)}`")

    def _of_Subscript(self, node: ast.Subscript) -> Typed:
        base = self.value(node.value)
        if base.kind in ELEMENTS:
            array, place = self.entry(node)
            return nodes.Entry(element(array.kind, place.kind, self.program.width), array, place)
        if isinstance(base, nodes.Table):
            return self._of_table(node, base)
        if not base.kind.items:
            raise self.refusal(node, f"{base.kind.name} has no items")
        place = self.value(node.slice).constant
        kinds = base.kind.items
        if isinstance(place, int) and not isinstance(place, bool) and -len(kinds) <= place < len(kinds):
            place %= len(kinds)
            item = known_item(base, place)
            return item or nodes.Item(kinds[place], base, place)
        same = len(set(kinds)) == 1 and kinds[0] in (INT, FLOAT)
        if not isinstance(base, nodes.Tuple) or base.constant is None or not same:
            raise self.refusal(node, "the place of an item of a tuple is a constant within it")
        return nodes.Chosen(kinds[0], base, self._place(node.slice))

    def _of_table(self, node: ast.Subscript, base: nodes.Table) -> Typed:
        table = base.constant
        parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(parts) != table.ndim:
            raise self.refusal(node, f"a table of {table.ndim} dimensions needs as many places")
        places = tuple(self._place(part) for part in parts)
        if all(place.constant is not None for place in places):
            constant = known(table[tuple(place.constant for place in places)])
            if constant is not None:
                return constant
        return nodes.TableEntry(FLOAT if table.dtype.kind == "f" else INT, base, places)

    def _place(self, node: ast.expr) -> Typed:
        return self._whole(node, self.value(node))

    def _whole(self, node: ast.expr, place: Typed) -> Typed:
        if place.kind is not INT:
            raise self.refusal(node, f"a place in an array is an int, not {place.kind.name}")
        return place

    def entry(self, node: ast.Subscript) -> tuple[nodes.Argument, Typed]:
        """(array, place of an entry of it)."""
        array = self.value(node.value)
        if not isinstance(array, nodes.Argument) or array.kind not in ELEMENTS:
            raise self.refusal(node, f"an entry of {array.kind.name} cannot be set")
        if isinstance(node.slice, (ast.Slice, ast.Tuple)):
            raise self.refusal(node, "an array has one place at a time; write a loop")
        place = self.value(node.slice)
        if place.kind is PLACES and array.kind is FLOATS:
            return array, place
        return array, self._whole(node.slice, place)


def known_item(base: Typed, place: int) -> Typed | None:
    """An item of a tuple where it is known: a number, or of a tuple that is known as a whole."""
    while isinstance(base, nodes.Let):
        base = base.value
    if not isinstance(base, nodes.Tuple):
        return None
    item = base.items[place]
    return item if isinstance(item, nodes.Number) or base.constant is not None else None
