"""The contract of a machine, clause by clause: each takes a machine and says what is wrong, or None."""

import math
import sys
from collections.abc import Callable, Iterator
from typing import Any

from vibrocap.contracts.samples import ImposedSample, draws, machine_draw
from vibrocap.numerics.expressions.graph import Graph, derivative, evaluate

# of friction and of surroundings, and what else stands beside works
OTHERS_CHANNELS = (
    *("contact_sliding", "bristle_loss", "contact_storage", "drag", "outer_force", "gravity"),
    *("stored", "residual", "window", "periods", "own"),
)
EPSILON = sys.float_info.epsilon
SAMPLES = 60


def _moving(machine: Any, count: int = SAMPLES) -> Iterator[tuple]:
    """(machine, t, state, drive, force) at random; a machine whose motion is imposed is driven by a sample of one."""
    driven = machine.driven_by(ImposedSample())
    for draw in draws(count):
        yield driven, *machine_draw(driven, draw)


def declarations(machine: Any) -> str | None:
    """What it declares fits together."""
    states = machine.states
    if not isinstance(states, tuple) or len(set(states)) != len(states):
        return f"states: should be a tuple of names, each once, got {states!r}"
    for what in ("cyclic", "contact_state", "place"):
        name = getattr(machine, what)
        if name not in states and not (name is None and what != "contact_state"):
            return f"{what}: should be one of {', '.join(states)}, got {name!r}"
    if machine.cyclic is None and machine.place is None:
        return "place: a machine without a cyclic state names the state that is the place of its contact"
    if len(machine.symmetry) != len(states) or set(machine.symmetry) - {1, -1}:
        return f"symmetry: should be +1 or -1 for each of {', '.join(states)}, got {machine.symmetry!r}"
    channels = machine.channels
    if not isinstance(channels, tuple) or len(set(channels)) != len(channels) or "drive" not in channels:
        return f"channels: should be a tuple of names, each once, among them 'drive', got {channels!r}"
    if taken := [name for name in channels if name in OTHERS_CHANNELS or not str(name).isidentifier()]:
        return f"channels: {taken[0]!r} is no name for one, or is one of friction, surroundings or balances"
    if strange := [name for name in machine.strikes_ground if name not in machine.switch_events]:
        return f"strikes_ground: names {strange[0]!r}, which is none of switch_events, {machine.switch_events!r}"
    return None


def held_at_rest(given: Any) -> str | None:
    """With friction = holding_force the contact's acceleration is exactly zero, and friction works against it."""
    contact = given.states.index(given.contact_state)
    for machine, t, y, drive, _ in _moving(given):
        hold = machine.holding_force(t, y, drive)
        moving = explicit_rate(machine.contact_velocity, t, y)  # of a contact that an imposed motion moves
        found = machine.rates(t, y, drive, hold)[contact] + moving
        if not abs(found) <= 4 * EPSILON * abs(moving):
            return (
                f"rates: with force = holding_force the rate of {machine.contact_state} should be exactly 0, got "
                f"{found:g}; write the acceleration as (holding force - R) over an inertia"
            )
        more, less = (machine.rates(t, y, drive, hold + change)[contact] + moving for change in (0.1, -0.1))
        if not more < 0.0 < less:
            return f"rates: more friction than holding_force should slow {machine.contact_state} down, got {more:g}"
    return None


def contact(given: Any) -> str | None:
    """The contact state moves one to one with the contact velocity."""
    place = given.states.index(given.contact_state)
    for machine, t, y, _, _ in _moving(given, 10):
        moved = tuple(v + 0.25 if i == place else v for i, v in enumerate(y))
        found = machine.contact_velocity(t, moved) - machine.contact_velocity(t, y)
        if not abs(found - 0.25) <= 8 * EPSILON * max(1.0, *map(abs, y)):
            return f"contact_velocity: changes by {found:g} where {machine.contact_state} changes by 0.25"
    return None


def along(function: Callable, states: int) -> Callable[[float, tuple, Any], float]:
    """d/dt of a function of the mechanical state, of (t, state, rates): by its partial derivatives, recorded once.

    None of it by the time.
    """
    graph = Graph()
    recorded = graph.expression(function(graph.node("time"), tuple(graph.node("state", i) for i in range(states))))
    partial = [derivative(recorded, i) for i in range(states)]

    def growth(t: float, y: tuple, rates: Any) -> float:
        slopes = evaluate(partial, t, y, 1.0, ())
        return sum(slope * rate for slope, rate in zip(slopes, rates, strict=True))

    return growth


def explicit_rate(function: Callable, t: float, y: tuple) -> float:
    """Partial derivative by the time of a function of time and state."""
    graph = Graph()
    recorded = graph.expression(function(graph.node("time"), y))
    return float(evaluate([derivative(recorded, -1)], t, y, 1.0, ())[0])


def _frictions(machine: Any, force: float) -> tuple[float, ...]:
    """A friction force at each contact, that of the first being `force`."""
    return (force, *(0.4 - 0.3 * i - 0.7 * force for i in range(len(machine.contacts))))


def energy(given: Any) -> str | None:
    """Its energy balance closes: H' = sum of the powers - R v of every contact."""
    growth = along(given.driven_by(ImposedSample()).energy, len(given.states))
    for machine, t, y, drive, force in _moving(given):
        frictions = _frictions(machine, force)
        rates, powers = machine.rates(t, y, drive, *frictions), machine.powers(t, y, drive, *frictions)
        if len(rates) != len(machine.states) or len(powers) != len(machine.channels):
            return (
                f"rates, powers: should be {len(machine.states)} and {len(machine.channels)} numbers, one for each of "
                f"states and channels, got {len(rates)} and {len(powers)}"
            )
        velocities = (machine.contact_velocity(t, y), *machine.further_velocities(t, y))
        expected = sum(powers) - sum(force * v for force, v in zip(frictions, velocities, strict=True))
        found, size = growth(t, y, rates), max(map(abs, (*rates, *powers, 1.0))) ** 2
        if not abs(found - expected) <= 16 * EPSILON * size:
            told = f"the energy grows by {found:g}, the powers less R v of every contact are {expected:g}"
            return f"energy, powers: {told}; they should be equal ({_place(y, drive, force)})"
    return None


def momentum(given: Any) -> str | None:
    """Its momentum balance closes: p' = outer force - R of every contact."""
    growth = along(given.driven_by(ImposedSample()).momentum, len(given.states))
    for machine, t, y, drive, force in _moving(given):
        frictions = _frictions(machine, force)
        rates, powers = machine.rates(t, y, drive, *frictions), machine.powers(t, y, drive, *frictions)
        expected = machine.outer_force(t, y, drive) + machine.wall_force(t, y, drive, force) - sum(frictions)
        found, size = growth(t, y, rates), max(map(abs, (*rates, *powers, 1.0))) ** 2
        if not abs(found - expected) <= 16 * EPSILON * size:
            told = f"the momentum grows by {found:g}, the outer force less R is {expected:g}"
            return f"momentum, outer_force: {told}; they should be equal ({_place(y, drive, force)})"
    return None


def symmetric(given: Any) -> str | None:
    """Its signs of `symmetry` turn a motion into a motion, exactly, unless `symmetric` says that they do not."""
    different = 0
    for machine, t, y, drive, force in _moving(given):
        mirror = tuple(sign * v for sign, v in zip(machine.symmetry, y, strict=True))
        rates = machine.rates(t, y, drive, force)
        expected = tuple(sign * rate for sign, rate in zip(machine.symmetry, rates, strict=True))
        back = machine.driven_by(ImposedSample(-1.0))
        found = back.rates(t, mirror, -drive, -force)
        guards, mirrored = sorted(machine.switches(t, y, drive, force)), back.switches(t, mirror, -drive, -force)
        loads = _load(back, t, mirror, -drive, -force), _load(machine, t, y, drive, force)
        if not machine.symmetric:
            pairs = [*zip(found, expected, strict=True), *zip(sorted(mirrored), guards, strict=True), loads]
            different += any(abs(a - b) > 1e-3 * abs(b) for a, b in pairs)
            continue
        if sorted(mirrored) != guards:
            return "switches: should be the same guards in the mirrored state"
        if loads[0] != loads[1]:
            return f"reaction: should be the same in the mirrored state, got {loads[0]:g} for {loads[1]:g}"
        if found != expected:
            return (
                f"symmetry: mirrored rates should be {_shown(expected)}, got {_shown(found)}; mend the signs, or let "
                "`symmetric` be False"
            )
        if back.contact_velocity(t, mirror) != -machine.contact_velocity(t, y):
            return "contact_velocity: should change its sign in the mirrored state"
        if back.holding_force(t, mirror, -drive) != -machine.holding_force(t, y, drive):
            return "holding_force: should change its sign in the mirrored state, with the drive reversed"
        if back.energy(t, mirror) != machine.energy(t, y):
            return "energy: should be the same in the mirrored state"
    return None if given.symmetric or different else "symmetric: is False, but the equations are their mirror image"


def _load(machine: Any, t: float, y: tuple, drive: float, force: float) -> float:
    """The normal load under a friction force."""
    if not machine.follows_load:
        return machine.load()
    inertia, own, slope = machine.reaction(t, y, drive)
    return (own + slope * force) / inertia


def load_made(given: Any) -> str | None:
    """A load that follows the motion is its mean and the rate of the momentum normal to the ground."""
    rising = None
    for machine, t, y, drive, force in _moving(given, SAMPLES if given.follows_load else 0):
        if not machine.reaction(t, y, drive)[0] > 0.0:
            return f"reaction: its first number should be positive, got {machine.reaction(t, y, drive)[0]:g}"
        if machine.vertical_momentum(t, y) is None:
            continue
        rising = rising or along(machine.vertical_momentum, len(y))
        rates = machine.rates(t, y, drive, force)
        found, lift = _load(machine, t, y, drive, force), rising(t, y, rates)
        size = 1.0 + max(map(abs, (*rates, found))) ** 2
        if not abs(found - machine.load() - lift) <= 64 * EPSILON * size:
            made = machine.load() + lift
            told = f"the load is {found:g}, the mean and the rate of the momentum make {made:g}"
            return f"reaction, vertical_momentum: {told}; they should be equal ({_place(y, drive, force)})"
    return None


def cyclic(given: Any) -> str | None:
    """Nothing depends on the cyclic state."""
    if given.cyclic is None:
        return None
    place = given.states.index(given.cyclic)
    for machine, t, y, drive, force in _moving(given, 10):
        moved = tuple(v + 7.0 if i == place else v for i, v in enumerate(y))
        if machine.rates(t, moved, drive, force) != machine.rates(t, y, drive, force):
            return f"rates: should not depend on the cyclic state {machine.cyclic}"
        if machine.energy(t, moved) != machine.energy(t, y):
            return f"energy: should not depend on the cyclic state {machine.cyclic}"
    return None


def turns(given: Any) -> str | None:
    """Everything depends on the states that turn with their period, to rounding."""
    for name, period in given.turns.items():
        if name not in given.states or name in (given.cyclic, given.contact_state, *given.switched):
            return f"turns: should name states that neither travel nor slide nor are switched, got {name!r}"
        if not (isinstance(period, (int, float)) and 0.0 < period < math.inf):
            return f"turns: the period of {name} should be a positive number, got {period!r}"
        place = given.states.index(name)
        for machine, t, y, drive, force in _moving(given):
            moved = tuple(v + period if i == place else v for i, v in enumerate(y))
            for what, values in _functions(machine, t, y, drive, force).items():
                found = _functions(machine, t, moved, drive, force)[what]
                bound = 64 * EPSILON * (1.0 + period) * max(map(abs, (1.0, *values))) ** 2
                if not all(abs(a - b) <= bound for a, b in zip(found, values, strict=True)):
                    told = f"{_shown(values)}, got {_shown(found)}"
                    return f"{what}: should be the same after a whole turn of {name}, {told}"
    return None


def _functions(machine: Any, t: float, y: tuple, drive: float, force: float) -> dict[str, tuple]:
    """What a state decides, by the function that says it."""
    return {
        "rates": tuple(machine.rates(t, y, drive, force)),
        "holding_force": (machine.holding_force(t, y, drive),),
        "contact_velocity": (machine.contact_velocity(t, y),),
        "reaction": (_load(machine, t, y, drive, force),),
        "energy": (machine.energy(t, y),),
        "momentum": (machine.momentum(t, y),),
        "powers": tuple(machine.powers(t, y, drive, force)),
        "switches": tuple(machine.switches(t, y, drive, force)),
        "bounds": tuple(machine.bounds(t, y)),
    }


def place(given: Any) -> str | None:
    """The place of the contact moves with it and the ground."""
    for machine, t, y, drive, force in _moving(given, 10):
        name = machine.place or machine.cyclic
        rate = machine.rates(t, y, drive, force)[machine.states.index(name)]
        expected = machine.contact_velocity(t, y) + machine.ground_speed()
        if not abs(rate - expected) <= 8 * EPSILON * max(1.0, abs(expected)):
            return f"rates: {name} should move with contact_velocity + ground_speed, {expected:g}, got {rate:g}"
    return None


def mechanism(given: Any) -> str | None:
    """Its mechanism, where it has one, has its energy, its momentum and its powers without friction."""
    for machine, t, y, drive, _ in _moving(given):
        if (parts := machine.mechanism(t, y)) is None:
            return None
        normal = 0.0 if machine.gravity is None else machine.gravity[0]
        places, velocities = {"": 0.0}, {"": 0.0}
        energy = momentum = power = 0.0
        for each in parts.bodies:
            turns, sine, cosine = each.joint == "hinge", math.sin(each.place), math.cos(each.place)
            rise = -sine * each.rate if turns else 0.0
            velocity = velocities[each.carrier] + (-cosine * each.rate if turns else each.rate)
            places[each.name], velocities[each.name] = each.place, velocity
            energy += 0.5 * each.mass * (velocity * velocity + rise * rise) + 0.5 * each.stiffness * each.place**2
            energy += each.mass * normal * cosine if turns else 0.0
            momentum += each.mass * velocity
            power += (each.actuation * drive - each.damping * each.rate) * each.rate
        for link in parts.links:
            opening, rate = (found[link.ahead] - found[link.behind] for found in (places, velocities))
            energy += 0.5 * link.stiffness * opening * opening
            power += (link.actuation * drive - link.damping * rate) * rate
        none = (0.0,) * (1 + len(machine.contacts))
        wanted = machine.energy(t, y), machine.momentum(t, y), sum(machine.powers(t, y, drive, *none))
        for what, found, value in zip(("energy", "momentum", "power"), (energy, momentum, power), wanted, strict=True):
            if not abs(found - value) <= 64 * EPSILON * (1.0 + max(map(abs, (*y, drive, value)))) ** 2:
                return f"mechanism: its {what} is {found:g}, that of the equations {value:g} ({_place(y, drive, 0.0)})"
    return None


def sizes(machine: Any) -> str | None:
    """Its load and its scales are positive."""
    if not (math.isfinite(machine.load()) and machine.load() > 0.0):
        return f"load: should be positive, got {machine.load():g}"
    for period in (1e-3, 1.0, 1e3):
        found = machine.scales(period)
        if len(found) != len(machine.states) or not min(found) > 0.0:
            return f"scales: should be a positive size for each of {', '.join(machine.states)}, got {found}"
    return None


def branches(machine: Any) -> str | None:
    """Its switches have names, give whole numbers to the switched states, and keep the momentum but at the ground."""
    unknown = set(machine.switched) - set(machine.states)
    if unknown:
        return f"switched: names {', '.join(sorted(unknown))}, which is no state"
    kept = [i for i, name in enumerate(machine.states) if name in (machine.cyclic, machine.place)]
    switched = [i for i, name in enumerate(machine.states) if name in machine.switched]
    for draw in draws(SAMPLES):
        t, y, drive, force = machine_draw(machine, draw)
        guards = machine.switches(t, y, drive, force)
        if len(guards) > len(machine.switch_events):
            return f"switch_events: should name what happens at each of {len(guards)} guards"
        for which in range(len(guards)):
            after = machine.after_switch(which, t, y, drive, force)
            if len(after) != len(y):
                return f"after_switch: should give all {len(y)} states, got {len(after)}"
            if any(after[i] != round(after[i]) for i in switched):
                return f"after_switch: {', '.join(machine.switched)} should become whole numbers, got {_shown(after)}"
            ends = machine.room()  # at a stop on the ground it stands exactly there
            if any(after[i] != y[i] and after[i] not in ends.get(machine.states[i], ()) for i in kept):
                return f"after_switch: {machine.place or machine.cyclic} should stay where it is"
            gained = machine.momentum(t, after) - machine.momentum(t, y)
            if machine.switch_events[which] in machine.strikes_ground:
                continue
            if not abs(gained) <= 64 * EPSILON * max(1.0, abs(machine.momentum(t, y))):
                return (
                    f"after_switch: guard {which} changes the momentum by {gained:g}; an impact keeps it, unless its "
                    f"name, {machine.switch_events[which]!r}, stands in strikes_ground"
                )
    return None


def _shown(values: tuple) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in values) + ")"


def _place(y: tuple, drive: float, force: float) -> str:
    return f"state {_shown(y)}, drive {drive:.3g}, R {force:.3g}"


BALANCES = (energy, momentum, load_made)
MACHINE_CLAUSES = (
    declarations,
    held_at_rest,
    contact,
    *BALANCES,
    symmetric,
    cyclic,
    turns,
    place,
    mechanism,
    sizes,
    branches,
)
