"""Crawlers: two to twenty bodies in a row, all of them rubbing, with a spring, a damper and a drive in every gap."""

from collections.abc import Mapping
from typing import Any, ClassVar

from vibrocap.physics.machines.machine import NonNegative, Number, Positive
from vibrocap.physics.machines.row import Numbered, Row, row_of
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, coordinate
from vibrocap.physics.names import numbered


class Crawler(Row):
    """Bodies 1, 2, ... in a row on the ground, each with a contact of its own; z_i is how far gap i has opened.

    Body 1 is the rearmost. The force T_i pulls the bodies beside gap i together, and friction R_i acts on body i:

        m_i v_i' = T_i - T_(i-1) - R_i,     T_i = k_i z_i + c_i z_i' - a_i drive,     z_i' = v_(i+1) - v_i

    so that a positive drive pushes apart; the share a_i may differ in sign from gap to gap. What has no number in its
    name belongs to body 1 or to the first gap. They travel where forward and back, or front and rear, differ: by the
    masses, the loads, the laws or the drive. Any consistent units may be used; loads are forces.
    """

    called: ClassVar = ("body", "crawler")
    source: ClassVar[str] = "zimmermann2009"
    summary: ClassVar = "bodies in a row, all of them rubbing."
    row_parameters: ClassVar = (
        Numbered("mass", "body", Positive, Positive, 1.0, "m", "mass of body {}", "mass"),
        Numbered("stiffness", "gap", Positive, NonNegative, 1.0, "k", "spring in gap {}", "stiffness"),
        Numbered("damping", "gap", NonNegative, NonNegative, 0.1, "c", "damper in gap {}", "viscous damping"),
        Numbered("actuation", "gap", Number, Number, 1.0, "a", "share of the drive that pushes gap {} apart", "share"),
        Numbered("normal_load", "body", Positive, NonNegative, 1.0, "N", "load on the contact of body {}", "load"),
    )

    @classmethod
    def of_bodies(cls, bodies: int) -> Mapping[str, Any]:
        """The first gap, body 1, and the other gaps."""
        gaps = {numbered("displacement", i): coordinate("z", f"opening of gap {i}", "m") for i in range(1, bodies)}
        first = gaps.pop("displacement")
        return {"displacement": first, "position": coordinate("X", "place of body 1", "m"), **gaps}

    def parts(self, q):
        places, parts = [q.position], []
        own = (self._all(name, self.bodies - 1) for name in ("stiffness", "damping", "actuation"))
        for i, (stiffness, damping, share) in enumerate(zip(*own, strict=True), start=1):
            gap = getattr(q, numbered("displacement", i))
            places.append(places[-1] + gap)
            parts += [Spring(stiffness, gap), Damper(damping, gap), Drive(gap, share)]
        bodies = zip(places, self._all("mass", self.bodies), self._all("normal_load", self.bodies), strict=True)
        for i, (x, mass, load) in enumerate(bodies, start=1):
            body = Mass(f"body {i}", mass, x=x)
            parts += [body, Contact(body, load=load, speed=numbered("velocity", i))]
        return parts


def crawler(bodies: int) -> Any:
    """The class of a crawler of two to twenty bodies, "two-body-crawler" and so on."""
    return row_of(Crawler, bodies)


TwoBodyCrawler = crawler(2)
ThreeBodyCrawler = crawler(3)
