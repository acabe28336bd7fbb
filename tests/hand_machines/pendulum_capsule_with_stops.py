"""The pendulum capsule with stops: its pendulum can swing so far only, where a run ends or the pendulum bounces."""

import math
from typing import ClassVar

from pydantic import model_validator

from hand_machines.pendulum_capsule import PendulumCapsule
from hand_machines.stops import EndOrRestitution
from vibrocap.physics.machines.machine import (
    IMPACT,
    Machine,
    Positive,
    Shape,
    cos,
    parameter,
    parameters,
    rebounds,
    sin,
)

# What is drawn, in lengths of the pendulum: the pivot on top of the capsule and a corner beside it; a stop from here to
# there on a line through the pivot, which the bob touches when its middle is that angle before it.
PIVOT, CORNER, STOP = 0.5, 0.6, (0.8, 1.2)
TOUCHING = math.asin(0.15)


@parameters
class PendulumCapsuleWithStops(PendulumCapsule):
    """Pendulum capsule whose pendulum is stopped at the angles theta_m and -theta_m: the floor, or limits of its drive.

    Without `restitution` a run ends there, with the status "stop reached". With it the pendulum bounces off the
    capsule, of whose momentum nothing is lost, and of the energy (1 - e^2) B theta'^2/(2 (lambda+1)),

        theta' := -e theta',     (lambda+1) X' - cos(theta) theta' stays

    with no impulse of friction, which is finite under a constant load; a load that follows the motion would have one,
    and is refused. A pendulum that is pushed against its stop rests there after its rebounds, see `RigidStopCapsule`:

        together   (lambda+1) X'' = -R,     until  P + cos(theta) X'' = 0
    """

    limit_angle: Positive = parameter(math.pi / 2, "theta_m", "angle at which the pendulum is stopped", "phase")
    restitution: EndOrRestitution = parameter(
        None, "e", "coefficient of restitution of the stops, 0 to 1; none: a run ends there", "fraction"
    )

    source: ClassVar[str] = "liu2019; brogliato2016"
    name: ClassVar[str] = "pendulum-capsule-with-stops"
    mechanism = Machine.mechanism  # stops have no part there
    states: ClassVar = (*PendulumCapsule.states, "touching")
    symmetry: ClassVar = (-1, -1, -1, -1, -1)
    switched: ClassVar = ("touching",)
    switch_events: ClassVar = ("impact", "stop_opened", "impact")
    locked: ClassVar = {"touching": ("angle", "angle_rate")}
    bound_kinds: ClassVar = ("stop_reached", "stop_reached")
    channels: ClassVar = ("drive", "damper", IMPACT)

    @model_validator(mode="after")
    def _constant_load(self):
        if self.restitution is not None and self.follows_load:
            raise ValueError(
                'restitution should be left out with normal_load = "dynamic", as a blow would have an impulse of the '
                f"load, got {self.restitution}"
            )
        return self

    def room(self):
        """Between the stops."""
        return {"angle": (-self.limit_angle, self.limit_angle)}

    def _free(self, y):
        """1; 0 at a stop."""
        return 1.0 - y[4] * y[4]

    def _at_stop(self, y):
        """The state of a pendulum at rest at the stop that it touches, exactly, with the same momentum."""
        angle = y[4] * self.limit_angle
        return angle, 0.0, y[2], y[3] - cos(y[0]) * y[1] / (self.mass_ratio + 1.0), y[4]

    def _inertia(self, y):
        """B; lambda + 1 at a stop."""
        return self.mass_ratio + 1.0 - self._free(y) * (cos(y[0]) * cos(y[0]))

    def _reaction(self, y, drive):
        """That of the free pendulum, or the weight."""
        inertia, own, slope = super()._reaction(y, drive)
        free = self._free(y)
        weight = self._towards_ground(self.mass_ratio + 1.0)
        return inertia, free * own + (1.0 - free) * (inertia * weight), free * slope

    def _held(self, y, drive):
        """R that keeps X'' = 0; none at a stop."""
        return self._free(y) * (cos(y[0]) * self._torque(y, drive)) - sin(y[0]) * (y[1] * y[1])

    def accelerations(self, t, y, drive, force):
        """(theta'', X''); at a stop theta'' = 0."""
        pendulum, capsule = super().accelerations(t, y, drive, force)
        return self._free(y) * pendulum, capsule

    def rates(self, t, y, drive, frictions):
        """y' = (theta', theta'', X', X'', 0)."""
        return *super().rates(t, y, drive, frictions), 0.0

    def powers(self, t, y, drive, frictions):
        """Powers of drive and damper; impacts take their energy at one instant."""
        return *super().powers(t, y, drive, frictions), 0.0

    def _ways(self, y):
        """Way to each stop, over the natural size of the angle."""
        width = 1.0 + self.limit_angle
        return (self.limit_angle - y[0]) / width, (self.limit_angle + y[0]) / width

    def bounds(self, t, y):
        """The stops, where a run ends at them."""
        return self._ways(y) if self.restitution is None else ()

    def switches(self, t, y, drive, frictions):
        """The pendulum reaches one stop; the stop would have to pull; it reaches the other one."""
        if self.restitution is None:
            return ()
        free, (front, back) = self._free(y), self._ways(y)
        resting = self._at_stop(y)
        capsule = (self._held(resting, drive) - frictions[0]) / (self.mass_ratio + 1.0)
        pressed = free + y[4] * (self._torque(resting, drive) + cos(resting[0]) * capsule)
        return 1.0 - free + free * front, pressed, 1.0 - free + free * back

    def after_switch(self, which, t, y, drive, frictions):
        """It bounces, or stays at the stop; it leaves the stop, from rest."""
        if which == 1:
            return *self._at_stop(y)[:4], 0.0
        side = 1.0 if which == 0 else -1.0
        bounces = rebounds(side * self.restitution * y[1])
        rebound = -bounces * self.restitution * y[1]
        capsule = y[3] + (cos(self.limit_angle) * rebound - cos(y[0]) * y[1]) / (self.mass_ratio + 1.0)
        return side * self.limit_angle, rebound, y[2], capsule, side * (1.0 - bounces)

    def scene(self, t, y) -> tuple[Shape, ...]:
        """With the stops, each on an arm from a corner of the capsule: the bob touches them at the limit angle."""
        stops = (_stop(y[2], side, self.limit_angle) for side in (1.0, -1.0))
        return *super().scene(t, y), *(shape for stop in stops for shape in stop)


def _stop(x, side, limit_angle) -> tuple[Shape, Shape]:
    """The stop of one side and its arm, of a capsule at x."""
    angle = limit_angle + TOUCHING
    ends = tuple((x - side * (distance * sin(angle)), PIVOT + distance * cos(angle)) for distance in STOP)
    name = "stop behind" if side > 0.0 else "stop in front"
    return Shape("rod", name, ends), Shape("rod", f"arm of the {name}", ((x - side * CORNER, PIVOT), ends[0]))
