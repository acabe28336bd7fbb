"""Every way in which the contacts of a machine can go on from a state: found by trying all, for tests and for looking.

The motion itself decides by pivoting (`numerics/kernel/events/decision.py`); nothing of that is used here.
"""

import dataclasses
import itertools
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_number, shown
from vibrocap.motion.simulate import initial_state
from vibrocap.physics.machines.machine import Contact
from vibrocap.physics.names import numbered
from vibrocap.physics.system import System
from vibrocap.quantities.declared import Acceleration, ByName, Force, Speed, Time
from vibrocap.quantities.dimensional import Dimensional

ROUNDING = 1e-9  # of forces over the largest, and of accelerations likewise


@dataclasses.dataclass(frozen=True)
class ContactModes(Dimensional):
    """One consistent set of modes of all contacts, the first contact first.

    sides: 0 rests, +1 and -1 slides or starts to slide there; friction, loads, accelerations: of each contact
    determined: whether the friction at each contact follows; it does not where contacts at imposed distances rest
    together, then it is shown as equal shares of their limits
    """

    sides: tuple[int, ...]
    friction: tuple[Force, ...]
    loads: tuple[Force, ...]
    accelerations: tuple[Acceleration, ...]
    determined: bool = True


@dataclasses.dataclass(frozen=True)
class _Problem:
    """a = free - response R, N = loads - raised R; least, most: friction per load that a mode may hold."""

    free: np.ndarray
    response: np.ndarray
    loads: np.ndarray
    raised: np.ndarray
    least: np.ndarray
    most: np.ndarray
    shared: bool


def contact_modes(
    system: System, state: ByName | None = None, time: Time = 0.0, still: Speed = 1e-12
) -> tuple[ContactModes, ...]:
    """Every consistent set of modes of the contacts of a system at a state: one where the continuation is unique.

    All 3^n modes are tried. A contact that moves keeps its side; one that does not rests (a = 0, with friction within
    the holding limit), or starts to slide to the side s of its acceleration (s a > 0) with friction at the limit. All
    loads must be positive. Whether there is exactly one set for all forces is a property of the matrices (P-matrices,
    see `physics/contacts.py`); where there are two
    or more, or none, a run would end as "ambiguous contacts".

    state: by name, others are 0; time: of the drive; still: speed below which a contact counts as at rest

    Raises ArgumentError for a state or a time that is none.
    """
    if not is_number(time) or not np.isfinite(time):
        raise ArgumentError("time", f"should be a finite number, got {shown(time)}")
    y = tuple(initial_state(system, state).values())
    placed = system.placed
    contacts = placed.contacts(time, y[: len(placed.states)], system.drive.value(time))
    velocities = np.array([contact.velocity for contact in contacts])
    problem = _problem(system, time, y, contacts, velocities, still)
    choices = [
        (int(np.sign(v)),) if abs(v) > still else (0, 1, -1) if law.kind == "set-valued" else (1,)
        for law, v in zip(system.laws, velocities, strict=True)
    ]
    consistent = (_consistent(problem, sides, np.abs(velocities) > still) for sides in itertools.product(*choices))
    return tuple(modes for modes in consistent if modes is not None)


def _problem(
    system: System, time: float, y: tuple, contacts: tuple[Contact, ...], velocities: np.ndarray, still: float
) -> _Problem:
    """The matrices of all contacts, of a machine whose contacts are coupled or not."""
    machine, count = system.placed, len(velocities)
    mechanical = y[: len(machine.states)]
    loads, raised = np.array(machine.loads(), dtype=float), np.zeros((count, count))
    if any(contact.response for contact in contacts):
        free = np.array([contact.acceleration for contact in contacts], dtype=float)
        response = np.array([contact.response for contact in contacts], dtype=float)
    else:
        free, response = _from_rates(machine, time, mechanical, system.drive.value(time), count)
    if machine.follows_load:
        reactions: list[Any] = [contact.reaction for contact in contacts]
        loads = np.array([reaction[0] for reaction in reactions])
        raised = np.array([[-slope for slope in slopes] for _, *slopes in reactions])
    if system.environment is not None:
        outside = system.environment.outside(machine, time, mechanical, velocities, np.sign(velocities))
        push = np.array([pushes[int(abs(v) <= still)] for pushes, v in zip(outside.pushes, velocities, strict=True)])
        free, loads = free + response @ push, loads + raised @ push
    least, most = np.zeros(count), np.zeros(count)
    for i, (law, v) in enumerate(zip(system.laws, velocities, strict=True)):
        internal = tuple(y[system.state_names.index(numbered(name, i + 1))] for name in law.internal)
        # A law is asked per load where loads follow the motion, and with the load where it is constant.
        load = 1.0 if machine.follows_load else loads[i]
        if law.kind == "set-valued" and abs(v) <= still:
            middle, limit = law.holding_centre(load), law.holding_limit(load)
            least[i], most[i] = (middle - limit) / load, (middle + limit) / load
        else:
            least[i] = most[i] = law.force(v, internal, float(np.sign(v)) or 1.0, load)[0] / load
    return _Problem(free, response, loads, raised, least, most, machine.imposes_distances)


def _from_rates(machine: Any, time: float, y: tuple, drive: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(free, response) read off the rates, which are linear in all friction forces."""
    places = [machine.states.index(name) for name in machine.contact_states]

    def accelerations(forces: Any) -> np.ndarray:
        rates = machine.rates(time, y, drive, tuple(forces))
        return np.array([rates[i] for i in places], dtype=float)

    free = accelerations(np.zeros(count))
    return free, np.column_stack([free - accelerations(unit) for unit in np.eye(count)])


def _consistent(problem: _Problem, sides: tuple[int, ...], moving: np.ndarray) -> ContactModes | None:
    """The set of modes with its forces, if it is one that can go on."""
    n, side = len(sides), np.array(sides)
    rests, level = side == 0, np.where(side < 0, problem.least, problem.most)
    # rows: of contacts at rest no acceleration, of others R = level N
    rows = np.where(rests[:, None], problem.response, np.eye(n) + level[:, None] * problem.raised)
    right = np.where(rests, problem.free, level * problem.loads)
    determined = True
    if problem.shared and np.sum(rests) > 1:
        determined, together = False, np.flatnonzero(rests)
        if np.ptp(problem.free[together]) > ROUNDING * (1.0 + np.max(np.abs(problem.free))):
            return None  # their distance changes
        width = (problem.most - problem.least) * problem.loads
        middle = 0.5 * (problem.most + problem.least) * problem.loads
        head, *others = together
        for other in others:  # (R - middle)/width is the same
            rows[other] = 0.0
            rows[other, [head, other]] = 1.0 / width[head], -1.0 / width[other]
            right[other] = middle[head] / width[head] - middle[other] / width[other]
    try:
        friction = np.linalg.solve(rows, right)
    except np.linalg.LinAlgError:
        return None
    accelerations = problem.free - problem.response @ friction
    loads = problem.loads - problem.raised @ friction
    size = ROUNDING * (1.0 + np.max(np.abs(friction)))
    if np.any(loads <= 0.0):
        return None
    within = (friction >= problem.least * loads - size) & (friction <= problem.most * loads + size)
    departs = side * accelerations > ROUNDING * (1.0 + np.max(np.abs(problem.free)))
    if not np.all(np.where(rests, within, moving | departs)):
        return None
    lists = [tuple(float(value) for value in column) for column in (friction, loads, accelerations)]
    return ContactModes(sides, lists[0], lists[1], lists[2], determined)
