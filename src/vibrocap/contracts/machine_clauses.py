"""The contract of a machine, clause by clause: each takes a machine and returns its fault, or None.

Its equations follow from its parts, so that accelerations, loads, energy and momentum agree. Judged here is what a
class says itself: numbers, units and sizes, and whether every coordinate moves a mass wherever it may be.
"""

import itertools
import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from scipy import optimize

from vibrocap.contracts.samples import ImposedSample, draws, machine_draw
from vibrocap.physics.events import SINGULAR_MASS_MATRIX
from vibrocap.physics.machines.machine import IMPOSED
from vibrocap.physics.mechanics.parts import Placed
from vibrocap.physics.parameters import dimension_of_unit

SAMPLES = 20
REACH, STEPS = 2.0, 32  # of a coordinate, in natural sizes of its state, within which masses are looked at
TURN = 3.2  # the same of an angle, at least: all round
EPSILON = float(np.finfo(float).eps)


def _moving(machine: Any, count: int = SAMPLES) -> Iterator[tuple]:
    """(machine, t, state, drive, friction forces) at random; of an imposed motion it is driven by a sample."""
    driven = machine.driven_by(ImposedSample())
    for draw in draws(count):
        yield driven, *machine_draw(driven, draw)


def declarations(machine: Any) -> str | None:
    """What it declares fits together."""
    names = ("force", "torque", *IMPOSED)
    if machine.effort not in names:
        return f"effort: should be one of {', '.join(names)}, got {machine.effort!r}"
    for name, turn in machine.turns.items():
        if not (isinstance(turn, (int, float)) and 0.0 < turn < math.inf):
            return f"repeats: the period of {name} should be a positive number, got {turn!r}"
    for name, (low, high) in machine.room().items():
        if not low < high:
            return f"parts: the stops of {name} leave it no room, from {low:g} to {high:g}"
    return None


def units(machine: Any) -> str | None:
    """Its coordinates have units that are known, and metres are not added to radians."""
    own = {name: coordinate.unit for name, coordinate in machine.all_coordinates.items()}
    for name, unit in own.items():
        try:
            dimension_of_unit(unit)
        except ValueError as error:
            return f"{name}: {error}"
    for part, quantity in machine.kind().whole.everything():
        added = {own[name]: name for name in own if quantity.slope(name).number in (1.0, -1.0)}
        if {"m", "rad"} <= added.keys():
            what = f"{type(part).__name__}{f' {part.name!r}' if isinstance(part, Placed) else ''}"
            places = f"{added['m']} in m and {added['rad']} in rad"
            return f"parts: a {what} adds {places}: multiply the angle by a length, a parameter"
    return None


def numbers(part: Any) -> str | None:
    """Masses and dampers are not negative, and restitutions are 0 to 1."""
    for machine, t, y, *_ in _moving(part):
        for what, value, most in machine.evaluated("numbers", t, y):
            if not 0.0 <= value <= most:
                wanted = ">= 0" if most == math.inf else f"0 to {most:g}"
                return f"parts: {what} should be {wanted}, got {value:g} at {_place(machine, y)}"
    return None


def accelerated(part: Any) -> str | None:
    """Its rates are finite, and its mass matrix is not singular, wherever its coordinates may reach."""
    machine, t, start, *_ = next(_moving(part, 1))
    names, sizes, room = [*machine.coordinates], machine.scales(), machine.room()
    dead = [kind == SINGULAR_MASS_MATRIX for kind in machine.bound_kinds]

    def least(y: tuple) -> float:
        """What is left until it is singular; inf out of reach."""
        try:
            bounds = [*zip(dead, machine.bounds(t, y), strict=True)]
        except (ValueError, ZeroDivisionError, OverflowError):
            return math.inf
        reached = all(own or bound > 0.0 for own, bound in bounds)
        return min(bound for own, bound in bounds if own) if reached else math.inf

    for at, name in itertools.product(((0.0,) * len(start), start), names if any(dead) else ()):
        i = machine.states.index(name)
        low, high = room.get(name, (-math.inf, math.inf))
        reach = max(REACH * sizes[i], TURN if machine.all_coordinates[name].unit == "rad" else 0.0)
        x = np.linspace(max(low, -reach), min(high, reach), STEPS + 1)
        values = [least((*at[:i], float(number), *at[i + 1 :])) for number in x]
        k = int(np.argmin(values))
        near = optimize.minimize_scalar(
            lambda number, at=at, i=i: least((*at[:i], float(number), *at[i + 1 :])),
            bounds=(x[max(k - 1, 0)], x[min(k + 1, STEPS)]),
            method="bounded",
            options={"xatol": 1e-12 * sizes[i]},
        )
        value, worst = min((values[k], float(x[k])), (float(near.fun), float(near.x)))
        if value <= 0.0:
            y = (*at[:i], worst, *at[i + 1 :])
            return f"parts: the mass matrix is singular at {_place(machine, y)}: a coordinate moves no mass there"
    for machine, t, y, drive, frictions in _moving(part):
        for placed in (machine, machine.tilted(1.0, 0.2)):
            if not all(map(math.isfinite, placed.rates(t, y, drive, frictions))):
                return f"rates: are not finite at {_place(machine, y)}"
    return None


def sizes(machine: Any) -> str | None:
    """Its loads and its scales are positive."""
    if not all(math.isfinite(load) and load > 0.0 for load in machine.loads()):
        return f"loads: should be positive, got {_shown(machine.loads())}"
    for period in (1e-3, 1.0, 1e3):
        scales = machine.scales(period)
        if len(scales) != len(machine.states) or not min(scales) > 0.0:
            return f"scales: should be a positive size for each of {', '.join(machine.states)}, got {scales}"
    return None


def turns(part: Any) -> str | None:
    """Everything depends on the coordinates that repeat with their period, to rounding."""
    for name, period in part.turns.items():
        i = part.states.index(name)
        for machine, t, y, drive, frictions in _moving(part):
            moved = (*y[:i], y[i] + period, *y[i + 1 :])
            values, after_turn = (
                [
                    *machine.rates(t, at, drive, frictions),
                    machine.energy(t, at),
                    *(load for own in machine.contacts(t, at, drive) for load in own.reaction or ()),
                ]
                for at in (y, moved)
            )
            bound = 64 * EPSILON * (1.0 + period) * max(map(abs, (1.0, *values))) ** 2
            if not all(abs(a - b) <= bound for a, b in zip(after_turn, values, strict=True)):
                numbers_shown = f"{_shown(values)}, got {_shown(after_turn)}"
                return f"repeats: rates, energy and loads should be the same after a turn of {name}, {numbers_shown}"
    return None


def branches(machine: Any) -> str | None:
    """Its switches have names, give whole numbers to the switched states, and keep the momentum but at the ground."""
    kept = [i for i, name in enumerate(machine.states) if name in (machine.cyclic, machine.place)]
    switched = [i for i, name in enumerate(machine.states) if name in machine.switched]
    for _, t, y, drive, frictions in _moving(machine):
        guards = machine.switches(t, y, drive, frictions)
        if len(guards) > len(machine.switch_events):
            return f"switch_events: should name the event at each of {len(guards)} guards"
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


def _shown(values: Iterable[float]) -> str:
    return "(" + ", ".join(f"{value:.3g}" for value in values) + ")"


def _place(machine: Any, y: tuple) -> str:
    return ", ".join(
        f"{name} {value:.3g}" for name, value in zip(machine.states, y, strict=True) if name in machine.coordinates
    )


MACHINE_CLAUSES = (declarations, units, numbers, sizes, accelerated, turns, branches)
