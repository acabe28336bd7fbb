"""A MuJoCo model beside the exact motion of its case: where both end, and how far they travel in a period."""

import dataclasses
import importlib
import math
from typing import Any

from vibrocap.arguments import require
from vibrocap.case.case import Case
from vibrocap.exchange.mjcf import MujocoModel, Units, directed_level, mujoco_model
from vibrocap.measures.recorded.travel import drift
from vibrocap.motion.trajectory import Trajectory


@dataclasses.dataclass(frozen=True)
class Ending:
    """Where a motion ended: place of the (first) contact, and how far it went in the last whole period.

    Without units, as the equations count; drift: None where there was no whole period.
    """

    place: float
    drift: float | None


@dataclasses.dataclass(frozen=True)
class Judgement:
    """The exact motion, the model as its file says, and the same with friction rewritten at every step.

    exact: without units. exact_ending, as_written, rewritten: where each ended. steps: how many MuJoCo took.
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
    system = case.system
    unit = Units(system)
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
        self.of = []  # (law, load, where its velocity stands, where its level)
        self.first = next(body.name for body in mechanism.bodies if body.contact == 0)
        self.levels = runner.geom_friction[:, 0] if model.pressed else runner.dof_frictionloss
        for body in mechanism.bodies:
            if body.contact is not None:
                place = int(runner.joint(body.name).dofadr[0])
                where = runner.geom("ground").id if model.pressed else place
                law, load = system.laws[body.contact], system.law_loads[body.contact]
                self.of.append((law, load, place, where))
        self.speed, self.force = unit("m/s"), 1.0 if model.pressed else unit("N")

    def rewrite(self, state: Any) -> None:
        """Set each level to that of the present velocity."""
        for law, load, place, where in self.of:
            self.levels[where] = self.force * directed_level(law, float(state.qvel[place]) / self.speed, load)
