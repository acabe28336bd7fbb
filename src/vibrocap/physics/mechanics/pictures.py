"""The bodies of a machine: as a mechanism, for programs of rigid bodies, and as a scene, for pages and films.

The mechanism says in other words what the equations of the machine say: its bodies, on what they move and their joints.
The tests compare energy, momentum and power of both, and accelerations with those of MuJoCo. The scene is what is drawn
at a state, as plain data: shapes whose coordinates are numbers, or expressions of the state where it is recorded.
Lengths are those of the equations; x is along the line of sliding, y upwards from the ground.
"""

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any, Literal

from vibrocap.physics.elementary import cos, sin
from vibrocap.physics.mechanics.parts import Contact, Damper, Mass, Point, Support, as_sum
from vibrocap.physics.mechanics.quantities import Quantity
from vibrocap.physics.mechanics.speeds import TIME
from vibrocap.physics.mechanics.sums import Sum, total, written

APART = 5.0  # of the middles of neighbours that would stand in one another, where no gap has opened
WALL = 2.0  # height from which their springs to a wall hang
# A stop of a body that turns is from here to there on a line through its pivot, on an arm from beside the pivot; the
# body touches it when its middle is that angle before it.
CORNER, STOP, TOUCHING = 0.6, (0.8, 1.2), math.asin(0.15)


@dataclasses.dataclass(frozen=True)
class Body:
    """A body and the joint on which it moves.

    name: that of its shape in the scene. mass: of all of it, at one point.
    joint: "slide" (moves along the line) or "hinge" (turns about a hinge on its carrier, a mass at the distance 1 from
        it; the angle from upright, positive backwards)
    place, rate: of the joint, at the state that was asked for; relative to the carrier
    carrier: name of the body on which it moves, which stands before it; "": the ground
    stiffness, damping: of the spring, not stretched at place 0, and of the viscous damper at the joint
    actuation: share of the drive that acts at the joint
    contact: the number of the contact between body and ground, from 0; None: it does not rub
    """

    name: str
    mass: Any
    joint: Literal["slide", "hinge"] = "slide"
    place: Any = 0.0
    rate: Any = 0.0
    carrier: str = ""
    stiffness: Any = 0.0
    damping: Any = 0.0
    actuation: Any = 0.0
    contact: int | None = None


@dataclasses.dataclass(frozen=True)
class Link:
    """A spring, a damper and a share of the drive between two sliding bodies; a positive drive pushes them apart.

    The spring is not stretched where the places of both bodies are equal.
    """

    behind: str
    ahead: str
    stiffness: Any = 0.0
    damping: Any = 0.0
    actuation: Any = 0.0


@dataclasses.dataclass(frozen=True)
class Mechanism:
    """Bodies, carriers before what they carry, and links between them."""

    bodies: tuple[Body, ...]
    links: tuple[Link, ...] = ()


Kind = Literal["box", "disc", "rod", "spring", "hinge", "contact"]


@dataclasses.dataclass(frozen=True)
class Shape:
    """One shape of a scene.

    kind: "box" (a body: centre, width and height), "disc" (a body: centre and diameter), "rod" and "spring" (from one
        point to another), "hinge" (a point), "contact" (the point of a body at which friction acts, and its width)
    name: what it is, in words
    points: (x, y) of each point of the machine, one or two, in the lengths of the equations
    size: (width, height), in units of drawing; zero where it has none
    box: of a disc the box in which it slides, of a spring that at whose wall it begins, of a contact that above it: a
        box is drawn as wide as what slides in it needs
    aside: how far from each point it is drawn, in units of drawing; by default there
    """

    kind: Kind
    name: str
    points: tuple[tuple[Any, Any], ...]
    size: tuple[float, float] = (0.0, 0.0)
    box: str = ""
    aside: tuple[tuple[Any, Any], ...] = ()

    def places(self, length: float = 1.0) -> tuple[tuple[Any, Any], ...]:
        """Where it is drawn, in units of drawing of this length."""
        beside = self.aside or ((0.0, 0.0),) * len(self.points)
        drawn = zip(self.points, beside, strict=True)
        return tuple((x / length + right, z / length + up) for (x, z), (right, up) in drawn)


def mechanism_of(motion: Any) -> tuple | None:
    """Fields of bodies and links, on slides and on hinges of the length 1; None where a part has no place there."""
    if motion.imposes or motion.stops or motion.own or any(isinstance(body, Point) for body in motion.bodies):
        return None
    if any(each.slope(TIME) for part, each in motion.everything() if not isinstance(part, (Contact, Support))):
        return None
    if motion.moving_loads and not all(c.load == "dynamic" and not c.scaled for c in motion.contacts):
        return None
    used: set[int] = set()
    dampers = [damper for damper in motion.dampers if isinstance(damper, Damper)]

    def sum_of(parts: list, path: Callable[[Any], Quantity], size: str, *wanted: Quantity) -> Any:
        of_path = [part for part in parts for own in wanted if _same(path(part), own)]
        used.update(map(id, of_path))
        return written(total(as_sum(getattr(entry, size)) for entry in of_path))

    def own_parts(joint: Quantity, *carried: Quantity) -> tuple:
        return (
            sum_of(motion.springs, lambda part: motion.stretches[id(part)], "stiffness", joint),
            sum_of(dampers, lambda part: Quantity.of(part.stretch), "damping", joint),
            sum_of(motion.drives, lambda part: Quantity.of(part.path), "share", joint, *carried),
        )

    if any(isinstance(contact.on, Mass) for contact in motion.contacts):
        return None
    bodies, links, joints = [], [], {}
    for m in motion.masses:
        joint = _joint(motion, m)
        if joint is None or isinstance(m.on, Support):
            return None
        kind, path = joint
        joints[m] = kind, path
        through = [b.along for b in motion.masses if b is not m and b.stands_on(m)] if kind == "slide" else []
        through += [m.along] if m.on is not None and kind == "slide" else []
        contact = next((c for c, contact in enumerate(motion.contacts) if contact.body is m), None)
        size = written(as_sum(m.mass)), written(path.value), written(path.rate)
        own, carrier = own_parts(path, *through), m.on.name if m.on else ""
        bodies.append(Body(m.name, size[0], kind, size[1], size[2], carrier, *own, contact=contact))
    for i, a in enumerate(motion.masses):
        for b in motion.masses[i + 1 :]:
            between = () if a.on or b.on else own_parts(b.along - a.along)
            links += [Link(a.name, b.name, *between)] if any(entry != 0.0 for entry in between) else []
    parts = (*motion.springs, *motion.dampers, *motion.drives, *motion.potentials)
    mechanism = tuple(map(fields_of, bodies)), tuple(map(fields_of, links))
    return mechanism if all(id(part) in used for part in parts) else None


def _joint(motion: Any, m: Any) -> tuple[Any, Quantity] | None:
    """("slide" or "hinge", how far): on which a body moves, relative to what it stands on; None: on no such joint."""
    if not isinstance(m, Mass) or as_sum(m.inertia) or Quantity.of(m.angle).moves:
        return None
    x, z = Quantity.of(m.x), Quantity.of(m.z)
    if not z.moves:
        return "slide", x
    for name in motion.names:
        own = motion.along[name]
        if _same(x, -1.0 * own.sin()) and _same(z, own.cos()):
            return "hinge", own
    return None


def _same(a: Quantity, b: Quantity) -> bool:
    return a.value == b.value and all(a.slope(i) == b.slope(i) for i in {**a.slopes, **b.slopes})


def places_of(motion: Any) -> tuple:
    """(x, z) of every body and point, in the order of the parts."""
    return tuple(_at(body.along.value, body.height.value) for body in motion.bodies)


def fields_of(record: Any) -> tuple:
    """The values of a record's fields."""
    return tuple(getattr(record, field.name) for field in dataclasses.fields(record))


def scene_of(motion: Any) -> tuple[Shape, ...]:
    """A box for each body that rubs, with the masses that slide in it, discs on rods for those that turn; stops.

    Bodies on the ground that would stand in one another stand in a row, joined by springs and imposed distances.
    """
    row = _row(motion)
    own = (shape for m in motion.masses for shape in (*_body(motion, m, row), *_joint_shapes(motion, m, row)))
    return (*own, *_between(motion, row))


def _row(motion: Any) -> dict[Any, float]:
    """Bodies that rub on the ground or on a support, each with how far ahead of its place it is drawn."""
    rubs = (contact.body for contact in motion.contacts if not isinstance(contact.on, Mass))
    bodies = [*dict.fromkeys(rub for rub in rubs if isinstance(rub, Mass) and not isinstance(rub.on, Mass))]
    places = (body.along.value.terms.items() for body in bodies)
    still = [[term for term in terms if motion._constant([Sum(dict([term]))])] for terms in places]
    return {body: APART * still[:i].count(still[i]) for i, body in enumerate(bodies)}


@dataclasses.dataclass(frozen=True)
class _Place:
    """A point of the machine, and how far beside it something is drawn."""

    x: Any
    z: Any
    right: float = 0.0
    up: float = 0.0

    def beside(self, right: float = 0.0, up: float = 0.0) -> "_Place":
        return dataclasses.replace(self, right=self.right + right, up=self.up + up)


def _shape(kind: Any, name: str, *places: _Place, size: tuple[float, float] = (0.0, 0.0), box: str = "") -> Shape:
    points = tuple(_at(place.x, place.z) for place in places)
    return Shape(kind, name, points, size, box, tuple((place.right, place.up) for place in places))


def _between(motion: Any, row: dict[Any, float]) -> Iterator[Shape]:
    """What joins bodies of a row: springs, and rods as long as the drive makes them."""
    links: list[tuple[Any, Quantity]] = [("spring", stretch) for stretch in motion.stretches.values()]
    links += [("rod", each) for each in motion.imposed]
    for a, b in itertools.combinations(row, 2):
        for kind in dict.fromkeys(kind for kind, path in links if not (path - (b.along - a.along)).moves):
            ends = _place(a, row).beside(0.5, 0.25), _place(b, row).beside(-0.5, 0.25)
            yield _shape(kind, f"{kind} between {a.name} and {b.name}", *ends)


def _place(m: Any, row: dict[Any, float]) -> _Place:
    """Where a body is drawn; of one that turns only its angle, as a place."""
    base = m
    while isinstance(base.on, Mass):
        base = base.on
    return (
        _Place(m.along.value, m.height.value, row.get(base, 0.0))
        if isinstance(m, Mass)
        else _Place(m.turn.value, Sum())
    )


def _body(motion: Any, m: Any, row: dict[Any, float]) -> Iterator[Shape]:
    """A box with its contact, large enough for what is in it or on it; a disc for what does not rub."""
    place, rubs = _place(m, row), [contact.body for contact in motion.contacts]
    carried = [mass for mass in motion.masses if mass.on is m]
    if m not in rubs:
        inside = m.on.name if _slides(m) else ""
        yield _shape("disc", m.name, place.beside(up=0.4 if inside else 0.5), size=(0.3, 0.3), box=inside)
        return
    width, height = (1.8, 0.8) if any(map(_slides, carried)) else (1.3 if carried else 1.0, 0.5)
    yield _shape("box", m.name, place.beside(up=0.5 * height), size=(width, height))
    name = "contact" if len(rubs) == 1 else f"contact {rubs.index(m) + 1}"
    yield _shape("contact", name, place, size=(width - 0.1, 0.0), box=m.name)


def _joint_shapes(motion: Any, m: Any, row: dict[Any, float]) -> Iterator[Shape]:
    """The rod and the hinge on which a body turns; or the spring on which it slides, and its stops."""
    place = _place(m, row)
    if isinstance(m.on, Mass) and not _slides(m):
        pivot = _place(m.on, row).beside(up=0.5)
        yield _shape("rod", f"rod of {m.name}", pivot, place.beside(up=0.5))
        yield _shape("hinge", f"pivot of {m.name}", pivot)
        kind, angle = _joint(motion, m) or ("", Quantity(0.0))
        for stop in motion.stops:
            if kind == "hinge" and _same(stop.way, angle):
                yield from _stops_of_hinge(stop, pivot)
        return
    half, height = (0.5, 0.25) if m.on is None else (0.15, 0.4)
    foot = _Place(Sum(), place.z, -2.5) if m.on is None else _place(m.on, row).beside(-0.9)
    if any(_same(stretch, Quantity.of(m.x)) for stretch in motion.stretches.values()):
        ends = foot.beside(up=height), place.beside(-half, height)
        if any(row.values()) and m in row:
            ends = _Place(Sum(), Sum(), row[m], WALL), place.beside(up=2.0 * height)
        yield _shape("spring", f"spring of {m.name}", *ends, box=m.on.name if m.on else "")
    for stop in motion.stops:
        if _same(stop.way, Quantity.of(m.x)):
            free = dataclasses.replace(place, x=place.x - stop.way.value)
            for name, side, gap in (("in front", 1.0, stop.gap), ("behind", -1.0, stop.back_gap)):
                if gap is not None:
                    at = dataclasses.replace(free, x=free.x + side * as_sum(gap)).beside(side * half)
                    yield _shape("rod", f"stop {name}", at.beside(up=0.2), at.beside(up=0.6))


def _stops_of_hinge(stop: Any, pivot: _Place) -> Iterator[Shape]:
    """The stops of a body that turns about a pivot at the distance 1, each with its arm."""
    for side, name, gap in ((1.0, "behind", stop.gap), (-1.0, "in front", stop.back_gap)):
        if gap is not None:
            sine, cosine = sin(as_sum(gap) + TOUCHING), cos(as_sum(gap) + TOUCHING)
            near, far = (
                dataclasses.replace(pivot, x=pivot.x - side * (distance * sine), z=pivot.z + distance * cosine)
                for distance in STOP
            )
            corner = dataclasses.replace(pivot, x=pivot.x - side * CORNER)
            yield _shape("rod", f"stop {name}", near, far)
            yield _shape("rod", f"arm of the stop {name}", corner, near)


def _slides(m: Any) -> bool:
    """Whether a body moves to and fro in the one on which it stands."""
    return isinstance(m, Mass) and m.on is not None and not Quantity.of(m.z).moves


def _at(x: Any, z: Any) -> tuple[Any, Any]:
    return written(x), written(z)
