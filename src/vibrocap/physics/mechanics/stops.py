"""Stops: elastic ones, and rigid ones, off which a body bounces and at which it may stay.

What strikes a rigid stop with the rate s' of the stretch leaves it with -e s'. The blow acts along the slope of s, so
that all speeds jump by M^-1 times it, unless the ground takes it; friction is finite and has no impulse then. A body
that is pushed against a stop stays there, s' = 0, until the stop would have to pull.
"""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from vibrocap.physics.elementary import sqrt
from vibrocap.physics.mechanics.formulas import add, div, mul, sub
from vibrocap.physics.mechanics.parts import MechanicsError, Stop, as_sum
from vibrocap.physics.mechanics.sums import Sum, solved, written

LEAST_PULL = 1e-12  # of the force of a stop: with this acceleration a body leaves it, so that the way is no rounding

SLOWEST_REBOUND = 1e-7  # natural speeds: such a rebound rises by some 1e-14, which is rounding


def rebounds(speed):
    """1 where a mass leaves a stop at this speed, 0 where it is too slow and stays (see `RigidStopCapsule`)."""
    fast = speed - SLOWEST_REBOUND
    return 0.5 + 0.5 * fast / sqrt(fast * fast)


def which_stop(touching):
    """(front, back): 1 where that stop is touched; touching: 1 in front, -1 behind, 0 none."""
    return 0.5 * touching * (touching + 1.0), 0.5 * touching * (touching - 1.0)


@dataclasses.dataclass(frozen=True)
class ElasticStops:
    """A spring without mass, and where it has one a damper beside it, at a way gap in front, and at back_gap behind.

    They are touched and left where their springs carry nothing:

        F = k_s (z - gap) + c_s z'   in front,     F = k_b (z + back_gap) + c_b z'   behind

    A damper therefore pulls, by at most c_s |z'|, just before the mass leaves. What is None is not there; behind, the
    spring and the damper are then those in front.
    """

    gap: Any
    back_gap: Any
    stiffness: Any
    back_stiffness: Any = None
    damping: Any = None
    back_damping: Any = None

    @property
    def symmetric(self) -> bool:
        """Whether there are two that are alike."""
        alike = self.back_stiffness in (None, self.stiffness) and self.back_damping in (None, self.damping or 0.0)
        return self.back_gap == self.gap and alike

    def _closed(self, touching):
        return (touching, 0.0) if self.back_gap is None else which_stop(touching)

    def _pressed(self, z, touching):
        """(way into the stop in front, into the one behind: negative); the latter None where there is none."""
        front, back = self._closed(touching)
        return front * (z - self.gap), None if self.back_gap is None else back * (z + self.back_gap)

    def _damping(self, touching):
        """c of the stop that is touched; None where neither has a damper."""
        front, back = self._closed(touching)
        if self.back_gap is None or self.back_damping is None:
            return None if self.damping is None else (front + back) * self.damping
        return back * self.back_damping if self.damping is None else front * self.damping + back * self.back_damping

    def force(self, z, rate, touching):
        """F."""
        front, back = self._pressed(z, touching)
        if back is None or self.back_stiffness is None:
            force = self.stiffness * (front if back is None else front + back)
        else:
            force = self.stiffness * front + self.back_stiffness * back
        damping = self._damping(touching)
        return force if damping is None else force + damping * rate

    def energy(self, z, touching):
        """Stored in the spring that is touched."""
        front, back = self._pressed(z, touching)
        if back is None or self.back_stiffness is None:
            pressed = front if back is None else front + back
            return 0.5 * self.stiffness * (pressed * pressed)
        return 0.5 * (self.stiffness * (front * front) + self.back_stiffness * (back * back))

    def damper_power(self, rate, touching):
        """What the damper of the stop that is touched takes, <= 0; None where neither has one."""
        damping = self._damping(touching)
        return None if damping is None else -damping * rate * rate

    def guards(self, z, touching, width, back_width):
        """Positive while it lasts: the front stop is reached, a stop is left, the one behind is reached.

        width, back_width: natural sizes of the ways to the stops
        """
        front, back = self._closed(touching)
        reaches = front + back + (1.0 - front - back) * (self.gap - z) / width
        if self.back_gap is None:
            return reaches, 1.0 - front + front * (z - self.gap) / width
        leaves = 1.0 - front - back + front * (z - self.gap) / width - back * (z + self.back_gap) / back_width
        return reaches, leaves, front + back + (1.0 - front - back) * (z + self.back_gap) / back_width


# --- stops of a machine that is described ----------------------------------------------------------------------------


def elastic_stops(stop: Stop) -> ElasticStops:
    """The springs and dampers of a stop."""
    numbers = stop.gap, stop.back_gap, stop.stiffness, stop.back_stiffness, stop.damping, stop.back_damping
    return ElasticStops(*(None if each is None else as_sum(each) for each in numbers))


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
    return name


def ends(motion: Any) -> tuple:
    """What is positive until a run ends at a stop."""
    found = []
    for stop in motion.stops:
        if not stop.switches:
            way, (size, back_size) = stop.way.value, sizes(stop)
            found.append(written((as_sum(stop.gap) - way) / size))
            if stop.back_gap is not None:
                found.append(written((as_sum(stop.back_gap) + way) / back_size))
    return tuple(found)


def rooms(motion: Any) -> tuple:
    """(coordinate, least, most) of those that stops bound which no motion passes."""
    found = []
    for stop in motion.stops:
        if not stop.elastic:
            name = stopped(motion, stop)
            at = stop.way.value - motion.states[name]
            low = -math.inf if stop.back_gap is None else written(-as_sum(stop.back_gap) - at)
            found.append((name, low, written(as_sum(stop.gap) - at)))
    return tuple(found)


def guards(motion: Any) -> tuple:
    """Positive while it lasts, of each stop: it is reached in front, left, and reached behind where it is there too."""
    found = []
    for _, stop, touching in motion.switching:
        way, (size, back_size), gap = stop.way, sizes(stop), as_sum(stop.gap)
        if stop.elastic:
            found += [written(each) for each in elastic_stops(stop).guards(way.value, touching, size, back_size)]
            continue
        free = 1.0 - touching * touching
        found += [written(1.0 - free + free * ((gap - way.value) / size)), _pressed(motion, stop, touching)]
        if stop.back_gap is not None:
            found.append(written(1.0 - free + free * ((way.value + as_sum(stop.back_gap)) / back_size)))
    return tuple(found)


def _pressed(motion: Any, stop: Stop, touching: Sum) -> Any:
    """1; at a rigid stop what presses against it, over its natural size: h less M u' along the stretch, at rest."""
    name, free = stopped(motion, stop), 1.0 - touching * touching
    still = motion.at(_at_rest(motion, stop, touching))
    push = written(still.push(name))
    for other, acceleration in motion.accelerations.items():
        if other != name:
            push = sub(push, mul(written(still.inertia(name, other)), acceleration))
    for speed, friction in zip(motion.speeds, motion.inputs.frictions, strict=True):
        push = sub(push, friction) if speed == motion.rates[name] else push
    least = LEAST_PULL if stop.on_ground else 0.0
    return add(written(free + (1.0 - free) * least), mul(written(touching), div(push, written(as_sum(stop.force)))))


def _at_rest(motion: Any, stop: Stop, touching: Sum) -> Mapping[str, Any]:
    """All states of a body at rest at the stop that it touches, exactly."""
    front, back = which_stop(touching)
    wall = front * as_sum(stop.gap)
    wall = wall if stop.back_gap is None else wall - back * as_sum(stop.back_gap)
    if stop.on_ground:  # a state that touches nothing stays as it is
        free = 1.0 - touching * touching
        return _moved(motion, stop, wall + free * stop.way.value, free * stop.way.rate)
    return _moved(motion, stop, wall, Sum())


def _moved(motion: Any, stop: Stop, way: Any, rate: Any) -> dict[str, Any]:
    """Coordinates and speeds once the stretch of a stop has this value and this rate: the blow acts along its slope."""
    name = stopped(motion, stop)
    found = dict(motion.states)
    others = [each for each in motion.names if each != name]
    jump = rate - stop.way.rate
    if not stop.on_ground:
        rows = [[*(motion.inertia(i, j) for j in others), -(motion.inertia(i, name) * jump)] for i in others]
        for each, (change,) in zip(others, solved(rows, len(others)), strict=True):
            found[motion.rates[each]] = Sum.of(add(written(found[motion.rates[each]]), change))
    value = motion.states[name]
    found[name] = Sum.of(way) + (value - stop.way.value)
    found[motion.rates[name]] = Sum.of(motion.speed[name]) + jump
    return found


def outcomes(motion: Any) -> tuple[dict[str, Any], ...]:
    """Of each guard the states that change, by name, a stop's own by its number."""
    found: list[dict[Any, Any]] = []
    for number, stop, touching in motion.switching:
        sides = (1.0, 0.0, -1.0) if stop.back_gap is not None else (1.0, 0.0)
        for side in sides:
            if stop.elastic:
                found.append({number: side})
            elif side == 0.0:
                found.append({**_at_rest(motion, stop, touching), number: 0.0})
            else:
                rate, e = stop.way.rate, as_sum(stop.restitution)
                bounces = Sum.of(rebounds(written(side * (e * rate) / as_sum(stop.speed))))
                wall = as_sum(stop.gap) if side > 0.0 else -as_sum(stop.back_gap)
                after = _moved(motion, stop, wall, -(bounces * e * rate))
                found.append({**after, number: side * (1.0 - bounces)})
    return tuple({key: written(value) for key, value in each.items()} for each in found)
