"""Regimes of a pulled slider: what motion a force record shows, and what decides."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from vibrocap.quantities.declared import Seconds
from vibrocap.records.slips.periods import Recurrence
from vibrocap.records.slips.phases import Phase

STICK_SLIP, INERTIAL, STEADY, SLOW = "stick-slip", "inertial", "steady", "slow oscillation"
# A block on static and kinetic Coulomb friction has P/T0 = 1 + (x - atan x)/pi, x = w D/V, and sticks for the share
# x/(x + pi - atan x) of its period P: half of it where x = pi - atan x. Between its extremes its force rises for the
# share 1 - T0/(2 P), there 0.61.
HALF_STICK_X, HALF_STICK_RATIO = 2.0288, 1.29
STICKS, RISES = 0.4, 0.6  # shares of the time, less than half to allow for noise; a sine rises for half of it
STRAIGHT = 0.08  # bend of stick phases over the fall; measured: 0.03 at most where it sticks, 0.13 in coloured noise
MISSED = 1.3  # times the period of the spectrum, from which on the falls that stand above the noise are not all
BARELY = 2.0  # times the least significant fall: falls that are no larger on average may be missed
AGREE = 0.2  # relative difference of two periods that are the same
REGULAR = 0.3  # standard deviation of the intervals between tops over their mean, where there is a period


@dataclasses.dataclass(frozen=True)
class Regime:
    """What kind of motion a force record shows, and what decided it.

    name: "stick-slip": straight stick phases for at least 0.4 of the time, and a period of at least 1.29 inertial
        periods, above which a Coulomb block sticks for more than half of the time;
        "inertial": a regular oscillation whose period is near or below the inertial one, or whose force is about as
        long rising as falling where that period is not known;
        "steady": no fluctuation above the noise, or one without a period;
        "slow oscillation": a regular one, slower than inertia explains and without stick phases, driven from elsewhere
    reason: the same in a sentence, with the numbers
    typical_period: median time between tops [s];  irregularity: standard deviation of these times over their mean
    inertial_period: 2 pi sqrt(m/k) [s];  period_ratio: typical_period over it; None where mass or stiffness is unknown
    stick_fraction: share of the time in stick phases;  rise_fraction: share in which the force rises
    stick_bend: how far from straight the force is in stick phases, over the mean fall
    from_spectrum: typical_period is that of the spectrum, since only some falls stand above the noise
    """

    name: str
    reason: str
    typical_period: Seconds | None
    irregularity: float | None
    inertial_period: Seconds | None
    period_ratio: float | None
    stick_fraction: float | None
    rise_fraction: float | None
    stick_bend: float | None
    from_spectrum: bool = False


def regime(
    phases: Sequence[Phase],
    tops: np.ndarray,
    bottoms: np.ndarray,
    recurrence: Recurrence,
    inertial_period: float | None,
    bend: float | None,
    clearness: float = float("inf"),
) -> Regime:
    """What kind of motion phases and turning points [s] show; see `Regime` for what decides.

    clearness: mean fall over the least that is significant. Where falls barely are, or the correlation repeats as the
    spectrum does, and their intervals are far longer than the period of the spectrum, most falls were missed: then the
    spectrum tells the period.
    """
    if len(tops) < 3:
        few = "no fall of the force stands" if not len(tops) else f"only {len(tops)} falls of the force stand"
        return Regime(STEADY, f"{few} above the noise", None, None, inertial_period, None, None, None, None)
    intervals = np.diff(tops)
    period = float(np.median(intervals))
    irregularity = float(intervals.std() / intervals.mean())
    rises = float((tops[1:] - bottoms[:-1]).sum() / (bottoms[-1] - bottoms[0]))
    resting = sum(phase.duration for phase in phases if phase.kind == "stick")
    sticks = resting / (phases[-1].end - phases[0].start)
    mean = float(intervals.mean())
    if recurrence.spectral_period is not None and falls_missed(mean, recurrence, clearness):
        period = recurrence.spectral_period
        ratio = None if inertial_period is None else period / inertial_period
        near = ratio is None or ratio < HALF_STICK_RATIO
        name, how = (INERTIAL, "swings on its spring") if near else (SLOW, "oscillates more slowly than by its inertia")
        missed = f"the spectrum has a period of {period:.4g} s, and falls stand above the noise every {mean:.4g} s only"
        compared = "" if ratio is None else f"; it is {ratio:.3g} times 2 pi sqrt(m/k) = {inertial_period:.4g} s"
        reason = f"{how}: {missed}{compared}"
        return Regime(name, reason, period, irregularity, inertial_period, ratio, None, rises, bend, True)
    ratio = None if inertial_period is None else period / inertial_period
    repeats = recurrence.correlation_period is not None or irregularity <= REGULAR
    far = ratio is None or ratio >= HALF_STICK_RATIO
    share = f"sticks {sticks:.0%} of the time, the force rises {rises:.0%} of it"
    compared = (
        "; mass or stiffness is not given, so the period was not compared with 2 pi sqrt(m/k)"
        if inertial_period is None
        else f"; the time between tops, {period:.4g} s, is {ratio:.3g} times 2 pi sqrt(m/k) = {inertial_period:.4g} s"
    )
    straight = bend is None or bend <= STRAIGHT
    if far and straight and sticks >= STICKS and rises >= RISES:
        name, reason = STICK_SLIP, share + compared
    elif not repeats:
        name, reason = STEADY, f"fluctuates without a period (intervals vary by {irregularity:.0%}), {share}"
    elif far and ratio is not None:
        name, reason = SLOW, f"oscillates more slowly than by its inertia, without sticking long: {share}{compared}"
    else:
        name, reason = INERTIAL, f"swings on its spring: {share}{compared}"
    return Regime(name, reason, period, irregularity, inertial_period, ratio, sticks, rises, bend)


def falls_missed(period: float, recurrence: Recurrence, clearness: float) -> bool:
    """Whether the mean period between tops is so much longer than the spectrum's that falls must have been missed."""
    spectral, repeats = recurrence.spectral_period, recurrence.correlation_period
    if spectral is None or period < MISSED * spectral:
        return False
    return clearness < BARELY or (repeats is not None and abs(repeats / spectral - 1.0) < AGREE)
