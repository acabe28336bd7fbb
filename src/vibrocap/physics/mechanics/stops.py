"""Stops: elastic ones, and rigid ones, off which a body bounces and at which it may stay.

What strikes a rigid stop with the rate s' of the stretch leaves it with -e s'. The blow acts along the slope of s: all
speeds jump by M^-1 times it; friction is finite and has no impulse then. A body that is pushed against a stop stays
there, s' = 0, until the stop would have to pull. One that rests at a stop while another is struck stays there where the
blow presses it on, with an impulse of that stop too, and leaves where it does not (Pfeiffer and Glocker 1996, ch. 8,
with Newton's restitution).
"""

import itertools
import math
from collections.abc import Iterable, Mapping
from typing import Any

from vibrocap.physics.elementary import sqrt
from vibrocap.physics.events import IMPACT, STOP_OPENED
from vibrocap.physics.mechanics.formulas import add, div, mul
from vibrocap.physics.mechanics.parts import MechanicsError, Stop, as_sum
from vibrocap.physics.mechanics.sums import Sum, named, solved, total, written

LEAST_PULL = 1e-12  # of the force of a stop: with this acceleration a body leaves it, so that the way is no rounding

SLOWEST_REBOUND = 1e-7  # natural speeds: such a rebound rises by some 1e-14, which is rounding


def rebounds(speed):
    """1 where a mass leaves a stop at this speed, 0 where it is too slow and stays (see `RigidStopCapsule`)."""
    fast = speed - SLOWEST_REBOUND
    return 0.5 + 0.5 * fast / sqrt(fast * fast)


def which_stop(touching):
    """(front, back): 1 where that stop is touched; touching: 1 in front, -1 behind, 0 none."""
    return 0.5 * touching * (touching + 1.0), 0.5 * touching * (touching - 1.0)


def springs(stop: Stop, touching: Any) -> list[tuple]:
    """(1 while it is touched, how far it is pressed, stiffness, damping) of the springs of an elastic stop.

    A spring without mass, and where it has one a damper beside it, is touched and left where it carries nothing,

        F = k (s - gap) + c s'   in front,     F = k_b (s + back_gap) + c_b s'   behind

    so that a damper pulls, by at most c |s'|, just before the mass leaves. Stops that are alike are one spring.
    """
    stretch, k, c = stop.way.value, as_sum(stop.stiffness), as_sum(stop.damping or 0.0)
    if stop.back_gap is None:
        return [(touching, named(touching * (stretch - as_sum(stop.gap))), k, c)]
    front, back = which_stop(touching)
    pressed, pressed_back = named(front * (stretch - as_sum(stop.gap))), named(back * (stretch + as_sum(stop.back_gap)))
    if stop.back_stiffness is None and stop.back_damping is None:
        return [(front + back, named(pressed + pressed_back), k, c)]
    k_back = k if stop.back_stiffness is None else as_sum(stop.back_stiffness)
    c_back = c if stop.back_damping is None else as_sum(stop.back_damping)
    return [(front, pressed, k, c), (back, pressed_back, k_back, c_back)]


def sides(stop: Stop) -> tuple[float, ...]:
    """What `touching` becomes at each of its guards: it is reached in front, left, reached behind where it is there."""
    return (1.0, 0.0) if stop.back_gap is None else (1.0, 0.0, -1.0)


def switch_events(stops: Iterable[Stop]) -> tuple[str, ...]:
    """What happens at each guard."""
    return tuple(IMPACT if side else STOP_OPENED for stop in stops if stop.switches for side in sides(stop))


def elastic_force(stop: Stop, touching: Any) -> Sum:
    """F of an elastic stop."""
    return total(k * pressed + c * closed * stop.way.rate for closed, pressed, k, c in springs(stop, touching))


def sizes(stop: Stop) -> tuple[Sum, Sum]:
    """Natural sizes of the ways to the stop in front and to the one behind."""
    if stop.size is not None:
        return as_sum(stop.size), as_sum(stop.size)
    return 1.0 + as_sum(stop.gap), 1.0 + as_sum(0.0 if stop.back_gap is None else stop.back_gap)


def stopped(motion: Any, stop: Stop) -> str:
    """The coordinate that a stop bounds; MechanicsError where there is none, or a rigid stop cannot hold its speed."""
    name = next((name for name in motion.names if not (stop.way - motion.along[name]).moves), None)
    if name is None or (stop.rigid and stop.way.slopes.keys() != {name}):
        raise MechanicsError("a stop should bound one coordinate, which grows one to one with its stretch")
    if stop.rigid and stop.way.curvature:
        how = "let what it rubs on bear the stop, or let that be elastic"
        raise MechanicsError(
            f"a rigid stop holds {name!r} while a function of time changes its sliding velocity: {how}"
        )
    return name


def ends(motion: Any) -> tuple:
    """What is positive until a run ends at a stop, or where a path is singular."""
    rows = []
    for stop in motion.stops:
        if not stop.switches:
            stretch, (size, back_size) = stop.way.value, sizes(stop)
            rows.append(written((as_sum(stop.gap) - stretch) / size))
            if stop.back_gap is not None:
                rows.append(written((as_sum(stop.back_gap) + stretch) / back_size))
    return (*rows, *map(written, motion.folds))


def rooms(motion: Any) -> tuple:
    """(coordinate, least, most) of those that stops bound which no motion passes."""
    rows = []
    for stop in motion.stops:
        if not stop.elastic:
            name = stopped(motion, stop)
            at = stop.way.value - motion.states[name]
            low = -math.inf if stop.back_gap is None else written(-as_sum(stop.back_gap) - at)
            rows.append((name, low, written(as_sum(stop.gap) - at)))
    return tuple(rows)


def guards(motion: Any) -> tuple:
    """Positive while it lasts, of each stop: it is reached in front, left, and reached behind where it is there too."""
    rows = []
    for _, stop, touching in motion.switching:
        stretch, (size, back_size), gap = stop.way, sizes(stop), as_sum(stop.gap)
        if stop.elastic:
            front, back = (touching, 0.0) if stop.back_gap is None else which_stop(touching)
            open_, ahead = 1.0 - front - back, (stretch.value - gap) / size
            behind = Sum() if stop.back_gap is None else (stretch.value + as_sum(stop.back_gap)) / back_size
            rows += [written(front + back - open_ * ahead), written(open_ + front * ahead - back * behind)]
            rows += [] if stop.back_gap is None else [written(front + back + open_ * behind)]
            continue
        free = 1.0 - touching * touching
        rows += [written(1.0 - free + free * ((gap - stretch.value) / size)), _pressed(motion, stop, touching)]
        if stop.back_gap is not None:
            rows.append(written(1.0 - free + free * ((stretch.value + as_sum(stop.back_gap)) / back_size)))
    return tuple(rows)


def _pressed(motion: Any, stop: Stop, touching: Sum) -> Any:
    """1; at a rigid stop what presses against it, over its natural size: h less M u' along the stretch, at rest."""
    free, still = 1.0 - touching * touching, motion.at(_at_rest(motion, stop, touching))
    push = still.pressing(stopped(motion, stop), motion.accelerations)
    least = written(free + (1.0 - free) * LEAST_PULL)
    pressed = add(least, mul(written(touching), div(push, written(as_sum(stop.force)))))
    if not _resting(motion, stop):
        return pressed
    stays = Sum.of(written(free + (1.0 - free) * _positive(touching * stop.way.rate / as_sum(stop.speed))))
    return written(stays * Sum.of(pressed) - (1.0 - stays))  # the blow at another stop drives it away


def _at_rest(motion: Any, stop: Stop, touching: Sum) -> Mapping[str, Any]:
    """All states of a body at rest at the stop that it touches, exactly."""
    front, back = which_stop(touching)
    wall = front * as_sum(stop.gap)
    wall = wall if stop.back_gap is None else wall - back * as_sum(stop.back_gap)
    if stop.on_ground:  # a state that touches nothing stays as it is
        free = 1.0 - touching * touching
        return _moved(motion, stop, wall + free * stop.way.value, free * stop.way.rate, _resting(motion, stop))
    return _moved(motion, stop, wall, Sum(), _resting(motion, stop))


def _resting(motion: Any, stop: Stop) -> dict[str, Sum]:
    """Of the other coordinates with rigid stops, 1 where one is touched in front, -1 behind, 0 where none is."""
    own, resting = stopped(motion, stop), dict[str, Sum]()
    for _, other, touching in motion.switching:
        if other.rigid and (name := stopped(motion, other)) != own:
            resting[name] = resting.get(name, Sum()) + touching
    return resting


def _moved(motion: Any, stop: Stop, stretch: Any, rate: Any, held: Mapping[str, Sum]) -> dict[str, Any]:
    """All states once the stretch of a stop has this value and this rate: speeds that other stops hold, where `held` is
    not 0, stay, and the momenta of all other coordinates."""
    name, speeds = stopped(motion, stop), motion.rates
    after = {name: Sum.of(stretch) + (motion.states[name] - stop.way.value)}
    after[speeds[name]] = motion.speed[name] + (rate - stop.way.rate)
    states = {**motion.states, **after}
    if others := [other for other in motion.names if other != name]:
        still, rows = motion.at(states), []
        for i in others:
            free = 1.0 - held.get(i, Sum()) * held.get(i, Sum())
            row = [still.inertia(i, j) if i == j else free * still.inertia(i, j) for j in others]
            rows.append([*row, free * (motion.momentum(i) - still.momentum(i))])
        for other, (change,) in zip(others, solved(rows, len(others)), strict=True):
            states[speeds[other]] = Sum.of(add(written(states[speeds[other]]), change))
    return states


def _struck(motion: Any, stop: Stop, stretch: Any, rate: Any) -> dict[str, Any]:
    """The same after a blow, of which other stops take a part.

    Which stops hold is the first choice that agrees with itself: those that hold push, what leaves moves away.
    """
    resting, speeds = _resting(motion, stop), motion.rates
    choices = [names for k in range(1 + len(resting)) for names in itertools.combinations(resting, k)]
    after, left = dict[str, Any](), Sum.of(1.0)
    for names in choices:
        states, fits = _moved(motion, stop, stretch, rate, {name: resting[name] for name in names}), left
        if names != choices[-1]:
            moved = motion.at(states)
            for name, side in resting.items():
                push = side * (motion.momentum(name) - moved.momentum(name))
                on = side * (Sum.of(states[speeds[name]]) - motion.speed[name]) / as_sum(stop.speed)
                agrees = side * side * _positive(push) if name in names else 1.0 - side * side * _positive(on)
                fits = fits * Sum.of(written(agrees))
        left, fits = left - fits, Sum.of(written(fits))
        for key, value in states.items():
            after[key] = Sum.of(value) if len(choices) == 1 else after.get(key, Sum()) + fits * Sum.of(value)
    return after


def _positive(x: Sum) -> Any:
    """1 where a number is not negative, to rounding; else 0."""
    more = written(x + LEAST_PULL)
    return 0.5 + 0.5 * (more / sqrt(more * more))


def outcomes(motion: Any) -> tuple[dict[str, Any], ...]:
    """Of each guard the states that change, by name, a stop's own by its number."""
    after_all: list[dict[Any, Any]] = []
    for number, stop, touching in motion.switching:
        for side in sides(stop):
            if stop.elastic:
                after_all.append({number: side})
            elif side == 0.0:
                opened = {} if _resting(motion, stop) else _at_rest(motion, stop, touching)
                after_all.append({**opened, number: 0.0})
            else:
                rate, e = stop.way.rate, as_sum(stop.restitution)
                bounces = Sum.of(rebounds(written(side * (e * rate) / as_sum(stop.speed))))
                wall = as_sum(stop.gap) if side > 0.0 else -as_sum(stop.back_gap)
                after = _struck(motion, stop, wall, -(bounces * e * rate))
                after_all.append({**after, number: side * (1.0 - bounces)})
    return tuple({key: written(value) for key, value in states.items()} for states in after_all)
