"""A compiler for kernels: their text, in a small part of Python (`subset.py`), becomes machine code.

The text is read (`subset.py`) and its functions typed for the kinds of their arguments (`typed/`). From that tree
LLVM's language is written (`lowering.py`, `code.py`; all lanes at once: `lanes.py`), made machine code by LLVM and
called (`machine.py`), and kept on disk (`cache.py`); `compiled` does all of that. Nothing else of the package knows
LLVM. Other targets: browsers (`webassembly.py`) and C (`c/`).
"""

import functools
import hashlib
import pathlib
import threading

from vibrocap.numerics.compiler import cache
from vibrocap.numerics.compiler.kinds import FLOAT, FLOATS, INT, INTS, Kind
from vibrocap.numerics.compiler.machine import Compiled, NoObject, Target, host, object_code
from vibrocap.numerics.compiler.subset import LIBRARY, Refused
from vibrocap.progress import stage

__all__ = [
    "FLOAT",
    "FLOATS",
    "INT",
    "INTS",
    "Compiled",
    "Kind",
    "Refused",
    "Target",
    "compiled",
    "host",
    "ir",
    "is_kept",
    "key_here",
    "note",
    "noted",
    "object_code",
    "source_hash",
]

WORKING = threading.Lock()


@functools.cache
def source_hash(folder: pathlib.Path) -> str:
    """A hash of the text of all modules of a folder."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def own_source() -> str:
    """A hash of the compiler's own text: another compiler makes other code."""
    return source_hash(pathlib.Path(__file__).parent)


def ir(text: str, entry: str, target: Target | None = None) -> str:
    """A kernel in LLVM's language, to be made quickly (see `machine.py`)."""
    from vibrocap.numerics.compiler.lowering import lowered

    return lowered(text, entry, (target or host()).lanes, short=True)


def literal_ir(text: str, entry: str) -> str:
    """A kernel in LLVM's language that computes as a browser does, and plain Python with the package's functions.

    Every sum and product is rounded, none are fused; the functions of `math` are the kernel's own polynomials.
    """
    from vibrocap.numerics.compiler.lowering import lowered
    from vibrocap.numerics.compiler.subset import with_own_functions

    lowered_text = lowered(with_own_functions(text), entry, host().lanes, short=True, library=LIBRARY)
    return lowered_text.replace(" contract ", " ")


def compiled(text: str, entry: str, literal: bool = False) -> Compiled:
    """The function `entry` of a kernel, called with (floats, ints, trace, rounds), from the disk or made now.

    literal: computed as a browser does, see `literal_ir`
    Raises Refused where the text is no kernel.
    """
    with WORKING:  # a second thread finds what the first has made
        return _compiled(text, entry, literal)


def note(key: str, text: str, entry: str, literal: bool = False) -> None:
    """Note on the disk under which name a kernel is kept, for a process that knows the key alone."""
    cache.keep(key, _name(text, entry, literal).encode())


def noted(key: str) -> Compiled | None:
    """The kernel that was noted under a key; None where there is none, or its machine code is no longer on the disk."""
    name = cache.kept(key)
    with WORKING:
        return None if name is None else _linked(name.decode())


def key_here(*parts: str) -> str:
    """A key from all that decides what a kernel is, for this computer and compiler."""
    return cache.key(host().name, own_source(), *parts)


def is_kept(text: str, entry: str, literal: bool = False) -> bool:
    """Whether the machine code of a kernel is on the disk, whole or not."""
    return cache.place(_name(text, entry, literal)).exists()


def _name(text: str, entry: str, literal: bool) -> str:
    return cache.key(host().name, own_source(), entry, *(["literal"] if literal else []), text)


@functools.lru_cache(maxsize=128)
def _compiled(text: str, entry: str, literal: bool) -> Compiled:
    name = _name(text, entry, literal)
    if (program := _linked(name)) is not None:
        return program
    with cache.one_process_at_a_time(name):
        if (program := _linked(name)) is not None:  # another process has made it
            return program
        with stage("compiling"):
            code = object_code((literal_ir if literal else ir)(text, entry), host())
        cache.keep(name, code)
    return Compiled(code)


def _linked(name: str) -> Compiled | None:
    """The kernel of this name from the disk; None where there is none, or no object file for this computer."""
    code = cache.kept(name)
    try:
        return None if code is None else Compiled(code)
    except NoObject:
        return None
