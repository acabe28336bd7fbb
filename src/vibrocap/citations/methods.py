"""The methods by which motions are computed and analysed, with their sources.

Those of a simulation depend on the system: on the kind of its laws, on how many contacts and which drive it has. Those
of an analysis are the methods of the command of that name.
"""

import dataclasses
from collections.abc import Callable

from vibrocap.physics.machines.machine import IMPACT
from vibrocap.physics.system import System

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


def _may_be_stiff(system: System) -> bool:
    return any(law.kind != "set-valued" for law in system.laws)


def _bounces(system: System) -> bool:
    return IMPACT in system.machine.channels


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
    Method(
        "loads that friction changes, and their paradox",
        "painleve1895",
        used=lambda system: system.machine.follows_load,
    ),
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
    Method("errors that are correlated in time", "sokal1997; cochrane1949; ljung1978", ("fit",)),
    Method("rate-and-state fits with the spring of the machine", "sandu1997", ("fit",)),
    Method("comparison of laws by AIC and BIC", "akaike1974; schwarz1978", ("fit",)),
    Method("passivity of LuGre's law", "barabanov2000", ("friction",)),
    Method("slip velocities from measured positions", "savitzky1964", ("stick-slip",)),
)
ANALYSES = tuple(
    dict.fromkeys(each for method in METHODS for each in method.analyses if each != SIMULATION)
)  # that may be asked for


def methods_of(system: System | None, analyses: tuple[str, ...] = ()) -> tuple[Method, ...]:
    """The methods of a simulation of a system, and of further analyses; of these alone where there is no system."""
    if system is None:
        return tuple(method for method in METHODS if {*analyses} & {*method.analyses})
    wanted = {SIMULATION, *analyses}
    return tuple(method for method in METHODS if wanted & {*method.analyses} and method.used(system))
