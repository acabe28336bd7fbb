"""Rows of two to twenty blocks on a belt, each on a spring from a wall and joined to the next one by another."""

import itertools
import math
from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import model_validator

from hand_machines.row import APART, Numbered, Row, row_of, row_of_bodies
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import Body, Contact, Link, Mechanism, NonNegative, Number, Positive, Shape
from vibrocap.physics.names import numbered

WALL = 2.0  # height from which the wall springs hang in pictures


@model_validator(mode="after")
def some_block_rubs(row):
    """Refuse a row without any load, which has no natural force; every class of `BlockRow` names this validator."""
    loads = [getattr(row, numbered("normal_load", i)) for i in range(1, row.bodies + 1)]
    if not any(loads):
        raise ValueError(f"normal_load should be > 0 of one block at least, got 0 for all {row.bodies}")
    return row


class BlockRow(Row):
    """Blocks 1, 2, ... in a row on a belt of the speed v_b, with springs and dampers to a wall and to each other.

    One block of it is the `Oscillator`; more are the models of chattering brakes and of earthquakes (Burridge and
    Knopoff 1967; Galvanetto and Bishop 1994; Pascal 2008). x_i is how far block i is from where no spring is stretched,
    v_i its velocity over the belt, which is exactly zero while it sticks, and friction R_i acts on it:

        x_i' = v_i + v_b,     m_i v_i' = a_i drive - k_i x_i - c_i x_i' + F_i - F_(i-1) - R_i
        F_i = kappa_i (x_(i+1) - x_i) + gamma_i (x_(i+1)' - x_i')

    What has no number in its name belongs to block 1 or to the first gap. A row that is pulled over fixed ground by its
    wall springs, whose far ends move at the speed V, is the same system seen from there: v_b = -V. A block without load
    does not rub; it needs a law that is set-valued at rest, as any without internal states.

    Any consistent units may be used, SI as well as none. Loads are forces, 1 where the coefficients of the laws are.
    """

    called: ClassVar = ("block", "row")
    source: ClassVar[str] = "burridge1967; galvanetto1994; pascal2008"
    summary: ClassVar = "blocks in a row on a belt, on springs to a wall and to each other."
    cyclic: ClassVar = None
    place: ClassVar = "position"
    channels: ClassVar = ("drive", "damper", "belt")
    belt_speed: Any
    row_parameters: ClassVar = (
        Numbered("mass", "body", Positive, Positive, 1.0, "m", "mass of block {}", "mass"),
        Numbered("stiffness", "body", NonNegative, NonNegative, 1.0, "k", "spring of block {} to a wall", "stiffness"),
        Numbered(
            "damping", "body", NonNegative, NonNegative, 0.0, "c", "damper of block {} to a wall", "viscous damping"
        ),
        Numbered("actuation", "body", Number, Number, 1.0, "a", "share of the drive that acts on block {}", "share"),
        Numbered(
            "normal_load", "body", NonNegative, NonNegative, 1.0, "N", "load on block {}; 0: it does not rub", "load"
        ),
        Numbered("coupling_stiffness", "gap", NonNegative, NonNegative, 1.0, "kappa", "spring in gap {}", "stiffness"),
        Numbered(
            "coupling_damping", "gap", NonNegative, NonNegative, 0.0, "gamma", "damper in gap {}", "viscous damping"
        ),
        Numbered("belt_speed", "row", Number, Number, 0.0, "v_b", "speed of the belt under the blocks", "speed"),
    )

    @classmethod
    def of_bodies(cls, bodies: int) -> Mapping[str, Any]:
        """The states, block by block."""
        each = [(numbered("position", i), numbered("sliding_velocity", i)) for i in range(1, bodies + 1)]
        return {
            "states": tuple(itertools.chain.from_iterable(each)),
            "contact_states": tuple(velocity for _, velocity in each),
            "symmetry": (-1,) * (2 * bodies),
            "_loads": some_block_rubs,
        }

    @property
    def symmetric(self) -> bool:
        """Only on a belt at rest."""
        return self.belt_speed == 0.0

    def _whole(self, name: str):
        """The sum of a parameter over all blocks."""
        return sum(self._all(name, self.bodies))

    def scales(self, time=1.0):
        """Way and speed that a force of the size of all loads gives to all blocks together, as of an `Oscillator`."""
        mass, load = self._whole("mass"), self.effort_scale()
        stiffness = self._whole("stiffness") + mass * (2.0 * math.pi / time) * (2.0 * math.pi / time)
        return (load / stiffness, load / sqrt(mass * stiffness)) * self.bodies

    def effort_scale(self):
        """The sum of all loads."""
        return self._whole("normal_load")

    def ground_speed(self):
        """v_b."""
        return self.belt_speed

    def masses(self):
        """m_1, m_2, ..."""
        return dict(zip(self.contact_states, self._all("mass", self.bodies), strict=True))

    def _velocities(self, y) -> tuple:
        """x_1', x_2', ..., over the ground."""
        return tuple(v + self.belt_speed for v in y[1::2])

    def _gaps(self, y) -> tuple:
        """(how far each gap has opened, how fast)."""
        each = zip(y[::2], y[1::2], strict=True)
        return tuple((after - x, faster - v) for (x, v), (after, faster) in itertools.pairwise(each))

    def _from_outside(self, y, drive) -> list:
        """Of drive, wall spring and wall damper, on each block."""
        own = (self._all(name, self.bodies) for name in ("actuation", "stiffness", "damping"))
        each = zip(*own, y[::2], self._velocities(y), strict=True)
        return [a * drive - k * x - c * velocity for a, k, c, x, velocity in each]

    def _pushes(self, y, drive) -> list:
        """All forces on each block but friction, and the weight along a slope of all but the first."""
        found, last = self._from_outside(y, drive), self.bodies - 1
        own = (self._all(name, last) for name in ("coupling_stiffness", "coupling_damping"))
        for i, ((way, rate), k, c) in enumerate(zip(self._gaps(y), *own, strict=True)):
            pull = k * way + c * rate
            found[i], found[i + 1] = found[i] + pull, found[i + 1] - pull
        if not self.level:
            for i, mass in enumerate(self._all("mass", self.bodies)[1:], start=1):
                found[i] = found[i] - mass * self.gravity[1]
        return found

    def outer_force(self, t, y, drive):
        """The sum of a_i drive - k_i x_i - c_i x_i'."""
        found = 0.0
        for force in self._from_outside(y, drive):
            found = found + force
        return found

    def contacts(self, t, y, drive):
        """v_i, and R_i that keeps v_i' = 0."""
        return tuple(map(Contact, y[1::2], self._pushes(y, drive)))

    def rates(self, t, y, drive, frictions):
        """y' = (x_1', v_1', x_2', v_2', ...)."""
        each = zip(self._pushes(y, drive), frictions, self._all("mass", self.bodies), strict=True)
        accelerations = [(push - friction) / mass for push, friction, mass in each]
        return tuple(itertools.chain.from_iterable(zip(self._velocities(y), accelerations, strict=True)))

    def energy(self, t, y):
        """H = sum of m_i x_i'^2/2, k_i x_i^2/2 and kappa_i (x_(i+1) - x_i)^2/2."""
        found, own = 0.0, (self._all(name, self.bodies) for name in ("mass", "stiffness"))
        for mass, stiffness, x, velocity in zip(*own, y[::2], self._velocities(y), strict=True):
            found = found + (0.5 * mass * velocity * velocity + 0.5 * stiffness * x * x)
        for stiffness, (way, _) in zip(self._all("coupling_stiffness", self.bodies - 1), self._gaps(y), strict=True):
            found = found + 0.5 * stiffness * way * way
        return found

    def powers(self, t, y, drive, frictions):
        """Power of the drive, sum of a_i drive x_i', of all dampers, and of the belt, -v_b times all friction."""
        driven = damped = belt = 0.0
        own = (self._all(name, self.bodies) for name in ("actuation", "damping"))
        for actuation, damping, velocity in zip(*own, self._velocities(y), strict=True):
            driven, damped = driven + actuation * (drive * velocity), damped - damping * velocity * velocity
        for damping, (_, rate) in zip(self._all("coupling_damping", self.bodies - 1), self._gaps(y), strict=True):
            damped = damped - damping * rate * rate
        for friction in frictions:
            belt = belt - self.belt_speed * friction
        return driven, damped, belt

    def mechanism(self, t, y) -> Mechanism | None:
        """Blocks on their wall springs, with a link in every gap."""
        names = ("mass", "stiffness", "damping", "actuation")
        own = zip(y[::2], self._velocities(y), *(self._all(name, self.bodies) for name in names), strict=True)
        bodies = (
            Body(f"body {i + 1}", mass, "slide", place, rate, "", stiffness, damping, actuation, i)
            for i, (place, rate, mass, stiffness, damping, actuation) in enumerate(own)
        )
        gaps = zip(*(self._all(f"coupling_{name}", self.bodies - 1) for name in ("stiffness", "damping")), strict=True)
        links = (Link(f"body {i}", f"body {i + 1}", *each) for i, each in enumerate(gaps, start=1))
        return Mechanism(tuple(bodies), tuple(links))

    def scene(self, t, y) -> tuple[Shape, ...]:
        """Blocks in a row, with the springs between them, under wall springs that hang from where each is at rest."""
        rests = [APART * i for i in range(self.bodies)]
        places = [rest + x for rest, x in zip(rests, y[::2], strict=True)]
        hung = enumerate(zip(rests, places, strict=True), start=1)
        walls = (Shape("spring", f"wall spring {i}", ((rest, WALL), (place, 0.5))) for i, (rest, place) in hung)
        return *row_of_bodies(places, "spring"), *walls


def block_row(blocks: int) -> Any:
    """The class of a row of two to twenty blocks, "two-block-row" and so on."""
    return row_of(BlockRow, blocks)


TwoBlockRow = block_row(2)
ThreeBlockRow = block_row(3)
