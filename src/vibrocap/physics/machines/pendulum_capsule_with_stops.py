import math
from typing import Annotated, Any, ClassVar

from pydantic import model_validator

from vibrocap.physics.machines.machine import Positive, parameter, parameters
from vibrocap.physics.machines.pendulum_capsule import PendulumCapsule
from vibrocap.physics.mechanics.parts import Stop
from vibrocap.physics.parameters import allowed

ENDS = "a number from 0 to 1, or be left out where a run is to end at the stop"
EndOrRestitution = Annotated[Any, allowed(ENDS, (None,), 1.0)]


@parameters
class PendulumCapsuleWithStops(PendulumCapsule):
    """Pendulum capsule whose pendulum is stopped at the angles theta_m and -theta_m: the floor, or limits of its drive.

    Without `restitution` a run ends there, with the status "stop reached". With it the pendulum bounces off the
    capsule, theta' := -e theta', without loss of momentum and with no impulse of friction, which is finite under a
    constant load (one that follows the motion is refused). A pendulum that is pushed against its stop rests there after
    its rebounds, see `RigidStopCapsule`.
    """

    limit_angle: Positive = parameter(math.pi / 2, "theta_m", "angle at which the pendulum is stopped", "phase")
    restitution: EndOrRestitution = parameter(
        None, "e", "coefficient of restitution of the stops, 0 to 1; none: a run ends there", "fraction"
    )

    source: ClassVar[str] = "liu2019; brogliato2016"
    name: ClassVar[str] = "pendulum-capsule-with-stops"

    @model_validator(mode="after")
    def _constant_load(self):
        if self.restitution is not None and self.follows_load:
            why = 'with normal_load = "dynamic", as a blow would have an impulse of the load'
            raise ValueError(f"restitution should be left out {why}, got {self.restitution}")
        return self

    def parts(self, q):
        gaps = {"gap": self.limit_angle, "back_gap": self.limit_angle}
        return [*super().parts(q), Stop(q.angle, **gaps, restitution=self.restitution)]
