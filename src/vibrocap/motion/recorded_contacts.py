"""What recorded equations say of contacts: whose states are whose, which rest, where further ones turn."""

from typing import Any

from vibrocap.numerics.expressions.graph import Expression, Graph, reachable
from vibrocap.physics.states import actuator_states
from vibrocap.physics.system import Flow, System


def states_at_contacts(system: System) -> list[str]:
    """The states of the laws, and the velocities of further contacts, but for those that change at events only."""
    own = (*_contact_states(system), *system.state_names[len(system.machine.states) :])
    aside = (*system.switched, *actuator_states(system.actuator))
    return [name for name in own if name not in aside]


def states_of_laws(system: System) -> list[list[str]]:
    """The states of the law of each contact, but for those that change at events only."""
    laws = enumerate(system.further_laws, start=2)
    names = [system.friction.internal, *([f"{name}_{i}" for name in law.internal] for i, law in laws)]
    return [[name for name in some if name not in system.switched] for some in names]


def _contact_states(system: System) -> list[str]:
    """The velocities of further contacts that are states."""
    return [name for name in system.machine.contacts if name in system.machine.states]


def resting(system: System) -> list[str]:
    """The velocities that are exactly zero while a further contact sticks."""
    pairs = zip(system.machine.contacts, system.further_laws, strict=True)
    states = _contact_states(system)
    return [name for name, law in pairs if law.kind == "set-valued" and name in states]


def turning(system: System, flow: Flow, expression: Any) -> dict[int, tuple[int, Expression]]:
    """Guards of further contacts that turn where their velocity vanishes, as they have a force for every velocity.

    By number: (the state that moves one to one with this velocity, the velocity).
    """
    numbers = {expression(guard).index: i for i, guard in enumerate(flow.switches)}
    found, machine = {}, system.machine
    for each, name in zip(flow.further, machine.contacts, strict=True):
        if each.turns and not each.sticks:
            state = name if name in machine.states else machine.contact_state
            number = numbers[expression(each.guards()[0]).index]
            found[number] = system.state_names.index(state), expression(each.velocity)
    return found


def recorded_holds(system: System, flow: Flow, expression: Any) -> tuple[tuple[int, Expression, Expression], ...]:
    """Of each contact that can stick: (state that is its side, force over the middle of what it can hold, its limit).

    The force is that of a contact at rest. -1: the side of the first contact is no state.
    """
    found = []
    if flow.holding_limit is not None:
        found.append((-1, expression(flow.holding_force - flow.holding_middle), expression(flow.holding_limit)))
    for each in flow.further:
        if each.sticks:
            side = system.state_names.index(f"side_{each.number}")
            found.append((side, expression(each.friction - each.middle), expression(each.limit)))
    return tuple(found)


def stopping(system: System, flow: Flow, expression: Any) -> dict[int, int]:
    """Guards under which further contacts turn or come to rest, and that would stop one that moves.

    By number: the state that moves one to one with this velocity. At imposed distances contacts that rest see to it
    themselves.
    """
    numbers = {expression(guard).index: i for i, guard in enumerate(flow.switches)}
    resting = zip(flow.further, system.machine.contacts, strict=True)
    names = {numbers[expression(each.guards()[0]).index]: name for each, name in resting if each.sticks}
    states = {i: system.state_names.index(name) for i, name in names.items() if name in system.machine.states}
    return states | {i: state for i, (state, _) in turning(system, flow, expression).items()}


def shifts(system: System, placed: Any, graph: Graph, mechanical: tuple) -> tuple[Expression, ...]:
    """At imposed distances, the velocity of each contact where the state that all share vanishes."""
    machine = system.machine
    if machine.coupled != "distances":
        return ()
    own = list(mechanical[: len(machine.states)])
    own[machine.states.index(machine.contact_state)] = 0.0
    time = graph.node("time")
    velocities = placed.contact_velocity(time, tuple(own)), *placed.machine.further_velocities(time, tuple(own))
    found = tuple(map(graph.expression, velocities))
    if any(graph.nodes[i][0] == "state" for i in reachable(graph, [shift.index for shift in found])):
        what = f"should be functions of time, but for the state {machine.contact_state} that is added to each"
        raise ValueError(f"the {machine.name}: at imposed distances contact_velocity and further_velocities {what}")
    return found
