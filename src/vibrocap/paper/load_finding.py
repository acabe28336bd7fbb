"""What Figs 5-11 become under the dynamic load: a plain sentence for each, with its numbers.

No claim of the paper is judged by it: the paper's model has a constant load.
"""

import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from vibrocap.measures.recorded.sticking import stick_fraction
from vibrocap.motion.status import Status
from vibrocap.motion.trajectory import Trajectory
from vibrocap.paper.claims.claim import RUN_ERROR
from vibrocap.paper.figures.motion import WANDERED
from vibrocap.paper.presets import DISPLACEMENT_MASS_RATIOS, SHORT, figures_5_to_8, figures_9_to_11, with_load
from vibrocap.paper.runs import LAST, SHOWN_PERIODS, LoadedRun, Period, Runs
from vibrocap.paper.travel import PERIOD

PRINTED, DYNAMIC = 1.0, "dynamic"
LOADS: tuple[float | str, ...] = (PRINTED, "weight", DYNAMIC)
LARGE = 100.0  # a load at the end of a run that has grown without end
SPEED = 0.05  # at which the forces of Fig. 8 are compared


@dataclasses.dataclass(frozen=True)
class LoadedMotion:
    """The motion of Figs 5-8 under one load: travel, and the range of the true load in the settled period."""

    friction: str
    load: float | str
    travel: float  # X after `SHOWN_PERIODS`
    drift: float  # per period, settled
    least_load: float
    largest_load: float


@dataclasses.dataclass(frozen=True)
class LoadedFigure:
    """What one figure becomes, in a sentence, and the numbers in it."""

    sentence: str
    numbers: Mapping[str, float]


def loaded_motions(runs: Runs) -> tuple[LoadedMotion, ...]:
    """The motions of Figs 5-8 under the printed load, the weight of the machine, and the load that the motion makes."""
    motions = []
    for name in SHORT:
        for load in LOADS:
            period = runs.steady(name, load=load)
            travel = period.motion.sections[SHOWN_PERIODS, 2]
            reaction = period.motion.at(period.motion.end - period.motion.period + period.time, "reaction")
            extremes = float(reaction.min()), float(reaction.max())
            motions.append(LoadedMotion(SHORT[name], load, float(travel), period.drift, *extremes))
    return tuple(motions)


def loaded_figure(runs: Runs, key: str) -> LoadedFigure:
    """What a figure becomes under the dynamic load; key: "load05" to "load11"."""
    return _FIGURES[key](runs)


def _number(value: float) -> str:
    """Three digits; what is nothing but the error of the runs is called so."""
    return "nothing" if abs(value) < RUN_ERROR.value else f"{value:.3g}".replace("-", "−")


def _both(values: Sequence[float]) -> str:
    """Numbers of LM and of EM."""
    lm, em = map(_number, values)
    return f"{lm} with either law" if lm == em else f"{lm} with LM and {em} with EM"


def _numbers(**pairs: Sequence[float]) -> dict[str, float]:
    """Numbers of LM and EM, by what they are."""
    return {
        f"{short}: {name.replace('_', ' ')}": float(value)
        for name, values in pairs.items()
        for short, value in zip(SHORT.values(), values, strict=True)
    }


def _settled(runs: Runs) -> tuple[list[Period], list[Period]]:
    """The settled periods of LM and EM, under the printed load and under that of the motion."""
    before, after = ([runs.steady(name, load=load) for name in SHORT] for load in (PRINTED, DYNAMIC))
    return before, after


def _figure_5(runs: Runs) -> LoadedFigure:
    rows = loaded_motions(runs)
    before, after = ([row for row in rows if row.load == load] for load in (PRINTED, DYNAMIC))
    least, largest = min(row.least_load for row in after), max(row.largest_load for row in after)
    mean = float(with_load(figures_5_to_8(), DYNAMIC).machine.loads()[0])
    sentence = (
        f"The load swings between {least:.3g} and {largest:.3g} about its mean of {mean:g}, where the paper has 1: X "
        f"after {SHOWN_PERIODS} periods is {_both([row.travel for row in after])}, instead of "
        f"{_both([row.travel for row in before])}, and the settled drift per period is "
        f"{_both([row.drift for row in after])}, instead of {_both([row.drift for row in before])}."
    )
    numbers = _numbers(
        X_after_forty_periods=[row.travel for row in after],
        drift_per_period=[row.drift for row in after],
        least_load=[row.least_load for row in after],
        largest_load=[row.largest_load for row in after],
    )
    return LoadedFigure(sentence, numbers)


def _figure_6(runs: Runs) -> LoadedFigure:
    both = _settled(runs)
    peaks = [[float(np.max(np.abs(period["friction"]))) for period in periods] for periods in both]
    shares = [stick_fraction(periods[1].motion, periods=1) or 0.0 for periods in both]
    sentence = (
        f"The largest friction force of the settled period is {_both(peaks[1])}, instead of {_both(peaks[0])}, and EM "
        f"is stuck for {shares[1]:.1%} of the time, instead of {shares[0]:.1%}."
    ).replace("%", " %")
    return LoadedFigure(sentence, _numbers(largest_friction=peaks[1]) | {"EM: share stuck": shares[1]})


def _figure_7(runs: Runs) -> LoadedFigure:
    both = _settled(runs)
    swings = [[float(np.ptp(period["position"])) for period in periods] for periods in both]
    gaps = [[abs(period.drift) for period in periods] for periods in both]
    angles = [[float(np.max(np.abs(period["angle"]))) for period in periods] for periods in both]
    sentence = (
        f"The gap of the capsule's curve is {_both(gaps[1])}, instead of {_both(gaps[0])}; within a period X ranges "
        f"over {_both(swings[1])}, instead of {_both(swings[0])}. The pendulum hardly notices: its largest angle is "
        f"{_both(angles[1])}, instead of {_both(angles[0])}."
    )
    return LoadedFigure(sentence, _numbers(gap=gaps[1], range_of_X=swings[1], largest_angle=angles[1]))


def _figure_8(runs: Runs) -> LoadedFigure:
    before, after = ([_forces(period) for period in periods] for periods in _settled(runs))
    lm, em = map(_range, after)
    as_printed = [_range(forces) for forces in before]
    sentence = (
        f"EM, which has no memory, draws a loop, too, because the load has changed when a velocity comes again: at "
        f"X′ = {SPEED:g} its force is {em}, as printed {as_printed[1]} (LM: {lm}, as printed {as_printed[0]})."
    )
    least, largest = [min(forces) for forces in after], [max(forces) for forces in after]
    return LoadedFigure(sentence, _numbers(least_force_at_that_speed=least, largest_force_at_that_speed=largest))


def _forces(period: Period) -> list[float]:
    """Friction whenever the velocity of a period passes `SPEED`."""
    above, friction = period["velocity"] - SPEED, period["friction"]
    at = np.flatnonzero(above[1:] * above[:-1] < 0.0)
    share = above[at] / (above[at] - above[at + 1])
    return (friction[at] + share * (friction[at + 1] - friction[at])).tolist()


def _range(forces: Sequence[float]) -> str:
    low, high = _number(min(forces)), _number(max(forces))
    return f"{low} each time" if low == high else f"{low} to {high}"


def _figure_9(runs: Runs) -> LoadedFigure:
    sweeps = {short: runs.loaded_sweep(name) for name, short in SHORT.items()}
    light = {short: runs.loaded_sweep(name, light=True) for name, short in SHORT.items()}
    period = PERIOD
    steady = [max(abs(run.mean_velocity(period, LAST, True)) for run in _done(sweeps[s])) for s in sweeps]
    transient = [max(abs(run.mean_velocity(period, SHOWN_PERIODS)) for run in _done(sweeps[s])) for s in sweeps]
    resting = itertools.takewhile(lambda run: run.at_rest, reversed(sweeps["EM"]))  # never moves, nor at all above
    rests = min((run.mass_ratio for run in resting), default=float("nan"))
    ends = "; ".join(_ends(short, runs_of) for short, runs_of in light.items())
    sentence = (
        f"Wherever a run goes to its end, its steady average velocity is nothing, as under the printed load: at most "
        f"{max(steady):.1g}. The transient is smaller, its average over {SHOWN_PERIODS} periods at most "
        f"{_both(transient)}; from λ = {rests:.3g} on EM never leaves its place. Light capsules do not go to the end: "
        f"{ends}."
    )
    least = [min(run.mass_ratio for run in _done(runs_of)) for runs_of in light.values()]
    numbers = _numbers(largest_steady_velocity=steady, largest_transient_average=transient, least_mass_ratio=least)
    return LoadedFigure(sentence, numbers | {"EM: at rest from lambda": rests})


def _done(runs_of: Sequence[LoadedRun]) -> list[LoadedRun]:
    return [run for run in runs_of if run.status.ok]


def _ends(short: str, runs_of: Sequence[LoadedRun]) -> str:
    """How the runs of light capsules ended, in words."""
    parts = []
    for status in dict.fromkeys(run.status for run in runs_of if not run.status.ok):
        ended = [run for run in runs_of if run.status is status]
        ratios, times = [run.mass_ratio for run in ended], [run.end / PERIOD for run in ended]
        what = f"{_END_WORDS.get(status, 'they end')} (“{status.value}”)"
        span = f"λ = {ratios[0]:.3g}" if len(ratios) == 1 else f"λ = {ratios[0]:.3g} to {ratios[-1]:.3g}"
        parts.append(f"at {span} {what} after {min(times):.2f} to {max(times):.2f} periods{_growing(ended)}")
    return f"with {short} " + (" and ".join(parts) if parts else "every run does")


def _growing(ended: Sequence[LoadedRun]) -> str:
    """Of runs that end in Painleve's paradox, how large load and coefficient have become; empty for others."""
    bounds = [2.0 * math.sqrt(run.mass_ratio * (run.mass_ratio + 1.0)) for run in ended]
    if any(run.last_load < LARGE or run.last_coefficient < bound for run, bound in zip(ended, bounds, strict=True)):
        return ""
    least, load = min(run.last_coefficient for run in ended), min(run.last_load for run in ended)
    return (
        f", as friction and load raise one another (Painlevé's paradox: the load has grown to {load:.0e} at least, and "
        f"|R|/N to {least:.2g} at least, beyond 2√(λ(λ + 1)))"
    )


_END_WORDS = {
    Status.LIFT_OFF: "the capsule lifts off",
    Status.STEP_UNDERFLOW: "the equations become singular",
    Status.PARADOX: "the load no longer follows from the forces",
}


def _by_mass_ratio(runs: Runs, words: str, name: str, number: Callable[[Trajectory], float]) -> LoadedFigure:
    """A number of the runs shown, at each of the mass ratios, under the load of the motion and as printed."""
    parts, numbers = [], {}
    for law, short in SHORT.items():
        before, after = (
            [
                float(number(runs.motion(with_load(figures_9_to_11(law, ratio), load))))
                for ratio in DISPLACEMENT_MASS_RATIOS
            ]
            for load in (PRINTED, DYNAMIC)
        )
        parts.append(f"{_listed(after)} with {short} (as printed: {_listed(before)})")
        for ratio, value in zip(DISPLACEMENT_MASS_RATIOS, after, strict=True):
            numbers[f"{short}: {name}, lambda {ratio:g}"] = value
    return LoadedFigure(f"{words} at λ = {_listed(DISPLACEMENT_MASS_RATIOS)} is {', and '.join(parts)}.", numbers)


def _listed(values: Sequence[float]) -> str:
    """Numbers in a row."""
    *first, last = map(_number, values)
    return f"{last} at each" if set(first) == {last} else f"{', '.join(first)} and {last}"


_FIGURES: dict[str, Callable[[Runs], LoadedFigure]] = {
    "load05": _figure_5,
    "load06": _figure_6,
    "load07": _figure_7,
    "load08": _figure_8,
    "load09": _figure_9,
    "load10": lambda runs: _by_mass_ratio(
        runs, "The largest velocity of the capsule", "largest |X'|", lambda motion: np.max(np.abs(motion["velocity"]))
    ),
    "load11": lambda runs: _by_mass_ratio(
        runs, f"After {WANDERED} periods X", f"X after {WANDERED} periods", lambda motion: motion.sections[WANDERED, 2]
    ),
}
