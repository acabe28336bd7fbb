"""The typed tree: what the functions of a kernel say, with the kind of every value; targets are written from it.

An operand need not be of the kind in which an operation is done (`operands`): a target turns it into that. What is
known from constants alone is a `Number`; branches that cannot be reached are not there. A node stands at one place of
the tree, but for `Let`, `Counter`, `Held` and `Shared`: these are evaluated once, at the first place, and then read.
"""

import ast
import dataclasses
import typing
from typing import Any

import numpy as np

from vibrocap.numerics.compiler.kinds import BOOL, FLOAT, INT, TABLE, Kind, tuple_of


@typing.dataclass_transform(eq_default=False, field_specifiers=(dataclasses.field,))
class Node:
    """A part of the tree: its classes are dataclasses, each object equal to itself only."""

    def __init_subclass__(cls):
        dataclasses.dataclass(eq=False)(cls)


class Typed(Node):
    """A value: its kind, and what it is where that is known (a number, or a tuple or table of numbers)."""

    kind: Kind
    constant: Any = dataclasses.field(default=None, kw_only=True)


class Number(Typed):
    """A number that is known."""


class Table(Typed):
    """A constant table, by its name in the kernel."""

    name: str


class Argument(Typed):
    """An argument that is given no other value; arrays are such."""

    name: str


class Variable(Typed):
    """What a variable holds now."""

    name: str


class Let(Typed):
    """A name that is given one value, where its `Bind` stands."""

    value: Typed


class Counter(Typed):
    """The number of a round of a loop over a range."""


class Held(Typed):
    """The entry of an array that is being augmented, or an item of what is being unpacked."""


class Shared(Typed):
    """A value that stands twice in one expression."""

    value: Typed


class Tuple(Typed):
    """A tuple that is written there, or known."""

    items: tuple[Typed, ...]


class Item(Typed):
    """An item of a tuple at a known place."""

    base: Typed
    place: int


class Entry(Typed):
    """An entry of an array."""

    array: Argument
    place: Typed


class TableEntry(Typed):
    """An entry of a table: places in each of its dimensions."""

    table: Table
    places: tuple[Typed, ...]


class Chosen(Typed):
    """An item of a known tuple at a place that is not known."""

    base: Tuple
    place: Typed


class Converted(Typed):
    """A value as one of another kind that can hold it."""

    value: Typed


class Truncated(Typed):
    """The int that a float is towards zero."""

    value: Typed


class Viewed(Typed):
    """The bits of a float as an int, or those of an int as a float."""

    value: Typed


class Truth(Typed):
    """Whether a number is not 0."""

    value: Typed


class Binary(Typed):
    """left operator right: + - * / // % of ints or floats, & | ^ of bools and ints, << and >> of ints, and of lanes."""

    operator: str
    operands: Kind
    left: Typed
    right: Typed


class Power(Typed):
    """base ** exponent, an int: known, or of a float base."""

    base: Typed
    exponent: Typed


class FloatPower(Typed):
    """base ** exponent, a float, by the target's own function."""

    base: Typed
    exponent: Typed


class Unary(Typed):
    """Minus (USub), not (Not) or all bits flipped (Invert)."""

    operator: str
    value: Typed


class Compared(Typed):
    """Whether left operator right holds: of numbers, bools or lanes."""

    operator: str
    operands: Kind
    left: Typed
    right: Typed


class Within(Typed):
    """Whether any of several comparisons holds; all are asked."""

    parts: tuple[Typed, ...]


class Junction(Typed):
    """Conditions of which the next is asked only while all (or none) so far hold; at least two."""

    all_of: bool
    parts: tuple[Typed, ...]


class Choice(Typed):
    """one if condition else other, of which only one is evaluated."""

    condition: Typed
    one: Typed
    other: Typed


class Extreme(Typed):
    """The least (Lt) or greatest (Gt) of several, as Python has it: the first that no other is less or greater than.

    A NaN behind a number is passed over. Two at a time, each pair as what holds both.
    """

    operator: str
    parts: tuple[Typed, ...]


class Magnitude(Typed):
    """The value without its sign."""

    value: Typed


class Library(Typed):
    """A function of one float that a target has: floor (of which an int may be made), sqrt; others but on the CPU."""

    function: str
    value: Typed


class Call(Typed):
    """A call of a function of the kernel, for the kinds of these arguments."""

    function: "Function"
    arguments: tuple[Typed, ...]


class Primitive(Typed):
    """A call of one of the functions of lanes, which takes these kinds."""

    name: str
    arguments: tuple[Typed, ...]
    kinds: tuple[Kind, ...]


# The methods that write the code of values.
WRITERS = {subclass: f"_of_{subclass.__name__}" for subclass in Typed.__subclasses__()}


# --- statements ------------------------------------------------------------------------------------------------------


class Evaluate(Node):
    """A call of which no result is kept."""

    value: Typed


class Bind(Node):
    """A name gets its one value."""

    let: Let


class Assign(Node):
    """A variable gets a value."""

    name: str
    kind: Kind
    value: Typed


class Unpack(Node):
    """The items of a value are held, then put where the statements say, which read them."""

    value: Typed
    items: tuple[Typed, ...]
    statements: tuple[Any, ...]


class Store(Node):
    """An entry of an array gets a value, which is evaluated before the place is."""

    array: Argument
    place: Typed
    value: Typed


class Augment(Node):
    """An entry of an array gets a value that may be made of what it `held`; the place is evaluated first."""

    array: Argument
    place: Typed
    held: Held
    value: Typed


class If(Node):
    """A condition that is not known, and two blocks."""

    condition: Typed
    body: list[Any]
    orelse: list[Any]


class While(Node):
    """A loop; left: whether what follows it can be reached."""

    condition: Typed
    body: list[Any]
    left: bool


class For(Node):
    """A loop over range(first, last, step); the body begins with what gives the loop's name its value."""

    counter: Counter
    first: Typed
    last: Typed
    step: int
    body: list[Any]
    left: bool = True


class Break(Node):
    """Out of the innermost loop."""


class Continue(Node):
    """On to the next round of the innermost loop."""


class Return(Node):
    """The function ends, with a value unless it returns nothing."""

    value: Typed | None


class Function(Node):
    """A function for one combination of kinds of arguments.

    name: unlike that of any other of the kernel; variables: their kinds
    """

    name: str
    arguments: tuple[tuple[str, Kind], ...]
    variables: dict[str, Kind]
    result: Kind
    body: list[Any]


# --- what is known ---------------------------------------------------------------------------------------------------


def known(number: Any) -> Typed | None:
    """A Python constant in the tree; None where a kernel has no such."""
    if isinstance(number, (bool, np.bool_)):
        return Number(BOOL, constant=bool(number))
    if isinstance(number, (int, np.integer)):
        return Number(INT, constant=int(number)) if -(2**63) <= number < 2**63 else None
    if isinstance(number, (float, np.floating)):
        return Number(FLOAT, constant=float(number))
    if isinstance(number, tuple):
        items = [known(item) for item in number]
        if None in items:
            return None
        items_known = tuple(item for item in items if item is not None)
        return Tuple(tuple_of(tuple(item.kind for item in items_known)), items_known, constant=number)
    if isinstance(number, np.ndarray) and number.ndim in (1, 2) and number.dtype.kind in "fi" and number.size:
        return Table(TABLE, "", constant=number)
    return None


def named(node: ast.AST) -> str:
    """What a construct is called."""
    return f"`{type(node).__name__}`"
