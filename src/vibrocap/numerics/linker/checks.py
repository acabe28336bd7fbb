"""What is checked before a kernel's parts are joined, as all their names share one space.

A name that two parts define, or none, would show late and elsewhere, as a wrong type or a wrong number; here the answer
says which file.
"""

import builtins
import dataclasses
import functools
import symtable
from collections.abc import Iterator, Mapping

from vibrocap.numerics.linker.recipes import Recipe, Slot

KNOWN = frozenset(dir(builtins)) | {"math", "np"}
INTERFACE = "kernel/interface.py"


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
    heads = [table for table in top.get_children() if isinstance(table, symtable.Function)]
    functions = {table.get_name(): table.get_parameters() for table in heads if not table.get_name().startswith("<")}
    names = [table.get_name() for table in heads if table.get_name() in functions]
    names += [each.get_name() for each in top.get_symbols() if each.is_assigned() and not each.is_namespace()]
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


def check(recipe: Recipe, parts: Mapping[str, str], interface: str) -> None:
    """Raise LinkError unless these parts make the kernel of a recipe.

    parts: text by module, as in `recipe.modules`, and of other parts by what they are called
    interface: the text of `kernel/interface.py`
    """
    for slot in recipe.slots:
        check_slot(slot, [module for module in recipe.modules if module in slot.offers], parts, interface)
    homes = dict.fromkeys(recipe.primitives, "the compiler's primitives")
    for part, text in parts.items():
        for name in outline(text).names:
            if name in homes:
                here, before = file_of(part), homes[name]
                where = f"{here}, twice" if here == before else f"{before} and in {here}"
                raise LinkError(f"`{name}` is defined in {where}: give one of the two another name")
            homes[name] = file_of(part)
    for part, text in parts.items():
        for name, function in outline(text).needs.items():
            if name not in homes and name not in KNOWN:
                raise LinkError(f"{file_of(part)}, in `{function}`: `{name}` is defined in no part of this kernel")
    if recipe.entry not in homes:
        raise LinkError(f"the entry `{recipe.entry}` is defined in no part of this kernel")


def check_slot(slot: Slot, modules: list[str], parts: Mapping[str, str], interface: str) -> None:
    """Raise LinkError unless one module fills a slot, by the functions of its interface."""
    if len(modules) != 1:
        found = " and by ".join(map(file_of, modules)) or "no module"
        raise LinkError(f"the slot `{slot.name}` is filled by {found}; one of {', '.join(slot.offers)} should fill it")
    wanted, given = outline(interface).functions, outline(parts[modules[0]]).functions
    for name in slot.functions:
        head = f"{name}({', '.join(wanted[name])})"
        if name not in given:
            raise LinkError(f"{file_of(modules[0])} fills the slot `{slot.name}` without `{head}`, see {INTERFACE}")
        if given[name] != wanted[name]:
            found = f"{name}({', '.join(given[name])})"
            raise LinkError(f"{file_of(modules[0])}: `{found}` should be `{head}`, see {INTERFACE}")


def file_of(part: str) -> str:
    """Where a part stands."""
    return part if " " in part else f"kernel/{part.replace('.', '/')}.py"
