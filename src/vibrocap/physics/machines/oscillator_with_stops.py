from typing import ClassVar

from pydantic import model_validator

from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import Positive, parameter, parameters
from vibrocap.physics.machines.oscillator import Oscillator
from vibrocap.physics.machines.stops import BackGap, StopDamping, StopStiffness, behind, elastic_stop
from vibrocap.physics.parameters import Fraction


@parameters
class OscillatorWithStops(Oscillator):
    """Oscillator that strikes a stop on the ground: in front at x = delta, and behind at x = -delta_b if given.

    Energy harvesters, impact absorbers, spool valves. Without `stop_stiffness` the stops are rigid walls, x' := -e x',
    with no impulse of friction, which is finite. A block that is pushed against a wall rests there after its rebounds,
    of which those slower than 1e-7 sqrt(N delta/m) are left out (`rebounds`), until the force W with which the wall
    pushes back (`wall_force`) would have to pull. At rest the wall takes all of that force and friction
    none: how they share it is open, the motion is not. On a running belt friction slides at the wall. With
    `stop_stiffness` the stops are springs (`Stop`), whose force counts as one from outside.
    """

    gap: Positive = parameter(0.8, "delta", "gap between block and front stop", "gap")
    back_gap: BackGap = parameter(None, "delta_b", "gap between block and rear stop; none: no rear stop", "gap")
    restitution: Fraction = parameter(0.7, "e", "coefficient of restitution of rigid stops, 0 to 1", "fraction")
    stop_stiffness: StopStiffness = parameter(
        None, "k_s", "spring of an elastic stop; none where the stops are rigid", "stiffness"
    )
    stop_damping: StopDamping = parameter(
        None, "c_s", "damper of an elastic stop; none where it has none", "viscous damping"
    )
    back_stop_stiffness: StopStiffness = behind("k_b", "spring", "stiffness")
    back_stop_damping: StopDamping = behind("c_b", "damper", "viscous damping")

    source: ClassVar[str] = "denhartog1931; shaw1983"
    name: ClassVar[str] = "oscillator-with-stops"

    @model_validator(mode="after")
    def _told_of_stops_that_there_are(self):
        behind = ("back_stop_stiffness", "back_stop_damping")
        for name in ("stop_damping", *behind):
            missing = "back_gap" if name in behind and self.back_gap is None else ""
            missing = missing or ("stop_stiffness" if self.stop_stiffness is None else "")
            if getattr(self, name) is not None and missing:
                raise ValueError(f"{name} should be left out without {missing}, got {getattr(self, name)}")
        return self

    def parts(self, q):
        ground, own = None, super().parts(q)
        sizes = {"size": self.gap, "speed": sqrt(self.normal_load * self.gap / self.mass), "force": self.normal_load}
        stop = elastic_stop(self, None, between=(ground, own[1]), restitution=self.restitution, **sizes)
        return [*own, stop]
