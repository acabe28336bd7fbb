"""WebAssembly: kernels as one module that a browser runs, with the bits of plain Python.

LLVM's own back end writes it, from a text in which nothing may be fused: sums and products have the bits of Python's.
The functions of `math` are the kernel's own polynomials, since those of a browser are its own affair; sqrt and floor
are exact everywhere. Functions and tables are named after their content, so that what several kernels have in common
stands in a module once; and LLVM puts a function in the place of a call only where the code becomes no longer by it.

LLVM's object file needs no linker: it holds one module, whose addresses begin at 0. `module_of` gives it a memory, the
first 64 KiB of it for constant tables and, from their end downwards, LLVM's stack, and says what it exports.
"""

import hashlib
from collections.abc import Iterable, Iterator, Mapping

from vibrocap.numerics.compiler.foreign import foreign_code
from vibrocap.numerics.compiler.kinds import Kind
from vibrocap.numerics.compiler.lowering import Module, entry_text
from vibrocap.numerics.compiler.machine import SMALL, Target
from vibrocap.numerics.compiler.subset import LIBRARY, parsed, uncollected, with_own_functions
from vibrocap.numerics.compiler.typed.nodes import Function
from vibrocap.numerics.compiler.typed.program import Program

# Instructions that all browsers have known since 2021.
BROWSER = Target("wasm32-unknown-unknown", "generic", "+bulk-memory,+mutable-globals,+nontrapping-fptoint,+sign-ext")
OWN_MEMORY = 1 << 16  # bytes before the page's: tables, and the stack
TYPES, IMPORTS, FUNCTIONS, MEMORIES, GLOBALS, EXPORTS, TABLE_COUNT, CODE, TABLES = 1, 2, 3, 5, 6, 7, 12, 10, 11
LINKING, SYMBOLS = b"linking", 8  # a section, and the part of it that names things
FUNCTION, DATA, SECTION, UNDEFINED, NAMED = 0, 1, 3, 0x10, 0x40  # kinds and flags of symbols
I32, MUTABLE, CONSTANT, END = b"\x7f", b"\x01", b"\x41", b"\x0b"
HEAD = b"\0asm\x01\0\0\0"


def webassembly_module(kernels: Iterable[tuple[str, Mapping[str, tuple[str, tuple[Kind, ...]]]]]) -> bytes:
    """Kernels of one motion as one WebAssembly module, which is the same for the same texts.

    kernels: text of each, and by the name of an export the function of the text and the kinds of its arguments; an
    array is an address in the module's `memory`, of which the first 64 KiB are its own, an int is one of 32 bits
    Raises Refused where a text is no kernel of one motion.
    """
    written, entries, exports = SharedModule(0), [], []
    shared: dict[tuple, Function] = {}
    with uncollected():
        for text, exported in kernels:
            program = Program(parsed(with_own_functions(text)), 0, LIBRARY, shared)
            for name, (entry, kinds) in exported.items():
                function = program.entry(entry, kinds)
                entries.append(entry_text(written.written(function), function.result, kinds, name, "i32"))
                exports.append(name)
    text = SMALL + written.text.replace(" contract ", " ") + "".join(entries)
    return module_of(foreign_code(text, BROWSER, "object", HEAD), exports)


class SharedModule(Module):
    """Several kernels in LLVM's language; what is the same in them stands there once."""

    def called(self, name: str, content: str) -> str:
        """A name made of the content, which names its callees so too."""
        return f"n{hashlib.sha256(content.encode()).hexdigest()[:20]}"

    @property
    def text(self) -> str:
        """All of it; functions of one name, which are much alike, side by side, so that a page packs them well."""
        alike: dict[str, dict[str, str]] = {}
        for function, name in self.names.items():
            alike.setdefault(function.name, {})[name] = self.bodies[name]
        return "\n".join([*self.needed, *(body for bodies in alike.values() for body in bodies.values())])


def module_of(code: bytes, exports: Iterable[str]) -> bytes:
    """An object file of LLVM's as a module that exports some of its functions and its memory."""
    parts = dict(_sections(code))
    imported = parts.get(IMPORTS, b"\0")
    if imported[0] != sum(name in imported for name in (b"__linear_memory", b"__stack_pointer")):
        raise RuntimeError(f"WebAssembly: these kernels need what a page does not have, one of {imported!r}")
    if len(parts.get(TABLES, b"")) > OWN_MEMORY // 2:
        raise RuntimeError(f"WebAssembly: tables of {len(parts[TABLES])} bytes leave too little of {OWN_MEMORY}")
    places = _functions(parts[LINKING])
    entries = [_text(name) + b"\x00" + _number(places[name]) for name in exports] + [_text("memory") + b"\x02\x00"]
    stack = I32 + MUTABLE + CONSTANT + _number(OWN_MEMORY) + END
    parts |= {MEMORIES: b"\x01\x00\x01", GLOBALS: b"\x01" + stack, EXPORTS: _number(len(entries)) + b"".join(entries)}
    order = (TYPES, FUNCTIONS, MEMORIES, GLOBALS, EXPORTS, TABLE_COUNT, CODE, TABLES)
    return HEAD + b"".join(bytes([kind]) + _number(len(parts[kind])) + parts[kind] for kind in order if kind in parts)


def _sections(code: bytes) -> Iterator[tuple[int | bytes, bytes]]:
    """(kind, or name, and content) of each section."""
    at = len(HEAD)
    while at < len(code):
        kind, (size, at) = code[at], _read(code, at + 1)
        name, start = _read_text(code, at) if kind == 0 else (kind, at)
        yield name, code[start : at + size]
        at += size


def _functions(linking: bytes) -> dict[str, int]:
    """Place of each function by its name, from the table of symbols."""
    functions, (_, at) = {}, _read(linking, 0)
    while linking[at] != SYMBOLS:
        size, at = _read(linking, at + 1)
        at += size
    count, at = _read(linking, _read(linking, at + 1)[1])
    for _ in range(count):
        kind, (flags, at) = linking[at], _read(linking, at + 1)
        if kind == DATA:
            _, at = _read_text(linking, at)
            for _ in range(0 if flags & UNDEFINED else 3):  # its segment, place in that, size
                _, at = _read(linking, at)
            continue
        place, at = _read(linking, at)
        if kind != SECTION and (not flags & UNDEFINED or flags & NAMED):
            name, at = _read_text(linking, at)
            if kind == FUNCTION:
                functions[name.decode()] = place
    return functions


def _read(code: bytes, at: int) -> tuple[int, int]:
    """(a whole number >= 0, the place behind it): seven bits a byte, the least first."""
    number, shift = 0, 0
    while code[at] & 0x80:
        number, shift, at = number | (code[at] & 0x7F) << shift, shift + 7, at + 1
    return number | code[at] << shift, at + 1


def _read_text(code: bytes, at: int) -> tuple[bytes, int]:
    size, at = _read(code, at)
    return code[at : at + size], at + size


def _number(number: int) -> bytes:
    """A whole number >= 0 of WebAssembly, with a bit that is free for a sign."""
    encoded = bytearray()
    while number > 0x3F:
        encoded.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes(encoded) + bytes([number])


def _text(text: str) -> bytes:
    return _number(len(text)) + text.encode()
