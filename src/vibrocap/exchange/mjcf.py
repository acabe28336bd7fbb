"""A case as the nearest MuJoCo model, in MJCF, and in words what that model loses.

MuJoCo's friction is a soft constraint: its friction loss and its contacts know one level of friction, creep at rest and
take events at whole steps. What a case says beyond that is named, part by part. A `judgement` runs both to their end.
"""

import dataclasses
import importlib
import math
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_positive, require, shown
from vibrocap.case.case import Case
from vibrocap.files import write_text
from vibrocap.measures.recorded.travel import drift
from vibrocap.motion.recording.recorded_machine import drawn_length
from vibrocap.motion.simulate import initial_state
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.environment import Environment
from vibrocap.physics.friction.law import Law
from vibrocap.physics.mechanics.pictures import Body, Mechanism
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System

STEPS = 500  # in the shortest time of the machine; the error at the end falls in proportion to the step
IMPEDANCE = 0.9999  # of constraints, the largest that MuJoCo admits: how little a contact at rest creeps
POINT = 1e-12  # moment of inertia of a point mass over m l^2: MuJoCo takes none that is zero,
SMALLEST_INERTIA = 2e-15  # or smaller than 1e-15
RESTS = 1e-9  # of the natural speed: slower than that the level of friction is that at rest


@dataclasses.dataclass(frozen=True)
class MujocoModel:
    """A MuJoCo model of a case.

    text: the MJCF. lost: what of the case the model does not say, in sentences. step: of time, in the units of the
    file, which are SI where the case is. pressed: whether the load on the contact is MuJoCo's own, of a real contact;
    else friction is the loss of a joint, under a constant load.
    """

    text: str
    lost: tuple[str, ...]
    step: float
    pressed: bool


def mujoco_model(case: Case, step: float | None = None, tight: bool = True) -> MujocoModel:
    """The nearest MuJoCo model of a case.

    step: of time, in the units of the file; by default 1/500 of the shortest time of the machine, the fastest rate of
        its equations at the start or one radian of the drive, whichever is shorter
    tight: friction and contacts act within two steps, the fastest that MuJoCo admits; else they are MuJoCo's defaults
    Raises ArgumentError for a machine that MuJoCo has no parts for, and for what else it cannot say, by name.
    """
    if step is not None and not is_positive(step):
        raise ArgumentError("step", f"should be a positive time, got {shown(step)}")
    system = case.system
    start = tuple(initial_state(system, case.initial).values())[: len(system.placed.states)]
    mechanism = _mechanism(system, start)
    unit = Units(system)
    step = unit("s") * shortest_time(system, start) / STEPS if step is None else step
    soft = {"solref": f"{2.0 * step!r} 1", "solimp": f"{IMPEDANCE} {IMPEDANCE} 0.001"} if tight else {}
    pressed = system.machine.follows_load
    root = ET.Element("mujoco", model=system.machine.name)
    ET.SubElement(root, "compiler", angle="radian")
    normal, along = system.placed.gravity or (0.0, 0.0)
    pull = f"{_number(-along * unit('m/s^2'))} 0 {_number(-normal * unit('m/s^2'))}"
    ET.SubElement(root, "option", timestep=_number(step), gravity=pull)
    # where the load follows the motion it is 1, and levels are coefficients
    loaded = list(zip(system.laws, system.law_loads, strict=True))
    levels = [sliding_level(law, natural_speed(system), load) for law, load in loaded]
    world = ET.SubElement(root, "worldbody")
    _bodies(world, system, mechanism, unit, soft, None if pressed else levels)
    if pressed:
        _ground(world, soft, levels[0], unit)
    _links(root, mechanism, unit)
    _actuators(root, mechanism)
    _start_frame(root, mechanism, unit, pressed)
    lost = _lost(system, levels, unit, step)
    root.insert(0, ET.Comment("\n  ".join(["", *(sentence.replace("--", "-") for sentence in lost)]) + "\n"))
    ET.indent(root)
    return MujocoModel(ET.tostring(root, encoding="unicode") + "\n", lost, step, pressed)


def export_mjcf(case: Case, path: str | Path) -> MujocoModel:
    """Write the nearest MuJoCo model of a case to a file; the model, see `mujoco_model`.

    Raises WriteError where the file cannot be written.
    """
    model = mujoco_model(case)
    write_text(Path(path), model.text)
    return model


def shortest_time(system: System, start: tuple) -> float:
    """The shortest time of a machine that starts so: 1/|rate|, of the fastest rate of its equations, or of the drive.

    Friction left out, whose own rates MuJoCo does not follow.
    """
    machine, states = system.placed, len(system.placed.states)
    scales, still = machine.scales(system.drive.period), (0.0,) * len(machine.contact_states)
    columns = []
    for i, scale in enumerate(scales):
        pushes = (tuple(v + s * 1e-5 * scale * (j == i) for j, v in enumerate(start)) for s in (1.0, -1.0))
        ahead, behind = (np.array(machine.rates(0.0, pushed, 0.0, still)) for pushed in pushes)
        columns.append((ahead - behind) / (2e-5 * scale))
    fastest = np.abs(np.linalg.eigvals(np.array(columns).T)).max() if states else 0.0
    return 1.0 / max(float(fastest), 2.0 * math.pi / system.drive.period)


def natural_speed(system: System) -> float:
    machine = system.machine
    return machine.scales(system.drive.period)[machine.states.index(machine.contact_states[0])]


def sliding_level(law: Law, speed: float, load: float) -> float:
    """Level of friction, >= 0, at a speed; the mean of both directions, where they differ.

    Of a law with internal states that of steady sliding.
    """
    return 0.5 * (directed_level(law, speed, load) + directed_level(law, -speed, load))


def directed_level(law: Law, velocity: float, load: float) -> float:
    side = 1.0 if velocity >= 0.0 else -1.0
    if law.internal:
        return law.steady_force(abs(velocity), load)
    return side * law.force(velocity, (), side, load)[0]


class Units:
    """What one unit of the equations is in those of the file."""

    def __init__(self, system: System):
        self.units = None if system.units is None else system.si

    def __call__(self, unit: str) -> float:
        return 1.0 if self.units is None else self.units.factor_of(unit)


def _number(value: float) -> str:
    return repr(float(value) + 0.0)


def _mechanism(system: System, start: tuple) -> Mechanism:
    """The mechanism at the start; ArgumentError, by the name of the part, for what MuJoCo cannot say."""
    machine = system.machine
    if system.actuator is not None:
        raise ArgumentError("actuator", "should be left out: MuJoCo has no actuator with these rates and limits")
    if system.controller is not None:
        raise ArgumentError("controller", "should be left out: a MuJoCo model has no states and limits of a controller")
    outside = system.environment
    if outside is not None and dataclasses.replace(outside, inclination=0.0, gravity=None) != Environment():
        what = "should be a slope alone: drag and forces from outside have no part in a MuJoCo model"
        raise ArgumentError("environment", what)
    mechanism = system.placed.mechanism(0.0, start)
    if mechanism is None or not machine.over_ground:
        what = "imposed motions, stops, motions in a plane and what depends on time or place have no exact parts there"
        what = f"has no MuJoCo model: {what}"
        raise ArgumentError("machine", f"the {machine.name} {what}")
    if machine.ground_speed() != 0.0:
        raise ArgumentError("machine.belt_speed", "should be 0: the friction of a MuJoCo joint is that on fixed ground")
    return mechanism


def _bodies(
    world: ET.Element, system: System, mechanism: Mechanism, unit: Units, soft: dict, levels: list[float] | None
) -> None:
    """Bodies with their joints; levels: of the friction at each contact, None where contacts are MuJoCo's own."""
    drawn = {shape.name: shape for shape in system.placed.scene(0.0, (0.0,) * len(system.placed.states))}
    drawing = drawn_length(system)
    length = unit("m")
    elements: dict[str, tuple[ET.Element, Any, Any]] = {"": (world, 0.0, 0.0)}
    for body in mechanism.bodies:
        shape = drawn[body.name]
        x, z = (drawing * place for place in shape.places(drawing)[0])
        turns = body.joint == "hinge"
        z = z - 1.0 if turns else z  # of the hinge
        carrier, before_x, before_z = elements[body.carrier]
        position = f"{_number(length * (x - before_x))} 0 {_number(length * (z - before_z))}"
        elements[body.name] = element, x, z = ET.SubElement(carrier, "body", name=body.name, pos=position), x, z
        if body.contact is not None and levels is None:
            ET.SubElement(element, "joint", name=f"{body.name} rise", type="slide", axis="0 0 1")
        _joint(element, body, unit, soft, None if levels is None or body.contact is None else levels[body.contact])
        mass, arm = body.mass * unit("kg"), length if turns else 0.0
        point = _number(max(POINT * mass * length * length if turns else mass * length * length, SMALLEST_INERTIA))
        inertial = {"pos": f"0 0 {_number(arm)}", "mass": _number(mass), "diaginertia": " ".join([point] * 3)}
        ET.SubElement(element, "inertial", inertial)
        _looks(element, shape, arm, drawing * length, touches=body.contact is not None and levels is None)


def _joint(element: ET.Element, body: Body, unit: Units, soft: dict, level: float | None) -> None:
    turns = body.joint == "hinge"
    per, damper = ("N m/rad", "N m s/rad") if turns else ("N/m", "N s/m")
    # a hinge turns about -y, so that its angle from upright is positive backwards
    attributes = {"name": body.name, "type": body.joint, "axis": "0 -1 0" if turns else "1 0 0"}
    attributes |= {"stiffness": _number(body.stiffness * unit(per)), "damping": _number(body.damping * unit(damper))}
    if level is not None:
        attributes |= {"frictionloss": _number(level * unit("N"))}
        attributes |= {f"{name}friction": value for name, value in soft.items()}
    ET.SubElement(element, "joint", attributes)


def _looks(element: ET.Element, shape: Any, arm: float, length: float, touches: bool) -> None:
    """What is seen of a body, its shape in the scene; one that touches the ground is felt, too."""
    wide, high = (0.5 * length * size for size in shape.size)
    geom = {"name": shape.name, "pos": f"0 0 {_number(arm)}", "mass": "0"}
    if shape.kind == "disc":
        geom |= {"type": "sphere", "size": _number(wide)}
    else:
        geom |= {"type": "box", "size": f"{_number(wide)} {_number(high)} {_number(high)}"}
    if not touches:
        geom |= {"contype": "0", "conaffinity": "0"}
    ET.SubElement(element, "geom", geom)
    if arm:
        rod = {"type": "capsule", "fromto": f"0 0 0 0 0 {_number(arm)}", "size": _number(0.05 * length), "mass": "0"}
        ET.SubElement(element, "geom", {**rod, "name": f"{shape.name} rod", "contype": "0", "conaffinity": "0"})


def _ground(world: ET.Element, soft: dict, level: float, unit: Units) -> None:
    """The plane that a body touches; friction is its own (priority), of one coefficient."""
    size = _number(unit("m"))
    attributes = {"name": "ground", "type": "plane", "size": f"{size} {size} {size}", "condim": "3", "priority": "1"}
    world.insert(0, ET.Element("geom", {**attributes, "friction": f"{_number(level)} 0 0", **soft}))


def _links(root: ET.Element, mechanism: Mechanism, unit: Units) -> None:
    """Links are tendons whose length is the difference of two places."""
    if mechanism.links:
        tendons = ET.SubElement(root, "tendon")
        for i, link in enumerate(mechanism.links, start=1):
            spring = {"stiffness": _number(link.stiffness * unit("N/m")), "springlength": "0 0"}
            damper = {"damping": _number(link.damping * unit("N s/m"))}
            tendon = ET.SubElement(tendons, "fixed", {"name": f"link {i}", **spring, **damper})
            ET.SubElement(tendon, "joint", joint=link.behind, coef="-1")
            ET.SubElement(tendon, "joint", joint=link.ahead, coef="1")


def _actuators(root: ET.Element, mechanism: Mechanism) -> None:
    motors = ET.SubElement(root, "actuator")
    for body in mechanism.bodies:
        if body.actuation != 0.0:
            ET.SubElement(motors, "motor", name=f"drive of {body.name}", joint=body.name, gear=_number(body.actuation))
    for i, link in enumerate(mechanism.links, start=1):
        if link.actuation != 0.0:
            name = f"link {i}"
            ET.SubElement(motors, "motor", name=f"drive of {name}", tendon=name, gear=_number(link.actuation))


def _start_frame(root: ET.Element, mechanism: Mechanism, unit: Units, pressed: bool) -> None:
    """The keyframe "start": places and rates, in the order of the joints."""
    places, rates = [], []
    for body in mechanism.bodies:
        if body.contact is not None and pressed:
            places, rates = [*places, "0"], [*rates, "0"]
        place, rate = ("rad", "rad/s") if body.joint == "hinge" else ("m", "m/s")
        places.append(_number(body.place * unit(place)))
        rates.append(_number(body.rate * unit(rate)))
    ET.SubElement(ET.SubElement(root, "keyframe"), "key", name="start", qpos=" ".join(places), qvel=" ".join(rates))


def _lost(system: System, levels: list[float], unit: Units, step: float) -> tuple[str, ...]:
    """What the model does not say of the system, in sentences."""
    lost = []
    for number, known in enumerate(zip(system.laws, system.law_loads, levels, strict=True), start=1):
        lost += _lost_of_law(system, numbered("friction", number), *known, unit)
    if system.machine.follows_load:
        soft = "the load is that of a soft contact, into which the body sinks and on which it bounces"
        lost.append(f"machine.normal_load: {soft}")
    second = "" if system.units is None else " s"
    lost += [
        f"rest: friction is soft; a contact at rest creeps, and events wait for the end of a step ({step:.4g}{second})",
        f"drive: MJCF has no {system.drive.name} waveform; set every control to the value of the drive at each step",
    ]
    return tuple(lost)


def _lost_of_law(system: System, path: str, law: Law, load: float, level: float, unit: Units) -> list[str]:
    """What one level of friction does not say of a law."""
    speed = natural_speed(system)
    force = 1.0 if system.machine.follows_load else unit("N")
    of = "" if system.machine.follows_load or system.units is None else " N"
    slow, fast = (sliding_level(law, share * speed, load) for share in (RESTS, 1e3))
    per_time = "" if system.units is None else " m/s"
    kept = f"the file has {force * level:.4g}{of}, that at {speed * unit('m/s'):.4g}{per_time}"
    lost = []
    if law.internal:
        lost.append(f"the states of its contact ({', '.join(law.internal)}), so memory and presliding")
    if law.kind == "smooth":
        lost.append("that it holds nothing at rest")
    if not law.symmetric:
        lost.append("that its directions differ")
    if law.kind == "set-valued" and law.holding_limit(load) > slow * (1.0 + 1e-6):
        lost.append(f"that it holds up to {force * law.holding_limit(load):.4g}{of} at rest")
    if not math.isclose(slow, fast, rel_tol=1e-6):
        lost.append(f"that friction goes from {force * slow:.4g}{of} at vanishing speed to {force * fast:.4g}{of}")
    if not lost:
        return []
    return [f"{path}: MuJoCo cannot say the {law.name} law; lost: {'; '.join(lost)}; {kept}"]


@dataclasses.dataclass(frozen=True)
class Ending:
    """Where a motion ended: place of the (first) contact, and how far it went in the last whole period.

    Without units, as the equations count; drift: None where there was no whole period.
    """

    place: float
    drift: float | None


@dataclasses.dataclass(frozen=True)
class Judgement:
    """Where the exact motion, without units, the model as its file says, and that with friction rewritten ended.

    steps: how many MuJoCo took
    """

    exact: Trajectory
    exact_ending: Ending
    as_written: Ending
    rewritten: Ending
    steps: int


def judgement(case: Case, model: MujocoModel | None = None) -> Judgement:
    """The exact motion of a case beside its MuJoCo model, as far as the exact motion goes.

    model: by default that of `mujoco_model`. Friction is rewritten to the level of the law at the present velocity, of
    a law with internal states to that of steady sliding: as much as can be said to MuJoCo from outside.
    Raises ModuleNotFoundError, which says how to install it, where `mujoco` is missing.
    """
    require("a MuJoCo model beside the exact motion", "mujoco")
    model = mujoco_model(case) if model is None else model
    exact = case.simulate().dimensionless
    place = exact.state[str(case.system.machine.place or case.system.cyclic)]
    travel = drift(exact) if case.system.cyclic is not None and len(exact.sections) > 1 else None
    as_written, rewritten = (mujoco_ending(case, model, exact.end, rewritten=contact) for contact in (False, True))
    steps = math.ceil(exact.end * Units(case.system)("s") / model.step)
    return Judgement(exact, Ending(place, travel), as_written, rewritten, steps)


def mujoco_ending(case: Case, model: MujocoModel, end: float, rewritten: bool) -> Ending:
    """Where MuJoCo takes a model until a time, without units; rewritten: friction at every step, see `judgement`.

    Between two steps its place is taken from a straight line.
    """
    mujoco: Any = importlib.import_module("mujoco")
    system, unit = case.system, Units(case.system)
    time, length = unit("s"), unit("m")
    effort = 1.0 if system.units is None else system.si.factor("drive")
    runner = mujoco.MjModel.from_xml_string(model.text)
    state = mujoco.MjData(runner)
    mujoco.mj_resetDataKeyframe(runner, state, 0)
    friction = _Friction(case, model, runner)
    first = int(runner.joint(friction.first).qposadr[0])
    period = system.drive.period * time
    last = math.floor(end * time / period * (1.0 + 1e-12))
    asked = [(last - 1) * period, last * period, end * time] if last else [end * time]
    positions: list[float] = []
    before, count = 0.0, 0
    while len(positions) < len(asked):
        now, ahead = count * model.step, float(state.qpos[first])
        while len(positions) < len(asked) and asked[len(positions)] <= now:
            share = (now - asked[len(positions)]) / model.step
            positions.append(ahead - share * (ahead - before))
        before = ahead
        if rewritten:
            friction.rewrite(state)
        state.ctrl[:] = effort * system.drive.value(now / time)
        mujoco.mj_step(runner, state)
        count += 1
    travel = (positions[1] - positions[0]) / length if last else None
    return Ending(positions[-1] / length, travel)


class _Friction:
    """The level of friction at each contact of a running model."""

    def __init__(self, case: Case, model: MujocoModel, runner: Any):
        system, unit = case.system, Units(case.system)
        mechanism = system.placed.mechanism(0.0, (0.0,) * len(system.placed.states))
        rubbing = {body.contact: body.name for body in mechanism.bodies if body.contact is not None}
        self.first, self.of = rubbing[0], []  # (law, load, where its velocity stands, where its level)
        self.levels = runner.geom_friction[:, 0] if model.pressed else runner.dof_frictionloss
        for contact, name in rubbing.items():
            place = int(runner.joint(name).dofadr[0])
            where = runner.geom("ground").id if model.pressed else place
            self.of.append((system.laws[contact], system.law_loads[contact], place, where))
        self.speed, self.force = unit("m/s"), 1.0 if model.pressed else unit("N")

    def rewrite(self, state: Any) -> None:
        """Set each level to that of the present velocity."""
        for law, load, place, where in self.of:
            self.levels[where] = self.force * directed_level(law, float(state.qvel[place]) / self.speed, load)
