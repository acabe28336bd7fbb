"""Clauses that need a whole system: a part is put together with parts of the package, recorded, and let move."""

import dataclasses
import math
from typing import Any

from vibrocap.contracts.controller_clauses import machine_for
from vibrocap.contracts.machine_clauses import EPSILON
from vibrocap.contracts.samples import draws, random_internal, random_state, settled_branch, within_room
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.simulate import simulate
from vibrocap.motion.status import Status
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.expressions.graph import evaluate
from vibrocap.physics.catalogue import laws, machines
from vibrocap.physics.controllers.controller import Controller
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.drives.harmonics import Harmonic
from vibrocap.physics.drives.loadings import Loading
from vibrocap.physics.events import BOUNDS
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.parameters import FREQUENCY, parameter_table
from vibrocap.physics.system import System

SAMPLES = 20
SHARES = (1.0, 0.7, 0.5, 0.3, 0.2, 0.1)  # of drive and start, until a contact slides and no end of the equations is met
ENDS = {Status(kind.replace("_", " ")) for kind in BOUNDS}  # an answer of a machine, if it has moved for a period
PERIODS, TOLERANCES = 5, 100  # of the motion; what its residuals may be, in tolerances: they shrink with it


def system_of(part: Any) -> System:
    """A system with this part, the others being an oscillator or a capsule, Stribeck friction and a loading."""
    if isinstance(part, Law):
        return System(machines()["oscillator"](), part, Loading(0.0, 0.0, 1.8, 1.3))
    if isinstance(part, Drive):
        return System(machines()["pendulum-capsule"](), laws()["stribeck"](), part)
    if isinstance(part, Controller):
        reference = Harmonic(1.8, 1.3)
        if part.sampled:  # a whole number of times in its period
            time = reference.period / SAMPLES
            times = {"sample_time": time, "delay": None if part.delay is None else 0.3 * time}
            part = dataclasses.replace(part, **times)  # type: ignore[type-var]
        return System(machine_for(part), laws()["stribeck"](), reference, controller=part)
    if part.imposes_motion:
        return System(part, laws()["stribeck"](), Harmonic(amplitude=0.7, frequency=1.3))
    return System(part, laws()["stribeck"](), Loading(0.0, 0.0, 1.8, _frequency(part)))


def _frequency(machine: Machine) -> float:
    """Of a drive in whose period a machine repeats: 1.3, or one of its own parameters, or 1."""
    own = (getattr(machine, info.name) for info in parameter_table(machine) if info.dimension == FREQUENCY)
    for frequency in (1.3, *own):
        if frequency and machine.repeats_after(2.0 * math.pi / frequency):
            return frequency
    return 1.0


def recorded(part: Any) -> str | None:
    """Its equations can be recorded, and the recorded ones compute what the functions do."""
    system = system_of(part)
    formulas, values = equations(system), parameter_values(system)
    machine, law = system.placed, system.friction
    contact, still = machine.states.index(machine.contact_states[0]), (0.0,) * len(machine.contact_states)
    for draw in draws(SAMPLES):
        mechanical, side, t = random_state(machine.states, draw), draw.choice((1, -1)), draw.uniform(0, 9)
        mechanical = list(within_room(machine, mechanical))
        if formulas.corners is not None:  # recorded is the time since the start of the period
            t = t % system.drive.period
            values = tuple(float(value) for value in formulas.filled(values, t))
        mechanical[contact] = side * abs(mechanical[contact])
        mechanical = settled_branch(machine, t, tuple(mechanical), 0.0, still)
        velocity = machine.contacts(t, mechanical, 0.0)[0].velocity
        y = (*mechanical, *random_internal(law, velocity, side, machine.loads()[0], draw))
        expected = system.rates(t, y, side)
        rates = evaluate(formulas.rates, t, y, float(side), values)
        size = 1.0 + max(map(abs, expected))
        for name, one, other in zip(system.state_names, rates, expected, strict=True):
            if not abs(float(one) - other) <= 1e3 * EPSILON * size:
                return (
                    f"the recorded rate of {name} is {float(one):g}, the functions give {other:g}; a formula should "
                    "depend on its arguments and parameters alone"
                )
    return None


def moves(part: Any) -> str | None:
    """It moves for some periods, and the motion is certified."""
    system, tried = system_of(part), []
    for share in SHARES:
        tried.append(motion := motion_of(system, part, share))
        if motion.status not in ENDS and (motion.piece_sides.any() or not motion.status.ok):
            break
    else:
        motion = max(tried, key=lambda motion: (bool(motion.piece_sides.any()), motion.end))
    if not motion.status.ok and (motion.status not in ENDS or motion.end < motion.period):
        return f"the motion of {_others(system, part)} ended early: {motion.status.text}"
    certificate = dataclasses.asdict(motion.certificate)
    bound = TOLERANCES * motion.tolerance
    for name in ("energy_residual", "momentum_residual"):
        if not certificate[name] <= bound:
            return (
                f"the motion of {_others(system, part)} has {name} {certificate[name]:.2g}, over its bound {bound:.2g}"
            )
    if beyond := [verdict.text for verdict in motion.certificate.verdicts if not verdict.ok]:
        return f"the motion of {_others(system, part)} is not certified: {'; '.join(beyond)}"
    return None


def motion_of(system: System, part: Any, share: float) -> Trajectory:
    """A motion of the system from its first state, within the room of its machine; both weaker by a share."""
    if not isinstance(part, Drive):
        system = system.with_parameters({"drive.amplitude": share * system.parameter("drive.amplitude")})
    start = within_room(system.placed, (share, *(0.0 for _ in system.placed.states[1:])))
    return simulate(system, initial=dict(zip(system.placed.states, start, strict=True)), periods=PERIODS)


def _others(system: System, part: Any) -> str:
    return " with ".join(other.name for other in (system.machine, system.friction, system.drive) if other is not part)
