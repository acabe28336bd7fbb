"""Experiment design: motions to impose on a contact, and the most informative of them for the parameters of a law."""

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_positive, suggestion
from vibrocap.identification.fit_result import Chapter, Fit
from vibrocap.identification.inference.identifiability import LOOSE, beside
from vibrocap.identification.inference.uncertainty import Problem
from vibrocap.identification.problem.parametrisation import role
from vibrocap.laboratory.driven import check_numbers, driven_force, driven_forces
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table
from vibrocap.records.record import Record, integral
from vibrocap.results import Result


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
    check_numbers(amplitude=amplitude, frequency=frequency, cycles=cycles)
    time = np.linspace(0.0, cycles / frequency, samples)
    omega = 2 * np.pi * frequency
    name = f"sinusoid of {amplitude:.3g} {unit} at {frequency:.3g} Hz"
    return Motion(name, time, amplitude * omega * np.sin(omega * time))


def ramp(speed: float, duration: float, samples: int = 600, unit: str = "m") -> Motion:
    """Velocity that rises to `speed` and falls to rest, then the same backward: a slow one sweeps the steady curve."""
    check_numbers(speed=speed, duration=duration)
    time = np.linspace(0.0, duration, samples)
    velocity = np.interp(time / duration, [0, 0.25, 0.5, 0.75, 1], [0, speed, 0, -speed, 0])
    return Motion(f"ramps to {speed:.3g} {unit}/s in {duration / 4:.3g} s", time, velocity)


def steps(speeds: Sequence[float], distance: float, samples: int = 600) -> Motion:
    """Constant speeds one after the other, each over the same distance; a hundredth of the time is for each change."""
    check_numbers(distance=distance, **{f"speeds[{i}]": abs(v) for i, v in enumerate(speeds)})
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
    check_numbers(amplitude=amplitude, **{f"frequencies[{i}]": f for i, f in enumerate(frequencies)})
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


STEP = 1e-4  # of a logarithm, for differences
VAGUE = 10.0  # standard deviation of a logarithm before any experiment: a factor of 2e4


@dataclasses.dataclass(frozen=True, eq=False)
class RatedMotion:
    """One candidate, and its information by itself.

    deviations: standard deviation of the logarithm of each parameter after this motion (and what was known before);
    gain: how much the criterion falls; determines: parameters below LOOSE that were not before.
    """

    motion: Motion
    deviations: Mapping[str, float]
    gain: float
    determines: tuple[str, ...]


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class ExperimentDesign(Result):
    """Which motions to impose.

    chosen: the best sequence, each the best addition to those before it; rated: all candidates by themselves, the best
    first; before, after: standard deviations of the parameters' logarithms without and with the chosen motions;
    sentences: the parameters that each determines.
    """

    parameters: tuple[str, ...]
    criterion: str
    chosen: tuple[RatedMotion, ...]
    rated: tuple[RatedMotion, ...]
    before: Mapping[str, float]
    after: Mapping[str, float]
    sentences: tuple[str, ...]

    in_record = "criterion motions before after sentences"

    @property
    def motions(self) -> list[dict[str, Any]]:
        """The chosen motions: name, gain, and the deviations after each of them alone."""
        return [{"name": m.motion.name, "gain": m.gain, "deviations": dict(m.deviations)} for m in self.chosen]

    @property
    def chapter(self) -> Chapter:
        """What to do next, in words."""
        best = "; ".join(dict.fromkeys(experiment.motion.name for experiment in self.chosen))
        return Chapter("The next experiments", sentences=[f"The most informative motion is {best}.", *self.sentences])


def candidate_motions(
    *,
    amplitude: tuple[float, float],
    frequency: tuple[float, float],
    speed: float | None = None,
    samples: int = 600,
    unit: str = "m",
) -> tuple[Motion, ...]:
    """Motions that a rig can make: sinusoids over a grid of amplitude and frequency, ramps, and two multi-sines.

    amplitude m, frequency Hz: (lowest, highest), of which 4 and 3 values are taken on a logarithmic grid; speed m/s:
    the rig's largest, which leaves out what is faster (by default what the largest sinusoid asks for). unit: rad where
    the contact turns.
    """
    for name, ends in (("amplitude", amplitude), ("frequency", frequency)):
        checked_range(name, ends)
    largest = speed or 2 * math.pi * amplitude[1] * frequency[1]
    grid = itertools.product(np.geomspace(*amplitude, 4).tolist(), np.geomspace(*frequency, 3).tolist())
    motions = [sinusoid(a, f, samples=samples, unit=unit) for a, f in grid]
    tops = np.geomspace(0.01 * largest, largest, 3).tolist()
    motions += [ramp(top, 8 * amplitude[1] / top, samples, unit) for top in tops]
    tones = np.geomspace(*frequency, 4).tolist()
    motions += [multisine(a, tones, samples, unit=unit) for a in amplitude]
    return tuple(motion for motion in motions if np.abs(motion.velocity).max() <= largest * (1 + 1e-9))


def experiment_design(
    law: Law | Fit,
    candidates: Sequence[Motion],
    *,
    noise: float | None = None,
    load: float | None = None,
    parameters: Iterable[str] | None = None,
    criterion: str = "D",
    experiments: int = 3,
) -> ExperimentDesign:
    """The motions that determine a law's parameters best, by the Fisher information of the driven law.

        information M = sum over samples of (dR/dlog p)^T (dR/dlog p) / noise^2,  covariance of log p at least M^-1

    D maximises log det M (the volume of what remains possible), A minimises the trace of M^-1 (the mean variance). What
    is known before is that each logarithm has a standard deviation of 10, and with a `Fit` also what its records told.

    law: a law with the parameters as far as they are known, or a fit; the design is as good as these (it is local)
    noise: standard deviation of the force's error, in its unit; a fit knows its own
    load: normal force; None: the mean of the fit's records, 1 for a law
    parameters: names; None: all numbers above 0 that are not whole exponents or conventions
    Raises ValueError for input that makes no sense, and where no candidate can be driven.
    """
    fitted = law if isinstance(law, Fit) else None
    problem = None if fitted is None else fitted.problem
    base: Any = law if fitted is None else fitted.law
    if fitted is not None and (base is None or problem is None):
        raise ArgumentError("law", "the fit should be one of this session that found a law")
    if not isinstance(base, Law):
        raise ArgumentError("law", f"should be a friction law with its parameters, or a fit, got {law!r}")
    if noise is None and fitted is None:
        raise ArgumentError("noise", "is missing; should be the standard deviation of the force's error")
    noise = fitted.rmse if noise is None and fitted is not None else noise
    if noise is None or not is_positive(noise):
        raise ArgumentError("noise", f"should be > 0, got {noise!r}")
    if criterion not in ("D", "A"):
        raise ArgumentError("criterion", f"should be 'D' or 'A', got {criterion!r}")
    if not candidates:
        raise ArgumentError("candidates", "there is none")
    names = _names(base, parameters, fitted)
    if load is None:
        loads = [1.0] if problem is None else [np.mean(record.load) for record in problem.prediction.records]
        load = float(np.mean(loads))
    known = np.eye(len(names)) / VAGUE**2 + (0.0 if problem is None else _known(problem, names))
    informations = [(motion, _information(base, names, motion, noise, load)) for motion in candidates]
    driven = [(motion, information) for motion, information in informations if information is not None]
    if not driven:
        raise ArgumentError("candidates", f"{base.name} can be driven through none of them")

    def rated(before: np.ndarray) -> list[tuple[RatedMotion, np.ndarray]]:  # the best first
        pairs = [(_rated(motion, names, before, more, criterion), more) for motion, more in driven]
        return sorted(pairs, key=lambda pair: -pair[0].gain)

    chosen, so_far = [], known
    for _ in range(min(experiments, len(driven))):
        (best, more), *_ = rated(so_far)
        chosen.append(best)
        so_far = so_far + more
    before, after = _deviations(names, known), _deviations(names, so_far)
    sentences, alone = _sentences(base, names, chosen, before, after), tuple(motion for motion, _ in rated(known))
    return ExperimentDesign(names, criterion, tuple(chosen), alone, before, after, sentences)


def _names(law: Law, parameters: Iterable[str] | None, fitted: Fit | None) -> tuple[str, ...]:
    values = {info.name: getattr(law, info.name) for info in parameter_table(law)}
    numbers = {name: value for name, value in values.items() if isinstance(value, float) and value > 0}
    if parameters is None and fitted is not None:
        return tuple(name for name in fitted.free if name in numbers)
    if parameters is None:
        whole = [name for name in law.shape_parameters if name in numbers and numbers[name] == int(numbers[name])]
        return tuple(name for name in numbers if role(law, name).fitted and name not in whole)
    names = tuple(parameters)
    for name in names:
        if name not in numbers:
            complaint = f"{law.name} has no parameter {name!r} above 0; {suggestion(name, numbers)}"
            raise ArgumentError("parameters", complaint)
    if not names:
        raise ArgumentError("parameters", "there is none")
    return names


def _information(law: Law, names: Sequence[str], motion: Motion, noise: float, load: float) -> np.ndarray | None:
    """Fisher information of the logarithms in one motion; None where the law cannot be driven through it."""
    values = np.array([getattr(law, name) for name in names])
    table = np.tile(values, (len(names) + 1, 1))
    table[range(len(names)), range(len(names))] *= math.exp(STEP)
    forces = driven_forces(law, table, names, motion.time, motion.velocity, load=load).force
    if not np.isfinite(forces).all():
        return None
    slopes = (forces[:-1] - forces[-1]) / STEP / noise
    return slopes @ slopes.T


def _known(problem: Problem, names: Sequence[str]) -> np.ndarray:
    """Information of a fit's records on the logarithms, after the nuisance parameters have taken their share."""
    space, best = problem.prediction.space, problem.best
    values = space.named(best.u)
    slopes = best.slopes @ np.linalg.inv(space.slopes(best.u))
    others = [j for j, coordinate in enumerate(space.coordinates) if coordinate.nuisance]
    own = slopes[:, [space.names.index(name) for name in names]] * [values[name] for name in names]
    if others:
        own = beside(own, slopes[:, others])
    return own.T @ own / (problem.uncertainty.unit * float(np.median(problem.uncertainty.inflation)))


def _rated(motion: Motion, names: Sequence[str], known: np.ndarray, more: np.ndarray, criterion: str) -> RatedMotion:
    before, after = _deviations(names, known), _deviations(names, known + more)
    if criterion == "D":
        gain = float(np.linalg.slogdet(known + more)[1] - np.linalg.slogdet(known)[1])
    else:
        gain = float(sum(d * d for d in before.values()) - sum(d * d for d in after.values()))
    new = tuple(name for name in names if after[name] < LOOSE <= before[name])
    return RatedMotion(motion, after, gain, new)


def _deviations(names: Sequence[str], information: np.ndarray) -> dict[str, float]:
    variances = np.diag(np.linalg.inv(information))
    return dict(zip(names, np.sqrt(np.maximum(variances, 0.0)).tolist(), strict=True))


def _sentences(
    law: Law,
    names: Sequence[str],
    chosen: Sequence[RatedMotion],
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> tuple[str, ...]:
    sentences = [f"{m.motion.name} determines {', '.join(m.determines)}." for m in chosen if m.determines]
    still = [name for name in names if after[name] >= LOOSE]
    if still:
        others = "; ".join(f"{role(law, name).experiment.rstrip(',')} would" for name in still)
        sentences.append(f"None of these motions determines {', '.join(still)}: {others}.")
    elif all(deviation < LOOSE for deviation in before.values()):
        sentences.append("Every parameter is determined already; the chosen motions sharpen them.")
    return tuple(sentences)
