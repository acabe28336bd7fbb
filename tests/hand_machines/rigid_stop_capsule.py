"""The capsule with rigid stops: its inner mass bounces off a wall, on one side or on both."""

import math
from typing import Annotated, ClassVar

from pydantic import Field

from hand_machines.stops import BackGap, stop_shapes
from hand_machines.two_mass_capsule import TwoMassCapsule
from vibrocap.physics.machines.machine import IMPACT, Machine, NonNegative, Shape, parameter, parameters, rebounds

Restitution = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)]


@parameters
class RigidStopCapsule(TwoMassCapsule):
    """Two-mass capsule in which the inner mass strikes a rigid wall: forward, and back too where `back_gap` is given.

    Newton's law of impact, at z = delta with z' > 0 (or at z = -delta_b with z' < 0):

        z' := -e z',     lambda X' + (X' + z') stays,     lambda/(lambda + 1) (1 - e^2) z'^2/2 is lost

    Dry friction is finite, so that its impulse at that instant is zero. Rebounds of a mass that is pushed against the
    wall follow one another ever faster, without end in a finite time (Zeno). Where the next one would be slower than
    1e-7 natural speeds, and rise by rounding only, it is left out: the masses continue together, with the momentum
    that they have (z' = 0), until the wall would have to pull:

        together   (lambda + 1) X'' = [drive] - R,     until  drive - F - X'' = 0
    """

    restitution: Restitution = parameter(0.5, "e", "coefficient of restitution of the stops, 0 to 1", "fraction")
    gap: NonNegative = parameter(0.2, "delta", "way of the mass to the stop in front", "gap")
    back_gap: BackGap = parameter(
        None, "delta_b", "way of the mass to the stop behind; none where there is no such stop", "gap"
    )

    source: ClassVar[str] = "liu2013; brogliato2016"
    name: ClassVar[str] = "rigid-stop-capsule"
    mechanism = Machine.mechanism  # stops have no part there
    states: ClassVar = (*TwoMassCapsule.states, "touching")
    symmetry: ClassVar = (-1, -1, -1, -1, -1)
    switched: ClassVar = ("touching",)
    switch_events: ClassVar = ("impact", "stop_opened", "impact")
    locked: ClassVar = {"touching": ("displacement", "displacement_rate")}
    channels: ClassVar = ("drive", "damper", IMPACT)

    @property
    def symmetric(self) -> bool:
        """Only with stops on both sides at the same distance."""
        return self.back_gap is not None and self.back_gap == self.gap

    def room(self):
        """Between the stops."""
        return {"displacement": (-math.inf if self.back_gap is None else -self.back_gap, self.gap)}

    def masses(self):
        """lambda + 1: together or apart, gravity pulls at both; `pull` has what it does to the mass in the capsule."""
        return {"velocity": self.mass_ratio + 1.0}

    def pull(self, y):
        """F, and the weight of the mass along a slope."""
        return super().pull(y) if self.gravity is None else super().pull(y) + self.gravity[1]

    def _at_wall(self, y):
        """The state of a mass at rest at the wall that it touches, exactly, with the same momentum."""
        front = 0.5 * y[4] * (y[4] + 1.0)
        wall = front * self.gap
        if self.back_gap is not None:
            wall = wall - 0.5 * y[4] * (y[4] - 1.0) * self.back_gap
        return wall, 0.0, y[2], y[3] + y[1] / (self.mass_ratio + 1.0), y[4]

    def _held(self, t, y, drive):
        """R that keeps X'' = 0: of a capsule together with its mass all forces from outside."""
        together = y[4] * y[4]
        return (1.0 - together) * super()._held(t, y, drive) + together * self.outer_force(t, y, drive)

    def _capsule_acceleration(self, t, y, drive, frictions):
        """X'' = (holding force - R)/lambda, or over lambda + 1 together."""
        return (self._held(t, y, drive) - frictions[0]) / (self.mass_ratio + y[4] * y[4])

    def rates(self, t, y, drive, frictions):
        """y' = (z', z'', X', X'', 0); together z'' = 0."""
        capsule = self._capsule_acceleration(t, y, drive, frictions)
        free = 1.0 - y[4] * y[4]
        return y[1], free * (drive - self.pull(y) - capsule), y[3], capsule, 0.0

    def energy(self, t, y):
        """H, with the height of the mass in the capsule on a slope."""
        return super().energy(t, y) if self.gravity is None else super().energy(t, y) + self.gravity[1] * y[0]

    def powers(self, t, y, drive, frictions):
        """Powers of drive and damper; impacts take their energy at one instant."""
        return *super().powers(t, y, drive, frictions), 0.0

    def switches(self, t, y, drive, frictions):
        """The mass reaches the wall in front; the wall would have to pull; it reaches the one behind."""
        together = y[4] * y[4]
        free = 1.0 - together
        reaches = together + free * (self.gap - y[0]) / (1.0 + self.gap)
        pressed = free + y[4] * (
            drive - self.pull(self._at_wall(y)) - self._capsule_acceleration(t, y, drive, frictions)
        )
        if self.back_gap is None:
            return reaches, pressed
        return reaches, pressed, together + free * (y[0] + self.back_gap) / (1.0 + self.back_gap)

    def after_switch(self, which, t, y, drive, frictions):
        """It bounces, or stays at the wall; it leaves the wall, from rest."""
        if which == 1:
            return *self._at_wall(y)[:4], 0.0
        side = 1.0 if which == 0 else -1.0
        bounces = rebounds(side * self.restitution * y[1])
        rebound = -bounces * self.restitution * y[1]
        capsule = y[3] + (y[1] - rebound) / (self.mass_ratio + 1.0)
        wall = self.gap if which == 0 else -self.back_gap  # so that rounding does not add up over many rebounds
        return wall, rebound, y[2], capsule, side * (1.0 - bounces)

    def scene(self, t, y) -> tuple[Shape, ...]:
        """With the walls: the nearest sides of the mass touch them where it has gone its way."""
        return *super().scene(t, y), *stop_shapes(y[2], self.gap, self.back_gap)
