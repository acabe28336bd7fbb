"""What machines with stops share: their optional parameters, elastic stops, pictures."""

import dataclasses
from typing import Annotated, Any

from pydantic import BeforeValidator

from vibrocap.physics.bodies import Shape


def _optional(wanted: str, high: float) -> BeforeValidator:
    """The check of a number from 0 to `high`, or None where it is left out; wanted: what is said of another value."""

    def checked(given: Any) -> Any:
        if given is None or (isinstance(given, (int, float)) and not isinstance(given, bool) and 0 <= given <= high):
            return None if given is None else float(given)
        raise ValueError(f"should be {wanted}")

    return BeforeValidator(checked)


MOST = 1e300  # of a number that is finite
BackGap = Annotated[Any, _optional("a number >= 0, or be left out where there is no stop behind", MOST)]
StopStiffness = Annotated[Any, _optional("a number >= 0, or be left out", MOST)]
StopDamping = Annotated[Any, _optional("a number >= 0, or be left out where the stop has no damper", MOST)]
EndOrRestitution = Annotated[
    Any, _optional("a number from 0 to 1, or be left out where a run is to end at the stop", 1.0)
]


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


def stop_shapes(x, gap, back_gap, half=0.15) -> tuple[Shape, ...]:
    """The stops about a place x; a mass of this half width touches them where it has gone its way."""
    behind = () if back_gap is None else (_stop("stop behind", x - back_gap - half),)
    return _stop("stop in front", x + gap + half), *behind


def _stop(name, x):
    return Shape("rod", name, ((x, 0.2), (x, 0.6)))
