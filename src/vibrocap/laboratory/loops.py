"""Loops of a contact: force over displacement below and through break-away (presliding), and friction over a velocity
that varies (frictional lag); and creep under a force below break-away.
"""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from vibrocap.arguments import check_whole
from vibrocap.laboratory.contact_sizes import SLOW, contact_sizes
from vibrocap.laboratory.driven import check_motion, check_numbers, checked_list, driven_force
from vibrocap.motion.simulate import period_marks
from vibrocap.motion.status import Status
from vibrocap.physics.drives.loadings import Loading
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.oscillators import Oscillator
from vibrocap.physics.system import System

SAMPLES, LOOP_TOLERANCE = 1024, 1e-11  # samples per cycle of displacement
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
    # Simpson's rule. R dx/dphi has its kinks at reversals, which are even points of the grid, and vanishes there.
    power = force[last:] * amplitude * shape[last:]
    sums = 4.0 * power[1::2].sum() + 2.0 * power[2:-1:2].sum() + power[0] + power[-1]
    area = float(math.pi / loading / 3.0 * sums)
    peak = float(np.max(np.abs(force[last:])))
    deflection = float(np.max(np.abs(driven.internal[last:, 0]))) if law.internal else None
    closure = abs(float(force[-1] - force[last])) / peak if peak else 0.0
    columns = time, displacement, velocity, force
    return PreslidingLoop(float(amplitude), *columns, last, area, peak, deflection, closure)


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
    any force (LuGre does; the elasto-plastic law of Dupont et al. 2002 does not). LuGre at a constant level Fc,
    g = Fc/sigma0, without damping, between the least and the largest force a Fc and b Fc: loading takes
    dx = dxi/(1 - xi/g), unloading dx = dxi/(1 + xi/g), so that a cycle drifts by

        g ln[(1 - a^2)/(1 - b^2)]

    bias, amplitude: F and h, by default 0.12 and 0.08 of the break-away force      cycles: of the force

    The block is so light that its natural frequency on the contact is 100 omega, and critically damped: the contact
    feels the force but for some thousandth of h. A rate-and-state contact ages until its velocity is lost in rounding:
    the record then ends early, and says so. Raises ValueError for numbers that are none, and RuntimeError where not
    even four cycles can be completed.
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


LAG_MEAN, LAG_AMPLITUDE = 1.3, 1.2  # speeds of the contact: a motion that nearly stops but never turns
FREQUENCIES = (0.02, 0.1, 0.5)  # over speed/displacement of the contact
LAG_SAMPLES, LAG_TOLERANCE = 2048, 1e-10  # samples per cycle
RELAXATIONS = 40.0  # displacements of the contact to slide before the cycle that is kept, and at least
CYCLES = 2


@dataclasses.dataclass(frozen=True, eq=False)
class FrictionalLag:
    """Loops of friction over velocity, one per frequency, in the units of the law.

    velocity: [n] of one cycle, from its least to its largest value and back; force: [frequencies, n]
    width: [frequencies] largest difference of friction at one velocity, accelerating less decelerating, with its sign:
        positive where friction lags behind as measured (Hess and Soom 1990), 0 for a law that knows velocity alone
    at: [frequencies] the velocity there
    area: [frequencies] of the loop, the integral of R dv over the cycle, positive clockwise (with a positive width)
    """

    frequency: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    width: np.ndarray
    at: np.ndarray
    area: np.ndarray

    in_record = "frequency width at area"


def frictional_lag(
    law: Law,
    mean: float | None = None,
    amplitude: float | None = None,
    frequencies: Sequence[float] | None = None,
    *,
    load: float = 1.0,
) -> FrictionalLag:
    """Loops of friction over the velocity v = V - h cos(omega t) (Canudas de Wit et al. 1995, Fig. 3).

    Friction at a velocity that falls is less than at the same velocity that rises: the drop of friction with speed
    needs a way to develop. The loop widens with the frequency.

    mean, amplitude: V and h, by default 1.3 and 1.2 of the speed over which friction changes (`contact_sizes`)
    frequencies: omega, by default 0.02, 0.1 and 0.5 of that speed over the displacement of the contact

    Raises ValueError for what is not a positive number.
    """
    check_numbers(load=load)
    sizes = contact_sizes(law, load)
    mean = LAG_MEAN * sizes.speed if mean is None else mean
    amplitude = LAG_AMPLITUDE * sizes.speed if amplitude is None else amplitude
    check_numbers(mean=mean, amplitude=amplitude)
    own = sizes.speed / sizes.displacement * np.array(FREQUENCIES)
    frequency = own if frequencies is None else checked_list("frequencies", frequencies)
    phase = 2.0 * math.pi * np.arange(LAG_SAMPLES + 1) / LAG_SAMPLES
    velocity = mean - amplitude * np.cos(phase)
    force = np.array([_loop(law, mean, amplitude, float(omega), load, sizes.displacement) for omega in frequency])
    half = LAG_SAMPLES // 2
    gap = force[:, : half + 1] - force[:, : half - 1 : -1]  # the same velocities on the way up and on the way down
    place = np.argmax(np.abs(gap), axis=1)
    rows = np.arange(len(frequency))
    area = np.sum(0.5 * (force[:, 1:] + force[:, :-1]) * np.diff(velocity), axis=1)
    return FrictionalLag(frequency, velocity, force, gap[rows, place], velocity[place], area)


def _loop(law: Law, mean: float, amplitude: float, omega: float, load: float, displacement: float) -> np.ndarray:
    """Friction [n] over the last of some cycles, the first of which brings the internal states to a steady motion."""
    travel = 2.0 * math.pi / omega * mean
    cycles = CYCLES + math.ceil(RELAXATIONS * displacement / travel)
    phase = 2.0 * math.pi * np.arange(cycles * LAG_SAMPLES + 1) / LAG_SAMPLES
    forces = driven_force(law, phase / omega, mean - amplitude * np.cos(phase), load=load, tolerance=LAG_TOLERANCE)
    check_motion(forces.status, law)
    return forces.force[-LAG_SAMPLES - 1 :]
