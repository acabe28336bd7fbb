"""The contract of a friction law, clause by clause: each takes a law and returns its fault, or None."""

import math
import sys
from typing import Any

from vibrocap.contracts.samples import draws, mirrored, random_motion, settled_pieces
from vibrocap.numerics.expressions.graph import Graph, derivative, evaluate
from vibrocap.physics.friction.law import Law

EPSILON = sys.float_info.epsilon
SAMPLES = 25
PASSIVE_SAMPLES = 100
NEAR = 1e-6  # a speed so small that a smooth force is linear below it


def declarations(law: Any) -> str | None:
    """What it declares fits together."""
    cls = type(law)
    fields = set(cls.__pydantic_fields__)
    for what, names, known in (
        ("shape_parameters", law.shape_parameters, fields),
        ("switched", law.switched, set(law.internal)),
    ):
        if not isinstance(names, tuple) or not set(names) <= known:
            return f"{what}: should be a tuple of names among {', '.join(sorted(known)) or 'none'}, got {names!r}"
    if not isinstance(law.internal, tuple) or len(set(law.internal)) != len(law.internal):
        return f"internal: should be a tuple of names, each once, got {law.internal!r}"
    if law.internal_symmetry is not None and len(law.internal_symmetry) != len(law.internal):
        return f"internal_symmetry: should have a sign for each of {law.internal}, got {law.internal_symmetry}"
    if law.kind != "kinked" and law.internal:
        return f"kind: is {law.kind!r}, but a law with internal states is 'kinked'"
    for name in ("creeps", "symmetric", "passive"):
        if not isinstance(getattr(law, name), bool):
            return f"{name}: should be True or False, got {getattr(law, name)!r}"
    return None


def finite(law: Any) -> str | None:
    """Force, rates, guards and losses are finite, at any speed, and as many as there are states."""
    if len(scales := law.internal_scales(1.0)) != len(law.internal):
        return f"internal_scales: gives {len(scales)} sizes for the {len(law.internal)} states in internal"
    if len(rates := law.force(0.1, (0.0,) * len(law.internal), 1, 1.0)[1]) != len(law.internal):
        return f"force: gives {len(rates)} rates for the {len(law.internal)} states in internal"
    for draw in draws(SAMPLES):
        velocity, internal, side, load = random_motion(law, draw)
        scales = law.internal_scales(load)
        for speed in (velocity, 0.0, side * 1e-300, side * 1e3):
            force, rates = law.force(speed, internal, side, load)
            guards = law.switches(speed, internal, side, load)
            values = (force, *rates, *guards, *law.losses(speed, internal, side, load))
            if not all(map(math.isfinite, values)):
                where = f"velocity {speed:g}, states {internal}, load {load:g}"
                return f"force, rates, guards and losses: are {values} at {where}"
        if not math.isfinite(law.steady_force(abs(velocity), load)):
            return f"steady_force({abs(velocity):g}, {load:g}) is {law.steady_force(abs(velocity), load)}"
        if not all(scale > 0.0 for scale in scales):
            return f"internal_scales: should be positive, got {scales}"
    return None


def symmetric(law: Any) -> str | None:
    """Friction is the same in both directions, exactly, unless `symmetric` says that it is not."""
    different = 0
    for draw in draws(SAMPLES):
        velocity, internal, side, load = random_motion(law, draw)
        there, back = (velocity, internal, side, load), (-velocity, mirrored(law, internal), -side, load)
        (force, rates), (mirror, mirror_rates) = law.force(*there), law.force(*back)
        if law.stored_energy(back[1]) != law.stored_energy(internal):
            return f"stored_energy: is not the same for {internal} and its mirror image {back[1]}"
        if not law.symmetric:
            different += mirror != -force or law.losses(*back) != law.losses(*there)
            continue
        if (mirror, mirrored(law, mirror_rates)) != (-force, rates):
            return (
                f"force: is {force!r} at velocity {velocity:g}, but {mirror!r} at {-velocity:g} on the other side, "
                "which should be the same with the other sign, exactly; use side and side * velocity, or let "
                "`symmetric` be False"
            )
        if law.losses(*back) != law.losses(*there):
            return f"losses: are {law.losses(*there)} one way and {law.losses(*back)} the other way"
        if _outcomes(law, *back, mirror=True) != _outcomes(law, *there):
            return f"switches, after_switch: are not the mirror image of each other at {there} and {back}"
        if mirrored(law, law.after_reversal(back[1], side, load)) != law.after_reversal(internal, -side, load):
            return f"after_reversal: is not its own mirror image at {internal}"
    if not law.symmetric and not different:
        return "symmetric: is False, but friction is the same in both directions"
    return None


def _outcomes(law: Any, velocity: float, internal: tuple, side: int, load: float, mirror: bool = False) -> list:
    """Every guard with the states after it, in an order that does not depend on their numbers."""
    guards = law.switches(velocity, internal, side, load)
    after = [law.after_switch(i, velocity, internal, side, load) for i in range(len(guards))]
    return sorted(zip(guards, (mirrored(law, states) if mirror else states for states in after), strict=True))


def kind(law: Any) -> str | None:
    """At rest it is what its kind says: what it holds, and no jump of a force that goes on."""
    if law.kind == "set-valued":
        forward, back = (law.force(0.0, (), side, 1.3)[0] for side in (1, -1))
        middle, limit = law.holding_centre(1.3), law.holding_limit(1.3)
        if not middle - limit - 4 * EPSILON <= back < 0.0 < forward <= middle + limit + 4 * EPSILON:
            return (
                f"holding_limit: at rest it holds from {middle - limit:g} to {middle + limit:g}, but slides with "
                f"{back:g} and {forward:g} as the speed vanishes (load 1.3); the holding limit is at least the sliding "
                "force, or the contact could neither stick nor slide"
            )
        if (middle == 0.0) != law.symmetric:
            return f"holding_centre: is {middle:g}, while `symmetric` is {law.symmetric}"
        return None
    bends = 0
    for draw in draws(10):
        _, internal, _, load = random_motion(law, draw)
        differences = []
        for side in (1, -1):
            pieces = settled_pieces(law, 0.0, law.after_reversal(internal, side, load), side, load)
            ends = (law.force(v, pieces, side, load) for v in (0.0, NEAR * side))
            at_rest, ahead = ((force, *rates) for force, rates in ends)
            differences.append((at_rest[0], [after - before for before, after in zip(at_rest, ahead, strict=True)]))
        (forward, ahead), (back, behind) = differences
        if forward != back:
            return (
                f"kind: is {law.kind!r}, but the force jumps at rest, from {back:g} to {forward:g} at load {load:g}; a "
                "law that jumps there is 'set-valued', with a holding_limit"
            )
        bends += any(abs(a + b) > 1e-14 + 1e-3 * abs(b) for a, b in zip(ahead, behind, strict=True))
    if law.name.startswith("smoothed-"):  # of a smoothed law at most the second derivative jumps, like v |v|
        return None
    if law.kind == "smooth" and bends:
        return "kind: is 'smooth', but the force or a rate has a kink at rest; a law with a kink is 'kinked'"
    if law.kind == "kinked" and not bends and type(law).switches is Law.switches:
        return "kind: is 'kinked', but neither the force nor a rate has a kink at rest; a law without one is 'smooth'"
    return None


def energy(law: Any) -> str | None:
    """Its energy balance closes: R v = d(stored)/dt + contact sliding + bristle loss."""
    for draw in draws(SAMPLES):
        velocity, internal, side, load = random_motion(law, draw)
        graph = Graph()
        z = tuple(graph.node("state", i) for i in range(len(internal)))
        stored = graph.expression(law.stored_energy(z))
        slopes = evaluate([derivative(stored, i) for i in range(len(z))], 0.0, internal, side, ())
        force, rates = law.force(velocity, internal, side, load)
        growth = [slope * rate for slope, rate in zip(slopes, rates, strict=True)]
        losses = law.losses(velocity, internal, side, load)
        size = abs(force * velocity) + sum(map(abs, growth)) + sum(map(abs, losses))
        if not abs(force * velocity - sum(growth) - sum(losses)) <= 16 * EPSILON * size:
            return (
                f"losses, stored_energy: the contact takes in {force * velocity:g}, stores {sum(growth):g} and loses "
                f"{sum(losses):g} (velocity {velocity:g}, states {internal}); the first should be the sum of the others"
            )
    return None


def passive(law: Any) -> str | None:
    """It never gives energy, where `passive` says so."""
    # the claim of a law to be passive need not rest on its own split, see `BoucWen.passive`
    if not law.passive or getattr(law, "elastic_shape", 0.0) > getattr(law, "dissipative_shape", 0.0):
        return None
    for draw in draws(PASSIVE_SAMPLES):
        motion = random_motion(law, draw)
        if not sum(law.losses(*motion)) >= -4 * EPSILON * abs(law.force(*motion)[0] * motion[0]):
            return (
                f"passive: is True, but the law gives {-sum(law.losses(*motion)):g} at velocity {motion[0]:g}, states "
                f"{motion[1]}, load {motion[3]:g}"
            )
    return None


def steady(law: Any) -> str | None:
    """The steady force is that at a constant velocity (of a law with internal states it is not compared)."""
    if law.internal or not law.symmetric:
        return None
    for draw in draws(SAMPLES):
        velocity, _, side, load = random_motion(law, draw)
        velocity += 0.1 * side
        force, expected = law.force(velocity, (), side, load)[0], side * law.steady_force(abs(velocity), load)
        if not abs(force - expected) <= 1e-7 * abs(expected):
            return f"steady_force: is {abs(expected):g} at the speed {abs(velocity):g}, but force gives {abs(force):g}"
    return None


def pieces(law: Any) -> str | None:
    """Its pieces change whole numbers only, and do not chatter."""
    switched = [i for i, name in enumerate(law.internal) if name in law.switched]
    for draw in draws(SAMPLES):
        velocity, internal, side, load = random_motion(law, draw)
        _, rates = law.force(velocity, internal, side, load)
        for i in switched:
            if type(rates[i]) is not float or rates[i] != 0.0:
                return f"force: the rate of the switched state {law.internal[i]} should be 0.0, got {rates[i]!r}"
            if internal[i] not in (-1.0, 0.0, 1.0):
                return f"after_switch: {law.internal[i]} should be -1.0, 0.0 or 1.0, got {internal[i]!r}"
        for which, guard in enumerate(law.switches(velocity, internal, side, load)):
            after = law.after_switch(which, velocity, internal, side, load)
            if len(after) != len(internal):
                return f"after_switch: gives {len(after)} states, of {len(internal)}"
            if after == internal and guard != 1.0:
                return f"after_switch: guard {which} changes nothing at {internal}"
        settled_pieces(law, 0.0, law.after_reversal(internal, -side, load), -side, load)
    if law.switched and not law.switches(0.1, (0.0,) * len(law.internal), 1, 1.0):
        return "switches: there is none, though `switched` names states"
    return None


LAW_CLAUSES = (declarations, finite, symmetric, kind, energy, passive, steady, pieces)
