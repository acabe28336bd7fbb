"""Crawlers: two to twenty bodies in a row, all of them rubbing, with a spring, a damper and a drive in every gap."""

import itertools
import math
from collections.abc import Mapping
from typing import Any, ClassVar

from hand_machines.row import APART, Numbered, Row, row_of, row_of_bodies
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import Body, Contact, Link, Mechanism, NonNegative, Number, Positive
from vibrocap.physics.names import numbered


class Crawler(Row):
    """Bodies 1, 2, ... in a row on the ground, each with a contact of its own; z_i is how far gap i has opened.

    Body 1 is the rearmost. The force T_i pulls the bodies beside gap i together, and friction R_i acts on body i:

        m_i v_i' = T_i - T_(i-1) - R_i,     T_i = k_i z_i + c_i z_i' - a_i drive,     z_i' = v_(i+1) - v_i

    so that a positive drive pushes apart; a_i is the share of it in gap i, whose sign may differ from gap to gap. What
    has no number in its name belongs to body 1 or to the first gap. Without friction the bodies would not travel, and
    they travel where forward and back, or front and rear, differ: by the masses, the loads, the laws or the drive.

    Any consistent units may be used, SI as well as none. Loads are forces, the weights of the bodies for instance.
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
        """The states, of which the first gap and the first two bodies have the names that other machines give them."""
        inner = (*(f"displacement_{i}" for i in range(2, bodies)), *(f"velocity_{i}" for i in range(3, bodies + 1)))
        states = ("displacement", "velocity_2", "position", "velocity", *inner)
        contacts = tuple(numbered("velocity", i) for i in range(1, bodies + 1))
        return {"states": states, "contact_states": contacts, "symmetry": (-1,) * len(states)}

    def scales(self, time=1.0):
        """Opening and speed that a force of the size of all loads makes, as of an `Oscillator`."""
        mass, load = sum(self._all("mass", self.bodies)), sum(self._all("normal_load", self.bodies))
        stiffness = self.stiffness + mass * (2.0 * math.pi / time) * (2.0 * math.pi / time)  # type: ignore[attr-defined]
        length, speed = load / stiffness, load / sqrt(mass * stiffness)
        return tuple(speed if name.startswith("velocity") else length for name in self.states)

    def effort_scale(self):
        """The sum of all loads."""
        return sum(self._all("normal_load", self.bodies))

    def masses(self):
        """m_1, m_2, ..."""
        return dict(zip(self.contact_states, self._all("mass", self.bodies), strict=True))

    def _velocities(self, y) -> tuple:
        return y[3], y[1], *y[4 + self.bodies - 2 :]

    def _gaps(self, y) -> tuple:
        """(z_i, z_i') of each gap."""
        v = self._velocities(y)
        openings = (y[0], *y[4 : 4 + self.bodies - 2])
        return tuple((z, v[i + 1] - v[i]) for i, z in enumerate(openings))

    def _pushes(self, y, drive) -> list:
        """All forces on each body but friction: T_i - T_(i-1), and the weight along a slope of all but the first."""
        gaps = self._gaps(y)
        share = zip(gaps, *(self._all(name, len(gaps)) for name in ("stiffness", "damping", "actuation")), strict=True)
        pulls = [k * z + c * rate - a * drive for (z, rate), k, c, a in share]
        found = [pulls[0], *(ahead - behind for behind, ahead in itertools.pairwise(pulls)), -pulls[-1]]
        if self.level:
            return found
        weights = (mass * self.gravity[1] for mass in self._all("mass", self.bodies)[1:])
        return [found[0], *(push - weight for push, weight in zip(found[1:], weights, strict=True))]

    def contacts(self, t, y, drive):
        """v_i, and R_i that keeps v_i' = 0."""
        return tuple(map(Contact, self._velocities(y), self._pushes(y, drive)))

    def rates(self, t, y, drive, frictions):
        """y' = (z_1', v_2', X', v_1', z_2', ..., v_3', ...)."""
        masses = self._all("mass", self.bodies)
        each = zip(self._pushes(y, drive), frictions, masses, strict=True)
        accelerations = [(push - friction) / mass for push, friction, mass in each]
        rates = [rate for _, rate in self._gaps(y)]
        return rates[0], accelerations[1], y[3], accelerations[0], *rates[1:], *accelerations[2:]

    def energy(self, t, y):
        """H = sum of m_i v_i^2/2 and k_i z_i^2/2."""
        found = 0.0
        for mass, v in zip(self._all("mass", self.bodies), self._velocities(y), strict=True):
            found = found + 0.5 * mass * v * v
        for stiffness, (z, _) in zip(self._all("stiffness", self.bodies - 1), self._gaps(y), strict=True):
            found = found + 0.5 * stiffness * z * z
        return found

    def powers(self, t, y, drive, frictions):
        """Power of the drive, the sum of a_i drive z_i', and of the dampers, -c_i z_i'^2."""
        driven = damped = 0.0
        shares = (self._all(name, self.bodies - 1) for name in ("actuation", "damping"))
        for (_, rate), actuation, damping in zip(self._gaps(y), *shares, strict=True):
            driven, damped = driven + actuation * (drive * rate), damped - damping * rate * rate
        return driven, damped

    def mechanism(self, t, y) -> Mechanism | None:
        """Bodies on the ground, with a link in every gap."""
        place, bodies, links = y[2], [], []
        for i, (mass, rate) in enumerate(zip(self._all("mass", self.bodies), self._velocities(y), strict=True)):
            bodies.append(Body(f"body {i + 1}", mass, place=place, rate=rate, contact=i))
            if i < self.bodies - 1:
                place = place + self._gaps(y)[i][0]
        own = (self._all(name, self.bodies - 1) for name in ("stiffness", "damping", "actuation"))
        for i, (stiffness, damping, actuation) in enumerate(zip(*own, strict=True), start=1):
            links.append(Link(f"body {i}", f"body {i + 1}", stiffness, damping, actuation))
        return Mechanism(tuple(bodies), tuple(links))

    def scene(self, t, y):
        """Blocks in a row, with springs; how far apart they stand at rest the equations do not say."""
        places = [y[2]]
        for z, _ in self._gaps(y):
            places.append(places[-1] + APART + z)
        return row_of_bodies(places, "spring")


def crawler(bodies: int) -> Any:
    """The class of a crawler of two to twenty bodies, "two-body-crawler" and so on."""
    return row_of(Crawler, bodies)


TwoBodyCrawler = crawler(2)
ThreeBodyCrawler = crawler(3)
