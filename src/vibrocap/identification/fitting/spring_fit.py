"""Fits of rate-and-state friction to velocity steps that are imposed through a spring: the machine's own elasticity."""

import dataclasses
import itertools
import math
import time as clock
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from vibrocap.identification.fitting.fit import split_records
from vibrocap.identification.fitting.solution import Settings, solution
from vibrocap.identification.problem.coordinates import Coordinate
from vibrocap.identification.problem.data_scales import data_scales
from vibrocap.identification.problem.parametrisation import law_class, parametrisation
from vibrocap.identification.problem.samples import Samples
from vibrocap.identification.problem.spring_prediction import SpringPrediction
from vibrocap.identification.problem.velocity_step import (
    Step,
    check_program,
    found_step,
    measured_stiffness,
    path_of,
    relaxation_distance,
)
from vibrocap.identification.result.fit_result import Fit
from vibrocap.progress import Progress, reporting


def spring_fit(
    record: Any,
    law: Any = "rate-and-state-ageing",
    *,
    program: Sequence[Step] | None = None,
    machine_stiffness: float | str | None = None,
    drift: bool = True,
    free: Iterable[str] | None = None,
    fixed: Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    starts: int = 8,
    loss: str = "linear",
    loss_scale: float | None = None,
    intervals: str = "profile",
    load: float | None = None,
    seed: int = 0,
    progress: Progress = None,
) -> Fit:
    """Fit rate-and-state friction to a step of the sliding velocity: a, b, D_c, level and the machine's spring.

    What such a machine imposes and measures is the motion of the load point. The contact lags behind it by the elastic
    shortening of machine and rock, F/k; a law driven by the load point's velocity would see a jump in a that the
    contact never made. So the contact is pulled through a spring, whose stiffness is searched along with the law.

    record: friction force (or coefficient, for a load of 1) and displacement of the load point, sliding one way
    law: a law with one internal state, rate-and-state-ageing or rate-and-state-slip; its reference velocity is the
        first speed, so that the reference coefficient is the level before the step
    program: speeds of the load point; None: one step, found in the displacement
    machine_stiffness: N/m, where it is known; "measured": from the record, see `measured_stiffness`;
        None: searched. drift: search a level that changes with displacement.
    The other arguments, the result and the errors are those of `fit.fit`.
    """
    begin = clock.perf_counter()
    settings = Settings(starts, loss, loss_scale, intervals, seed)
    cls = law_class(law)
    if cls.internal != ("log_age",):
        raise ValueError(f"law: should be a rate-and-state law, got {cls.name}")
    (samples,), _ = split_records(record, (), load)
    steps = tuple(program) if program is not None else found_step(samples, _displacement(record, samples))
    if machine_stiffness == "measured":
        machine_stiffness = measured_stiffness(samples, steps)
    check_program(steps, samples, machine_stiffness)
    assert not isinstance(machine_stiffness, str)
    scales = data_scales([samples])
    held = {"reference_velocity": abs(steps[0].speed), **(fixed or {})}
    rise = abs(float(np.ptp(samples.force)))
    rates = [abs(math.log(after.speed / before.speed)) for before, after in itertools.pairwise(steps)]
    effect = 0.7 * rise / max(rates) / scales.load
    chosen = parametrisation(law, scales, free, held, bounds)
    distance = relaxation_distance(samples, steps)
    guess = {"direct_effect": effect, "evolution_effect": effect, "critical_distance": distance}
    start = dict(zip(chosen.space.names, chosen.space.values(chosen.start).tolist(), strict=True))
    chosen = dataclasses.replace(chosen, start=chosen.space.of(start | {k: v for k, v in guess.items() if k in start}))
    extra, starts_at = [], []
    if machine_stiffness is None:
        spring = 2.0 * rise / distance
        extra.append(Coordinate("machine_stiffness", "log", 0.01 * spring, 100 * spring, spread=0.5))
        starts_at.append(math.log(spring))
    if drift:
        size = rise / float(np.ptp(path_of(steps, samples.time[-1])[1]))
        extra.append(Coordinate("drift", "linear", -10 * size, 10 * size, scale=size, spread=0.0))
        starts_at.append(0.0)
    chosen = dataclasses.replace(
        chosen,
        space=chosen.space.with_more(tuple(extra)),
        start=np.concatenate([chosen.start, starts_at]),
        own_start=None,
    )
    prediction = SpringPrediction(
        chosen.template,
        chosen.space,
        (samples,),
        (samples.deviation,),
        program=steps,
        machine_stiffness=machine_stiffness,
    )
    options = {
        "method": "pulled through a spring",
        "program": [(step.time, step.speed) for step in steps],
        "machine_stiffness": machine_stiffness,
        "drift": drift,
        "load": load,
        "fixed": held,
    }
    with reporting(progress, f"Fitting {chosen.template.name}") as report:
        return solution(prediction, prediction, chosen, settings, (), options, begin, report)


def _displacement(record: Any, samples: Samples) -> np.ndarray:
    measured = getattr(record, "displacement", None)
    return samples.displacement if measured is None else np.asarray(measured, float)
