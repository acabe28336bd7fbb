"""A system's equations, recorded: from scalar physics to the graph that the numerics compile.

The equations of a system whose drive has corners are recorded with the coefficients of one segment as numbers, behind
the parameters of the system: (period of the drive, start of the segment, coefficients in powers of time). Which numbers
these are, at any time and for any parameters, the recorded corners tell.
"""

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.expressions.equations import (
    ContactEquations,
    ContactMechanics,
    Corners,
    DecisionRows,
    Equations,
    Load,
    Mechanics,
    MotionRow,
)
from vibrocap.numerics.expressions.graph import Expression, Graph, reachable
from vibrocap.numerics.expressions.refusals import RecordingError
from vibrocap.numerics.expressions.structure import no_series_at_rest
from vibrocap.physics.closed_loop.sampling import SampledReference
from vibrocap.physics.drives.drive import Piecewise
from vibrocap.physics.events import IMPACT, LOCATED
from vibrocap.physics.flow import Flow
from vibrocap.physics.names import numbered
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.system import System

SEGMENT_PATHS = ("segment.period", "segment.start", "segment.coefficient_")


def is_recorded(law_or_part: Any, name: str, value: Any) -> bool:
    """Whether a parameter is a number of the parameter vector; if not, its value belongs to the equations' form."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return False
    return not (name in getattr(law_or_part, "shape_parameters", ()) and value == int(value))


@functools.lru_cache(maxsize=256)
def parameter_values(system: System) -> tuple[float, ...]:
    """The parameter vector of a system, in the order of `Equations.parameter_paths`."""
    values = tuple(float(value) for _, value in _recorded_parameters(system))
    corners = equations(system).corners
    if corners is None:
        return values
    return tuple(corners.filled(np.append(values, np.zeros(2 + corners.coefficients))).tolist())


def parameters_at(system: System, time: np.ndarray) -> tuple:
    """The parameter vector of a system whose drive has corners, at times [n] since the start of its period.

    The numbers of the segment that holds are arrays [n].
    """
    values, corners = parameter_values(system), equations(system).corners
    if corners is None:
        return values
    return (*values[: corners.place], *corners.present(*corners.of_one(values), time, 0.0)[1])


def _recorded_parameters(system: System) -> list[tuple[str, Any]]:
    parameters = []
    for part, record in system.parts.items():
        for info in parameter_table(record):
            value = getattr(record, info.name)
            if is_recorded(record, info.name, value):
                parameters.append((f"{part}.{info.name}", value))
    return parameters


def form(system: System) -> tuple:
    """What systems of the same equations have in common: kinds of parts and the parameters that are not numbers."""
    result: list[tuple] = [("cyclic", system.cyclic)]
    for part, record in system.parts.items():
        fixed = tuple(
            (info.name, getattr(record, info.name))
            for info in parameter_table(record)
            if not is_recorded(record, info.name, getattr(record, info.name))
        )
        result.append((part, type(record), fixed))
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


def _check_count(system: System, function: str, values: Sequence, names: str, wanted: Sequence[str]) -> None:
    """RecordingError where a function of the machine does not give a number for each of its states or channels."""
    if len(values) != len(wanted):
        more = len(values) - len(wanted)  # what law, environment and the like add is there in both
        own = getattr(system.machine, names)
        wrong = f"should be {len(own)} numbers, one for each of {names} ({', '.join(own)}), got {len(own) + more}"
        raise RecordingError(f"{system.machine.name}: {function}: {wrong}")


@functools.lru_cache(maxsize=64)
def _equations(_form: tuple, carrier: _Unhashed) -> Equations:
    system = carrier.system
    graph = Graph()
    paths = tuple(path for path, _ in _recorded_parameters(system))
    symbols = {path: graph.node("parameter", i) for i, path in enumerate(paths)}
    recorded = System.unchecked({part: with_symbols(part, values, symbols) for part, values in system.parts.items()})
    corners = _recorded_corners(system, paths)
    if corners is not None:
        put_on_segment(recorded, graph, corners.place)
        drive: Any = system.timed_drive
        paths = (*paths, *segment_paths(drive))
    y = tuple(graph.node("state", i) for i in range(len(system.state_names)))
    sides = tuple(graph.node("side", i) for i in range(len(system.machine.contact_states)))
    flow = recorded.flow(graph.node("time"), y, sides)
    _check_count(system, "rates", flow.rates, "states", system.state_names)
    _check_count(system, "powers", flow.powers, "channels", system.channels)
    placed = recorded.placed
    expression = graph.expression
    scales = recorded.scales()
    mechanical = y[: len(placed.states)]
    observables = {
        "drive": flow.drive,
        "energy": flow.energy,
        "contact_energy": flow.contact_energy,
        "momentum": placed.momentum(graph.node("time"), mechanical),
    }
    for number in range(1, 1 + len(flow.contacts)):
        observables |= _contact_observables(flow, number)
    forces = {numbered("reaction", i + 1): flow.reaction(i) for i in range(len(flow.contacts))}
    reactions = {name: reaction for name, reaction in forces.items() if reaction is not None}
    observables |= reactions
    from_outside = expression(flow.outer_force).value != 0.0 or system.environment is not None
    if from_outside:
        observables["outer_force"] = flow.outer_force
    if system.actuator is not None:
        observables["command"] = flow.command
    if system.controller is not None:
        observables["reference"] = flow.reference
    observables |= placed.actuator(graph.node("time"), mechanical, flow.tangential)
    expressed = {name: expression(value) for name, value in observables.items()}
    return Equations(
        graph=graph,
        state_names=system.state_names,
        channels=system.channels,
        parameter_paths=paths,
        rates=tuple(expression(rate) for rate in flow.rates),
        powers=tuple(expression(power) for power in flow.powers),
        scales=tuple(expression(scale) for scale in scales),
        contacts=contact_equations(system, flow, expression),
        rows=None if flow.rows is None else decision_rows(flow, expression),
        shifts=imposed_shifts(system, placed, graph, mechanical),
        cyclic_state=-1 if system.cyclic is None else system.state_names.index(system.cyclic),
        turns=turning_states(system),
        symmetry=system.symmetry,
        period=expression(recorded.drive.period),
        switches=tuple(expression(guard) for guard in flow.switches),
        law_switches=flow.law_switches,
        impact=system.channels.index(IMPACT) if IMPACT in system.channels else -1,
        loads=tuple(expression(load) for load in flow.loads),
        divisors=tuple(expression(divisor) for divisor in flow.divisors),
        bounds=tuple(expression(bound) for bound in flow.bounds),
        bound_kinds=flow.bound_kinds,
        located=tuple(LOCATED[kind] for kind in flow.bound_kinds),
        after_switch=tuple(tuple(map(expression, states)) for states in flow.after_switch),
        maybe_stiff=any(law.kind != "set-valued" for law in system.laws),
        observables=expressed,
        base=len(flow.rates),
        mechanics=recorded_mechanics(recorded, graph, mechanical, flow, sides),
        corners=corners,
        true_loads={} if system.machine.follows_load else {name: expressed[name] for name in reactions},
    )


def integrals(recording: Equations) -> dict[str, Expression]:
    """Rates of the quantities that a motion carries along, by name: works, then the impulse of friction by contact."""
    impulses = (numbered("impulse", i) for i in range(1, 1 + len(recording.contacts)))
    names = (*(f"{name}_work" for name in recording.channels), *impulses)
    return dict(zip(names, recording.integrals, strict=True))


def _contact_observables(flow: Flow, number: int) -> dict[str, Any]:
    """What is known of a contact at every instant; what it can hold only where its load may change."""
    contact = flow.contacts[number - 1]
    own = {"friction": contact.friction, "holding_force": contact.held, "contact_velocity": contact.contact.velocity}
    rates = zip(contact.contact.law.internal, contact.contact.internal_rates, strict=True)
    own |= {f"{name}_rate": rate for name, rate in rates}
    if flow.bounds and contact.contact.sticks:
        own |= {"holding_limit": contact.limit, "holding_centre": contact.middle}
    return {numbered(name, number): value for name, value in own.items()}


def put_on_segment(recorded: System, graph: Graph, place: int) -> None:
    """Let the drive of a recorded system be that of the segment whose numbers are parameters from a place on."""
    drive = recorded.timed_drive
    _, *segment = segment_paths(drive)
    start, *coefficients = (graph.node("parameter", place + 1 + k) for k in range(len(segment)))
    object.__setattr__(recorded, "drive", drive.on_segment(start, tuple(coefficients)))


def segment_paths(drive: Piecewise) -> tuple[str, ...]:
    """Names of the numbers of the present segment in the parameter vector."""
    period, start, coefficient = SEGMENT_PATHS
    return (period, start, *(f"{coefficient}{k}" for k in range(drive.degree + 1)))


def _recorded_corners(system: System, paths: tuple[str, ...]) -> Corners | None:
    """The corners of the drive, recorded in a graph of their own, as a table may have very many; None of none."""
    graph = Graph()
    symbols = {path: graph.node("parameter", i) for i, path in enumerate(paths)}
    recorded = System.unchecked({part: with_symbols(part, values, symbols) for part, values in system.parts.items()})
    drive = recorded.timed_drive
    if not isinstance(drive, Piecewise):
        return None
    sampled = isinstance(drive, SampledReference)
    segments = drive.segments(graph.node("time")) if sampled else drive.segments()
    return Corners(
        place=len(paths),
        coefficients=drive.degree + 1,
        period=graph.expression(drive.period),
        lengths=tuple(graph.expression(segment.length) for segment in segments),
        shapes=tuple(tuple(map(graph.expression, segment.coefficients)) for segment in segments),
        parts=graph.expression(drive.parts if sampled else 1.0),
    )


def with_symbols(part: str, record: Any, symbols: dict[str, Expression]) -> Any:
    """The same record with its numbers replaced by symbols."""
    copy = object.__new__(type(record))
    for info in parameter_table(record):
        value = symbols.get(f"{part}.{info.name}", getattr(record, info.name))
        object.__setattr__(copy, info.name, value)
    return copy


def contact_equations(system: System, flow: Flow, expression: Any) -> tuple[ContactEquations, ...]:
    """The recorded contacts."""
    equations_of_contacts, states = [], system.state_names
    for i, (contact, law, name) in enumerate(
        zip(flow.contacts, system.laws, system.machine.contact_states, strict=True)
    ):
        internal = (states.index(numbered(own, i + 1)) for own in law.internal if own not in law.switched)
        velocity, kind = expression(contact.contact.velocity), system.contact_kinds[i]
        if kind == "smooth" and no_series_at_rest(velocity, [expression(contact.contact.force)]):
            kind = "kinked"  # so that steps end where it passes rest
        equations_of_contacts.append(
            ContactEquations(
                friction=expression(contact.friction),
                velocity=velocity,
                state=states.index(name),
                kind=kind,
                hold=None if contact.hold is None else expression(contact.hold),
                limit=None if contact.limit is None else expression(contact.resting[-1]),
                internal=tuple(internal),
                after_reversal=tuple(map(expression, flow.after_reversal[i])),
            )
        )
    return tuple(equations_of_contacts)


def decision_rows(flow: Flow, expression: Any) -> DecisionRows:
    def tuples(values: Any) -> tuple[Expression, ...]:
        return tuple(map(expression, values))

    problem, contacts = flow.rows, [contact.contact for contact in flow.contacts]
    assert problem is not None
    return DecisionRows(
        b=tuples(problem.b),
        response=tuple(map(tuples, problem.A)),
        loads=tuples(problem.n),
        load_response=tuple(map(tuples, problem.C)),
        forces=tuples(contact.force for contact in contacts),
        pushes=tuple(tuples((contact.push, contact.push_at_rest)) for contact in contacts),
        bounds=tuple(tuples(contact.reach) if contact.sticks else None for contact in contacts),
    )


def turning_states(system: System) -> tuple[tuple[int, float], ...]:
    """(place in the state vector, period) of each coordinate that turns."""
    return tuple((system.state_names.index(name), period) for name, period in system.turns.items())


def imposed_shifts(system: System, placed: Any, graph: Graph, mechanical: tuple) -> tuple[Expression, ...]:
    """At imposed distances, the velocity of each contact where the state that all share vanishes."""
    machine = system.machine
    if not machine.imposes_distances:
        return ()
    own = list(mechanical)
    own[machine.states.index(machine.contact_states[0])] = 0.0
    time = graph.node("time")
    expressions = tuple(graph.expression(contact.velocity) for contact in placed.contacts(time, tuple(own), 0.0))
    if any(graph.nodes[i][0] == "state" for i in reachable(graph, [shift.index for shift in expressions])):
        what = f"should be functions of time, but for the state {machine.contact_states[0]} that is added to each"
        raise ValueError(f"the {machine.name}: at imposed distances the velocities of its contacts {what}")
    return expressions


def recorded_mechanics(recorded: System, graph: Graph, mechanical: tuple, flow: Flow, sides: tuple) -> Mechanics | None:
    """The rows of a system; None where a drive imposes the motion, or a command knows the friction."""
    time, machine, expression = graph.node("time"), recorded.placed, graph.expression
    machine = machine if recorded.controller is None else machine.sliding(sides)
    at = time, mechanical, flow.reference, flow.tangential
    description = machine.equations_of_motion(*at)
    if description is None:
        return None
    rows, lifts = description
    names = [machine.derived.rates[name] for name in machine.derived.order]
    solved = [
        {name: expression(rate) for name, rate in zip(machine.states, rates, strict=False)}
        for rates in (machine.rates(*at), flow.rates)
    ]
    accelerations = [tuple({row[name].index: row[name] for row in solved}.values()) for name in names]

    def left(row: tuple, acceleration: Any) -> Expression:
        force, factors, share = row
        remainder = expression(force)
        for factor, rate in factors:
            remainder = remainder - factor * expression(rate).rate()
        return remainder - share * acceleration

    contacts = []
    last = rows[len(rows) - len(lifts) :]
    for c, (contact, lift, (*_, share)) in enumerate(zip(flow.contacts, lifts, last, strict=True)):
        own, load, (held, at_rest) = contact.contact, None, contact.alone
        if lift is not None:
            moving = expression(contact.normal if flow.loads else flow.reaction(c))
            load = Load(-left(lift, 0.0), moving, None if at_rest is None else expression(at_rest))
            load = None if graph.is_constant_in_time(moving.index) else load
        contacts.append(
            ContactMechanics(
                friction=expression((1.0 - share) * (contact.sliding - own.push)),
                share=expression(own.slips),
                held=None if held is None else expression(held),
                taken=expression(contact.tangential) if held is None else None,
                load=load,
            )
        )
    motions = zip(rows, accelerations, strict=True)
    return Mechanics(tuple(MotionRow(left(row, rates[0]), rates) for row, rates in motions), tuple(contacts))
