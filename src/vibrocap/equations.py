"""A system's equations, recorded: from scalar physics to the graph that the numerics compile."""

import dataclasses
import functools
from typing import Any

from vibrocap.numerics.graph import Expression, Graph
from vibrocap.parameters import parameter_table
from vibrocap.system import PARTS, System


@dataclasses.dataclass(frozen=True, eq=False)
class Equations:
    """Recorded equations of all systems of one form; their numbers are in the parameter vector.

    rates: y' per state; integrals: rates of the quantities carried along (energy channels, then the impulse of
    friction); hold and limit: None where the contact cannot stick.
    """

    graph: Graph
    state_names: tuple[str, ...]
    integral_names: tuple[str, ...]
    parameter_paths: tuple[str, ...]
    rates: tuple[Expression, ...]
    integrals: tuple[Expression, ...]
    scales: tuple[Expression, ...]
    visible_speed: Expression
    contact_velocity: Expression
    contact_state: int
    cyclic_state: int
    symmetry: tuple[int, ...]  # sign of each state under the half-period symmetry
    period: Expression
    hold: Expression | None
    limit: Expression | None
    kinked: bool
    observables: dict[str, Expression]


def is_recorded(law_or_part: Any, name: str, value: Any) -> bool:
    """Whether a parameter is a number of the parameter vector; if not, its value belongs to the equations' form."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return not (name in getattr(law_or_part, "shape_parameters", ()) and value == int(value))


@functools.lru_cache(maxsize=256)
def parameter_values(system: System) -> tuple[float, ...]:
    """The parameter vector of a system, in the order of `Equations.parameter_paths`."""
    return tuple(float(value) for _, value in _recorded_parameters(system))


def _recorded_parameters(system: System) -> list[tuple[str, Any]]:
    found = []
    for part in PARTS:
        record = getattr(system, part)
        for info in parameter_table(record):
            value = getattr(record, info.name)
            if is_recorded(record, info.name, value):
                found.append((f"{part}.{info.name}", value))
    return found


def form(system: System) -> tuple:
    """What systems of the same equations have in common: kinds of parts and the parameters that are not numbers."""
    result = []
    for part in PARTS:
        record = getattr(system, part)
        fixed = tuple(
            (info.name, getattr(record, info.name))
            for info in parameter_table(record)
            if not is_recorded(record, info.name, getattr(record, info.name))
        )
        result.append((type(record), fixed))
    return tuple(result)


@functools.lru_cache(maxsize=256)
def equations(system: System) -> Equations:
    """Record the equations of a system; systems of one form share them."""
    return _equations(form(system), _Unhashed(system))


class _Unhashed:
    """Carries a system past the cache key: systems of one form are equal here."""

    def __init__(self, system: System):
        self.system = system

    def __hash__(self):
        return 0

    def __eq__(self, other):
        return True


@functools.lru_cache(maxsize=64)
def _equations(_form: tuple, carrier: _Unhashed) -> Equations:
    system = carrier.system
    graph = Graph()
    paths = tuple(path for path, _ in _recorded_parameters(system))
    symbols = {path: graph.node("parameter", i) for i, path in enumerate(paths)}
    recorded = object.__new__(System)
    for part in PARTS:
        object.__setattr__(recorded, part, _with_symbols(part, getattr(system, part), symbols))
    y = tuple(graph.node("state", i) for i in range(len(system.state_names)))
    flow = recorded.flow(graph.node("time"), y, graph.node("side"))
    expression = graph.expression
    load = recorded.machine.load()
    scales = (*recorded.machine.scales(), *recorded.friction.internal_scales(load))
    internal_rates = dict(zip(system.friction.internal, flow.rates[len(system.machine.states) :], strict=True))
    observables = {
        "friction": flow.friction,
        "holding_force": flow.holding_force,
        "contact_velocity": flow.contact_velocity,
        "drive": flow.drive,
        "energy": flow.energy,
        "contact_energy": flow.contact_energy,
        "momentum": recorded.machine.momentum(graph.node("time"), y[: len(system.machine.states)]),
        **{f"{name}_rate": rate for name, rate in internal_rates.items()},
    }
    return Equations(
        graph=graph,
        state_names=system.state_names,
        integral_names=(*system.channels, "impulse"),
        parameter_paths=paths,
        rates=tuple(expression(rate) for rate in flow.rates),
        integrals=tuple(expression(power) for power in (*flow.powers, flow.friction)),
        scales=tuple(expression(scale) for scale in scales),
        visible_speed=expression(recorded.friction.visible_speed()),
        contact_velocity=expression(flow.contact_velocity),
        contact_state=system.state_names.index(system.machine.contact_state),
        cyclic_state=system.state_names.index(system.machine.cyclic),
        symmetry=system.symmetry,
        period=expression(recorded.drive.period),
        hold=None if flow.holding_limit is None else expression(flow.holding_force),
        limit=None if flow.holding_limit is None else expression(flow.holding_limit),
        kinked=system.friction.kind == "kinked",
        observables={name: expression(value) for name, value in observables.items()},
    )


def _with_symbols(part: str, record: Any, symbols: dict[str, Expression]) -> Any:
    """The same record with its numbers replaced by symbols."""
    copy = object.__new__(type(record))
    for info in parameter_table(record):
        value = symbols.get(f"{part}.{info.name}", getattr(record, info.name))
        object.__setattr__(copy, info.name, value)
    return copy
