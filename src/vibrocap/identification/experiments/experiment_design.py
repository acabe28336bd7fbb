"""Experiment design: the most informative motions for the parameters of a law."""

import dataclasses
import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_positive, suggestion
from vibrocap.identification.experiments.motions import Motion, checked_range, multisine, ramp, sinusoid
from vibrocap.identification.inference.identifiability import LOOSE, beside
from vibrocap.identification.inference.uncertainty import Problem
from vibrocap.identification.problem.parameter_roles import role
from vibrocap.identification.result.fit_result import Chapter, Fit
from vibrocap.laboratory.driven import driven_forces
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table
from vibrocap.results import Result

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
    rated = sorted((_rated(m, names, known, i, criterion) for m, i in driven), key=lambda experiment: -experiment.gain)
    best_motions, so_far = [], known
    for _ in range(min(experiments, len(driven))):
        best = max(((_rated(m, names, so_far, i, criterion), i) for m, i in driven), key=lambda pair: pair[0].gain)
        best_motions.append(best[0])
        so_far = so_far + best[1]
    before, after = _deviations(names, known), _deviations(names, so_far)
    sentences = _sentences(base, names, best_motions, before, after)
    return ExperimentDesign(names, criterion, tuple(best_motions), tuple(rated), before, after, sentences)


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
    best_motions: Sequence[RatedMotion],
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> tuple[str, ...]:
    sentences = [f"{m.motion.name} determines {', '.join(m.determines)}." for m in best_motions if m.determines]
    still = [name for name in names if after[name] >= LOOSE]
    if still:
        others = "; ".join(f"{role(law, name).experiment.rstrip(',')} would" for name in still)
        sentences.append(f"None of these motions determines {', '.join(still)}: {others}.")
    elif all(deviation < LOOSE for deviation in before.values()):
        sentences.append("Every parameter is determined already; the chosen motions sharpen them.")
    return tuple(sentences)
