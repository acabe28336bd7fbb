"""The equations of motion of a system as its machine tells them, recorded beside the solved ones."""

from typing import Any

from vibrocap.numerics.expressions.equations import ContactMechanics, Load, Mechanics, MotionRow
from vibrocap.numerics.expressions.graph import Expression, Graph
from vibrocap.physics.flow import Flow
from vibrocap.physics.system import System


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
