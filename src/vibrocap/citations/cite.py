"""What to cite: `cite` of a system, a case or a result, and the record that it gives."""

import dataclasses
from collections.abc import Sequence
from typing import Any

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.citations.bibliography import SOFTWARE, Reference, as_bibtex, references
from vibrocap.citations.methods import ANALYSES, methods_of
from vibrocap.physics.controllers.controller import Controller
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.numbering import number_in
from vibrocap.physics.part import Part
from vibrocap.physics.system import PARTS, System
from vibrocap.results import Result

KINDS = ((Law, "friction law"), (Machine, "machine"), (Drive, "drive"), (Controller, "controller"))


@dataclasses.dataclass(frozen=True)
class Citation:
    """What is cited for one thing. what: the thing, such as "friction law lugre"; references: none where its source
    is not recorded."""

    what: str
    references: tuple[Reference, ...]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Citations(Result):
    """What to cite for a system: `str` is the text, `bibtex` the entries of a .bib file."""

    entries: tuple[Citation, ...]

    @property
    def references(self) -> tuple[Reference, ...]:
        """The references, each once, in the order in which they occur."""
        found = {each.key: each for entry in self.entries for each in entry.references}
        return tuple(found.values())

    @property
    def bibtex(self) -> str:
        """The references as a .bib file."""
        return as_bibtex(self.references)

    @property
    def heading(self) -> str:
        """How many references."""
        return f"{len(self.references)} references"

    @property
    def facts(self) -> dict[str, str]:
        """What each part and method is cited by."""
        return {entry.what: ", ".join(each.key for each in entry.references) or "no source" for entry in self.entries}

    def __str__(self) -> str:
        """Parts and methods with the numbers of their references, and the references below."""
        numbers = {each.key: i for i, each in enumerate(self.references, 1)}
        width = max(len(entry.what) for entry in self.entries)
        rows = [f"{entry.what:<{width}}  {_numbered(entry, numbers)}" for entry in self.entries]
        return "\n".join([*rows, "", *(f"[{numbers[each.key]}] {each.text}" for each in self.references)])


def _numbered(entry: Citation, numbers: dict[str, int]) -> str:
    if not entry.references:
        return "no source: name it in `source` of the class"
    return " ".join(f"[{numbers[each.key]}]" for each in entry.references)


def cite(of: Any = None, *, analyses: Sequence[str] = ()) -> Citations:
    """What to cite for a system: vibrocap, and the sources of its parts and of the methods that simulate it.

    of: a system, a case, or a result that has one (a motion, an orbit, ...); a part alone, or a fit, which has a law;
        None: vibrocap alone, and the paper from which it started
    analyses: what else is used, by the name of the command: "orbit", "branch", ... (`methods.ANALYSES`); of a fit "fit"
        goes without saying
    Raises ArgumentError for what has no system and is no part, and for an analysis that there is not.
    """
    for name in analyses:
        if name not in ANALYSES:
            raise ArgumentError("analyses", f"{name!r} is none; {suggestion(name, ANALYSES)}")
    wanted = tuple(analyses)
    found = [Citation("vibrocap", references(SOFTWARE))]
    if of is None:
        if analyses:
            raise ArgumentError("of", "should be the system or case that is analysed, got none")
        return Citations((*found, Citation("the paper it started from", references("liu2019"))))
    law = getattr(of, "law", None)
    if isinstance(of, Part) or isinstance(law, Part):
        found.append(_citation(law or of))
        methods = methods_of(None, wanted if law is None else ("fit", *wanted))
    else:
        system = of if isinstance(of, System) else getattr(of, "system", None)
        if not isinstance(system, System):
            said = "should be a system, a part, a case or a result that has a system or a law"
            raise ArgumentError("of", f"{said}, got {type(of).__name__}")
        for part, given in system.parts.items():
            if given.source or part in PARTS or number_in(part, "friction"):  # an environment has none
                found.append(_citation(given))
        methods = methods_of(system, wanted)
    found += [Citation(method.name, references(method.source)) for method in methods]
    return Citations(tuple({entry.what: entry for entry in found}.values()))


def _citation(part: Part) -> Citation:
    """What is cited for a part."""
    kind = next((what for contract, what in KINDS if isinstance(part, contract)), "")
    name: str = part.name  # type: ignore[attr-defined]
    return Citation(f"{kind} {name}".strip(), references(part.source, name=name))
