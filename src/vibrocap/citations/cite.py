"""What to cite: `cite` of a system, a case or a result, and the methods with their sources.

The methods of a simulation depend on the kinds of law, the number of contacts and the drive of the system. Those of an
analysis are the methods of the command of that name.
"""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.citations.bibliography import SOFTWARE, Reference, as_bibtex, references
from vibrocap.physics.controllers.controller import Controller
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.events import IMPACT
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.names import number_in
from vibrocap.physics.parameters import Part
from vibrocap.physics.system import PARTS, System
from vibrocap.results import Result

SIMULATION = "simulate"


@dataclasses.dataclass(frozen=True)
class Method:
    """A method of the package. name: what it is; source: as that of a part; analyses: the commands that use it.

    used: whether a simulation of a system uses it; a method of an analysis only where the analysis does.
    """

    name: str
    source: str
    analyses: tuple[str, ...] = (SIMULATION,)
    used: Callable[[System], bool] = lambda system: True


def _sticks(system: System) -> bool:
    return any(law.kind == "set-valued" for law in system.laws)


def _bounces(system: System) -> bool:
    return IMPACT in system.machine.channels


def _may_be_stiff(system: System) -> bool:
    return any(law.kind != "set-valued" for law in system.laws)


METHODS = (
    Method("Taylor series of high order and their step", "jorba2005"),
    Method("sticking as a mode with located events", "filippov1988; acary2008", used=_sticks),
    Method("enclosures of laws over a step", "moore1966"),
    Method("stabilised series for laws that decay fast", "ketcheson2012", used=_may_be_stiff),
    Method("implicit steps for stiff laws", "steinebach2023", used=_may_be_stiff),
    Method(
        "simultaneous decision of several contacts",
        "loetstedt1981; pfeiffer1996; acary2008; cottle1992; murty1974",
        used=lambda system: len(system.laws) > 1,
    ),
    Method("loads that friction changes, and their paradox", "painleve1895", used=lambda x: x.machine.follows_load),
    Method("impacts and their accumulation", "brogliato2016", used=_bounces),
    Method("crossings of an observable", "good1961", ("crossings",)),
    Method("tangents through events (saltation)", "leine2004", ("orbit", "branch", "crossing", "lyapunov")),
    Method("bifurcations of steady motions", "kuznetsov2004", ("branch", "equilibria")),
    Method("special points of branches, bracketed", "oliveira2020", ("branch",)),
    Method("grazing at rigid stops", "nordmark1991", ("branch",), used=_bounces),
    Method("fold and Hopf points of equilibria", "moore1980; griewank1983", ("equilibria",)),
    Method("Lyapunov exponents", "benettin1980; shimada1979", ("lyapunov",)),
    Method("0-1 test for chaos", "gottwald2009", ("basins",)),
    Method("global search of designs", "storn1997", ("optimise",)),
    Method("local refinement of designs (COBYQA)", "ragonneau2022", ("optimise",)),
    Method("Pareto fronts (NSGA-II)", "deb2002", ("optimise",)),
    Method("conditional value at risk", "rockafellar2000", ("optimise", "robust")),
    Method("extrapolation of settling runs (reduced rank)", "sidi2017", ("optimise", "robust", "sweep")),
    Method("Sobol indices", "saltelli2010", ("robust",)),
    Method("largest speed at a stroke", "chernousko2002", ("bound",)),
    Method("intervals that hold where errors are not alike", "white1980; mackinnon1985", ("fit",)),
    Method("adhesion beside friction", "derjaguin1934", ("fit",)),
    Method("errors that are correlated in time", "sokal1997; cochrane1949; ljung1978", ("fit",)),
    Method("rate-and-state fits with the spring of the machine", "sandu1997", ("fit",)),
    Method("comparison of laws by AIC and BIC", "akaike1974; schwarz1978", ("fit",)),
    Method("passivity of LuGre's law", "barabanov2000", ("friction",)),
    Method("slip velocities from measured positions", "savitzky1964", ("stick-slip",)),
)
ANALYSES = tuple(dict.fromkeys(x for method in METHODS for x in method.analyses if x != SIMULATION))


def methods_of(system: System | None, analyses: tuple[str, ...] = ()) -> tuple[Method, ...]:
    """The methods of a simulation of a system, and of further analyses; of these alone where there is no system."""
    if system is None:
        return tuple(method for method in METHODS if {*analyses} & {*method.analyses})
    wanted = {SIMULATION, *analyses}
    return tuple(method for method in METHODS if wanted & {*method.analyses} and method.used(system))


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
        by_key = {reference.key: reference for entry in self.entries for reference in entry.references}
        return tuple(by_key.values())

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
        return {
            entry.what: ", ".join(reference.key for reference in entry.references) or "no source"
            for entry in self.entries
        }

    def __str__(self) -> str:
        """Parts and methods with the numbers of their references, and the references below."""
        numbers = {reference.key: i for i, reference in enumerate(self.references, 1)}
        width = max(len(entry.what) for entry in self.entries)
        rows = []
        for entry in self.entries:
            cited = " ".join(f"[{numbers[reference.key]}]" for reference in entry.references)
            rows.append(f"{entry.what:<{width}}  {cited or 'no source: name it in `source` of the class'}")
        return "\n".join([*rows, "", *(f"[{i}] {reference.text}" for i, reference in enumerate(self.references, 1))])


def cite(of: Any = None, *, analyses: Sequence[str] = ()) -> Citations:
    """What to cite for a system: vibrocap, and the sources of its parts and of the methods that simulate it.

    of: a system, a case, or a result that has one (a motion, an orbit, ...); a part alone, or a fit, which has a law;
        None: vibrocap alone, and the paper from which it started
    analyses: further methods, by the name of the command: "orbit", "branch", ... (`methods.ANALYSES`); of a fit "fit"
        goes without saying
    Raises ArgumentError for an object without a system that is no part, and for an unknown analysis.
    """
    for name in analyses:
        if name not in ANALYSES:
            raise ArgumentError("analyses", f"{name!r} is none; {suggestion(name, ANALYSES)}")
    wanted = tuple(analyses)
    citations = [Citation("vibrocap", references(SOFTWARE))]
    if of is None:
        if analyses:
            raise ArgumentError("of", "should be the system or case that is analysed, got none")
        return Citations((*citations, Citation("the paper it started from", references("liu2019"))))
    law = getattr(of, "law", None)
    if isinstance(of, Part) or isinstance(law, Part):
        citations.append(_citation(law or of))
        methods = methods_of(None, wanted if law is None else ("fit", *wanted))
    else:
        system = of if isinstance(of, System) else getattr(of, "system", None)
        if not isinstance(system, System):
            text = "should be a system, a part, a case or a result that has a system or a law"
            raise ArgumentError("of", f"{text}, got {type(of).__name__}")
        for part, part_kind in system.parts.items():
            if part_kind.source or part in PARTS or number_in(part, "friction"):  # an environment has none
                citations.append(_citation(part_kind))
        methods = methods_of(system, wanted)
    citations += [Citation(method.name, references(method.source)) for method in methods]
    return Citations(tuple({entry.what: entry for entry in citations}.values()))


def _citation(part: Part) -> Citation:
    """What is cited for a part."""
    kind = next((what for contract, what in KINDS if isinstance(part, contract)), "")
    name: str = part.name  # type: ignore[attr-defined]
    return Citation(f"{kind} {name}".strip(), references(part.source, name=name))
