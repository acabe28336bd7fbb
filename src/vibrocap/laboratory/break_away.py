"""The break-away test: a mass is pulled by a force that grows at a constant rate, until friction lets it go."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from vibrocap.laboratory.contact_sizes import ContactSizes, contact_sizes
from vibrocap.laboratory.driven import check_motion, check_numbers, checked_list
from vibrocap.measures.recorded.stretch import stretches
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.drives.loadings import Loading
from vibrocap.physics.events import SLIP_FORWARD
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.oscillators import Oscillator
from vibrocap.physics.system import System

RATES = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0)  # times the rate at which the contact yields with its own speed
PAST = 1.2  # break-away forces that the ramp passes through at first, and how much longer it gets each time
LONGER = (1.0, 1.5, 3.0)
FALLEN = 1e-6  # share of a maximum by which friction falls after it, to be no ripple of rounding
POINTS = 8  # per piece of the motion
TOLERANCE = 1e-11


@dataclasses.dataclass(frozen=True, eq=False)
class Pull:
    """One pull: applied and friction force, displacement and velocity over time, all [n]."""

    rate: float
    time: np.ndarray
    applied: np.ndarray
    friction: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False)
class BreakAway:
    """Break-away forces by loading rate, all [rates] in the units of the law.

    force: the largest friction force before the mass slides away; applied: the force of the ramp at that instant
    velocity, displacement: of the mass there
    peaked: whether friction falls after it; where it does not (no Stribeck drop) `force` is the largest of the whole
        pull, and the instant means nothing (NaN)
    pulls: the motions; mass: that was pulled
    """

    rate: np.ndarray
    force: np.ndarray
    applied: np.ndarray
    velocity: np.ndarray
    displacement: np.ndarray
    peaked: np.ndarray
    pulls: tuple[Pull, ...]
    mass: float

    in_record = "rate force applied peaked"


def break_away(
    law: Law,
    rates: Sequence[float] | None = None,
    *,
    mass: float = 1.0,
    load: float = 1.0,
    tolerance: float = TOLERANCE,
) -> BreakAway:
    """Break-away force against loading rate (Canudas de Wit et al. 1995, section IV and Fig. 4).

    A mass at rest is pulled by the force q t. It yields elastically at first; then velocity rises sharply, and friction
    falls. The break-away force is the largest friction force until then: the first maximum after which friction falls.
    (The applied force is larger at that instant, by what accelerates the mass.) A law that knows only velocity lets go
    at one force; with bristles it falls with the rate, since bristles that are stretched quickly have no time to follow
    the Stribeck drop.

    rates: of the force, per unit of time; by default 0.003 to 1 of the rate at which the contact yields with the speed
        over which its friction changes (`contact_sizes`)
    mass: that is pulled; load: on the contact     All in any one system of units.

    LuGre's own parameters (sigma0 1e5, sigma1 sqrt(1e5), sigma2 0.4, Fc 1, Fs 1.5, v_s 1e-3, m 1): 1.43242 N at 1 N/s,
    1.21995 N at 10 N/s. Raises ValueError for rates, mass or load that are not positive numbers, and RuntimeError where
    a motion cannot be completed.
    """
    check_numbers(mass=mass, load=load)
    sizes = contact_sizes(law, load)
    rate = sizes.stiffness * sizes.speed * np.array(RATES) if rates is None else checked_list("rates", rates)
    rows, pulls = zip(*(_pulled(law, float(q), mass, load, sizes, tolerance) for q in rate), strict=True)
    force, applied, velocity, displacement, peaked = np.array(rows).T
    return BreakAway(rate, force, applied, velocity, displacement, peaked > 0.0, pulls, mass)


def _pulled(law: Law, rate: float, mass: float, load: float, sizes: ContactSizes, tolerance: float):
    """((force, applied, velocity, displacement, whether it peaked), Pull) of one rate."""
    machine = Oscillator(mass=mass, stiffness=0.0, normal_load=load)
    # What the ramp needs to reach the break-away force, and the mass to move by the displacement of the contact.
    duration = PAST * sizes.force / rate + 6.0 * math.sqrt(mass * sizes.displacement / sizes.force)
    row: tuple[float, ...] = ()
    pull: Pull | None = None
    for longer in LONGER:
        frequency = 2.0 * math.pi / (longer * duration)
        drive = Loading(level=0.0, rate=rate, amplitude=0.0, frequency=frequency)
        motion = simulate(System(machine, law, drive), periods=1, tolerance=tolerance)
        check_motion(motion.status, law)
        row, pull = _break_away(motion, rate)
        if row[-1]:
            break
    assert pull is not None
    return row, pull


def _break_away(motion: Trajectory, rate: float) -> tuple[tuple[float, ...], Pull]:
    """(force, applied, velocity, displacement, whether it peaked) of one pull, and its course."""
    time = _look_times(motion)
    # Where a contact lets go, friction is that of the contact at rest.
    index = np.maximum(np.searchsorted(motion.piece_start, time, side="left") - 1, 0)
    friction = motion.piece_observables(("friction",), index, time - motion.piece_start[index])[0]
    place, velocity = motion.states(time)[:2]
    pull = Pull(rate, time, rate * time, friction, place, velocity)
    slips = motion.event_times[motion.event_kinds == SLIP_FORWARD]
    if motion.system.friction.kind == "set-valued" and len(slips):
        at, peaked = int(np.searchsorted(time, slips[0])), True
    else:
        at, peaked = _peak(friction)
    there = (pull.applied[at], velocity[at], place[at]) if peaked else (math.nan,) * 3
    return (friction[at], *there, float(peaked)), pull


def _look_times(motion: Trajectory) -> np.ndarray:
    """Times within every piece, at both ends of it, and where friction turns."""
    share = np.linspace(0.0, 1.0, POINTS)
    points = (motion.piece_start[:, None] + motion.piece_length[:, None] * share).ravel()
    turns = [part.roots(part.friction_rate) for part in stretches(motion, 0.0, motion.end) if part.side]
    return np.unique(np.concatenate((points, *turns)))


def _peak(friction: np.ndarray) -> tuple[int, bool]:
    """Index of the first maximum after which friction falls before it rises beyond it, and whether there is one."""
    largest = np.maximum.accumulate(friction)
    fallen = np.flatnonzero(friction < (1.0 - FALLEN) * largest)
    if not len(fallen):
        return int(np.argmax(friction)), False
    return int(np.argmax(friction[: fallen[0]])), True
