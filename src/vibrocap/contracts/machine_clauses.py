"""The contract of a machine, clause by clause: each takes a machine and says what is wrong, or None."""

import math
from collections.abc import Iterator
from typing import Any

from vibrocap.contracts.growth import EPSILON, balance, explicit_rates, growth_terms, rounding_of_machine
from vibrocap.contracts.samples import ImposedSample, draws, machine_draw
from vibrocap.physics.machines.machine import Contact

# of friction and of surroundings, and what else stands beside works
OTHERS_CHANNELS = (
    *("contact_sliding", "bristle_loss", "contact_storage", "drag", "outer_force", "gravity"),
    *("stored", "residual", "window", "periods", "own"),
)
SAMPLES = 60


def _moving(machine: Any, count: int = SAMPLES) -> Iterator[tuple]:
    """(machine, t, state, drive, friction forces) at random; of an imposed motion it is driven by a sample."""
    driven = machine.driven_by(ImposedSample())
    for draw in draws(count):
        yield driven, *machine_draw(driven, draw)


def declarations(machine: Any) -> str | None:
    """What it declares fits together."""
    states = machine.states
    if not isinstance(states, tuple) or len(set(states)) != len(states):
        return f"states: should be a tuple of names, each once, got {states!r}"
    for what in ("cyclic", "place"):
        name = getattr(machine, what)
        if name not in states and name is not None:
            return f"{what}: should be one of {', '.join(states)}, got {name!r}"
    names = machine.contact_states
    if not isinstance(names, tuple) or not names or not {*names} <= {*states}:
        return (
            "contact_states: should be a tuple of one name for each contact, of the state that moves with its sliding "
            f"velocity, among {', '.join(states)}, got {names!r}"
        )
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


def listed(given: Any) -> str | None:
    """It lists its contacts, as many as `contact_states`, each with its load and with what would hold it."""
    names = given.contact_states
    count, loads = len(names), given.loads()
    if not isinstance(loads, tuple) or len(loads) != count:
        return f"loads: should be a tuple of one load for each contact ({', '.join(names)}), got {loads!r}"
    for machine, t, y, drive, _ in _moving(given, 1):
        found = machine.contacts(t, y, drive)
        if not isinstance(found, tuple) or len(found) != count or not all(isinstance(each, Contact) for each in found):
            return f"contacts: should be a tuple of one Contact for each of contact_states ({', '.join(names)})"
        if len({bool(each.response) for each in found}) > 1:
            return "contacts: should all have a holding_force, or all an acceleration and a response"
        for number, each in enumerate(found, start=1):
            alone = (each.acceleration, each.response) == (None, ())
            if alone == (each.holding_force is None) or not (alone or len(each.response) == count):
                wanted = f"a holding_force or, in its place, an acceleration and a response of {count} numbers"
                return f"contacts: contact {number} should have {wanted}"
            if each.reaction is not None and len(each.reaction) != 2 + count:
                return f"contacts: the reaction of contact {number} should be (b, n, s_1, ...), {2 + count} numbers"
            if machine.follows_load and each.reaction is None:
                return f"contacts: contact {number} should have a reaction, which is its load by follows_load"
            if count > 1 and alone and (machine.follows_load or machine.imposes_distances):
                why = "loads follow the motion" if machine.follows_load else "a state is shared"
                return f"contacts: should have an acceleration and a response each, as {why}"
    return None


def held_at_rest(given: Any) -> str | None:
    """Each contact is accelerated as `contacts` says: not at all with its holding force as friction."""
    for machine, t, y, drive, frictions in _moving(given):
        imposed = explicit_rates(lambda t, y, of=machine: [each.velocity for each in of.contacts(t, y, 0.0)], t, y)
        for i, each in enumerate(machine.contacts(t, y, drive)):
            name, moving = given.contact_states[i], imposed[i]
            own = frictions[i] if each.response else each.holding_force
            asked = [(*frictions[:i], own + change, *frictions[i + 1 :]) for change in (0.0, 0.1, -0.1)]
            place = given.states.index(name)
            found, more, less = (machine.rates(t, y, drive, forces)[place] + moving for forces in asked)
            if each.response:
                taken = sum(share * force for share, force in zip(each.response, frictions, strict=True))
                expected = each.acceleration - taken
                if not abs(found - expected) <= 1e3 * EPSILON * max(1.0, abs(each.acceleration), abs(found)):
                    told = f"{expected:g} by its acceleration and response"
                    return f"rates: the acceleration of contact {i + 1} should be {told}, got {found:g}"
            elif not abs(found) <= 4 * EPSILON * abs(moving) + rounding_of_machine(
                lambda *at, of=machine, place=place: [of.rates(*at)[place]], t, y, drive, asked[0]
            ):
                told = f"with its holding_force as friction the rate of {name} should be 0, got {found:g}"
                return f"rates: {told}; write the acceleration as (holding force - R) over an inertia"
            if not more < found < less:
                return f"rates: more friction should slow {name} down, got {more:g} for {found:g}"
    return None


def contact(given: Any) -> str | None:
    """Each contact state moves one to one with the sliding velocity of its contact."""
    for machine, t, y, drive, _ in _moving(given, 10):
        for i, name in enumerate(given.contact_states):
            moved = tuple(v + 0.25 if name == state else v for state, v in zip(given.states, y, strict=True))
            after, before = (machine.contacts(t, at, drive)[i].velocity for at in (moved, y))
            if not abs(after - before - 0.25) <= 8 * EPSILON * max(1.0, *map(abs, y)):
                return f"contacts: the velocity changes by {after - before:g} where {name} changes by 0.25"
    return None


def energy(given: Any) -> str | None:
    """Its energy balance closes: H' = sum of the powers - R v of every contact."""
    growth = growth_terms(given.driven_by(ImposedSample()).energy, len(given.states))
    for machine, t, y, drive, frictions in _moving(given):
        rates, powers = machine.rates(t, y, drive, frictions), machine.powers(t, y, drive, frictions)
        if len(rates) != len(machine.states) or len(powers) != len(machine.channels):
            return (
                f"rates, powers: should be {len(machine.states)} and {len(machine.channels)} numbers, one for each of "
                f"states and channels, got {len(rates)} and {len(powers)}"
            )

        def flows(*at: Any, of: Any = machine) -> list[float]:
            sliding = (each.velocity for each in of.contacts(*at[:3]))
            return [*of.powers(*at), *(-force * v for force, v in zip(at[3], sliding, strict=True))]

        found, expected, bound = balance(growth, flows, machine, t, y, drive, frictions)
        if not abs(found - expected) <= bound:
            told = f"the energy grows by {found:g}, the powers less R v of every contact are {expected:g}"
            return f"energy, powers: {told}; they should be equal ({_place(y, drive, frictions)})"
    return None


def momentum(given: Any) -> str | None:
    """Its momentum balance closes: p' = outer force - R of every contact."""
    growth = growth_terms(given.driven_by(ImposedSample()).momentum, len(given.states))
    for machine, t, y, drive, frictions in _moving(given):

        def flows(*at: Any, of: Any = machine) -> list[float]:
            return [of.outer_force(*at[:3]), of.wall_force(*at), *(-force for force in at[3])]

        found, expected, bound = balance(growth, flows, machine, t, y, drive, frictions)
        if not abs(found - expected) <= bound:
            told = f"the momentum grows by {found:g}, the outer force less R is {expected:g}"
            return f"momentum, outer_force: {told}; they should be equal ({_place(y, drive, frictions)})"
    return None


def symmetric(given: Any) -> str | None:
    """Its signs of `symmetry` turn a motion into a later motion, exactly, unless `symmetric` says that they do not."""
    different = 0
    for machine, t, y, drive, frictions in _moving(given):
        mirror = tuple(sign * v for sign, v in zip(machine.symmetry, y, strict=True))
        rates = machine.rates(t, y, drive, frictions)
        expected = tuple(sign * rate for sign, rate in zip(machine.symmetry, rates, strict=True))
        back, opposite = machine.driven_by(ImposedSample(-1.0)), tuple(-force for force in frictions)
        then = t if machine.imposes_motion else t + 0.37, mirror, -drive  # half a period later
        found, mirrored = back.rates(*then, opposite), back.switches(*then, opposite)
        guards = sorted(machine.switches(t, y, drive, frictions))
        loads = _loads(back, *then, opposite), _loads(machine, t, y, drive, frictions)
        motions = _motion_of(back, *then), _motion_of(machine, t, y, drive)
        if not machine.symmetric:
            pairs = [
                *zip(found, expected, strict=True),
                *zip(sorted(mirrored), guards, strict=True),
                *zip(*loads, strict=True),
                *((a, -b) for a, b in zip(*motions, strict=True)),
            ]
            different += any(abs(a - b) > 1e3 * EPSILON * abs(b) for a, b in pairs)
            continue
        if sorted(mirrored) != guards:
            return "switches: should be the same guards in the mirrored state"
        if loads[0] != loads[1]:
            told = f"got {_shown(loads[0])} for {_shown(loads[1])}"
            return f"contacts: loads should be the same in the mirrored state, {told}"
        if found != expected:
            return (
                f"symmetry: mirrored rates should be {_shown(expected)}, got {_shown(found)}; mend the signs, or let "
                "`symmetric` be False"
            )
        if motions[0] != tuple(-value for value in motions[1]):
            told = "velocity and holding_force (or acceleration) should change their signs in the mirrored state"
            return f"contacts: {told}, with the drive reversed"
        if back.energy(*then[:2]) != machine.energy(t, y):
            return "energy: should be the same in the mirrored state"
    return None if given.symmetric or different else "symmetric: is False, but the equations are their mirror image"


def _loads(machine: Any, t: float, y: tuple, drive: float, frictions: tuple[float, ...]) -> tuple[float, ...]:
    """The load on each contact under friction forces."""
    if not machine.follows_load:
        return machine.loads()
    reactions = (each.reaction for each in machine.contacts(t, y, drive))
    return tuple(
        (own + sum(slope * force for slope, force in zip(slopes, frictions, strict=True))) / over
        for over, own, *slopes in reactions
    )


def _motion_of(machine: Any, t: float, y: tuple, drive: float) -> tuple[float, ...]:
    """Velocity of each contact, and the force that holds it or its acceleration."""
    found = machine.contacts(t, y, drive)
    return tuple(value for each in found for value in (each.velocity, each.holding_force or each.acceleration or 0.0))


def load_made(given: Any) -> str | None:
    """A load that follows the motion is its mean and the rate of the momentum normal to the ground."""
    rising = None
    for machine, t, y, drive, frictions in _moving(given, SAMPLES if given.follows_load else 0):
        if not min(over := [each.reaction[0] for each in machine.contacts(t, y, drive)]) > 0.0:
            return f"contacts: the first number of a reaction should be positive, got {min(over):g}"
        if machine.vertical_momentum(t, y) is None:
            continue
        rising = rising or growth_terms(machine.vertical_momentum, len(y))

        def load(*at: Any, of: Any = machine) -> list[float]:
            return [_loads(of, *at)[0], -of.loads()[0]]

        lift, above, bound = balance(rising, load, machine, t, y, drive, frictions)
        if not abs(above - lift) <= bound:
            mean = machine.loads()[0]
            told = f"the load is {mean + above:g}, the mean and the rate of the momentum make {mean + lift:g}"
            return f"contacts, vertical_momentum: {told}; they should be equal ({_place(y, drive, frictions)})"
    return None


def cyclic(given: Any) -> str | None:
    """Nothing depends on the cyclic state."""
    if given.cyclic is None:
        return None
    place = given.states.index(given.cyclic)
    for machine, t, y, drive, frictions in _moving(given, 10):
        moved = tuple(v + 7.0 if i == place else v for i, v in enumerate(y))
        if machine.rates(t, moved, drive, frictions) != machine.rates(t, y, drive, frictions):
            return f"rates: should not depend on the cyclic state {machine.cyclic}"
        if machine.energy(t, moved) != machine.energy(t, y):
            return f"energy: should not depend on the cyclic state {machine.cyclic}"
    return None


def turns(given: Any) -> str | None:
    """Everything depends on the states that turn with their period, to rounding."""
    for name, period in given.turns.items():
        if name not in given.states or name in (given.cyclic, *given.contact_states, *given.switched):
            return f"turns: should name states that neither travel nor slide nor are switched, got {name!r}"
        if not (isinstance(period, (int, float)) and 0.0 < period < math.inf):
            return f"turns: the period of {name} should be a positive number, got {period!r}"
        place = given.states.index(name)
        for machine, t, y, drive, frictions in _moving(given):
            moved = tuple(v + period if i == place else v for i, v in enumerate(y))
            for what, values in _functions(machine, t, y, drive, frictions).items():
                found = _functions(machine, t, moved, drive, frictions)[what]
                bound = 64 * EPSILON * (1.0 + period) * max(map(abs, (1.0, *values))) ** 2
                if not all(abs(a - b) <= bound for a, b in zip(found, values, strict=True)):
                    told = f"{_shown(values)}, got {_shown(found)}"
                    return f"{what}: should be the same after a whole turn of {name}, {told}"
    return None


def _functions(machine: Any, t: float, y: tuple, drive: float, frictions: tuple[float, ...]) -> dict[str, tuple]:
    """What a state decides, by the function that says it."""
    return {
        "rates": tuple(machine.rates(t, y, drive, frictions)),
        "contacts": (*_motion_of(machine, t, y, drive), *_loads(machine, t, y, drive, frictions)),
        "energy": (machine.energy(t, y),),
        "momentum": (machine.momentum(t, y),),
        "powers": tuple(machine.powers(t, y, drive, frictions)),
        "switches": tuple(machine.switches(t, y, drive, frictions)),
        "bounds": tuple(machine.bounds(t, y)),
    }


def place(given: Any) -> str | None:
    """The place of the first contact moves with it and the ground."""
    changes = ground_changes(given)
    for machine, t, y, drive, frictions in _moving(given, 10 if given.over_ground else 0):
        name = machine.place or machine.cyclic
        rate = machine.rates(t, y, drive, frictions)[machine.states.index(name)]
        speed = _ground(machine, t, *next(_moving(given, 1))[2:]) if changes else machine.ground_speed()
        expected = machine.contacts(t, y, drive)[0].velocity + speed
        if not abs(rate - expected) <= 8 * EPSILON * max(1.0, abs(speed), abs(expected)):
            told = f"the velocity of the first contact + ground_speed, {expected:g}, got {rate:g}"
            return f"rates: {name} should move with {told}"
    return None


def _ground(machine: Any, t: float, y: tuple, drive: float, frictions: tuple[float, ...]) -> float:
    """The speed of the ground under the first contact, as its place and its sliding velocity tell it."""
    rate = machine.rates(t, y, drive, frictions)[machine.states.index(machine.place or machine.cyclic)]
    return rate - machine.contacts(t, y, drive)[0].velocity


def ground_changes(given: Any) -> bool:
    """Whether the ground moves at a speed that changes in time, which `ground_speed` cannot tell."""
    speeds = [_ground(machine, t, *next(_moving(given, 1))[2:]) for machine, t, *_ in _moving(given, 10)]
    return max(speeds) - min(speeds) > 1e3 * EPSILON * max(1.0, *map(abs, speeds))


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
        none = (0.0,) * len(machine.contact_states)
        wanted = machine.energy(t, y), machine.momentum(t, y), sum(machine.powers(t, y, drive, none))
        for what, found, value in zip(("energy", "momentum", "power"), (energy, momentum, power), wanted, strict=True):
            if not abs(found - value) <= 64 * EPSILON * (1.0 + max(map(abs, (*y, drive, value)))) ** 2:
                return f"mechanism: its {what} is {found:g}, that of the equations {value:g} ({_place(y, drive, none)})"
    return None


def sizes(machine: Any) -> str | None:
    """Its loads and its scales are positive."""
    if not all(math.isfinite(load) and load > 0.0 for load in machine.loads()):
        return f"loads: should be positive, got {_shown(machine.loads())}"
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
        t, y, drive, frictions = machine_draw(machine, draw)
        guards = machine.switches(t, y, drive, frictions)
        if len(guards) > len(machine.switch_events):
            return f"switch_events: should name what happens at each of {len(guards)} guards"
        for which in range(len(guards)):
            after = machine.after_switch(which, t, y, drive, frictions)
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


def _place(y: tuple, drive: float, frictions: tuple[float, ...]) -> str:
    return f"state {_shown(y)}, drive {drive:.3g}, R {_shown(frictions)}"


BALANCES = (energy, momentum, load_made)
MACHINE_CLAUSES = (
    declarations,
    listed,
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
