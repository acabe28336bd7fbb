"""The main finding about Fig. 9: the half-period symmetry, and what follows from it, in numbers."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from vibrocap.paper.averages import STEADY_WINDOW, averages, meetings, zeros
from vibrocap.paper.presets import SHORT, figures_5_to_8, figures_9_to_11
from vibrocap.paper.runs import Runs, last_period
from vibrocap.paper.steady_points import PRINTED, RANGE_OF_SOFT, SteadyPoints, steady_points
from vibrocap.physics.system import System

SHOWN_RATIOS = (0.1, 0.8, 2.0, 4.0, 8.1)


@dataclasses.dataclass(frozen=True)
class Asymmetry:
    """How far a settled motion is from its mirror image, and what it travels per period; the same for its twin."""

    case: str
    largest_difference: float  # |X'(tau) + X'(tau + T/2)|
    drift: float
    drift_of_twin: float


@dataclasses.dataclass(frozen=True)
class MainFinding:
    """Numbers of the main finding.

    asymmetries: for both parameter sets and both laws   steady: largest |steady velocity| over lambda, by law
    points: the printed points against their place by averaging window   stiff: the same in the steady state, as printed
    soft: the same for softer springs, with errors
    from_random_starts: largest |steady velocity| from so many `starts`
    """

    asymmetries: tuple[Asymmetry, ...]
    steady: Mapping[str, float]
    points: Mapping[str, Mapping[str, float]]
    stiff: SteadyPoints
    soft: tuple[SteadyPoints, ...]
    from_random_starts: float
    starts: int


def asymmetry(runs: Runs, case: str, system: System) -> Asymmetry:
    """How far the settled motion of a system is from its mirror image."""
    period = last_period(runs.motion(system, 200), samples=4096)
    twin = last_period(runs.motion(system, 200, twin=True), samples=2)
    velocity = period["velocity"][:-1]
    difference = velocity + np.roll(velocity, velocity.size // 2)
    return Asymmetry(case, float(np.max(np.abs(difference))), period.drift, twin.drift)


def main_finding(runs: Runs) -> MainFinding:
    """All numbers of the main finding."""
    asymmetries = [
        asymmetry(runs, f"Figs 9-11, lambda = {ratio:g}, {short}", figures_9_to_11(name, ratio))
        for ratio in SHOWN_RATIOS
        for name, short in SHORT.items()
    ]
    asymmetries += [asymmetry(runs, f"Figs 5-8, {short}", figures_5_to_8(name)) for name, short in SHORT.items()]
    lm, em, met = zeros(runs, "lugre"), zeros(runs, "exponential"), meetings(runs)
    points = {"printed": PRINTED} | {
        window: {"O1": lm[window], "O2": em[window], "P1": met[window][0], "P2": met[window][1]} for window in lm
    }
    random = [abs(velocity) for name in SHORT for velocity in runs.random_starts(name)]
    return MainFinding(
        tuple(asymmetries),
        {short: float(np.max(np.abs(averages(runs, name)[STEADY_WINDOW]))) for name, short in SHORT.items()},
        points,
        steady_points(runs, 4.0),
        tuple(steady_points(runs, stiffness) for stiffness in RANGE_OF_SOFT),
        max(random),
        len(random),
    )
