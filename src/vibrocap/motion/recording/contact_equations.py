"""What recorded equations say of each contact, and of all together where there are several."""

from typing import Any

from vibrocap.numerics.expressions.equations import ContactEquations, DecisionRows
from vibrocap.numerics.expressions.graph import Expression, Graph, reachable
from vibrocap.physics.flow import Flow
from vibrocap.physics.names import between_states, numbered
from vibrocap.physics.system import System


def contact_equations(system: System, flow: Flow, expression: Any) -> tuple[ContactEquations, ...]:
    """The recorded contacts."""
    found, states = [], system.state_names
    for i, (each, law, name) in enumerate(zip(flow.contacts, system.laws, system.machine.contact_states, strict=True)):
        internal = (states.index(numbered(own, i + 1)) for own in law.internal if own not in law.switched)
        found.append(
            ContactEquations(
                velocity=expression(each.contact.velocity),
                state=states.index(name),
                kind=system.contact_kinds[i],
                hold=None if each.hold is None else expression(each.hold),
                limit=None if each.limit is None else expression(each.limit),
                internal=tuple(internal),
                after_reversal=tuple(map(expression, flow.after_reversal[i])),
            )
        )
    return tuple(found)


def decision_rows(flow: Flow, expression: Any) -> DecisionRows:
    def tuples(values: Any) -> tuple[Expression, ...]:
        return tuple(map(expression, values))

    given, contacts, bounds = flow.rows, [each.contact for each in flow.contacts], []
    assert given is not None
    for each in contacts:
        both = (each.static.least, each.static.most, each.kinetic.least, each.kinetic.most) if each.sticks else None
        bounds.append(None if both is None else tuples(both))
    return DecisionRows(
        b=tuples(given.b),
        response=tuple(map(tuples, given.A)),
        loads=tuples(given.n),
        load_response=tuple(map(tuples, given.C)),
        forces=tuples(each.force for each in contacts),
        pushes=tuple(tuples((each.push, each.push_at_rest)) for each in contacts),
        bounds=tuple(bounds),
    )


def states_at_contacts(system: System) -> tuple[int, ...]:
    """The states of the laws, and the velocities of further contacts, but for those that change at events only."""
    own = (*list(dict.fromkeys(system.machine.contact_states))[1:], *system.state_names[len(system.machine.states) :])
    aside = (*system.switched, *between_states(system.parts))
    return tuple(system.state_names.index(name) for name in own if name not in aside)


def imposed_shifts(system: System, placed: Any, graph: Graph, mechanical: tuple) -> tuple[Expression, ...]:
    """At imposed distances, the velocity of each contact where the state that all share vanishes."""
    machine = system.machine
    if not machine.imposes_distances:
        return ()
    own = list(mechanical)
    own[machine.states.index(machine.contact_states[0])] = 0.0
    time = graph.node("time")
    found = tuple(graph.expression(each.velocity) for each in placed.contacts(time, tuple(own), 0.0))
    if any(graph.nodes[i][0] == "state" for i in reachable(graph, [shift.index for shift in found])):
        what = f"should be functions of time, but for the state {machine.contact_states[0]} that is added to each"
        raise ValueError(f"the {machine.name}: at imposed distances the velocities of its contacts {what}")
    return found
