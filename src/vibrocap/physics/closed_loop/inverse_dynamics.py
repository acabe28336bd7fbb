"""The force or torque that gives a state of a machine the rate that is ordered, from the machine's own equations.

Rates are affine in the effort u and in the friction forces R, so that u is affine in R:

    y_i' = f + f_u u + f_1 R_1 + f_2 R_2 + ... = w     =>     u = (w - f)/f_u - (f_1/f_u) R_1 - (f_2/f_u) R_2 - ...

(computed torque, or inverse dynamics: Spong, Hutchinson and Vidyasagar 2006, section 8.3; with coordinates that no
effort acts on, as a capsule under its pendulum, collocated partial linearisation: Spong 1994). With u put in, the
machine's contacts are again of the form a = b - A R, and whether they rest is decided as for any other machine.
"""

from collections.abc import Sequence
from typing import Any

from vibrocap.physics.machines.machine import Contact


def effort_for(rate: Sequence[Any], wanted: Any) -> tuple:
    """u as (free, by the force at each contact), by which a rate (f, f_u, f_1, ...) is the one that is wanted."""
    free, by_effort, *by_friction = rate
    return (wanted - free) / by_effort, *(-(slope / by_effort) for slope in by_friction)


def put_in(value: Sequence[Any], effort: Sequence[Any]) -> tuple:
    """What is affine in the effort and the friction forces, in these alone under such an effort."""
    free, by_effort, *by_friction = value
    return tuple(own + by_effort * by for own, by in zip((free, *by_friction), effort, strict=True))


def contacts_under(machine: Any, t: Any, y: Sequence[Any], effort: Sequence[Any]) -> tuple[Contact, ...]:
    """The contacts of a machine whose effort depends on the forces at them: accelerations, responses and reactions."""
    contacts, (rates, loads) = [], machine.evaluated("effects", t, y)
    for contact, state, load in zip(machine.contacts(t, y, 0.0), machine.contact_states, loads, strict=True):
        acceleration, *slopes = put_in(rates[machine.states.index(state)], effort)
        response = tuple(-slope for slope in slopes)
        reaction = None if load is None else put_in(load, effort)
        contacts.append(Contact(contact.velocity, None, acceleration, response, reaction, contact.factor))
    return tuple(contacts)
