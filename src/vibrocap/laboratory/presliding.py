"""Presliding: the loop of force over displacement below and through break-away, and creep under a force below it."""

import dataclasses
import math

import numpy as np

from vibrocap.arguments import check_whole
from vibrocap.laboratory.contact_sizes import SLOW, contact_sizes
from vibrocap.laboratory.driven import check_motion, check_numbers, driven_force
from vibrocap.motion.simulate import period_marks
from vibrocap.motion.status import Status
from vibrocap.physics.drives.loadings import Loading
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.oscillators import Oscillator
from vibrocap.physics.system import System

SAMPLES = 1024  # per cycle of displacement
LOOP_TOLERANCE = 1e-11
QUASI_STATIC = 100.0  # natural frequency of the block on its contact, over the frequency of the force
BIAS, AMPLITUDE = 0.12, 0.08  # break-away forces: a force that stays well below, even of Coulomb level
SLOW_CREEP = 0.1  # speed/displacement of the contact: its damping and its Stribeck drop play no part
CREEP_TOLERANCE = 1e-11
FEWEST = 4  # cycles of a creep test that could not be completed
NO_DRIFT = 1e-9  # displacements of the contact in one cycle


@dataclasses.dataclass(frozen=True, eq=False)
class PreslidingLoop:
    """Force over displacement, quasi-static, in the units of the law; arrays are [n] and begin with the first loading.

    last: index at which the last cycle begins
    area: work taken by the contact in the last cycle; peak_force: largest |R| in it
    deflection: largest size of the first internal state in it; None for a law that has none
    closure: what the force changes over the last cycle, over the peak force
    """

    amplitude: float
    time: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    last: int
    area: float
    peak_force: float
    deflection: float | None
    closure: float

    in_record = "amplitude area peak_force deflection closure"


@dataclasses.dataclass(frozen=True, eq=False)
class Creep:
    """What a block does under a force that oscillates below break-away, in the units of the law.

    bias, amplitude: of the force; displacement: at the end of each cycle [cycles + 1], from the start
    drift: over the second half of the cycles (in the first the block settles under its load); drift_per_cycle: the same
        per cycle; creeps: whether that is more than 1e-9 displacements of the contact
    status: `finished`, or why there are fewer cycles than were asked for
    """

    bias: float
    amplitude: float
    displacement: np.ndarray
    drift: float
    drift_per_cycle: float
    creeps: bool
    status: Status

    in_record = "bias amplitude drift_per_cycle creeps"


def presliding_loop(
    law: Law, amplitude: float | None = None, *, load: float = 1.0, cycles: int = 3, speed: float | None = None
) -> PreslidingLoop:
    """The loop of friction force over displacement under a slow harmonic motion of the contact.

    From rest the contact is moved to +A, then in whole cycles x = A cos(phi). Below break-away it yields like a spring
    that loses a little (presliding), beyond it slides. LuGre at a constant level Fc, with g = Fc/sigma0:

        |xi|max = g tanh(A/g),      area = 4 Fc [A - g tanh(A/g)]                          docs/model.md

    amplitude: A, by default the displacement at which the contact breaks away (`contact_sizes`)
    cycles: whole cycles after the first loading, of which the last is measured
    speed: largest speed, by default 1e-5 of that over which friction changes, so slow that the rate does not matter

    Set-valued laws show a rectangle: the full force at once, to either side.
    """
    check_numbers(load=load)
    check_whole("cycles", cycles, 1)
    sizes = contact_sizes(law, load)
    amplitude = sizes.displacement if amplitude is None else amplitude
    speed = SLOW * sizes.speed if speed is None else speed
    check_numbers(amplitude=amplitude, speed=speed)
    loading = SAMPLES // 2
    count = loading + cycles * SAMPLES
    phase = math.pi * np.arange(count + 1) / loading
    # x = A (1 - cos)/2 up to A, then -A cos(phase), at the samples exactly; the velocity is linear between them
    shape = np.where(np.arange(count + 1) <= loading, np.sin(phase) / 2.0, np.sin(phase))
    shape[loading::loading] = 0.0
    step = math.pi * amplitude / (speed * loading)
    velocity = shape * amplitude * (2.0 * math.tan(math.pi / (2.0 * loading))) / step
    time = step * np.arange(count + 1)
    displacement = np.append(0.0, np.cumsum(0.5 * step * (velocity[1:] + velocity[:-1])))
    driven = driven_force(law, time, velocity, load=load, tolerance=LOOP_TOLERANCE)
    check_motion(driven.status, law)
    force, last = driven.force, count - SAMPLES
    area = _integral(force[last:] * amplitude * shape[last:], math.pi / loading)
    peak = float(np.max(np.abs(force[last:])))
    deflection = float(np.max(np.abs(driven.internal[last:, 0]))) if law.internal else None
    closure = abs(float(force[-1] - force[last])) / peak if peak else 0.0
    columns = time, displacement, velocity, force
    return PreslidingLoop(float(amplitude), *columns, last, area, peak, deflection, closure)


def _integral(values: np.ndarray, step: float) -> float:
    """Simpson's rule. R dx/dphi has its kinks at reversals, which are even points of the grid, and vanishes there."""
    return float(step / 3.0 * (4.0 * values[1::2].sum() + 2.0 * values[2:-1:2].sum() + values[0] + values[-1]))


def creep(
    law: Law,
    bias: float | None = None,
    amplitude: float | None = None,
    cycles: int = 1000,
    *,
    load: float = 1.0,
    tolerance: float = CREEP_TOLERANCE,
) -> Creep:
    """The drift of a block under the force F + h cos(omega t), which stays below break-away.

    A real contact stays where it is; some laws creep, a little in every cycle, since their bristles slip a little at
    any force (LuGre does; Dupont et al. 2002 made the elasto-plastic law so that it does not).

    LuGre at a constant level Fc, g = Fc/sigma0, without damping, between the least and the largest force a Fc and b Fc:
    loading takes dx = dxi/(1 - xi/g), unloading dx = dxi/(1 + xi/g), so that a cycle drifts by

        g ln[(1 - a^2)/(1 - b^2)]

    bias, amplitude: F and h, by default 0.12 and 0.08 of the break-away force      cycles: of the force

    The block is so light that its natural frequency on the contact is 100 omega, and a damper beside it lets it follow
    the force without ringing (critically damped): the contact feels the force but for some thousandth of h. Ten
    thousand cycles of LuGre's law take some seconds. A rate-and-state contact ages until its velocity is lost in
    rounding: the record then ends early, and says so. Raises ValueError for numbers that are none, and RuntimeError
    where not even four cycles can be completed.
    """
    check_numbers(load=load)
    check_whole("cycles", cycles, 1)
    sizes = contact_sizes(law, load)
    bias = BIAS * sizes.force if bias is None else bias
    amplitude = AMPLITUDE * sizes.force if amplitude is None else amplitude
    check_numbers(amplitude=amplitude)
    if bias != 0.0:
        check_numbers(bias=abs(bias) if isinstance(bias, (int, float)) else bias)
    frequency = SLOW_CREEP * sizes.speed / sizes.displacement
    mass = sizes.stiffness / (QUASI_STATIC * frequency) ** 2
    damping = 2.0 * math.sqrt(sizes.stiffness * mass)
    machine = Oscillator(mass=mass, stiffness=0.0, damping=damping, normal_load=load)
    drive = Loading(level=bias, rate=0.0, amplitude=amplitude, frequency=frequency)
    status, marks = period_marks(System(machine, law, drive), periods=cycles, tolerance=tolerance)
    place = marks[:, 0]
    cycles, half = len(place) - 1, (len(place) - 1) // 2
    if cycles < FEWEST:
        check_motion(status, law)
    drift = float(place[-1] - place[half])
    per_cycle = drift / max(cycles - half, 1)
    creeps = abs(per_cycle) > NO_DRIFT * sizes.displacement
    return Creep(float(bias), float(amplitude), place, drift, per_cycle, creeps, status)
