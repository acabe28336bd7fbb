"""Worms on contacts that remember, by SciPy: DOP853 from corner to corner and from kink to kink.

Nothing is shared with the package: the equations are those of docs/machines.md and docs/friction.md, written anew. A
contact keeps its side until its velocity vanishes, and takes the sign of its velocity anew at every corner of the
drive, at which that velocity jumps. Where a law has a kink of its own the solver stops too.
"""

import dataclasses
import itertools
import math

import numpy as np
from scipy.integrate import solve_ivp

EXACT = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
LONGEST = 0.05  # step, in which an event might hide
STILL = 1e-13  # speed of a contact that turns, to rounding


def level(v, law):
    """Friction at a steady speed, under a load of 1: from static to Coulomb level."""
    drop = law["static_coefficient"] - law["coulomb_coefficient"]
    return law["coulomb_coefficient"] + drop * math.exp(-((v / law["stribeck_velocity"]) ** 2))


@dataclasses.dataclass
class Contact:
    """A law with its numbers under a load; z: its states, side: that of the slide, modes: of its pieces."""

    law: dict
    load: float
    states = 1
    modes = ()

    def turned(self):
        """A slide to the other side begins."""

    def kinks(self, v, z, side):
        """Functions that are positive within the present pieces."""
        return []

    def passed(self, which):
        """Beyond such a kink."""


class LuGre(Contact):
    """z' = v - |v| z/g(v), R = d0 z + d1 z'."""

    def force(self, v, z, side):
        """(R, z')."""
        law = self.law
        rate = v - law["bristle_stiffness"] * side * v * z[0] / (self.load * level(v, law))
        return law["bristle_stiffness"] * z[0] + law["bristle_damping"] * rate, [rate]


class Dahl(Contact):
    """z' = v (1 - d0 z sgn(v)/(N eta_c)), R = d0 z."""

    def force(self, v, z, side):
        """(R, z')."""
        force = self.law["bristle_stiffness"] * z[0]
        return force, [v * (1.0 - side * force / (self.load * self.law["coulomb_coefficient"]))]


class BoucWen(Contact):
    """z' = v - (|v| |z| z + v z^2)/2 in units of Y = N eta_c/d0: A = 1, beta = gamma = 1/2, n = 2."""

    def force(self, v, z, side):
        """(R, z')."""
        limit = self.load * self.law["coulomb_coefficient"]
        share = self.law["bristle_stiffness"] * z[0] / limit
        rate = v - 0.5 * side * v * abs(share) * share - 0.5 * v * share * share
        return limit * share, [rate]


class ElastoPlastic(Contact):
    """z' = v (1 - p sgn(v) z/g), R = d0 z + d1 z'; p from 0 at z_ba to 1 at g(v) in loading, along half a wave."""

    def force(self, v, z, side):
        """(R, z')."""
        law, loaded = self.law, side * self.law["bristle_stiffness"] * z[0] / self.load
        top, least = level(v, law), law["elastic_share"] * law["coulomb_coefficient"]
        share = 0.5 + 0.5 * math.sin(math.pi * (min(max(loaded, least), top) - 0.5 * (top + least)) / (top - least))
        rate = v * (1.0 - share * loaded / top)
        return law["bristle_stiffness"] * z[0] + law["bristle_damping"] * rate, [rate]


class MaxwellSlip(Contact):
    """Four springs; F_i' = k_i v until |F_i| = nu_i s(v), then N C (nu_i sgn(v) - F_i/s(v)) until the slide ends."""

    states = 4
    stiffness = (40.0, 30.0, 20.0, 10.0)
    shares = (0.1, 0.2, 0.3, 0.4)
    slipping = (False,) * 4

    def turned(self):
        """All stick."""
        self.slipping = (False,) * 4

    def force(self, v, z, side):
        """(R, F_i')."""
        top, rate = self.load * level(v, self.law), self.load * self.law["attraction_rate"]
        of_each = zip(self.stiffness, self.shares, z, self.slipping, strict=True)
        return sum(z), [rate * (nu * side - f / top) if slips else k * v for k, nu, f, slips in of_each]

    def kinks(self, v, z, side):
        """How far the sticking ones are from their shares."""
        top, of_each = self.load * level(v, self.law), zip(self.shares, z, self.slipping, strict=True)
        return [1.0 if slips else nu * top - side * f for nu, f, slips in of_each]

    def passed(self, which):
        """One slips."""
        self.slipping = tuple(slips or i == which for i, slips in enumerate(self.slipping))


KINDS = {
    "lugre": LuGre,
    "dahl": Dahl,
    "bouc-wen": BoucWen,
    "elasto-plastic": ElastoPlastic,
    "maxwell-slip": MaxwellSlip,
}


class Worm:
    """A worm under a drive whose slope is constant from corner to corner, so that all bodies accelerate alike.

    actuation: by how much of the drive each gap widens. y holds x_1, the velocity p of the common centre, all states.
    """

    def __init__(self, masses, actuation, contacts):
        self.mass, self.contacts = sum(masses), contacts
        places = np.concatenate(([0.0], np.cumsum(actuation)))
        self.shares = (places - np.dot(masses, places) / self.mass).tolist()
        cuts = np.cumsum([2, *(each.states for each in contacts)]).tolist()
        self.own = [slice(first, last) for first, last in itertools.pairwise(cuts)]
        self.size, self.turns, self.sides = cuts[-1], [], [0.0] * len(contacts)

    def velocity(self, i, y):
        """x_i'."""
        return y[1] + self.shares[i] * self.slope

    def rates(self, _t, y):
        """y'."""
        found, friction = [], 0.0
        for i, contact in enumerate(self.contacts):
            force, own = contact.force(self.velocity(i, y), y[self.own[i]].tolist(), self.sides[i])
            friction += force
            found += own
        return [self.velocity(0, y), -friction / self.mass, *found]

    def kinks(self, i, y):
        """Of one contact."""
        return self.contacts[i].kinks(self.velocity(i, y), y[self.own[i]].tolist(), self.sides[i])

    def turn(self, i, t):
        """A contact begins to slide to the other side."""
        self.turns.append((t, i + 1))
        self.sides[i] = -self.sides[i]
        self.contacts[i].turned()

    def guards(self, y):
        """(which contact and kink, function) of all that ends a piece; contact -1: where the acceleration vanishes.

        There for no velocity to pass zero twice in a step.
        """
        yield (-1, 0), lambda t, y: self.rises * self.rates(t, y)[1]
        for i in range(len(self.contacts)):
            yield (i, -1), lambda _t, y, i=i: self.sides[i] * self.velocity(i, y)
            for k in range(len(self.kinks(i, y))):
                yield (i, k), lambda _t, y, i=i, k=k: self.kinks(i, y)[k]

    def end(self, corners, slopes, start, until):
        """(x_1, p) at the end. corners: instants, the first one 0; start: p there, where nothing is deflected."""
        y = np.zeros(self.size)
        y[1] = start
        for t, end, self.slope in zip(corners, [*corners[1:], until], slopes, strict=True):
            self.bent = False
            for i in range(len(self.contacts)):
                if self.sides[i] == 0.0:
                    self.sides[i] = math.copysign(1.0, self.velocity(i, y))
                elif self.sides[i] * self.velocity(i, y) < 0.0:
                    self.turn(i, t)
            while t < end:
                t, y = self.piece(t, y, end)
        return y[:2]

    def piece(self, t, y, end):
        """(time, state) at the end of a piece."""
        for i in range(len(self.contacts)):
            for k, left in enumerate(self.kinks(i, y)):
                if left <= 0.0:
                    self.contacts[i].passed(k)
        self.rises = -self.rises if self.bent else math.copysign(1.0, self.rates(t, y)[1])
        names, guards = zip(*self.guards(y), strict=True)
        for guard in guards:
            guard.terminal, guard.direction = True, -1.0
        run = solve_ivp(self.rates, (t, end), y, events=guards, max_step=LONGEST, **EXACT)
        assert run.success, run.message
        y, self.bent = run.y[:, -1], run.status == 1 and len(run.t_events[0]) > 0
        fired = [name for name, instants in zip(names, run.t_events, strict=True) if len(instants)]
        for i, k in fired:
            if i >= 0 and k >= 0:
                self.contacts[i].passed(k)
        left = {self.sides[i] for i, k in fired if k < 0}
        for i in range(len(self.contacts)):  # with all others that are as slow on that side
            if (i, -1) in fired or (self.sides[i] in left and abs(self.velocity(i, y)) < STILL):
                self.turn(i, run.t[-1])
        return run.t[-1], y
