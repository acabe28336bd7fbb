"""Bodies that only turn, so that friction and its load are torques: a drill string, and a clutch."""

from typing import ClassVar

from vibrocap.physics.machines.machine import ConsistentUnits, NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Inertia, Spring, Support, coordinate


@parameters
class DrillString(ConsistentUnits):
    """Drill string: a table that turns steadily drives a disc and, below it, the bit, which rubs on the rock.

    Drill strings stick and slip as a block on a belt does, with a torsional spring of many turns (Leine et al. 1998).
    phi_1 and phi_2 are the twists of the strings above disc and bit, v = Omega + phi_1' + phi_2' is the speed of the
    bit. R is a torque, its load N too. Any consistent units may be used, SI as well as none.
    """

    disc_inertia: Positive = parameter(2.0, "J_1", "inertia of the disc", "inertia")
    bit_inertia: Positive = parameter(0.5, "J_2", "inertia of the bit", "inertia")
    stiffness: Positive = parameter(1.0, "k", "torsional stiffness of each string", "torsional stiffness")
    damping: NonNegative = parameter(0.05, "c", "torsional damper of each string", "torsional damping")
    table_speed: Number = parameter(0.3, "Omega", "angular speed of the table", "frequency")
    normal_load: Positive = parameter(1.0, "N", "load on the bit, as a torque", "torque")
    name: ClassVar[str] = "drill-string"
    first_case: ClassVar = {"drive.amplitude": 0.3, "drive.frequency": 0.5}
    source: ClassVar[str] = "leine1998"
    effort: ClassVar = "torque"
    twist = coordinate("phi", "twist of each string", "rad", count=2)

    def parts(self, q):
        table = Support("table", angle=self.table_speed * q.time)
        disc = Inertia("disc", self.disc_inertia, q.twist[0], on=table)
        bit = Inertia("bit", self.bit_inertia, q.twist[1], on=disc)
        strings = [(Spring(self.stiffness, s), Damper(self.damping, s)) for s in q.twist]
        return [table, disc, bit, strings, Drive(q.twist[0]), Contact(bit, load=self.normal_load, speed="bit_speed")]


@parameters
class Clutch(ConsistentUnits):
    """Clutch: two inertias that rub on each other under a load that the drive changes, N = N_0 + a drive.

    A motor, with the torque c_m (Omega - phi' - s'), turns the engine. phi is the angle of the vehicle, on its shaft, s
    the slip of the engine from it (after Pfeiffer and Glocker 1996). R, N and the drive are torques. Any consistent
    units may be used.
    """

    engine_inertia: Positive = parameter(1.0, "J_1", "inertia of the engine", "inertia")
    vehicle_inertia: Positive = parameter(3.0, "J_2", "inertia of the vehicle", "inertia")
    stiffness: NonNegative = parameter(4.0, "k", "torsional stiffness of the shaft", "torsional stiffness")
    damping: NonNegative = parameter(0.2, "c", "torsional damper of the vehicle", "torsional damping")
    motor_speed: Number = parameter(1.0, "Omega", "angular speed at which the motor has no torque", "frequency")
    motor_damping: NonNegative = parameter(0.3, "c_m", "drop of its torque over its speed", "torsional damping")
    normal_load: Positive = parameter(1.0, "N_0", "mean load, as a torque", "torque")
    share: Number = parameter(0.4, "a", "change of the load over the drive", "share")
    name: ClassVar[str] = "clutch"
    source: ClassVar[str] = "pfeiffer1996"
    effort: ClassVar = "torque"
    slip = coordinate("s", "angle of the engine from the vehicle", "rad")
    vehicle_angle = coordinate("phi", "angle of the vehicle", "rad")

    def parts(self, q):
        motor = Support("motor", angle=self.motor_speed * q.time)
        vehicle = Inertia("vehicle", self.vehicle_inertia, q.vehicle_angle)
        engine = Inertia("engine", self.engine_inertia, q.slip, on=vehicle)
        shaft = Spring(self.stiffness, q.vehicle_angle), Damper(self.damping, q.vehicle_angle)
        rubs = Contact(engine, on=vehicle, load=self.normal_load + self.share * q.drive)
        return [motor, vehicle, engine, shaft, Damper(self.motor_damping, engine.turn - motor.turn), rubs]
