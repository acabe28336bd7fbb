"""Worms of two to twenty bodies in a row, whose distances the drive imposes, each with a contact of its own."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from hand_machines.imposed import Imposed
from hand_machines.row import APART, Numbered, Row, row_of, row_of_bodies
from vibrocap.physics.machines.machine import Contact, Number, Positive
from vibrocap.physics.names import numbered


class Worm(Row, Imposed):
    """Bodies 1, 2, ... in a row on the ground, each with a contact of its own; the drive z(t) imposes their distances.

    Body 1 is the rearmost. Gap i is a_i z(t) wider than at z = 0, whatever force that takes. One coordinate is left
    free, p, the velocity of the common centre of mass, which continues where z' jumps; friction R_i acts on body i:

        x_i' = p + u_i z',    u_i = a_1 + ... + a_(i-1) - (mean over the masses),    M p' = -(R_1 + ... + R_n)

    This is the model of worm-like locomotion without legs (Chernousko 2002; Zimmermann, Zeidis and Bolotnik 2009). It
    travels where front and rear differ, by masses, loads, laws or a gait, or where friction differs between forward and
    back. Body i at rest holds R_i = M u_i z'' less the friction of all others.

    Two bodies rest together only while their distance does not change. How they share the force that is then held is
    open, though the motion is not (hyperstatic, see `contacts.py`): shown are equal shares of their limits.

    The energy is that of the common centre, M p^2/2, and the work of the drive what reaches it, the sum of u_i z' R_i.
    What a gap takes is `actuator_force` (of gap i: `actuator_force_i`), the push between the bodies behind and ahead,
    and the power of all `actuator_power`; where z' jumps the force has an impulse besides.

    Any consistent units may be used, SI as well as none. Loads are forces, the weights of the bodies for instance.
    """

    called: ClassVar = ("body", "worm")
    source: ClassVar[str] = "chernousko2002; zimmermann2009b"
    summary: ClassVar = "bodies in a row at imposed distances, all of them rubbing."
    row_parameters: ClassVar = (
        Numbered("mass", "body", Positive, Positive, 1.0, "m", "mass of body {}", "mass"),
        Numbered("actuation", "gap", Number, Number, 1.0, "a", "share of the drive by which gap {} widens", "share"),
        Numbered("normal_load", "body", Positive, Positive, 1.0, "N", "load on the contact of body {}", "load"),
    )
    effort: ClassVar = "displacement"
    state_units: ClassVar = {"centre_velocity": "m/s"}
    states: ClassVar = ("position", "centre_velocity")
    symmetry: ClassVar = (-1, -1)

    @classmethod
    def of_bodies(cls, bodies: int) -> Mapping[str, Any]:
        """The state that all contacts share."""
        return {"contact_states": ("centre_velocity",) * bodies}

    def _mass(self):
        """M."""
        return sum(self._all("mass", self.bodies))

    def _shares(self) -> tuple:
        """u_1, u_2, ..."""
        ahead, moved, mean = [0.0], 0.0, 0.0
        for share in self._all("actuation", self.bodies - 1):
            ahead.append(ahead[-1] + share)
        for mass, place in zip(self._all("mass", self.bodies), ahead, strict=True):
            moved = moved + mass * place
        mean = moved / self._mass()
        return tuple(place - mean for place in ahead)

    def scales(self, time=1.0):
        """Distance and speed that all loads give to all bodies in the time of a radian of the drive."""
        mass, load = self._mass(), sum(self._all("normal_load", self.bodies))
        short = time / (2.0 * math.pi)
        return load / mass * short * short, load / mass * short

    def masses(self):
        """M; what moves between the bodies is imposed."""
        return {"centre_velocity": self._mass()}

    def _sliding(self, t, y) -> tuple:
        """x_1', x_2', ..."""
        return tuple(y[1] + share * self.imposed.slope(t) for share in self._shares())

    def contacts(self, t, y, drive):
        """x_i', and a_i = u_i z'' - (R_1 + R_2 + ...)/M."""
        curvature, response = self.imposed.curvature(t), (1.0 / self._mass(),) * self.bodies
        each = zip(self._sliding(t, y), self._shares(), strict=True)
        return tuple(Contact(v, acceleration=share * curvature, response=response) for v, share in each)

    def rates(self, t, y, drive, frictions):
        """y' = (x_1', p')."""
        return self._sliding(t, y)[0], -_sum(frictions) / self._mass()

    def energy(self, t, y):
        """H = M p^2/2, of the common centre."""
        return 0.5 * self._mass() * y[1] * y[1]

    def momentum(self, t, y):
        """M p; its rate is minus the sum of the friction forces."""
        return self._mass() * y[1]

    def powers(self, t, y, drive, frictions):
        """What of the power of the drive moves the common centre, z' times the sum of u_i R_i; no damper."""
        found = 0.0
        for share, friction in zip(self._shares(), frictions, strict=True):
            found = found + share * friction
        return found * self.imposed.slope(t), 0.0

    def actuator(self, t, y, frictions):
        """The push in each gap, m_1 x_1'' + R_1 and so on from behind, taken with the other sign; power of all."""
        curvature, slope, found, power = self.imposed.curvature(t), self.imposed.slope(t), {}, 0.0
        behind = 0.0 if self.gravity is None else self._mass() * self.gravity[1]  # all weight is given with body 1
        centre = -_sum(frictions) / self._mass()
        bodies = zip(self._all("mass", self.bodies - 1), self._shares(), frictions, strict=False)
        for i, (mass, share, friction) in enumerate(bodies, start=1):
            behind = behind - (mass * (centre + share * curvature) + friction)
            if self.gravity is not None:
                behind = behind - mass * self.gravity[1]
            found[numbered("actuator_force", i)] = behind
            power = power + getattr(self, numbered("actuation", i)) * behind * slope
        return {**found, "actuator_power": power}

    def scene(self, t, y):
        """Blocks in a row, with rods as long as the drive makes them."""
        places = [y[0]]
        for share in self._all("actuation", self.bodies - 1):
            places.append(places[-1] + APART + share * self.imposed.value(t))
        return row_of_bodies(places, "rod")


def _sum(frictions):
    """Of all friction forces."""
    first, *others = frictions
    return sum(others, start=first)


def worm(bodies: int) -> Any:
    """The class of a worm of two to twenty bodies, "two-body-worm" and so on."""
    return row_of(Worm, bodies)


TwoBodyWorm = worm(2)
ThreeBodyWorm = worm(3)
