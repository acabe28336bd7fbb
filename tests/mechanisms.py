"""Machines of one's own, described in the parts of `vibrocap.mechanics`, with their equations of motion by hand.

Of each the kinetic and the potential energy L = T - V and the generalised forces are written out for SymPy, from which
`test_mechanisms.py` makes Lagrange's equations: they share nothing with the parts.
"""

import math
from typing import ClassVar

import vibrocap as vc
from vibrocap.mechanics import (
    Contact,
    Damper,
    Drag,
    Drive,
    Inertia,
    Machine,
    Mass,
    NonNegative,
    Number,
    Point,
    Positive,
    Potential,
    Spring,
    Stop,
    Support,
    coordinate,
    cos,
    distance,
    offset,
    parameter,
    parameters,
    signal,
    sin,
)


@parameters
class ElasticSkin(Machine):
    """A capsule that stands on its runner through an elastic skin."""

    mass_ratio: Positive = parameter(2.0, "lambda", "capsule over inner mass", "mass")
    runner: Positive = parameter(0.5, "mu", "runner over inner mass", "mass")
    skin: NonNegative = parameter(8.0, "kappa", "skin", "stiffness")
    stiffness: NonNegative = parameter(1.0, "rho", "spring of the inner mass", "stiffness")
    damping: NonNegative = parameter(0.2, "nu", "both dampers", "viscous damping")
    displacement = coordinate("z", "inner mass from the capsule", "m")
    sway = coordinate("s", "capsule from the runner", "m")
    position = coordinate("X", "place of the runner", "m")
    name: ClassVar = "elastic-skin"

    def parts(self, q):
        """Runner, capsule and inner mass, each on the one before."""
        runner = Mass("runner", self.runner, x=q.position)
        capsule = Mass("capsule", self.mass_ratio, on=runner, x=q.sway)
        inner = Mass("inner mass", 1.0, on=capsule, x=q.displacement)
        springs = Spring(self.skin, q.sway), Spring(self.stiffness, q.displacement)
        dampers = Damper(self.damping, q.sway), Damper(self.damping, q.displacement)
        return runner, capsule, inner, springs, dampers, Drive(q.displacement), Contact(runner, load="weight")


@parameters
class CubicPendulum(Machine):
    """A pendulum capsule whose spring hardens, and may be negative at rest."""

    mass_ratio: Positive = parameter(2.5, "lambda", "capsule over bob", "mass")
    stiffness: Number = parameter(-0.5, "rho", "spring, may be negative", "torsional stiffness")
    cubic: NonNegative = parameter(2.0, "rho_3", "cubic spring", "torsional stiffness")
    damping: NonNegative = parameter(0.5, "nu", "damper", "torsional damping")
    angle = coordinate("theta", "angle of the pendulum", "rad")
    position = coordinate("X", "place of the capsule", "m")
    name: ClassVar = "cubic-pendulum"
    effort: ClassVar = "torque"

    def parts(self, q):
        """Capsule and bob, with both springs."""
        capsule = Mass("capsule", self.mass_ratio, x=q.position)
        bob = Mass("bob", 1.0, on=capsule, x=-sin(q.angle), z=cos(q.angle))
        springs = Spring(self.stiffness, q.angle), Potential(0.25 * self.cubic * q.angle**4)
        return capsule, bob, springs, Damper(self.damping, q.angle), Drive(q.angle), Contact(capsule)


@parameters
class Clutch(Machine):
    """Two inertias that rub; the clamping load is an input of its own."""

    engine: Positive = parameter(1.0, "J_1", "inertia of the engine", unit="kg m^2")
    vehicle: Positive = parameter(3.0, "J_2", "inertia of the vehicle", unit="kg m^2")
    shaft: NonNegative = parameter(4.0, "k", "shaft of the vehicle", "torsional stiffness")
    damping: NonNegative = parameter(0.2, "c", "drag of the vehicle", "torsional damping")
    preload: Positive = parameter(1.0, "N_0", "mean of the load, as a torque", unit="N m")
    clamp = signal("N", "change of the clamping load, as a torque", "N m", default=vc.Harmonic(0.3, 2.0))
    slip = coordinate("s", "engine from vehicle", "rad")
    angle = coordinate("phi", "angle of the vehicle", "rad")
    name: ClassVar = "own-clutch"
    effort: ClassVar = "torque"

    def parts(self, q):
        """Engine and vehicle."""
        vehicle = Inertia("vehicle", self.vehicle, q.angle)
        engine = Inertia("engine", self.engine, q.slip, on=vehicle)
        drag = Spring(self.shaft, q.angle), Damper(self.damping, q.angle)
        return vehicle, engine, drag, Drive(engine.turn), Contact(engine, on=vehicle, load=self.preload + q.clamp)


@parameters
class StackedPlates(Machine):
    """The drive shakes the upper plate, a spring holds it; friction carries the lower one along."""

    lower_mass: Positive = parameter(1.0, "m_1", "lower plate", "mass")
    upper_mass: Positive = parameter(0.5, "m_2", "upper plate", "mass")
    stiffness: NonNegative = parameter(2.0, "k", "spring of the upper plate to a wall", "stiffness")
    position = coordinate("x_1", "place of the lower plate", "m")
    upper = coordinate("x_2", "place of the upper plate", "m")
    name: ClassVar = "stacked-plates"

    def parts(self, q):
        """Two plates."""
        lower, upper = (
            Mass("lower plate", self.lower_mass, x=q.position),
            Mass("upper plate", self.upper_mass, x=q.upper),
        )
        rubs = Contact(lower, load=self.lower_mass + self.upper_mass), Contact(upper, on=lower, load=self.upper_mass)
        return lower, upper, Spring(self.stiffness, q.upper), Drive(q.upper), rubs


@parameters
class Feeder(Machine):
    """A part on a plate that vibrates along and across, as vibratory feeders do."""

    stroke: Number = parameter(0.4, "a", "stroke along", "distance")
    lift: Number = parameter(0.3, "b", "stroke across", "distance")
    rate: Positive = parameter(1.0, "Omega", "angular frequency of the plate", "frequency")
    phase: Number = parameter(0.9, "psi", "phase of the stroke across", "phase")
    position = coordinate("s", "place of the part on the plate", "m")
    name: ClassVar = "own-feeder"

    def parts(self, q):
        """The part on its plate."""
        turn = self.rate * q.time
        plate = Support("plate", x=self.stroke * sin(turn), z=self.lift * sin(turn + self.phase))
        part = Mass("part", 1.0, on=plate, x=q.position)
        return plate, part, Contact(part, on=plate), Drive(q.position)


@parameters
class BowedString(Machine):
    """Three modes of a string; the bow rubs at the point beta of its length."""

    frequency: Positive = parameter(1.0, "omega_1", "of the first mode", "frequency")
    damping: NonNegative = parameter(0.02, "zeta", "damping of each mode", "fraction")
    bow_speed: Number = parameter(0.2, "v_b", "speed of the bow", "speed")
    beta: Positive = parameter(0.15, "beta", "where the bow is", "fraction")
    mode = coordinate("a", "amplitude of each mode", "m", count=3)
    name: ClassVar = "bowed-string"

    def parts(self, q):
        """Modes, and the point of the string under the bow."""
        bow, results, point = Support("bow", x=self.bow_speed * q.time), [], 0.0
        for n, a in enumerate(q.mode, 1):
            own = n * self.frequency
            results += [Mass(f"mode {n}", 0.5, x=a), Spring(0.5 * own * own, a), Damper(self.damping * own, a)]
            point = a * sin(math.pi * n * self.beta) + point
        string = Point("string under the bow", x=point)
        return bow, results, string, Drive(q.mode[0]), Contact(string, on=bow, load=1.0)


@parameters
class RodRobot(Machine):
    """A body on two leaning legs that stretch as rods do; the drive pushes it down, the legs turn this into travel."""

    mass: Positive = parameter(1.0, "m", "body", "mass")
    foot: Positive = parameter(0.05, "m_f", "each foot", "mass")
    stiffness: Positive = parameter(40.0, "k", "legs along", "stiffness")
    bending: Positive = parameter(25.0, "k_b", "legs across", "stiffness")
    damping: NonNegative = parameter(1.5, "c", "legs", "viscous damping")
    lean: Number = parameter(0.3, "s", "how far feet stand behind hips", "distance")
    sag = coordinate("s", "how far the body has sunk", "m")
    pitch = coordinate("phi", "angle of the body", "rad")
    shift = coordinate("u", "body from where it stands over its first foot", "m")
    stretch = coordinate("w", "second foot from the first, less the distance of hips", "m")
    position = coordinate("X", "place of the first foot", "m")
    name: ClassVar = "rod-robot"

    def parts(self, q):
        """Feet, body and legs."""
        feet = [Mass("foot 1", self.foot, x=q.position), Mass("foot 2", self.foot, x=q.position + 1.0 + q.stretch)]
        x = q.position + self.lean + 0.5 + q.shift
        body = Mass("body", self.mass, x=x, z=1.0 - q.sag, inertia=0.1, angle=q.pitch)
        values = [*feet, body, Drive(-q.sag)]
        for foot, side in zip(feet, (-0.5, 0.5), strict=True):
            hip = Point(f"hip of {foot.name}", on=body, x=side)
            leg, across, length = distance(foot, hip), offset(foot, hip), (1.0 + self.lean**2) ** 0.5
            values += [hip, Spring(self.stiffness, leg, rest=length), Spring(self.bending, across, rest=self.lean)]
            values += [Damper(self.damping, leg), Damper(self.damping, across), Contact(foot)]
        return values


@parameters
class TubeCapsule(Machine):
    """A capsule in a tube that shakes; rigid walls of the tube bound its way."""

    shake = signal("a", "place of the tube", "m", default=vc.Harmonic(0.4, 1.0))
    way: Positive = parameter(0.6, "b", "from the middle to a wall", "distance")
    restitution: NonNegative = parameter(0.7, "e", "of the walls", "fraction")
    offset = coordinate("s", "capsule from the middle of the tube", "m")
    name: ClassVar = "tube-capsule"

    def parts(self, q):
        """A tube and the capsule in it."""
        tube = Support("tube", x=q.shake)
        capsule = Mass("capsule", 1.0, on=tube, x=q.offset)
        walls = Stop(between=(tube, capsule), gap=self.way, back_gap=self.way, restitution=self.restitution)
        return tube, capsule, walls, Drive(q.offset), Contact(capsule, on=tube, load=1.0)


@parameters
class BeltRow(Machine):
    """Two blocks on springs, on a belt that oscillates."""

    mass: Positive = parameter(1.0, "m", "mass of each block", "mass")
    stiffness: NonNegative = parameter(1.0, "k", "spring to the wall", "stiffness")
    coupling_stiffness: NonNegative = parameter(0.7, "kappa", "spring between blocks", "stiffness")
    belt = signal("b", "place of the belt", "m", default=vc.Harmonic(0.3, 1.0))
    position = coordinate("x", "place of each block", "m", rate="sliding_velocity", count=2)
    name: ClassVar = "belt-row"

    def parts(self, q):
        """Blocks on the belt."""
        belt, (first, second) = Support("belt", x=q.belt), q.position
        row = Mass("block 1", self.mass, x=first), Mass("block 2", self.mass, x=second)
        springs = [Spring(self.stiffness, x) for x in q.position], Spring(self.coupling_stiffness, second - first)
        return belt, row, springs, Drive(first), [Contact(block, on=belt, load=1.0) for block in row]


@parameters
class Washboard(Machine):
    """A block on ground whose friction repeats along it; as friction by place, or as a load by place."""

    depth: Number = parameter(0.8, "d", "change of friction along the ground", "fraction")
    drag: NonNegative = parameter(0.0, "c", "quadratic drag", "quadratic damping")
    position = coordinate("X", "place of the block", "m", rate="velocity", repeats=1.0)
    name: ClassVar[str] = "washboard"

    def parts(self, q):
        block = Mass("block", 1.0, x=q.position)
        around = Damper(0.5, q.position), Drag(self.drag, q.position, 0.1)
        return (
            block,
            Drive(q.position),
            *around,
            self.contact(block, 1.0 + self.depth * cos(2.0 * math.pi * q.position)),
        )

    def contact(self, block, factor):
        return Contact(block, load="weight", factor=factor)


@parameters
class Slider(Machine):
    """A stage on a rod that shakes: the rod gives the energy."""

    rod = signal("u", "place of the rod", "m", default=vc.Harmonic(0.1))
    position = coordinate("X", "place of the stage", "m")
    name: ClassVar = "slider"

    def parts(self, q):
        """Rod and stage."""
        rod, stage = Support("rod", x=q.rod), Mass("stage", 1.0, x=q.position)
        return rod, stage, Drive(q.position), Contact(stage, on=rod, load=1.0)


MECHANISMS = (
    *(ElasticSkin, CubicPendulum, Clutch, StackedPlates, Feeder, BowedString, RodRobot, TubeCapsule, BeltRow),
)
