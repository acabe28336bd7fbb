"""Samples of parts: parameters, states and motions at random, always the same ones, in which no term is zero."""

import dataclasses
import math
import random
from collections.abc import Iterable
from typing import Any

from vibrocap.physics.parameters import FREQUENCY, ParameterError, parameter_table

TRIES = 200  # of random values, until some are within the bounds of a part
MOST_SWITCHES = 12  # of a law at one instant


def varied(part: Any, seed: int) -> Any:
    """A part with every number changed at random by up to a fifth; a zero becomes a number too.

    Frequencies change alike, so that what repeats with several of them does so still.
    """
    draw, pace = random.Random(f"{part.name} {seed}"), random.Random(f"pace {seed}").uniform(0.8, 1.2)
    values = {info.name: (info.default, pace if info.dimension == FREQUENCY else 0.0) for info in parameter_table(part)}
    for _ in range(TRIES):
        try:
            return part(
                **{
                    name: (value * (factor or draw.uniform(0.8, 1.2)) or draw.uniform(0.2, 0.5))
                    if isinstance(value, float)
                    else value
                    for name, (value, factor) in values.items()
                }
            )
        except ParameterError:  # a number beyond its bounds
            continue
    return part()


def instances(parts: Iterable[Any], sets: int = 2) -> list[Any]:
    """Each part with its defaults and with some random sets of values."""
    return [make for part in parts for make in (part(), *(varied(part, 1 + i) for i in range(sets)))]


def draws(count: int, seed: str = "contracts") -> list[random.Random]:
    """As many random generators."""
    return [random.Random(f"{seed} {i}") for i in range(count)]


def random_state(names: tuple[str, ...], draw: random.Random) -> tuple[float, ...]:
    """Numbers of the order of one."""
    return tuple(draw.uniform(-1.2, 1.2) for _ in names)


def settled_pieces(law: Any, velocity: float, internal: tuple, side: int, load: float) -> tuple:
    """The internal states after every guard that is not positive has fired; ValueError where that does not end."""
    fired: list[int] = []
    for _ in range(MOST_SWITCHES):
        guards = law.switches(velocity, internal, side, load)
        fired = [i for i, guard in enumerate(guards) if not guard > 0.0]
        if not fired:
            return internal
        internal = law.after_switch(fired[0], velocity, internal, side, load)
    raise ValueError(
        f"switches: the pieces of the law do not settle, guard {fired[0]} falls again and again at {internal}; a guard "
        "should be clearly positive after its own switch"
    )


def random_internal(law: Any, velocity: float, side: int, load: float, draw: random.Random) -> tuple:
    """Internal states within their natural size, with the pieces that belong to them."""
    internal = tuple(
        0.0 if name in law.switched else draw.uniform(-1, 1) * scale
        for name, scale in zip(law.internal, law.internal_scales(load), strict=True)
    )
    if "engaged" in law.internal:
        internal = (*internal[:-1], draw.choice((-1.0, 0.0, 1.0)))
    return settled_pieces(law, velocity, internal, side, load)


def random_motion(law: Any, draw: random.Random) -> tuple[float, tuple, int, float]:
    """(velocity, internal states, side, load) of a contact."""
    side, load = draw.choice((1, -1)), draw.uniform(0.3, 2.0)
    velocity = side * draw.uniform(0.0, 1.0) ** 3
    return velocity, random_internal(law, velocity, side, load, draw), side, load


def mirrored(law: Any, internal: tuple) -> tuple:
    """Internal states of the mirrored motion."""
    signs = law.internal_symmetry or (-1,) * len(law.internal)
    return tuple(sign * state for sign, state in zip(signs, internal, strict=True))


@dataclasses.dataclass(frozen=True)
class ImposedSample:
    """A motion that a machine may be told to make: a parabola in time, or its mirror image."""

    sign: float = 1.0

    def value(self, t):
        return self.sign * (0.2 - 0.11 * t + 0.013 * t * t)

    def slope(self, t):
        return self.sign * (-0.11 + 0.026 * t)

    def curvature(self, t):
        return self.sign * 0.026


def machine_draw(machine: Any, draw: random.Random) -> tuple[float, tuple, float, tuple[float, ...]]:
    """(time, state, drive, friction force at each contact) of a machine, in the branch that holds there."""
    t, y, drive, force = (
        draw.uniform(0, 9),
        within_room(machine, random_state(machine.states, draw)),
        draw.uniform(-2, 2),
        draw.uniform(-1, 1),
    )
    frictions = force, *(0.4 - 0.3 * i - 0.7 * force for i in range(len(machine.contact_states) - 1))
    return t, settled_branch(machine, t, y, drive, frictions), drive, frictions


def within_room(machine: Any, y: tuple) -> tuple:
    """A state of a machine, moved to where one between two rigid ends may be, or mirrored at the only one."""
    state = list(y)
    for name, (low, high) in machine.room().items():
        place, width = machine.states.index(name), high - low
        if low < state[place] < high:
            continue
        if math.isfinite(width):
            state[place] = low + width * (0.05 + 0.9 * ((state[place] - low) / width % 1.0))
        else:
            state[place] = 2.0 * (high if math.isfinite(high) else low) - state[place]
    return tuple(state)


def settled_branch(machine: Any, t: float, y: tuple, drive: float, frictions: tuple[float, ...]) -> tuple:
    """A state of a machine after every guard that is negative has fired; ValueError where that does not end."""
    y = tuple(0.0 if name in machine.switched else value for name, value in zip(machine.states, y, strict=True))
    fired: list[int] = []
    for _ in range(MOST_SWITCHES):
        guards = machine.switches(t, y, drive, frictions)
        fired = [i for i, guard in enumerate(guards) if guard < 0.0]
        if not fired:
            return y
        y = machine.after_switch(fired[0], t, y, drive, frictions)
    raise ValueError(
        f"switches: the branches of the machine do not settle, guard {fired[0]} is negative again and again at {y}"
    )
