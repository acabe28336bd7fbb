"""Bodies that vibration across the ground conveys: a part on a feeder, and a robot on bristles."""

from typing import ClassVar

from vibrocap.physics.dimensions.scales import WeightScales
from vibrocap.physics.elementary import cos, sin, sqrt
from vibrocap.physics.machines.machine import Machine, NonNegative, Number, Positive, parameter, parameters
from vibrocap.physics.mechanics.parts import Contact, Damper, Drive, Mass, Point, Spring, Support, coordinate
from vibrocap.physics.mechanics.pictures import Shape


@parameters
class Feeder(Machine):
    """Part on a plate that vibrates along a line at an angle to it, as vibratory feeders do (Sloot and Kruyt 1996).

    The load rises and falls with the plate, N = m (1 + d'' sin(beta)): friction holds on one way and lets go on the
    other. The drive is the displacement d of the plate, s the place of the part on it. The run ends where the part
    leaves the plate, at N = 0. Time is in units of sqrt(l/g), for any length l.
    """

    mass: Positive = parameter(1.0, "m", "mass of the part", "mass")
    vibration_angle: Number = parameter(0.3, "beta", "angle between the plate and the line of its motion", "phase")
    name: ClassVar[str] = "feeder"
    source: ClassVar[str] = "sloot1996"
    effort: ClassVar = "displacement"
    si_scales: ClassVar = WeightScales
    position = coordinate("s", "place of the part on the plate", "m", rate="centre_velocity")

    def parts(self, q):
        moved, angle = q.imposed(q.drive), self.vibration_angle
        plate = Support("plate", x=moved * cos(angle), z=moved * sin(angle))
        part = Mass("part", self.mass, on=plate, x=q.position)
        return [plate, part, Contact(part, on=plate)]


@parameters
class BristleRobot(Machine):
    """Bristle robot: a body on two leaning legs; the drive pushes it up and down, the legs turn this into travel.

    After Cicconofri and DeSimone (2015), with springs along and across each leg, whose directions stay as in the
    upright robot. The drive acts along the height of the motor. Time is in units of sqrt(l/g), length in the distance l
    of the hips.
    """

    mass: Positive = parameter(4.0, "m", "mass of the body", "mass")
    inertia: Positive = parameter(0.4, "J", "inertia of the body", "inertia")
    foot_mass: Positive = parameter(0.2, "m_f", "mass of each foot", "mass")
    stiffness: Positive = parameter(40.0, "k", "stiffness of a leg along it", "stiffness")
    bending_stiffness: Positive = parameter(10.0, "k_b", "stiffness of a leg across", "stiffness")
    damping: NonNegative = parameter(3.0, "c", "viscous dampers along and across a leg", "viscous damping")
    lean: Number = parameter(0.5, "s", "how far the feet stand behind the hips", "distance")
    arm: Number = parameter(0.2, "r", "how far the motor is in front of the middle of the body", "distance")
    name: ClassVar[str] = "bristle-robot"
    first_case: ClassVar = {"drive.frequency": 3.0}
    source: ClassVar[str] = "cicconofri2015"
    si_scales: ClassVar = WeightScales
    sag = coordinate("h", "how far the body has sunk", "m")
    pitch = coordinate("phi", "angle of the body", "rad")
    shift = coordinate("u", "how far the body is in front of its place at rest over foot 1", "m")
    stretch = coordinate("w", "distance of the feet, less that of the hips", "m")
    position = coordinate("X", "place of foot 1", "m")

    def parts(self, q):
        feet = [Mass(f"foot {i + 1}", self.foot_mass, x=q.position + i * (1.0 + q.stretch)) for i in (0, 1)]
        middle = q.position + self.lean + 0.5 + q.shift
        body = Mass("body", self.mass, x=middle, z=1.0 - q.sag, inertia=self.inertia, angle=q.pitch)
        motor = Point("motor", on=body, x=self.arm)
        parts, length = [*feet, body, motor, Drive(motor.height)], sqrt(1.0 + self.lean * self.lean)
        for foot, side, speed in zip(feet, (-0.5, 0.5), ("velocity", "velocity_2"), strict=True):
            hip = Point(f"hip of {foot.name}", on=body, x=side)
            ahead, up = hip.along - foot.along, hip.height - foot.height
            along, across = (self.lean * ahead + up) / length, (ahead - self.lean * up) / length
            parts += [hip, Spring(self.stiffness, along, rest=length), Spring(self.bending_stiffness, across)]
            parts += [Damper(self.damping, along), Damper(self.damping, across), Contact(foot, speed=speed)]
        return parts

    def scene(self, t, y):
        *feet, _, motor, hip_1, hip_2 = self.evaluated("places", t, y)
        shapes = [Shape("rod", "body", (hip_1, hip_2)), Shape("disc", "motor", (motor,), (0.3, 0.3))]
        for i, (foot, hip) in enumerate(zip(feet, (hip_1, hip_2), strict=True), start=1):
            shapes += [Shape("rod", f"leg {i}", (foot, hip)), Shape("hinge", f"hip {i}", (hip,))]
            shapes.append(Shape("contact", f"contact {i}", (foot,), (0.25, 0.0)))
        return tuple(shapes)
