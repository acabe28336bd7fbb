"""Worms of two to twenty bodies in a row, whose distances the drive imposes, each with a contact of its own."""

import math
from typing import Any, ClassVar

from vibrocap.physics.machines.machine import Number, Positive
from vibrocap.physics.machines.row import Numbered, Row, row_of
from vibrocap.physics.mechanics.parts import Contact, Mass, coordinate


class Worm(Row):
    """Bodies 1, 2, ... in a row on the ground, each with a contact of its own; the drive z(t) imposes their distances.

    Body 1 is the rearmost. Gap i is a_i z(t) wider than at z = 0, whatever force that takes. One coordinate is left
    free, p, the velocity of the common centre of mass, which continues where z' jumps; friction R_i acts on body i:

        x_i' = p + u_i z',    u_i = a_1 + ... + a_(i-1) - (mean over the masses),    M p' = -(R_1 + ... + R_n)

    This is worm-like locomotion without legs (Chernousko 2002; Zimmermann, Zeidis and Bolotnik 2009). It travels where
    front and rear differ, by masses, loads, laws or a gait, or where friction differs between forward and back. Body i
    at rest holds R_i = M u_i z'' less the friction of all others; of bodies that rest together equal shares of their
    limits are shown (hyperstatic, `contacts.py`).

    The energy is that of the common centre, M p^2/2, and the work of the drive what reaches it, the sum of u_i z' R_i.
    What gap i takes is `actuator_force_i`, the push between the bodies behind and ahead, and the power of all
    `actuator_power`; where z' jumps the force has an impulse besides. Any consistent units may be used.
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
    position = coordinate("X", "place of body 1", "m", rate="centre_velocity")

    def parts(self, q):
        x, parts = q.position, []
        shares = (0.0, *self._all("actuation", self.bodies - 1))
        own = zip(shares, self._all("mass", self.bodies), self._all("normal_load", self.bodies), strict=True)
        for i, (share, mass, load) in enumerate(own, start=1):
            x = x if i == 1 else x + q.imposed(share * q.drive)
            body = Mass(f"body {i}", mass, x=x)
            parts += [body, Contact(body, load=load)]
        return parts

    def scales(self, time=1.0):
        """Distance and speed that all loads give to all bodies in the time of a radian of the drive."""
        mass, load = self._whole("mass"), self._whole("normal_load")
        short = time / (2.0 * math.pi)
        return load / mass * short * short, load / mass * short


def worm(bodies: int) -> Any:
    """The class of a worm of two to twenty bodies, "two-body-worm" and so on."""
    return row_of(Worm, bodies)


TwoBodyWorm = worm(2)
ThreeBodyWorm = worm(3)
