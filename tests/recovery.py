"""Recovery: whether fits of simulated experiments give back the parameters that made them, as often as they state."""

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.identification.experiments.experiment_design import (
    Motion,
    joined,
    multisine,
    ramp,
    sinusoid,
    steps,
    synthetic_record,
)
from vibrocap.identification.fit import fit
from vibrocap.identification.problem.parametrisation import role, with_role
from vibrocap.physics.friction.law import Law
from vibrocap.physics.parameters import parameter_table


@dataclasses.dataclass(frozen=True)
class RecoveredParameter:
    """One parameter over all repetitions.

    inside: how many intervals (95 %) hold its true value; determined: how many fits call it determined; bias: mean
    error over the mean standard error; width: median of half the interval over the true value (inf where it is open).
    """

    name: str
    true: float
    inside: int
    determined: int
    bias: float
    width: float


@dataclasses.dataclass(frozen=True)
class Recovery:
    """Repeated simulated experiments on one law. failed: fits that found no law (they count as outside)."""

    law: Law
    repetitions: int
    failed: int
    parameters: tuple[RecoveredParameter, ...]

    @property
    def identifiable(self) -> tuple[RecoveredParameter, ...]:
        """The parameters that at least half of the fits call determined."""
        return tuple(parameter for parameter in self.parameters if 2 * parameter.determined >= self.repetitions)


def recovery(
    law: Law,
    motions: Sequence[Motion] | None = None,
    *,
    noise: float = 0.02,
    repetitions: int = 100,
    first_seed: int = 0,
    load: float = 1.0,
    progress: Callable[[float], None] | None = None,
    **settings: Any,
) -> Recovery:
    """Simulate an experiment many times with new noise, fit each from its data alone, count the intervals that hold.

    motions: what is imposed; None: a motion that tells of every parameter (`telling_motion`). noise: standard
    deviation of the force's white noise over that of the force. **settings: of `fit`; by default 4 starts and a
    relaxed contact at the start. The fit knows the law's class, its conventions and whole exponents, and nothing else.
    """
    motions = [telling_motion(law, load)] if motions is None else list(motions)
    settings = {"starts": 4, "start": "relaxed", **settings}
    held = conventions(law)
    inside: dict[str, list[tuple[bool, bool, float, float, float]]] = {}
    failed = 0
    for i in range(repetitions):
        seed = first_seed + i
        records = [
            synthetic_record(law, motion, noise=noise, load=load, seed=seed * len(motions) + j)
            for j, motion in enumerate(motions)
        ]
        one = fit(records, type(law), fixed=held, seed=seed, **settings)
        failed += not one.ok
        for name in one.free:
            p, true = one[name], float(getattr(law, name))
            row = (true in p, p.determined, p.value - true, p.standard_error, 0.5 * (p.high - p.low))
            inside.setdefault(name, []).append(row)
        if progress is not None:
            progress((i + 1) / repetitions)
    parameters = []
    for name, rows in inside.items():
        holds, determined, errors, stated, widths = (np.array(column, float) for column in zip(*rows, strict=True))
        true = float(getattr(law, name))
        bias = float(np.mean(errors) / max(np.mean(stated), 1e-300))
        width = float(np.median(widths)) / (abs(true) or 1.0)
        parameters.append(RecoveredParameter(name, true, int(holds.sum()), int(determined.sum()), bias, width))
    return Recovery(law, repetitions, failed, tuple(parameters))


def conventions(law: Law) -> Mapping[str, float]:
    """What a fit of a law is told: whole exponents and parameters that are conventions."""
    table = {}
    for info in parameter_table(law):
        value = getattr(law, info.name)
        if isinstance(value, float) and (not role(law, info.name).fitted or info.name in law.shape_parameters):
            table[info.name] = value
    return table


def telling_motion(law: Law, load: float = 1.0) -> Motion:
    """A motion that tells of every parameter of a law whose sizes are known: loops, sweeps, fast changes, steps.

    Presliding loops with strokes from a third to ten times the breakaway distance, small fast oscillations, sweeps of
    speed across each of the law's own speeds, fast slides; for rate-and-state friction steps of the speed.
    """
    renewal, references = _values(law, "distance"), _values(law, "reference velocity")
    if renewal and references:
        speeds = [references[0] * factor for factor in (1.0, 10.0, 1.0, 30.0, 3.0, 10.0, 1.0)]
        return steps(speeds, 8.0 * renewal[0], 1400)
    speeds = _values(law, "Stribeck velocity", "fading velocity", "smoothing velocity", "cutoff velocity") + references
    speeds += [1.0 / value for value in _values(law, "decay rate") if value]
    speeds = sorted(speeds) or [0.1]
    stiffness, levels, gap = _values(law, "stiffness"), _values(law, "level"), sum(_values(law, "gap"))
    parts: list[Motion] = []
    far = 10.0 * speeds[-1]
    if stiffness and levels:
        distance = load * levels[0] / sum(stiffness)
        slow = 0.2 * speeds[-1] / distance / (2 * math.pi)  # Hz: strokes of a few distances stay slow
        parts += [sinusoid(0.5 * (n * distance + 2 * gap), slow / n, 2, 240) for n in (1.0, 3.0, 10.0)]
        parts.append(sinusoid(0.3 * distance + gap, 10 * slow, 4, 240))
        tones = [far / (600 * distance + 20 * gap) * f for f in (1.0, 2.3)]
        parts.append(multisine(60 * distance + 2 * gap, tones, 480))
    parts += [ramp(4 * speed, 40.0 * _settling(law, speed, load), 480) for speed in speeds]
    parts.append(ramp(far, 40.0 * _settling(law, far, load), 240))
    return joined(parts, "telling motion")


def _settling(law: Law, speed: float, load: float) -> float:
    """Time in which the contact settles at a speed, or a second where it has no memory."""
    stiffness, levels = _values(law, "stiffness"), _values(law, "level")
    if not stiffness or not levels:
        return 0.1
    distance = load * levels[0] / min(stiffness)
    return (distance + sum(_values(law, "gap"))) / speed


def _values(law: Law, *roles: str) -> list[float]:
    """Values of the parameters with these roles, without those that the law goes without."""
    return [float(value) for name in with_role(law, *roles) if (value := getattr(law, name)) is not None]
