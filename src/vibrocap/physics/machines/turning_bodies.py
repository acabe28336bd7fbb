"""Bodies that only turn, so that friction and its load are torques: a drill string, and a clutch."""

import math
from typing import Annotated, Any, ClassVar

from pydantic import Field

from vibrocap.physics.elementary import cos, sqrt
from vibrocap.physics.machines.machine import Machine, NonNegative, Number, Positive, SIScales, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Inertia, Spring, Support, coordinate

Fraction = Annotated[float, Field(strict=True, ge=0.0, le=1.0)]


class TurningBodies(Machine):
    """What both have in common: a torque as drive, any consistent units, natural sizes from load and inertia."""

    stiffness: Any
    normal_load: Any
    effort: ClassVar = "torque"
    si_scales: ClassVar = SIScales

    def _inertia(self):
        """That which is told by its size."""
        raise NotImplementedError

    def scales(self, time=1.0):
        """Angle and speed that a torque of the size of the load makes, as of an `Oscillator`."""
        inertia = self._inertia()
        stiffness = self.stiffness + inertia * (2.0 * math.pi / time) * (2.0 * math.pi / time)
        return (self.normal_load / stiffness, self.normal_load / sqrt(inertia * stiffness)) * 2

    def effort_scale(self):
        """N."""
        return self.normal_load


@parameters
class DrillString(TurningBodies):
    """Drill string: a table that turns steadily drives a disc and, below it, the bit, which rubs on the rock.

    Drill strings stick and slip as a block on a belt does, with a torsional spring of many turns (Leine et al. 1998).
    With the twists phi_1, phi_2 of the strings above disc and bit, and the speed v of the bit,

        v = Omega + phi_1' + phi_2',     J_2 v' = -k phi_2 - c phi_2' - R
        J_1 phi_1'' = drive - k phi_1 - c phi_1' + k phi_2 + c phi_2'

    R is a torque, its load N too. Any consistent units may be used, SI as well as none.
    """

    disc_inertia: Positive = parameter(2.0, "J_1", "inertia of the disc", "inertia")
    bit_inertia: Positive = parameter(0.5, "J_2", "inertia of the bit", "inertia")
    stiffness: Positive = parameter(1.0, "k", "torsional stiffness of each string", "torsional stiffness")
    damping: NonNegative = parameter(0.05, "c", "torsional damper of each string", "torsional damping")
    table_speed: Number = parameter(0.3, "Omega", "angular speed of the table", "frequency")
    normal_load: Positive = parameter(1.0, "N", "load on the bit, as a torque", "torque")
    name: ClassVar[str] = "drill-string"
    source: ClassVar[str] = "leine1998"
    twist = coordinate("phi", "twist of each string", "rad", count=2)

    def _inertia(self):
        return self.disc_inertia + self.bit_inertia

    def parts(self, q):
        """Table, disc and bit, and the strings between them."""
        table = Support("table", angle=self.table_speed * q.time)
        disc = Inertia("disc", self.disc_inertia, q.twist[0], on=table)
        bit = Inertia("bit", self.bit_inertia, q.twist[1], on=disc)
        strings = [(Spring(self.stiffness, s), Damper(self.damping, s)) for s in q.twist]
        return [table, disc, bit, strings, Drive(q.twist[0]), Contact(bit, load=self.normal_load, speed="bit_speed")]


@parameters
class Clutch(TurningBodies):
    """Clutch: two inertias that rub on each other under a load that rises and falls; the drive turns the engine.

    With the angle phi of the vehicle, on its shaft, and the slip s of the engine from it,

        J_1 (phi'' + s'') = drive - R,     J_2 phi'' = R - k phi - c phi',     N = N_0 [1 + a cos(omega t)]

    (Pfeiffer and Glocker 1996). R is a torque, its load N too. A run has the period of its drive: choose it so that the
    load repeats in it. Any consistent units may be used, SI as well as none.
    """

    engine_inertia: Positive = parameter(1.0, "J_1", "inertia of the engine", "inertia")
    vehicle_inertia: Positive = parameter(3.0, "J_2", "inertia of the vehicle", "inertia")
    stiffness: NonNegative = parameter(4.0, "k", "torsional stiffness of the shaft", "torsional stiffness")
    damping: NonNegative = parameter(0.2, "c", "torsional damper of the vehicle", "torsional damping")
    normal_load: Positive = parameter(1.0, "N_0", "mean load, as a torque", "torque")
    load_swing: Fraction = parameter(0.3, "a", "amplitude of the load over its mean, 0 to 1", "fraction")
    load_frequency: Positive = parameter(2.0, "omega", "angular frequency of the load", "frequency")
    name: ClassVar[str] = "clutch"
    source: ClassVar[str] = "pfeiffer1996"
    slip = coordinate("s", "angle of the engine from the vehicle", "rad")
    angle = coordinate("phi", "angle of the vehicle", "rad")

    def _inertia(self):
        return self.engine_inertia + self.vehicle_inertia

    def parts(self, q):
        """Engine and vehicle."""
        vehicle = Inertia("vehicle", self.vehicle_inertia, q.angle)
        engine = Inertia("engine", self.engine_inertia, q.slip, on=vehicle)
        load = self.normal_load * (1.0 + self.load_swing * cos(self.load_frequency * q.time))
        shaft = Spring(self.stiffness, q.angle), Damper(self.damping, q.angle)
        return [vehicle, engine, *shaft, Drive(engine.turn), Contact(engine, on=vehicle, load=load)]
