"""Oscillators: a block on springs that rubs on a belt, also with stops, or with springs that couple motion and load."""

from typing import ClassVar

from pydantic import model_validator

from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import ConsistentUnits, NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.machines.stops import BackGap, StopDamping, StopStiffness, behind, elastic_stop
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Potential, Spring, Support, coordinate
from vibrocap.physics.parameters import Fraction


@parameters
class Oscillator(ConsistentUnits):
    """Block of mass m on a spring k and a damper c, on a belt of the speed v_b, moved by the force of the drive.

    The oldest machine of dry friction (Den Hartog 1931), and with a running belt the standard test of stick-slip. The
    block is at x; v = x' - v_b, over the belt, is the state, so that it is exactly zero while the contact sticks. A
    block that is pulled over fixed ground through a spring, whose far end moves at the speed V, is the same system: v_b
    = -V, and the stretch of the spring is -x (`pulled`). Without a spring it is a mass on the ground. Any consistent
    units may be used; with a law whose coefficients are forces in N, the normal load is 1.
    """

    mass: Positive = parameter(1.0, "m", "mass of the block", "mass")
    stiffness: NonNegative = parameter(1.0, "k", "stiffness of the spring", "stiffness")
    damping: NonNegative = parameter(0.0, "c", "viscous damper beside the spring", "viscous damping")
    belt_speed: Number = parameter(0.0, "v_b", "speed of the belt under the block", "speed")
    normal_load: Positive = parameter(
        1.0, "N", "load on the contact; 1 where the coefficients of the law are forces", "load"
    )

    name: ClassVar[str] = "oscillator"
    source: ClassVar[str] = "denhartog1931"
    first_case: ClassVar = {"machine.belt_speed": 0.1, "drive.amplitude": 0.2, "drive.frequency": 0.5}
    position = coordinate("x", "place of the block", "m", rate="sliding_velocity")
    si_load: ClassVar = "1 where the coefficients of the law are forces in N"

    @classmethod
    def pulled(cls, speed: float, **given: float) -> "Oscillator":
        """The block that is pulled at a speed through its spring over fixed ground; `given`: the other parameters.

        Its spring pulls with -k x, and the block has moved by x + V t.
        """
        return cls(belt_speed=-speed, **given)

    def parts(self, q):
        belt, block = Support("belt", x=self.belt_speed * q.time), Mass("block", self.mass, x=q.position)
        wall = Spring(self.stiffness, q.position), Damper(self.damping, q.position)
        return [belt, block, *wall, Drive(q.position), Contact(block, on=belt, load=self.normal_load)]


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
    first_case: ClassVar = {"drive.frequency": 0.5}

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


@parameters
class ModeCouplingBlock(ConsistentUnits):
    """Block on a belt, on springs that couple its motion along the belt, x, to that towards it, y.

    The smallest model in which a constant friction coefficient makes vibrations (Hoffmann, Fischer, Allgaier and Gaul,
    Mech. Res. Comm. 29, 2002, 197-205): pressed on, the block is pulled along. N = N_0 + k3 y, and k22 holds the
    stiffness k3 of the contact. On a faster belt, R = -mu N, the stiffness matrix is [[k11, k12 - mu k3], [k12, k22]]:
    without damping two frequencies meet, at sqrt((k11 + k22)/(2 m)), and one vibration grows, where

        mu > [(k11 - k22)^2/(4 k12) + k12]/k3

    The run ends where N falls to zero. Any consistent units may be used.
    """

    mass: Positive = parameter(1.0, "m", "mass of the block", "mass")
    sliding_stiffness: Positive = parameter(2.0, "k11", "stiffness along the belt", "stiffness")
    coupling_stiffness: Number = parameter(0.5, "k12", "stiffness that couples both directions", "stiffness")
    normal_stiffness: Positive = parameter(
        1.6, "k22", "stiffness towards the belt, the contact's included", "stiffness"
    )
    contact_stiffness: NonNegative = parameter(1.2, "k3", "stiffness of the contact", "stiffness")
    damping: NonNegative = parameter(0.0, "c", "viscous damper, in each direction", "viscous damping")
    belt_speed: Number = parameter(1.0, "v_b", "speed of the belt under the block", "speed")
    normal_load: Positive = parameter(1.0, "N_0", "load on the contact where y = 0", "load")

    name: ClassVar[str] = "mode-coupling-block"
    source: ClassVar[str] = "hoffmann2002"
    approach = coordinate("y", "place of the block towards the belt", "m")
    position = coordinate("x", "place of the block along the belt", "m", rate="sliding_velocity")
    first_case: ClassVar = {
        "machine.damping": 0.02,
        "machine.belt_speed": 0.1,
        "drive.amplitude": 0.1,
        "drive.frequency": 0.5,
    }
    gravity: ClassVar = None
    si_load: ClassVar = "1 where the coefficients of the law are forces in N"

    def parts(self, q):
        belt, block = Support("belt", x=self.belt_speed * q.time), Mass("block", self.mass, x=q.position, z=-q.approach)
        springs = Spring(self.sliding_stiffness, q.position), Spring(self.normal_stiffness, q.approach)
        coupling = Potential(self.coupling_stiffness * (q.position * q.approach))
        dampers = Damper(self.damping, q.position), Damper(self.damping, q.approach)
        pressed = Contact(block, on=belt, load=self.normal_load + self.contact_stiffness * q.approach)
        return [belt, block, *springs, coupling, *dampers, Drive(q.position), pressed]

    def sized_by(self):
        """k11, along the belt."""
        return self.sliding_stiffness
