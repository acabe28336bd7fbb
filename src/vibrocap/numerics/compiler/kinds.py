"""The kinds of values in a kernel.

A kind has one object, with its name in messages and what LLVM calls it; `joined` says which of two a name has that is
given both.
"""

import dataclasses
import functools
import struct
from typing import Any


@dataclasses.dataclass(frozen=True, eq=False)
class Kind:
    """A kind of value: its name in messages, its LLVM type, and how many lanes it has (0: it is one number).

    There is one object of each kind.
    """

    name: str
    llvm: str
    lanes: int = 0
    items: "tuple[Kind, ...]" = ()  # of a tuple


FLOAT, INT, BOOL = Kind("float", "double"), Kind("int", "i64"), Kind("bool", "i1")
FLOATS, INTS = Kind("array of floats", "ptr"), Kind("array of ints", "ptr")
TABLE = Kind("constant table", "ptr")
PLACES = Kind("places of all lanes", "i64")  # side by side: known by that of the first
NOTHING = Kind("nothing", "void")
SCALARS = (BOOL, INT, FLOAT)  # each fits into those behind it
ELEMENTS = {FLOATS: FLOAT, INTS: INT}


@functools.cache
def numbers(lanes: int) -> Kind:
    """A float per lane."""
    return Kind("numbers of all lanes", f"<{lanes} x double>", lanes)


@functools.cache
def choices(lanes: int) -> Kind:
    """A yes or no per lane."""
    return Kind("choices of all lanes", f"<{lanes} x i1>", lanes)


@functools.cache
def ints(lanes: int) -> Kind:
    """An int per lane."""
    return Kind("ints of all lanes", f"<{lanes} x i64>", lanes)


def element(array: Kind, place: Kind, lanes: int) -> Kind:
    """The kind of what stands at a place of an array, or at the places of all lanes."""
    return of_lanes(array, lanes) if place is PLACES else ELEMENTS[array]


def of_lanes(array: Kind, lanes: int) -> Kind:
    """The kind of what stands in an array for all lanes."""
    return ints(lanes) if array is INTS else numbers(lanes)


@functools.cache
def tuple_of(items: tuple[Kind, ...]) -> Kind:
    """A tuple, passed and returned by value."""
    name = f"({', '.join(item.name for item in items)})"
    return Kind(name, f"{{ {', '.join(item.llvm for item in items)} }}", items=items)


def joined(one: Kind, other: Kind) -> Kind | None:
    """The kind that holds values of both, or None: a number that is int here and float there is a float."""
    if one is other:
        return one
    if one in SCALARS and other in SCALARS:
        return SCALARS[max(SCALARS.index(one), SCALARS.index(other))]
    if one.lanes and one.lanes == other.lanes:
        return None
    for lanes, number in ((one, other), (other, one)):
        taken = {numbers(lanes.lanes): (INT, FLOAT), ints(lanes.lanes): (INT,)}
        if lanes.lanes and number in taken.get(lanes, ()):
            return lanes
    if one.items and len(one.items) == len(other.items):
        items = [joined(a, b) for a, b in zip(one.items, other.items, strict=True)]
        return None if None in items else tuple_of(tuple(item for item in items if item is not None))
    return None


class Value:
    """A value in a function: its kind, its text in LLVM's language, and the number it is where that is known."""

    __slots__ = ("constant", "items", "kind", "text")

    def __init__(self, kind: Kind, text: str, constant: Any = None, items: "tuple[Value, ...] | None" = None):
        self.kind, self.text, self.constant, self.items = kind, text, constant, items


def literal(number: bool | int | float) -> Value:
    """A number of the typed tree (`typed.nodes.known`) as a value."""
    if isinstance(number, bool):
        return Value(BOOL, "true" if number else "false", number)
    if isinstance(number, int):
        return Value(INT, str(number), number)
    return Value(FLOAT, float_text(number), number)


def float_text(number: float) -> str:
    """All bits of a float, as LLVM reads them."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', number))[0]:016X}"
