"""Machines of the package and of one's own, described, against Lagrange's equations written for SymPy.

Their motions stand in `test_several_contacts.py`, beside those of an independent solver.
"""

import dataclasses
import functools
import math
import random
from typing import ClassVar

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

import vibrocap as vc
from mechanisms import MECHANISMS as OWN
from mechanisms import BeltRow, Washboard
from thinned import slow_but
from vibrocap.arguments import ArgumentError
from vibrocap.mechanics import (
    Contact,
    Drive,
    Machine,
    Mass,
    NonNegative,
    Point,
    Spring,
    Support,
    coordinate,
    cos,
    parameter,
    parameters,
    sin,
    sqrt,
)
from vibrocap.motion.recording.recorded_machine import drawn_length
from vibrocap.motion.shapes import moving_shapes

pytestmark = pytest.mark.plain

ROUNDING = 1e-12
LAW = vc.Exponential(coulomb_coefficient=0.05, static_coefficient=0.12)


class Energies:
    """T, V, Rayleigh's D, the drive and the path along which it acts, and the paths of contacts with their loads.

    load: an expression, or the lift off the ground along which the load is the force
    """

    def __init__(self, t, force):
        self.t, self.force, self.contacts = t, force, []
        self.kinetic, self.potential, self.lost, self.path = (sp.Integer(0),) * 4

    def body(self, mass, x, z=0, inertia=0, angle=0):
        speeds = (sp.diff(each, self.t) ** 2 for each in (x, z))
        self.kinetic += mass * sum(speeds) / 2 + inertia * sp.diff(angle, self.t) ** 2 / 2
        self.potential += mass * z

    def spring(self, stiffness, stretch):
        self.potential += stiffness * stretch**2 / 2

    def damper(self, damping, stretch):
        self.lost += damping * sp.diff(stretch, self.t) ** 2 / 2


def two_pendulums(m, e, q, u):
    e.body(m.mass_ratio, q["position"], u[0])
    own = ("angle", 1, 1, m.stiffness, 1), ("angle_2", m.mass_ratio_2, m.length_2, m.stiffness_2, m.share)
    for name, mass, length, k, share in own:
        e.body(mass, q["position"] - length * sp.sin(q[name]), u[0] + length * sp.cos(q[name]))
        e.spring(k, q[name])
        e.damper(m.damping, q[name])
        e.path += share * q[name]
    e.contacts = [(q["position"], u[0])]


def double_pendulum(m, e, q, u):
    first, second, x = q["angle"], q["angle_2"], q["position"]
    e.body(m.mass_ratio, x, u[0])
    e.body(1, x - sp.sin(first), u[0] + sp.cos(first))
    end = x - sp.sin(first) - m.length_2 * sp.sin(second), u[0] + sp.cos(first) + m.length_2 * sp.cos(second)
    e.body(m.mass_ratio_2, *end)
    for stretch in (first, second - first):
        e.spring(m.stiffness, stretch)
        e.damper(m.damping, stretch)
    e.path, e.contacts = first, [(x, u[0])]


def elastic_skin(m, e, q, u):
    x, s, z = q["position"], q["sway"], q["displacement"]
    for mass, place in ((m.runner, x), (m.mass_ratio, x + s), (1, x + s + z)):
        e.body(mass, place)
    for stiffness, stretch in ((m.skin, s), (m.stiffness, z)):
        e.spring(stiffness, stretch)
        e.damper(m.damping, stretch)
    e.path, e.contacts = z, [(x, m.runner + m.mass_ratio + 1)]


def cubic_pendulum(m, e, q, u):
    a, x = q["angle"], q["position"]
    e.body(m.mass_ratio, x, u[0])
    e.body(1, x - sp.sin(a), u[0] + sp.cos(a))
    e.spring(m.stiffness, a)
    e.potential += m.cubic * a**4 / 4
    e.damper(m.damping, a)
    e.path, e.contacts = a, [(x, u[0])]


def drill_string(m, e, q, u):
    turned = m.table_speed * e.t
    bit = turned + q["twist"] + q["twist_2"]
    for inertia, angle in ((m.disc_inertia, turned + q["twist"]), (m.bit_inertia, bit)):
        e.body(0, 0, 0, inertia, angle)
    for stretch in (q["twist"], q["twist_2"]):
        e.spring(m.stiffness, stretch)
        e.damper(m.damping, stretch)
    e.path, e.contacts = q["twist"], [(bit, m.normal_load)]


def clutch(m, e, q, u):
    slip, angle = q["slip"], q["vehicle_angle"]
    e.body(0, 0, 0, m.vehicle_inertia, angle)
    e.body(0, 0, 0, m.engine_inertia, angle + slip)
    e.spring(m.stiffness, angle)
    e.damper(m.damping, angle)
    e.damper(m.motor_damping, angle + slip - m.motor_speed * e.t)
    e.contacts = [(slip, m.normal_load + m.share * e.force)]


def own_clutch(m, e, q, u):
    slip, angle = q["slip"], q["angle"]
    e.body(0, 0, 0, m.vehicle, angle)
    e.body(0, 0, 0, m.engine, angle + slip)
    e.spring(m.shaft, angle)
    e.damper(m.damping, angle)
    e.path, e.contacts = angle + slip, [(slip, m.preload + sp.Rational(3, 10) * sp.cos(2 * e.t))]


def stacked_plates(m, e, q, u):
    lower, upper = q["position"], q["upper"]
    e.body(m.lower_mass, lower)
    e.body(m.upper_mass, upper)
    e.spring(m.stiffness, upper)
    e.path, e.contacts = upper, [(lower, m.lower_mass + m.upper_mass), (upper - lower, m.upper_mass)]


def feeder(m, e, q, u):
    turn = m.rate * e.t
    e.body(1, q["position"] + m.stroke * sp.sin(turn), u[0] + m.lift * sp.sin(turn + m.phase))
    e.path, e.contacts = q["position"], [(q["position"], u[0])]


def bowed_string(m, e, q, u):
    point = -m.bow_speed * e.t
    for n, name in enumerate(("mode", "mode_2", "mode_3"), 1):
        e.body(sp.Rational(1, 2), q[name])
        e.spring((n * m.frequency) ** 2 / 2, q[name])
        e.damper(m.damping * n * m.frequency, q[name])
        point += sp.sin(sp.pi * n * m.beta) * q[name]
    e.path, e.contacts = q["mode"], [(point, 1)]


def bristle_robot(m, e, q, u):
    feet = q["position"], q["position"] + 1 + q["stretch"]
    x, z = q["position"] + m.lean + sp.Rational(1, 2) + q["shift"], 1 - q["sag"]
    e.body(m.mass, x, z, m.inertia, q["pitch"])
    rest = sp.sqrt(1 + m.lean**2)
    for foot, lift, side in zip(feet, u, (-sp.Rational(1, 2), sp.Rational(1, 2)), strict=True):
        e.body(m.foot_mass, foot, lift)
        dx, dz = x + side * sp.cos(q["pitch"]) - foot, z + side * sp.sin(q["pitch"]) - lift
        along, across = (m.lean * dx + dz) / rest, (dx - m.lean * dz) / rest
        e.spring(m.stiffness, along - rest)
        e.spring(m.bending_stiffness, across)
        e.damper(m.damping, along)
        e.damper(m.damping, across)
    e.path, e.contacts = z + m.arm * sp.sin(q["pitch"]), list(zip(feet, u, strict=True))


def rod_robot(m, e, q, u):
    feet = q["position"], q["position"] + 1 + q["stretch"]
    x, z = q["position"] + m.lean + sp.Rational(1, 2) + q["shift"], 1 - q["sag"]
    e.body(m.mass, x, z, sp.Rational(1, 10), q["pitch"])
    for foot, lift, side in zip(feet, u, (-sp.Rational(1, 2), sp.Rational(1, 2)), strict=True):
        e.body(m.foot, foot, lift)
        dx, dz = x + side * sp.cos(q["pitch"]) - foot, z + side * sp.sin(q["pitch"]) - lift
        leg = sp.sqrt(dx**2 + dz**2)
        e.spring(m.stiffness, leg - (1 + m.lean**2) ** 0.5)
        e.spring(m.bending, dx - m.lean)
        e.damper(m.damping, leg)
        e.damper(m.damping, dx)
    e.path, e.contacts = -q["sag"], list(zip(feet, u, strict=True))


def tube_capsule(m, e, q, u):
    e.body(1, q["offset"] + sp.Rational(4, 10) * sp.cos(e.t))
    e.path, e.contacts = q["offset"], [(q["offset"], 1)]


def belt_row(m, e, q, u):
    first, second, belt = q["position"], q["position_2"], sp.Rational(3, 10) * sp.cos(e.t)
    for x in (first, second):
        e.body(m.mass, x)
        e.spring(m.stiffness, x)
    e.spring(m.coupling_stiffness, second - first)
    e.path, e.contacts = first, [(first - belt, 1), (second - belt, 1)]


MODELS = {
    vc.TwoPendulumCapsule: two_pendulums,
    vc.DoublePendulumCapsule: double_pendulum,
    vc.DrillString: drill_string,
    vc.Clutch: clutch,
    vc.BristleRobot: bristle_robot,
}
OTHERS = (
    *(elastic_skin, cubic_pendulum, own_clutch, stacked_plates, feeder),
    *(bowed_string, rod_robot, tube_capsule, belt_row),
)
MODELS |= zip(OWN, OTHERS, strict=True)
MECHANISMS = tuple(MODELS)


class Lagrange:
    """Lagrange's equations of one machine: M q'' = h - sum of R ds/dq, and the loads."""

    def __init__(self, machine):
        t, force = sp.Symbol("t"), sp.Symbol("F")
        self.machine, self.names = machine, list(machine.coordinates)
        q = {name: sp.Function(name)(t) for name in self.names}
        lifts = [sp.Function(f"lift_{i}")(t) for i in range(len(machine.contact_states))]
        e = Energies(t, force)
        MODELS[type(machine)](machine, e, q, lifts)
        places, rates, more = (sp.symbols(f"{s}0:{len(q)}") for s in "qwa")

        def plain(x):
            x = sp.sympify(x)
            for lift in lifts:
                x = x.subs(lift.diff(t, 2), 0).subs(lift.diff(t), 0).subs(lift, 0)
            for own, place, rate, acceleration in zip(q.values(), places, rates, more, strict=True):
                x = x.subs(own.diff(t, 2), acceleration).subs(own.diff(t), rate).subs(own, place)
            return x

        def equation(c):
            rate, path = c.diff(t), sp.sympify(e.path)
            kinetic = e.kinetic.diff(rate).diff(t) - e.kinetic.diff(c)
            return plain(kinetic + e.potential.diff(c) + sp.sympify(e.lost).diff(rate)) - force * plain(path.diff(c))

        rows = [equation(c) for c in (*q.values(), *lifts)]
        slides = [plain(sp.sympify(path).diff(t)) for path, _ in e.contacts]
        bends = [plain(sp.sympify(path).diff(t, 2)) for path, _ in e.contacts]
        plains = [plain(load) for _, load in e.contacts]
        pairs = zip((load for _, load in e.contacts), plains, strict=True)
        loads = [rows[len(q) + lifts.index(load)] if load in lifts else x for load, x in pairs]
        linear = [sp.Matrix(x) for x in (rows[: len(q)], slides, bends, loads)]
        values = [linear[0].jacobian(more), linear[1].jacobian(rates)]
        still = [x.subs(dict.fromkeys(more, 0)) for x in linear]
        values += [-still[0], linear[1].subs(dict.fromkeys(rates, 0)), still[2], still[3], linear[3].jacobian(more)]
        self.compute = sp.lambdify([t, *places, *rates, force], values, "numpy", cse=True)

    def at(self, t, y, force):
        """(M, slopes of paths, h, rate of paths at rest, their curvature, loads without q'', their slopes), q'."""
        state = dict(zip(self.machine.states, y, strict=True))
        n, speeds = len(self.names), list(self.machine.coordinates)
        q = [state[name] for name in self.names]
        _, S, _, moved, *_ = (np.asarray(x, float) for x in self.compute(t, *q, *[0.0] * n, force))
        rates = list(type(self.machine).kind().rates.values())
        A, right = np.eye(n), np.array([state[rate] for rate in rates])
        for c, name in enumerate(self.machine.contact_states):
            A[rates.index(name)], right[rates.index(name)] = S[c], state[name] - moved[c, 0]
        w = np.linalg.solve(A, right)
        assert speeds == self.names
        return [np.asarray(x, float) for x in self.compute(t, *q, *w, force)], w

    def rates(self, t, y, force, frictions):
        """(y' by name, loads), given the friction forces."""
        (M, S, h, _, bend, loads, by), w = self.at(t, y, force)
        a = np.linalg.solve(M, h[:, 0] - S.T @ np.array(frictions))
        table = dict(zip(self.names, w, strict=True)) | dict(zip(self.kind_rates, a, strict=True))
        table |= dict(zip(self.machine.contact_states, S @ a + bend[:, 0], strict=True))
        return table, loads[:, 0] + by @ a

    @property
    def kind_rates(self):
        return list(type(self.machine).kind().rates.values())


@functools.cache
def lagrange(kind):
    return Lagrange(kind())


ROBOT = [kind.name for kind in MECHANISMS].index("rod-robot")  # nearly the bristle robot of the package


@pytest.mark.parametrize("kind", slow_but({*range(len(MECHANISMS))} - {ROBOT}, MECHANISMS), ids=lambda kind: kind.name)
def test_described_machines_obey_lagrange(kind):
    machine, draw, worst = kind(), random.Random(1), 0.0
    for _ in range(20):
        y = [draw.uniform(-0.3, 0.3) if name not in kind.switched else 0.0 for name in kind.states]
        t, force = draw.uniform(0.0, 6.0), draw.uniform(-1.0, 1.0)
        frictions = tuple(draw.uniform(-0.5, 0.5) for _ in kind.contact_states)
        rates, loads = lagrange(kind).rates(t, y, force, frictions)
        own = dict(zip(kind.states, machine.rates(t, y, force, frictions), strict=True))
        size = 1.0 + max(map(abs, rates.values()))
        worst = max(worst, *(abs(rates[name] - own[name]) / size for name in rates))
        if machine.follows_load:
            reactions = [contact.reaction for contact in machine.contacts(t, y, force)]
            totals = [n + sum(s * r for s, r in zip(more, frictions, strict=True)) for n, *more in reactions]
        else:
            totals = machine.loads()
        worst = max(worst, *(abs(a - b) / size for a, b in zip(totals, loads, strict=True)))
    assert worst <= ROUNDING


def test_what_depends_on_time_is_not_its_mirror_image_half_a_period_later():
    """The load of the clutch in `mechanisms.py` repeats in any time but that of its drive."""
    symmetric = {kind.name for kind in MECHANISMS if kind().symmetric}
    assert "own-clutch" not in symmetric
    assert {"two-pendulum-capsule", "double-pendulum-capsule", "elastic-skin", "stacked-plates"} <= symmetric


@pytest.mark.parametrize(("name", "frequency"), [("own-clutch", 2.0), ("own-feeder", 0.5), ("belt-row", 1.0)])
def test_what_depends_on_time_repeats_in_the_period_of_the_drive(name, frequency):
    """Periods begin at time 0, so that a load, a table or a signal with another period would jump there."""
    kind = next(kind for kind in OWN if kind.name == name)
    system = vc.System(kind(), LAW, vc.Harmonic(frequency=frequency))
    with pytest.raises(ArgumentError, match=f"drive: has the period .*, after which the {name} is another: all that"):
        vc.System(kind(), LAW, vc.Harmonic(frequency=1.1 * frequency))
    over = {"drive.frequency": [frequency, 1.1 * frequency]}
    with pytest.raises(ValueError, match=f"after which the {name} is another"):
        vc.ensemble(system, over, periods=2, measures=["peak_friction"])
    with pytest.raises(ArgumentError, match=r"over: drive\.frequency decides whether the machine repeats"):
        vc.branch(system, "drive.frequency", (0.5 * frequency, frequency))  # both ends have a common period


def test_a_signal_without_a_frequency_has_that_of_the_drive():
    """As one that is given it at each frequency, run by run; a drive has its own."""
    drive, wave = vc.Square(0.4, 0.9), vc.Biharmonic(1.5, 0.9, 0.1, 0.4)
    waves, frequencies = (wave, dataclasses.replace(wave, frequency=None)), {"drive.frequency": [0.9, 1.1]}
    given, in_step = (vc.System(BeltRow(), vc.Coulomb(0.2, 0.3), drive, drives={"belt": own}) for own in waves)
    options = {"periods": 20, "measures": ["belt_work"]}
    expected = vc.ensemble(given, frequencies | {"drives.belt.frequency": [0.9, 1.1]}, **options)
    assert vc.ensemble(in_step, frequencies, **options)["belt_work"] == pytest.approx(expected["belt_work"], rel=1e-9)
    assert in_step.with_parameters({"drive.frequency": 1.1}).placed.waves[0].frequency == 1.1
    with pytest.raises(ArgumentError, match=r"drive\.frequency should be a positive number"):
        vc.System(BeltRow(), vc.Coulomb(), vc.Harmonic(frequency=None))


def test_a_part_on_a_feeder_obeys_its_equations():
    drive = vc.Biharmonic(0.7, 1.3, 0.2, 0.4)
    machine, draw = vc.Feeder(mass=1.7, vibration_angle=0.6).driven_by(drive), random.Random(4)
    for _ in range(20):
        t, s, p, friction = draw.uniform(0.0, 9.0), *(draw.uniform(-1.0, 1.0) for _ in range(3))
        slides = p - drive.slope(t) * math.cos(0.6)
        assert machine.rates(t, (s, p), 0.0, (friction,)) == pytest.approx((slides, -friction / 1.7), abs=1e-15)
        (contact,) = machine.contacts(t, (s, p), 0.0)
        n, *_ = contact.reaction
        assert contact.velocity == pytest.approx(slides, abs=1e-15)
        assert n == pytest.approx(1.7 * (1.0 + drive.curvature(t) * math.sin(0.6)), rel=1e-14)
        power = machine.powers(t, (s, p), 0.0, (friction,))[0]  # of what moves the plate
        assert power == pytest.approx(-friction * drive.slope(t) * math.cos(0.6), abs=1e-14)


@pytest.mark.parametrize("kind", slow_but(range(0, len(OWN), 2), OWN), ids=lambda kind: kind.name)
def test_they_keep_the_contract_of_machines(kind):
    report = vc.check_part(kind, motion=False)
    assert report.ok, str(report)


@parameters
class Weighed(Washboard):
    name: ClassVar[str] = "weighed-washboard"

    def contact(self, block, factor):
        return Contact(block, load=factor)


def pushed(machine, law=None, force=0.34):
    return vc.System(
        machine, law or vc.Coulomb(0.2, 0.2), vc.Harmonic(0.5, 1.0), environment=vc.Environment(force=force)
    )


def test_friction_by_place_is_that_of_a_load_by_place_and_leaves_the_load():
    motions = [vc.simulate(pushed(kind(), force=0.1), periods=8) for kind in (Washboard, Weighed)]
    one, other = motions
    assert one.certificate.ok
    np.testing.assert_allclose(one.event_times, other.event_times, rtol=1e-14)  # the weight is m g, with a g of 1
    for name in ("position", "friction"):
        np.testing.assert_allclose(one[name], other[name], rtol=0.0, atol=1e-13)
    assert {*one["reaction"]} == {1.0}
    assert np.ptp(other["reaction"]) > 1.0


@pytest.mark.parametrize("load", ["dynamic", 1.0])
def test_a_constant_factor_is_in_the_coefficients(load):
    """Also where the load follows the motion, and so the friction that the factor changes."""

    @parameters
    class Smooth(vc.PendulumCapsule):
        name: ClassVar[str] = "smooth-capsule"

        def parts(self, q):
            return [dataclasses.replace(x, factor=0.5) if isinstance(x, Contact) else x for x in super().parts(q)]

    systems = (
        vc.System(Smooth(normal_load=load), vc.Exponential(0.2, 0.4), vc.Harmonic(1.2, 1.0)),
        vc.System(vc.PendulumCapsule(normal_load=load), vc.Exponential(0.1, 0.2), vc.Harmonic(1.2, 1.0)),
    )
    one, other = (vc.simulate(system, periods=6, initial={"angle": 0.3}) for system in systems)
    assert one.certificate.ok
    assert one.event_times == pytest.approx(other.event_times, abs=1e-12)
    assert one["velocity"] == pytest.approx(other["velocity"], abs=1e-12)
    assert one["reaction"] == pytest.approx(other["reaction"] if load == "dynamic" else 1.0, rel=1e-12)


@pytest.mark.slow  # its kernel
def test_orbits_close_modulo_the_period_of_friction_along_the_ground():
    orbit = vc.orbit(pushed(Washboard()))
    assert orbit.winding == {"position": 2}  # two periods of the ground in one of the drive
    assert orbit.stable


@pytest.mark.plain(False)
def test_drag_is_quadratic_above_its_speed():
    """Against SciPy, with friction where it slides one way only; its power is the damper's."""
    machine = Washboard(depth=0.0, drag=0.7)
    motion = vc.simulate(pushed(machine, force=1.5), periods=3, initial={"velocity": 0.5})

    def rates(t, y):
        v = y[1]
        return [v, 0.5 * math.cos(t) + 1.5 - 0.5 * v - 0.7 * v * math.hypot(v, 0.1) - 0.2]

    end = 6.0 * math.pi
    other = solve_ivp(rates, (0.0, end), [0.0, 0.5], method="DOP853", rtol=1e-12, atol=1e-13)
    assert motion.certificate.ok
    assert other.y[1].min() > 0.0
    assert [motion["position"][-1], motion["velocity"][-1]] == pytest.approx(other.y[:, -1], abs=1e-8)
    assert machine.powers(0.0, (0.0, 2.0), 0.0)[1] == pytest.approx(-0.5 * 4.0 - 0.7 * 4.0 * math.hypot(2.0, 0.1))


@parameters
class Guided(Machine):
    """A slider on a circle whose friction counts its way along the line, which ends at a quarter turn."""

    angle = coordinate("phi", "angle of the slider", "rad")
    name: ClassVar[str] = "guided-slider"

    def parts(self, q):
        slider = Mass("slider", 1.0, x=sin(q.angle), z=-cos(q.angle))
        return slider, Drive(q.angle), Contact(slider, load=1.0)


def test_a_run_ends_where_the_path_of_a_contact_is_singular():
    """The slope cos(phi) of the path vanishes there; short of that the motion is that of its equation."""
    system = vc.System(Guided(), vc.Coulomb(0.1, 0.1), vc.Harmonic(2.5, 0.5))
    motion = vc.simulate(system, periods=5, initial={"angle": 0.3})
    assert motion.status is vc.Status.SINGULAR_PATH
    assert motion.state["angle"] == pytest.approx(0.5 * math.pi - 1e-4, abs=1e-8)

    def rates(t, y):
        a, w = y
        return [w, 2.5 * math.cos(0.5 * t) - math.sin(a) - 0.1 * math.cos(a)]

    end = 0.9 * motion.end
    other = solve_ivp(rates, (0.0, end), [0.3, 0.0], method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    angle, velocity = (float(x[0]) for x in motion.states([end]))
    assert [angle, velocity / math.cos(angle)] == pytest.approx(other, abs=1e-7)


@parameters
class Towed(Machine):
    """Two bodies at one place, but for a gap with a spring; a third one is carried by the second."""

    name = "towed"
    source: ClassVar[str] = "vibrocap"
    position = coordinate("X", "place of the rear body", "m")
    gap = coordinate("z", "opening of the gap", "m")

    def parts(self, q):
        rear, middle = Mass("rear", 1.0, x=q.position), Mass("middle", 1.0, x=q.position + q.gap)
        return [rear, middle, Mass("bob", 0.1, x=0.4, on=middle), Spring(2.0, q.gap), Contact(rear), Contact(middle)]


def test_bodies_that_would_stand_in_one_another_are_drawn_in_a_row():
    shapes = {each.name: each for each in Towed().scene(0.0, (0.3, 0.0, 0.25, 0.0))}
    assert shapes["rear"].places()[0][0] == 0.3
    assert shapes["middle"].places()[0][0] == pytest.approx(0.3 + 0.25 + 5.0)
    assert shapes["bob"].places()[0][0] == pytest.approx(shapes["middle"].places()[0][0] + 0.4)
    ends = shapes["spring between rear and middle"].places()
    assert [x for x, _ in ends] == pytest.approx([0.8, 5.05])


@parameters
class Bench(Machine):
    """A sledge on a spring, from which a bob hangs on a rod, in SI."""

    stiffness: NonNegative = parameter(1e5, "k", "spring", "stiffness")
    rod: NonNegative = parameter(0.0, "l", "rod", "distance")
    name: ClassVar[str] = "bench"
    source: ClassVar[str] = "vibrocap"
    si_scales: ClassVar = vc.SIScales
    position = coordinate("X", "place of the sledge", "m")
    angle = coordinate("phi", "angle of the rod", "rad")

    def parts(self, q):
        sledge, x, z = Mass("sledge", 2.0, x=q.position), self.rod * sin(q.angle), -self.rod * cos(q.angle)
        bob = Mass("bob", 1.0, on=sledge, x=x, z=z, inertia=1e-3, angle=q.angle)
        tip = Point("tip", on=bob, x=0.2, z=0.1)
        return [sledge, bob, tip, Spring(self.stiffness, q.position), Contact(sledge), Drive(q.position)]


def test_what_has_no_place_at_zero_is_drawn_by_its_natural_size():
    class Rail(Bench):
        name: ClassVar[str] = "rail"

        def parts(self, q):
            sledge, *_, spring, contact, drive = super().parts(q)
            return [sledge, Mass("bob", 1.0, on=sledge, z=sqrt(q.angle - 0.1)), spring, contact, drive]

    assert drawn_length(vc.System(Rail(), vc.Coulomb(), vc.Harmonic(3.0, 12.0))) == pytest.approx(2e-4)


def test_a_point_turns_with_its_body():
    *_, (x, z) = Bench(rod=0.3).evaluated("places", 0.0, (0.5, 0.0, 0.4, 0.0))
    sine, cosine = np.sin(0.4), np.cos(0.4)
    assert x == pytest.approx(0.5 + 0.3 * sine + 0.2 * cosine - 0.1 * sine, rel=1e-14)
    assert z == pytest.approx(-0.3 * cosine + 0.2 * sine + 0.1 * cosine, rel=1e-14)


@parameters
class CarriedCrawler(Machine):
    """A body on a belt that moves evenly, with an inner mass whose motion the drive imposes."""

    speed: NonNegative = parameter(0.5, "v_b", "speed of the belt", unit="m/s")
    name = "carried-crawler"
    effort = "displacement"
    ride = coordinate("x", "place on the belt", "m", rate="centre_velocity")

    def parts(self, q):
        belt = Support("belt", x=self.speed * q.time)
        body = Mass("body", 2.0, x=q.ride, on=belt)
        return [belt, body, Mass("inner mass", 1.0, on=body, x=q.imposed(q.drive)), Contact(body, on=belt, load=1.0)]


@pytest.mark.parametrize("machine", [vc.DrillString(), CarriedCrawler()])
@pytest.mark.parametrize("phase", [0.0, 0.3])
def test_what_a_table_takes_along_is_drawn_where_it_is_since_the_start(machine, phase):
    """A drive that is drawn is where it is in its period, also on the segments of one with corners."""
    imposed = machine.imposes_motion
    drive = vc.Trapezoid(amplitude=0.4, frequency=1.0) if imposed else vc.Harmonic(amplitude=0.4)
    motion = vc.simulate(vc.System(machine, vc.Coulomb(), drive), periods=3.0, start=vc.Start(phase=phase))
    times, since = motion.time, motion.time + phase * motion.period
    shapes = {each.shape.name: each.points[0, 0] for each in moving_shapes(motion, times)}
    speed, body, state = (0.5, "body", "ride") if imposed else (machine.table_speed, "disc", "twist")
    assert shapes[body] == pytest.approx(speed * since + motion.at(times, state), abs=1e-12)
    if imposed:
        assert shapes["inner mass"] - shapes[body] == pytest.approx(motion.at(times, "drive"), abs=1e-12)


@pytest.mark.parametrize(("stiffness", "rod", "length"), [(1e5, 0.0, 2e-4), (0.0, 0.2, 0.05), (0.0, 8.0, 1.0)])
def test_a_machine_in_metres_is_drawn_at_its_size(stiffness, rod, length):
    """A film and a page show 30 um of a stage, and not a body of a metre that stands still."""
    system = vc.System(Bench(stiffness, rod), vc.Coulomb(), vc.Harmonic(3.0, 12.0))
    motion = vc.simulate(system, periods=1, initial={"angle": 0.5})
    assert drawn_length(motion.system) == pytest.approx(length, rel=1e-12)
    shapes = {each.shape.name: each.points[0] for each in moving_shapes(motion, motion.time)}
    assert shapes["sledge"][0] == pytest.approx(motion.at(motion.time, "position") / length, rel=1e-12)
    far = shapes["bob"] - shapes["sledge"] - [[0.0], [0.25]]  # of the middle of the disc from that of the box
    assert np.hypot(*far) * length == pytest.approx(rod, abs=1e-12)
