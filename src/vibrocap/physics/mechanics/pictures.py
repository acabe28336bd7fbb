"""The bodies and joints of what a machine is made of, for programs of rigid bodies, and what is drawn of it."""

import dataclasses
from collections.abc import Callable
from typing import Any

from vibrocap.physics.bodies import Body, Link, Mechanism, Shape
from vibrocap.physics.mechanics.parts import Mass, Point, Support, as_sum
from vibrocap.physics.mechanics.quantities import Quantity
from vibrocap.physics.mechanics.sums import Sum, total, written

SIZES = ("mass", "place", "rate", "stiffness", "damping", "actuation")


def mechanism_of(motion: Any) -> Mechanism | None:
    """Bodies on slides and on hinges of the length 1; None where a part is neither at a joint nor between bodies."""
    if motion.imposes or motion.stops or any(isinstance(each, Point) for each in motion.bodies):
        return None
    used: set[int] = set()

    def sum_of(parts: list, path: Callable[[Any], Quantity], size: str, *wanted: Quantity) -> Any:
        found = [each for each in parts for own in wanted if _same(path(each), own)]
        used.update(map(id, found))
        return written(total(as_sum(getattr(each, size)) for each in found))

    def own_parts(joint: Quantity, *carried: Quantity) -> tuple:
        return (
            sum_of(motion.springs, lambda each: motion.stretches[id(each)], "stiffness", joint),
            sum_of(motion.dampers, lambda each: Quantity.of(each.stretch), "damping", joint),
            sum_of(motion.drives, lambda each: Quantity.of(each.path), "share", joint, *carried),
        )

    if any(isinstance(each.on, Mass) for each in motion.contacts):
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
        contact = next((c for c, each in enumerate(motion.contacts) if each.body is m), None)
        size = written(as_sum(m.mass)), written(path.value), written(path.rate)
        own, carrier = own_parts(path, *through), m.on.name if m.on else ""
        bodies.append(Body(m.name, size[0], kind, size[1], size[2], carrier, *own, contact=contact))
    for i, a in enumerate(motion.masses):
        for b in motion.masses[i + 1 :]:
            between = () if a.on or b.on else own_parts(b.along - a.along)
            links += [Link(a.name, b.name, *between)] if any(each != 0.0 for each in between) else []
    parts = (*motion.springs, *motion.dampers, *motion.drives, *motion.potentials)
    return Mechanism(tuple(bodies), tuple(links)) if all(id(each) in used for each in parts) else None


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


def mechanism_results(mechanism: Mechanism | None) -> Any:
    """The formulas of a mechanism, in tuples."""
    if mechanism is None:
        return None
    bodies = tuple(tuple(getattr(each, name) for name in SIZES) for each in mechanism.bodies)
    return bodies, tuple((each.stiffness, each.damping, each.actuation) for each in mechanism.links)


def filled(mechanism: Mechanism, results: tuple) -> Mechanism:
    """The mechanism with values in place of formulas."""
    bodies, links = results
    return Mechanism(
        tuple(
            dataclasses.replace(each, **dict(zip(SIZES, values, strict=True)))
            for each, values in zip(mechanism.bodies, bodies, strict=True)
        ),
        tuple(
            dataclasses.replace(each, stiffness=k, damping=c, actuation=a)
            for each, (k, c, a) in zip(mechanism.links, links, strict=True)
        ),
    )


def scene_of(motion: Any) -> tuple[Shape, ...]:
    """A box for each body that rubs, a disc for each other one, a rod or a spring to what it stands on."""
    rubs = {id(each.body) for each in motion.contacts}
    found = []
    for m in motion.masses:
        x, z = written(m.along.value), written(m.height.value)
        if not isinstance(m, Mass):  # what turns only is shown by its angle
            x, z = written(m.turn.value), 0.0
        if id(m) in rubs:
            found.append(Shape("box", m.name, ((x, written(Sum.of(z) + 0.25)),), (1.3, 0.5)))
            found.append(Shape("contact", f"contact of {m.name}", ((x, z),), (1.2, 0.0)))
        else:
            found.append(Shape("disc", m.name, ((x, written(Sum.of(z) + 0.5)),), (0.3, 0.3)))
        if isinstance(m.on, Mass):
            kind = "rod" if Quantity.of(m.z).moves else "spring"
            foot = written(m.on.along.value), written(m.on.height.value + 0.5)
            found.append(Shape(kind, f"link of {m.name}", (foot, (x, written(Sum.of(z) + 0.5)))))
    return tuple(found)
