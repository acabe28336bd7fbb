"""check_part(MyLaw): whether a law, machine, drive or controller keeps its contract, clause by clause, in words."""

import dataclasses
import inspect
from collections.abc import Callable, Iterator
from typing import Any

from vibrocap.contracts.controller_clauses import CONTROLLER_CLAUSES
from vibrocap.contracts.drive_clauses import DRIVE_CLAUSES
from vibrocap.contracts.law_clauses import LAW_CLAUSES
from vibrocap.contracts.machine_clauses import MACHINE_CLAUSES
from vibrocap.contracts.samples import instances
from vibrocap.contracts.system_clauses import moves, recorded
from vibrocap.physics.catalogue import CONTRACTS, complaints, contract_of
from vibrocap.physics.controllers.controller import Controller
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.part_files import error_place

Clause = Callable[[Any], str | None]
CLAUSES: dict[type, tuple[Clause, ...]] = {
    Law: (*LAW_CLAUSES, recorded),
    Machine: (*MACHINE_CLAUSES, recorded),
    Drive: (*DRIVE_CLAUSES, recorded),
    Controller: (*CONTROLLER_CLAUSES, recorded),
}
FIRST = ("declarations", "units", "numbers", "finite")  # clauses without which the others make no sense


@dataclasses.dataclass(frozen=True)
class ClauseResult:
    """One clause of a contract: its text, whether the part keeps it, and the fault if not."""

    clause: str
    ok: bool
    wrong: str = ""


@dataclasses.dataclass(frozen=True)
class PartReport:
    """What was found of a part; as text, a line for each clause.

    name: of the part; kind: law, machine, drive or controller; clauses: results in order; notes: what is no fault, but
    should be known, such as parameters that fits and units know nothing of.
    """

    name: str
    kind: str
    clauses: tuple[ClauseResult, ...]
    notes: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether the part keeps its contract."""
        return all(clause.ok for clause in self.clauses)

    @property
    def wrong(self) -> tuple[str, ...]:
        """What is wrong, in words; empty where nothing is."""
        return tuple(clause.wrong for clause in self.clauses if not clause.ok)

    def __str__(self) -> str:
        clauses = "one clause" if len(self.wrong) == 1 else f"{len(self.wrong)} clauses"
        verdict = "keeps its contract" if self.ok else f"breaks {clauses} of its contract"
        lines = [f"The {self.kind} {self.name} {verdict}."]
        for clause in self.clauses:
            lines.append(f"  {'ok   ' if clause.ok else 'WRONG'}  {clause.clause}")
            lines += [] if clause.ok else [f"         {clause.wrong}"]
        return "\n".join([*lines, *(f"  note   {note}" for note in self.notes)])


def check_part(part: Any, *, motion: bool = True) -> PartReport:
    """Hold a law, a machine, a drive or a controller to its contract, with its defaults and with other numbers.

    part: its class, or an instance, which is then checked with its own numbers alone. motion: also let it move for a
    few periods, which compiles its equations (some seconds).
    Returns a report; raises TypeError for other objects.
    """
    cls = part if isinstance(part, type) else type(part)
    contract = contract_of(cls)
    kind = CONTRACTS[contract][0]
    name = getattr(cls, "name", None)
    faults = complaints(cls)
    first = ClauseResult("It is a record of parameters with a name and all functions", not faults, "; ".join(faults))
    name = name if isinstance(name, str) else cls.__name__
    if faults:
        return PartReport(name, kind, (first,))
    samples = instances([cls]) if isinstance(part, type) else [part]
    results, notes = [first], list(_notes(cls, kind))
    for clause in CLAUSES[contract]:
        result, goes_on = _result(clause, samples)
        results.append(result)
        if not goes_on:
            notes.append("the other clauses were not looked at; check again when this is mended")
            break
    if motion and all(result.ok for result in results):  # a motion of a part that is wrong tells nothing more
        results.append(_result(moves, samples[:1])[0])
    return PartReport(name, kind, tuple(results), tuple(notes))


def _result(clause: Clause, samples: list[Any]) -> tuple[ClauseResult, bool]:
    """The result of a clause, for the first of the samples that breaks it, and whether others can be looked at."""
    words = inspect.cleandoc(clause.__doc__ or "").splitlines()[0].rstrip(".")
    for i, part in enumerate(samples):
        goes_on = clause.__name__ not in FIRST
        try:
            wrong = clause(part)
        except Exception as error:  # whatever a part of someone's own does
            goes_on = False
            place, text = error_place(error, type(part)), f"{type(error).__name__}: {error}"
            wrong = str(error) if place and str(error).startswith(place) else f"{place}: {text}" if place else text
        if wrong is not None:
            numbers = "" if i == 0 else f" (with {_numbers(part)})"
            return ClauseResult(words, False, wrong + numbers), goes_on
    return ClauseResult(words, True), True


def _numbers(part: Any) -> str:
    values = ((info.name, getattr(part, info.name)) for info in parameter_table(part))
    return ", ".join(f"{name} {value:.4g}" for name, value in values if isinstance(value, float))


def _notes(cls: Any, kind: str) -> Iterator[str]:
    unknown = [info.name for info in parameter_table(cls) if isinstance(info.default, float) and info.dimension is None]
    if unknown:
        more = " fits start it from its default, and" if kind == "law" else ""
        yield (
            f"{', '.join(unknown)}: declares neither a role nor a unit, so{more} it cannot be converted to SI; add "
            'one, as in parameter(0.15, "mu", "friction coefficient", "level") or parameter(..., unit="N s/m")'
        )
    plain = [info.name for info in parameter_table(cls) if not info.symbol or not info.meaning]
    if plain:
        yield f"{', '.join(plain)}: has no symbol or no meaning"
    if not (cls.__doc__ or "").strip():
        yield "the class has no docstring; lists show its first line"
