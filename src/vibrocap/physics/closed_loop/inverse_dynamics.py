"""The force or torque that gives a state of a machine the rate that is ordered, from the machine's own equations.

Rates are affine in the effort u and in the friction forces R, so that u is affine in R:

    y_i' = f + f_u u + f_1 R_1 + f_2 R_2 + ... = w     =>     u = (w - f)/f_u - (f_1/f_u) R_1 - (f_2/f_u) R_2 - ...

(computed torque, or inverse dynamics: Spong, Hutchinson and Vidyasagar 2006, section 8.3; with coordinates that no
effort acts on, as a capsule under its pendulum, collocated partial linearisation: Spong 1994). With u put in, the
machine's contacts are again of the form a = b - A R, and whether they rest is decided as for any other machine.
"""

import dataclasses
from collections.abc import Sequence
from typing import Any

from vibrocap.physics.machines.machine import Contact


@dataclasses.dataclass(frozen=True)
class Affine:
    """free + slope_1 x_1 + slope_2 x_2 + ...: what the equations make of an effort and of forces given like this.

    So slopes are exact and depend on no more than they must. As differences of rates they would be rounded, and in
    interval arithmetic so wide that steps could no longer be proved to see a sharp law (`resolution.py`). TypeError
    where two such numbers are multiplied, or one divides: that is not affine.
    """

    free: Any
    slopes: tuple

    def at(self, values: Sequence[Any]) -> Any:
        """What it is with these numbers."""
        return self.free + sum((slope * x for slope, x in zip(self.slopes, values, strict=True)), 0.0)

    def scaled(self, factor: Any) -> "Affine":
        """That many times as much."""
        return Affine(self.free * factor, tuple(slope * factor for slope in self.slopes))

    def __add__(self, other: Any) -> "Affine":
        if not isinstance(other, Affine):
            return Affine(self.free + other, self.slopes)
        return Affine(self.free + other.free, tuple(a + b for a, b in zip(self.slopes, other.slopes, strict=True)))

    def __neg__(self) -> "Affine":
        return Affine(-self.free, tuple(-slope for slope in self.slopes))

    def __radd__(self, other: Any) -> "Affine":
        return Affine(other + self.free, self.slopes)

    def __sub__(self, other: Any) -> "Affine":
        return self + (-other)

    def __rsub__(self, other: Any) -> "Affine":
        return Affine(other - self.free, tuple(-slope for slope in self.slopes))

    def __mul__(self, other: Any) -> "Affine":
        if isinstance(other, Affine):
            raise TypeError("is a product of two of drive and friction forces, where it should be affine in them")
        return self.scaled(other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> "Affine":
        return Affine(self.free / other, tuple(slope / other for slope in self.slopes))


def _affine(value: Any, count: int) -> Affine:
    return value if isinstance(value, Affine) else Affine(value, (0.0,) * count)


def variables(count: int) -> tuple[Affine, ...]:
    """The effort, then the friction force at each contact."""
    return tuple(Affine(0.0, tuple(1.0 if i == k else 0.0 for i in range(count + 1))) for k in range(count + 1))


def affine_rates(machine: Any, t: Any, y: Sequence[Any]) -> tuple[Affine, ...]:
    """y' of a machine, affine in the effort and the friction forces."""
    count = len(machine.contact_states)
    effort, *frictions = variables(count)
    return tuple(_affine(rate, count + 1) for rate in machine.rates(t, y, effort, tuple(frictions)))


def effort_for(rate: Affine, wanted: Any) -> Affine:
    """u, affine in the friction forces, by which a rate is the one that is wanted."""
    by_effort, *by_friction = rate.slopes
    return Affine((wanted - rate.free) / by_effort, tuple(-(slope / by_effort) for slope in by_friction))


def put_in(value: Any, effort: Affine) -> Affine:
    """What is affine in the effort and the friction forces, in these alone under such an effort."""
    value = _affine(value, 1 + len(effort.slopes))
    by_effort, *by_friction = value.slopes
    slopes = tuple(own + by_effort * by for own, by in zip(by_friction, effort.slopes, strict=True))
    return Affine(value.free + by_effort * effort.free, slopes)


def contacts_under(machine: Any, t: Any, y: Sequence[Any], effort: Affine) -> tuple[Contact, ...]:
    """The contacts of a machine whose effort depends on the forces at them: accelerations, responses and reactions."""
    rates, told = affine_rates(machine, t, y), variables(len(effort.slopes))[0]
    found = []
    for each, state in zip(machine.contacts(t, y, told), machine.contact_states, strict=True):
        own, reaction = put_in(rates[machine.states.index(state)], effort), each.reaction
        if reaction is not None:
            inertia, load, *slopes = reaction
            load = put_in(load, effort)
            more = (slope + by for slope, by in zip(slopes, load.slopes, strict=True))
            reaction = (inertia, load.free, *more)
        response = tuple(-slope for slope in own.slopes)
        found.append(
            Contact(each.velocity, acceleration=own.free, response=response, reaction=reaction, factor=each.factor)
        )
    return tuple(found)
