"""Joins a kernel's parts, the generated source of one system and modules of `kernel/`, to one text.

A recipe says of which modules, in the order in which they use each other; what none of them answers, `kernel/hook.py`
does. All names of the parts share one space, so what two parts define, or none, is refused before the text runs, and
the answer says which file it is: it would show late and elsewhere, as a wrong type or a wrong number.

The text runs as plain Python, for reading and for tests. Machine code is kept under a hash of the whole text
(`compiler/`), so that an edited law is never served by old code. To write the series of a system takes longer than to
read its machine code from the disk. The text follows from the recorded equations, the layout of the memory and the
modules of `numerics`, and from nothing else; so what they hash to, the `kernel_key`, names the machine code as well as
the text does, and a known kernel is found without writing its text.
"""

import ast
import builtins
import dataclasses
import functools
import hashlib
import importlib
import pathlib
import re
import symtable
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from types import CodeType
from typing import TYPE_CHECKING, Any

from vibrocap.numerics.expressions.graph import Expression, Graph
from vibrocap.numerics.kernel.lane import with_places
from vibrocap.numerics.kernel.memory_layout import Layout

if TYPE_CHECKING:
    from vibrocap.numerics.compiler import Compiled


@dataclasses.dataclass(frozen=True)
class Recipe:
    """Of what a kernel is made, besides generated code.

    entry: the function that is called from outside; primitives: names of `arithmetic.plain_vectors` that the compiler
    gives
    """

    entry: str
    modules: tuple[str, ...]
    primitives: tuple[str, ...] = ()


COMMON = ("arithmetic.roots", "events.transitions", "step.taylor", "step.stabilised", "step.resolved")
RECORDING, MEASURING = ("observe.record",), ("observe.accumulators", "observe.settle", "observe.window")
ALONE = ("arithmetic.one_number", "arithmetic.elementary_polynomials")
MOVING = ("events.contact", "loop.one_step")
SIMD = ("step.slow_manifold", "loop.side_by_side", "loop.simd_step")
LANE_PRIMITIVES = (
    *("align_stack", "all_lanes", "bits", "exponent", "floor", "load", "mantissa", "max", "min", "power_of_two"),
    *("square_root", "store", "where"),
)
SHOWING = ("observe.one_instant", "observe.instants")
DRIVEN = Recipe("follow", ("driven",))  # of a law under an imposed motion


def motion_recipe(layout: Layout) -> Recipe:
    """One motion, of which everything is recorded."""
    return Recipe("advance", (*ALONE, *_before(layout, RECORDING), *MOVING, "loop.one_by_one"))


def shown_motion_recipe(layout: Layout) -> Recipe:
    """One motion in a browser, where it is also looked at: entries of `observe.instants` beside `advance`."""
    own = motion_recipe(layout)
    return Recipe(own.entry, (*own.modules, *SHOWING))


def stored_motion_recipe(stiff: bool) -> Recipe:
    """A stored motion that is looked at at many instants; stiff: whether implicit steps may have made its pieces."""
    point = ("step.linear_system",) if stiff else ()
    return Recipe("look_along", (ALONE[0], "arithmetic.roots", "step.taylor", *point, *SHOWING))


def stepper_recipe(layout: Layout, held_input: bool = False) -> Recipe:
    """One motion that its caller moves on; held_input: whether the drive is an input. See `loop/stepper.py`."""
    passage = "loop.held_input" if held_input else "loop.own_drive"
    own = (
        *ALONE,
        *_before(layout, (), not held_input),
        *MOVING,
        "loop.one_by_one",
        passage,
        SHOWING[0],
        "loop.stepper",
    )
    return Recipe("take_step", own)


def ensemble_recipe(layout: Layout, loop: str) -> Recipe:
    """Many motions, of which measures are kept.

    loop: "ensemble", one by one; "simd", all lanes at once; "portable", one by one with the elementary functions of
        the package, for targets without these; "browser", the same without what takes evidence
    """
    before = (
        *_before(layout, MEASURING, side_by_side=loop == "simd"),
        *(("observe.returns",) if layout.returns else ()),
        *(("observe.evidence",) if loop != "browser" else ()),
        *(("observe.load_watch",) if layout.watched else ()),
        *(("observe.extrapolation",) if layout.extrapolates else ()),
    )
    if loop == "simd":
        modules = (*before, "arithmetic.elementary_polynomials", *MOVING, *SIMD, "loop.run_queue")
        return Recipe("advance_ensemble", modules, LANE_PRIMITIVES)
    own = ALONE[:1] if loop == "ensemble" else ALONE
    return Recipe("advance_ensemble", (*own, *before, *MOVING, "loop.one_by_one", "loop.run_queue"))


def _before(
    layout: Layout, observer: tuple[str, ...], follows_drive: bool = True, side_by_side: bool = False
) -> tuple[str, ...]:
    """The modules before those of the loop."""
    steps = ("step.explicit",)
    if layout.slow and not side_by_side:  # all bristles may be on manifolds, so that no step need be implicit
        steps = ("step.linear_system", "step.slow_manifold", "step.manifold_choice")
    elif layout.stiff and not layout.tangent:
        steps = ("step.linear_system", "step.implicit", "step.method_choice")
    return (
        *COMMON,
        *steps,
        *observer,
        *(("events.law_branches",) if layout.switches else ()),
        *(("events.decision",) if layout.several else ()),
        *(("events.corners",) if layout.corners and follows_drive else ()),
        *(("events.tangents",) if layout.tangent else ()),
    )


KNOWN = frozenset(dir(builtins)) | {"math", "np"}
HOOKS = "kernel/hook.py"


class LinkError(ValueError):
    """Parts that do not make a kernel."""


@dataclasses.dataclass(frozen=True)
class Outline:
    """What a part of a kernel defines and needs."""

    functions: Mapping[str, tuple[str, ...]]  # their arguments
    names: tuple[str, ...]  # all that is defined, functions too; a function twice if it is defined twice
    needs: Mapping[str, str]  # names that are read, and the function in which one is


@functools.lru_cache(maxsize=256)
def outline(text: str) -> Outline:
    """The outline of a text."""
    top = symtable.symtable(text, "<kernel>", "exec")
    heads = [table for table in top.get_children() if f"def {table.get_name()}(" in text]  # no comprehensions
    functions = {table.get_name(): table.get_parameters() for table in heads if isinstance(table, symtable.Function)}
    names = [table.get_name() for table in heads]
    assigned = (symbol for symbol in top.get_symbols() if symbol.is_assigned() and not symbol.is_namespace())
    names += [symbol.get_name() for symbol in assigned]
    needs: dict[str, str] = {}
    for table in _tables(top):
        for symbol in table.get_symbols():
            if symbol.is_referenced() and (table is top or symbol.is_global()):
                needs.setdefault(symbol.get_name(), table.get_name())
    return Outline(functions, tuple(names), needs)


def _tables(table: symtable.SymbolTable) -> Iterator[symtable.SymbolTable]:
    yield table
    for child in table.get_children():
        yield from _tables(child)


def check(recipe: Recipe, parts: Mapping[str, str]) -> None:
    """Raise LinkError unless these parts make the kernel of a recipe.

    parts: text by module, as in `recipe.modules`, and of other parts by what they are called
    """
    wanted = outline(kernel_source("hook")).functions
    homes = dict.fromkeys(recipe.primitives, "the compiler's primitives")
    for part, text in parts.items():
        for name in outline(text).names:
            if name in homes:
                here, before = file_of(part), homes[name]
                where = f"{here}, twice" if here == before else f"{before} and in {here}"
                raise LinkError(f"`{name}` is defined in {where}: give one of the two another name")
            homes[name] = file_of(part)
        for name, arguments in outline(text).functions.items():
            if wanted.get(name, arguments) != arguments:
                signatures, head = (f"{name}({', '.join(words)})" for words in (arguments, wanted[name]))
                raise LinkError(f"{file_of(part)}: `{signatures}` should be `{head}`, see {HOOKS}")
    for part, text in parts.items():
        for name, function in outline(text).needs.items():
            if name not in homes and name not in KNOWN:
                more = f"; it should be in one of the modules that answer {HOOKS}" if name in wanted else ""
                raise LinkError(
                    f"{file_of(part)}, in `{function}`: `{name}` is defined in no part of this kernel{more}"
                )
    if recipe.entry not in homes:
        raise LinkError(f"the entry `{recipe.entry}` is defined in no part of this kernel")


def file_of(part: str) -> str:
    """Where a part stands."""
    return part if " " in part else f"kernel/{part.replace('.', '/')}.py"


PLAIN_VECTORS = "from vibrocap.numerics.kernel.arithmetic.plain_vectors"
GENERATED = "# From the equations"  # as `compiler/subset.py` reads it
ENTRIES = ("advance", "advance_ensemble", "follow")  # the last one of a kernel is called from outside


NUMERICS = pathlib.Path(__file__).parent
KERNEL = NUMERICS / "kernel"
HEAD = re.compile(  # of a module: its docstring and its imports, which tell a reader and the type checker where to look
    r'\A"""(?:[^"]|"(?!""))*"""\n+(?:(?:import|from) [^\n(]*(?:\([^)]*\))?[^\n]*\n|\n)*'
)


@functools.cache
def kernel_source(name: str) -> str:
    """Source of a kernel module, "arithmetic.roots" for example: its file below its imports, with places."""
    path = KERNEL / f"{name.replace('.', '/')}.py"
    return module_source(path, f"numerics/kernel/{path.relative_to(KERNEL).as_posix()}")


def module_source(path: pathlib.Path, origin: str) -> str:
    """The text of a module in the language of kernels, below its imports, with places; origin: what to call it."""
    text = path.read_text(encoding="utf-8")
    return f"# From {origin}\n{with_places(HEAD.sub('', text, count=1).rstrip())}"


@functools.cache
def _answers() -> dict[str, str]:
    """The hooks that say what happens where no module defines them."""
    text = kernel_source("hook")
    heads = [node for node in ast.parse(text).body if isinstance(node, ast.FunctionDef)]
    known = [node for node in heads if not isinstance(node.body[-1], ast.Raise)]
    return {node.name: "\n".join(text.splitlines()[node.lineno - 1 : node.end_lineno]) for node in known}


@functools.cache
def _words(text: str) -> tuple[frozenset[str], frozenset[str]]:
    """(functions that a module defines, words behind which stands a bracket)."""
    return frozenset(re.findall(r"^def (\w+)", text, re.MULTILINE)), frozenset(re.findall(r"(\w+)\(", text))


def _unanswered(modules: Iterable[str]) -> str:
    """The hooks that these modules call and none of them defines."""
    defined, called = (frozenset().union(*names) for names in zip(*map(_words, modules), strict=True))
    left = [text for name, text in _answers().items() if name in called and name not in defined]
    return "\n\n\n".join([f"# From numerics/{HOOKS}", *left])


@functools.cache
def _lane_constants() -> str:
    """The numbers of `codes.py` and `memory_layout.py`."""
    modules = [importlib.import_module(f"vibrocap.numerics.kernel.{name}") for name in ("codes", "memory_layout")]
    every = {name: value for module in modules for name, value in vars(module).items()}
    numbers = {name: value for name, value in every.items() if name.isupper() and isinstance(value, (int, float))}
    return "\n".join(f"{name} = {value!r}" for name, value in numbers.items())


class Linked(str):
    """Text of a kernel as plain Python, which knows its parts.

    They are checked before it runs as plain Python or is compiled: not again where its machine code is kept, as that
    was made of the same text: the check takes nearly as long as to write it.
    """

    recipe: Recipe
    parts: Mapping[str, str]

    def check(self) -> None:
        """Raise LinkError unless its parts make the kernel of its recipe, see `check`."""
        check(self.recipe, self.parts)


def linked_source(generated: str, recipe: Recipe) -> Linked:
    """Text of a kernel as plain Python: generated code and the modules of a recipe."""
    kernel = {name: kernel_source(name) for name in recipe.modules}
    kernel["hook"] = _unanswered(kernel.values())
    head = "import math\n\nimport numpy as np\n"
    if recipe.primitives:
        head += f"{PLAIN_VECTORS} import {', '.join(recipe.primitives)}\n"
    linked = Linked("\n\n".join([head, _lane_constants(), GENERATED, generated, *kernel.values()]) + "\n")
    linked.recipe = recipe
    linked.parts = {"codes.py and memory_layout.py": _lane_constants(), "the generated code": generated, **kernel}
    return linked


def plain_kernel(text: str) -> dict[str, Any]:
    """The functions of a kernel as plain Python; a linked one is checked before."""
    if isinstance(text, Linked):
        text.check()
    names: dict[str, Any] = {}
    exec(_code(text), names)
    return names


@functools.lru_cache(maxsize=32)
def _code(text: str) -> CodeType:
    return compile(text, "<kernel>", "exec")


def entry_of(linked: str) -> str:
    """The function of a kernel that is called from outside: the last of ENTRIES that it has."""
    return next(name for name in reversed(ENTRIES) if f"\ndef {name}(" in linked)


def compiled_kernel(linked: str, literal: bool = False, entry: str = "") -> "Compiled":
    """An entry of a linked kernel as machine code, kept on disk for the next process.

    literal: computed as a browser does, see `compiler.literal_ir`; entry: by default `entry_of` it
    """
    from vibrocap.numerics.compiler import compiled, is_kept  # only here, as it imports LLVM

    entry = entry or entry_of(linked)
    if isinstance(linked, Linked) and not is_kept(linked, entry, literal):
        linked.check()
    return compiled(linked, entry, literal)


def kernel_key(*records: Any, literal: bool = False) -> str:
    """The key of the kernel of these records, on this computer and with this version of the code.

    literal: see `compiler.literal_ir`
    """
    from vibrocap.numerics.compiler import key_here, source_hash

    return key_here(source_hash(NUMERICS), digest(*records), str(literal))


def kept_kernel(text: Callable[[], Linked], *records: Any, literal: bool = False) -> "Compiled":
    """The kernel that follows from these records: from the disk, or of its text, which is written only then."""
    from vibrocap.numerics.compiler import note, noted

    key = kernel_key(*records, literal=literal)
    if (kernel := noted(key)) is None:
        linked = text()
        kernel = compiled_kernel(linked, literal)
        note(key, linked, entry_of(linked), literal)
    return kernel


def digest(*records: Any) -> str:
    """A hash of records of expressions and of their classes; not of nodes that were recorded later on the same graphs.

    A drive's corners are left out: they say how a table follows from the parameters, which is no part of a kernel.
    """
    graphs: dict[int, tuple[Graph, int]] = {}  # in the order met, each with its last node that is needed
    modules: set[str] = set()  # of the classes

    def words_of(value: Any) -> Any:
        """What a value says, in words that are the same in every process."""
        if isinstance(value, Expression):
            graph, last = graphs.get(id(value.graph), (value.graph, -1))
            graphs[id(value.graph)] = graph, max(last, value.index)
            return "node", list(graphs).index(id(graph)), value.index
        if isinstance(value, (tuple, list)):
            return [words_of(item) for item in value]
        if isinstance(value, Mapping):
            return [(name, words_of(item)) for name, item in value.items()]
        if dataclasses.is_dataclass(value):
            modules.add(type(value).__module__)
            fields = (field.name for field in dataclasses.fields(value) if field.name not in ("graph", "corners"))
            return type(value).__name__, [(name, words_of(getattr(value, name))) for name in fields]
        if value is None or isinstance(value, (str, bool, int, float)):
            return value
        raise TypeError(f"{type(value).__name__} has no digest")

    words = [words_of(record) for record in records]
    nodes = [graph.nodes[: last + 1] for graph, last in graphs.values()]
    texts = [_text_hash(module) for module in sorted(modules)]
    return hashlib.sha256(repr((words, nodes, texts)).encode()).hexdigest()


@functools.cache
def _text_hash(module: str) -> str:
    """A hash of the text of a module: the properties of its records are made there."""
    return hashlib.sha256(pathlib.Path(str(sys.modules[module].__file__)).read_bytes()).hexdigest()
