"""Motions to impose on a contact: sinusoids, ramps, steps, multi-sines, and records that a law would give."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_positive
from vibrocap.laboratory.driven import driven_force
from vibrocap.physics.friction.law import Law
from vibrocap.records.checks import integral
from vibrocap.records.record import Record


@dataclasses.dataclass(frozen=True, eq=False)
class Motion:
    """A motion of a contact from rest: time [n] s, velocity [n] m/s."""

    name: str
    time: np.ndarray
    velocity: np.ndarray

    @property
    def displacement(self) -> np.ndarray:
        """Displacement from the start, m."""
        return integral(self.time, self.velocity)


def sinusoid(amplitude: float, frequency: float, cycles: float = 3, samples: int = 600, unit: str = "m") -> Motion:
    """Harmonic displacement about its middle, x = -amplitude cos(2 pi frequency t), from rest."""
    _check(amplitude=amplitude, frequency=frequency, cycles=cycles)
    time = np.linspace(0.0, cycles / frequency, samples)
    omega = 2 * np.pi * frequency
    name = f"sinusoid of {amplitude:.3g} {unit} at {frequency:.3g} Hz"
    return Motion(name, time, amplitude * omega * np.sin(omega * time))


def ramp(speed: float, duration: float, samples: int = 600, unit: str = "m") -> Motion:
    """Velocity that rises to `speed` and falls to rest, then the same backward: a slow one sweeps the steady curve."""
    _check(speed=speed, duration=duration)
    time = np.linspace(0.0, duration, samples)
    velocity = np.interp(time / duration, [0, 0.25, 0.5, 0.75, 1], [0, speed, 0, -speed, 0])
    return Motion(f"ramps to {speed:.3g} {unit}/s in {duration / 4:.3g} s", time, velocity)


def steps(speeds: Sequence[float], distance: float, samples: int = 600) -> Motion:
    """Constant speeds one after the other, each over the same distance; a hundredth of the time is for each change."""
    _check(distance=distance, **{f"speeds[{i}]": abs(v) for i, v in enumerate(speeds)})
    knots, values = [0.0], [0.0]
    for speed in speeds:
        span = distance / abs(speed)
        knots += [knots[-1] + 0.01 * span, knots[-1] + span]
        values += [speed, speed]
    time = np.linspace(0.0, knots[-1], samples)
    time = np.unique(np.concatenate([time, knots]))
    names = ", ".join(f"{v:.3g}" for v in speeds)
    return Motion(f"steps of velocity {names} m/s", time, np.interp(time, knots, values))


def multisine(
    amplitude: float, frequencies: Sequence[float], samples: int = 1200, seed: int = 0, unit: str = "m"
) -> Motion:
    """Sum of sinusoids of velocity with random phases, of equal speed, scaled to a largest displacement; from rest.

    It begins and ends with a tenth of its time in which it swells and fades.
    """
    _check(amplitude=amplitude, **{f"frequencies[{i}]": f for i, f in enumerate(frequencies)})
    lowest = min(frequencies)
    time = np.linspace(0.0, 4 / lowest, samples)
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, len(frequencies))
    velocity = sum(np.sin(2 * np.pi * f * time + phase) for f, phase in zip(frequencies, phases, strict=True))
    swelling = np.clip(10 * np.minimum(time, time[-1] - time) / time[-1], 0, 1)
    velocity = velocity * swelling
    velocity = velocity - np.mean(velocity) * swelling / 0.9
    motion = Motion("", time, velocity)
    scale = amplitude / max(0.5 * float(np.ptp(motion.displacement)), 1e-300)
    name = f"multi-sine of {amplitude:.3g} {unit} with {', '.join(f'{f:.3g}' for f in frequencies)} Hz"
    return Motion(name, time, velocity * scale)


def joined(motions: Sequence[Motion], name: str = "") -> Motion:
    """Motions one after the other."""
    times, velocities, begin = [], [], 0.0
    for i, motion in enumerate(motions):
        first = 0 if i == 0 else 1  # the last sample of one motion is the first of the next
        times.append(begin + motion.time[first:] - motion.time[0])
        velocities.append(motion.velocity[first:])
        begin = times[-1][-1]
    return Motion(name or ", ".join(m.name for m in motions), np.concatenate(times), np.concatenate(velocities))


def synthetic_record(law: Law, motion: Motion, *, noise: float = 0.0, load: float = 1.0, seed: int = 0) -> Any:
    """The `Record` that a law would give under a motion, with white noise on the force.

    noise: its standard deviation over that of the force. Raises ValueError where the law cannot be driven so.
    """
    driven = driven_force(law, motion.time, motion.velocity, load=load)
    if not driven.status.ok:
        raise ArgumentError("law", f"{law.name} cannot be driven by {motion.name}: {driven.status}")
    wobble = np.random.default_rng(seed).standard_normal(len(motion.time))
    force = driven.force + noise * float(np.std(driven.force)) * wobble
    columns: dict[str, Any] = {"velocity": motion.velocity, "displacement": motion.displacement}
    columns |= {"acceleration": np.gradient(motion.velocity, motion.time), "normal_force": load}
    source = f"{law.name} law, {100 * noise:g} % noise, seed {seed}"
    return Record(motion.name or "motion", motion.time, force, **columns, source=source)


def checked_range(name: str, ends: Any) -> tuple[float, float]:
    """(lowest, highest) > 0, or ArgumentError."""
    try:
        low, high = (float(end) for end in ends)
    except (TypeError, ValueError):
        low = high = math.nan
    if not 0 < low < high < math.inf:
        raise ArgumentError(name, f"should be (lowest, highest) with 0 < lowest < highest, got {ends!r}")
    return low, high


def _check(**numbers: float) -> None:
    for name, value in numbers.items():
        if not is_positive(value):
            raise ArgumentError(name, f"should be > 0, got {value!r}")
