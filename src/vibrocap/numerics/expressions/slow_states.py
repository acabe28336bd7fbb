"""Which states of recorded equations relax faster than the motion: what may be slaved to all others, and its decay."""

import functools
import operator

from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.forms import Forms
from vibrocap.numerics.expressions.graph import Expression, derivative


def slow_bristles(equations: Equations) -> tuple[tuple[int, int], ...]:
    """(contact, internal state) of contacts whose one internal state may be slaved to all others; () with a tangent."""
    if not equations.maybe_stiff or len(equations.rates) > equations.base:
        return ()
    record_slopes(equations)
    forms = Forms(equations.graph, equations.rates)
    found = []
    for contact, each in enumerate(equations.contacts):
        if each.kind == "kinked" and len(each.internal) == 1 and not equations.law_switches:
            state = each.internal[0]
            rate = equations.rates[state]
            if forms.linear(rate.index)[1] == rate.index and derivative(rate, state).value != 0.0:
                found.append((contact, state))
    return tuple(found)


def slow_states(equations: Equations) -> tuple[tuple[int, int], ...]:
    """(contact, state) of what may be slaved in a motion alone: bristles, the velocity of a contact that creeps, both.

    () where a contact has a law with a force for every velocity, but no such bristles: those take implicit steps.
    """
    bristles, stiff = slow_bristles(equations), [i for i, each in enumerate(equations.contacts) if not each.sticks]
    if stiff != [contact for contact, _ in bristles]:
        return ()
    found = dict[int, int]()  # contact by state
    for contact, _ in bristles:
        each = equations.contacts[contact]
        if (each.is_state or equations.several) and derivative(equations.rates[each.state], each.state).value is None:
            found.setdefault(each.state, contact)
    return (*bristles, *((contact, state) for state, contact in found.items()))


def decay_rates(equations: Equations) -> list[Expression]:
    """Rates of which the largest is that of the fastest decay: the trace of the Jacobian, with the other sign.

    It is the sum of all rates, of which that of bristles exceeds all others where it matters; of several bristles of
    one law it is the sum. Bristles of one contact know nothing of those of another but by the velocities of their
    bodies, so that each contact has a trace of its own, without the bristles of all others: as if it were alone.
    Without the tangent of a motion, which decays as the motion does.
    """
    slopes = [derivative(rate, i) for i, rate in enumerate(equations.rates[: equations.base])]
    bristles = [set(each.internal) for each in equations.contacts if each.internal]
    apart = [set().union(*(other for other in bristles if other is not own)) for own in bristles] or [set()]
    kept = [[slope for i, slope in enumerate(slopes) if i not in others] for others in apart]
    return [-functools.reduce(operator.add, each) for each in kept]


def record_slopes(equations: Equations) -> None:
    """Record the slopes of all rates in one order: a graph remembers of a product which factor came first."""
    decay_rates(equations)
    for rate in equations.rates:
        for state in range(-1, len(equations.rates)):
            derivative(rate, state)
