"""Rows of two to twenty bodies, each with a contact of its own: crawlers, worms, and blocks on a belt."""

import functools
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, Literal, NamedTuple

from pydantic import model_validator

from vibrocap.physics.machines.machine import ConsistentUnits, NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Spring, Support, coordinate
from vibrocap.physics.names import numbered

WORDS = (
    "two three four five six seven eight nine ten eleven twelve thirteen fourteen fifteen sixteen seventeen eighteen"
)
NUMBERS = dict(enumerate([*WORDS.split(), "nineteen", "twenty"], start=2))


class Numbered(NamedTuple):
    """A parameter of every body or gap, or of the whole row.

    meaning: {} stands for the number of the body or gap   first: the type of that of the first, where it is another
    """

    name: str
    of: Literal["body", "gap", "row"]
    type: Any
    default: float
    symbol: str
    meaning: str
    role: str
    first: Any = None


class Row(ConsistentUnits):
    """Bodies 1, 2, ... in a row, each with a contact of its own; `row_of` makes the class of each number of them."""

    called: ClassVar[tuple[str, str]]  # what a body and the row are: ("body", "crawler") of "two-body-crawler"
    bodies: ClassVar[int]
    summary: ClassVar[str]  # of the class of a number of bodies
    row_parameters: ClassVar[tuple[Numbered, ...]]
    row_counts: ClassVar[Mapping[str, int]]  # of each parameter
    si_load: ClassVar = "1 where the coefficients of the law are forces in N"

    @classmethod
    def of_bodies(cls, bodies: int) -> Mapping[str, Any]:
        """What else of the class depends on the number of bodies."""
        return {}

    def _all(self, *names: str) -> list[list]:
        """Parameters by name, each of every body or gap."""
        return [[getattr(self, numbered(name, i + 1)) for i in range(self.row_counts[name])] for name in names]


@functools.cache
def row_of(kind: type[Row], bodies: int) -> Any:
    """The class of a row of two to twenty bodies, "two-body-crawler" and so on; ValueError for another number."""
    if bodies not in NUMBERS:
        raise ValueError(f"bodies should be a whole number from 2 to {max(NUMBERS)}, got {bodies!r}")
    fields: dict[str, Any] = {}
    types: dict[str, Any] = {}
    counts = {"body": bodies, "gap": bodies - 1, "row": 1}
    for own in kind.row_parameters:
        for i in range(1, counts[own.of] + 1):
            name, symbol = numbered(own.name, i), own.symbol if own.of == "row" else f"{own.symbol}_{i}"
            fields[name] = parameter(own.default, symbol, own.meaning.format(i), own.role)
            types[name] = (own.first if i == 1 else None) or own.type
    words = (NUMBERS[bodies], *kind.called)
    class_name = "".join(word.title() for word in words)
    space = {
        **fields,
        "__annotations__": types,
        "__module__": kind.__module__,
        "__qualname__": class_name,
        "__doc__": f"{words[0].title()} {kind.summary}\n\n    {kind.__doc__}",
        "__reduce__": lambda self: (_made, (kind, bodies, {name: getattr(self, name) for name in fields})),
        "name": "-".join(words),
        "bodies": bodies,
        "row_counts": {own.name: counts[own.of] for own in kind.row_parameters},
        **kind.of_bodies(bodies),
    }
    return parameters(type(class_name, (kind,), space))


def row_called(name: str, kinds: Sequence[type[Row]]) -> Any:
    """The class of a row of one of these kinds by its name, such as "five-body-worm"; KeyError for what is none."""
    known = {"-".join((word, *kind.called)): (kind, number) for kind in kinds for number, word in NUMBERS.items()}
    return row_of(*known[name])


def _made(kind: type[Row], bodies: int, values: dict[str, Any]) -> Any:
    """A machine again, where it was pickled: the classes of more than three bodies can be found in no module."""
    return row_of(kind, bodies)(**values)


class Crawler(Row):
    """Bodies 1, 2, ... in a row on the ground, each with a contact of its own; z_i is how far gap i has opened.

    Body 1 is the rearmost. A positive drive pushes apart; its share a_i may differ in sign from gap to gap. What has no
    number in its name belongs to body 1 or to the first gap. They travel where forward and back, or front and rear,
    differ: by the masses, the loads, the laws or the drive. Any consistent units may be used; loads are forces.
    """

    called: ClassVar = ("body", "crawler")
    source: ClassVar[str] = "zimmermann2009"
    first_case: ClassVar = {"drive.amplitude": 1.0, "drive.frequency": 0.5}
    summary: ClassVar = "bodies in a row, all of them rubbing."
    row_parameters: ClassVar = (
        Numbered("mass", "body", Positive, 1.0, "m", "mass of body {}", "mass"),
        Numbered("stiffness", "gap", NonNegative, 1.0, "k", "spring in gap {}", "stiffness", first=Positive),
        Numbered("damping", "gap", NonNegative, 0.1, "c", "damper in gap {}", "viscous damping"),
        Numbered("actuation", "gap", Number, 1.0, "a", "share of the drive that pushes gap {} apart", "share"),
        Numbered(
            "normal_load", "body", NonNegative, 1.0, "N", "load on the contact of body {}", "load", first=Positive
        ),
    )

    @classmethod
    def of_bodies(cls, bodies: int) -> Mapping[str, Any]:
        """The first gap, body 1, and the other gaps."""
        gaps = {numbered("displacement", i): coordinate("z", f"opening of gap {i}", "m") for i in range(1, bodies)}
        first = gaps.pop("displacement")
        return {"displacement": first, "position": coordinate("X", "place of body 1", "m"), **gaps}

    def parts(self, q):
        places, parts = [q.position], []
        gaps = zip(*self._all("stiffness", "damping", "actuation"), strict=True)
        for i, (stiffness, damping, share) in enumerate(gaps, start=1):
            gap = getattr(q, numbered("displacement", i))
            places.append(places[-1] + gap)
            parts += [Spring(stiffness, gap), Damper(damping, gap), Drive(gap, share)]
        for i, (x, mass, load) in enumerate(zip(places, *self._all("mass", "normal_load"), strict=True), start=1):
            body = Mass(f"body {i}", mass, x=x)
            parts += [body, Contact(body, load=load, speed=numbered("velocity", i))]
        return parts


def crawler(bodies: int) -> Any:
    """The class of a crawler of two to twenty bodies, "two-body-crawler" and so on."""
    return row_of(Crawler, bodies)


TwoBodyCrawler = crawler(2)
ThreeBodyCrawler = crawler(3)


class Worm(Row):
    """Bodies 1, 2, ... in a row on the ground, each with a contact of its own; the drive z(t) imposes their distances.

    Body 1 is the rearmost. Gap i is a_i z(t) wider than at z = 0, whatever force that takes. One coordinate is left
    free, p, the velocity of the common centre of mass, which continues where z' jumps: x_i' = p + u_i z', where u_i is
    a_1 + ... + a_(i-1) less its mean over the masses. This is worm-like locomotion without legs (Chernousko 2002;
    Zimmermann, Zeidis and Bolotnik 2009). It travels where front and rear differ, by masses, loads, laws or a gait, or
    where friction differs between forward and back. Body i at rest holds R_i = M u_i z'' less the friction of all
    others; of bodies that rest together equal shares of their limits are shown (hyperstatic, `contacts.py`).

    The energy is that of the common centre, M p^2/2, and the work of the drive what reaches it, the sum of u_i z' R_i.
    What gap i takes is `actuator_force_i`, the push between the bodies behind and ahead, and the power of all
    `actuator_power`; where z' jumps the force has an impulse besides. Any consistent units may be used.
    """

    called: ClassVar = ("body", "worm")
    source: ClassVar[str] = "chernousko2002; zimmermann2009b"
    summary: ClassVar = "bodies in a row at imposed distances, all of them rubbing."
    row_parameters: ClassVar = (
        Numbered("mass", "body", Positive, 1.0, "m", "mass of body {}", "mass"),
        Numbered("actuation", "gap", Number, 1.0, "a", "share of the drive by which gap {} widens", "share"),
        Numbered("normal_load", "body", Positive, 1.0, "N", "load on the contact of body {}", "load"),
    )
    effort: ClassVar = "displacement"
    position = coordinate("X", "place of body 1", "m", rate="centre_velocity")

    def parts(self, q):
        x, parts = q.position, []
        shares, masses, loads = self._all("actuation", "mass", "normal_load")
        for i, (share, mass, load) in enumerate(zip((0.0, *shares), masses, loads, strict=True), start=1):
            x = x if i == 1 else x + q.imposed(share * q.drive)
            body = Mass(f"body {i}", mass, x=x)
            parts += [body, Contact(body, load=load)]
        return parts

    def scales(self, time=1.0):
        """Distance and speed that all loads give to all bodies in the time of a radian of the drive."""
        mass, load = map(sum, self._all("mass", "normal_load"))
        short = time / (2.0 * math.pi)
        return load / mass * short * short, load / mass * short


def worm(bodies: int) -> Any:
    """The class of a worm of two to twenty bodies, "two-body-worm" and so on."""
    return row_of(Worm, bodies)


TwoBodyWorm = worm(2)
ThreeBodyWorm = worm(3)


@model_validator(mode="after")
def some_block_rubs(row):
    """Refuse a row without any load, which has no natural force; every class of `BlockRow` names this validator."""
    if not any(*row._all("normal_load")):
        raise ValueError(f"normal_load should be > 0 of one block at least, got 0 for all {row.bodies}")
    return row


class BlockRow(Row):
    """Blocks 1, 2, ... in a row on a belt of the speed v_b, with springs and dampers to a wall and to each other.

    One block of it is the `Oscillator`; more are the models of chattering brakes and of earthquakes (Burridge and
    Knopoff 1967; Galvanetto and Bishop 1994; Pascal 2008). x_i is how far block i is from where no spring is stretched,
    v_i its velocity over the belt, exactly zero while it sticks.

    What has no number in its name belongs to block 1 or to the first gap. A row that is pulled over fixed ground by its
    wall springs, whose far ends move at the speed V, is the same system: v_b = -V. A block without load does not rub;
    it needs a law that is set-valued at rest. Any consistent units may be used; loads are forces.
    """

    called: ClassVar = ("block", "row")
    source: ClassVar[str] = "burridge1967; galvanetto1994; pascal2008"
    first_case: ClassVar = {
        "machine.normal_load": 0.7,
        "machine.belt_speed": 0.1,
        "drive.amplitude": 0.2,
        "drive.frequency": 0.5,
    }
    summary: ClassVar = "blocks in a row on a belt, on springs to a wall and to each other."
    belt_speed: Any
    row_parameters: ClassVar = (
        Numbered("mass", "body", Positive, 1.0, "m", "mass of block {}", "mass"),
        Numbered("stiffness", "body", NonNegative, 1.0, "k", "spring of block {} to a wall", "stiffness"),
        Numbered("damping", "body", NonNegative, 0.0, "c", "damper of block {} to a wall", "viscous damping"),
        Numbered("actuation", "body", Number, 1.0, "a", "share of the drive that acts on block {}", "share"),
        Numbered("normal_load", "body", NonNegative, 1.0, "N", "load on block {}; 0: it does not rub", "load"),
        Numbered("coupling_stiffness", "gap", NonNegative, 1.0, "kappa", "spring in gap {}", "stiffness"),
        Numbered("coupling_damping", "gap", NonNegative, 0.0, "gamma", "damper in gap {}", "viscous damping"),
        Numbered("belt_speed", "row", Number, 0.0, "v_b", "speed of the belt under the blocks", "speed"),
    )

    @classmethod
    def of_bodies(cls, bodies: int) -> Mapping[str, Any]:
        """The coordinates, block by block."""
        position = coordinate("x", "place of each block", "m", rate="sliding_velocity", count=bodies)
        return {"position": position, "_loads": some_block_rubs}

    def parts(self, q):
        belt = Support("belt", x=self.belt_speed * q.time)
        parts, blocks, gaps = [belt], [], [b - a for a, b in itertools.pairwise(q.position)]
        own = self._all("mass", "stiffness", "damping", "actuation", "normal_load")
        for i, (x, mass, stiffness, damping, share, load) in enumerate(zip(q.position, *own, strict=True), start=1):
            blocks.append(Mass(f"body {i}", mass, x=x))
            parts += [blocks[-1], Spring(stiffness, x), Damper(damping, x), Drive(x, share)]
            parts += [Contact(blocks[-1], on=belt, load=load)]
        between = zip(gaps, *self._all("coupling_stiffness", "coupling_damping"), strict=True)
        for gap, stiffness, damping in between:
            parts += [Spring(stiffness, gap), Damper(damping, gap)]
        return parts

    def sized_by(self):
        """The stiffness of all springs to the wall together."""
        return sum(*self._all("stiffness"))


def block_row(blocks: int) -> Any:
    """The class of a row of two to twenty blocks, "two-block-row" and so on."""
    return row_of(BlockRow, blocks)


TwoBlockRow = block_row(2)
ThreeBlockRow = block_row(3)
