"""The binary format of WebAssembly (its core specification, chapter 5): what is needed of it, and a growing module."""

import dataclasses
import struct
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.compiler.kinds import BOOL, ELEMENTS, FLOAT, INT, NOTHING, TABLE, Kind

HEAP = 65536  # where tables end and the memory that a page uses begins
F64, I64, I32 = 0x7C, 0x7E, 0x7F
BYTES = {FLOAT: F64, INT: I64, BOOL: I32}
FUNCTION_TYPE = 0x60
TYPES, FUNCTIONS, MEMORIES, EXPORTS, CODES, DATA = 1, 3, 5, 7, 10, 11  # numbers of sections


def unsigned(number: int) -> bytes:
    """LEB128 of a number that is not negative."""
    found = bytearray()
    while number > 127:
        found.append(number & 127 | 128)
        number >>= 7
    return bytes([*found, number])


def signed(number: int) -> bytes:
    """LEB128 of any number."""
    found = bytearray()
    while not -64 <= number < 64:
        found.append(number & 127 | 128)
        number >>= 7
    return bytes([*found, number & 127])


def vector(parts: Sequence[bytes]) -> bytes:
    """Parts behind their number."""
    return unsigned(len(parts)) + b"".join(parts)


def flattened(kind: Kind) -> list[int]:
    """Types of a value: a tuple is as many values, an array is its address."""
    if kind in (NOTHING, TABLE):
        return []
    if kind.items:
        return [each for item in kind.items for each in flattened(item)]
    return [I32 if kind in ELEMENTS else BYTES[kind]]


@dataclasses.dataclass(slots=True, eq=False)
class Local:
    """A local variable of a function; its number is given last, when it is known how often each is named."""

    type: int
    number: int = -1
    gets: int = 0
    sets: int = 0


@dataclasses.dataclass(slots=True, eq=False, frozen=True)
class Get:
    """Its value, put on the stack."""

    local: Local


@dataclasses.dataclass(slots=True, eq=False, frozen=True)
class Set:
    """The value on the stack, taken into it."""

    local: Local


@dataclasses.dataclass(slots=True, frozen=True)
class Calling:
    """A call of a function of the module, whose place in it is not known yet."""

    function: int


Instruction = bytes | Get | Set | Calling
RETURN = b"\x0f"


def body(arguments: Sequence[Local], code: Iterable[Instruction]) -> list[bytes | Calling]:
    """The locals and the code of a function. What is set and then read at once stays on the stack."""
    kept = list(code)
    for each in kept:
        if isinstance(each, Get):
            each.local.gets += 1
        elif isinstance(each, Set):
            each.local.sets += 1
    short: list[bytes | Calling | Get | Set | Local] = []
    for each in kept:
        last = short[-1] if short else None
        if isinstance(each, Get) and isinstance(last, Set) and last.local is each.local:
            short.pop()
            if each.local.gets > 1 or each.local.sets > 1:
                short.append(each.local)  # set, and left on the stack
        else:
            short.append(each)
    while short and short[-1] == RETURN:  # the end returns
        short.pop()
    named = [each if isinstance(each, Local) else each.local for each in short if isinstance(each, (Get, Set, Local))]
    own = [local for local in dict.fromkeys(named) if local.number < 0]
    groups = [[local for local in own if local.type == type_] for type_ in (F64, I64, I32)]
    for number, local in enumerate((local for group in groups for local in group), len(arguments)):
        local.number = number
    found: list[bytes | Calling] = [
        vector([unsigned(len(group)) + bytes([group[0].type]) for group in groups if group])
    ]
    for each in short:
        if isinstance(each, Get):
            found.append(b"\x20" + unsigned(each.local.number))
        elif isinstance(each, Set):
            found.append(b"\x21" + unsigned(each.local.number))
        else:
            found.append(b"\x22" + unsigned(each.number) if isinstance(each, Local) else each)
    return _joined([*found, b"\x0b"])


def _joined(parts: Iterable[bytes | Calling]) -> list[bytes | Calling]:
    """The same with neighbouring bytes as one."""
    found: list[bytes | Calling] = []
    for each in parts:
        if isinstance(each, bytes) and found and isinstance(found[-1], bytes):
            found[-1] += each
        else:
            found.append(each)
    return found


class Assembly:
    """A module as it grows: types, functions, tables and exports; nothing stands in it twice."""

    def __init__(self) -> None:
        self._types: dict[bytes, int] = {}
        self._functions: dict[tuple, int] = {}
        self._names: list[str] = []
        self._data = bytearray()
        self._places: dict[bytes, int] = {}
        self._exports: dict[str, int] = {}

    def type(self, arguments: Sequence[int], results: Sequence[int]) -> int:
        """Number of a type of functions, or of blocks that take nothing."""
        key = bytes([FUNCTION_TYPE]) + vector([bytes([each]) for each in arguments])
        key += vector([bytes([each]) for each in results])
        return self._types.setdefault(key, len(self._types))

    def function(
        self, name: str, arguments: Sequence[int], results: Sequence[int], code: Iterable[bytes | Calling]
    ) -> int:
        """Number of a function, for `Calling`; of two that are the same that of the first."""
        key = (self.type(arguments, results), *code)
        if key not in self._functions:
            self._functions[key] = len(self._functions)
            self._names.append(name)
        return self._functions[key]

    def table(self, numbers: Any) -> int:
        """Address of the numbers of a table, floats or ints."""
        flat = np.ravel(numbers)
        content = flat.astype("<f8" if flat.dtype.kind == "f" else "<i8").tobytes()
        if content not in self._places:
            self._places[content] = len(self._data)
            self._data += content
            if len(self._data) > HEAP:
                raise ValueError(f"the tables of a page take at most {HEAP} bytes")
        return self._places[content]

    def export(self, name: str, function: int) -> None:
        """Let a function be seen from outside."""
        self._exports[name] = function

    def binary(self) -> bytes:
        """The module.

        Its functions are sorted by name: those of several kernels that are alike stand where a compressor sees both.
        """
        functions = sorted(self._functions, key=lambda each: (self._names[self._functions[each]], len(each)))
        places = {self._functions[function]: place for place, function in enumerate(functions)}
        codes = [
            b"".join(each if isinstance(each, bytes) else b"\x10" + unsigned(places[each.function]) for each in code)
            for _, *code in functions
        ]
        exports = [_name("memory") + b"\x02\x00"]
        exports += [_name(name) + b"\x00" + unsigned(places[number]) for name, number in self._exports.items()]
        data = [b"\x00\x41\x00\x0b" + unsigned(len(self._data)) + bytes(self._data)] if self._data else []
        sections = {
            TYPES: list(self._types),
            FUNCTIONS: [unsigned(type_) for type_, *_ in functions],
            MEMORIES: [b"\x00" + unsigned(1)],
            EXPORTS: exports,
            CODES: [_sized(code) for code in codes],
            DATA: data,
        }
        parts = [bytes([number]) + _sized(vector(each)) for number, each in sections.items() if each]
        return b"\x00asm\x01\x00\x00\x00" + b"".join(parts)


def _sized(content: bytes) -> bytes:
    return unsigned(len(content)) + content


def _name(text: str) -> bytes:
    return _sized(text.encode())


def float_constant(number: float) -> bytes:
    """The instruction that puts a float on the stack."""
    return b"\x44" + struct.pack("<d", number)
