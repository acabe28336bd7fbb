"""Average velocities over the mass ratio, by averaging window, and where their curves vanish and meet."""

import math

import numpy as np

from vibrocap.paper.presets import figures_9_to_11
from vibrocap.paper.runs import LAST, WINDOWS, Runs

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
