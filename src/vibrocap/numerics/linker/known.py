"""Kernels that are found without writing their text, by a digest of the equations of which they were made.

To write the series of a system takes longer than to read its machine code from the disk. The text follows from the
recorded equations, the layout of the memory and the modules of `numerics`, and from nothing else; so what they hash to
names the machine code as well as the text does, under which it is kept.
"""

import dataclasses
import functools
import hashlib
import pathlib
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from vibrocap.numerics.expressions.graph import Expression, Graph
from vibrocap.numerics.linker.link import Linked, entry_of

if TYPE_CHECKING:
    from vibrocap.numerics.compiler import Compiled

NUMERICS = pathlib.Path(__file__).parents[1]


def kernel_key(equations: Any, layout: Any, literal: bool) -> str:
    """The key of the kernel of one motion of these equations, on this computer and with this version of the code.

    literal: see `compiler.literal_ir`
    """
    from vibrocap.numerics.compiler import key_here, source_hash

    return key_here(source_hash(NUMERICS), digest(equations, layout), str(literal))


def known_kernel(key: str) -> "Compiled | None":
    """The kernel of a key from the disk; None where it has yet to be made."""
    from vibrocap.numerics.compiler import noted

    return noted(key)


def note_kernel(key: str, text: Linked, literal: bool) -> None:
    """Note that this is the kernel of a key."""
    from vibrocap.numerics.compiler import note

    note(key, text, entry_of(text), short=True, literal=literal)


def digest(*records: Any) -> str:
    """A hash of records of expressions and of their classes; not of nodes that were recorded later on the same graphs.

    A drive's corners are left out: they say how a table follows from the parameters, which is no part of a kernel.
    """
    digest = _Digest()
    told = [digest.told(record) for record in records]
    nodes = [graph.nodes[: last + 1] for graph, last in digest.graphs.values()]
    modules = [_text_hash(module) for module in sorted(digest.modules)]
    return hashlib.sha256(repr((told, nodes, modules)).encode()).hexdigest()


class _Digest:
    """What records say, in words that are the same in every process.

    graphs: each graph that they stand on, in the order met, and its last node that is needed; modules: of their classes
    """

    def __init__(self):
        self.graphs: dict[int, tuple[Graph, int]] = {}
        self.modules: set[str] = set()

    def told(self, value: Any) -> Any:
        """What a value says."""
        if isinstance(value, Expression):
            graph, last = self.graphs.get(id(value.graph), (value.graph, -1))
            self.graphs[id(value.graph)] = graph, max(last, value.index)
            return "node", list(self.graphs).index(id(graph)), value.index
        if isinstance(value, (tuple, list)):
            return [self.told(each) for each in value]
        if isinstance(value, Mapping):
            return [(name, self.told(each)) for name, each in value.items()]
        if dataclasses.is_dataclass(value):
            self.modules.add(type(value).__module__)
            fields = (field.name for field in dataclasses.fields(value) if field.name not in ("graph", "corners"))
            return type(value).__name__, [(name, self.told(getattr(value, name))) for name in fields]
        if value is None or isinstance(value, (str, bool, int, float)):
            return value
        raise TypeError(f"{type(value).__name__} has no digest")


@functools.cache
def _text_hash(module: str) -> str:
    """A hash of the text of a module: the properties of its records are made there."""
    return hashlib.sha256(pathlib.Path(str(sys.modules[module].__file__)).read_bytes()).hexdigest()
