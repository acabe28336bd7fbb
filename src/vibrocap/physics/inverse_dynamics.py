"""The force or torque that gives a state of a machine the rate that is ordered, from the machine's own equations.

Rates are affine in the effort u and in the friction forces R, so that u is affine in R:

    y_i' = f + f_u u + f_1 R_1 + f_2 R_2 + ... = w     =>     u = (w - f)/f_u - (f_1/f_u) R_1 - (f_2/f_u) R_2 - ...

(computed torque, or inverse dynamics: Spong, Hutchinson and Vidyasagar 2006, section 8.3; with coordinates that no effort
acts on, as a capsule under its pendulum, collocated partial linearisation: Spong 1994). With u put in, the machine's
contacts are again of the form a = b - A R, and whether they rest is decided as for any other machine.
"""

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

from vibrocap.physics.machines.machine import Contact


@dataclasses.dataclass(frozen=True)
class Effort:
    """u = free + by_friction_1 R_1 + by_friction_2 R_2 + ..."""

    free: Any
    by_friction: tuple

    def at(self, frictions: Sequence[Any]) -> Any:
        """u under these friction forces."""
        return self.free + sum((by * force for by, force in zip(self.by_friction, frictions, strict=True)), 0.0)

    def limited(self, held: Any, limit: Any) -> "Effort":
        """Behind a limit: `held` is +1 or -1 where that holds, 0 where it does not."""
        share = 1.0 - held * held
        return Effort(share * self.free + held * limit, tuple(share * by for by in self.by_friction))


def still(count: int, but: int | None = None) -> tuple[float, ...]:
    """No friction force at any contact, or one of size 1 at one of them."""
    return tuple(1.0 if i == but else 0.0 for i in range(count))


def effort_for(rate: Callable[[Any, tuple], Any], wanted: Any, count: int) -> Effort:
    """u by which the rate of a state is the one that is wanted.

    rate: of the state, given u and the friction forces; count: of contacts
    """
    free = rate(0.0, still(count))
    by_effort = rate(1.0, still(count)) - free
    slopes = [rate(0.0, still(count, i)) - free for i in range(count)]
    return Effort((wanted - free) / by_effort, tuple(0.0 - slope / by_effort for slope in slopes))


def contacts_under(machine: Any, t: Any, y: Sequence[Any], effort: Effort) -> tuple[Contact, ...]:
    """The contacts of a machine whose effort depends on the forces at them: accelerations, responses and reactions."""
    count = len(machine.contact_states)
    rows = [machine.states.index(name) for name in machine.contact_states]

    def accelerations(frictions: tuple) -> list[Any]:
        rates = machine.rates(t, y, effort.at(frictions), frictions)
        return [rates[row] for row in rows]

    free = accelerations(still(count))
    by_friction = [accelerations(still(count, j)) for j in range(count)]
    given = machine.contacts(t, y, effort.free)
    raised = machine.contacts(t, y, effort.free + 1.0) if given[0].reaction is not None else given
    return tuple(
        Contact(
            each.velocity,
            acceleration=free[i],
            response=tuple(free[i] - column[i] for column in by_friction),
            reaction=None if each.reaction is None else _reaction(each.reaction, more.reaction, effort),
        )
        for i, (each, more) in enumerate(zip(given, raised, strict=True))
    )


def _reaction(at: tuple, raised: Any, effort: Effort) -> tuple:
    """(b, n, s_1, ...) of b N = n + s_1 R_1 + ..., with what the effort adds under each force."""
    inertia, own, *slopes = at
    by_effort = raised[1] - own
    return (inertia, own, *(slope + by_effort * by for slope, by in zip(slopes, effort.by_friction, strict=True)))
