"""Travel over the mass ratio (Fig. 9): averages by window, the points of their curves, and the steady state.

O1 and O2 are where the curves of LM and EM vanish, P1 and P2 where they meet. In the steady state a symmetry decides:
the main finding. What came after the paper is where settled motions travel, over mass ratio and spring, and where
travel is born: a map under the printed load and that of the motion, and a diagram of branches of one capsule over its
spring, unstable motions included, both of EM, on which compiling takes less time than on LM.
"""

import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from vibrocap.measures.ensemble import ensemble
from vibrocap.motion.status import Status
from vibrocap.motion.trust import Trust, residue
from vibrocap.orbits.continuation.branch_diagram import BranchDiagram, branches
from vibrocap.orbits.continuation.crossing import Crossings
from vibrocap.orbits.continuation.crossing_bracket import Crossing, CrossingKind
from vibrocap.paper.presets import MASS_RATIOS, SHORT, figures_5_to_8, figures_9_to_11, start, with_load
from vibrocap.paper.runs import LAST, WINDOWS, Runs, last_period
from vibrocap.physics.system import System

STEADY_WINDOW = f"last {LAST} periods"
PERIOD = figures_9_to_11().drive.period


def window_name(periods: int) -> str:
    """An averaging window from the start, in words."""
    return "first period" if periods == 1 else f"first {periods} periods"


def in_words(windows: list[str]) -> str:
    """Several averaging windows in words: "averages over the first 5, 10, 20 periods"; nothing for none."""
    counts = [str(n) for n in WINDOWS if n > 1 and window_name(n) in windows]
    parts = ["first period"] if window_name(1) in windows else []
    parts += [f"first {', '.join(counts)} periods"] if counts else []
    parts += [STEADY_WINDOW] if STEADY_WINDOW in windows else []
    return f"averages over the {' or the '.join(parts)}" if parts else ""


def averages(runs: Runs, friction: str) -> dict[str, np.ndarray]:
    """Mean velocity over the mass ratio, for each window from the start and for the last periods."""
    sweep, period = runs.sweep(friction), PERIOD
    curves = {window_name(n): sweep.mean_velocity(period, n) for n in WINDOWS}
    return curves | {STEADY_WINDOW: sweep.mean_velocity(period, LAST, last=True)}


def crossings(x: np.ndarray, y: np.ndarray, rising: bool | None = None, noise: float = 1e-9) -> list[float]:
    """Where a curve changes sign, by linear interpolation; values below the noise count as zero, which is no sign.

    rising: only where it does so from below (True) or from above (False)
    """
    kept = np.abs(y) > noise
    x, y = x[kept], y[kept]
    changes = y[1:] * y[:-1] < 0.0
    if rising is not None:
        changes &= (y[1:] > 0.0) == rising
    return [float(x[i] - y[i] * (x[i + 1] - x[i]) / (y[i + 1] - y[i])) for i in np.flatnonzero(changes)]


def zeros(runs: Runs, friction: str) -> dict[str, float]:
    """First zero of the mean velocity over the mass ratio, by window (NaN: none)."""
    ratios = runs.sweep(friction).mass_ratio
    curves = averages(runs, friction)
    return {window: next(iter(crossings(ratios, curve)), math.nan) for window, curve in curves.items()}


def meeting_points(ratios: np.ndarray, lm: np.ndarray, em: np.ndarray) -> tuple[float, float]:
    """P1, where EM falls below LM, and P2, where it rises above LM again (NaN: none).

    Without a P1, P2 is the first place where EM rises above LM.
    """
    falls = next(iter(crossings(ratios, em - lm, rising=False)), math.nan)
    later = [x for x in crossings(ratios, em - lm, rising=True) if not x <= falls]
    return falls, next(iter(later), math.nan)


def meetings(runs: Runs) -> dict[str, tuple[float, float]]:
    """P1 and P2 of the curves of the two laws, by window."""
    lm, em = averages(runs, "lugre"), averages(runs, "exponential")
    return {window: meeting_points(runs.sweep("lugre").mass_ratio, lm[window], em[window]) for window in lm}


PRINTED = {"O1": 4.0, "O2": 2.2, "P1": 1.18, "P2": 4.36}
BOTH = "both"  # the difference of the two laws, as a key beside their names
SOFT = 0.58  # a spring with which all four exist, in the printed order
RANGE_OF_SOFT = (0.5, 0.55, 0.58, 0.62, 0.65)


@dataclasses.dataclass(frozen=True)
class SteadyPoints:
    """The four points at one stiffness, with their errors: NaN where there is none.

    equal: for each law and for their difference the ranges of the mass ratio over which the drift is nothing
    """

    stiffness: float
    at: Mapping[str, float]
    error: Mapping[str, float]
    equal: Mapping[str, tuple[tuple[float, float], ...]]


def crossings_of(runs: Runs, stiffness: float) -> dict[str, Crossings]:
    """Zeros of the steady drift over the mass ratio, for each law, and where both laws drift alike."""
    crossings = {name: runs.crossings(name, stiffness) for name in SHORT}
    return crossings | {BOTH: runs.crossings("lugre", stiffness, "exponential")}


def steady_points(runs: Runs, stiffness: float) -> SteadyPoints:
    """O1, O2, P1, P2 of the steady drift at a stiffness.

    As in the paper, of the mirror-image solutions the one that a light capsule follows forward: O1 and O2 are the first
    zeros of LM and of EM, P1 is where EM first falls below LM, P2 where it rises above it again.
    """
    located = crossings_of(runs, stiffness)
    drift = float(located["lugre"].differences[0])
    forward = math.copysign(1.0, drift) if abs(drift) > 0.0 else 1.0
    zeros = [_first(located[name]) for name in SHORT]
    falls = _first(located[BOTH], forward)  # LM less EM rises
    rises = _first(located[BOTH], -forward, after=falls.at if falls else -math.inf)
    points = dict(zip(PRINTED, (*zeros, falls, rises), strict=True))
    return SteadyPoints(
        stiffness,
        {name: math.nan if place is None else place.at for name, place in points.items()},
        {name: math.nan if place is None else place.error for name, place in points.items()},
        {key: value.equal for key, value in located.items()},
    )


def _first(crossings: Crossings, direction: float = 0.0, after: float = -math.inf) -> Crossing | None:
    """The first crossing beyond a place, upwards (way > 0), downwards (< 0) or either way; None where there is none."""
    for place in crossings.found:
        if place.kind is CrossingKind.CROSSING and place.at > after and place.slope * direction >= 0.0:
            return place
    return None


def printed_range_in_numbers(runs: Runs, key: str, stiffness: float = 4.0) -> dict[str, float]:
    """What the search for a point at the printed parameters has seen: all numbers behind "there is none"."""
    numbers = crossings_of(runs, stiffness)[key]
    nothing = numbers.equal[0] if len(numbers.equal) == 1 else (math.nan, math.nan)
    what = "drift of LM less EM" if key == BOTH else "drift"
    return {
        f"steady: points where the {what} changes sign": float(len(numbers.places)),
        f"steady: largest |{what}|": float(abs(numbers.differences).max()),
        "steady: it is nothing from lambda": nothing[0],
        "steady: it is nothing to lambda": nothing[1],
        "steady: mass ratios not settled": float(len(numbers.unsettled)),
    }


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


STIFFNESSES = (0.01, 4.5)
POINTS = 40  # along each axis of the map
PERIODS, SETTLE, TOLERANCE = 600, 1e-6, 5e-8
FOLLOWED = (1.45, 4.0)  # stiffness of the diagram of branches
FRICTION = "exponential"
LOADS: tuple[float | str, ...] = (1.0, "dynamic")


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyPanel:
    """Settled motions of one law under one load. Arrays [mass ratio, stiffness]."""

    friction: str
    load: float | str
    residue: float  # mean velocities up to this are no travel
    mean_velocity: np.ndarray
    status: np.ndarray  # index into list(Status)
    settled: np.ndarray
    least_load: np.ndarray  # of the true load; negative: a constant load hides a lift-off

    @property
    def finished(self) -> np.ndarray:
        """Runs that went to their end."""
        return self.status == list(Status).index(Status.FINISHED)

    @property
    def travelling(self) -> float:
        """Share of all runs that have settled and travel."""
        direction = Trust(self.status, self.settled, self.residue).direction(self.mean_velocity)
        return float(np.mean(np.abs(np.nan_to_num(direction))))

    @property
    def ended(self) -> dict[str, int]:
        """How many runs did not go to their end, by status."""
        statuses = list(Status)
        codes, counts = np.unique(self.status[~self.finished], return_counts=True)
        return {statuses[int(code)].value: int(count) for code, count in zip(codes, counts, strict=True)}

    @property
    def hidden(self) -> int:
        """Runs to whose end a constant load hid that the true one was negative."""
        return int(np.sum(self.finished & (self.least_load < 0.0)))


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyTravel:
    """The map, a panel for each load, and the diagram of branches."""

    mass_ratio: np.ndarray
    stiffness: np.ndarray
    panels: tuple[SteadyPanel, ...]
    branches: BranchDiagram


def steady_panel(friction: str, load: float | str, mass_ratio: np.ndarray, stiffness: np.ndarray) -> SteadyPanel:
    """Settled motions from the paper's start, over a grid of mass ratios and stiffnesses."""
    system = with_load(figures_9_to_11(friction), load)
    ratios, springs = np.meshgrid(mass_ratio, stiffness, indexing="ij")
    measured = ensemble(
        system,
        {"machine.mass_ratio": ratios.ravel(), "machine.stiffness": springs.ravel()},
        measures=("mean_velocity", "least_reaction"),
        initial=start(system),
        periods=PERIODS,
        settle=SETTLE,
        tolerance=TOLERANCE,
    )
    names = ("mean_velocity", "status", "settled", "least_reaction")
    columns = (measured[name].reshape(ratios.shape) for name in names)
    return SteadyPanel(SHORT[friction], load, residue(system, "mean_velocity", SETTLE), *columns)


def steady_travel() -> SteadyTravel:
    """The map and the diagram."""
    mass_ratio, stiffness = np.linspace(*MASS_RATIOS, POINTS), np.linspace(*STIFFNESSES, POINTS)
    panels = tuple(steady_panel(FRICTION, load, mass_ratio, stiffness) for load in LOADS)
    followed = figures_5_to_8(FRICTION)
    diagram = branches(followed, "machine.stiffness", FOLLOWED, initial=start(followed))
    return SteadyTravel(mass_ratio, stiffness, panels, diagram)
