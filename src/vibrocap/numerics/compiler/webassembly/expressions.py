"""Expressions of the typed tree as instructions that leave their value on WebAssembly's stack."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vibrocap.numerics.compiler.kinds import BOOL, ELEMENTS, FLOAT, INT, Kind, joined
from vibrocap.numerics.compiler.typed import nodes
from vibrocap.numerics.compiler.webassembly.encoding import (
    Calling,
    Get,
    Instruction,
    Local,
    Set,
    flattened,
    float_constant,
    signed,
    unsigned,
)

if TYPE_CHECKING:
    from vibrocap.numerics.compiler.webassembly.functions import Kernel

OPERATORS = {
    FLOAT: {"Add": 0xA0, "Sub": 0xA1, "Mult": 0xA2, "Div": 0xA3},
    INT: {
        "Add": 0x7C,
        "Sub": 0x7D,
        "Mult": 0x7E,
        "BitAnd": 0x83,
        "BitOr": 0x84,
        "BitXor": 0x85,
        "LShift": 0x86,
        "RShift": 0x87,
    },
    BOOL: {"BitAnd": 0x71, "BitOr": 0x72, "BitXor": 0x73},
}
PLACES = {"Add": 0x6A, "Sub": 0x6B, "Mult": 0x6C}  # of places in memory, in 32 bits
COMPARED = {
    FLOAT: {"Eq": 0x61, "NotEq": 0x62, "Lt": 0x63, "Gt": 0x64, "LtE": 0x65, "GtE": 0x66},
    INT: {"Eq": 0x51, "NotEq": 0x52, "Lt": 0x53, "Gt": 0x55, "LtE": 0x57, "GtE": 0x59},
    BOOL: {"Eq": 0x46, "NotEq": 0x47},
}
LIBRARY = {"floor": 0x9C, "sqrt": 0x9F}
LOAD, STORE = {FLOAT: 0x2B, INT: 0x29}, {FLOAT: 0x39, INT: 0x37}
CONVERSIONS = {(BOOL, INT): b"\xad", (BOOL, FLOAT): b"\xb8", (INT, FLOAT): b"\xb9"}
NEAR = 8192  # up to which the constant part of a place stands in the instruction: arrays stand behind `HEAP`
SIMPLE = (nodes.Number, nodes.Argument, nodes.Variable, nodes.Let, nodes.Counter)
CHEAP = 6  # nodes of a condition or choice that is evaluated rather than jumped over
WORKS = ("Add", "Sub", "Mult", "Div", "BitAnd", "BitOr", "BitXor", "LShift", "RShift")
ZERO = float_constant(0.0)


class Expressions:
    """Writes the expressions of one function."""

    def __init__(self, kernel: "Kernel", function: nodes.Function):
        self.kernel, self.function = kernel, function
        self.code: list[Instruction] = []
        self.known: dict[nodes.Typed, list[Local]] = {}  # where what is evaluated once stands
        self.variables: dict[str, list[Local]] = {}
        self.arguments: dict[str, list[Local]] = {}
        self.augmented: dict[nodes.Typed, Instruction] = {}  # what loads an entry that is being augmented

    def do(self, *code: int) -> None:
        """Bytes of an instruction."""
        self.code.append(bytes(code))

    def take(self, kind: Kind) -> list[Local]:
        """Put what is on the stack into new locals."""
        locals_ = [Local(each) for each in flattened(kind)]
        self.code += map(Set, reversed(locals_))
        return locals_

    def value(self, node: nodes.Typed, kind: Kind | None = None) -> None:
        """A value, as one of a kind that can hold it."""
        if kind is None or kind is node.kind:
            getattr(self, nodes.WRITERS[type(node)])(node)
        elif isinstance(node, nodes.Number):
            self._number(node.constant, kind)
        elif isinstance(node, nodes.Tuple):
            for item, part in zip(node.items, kind.items, strict=True):
                self.value(item, part)
        else:
            self.value(node)
            self._as(node.kind, kind)

    def _as(self, before: Kind, kind: Kind) -> None:
        """What is on the stack as another kind."""
        if not kind.items:
            self.code += [CONVERSIONS[before, kind]] if before is not kind else []
            return
        places = iter(self.take(before))
        for item, part in zip(before.items, kind.items, strict=True):
            self.code += [Get(next(places)) for _ in flattened(item)]
            self._as(item, part)

    def _number(self, number: bool | int | float, kind: Kind) -> None:
        if kind is FLOAT:
            self.code.append(float_constant(float(number)))
        else:
            self.code.append((b"\x42" if kind is INT else b"\x41") + signed(int(number)))

    def _of_Number(self, node: nodes.Number) -> None:
        self._number(node.constant, node.kind)

    def _of_Argument(self, node: nodes.Argument) -> None:
        self.code += map(Get, self.arguments[node.name])

    def _of_Variable(self, node: nodes.Variable) -> None:
        self.code += map(Get, self.variables[node.name])

    def _again(self, node: nodes.Typed) -> None:
        self.code += map(Get, self.known[node])

    _of_Let = _of_Counter = _again

    def _of_Held(self, node: nodes.Held) -> None:
        if node in self.augmented:
            self.code.append(self.augmented[node])
        else:
            self._again(node)

    def _of_Shared(self, node: nodes.Shared) -> None:
        if node not in self.known:
            self.value(node.value)
            self.known[node] = self.take(node.kind)
        self._again(node)

    def _of_Tuple(self, node: nodes.Tuple) -> None:
        for item in node.items:
            self.value(item)

    def places(self, node: nodes.Typed) -> list[Local] | None:
        """Where a value stands already."""
        if isinstance(node, nodes.Argument):
            return self.arguments[node.name]
        return self.variables[node.name] if isinstance(node, nodes.Variable) else self.known.get(node)

    def _of_Item(self, node: nodes.Item) -> None:
        sizes = [len(flattened(item)) for item in node.base.kind.items]
        start = sum(sizes[: node.place])
        wanted = slice(start, start + sizes[node.place])
        places = self.places(node.base)
        if places is None:
            self.value(node.base)
            places = [Local(each) for each in flattened(node.base.kind)]
            kept = places[wanted]
            self.code += [Set(each) if each in kept else b"\x1a" for each in reversed(places)]
        self.code += map(Get, places[wanted])

    # --- memory ------------------------------------------------------------------------------------------------------

    def address(self, array: nodes.Argument, place: nodes.Typed) -> bytes:
        """Put the address of an entry on the stack; what stands beside the instruction that loads or stores it."""
        rest, constant = _split(place)
        self.value(array)
        near = 0 <= constant < NEAR
        if rest is not None:
            self._scaled(rest)
            self.do(0x6A)
        if not near:
            self.code.append(b"\x41" + signed(8 * constant) + b"\x6a")
        return b"\x03" + unsigned(8 * constant if near else 0)

    def _scaled(self, place: nodes.Typed) -> None:
        """Eight times a place."""
        self._place(place)
        self.code.append(b"\x41\x03\x74")

    def _place(self, node: nodes.Typed) -> None:
        """A place in 32 bits, in which its sums and products may be taken, too."""
        if isinstance(node, nodes.Number):
            self.code.append(b"\x41" + signed(node.constant))
        elif isinstance(node, nodes.Binary) and node.operator in PLACES:
            self._place(node.left)
            self._place(node.right)
            self.do(PLACES[node.operator])
        elif isinstance(node, nodes.Converted) and node.value.kind is BOOL:
            self.value(node.value)
        else:
            self.value(node)
            self.do(0xA7)

    def _of_Entry(self, node: nodes.Entry) -> None:
        beside = self.address(node.array, node.place)
        self.code.append(bytes([LOAD[node.kind]]) + beside)

    def _of_TableEntry(self, node: nodes.TableEntry) -> None:
        place = node.places[0]
        if len(node.places) == 2:
            width = nodes.Number(INT, constant=node.table.constant.shape[1])
            row = nodes.Binary(INT, "Mult", INT, place, width)
            place = nodes.Binary(INT, "Add", INT, row, node.places[1])
        self._of_memory(node.kind, node.table.constant, place)

    def _of_Chosen(self, node: nodes.Chosen) -> None:
        self._of_memory(node.kind, node.base.constant, node.place)

    def _of_memory(self, kind: Kind, numbers: object, place: nodes.Typed) -> None:
        self._scaled(place)
        self.code.append(bytes([LOAD[kind], 3]) + unsigned(self.kernel.assembly.table(numbers)))

    # --- operators ---------------------------------------------------------------------------------------------------

    def _of_Converted(self, node: nodes.Converted) -> None:
        self.value(node.value, node.kind)

    def _of_Truncated(self, node: nodes.Truncated) -> None:
        self.value(node.value)
        self.do(0xFC, 6)

    def _of_Viewed(self, node: nodes.Viewed) -> None:
        self.value(node.value)
        self.do(0xBD if node.kind is INT else 0xBF)

    def _of_Truth(self, node: nodes.Truth) -> None:
        self.value(node.value)
        self.code.append(b"\x50\x45" if node.value.kind is INT else ZERO + b"\x62")

    def _of_Binary(self, node: nodes.Binary) -> None:
        kind, op = node.operands, node.operator
        self.value(node.left, kind)
        self.value(node.right, kind)
        if op in OPERATORS[kind]:
            self.do(OPERATORS[kind][op])
        else:
            self.kernel.call_operator(self, "float_rest" if op == "Mod" else "float_floor_divided", kind, op)

    def _of_Power(self, node: nodes.Power) -> None:
        kind, exponent = node.kind, node.exponent.constant
        if exponent is None or abs(exponent) > 0x10000:
            self.value(node.base)
            self.value(node.exponent, INT)
            self.kernel.call_helper(self, "whole_power", (FLOAT, INT))
            return
        times, left, power = OPERATORS[kind]["Mult"], abs(exponent), None
        if exponent < 0:
            self._number(1, kind)
        if left == 0:
            self._number(1, kind)
            return
        square = self._simple(node.base)
        while left:  # in the order of all targets
            if left & 1:
                if power is None:
                    power = square
                else:
                    self.code += [Get(power), Get(square), bytes([times])]
                    (power,) = self.take(kind)
            left >>= 1
            if left:
                self.code += [Get(square), Get(square), bytes([times])]
                (square,) = self.take(kind)
        if power is not None:
            self.code.append(Get(power))
        if exponent < 0:
            self.do(0xA3)

    def _simple(self, node: nodes.Typed) -> Local:
        """A number in a local that nothing changes meanwhile."""
        places = self.places(node)
        if places is None:
            self.value(node)
            places = self.take(node.kind)
        return places[0]

    def _of_Unary(self, node: nodes.Unary) -> None:
        if node.operator == "USub" and node.kind is INT:
            self._number(0, INT)
        self.value(node.value)
        if node.operator == "Not":
            self.do(0x45)
        elif node.operator == "Invert":
            self.code.append(b"\x42\x7f\x85")
        else:
            self.do(0x7D if node.kind is INT else 0x9A)

    def _of_Compared(self, node: nodes.Compared) -> None:
        self.value(node.left, node.operands)
        self.value(node.right, node.operands)
        self.do(COMPARED[node.operands][node.operator])

    def _of_Within(self, node: nodes.Within) -> None:
        first, *rest = node.parts
        self.value(first)
        for part in rest:
            self.value(part)
            self.do(0x72)

    def _of_Junction(self, node: nodes.Junction) -> None:
        first, *rest = node.parts
        self.value(first)
        ends = 0
        for part in rest:
            if cheap(part):
                self.value(part)
                self.do(0x71 if node.all_of else 0x72)
                continue
            self.code.append(b"\x04\x7f" if node.all_of else b"\x04\x7f\x41\x01\x05")
            self.value(part)
            ends += 1
        self.code += [b"\x05\x41\x00\x0b" if node.all_of else b"\x0b"] * ends

    def _of_Choice(self, node: nodes.Choice) -> None:
        if not node.kind.items and cheap(node.one) and cheap(node.other):
            self.value(node.one, node.kind)
            self.value(node.other, node.kind)
            self.value(node.condition)
            self.do(0x1B)
            return
        self.value(node.condition)
        types = flattened(node.kind)
        one = bytes([types[0]]) if len(types) == 1 else signed(self.kernel.assembly.type((), types))
        self.code.append(b"\x04" + one)
        self.value(node.one, node.kind)
        self.do(0x05)
        self.value(node.other, node.kind)
        self.do(0x0B)

    def _of_Extreme(self, node: nodes.Extreme) -> None:
        first, *rest = node.parts
        kind = first.kind
        self.value(first)
        for part in rest:
            both = joined(kind, part.kind) or FLOAT
            self._as(kind, both)
            (one,) = self.take(both)
            self.value(part, both)
            (other,) = self.take(both)
            better = bytes([COMPARED[both][node.operator]])
            self.code += [Get(other), Get(one), Get(other), Get(one), better, b"\x1b"]
            kind = both

    def _of_Magnitude(self, node: nodes.Magnitude) -> None:
        if node.kind is FLOAT:
            self.value(node.value)
            self.do(0x99)
            return
        found = self._simple(node.value)
        self._number(0, INT)
        self.code += [Get(found), b"\x7d", Get(found), Get(found), b"\x42\x00\x53", b"\x1b"]

    def _of_Library(self, node: nodes.Library) -> None:
        self.value(node.value)
        self.do(LIBRARY[node.function])

    def _of_Call(self, node: nodes.Call) -> None:
        if self.kernel.is_written_in_place(node.function):
            self.in_place(node)
            return
        for argument in node.arguments:
            self.value(argument)
        self.code.append(Calling(self.kernel.written(node.function)))

    def in_place(self, node: nodes.Call) -> None:
        """A call as the code of what is called."""
        raise NotImplementedError


def _split(place: nodes.Typed) -> tuple[nodes.Typed | None, int]:
    """(what is not known of a place, what is)."""
    if isinstance(place, nodes.Number):
        return None, place.constant
    if isinstance(place, nodes.Binary) and place.operator in ("Add", "Sub"):
        left, one = _split(place.left)
        right, other = _split(place.right)
        sign = 1 if place.operator == "Add" else -1
        if left is None and right is None:
            return None, one + sign * other
        if right is None:
            return left, one + sign * other
        if left is None and sign > 0:
            return right, one + other
        if left is not None:
            return nodes.Binary(INT, place.operator, INT, left, right), one + sign * other
    return place, 0


def _size(node: nodes.Typed) -> int:
    """How many nodes a value has, if it can be evaluated where Python would not; else many."""
    if isinstance(node, SIMPLE):
        return 1
    parts: Sequence[nodes.Typed]
    if (isinstance(node, nodes.Binary) and node.operator in WORKS) or isinstance(node, nodes.Compared):
        parts = (node.left, node.right)
    elif isinstance(node, (nodes.Converted, nodes.Unary, nodes.Truth, nodes.Magnitude, nodes.Shared)):
        parts = (node.value,)
    elif isinstance(node, (nodes.Within, nodes.Junction)):
        parts = node.parts
    else:
        return CHEAP + 1
    return 1 + sum(map(_size, parts))


def cheap(node: nodes.Typed) -> bool:
    """Whether a value is evaluated sooner than jumped over, and may be: it reads nothing but locals."""
    return node.kind not in ELEMENTS and _size(node) <= CHEAP
