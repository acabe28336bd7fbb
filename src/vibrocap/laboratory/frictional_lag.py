"""The frictional lag: sliding at a velocity that varies, friction follows with a delay."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from vibrocap.laboratory.contact_sizes import contact_sizes
from vibrocap.laboratory.driven import check_motion, check_numbers, checked_list, driven_force
from vibrocap.physics.friction.law import Law

MEAN, AMPLITUDE = 1.3, 1.2  # speeds of the contact: a motion that nearly stops but never turns
FREQUENCIES = (0.02, 0.1, 0.5)  # over speed/displacement of the contact
SAMPLES = 2048  # per cycle
TOLERANCE = 1e-10
RELAXATIONS = 40.0  # displacements of the contact to slide before the cycle that is kept, and at least
CYCLES = 2  # cycles


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
    mean = MEAN * sizes.speed if mean is None else mean
    amplitude = AMPLITUDE * sizes.speed if amplitude is None else amplitude
    check_numbers(mean=mean, amplitude=amplitude)
    own = sizes.speed / sizes.displacement * np.array(FREQUENCIES)
    frequency = own if frequencies is None else checked_list("frequencies", frequencies)
    phase = 2.0 * math.pi * np.arange(SAMPLES + 1) / SAMPLES
    velocity = mean - amplitude * np.cos(phase)
    force = np.array([_loop(law, mean, amplitude, float(omega), load, sizes.displacement) for omega in frequency])
    half = SAMPLES // 2
    gap = force[:, : half + 1] - force[:, : half - 1 : -1]  # the same velocities on the way up and on the way down
    place = np.argmax(np.abs(gap), axis=1)
    rows = np.arange(len(frequency))
    area = np.sum(0.5 * (force[:, 1:] + force[:, :-1]) * np.diff(velocity), axis=1)
    return FrictionalLag(frequency, velocity, force, gap[rows, place], velocity[place], area)


def _loop(law: Law, mean: float, amplitude: float, omega: float, load: float, displacement: float) -> np.ndarray:
    """Friction [n] over the last of some cycles, the first of which brings the internal states to a steady motion."""
    travel = 2.0 * math.pi / omega * mean
    cycles = CYCLES + math.ceil(RELAXATIONS * displacement / travel)
    phase = 2.0 * math.pi * np.arange(cycles * SAMPLES + 1) / SAMPLES
    forces = driven_force(law, phase / omega, mean - amplitude * np.cos(phase), load=load, tolerance=TOLERANCE)
    check_motion(forces.status, law)
    return forces.force[-SAMPLES - 1 :]
