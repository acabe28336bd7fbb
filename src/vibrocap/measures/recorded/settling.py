"""Whether a motion has settled, by its stroboscopic states modulo travel and turns, and what it has become."""

import dataclasses

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.measures.recorded.windows import whole_periods
from vibrocap.motion.recording.equations import equations
from vibrocap.motion.recording.section import section_states
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.api import LONGEST_PERIOD, Stroboscope
from vibrocap.quantities.declared import Number
from vibrocap.quantities.dimensional import Dimensional

# A motion is settled where it will change by no more than this share of the natural size of any state; no tolerance of
# a run can promise more than a thousand times itself, since errors of some hundred steps add up in a period.
THRESHOLD = 1e-6
TOLERANCES = 1e3


@dataclasses.dataclass(frozen=True)
class Settling(Dimensional):
    """Whether, since when and to what a motion has settled.

    settled: whether `remaining` is at most `threshold`
    since: index of the first period mark from which on the motion stays within `threshold` of where it goes
    period: periods of the drive after which the steady motion repeats; None where it has not settled
    residual: last difference of the stroboscopic state to that `period` periods earlier (where not settled, to one
        period earlier); None where the run is too short to tell (fewer than 10 periods)
    ratio: contraction of such differences per `period`; 0 where they are errors of the integration, None where they do
        not shrink
    remaining: bound of the distance still to go, the least over all periods tested; None where no differences shrink
    threshold: what `remaining` was compared with
    Distances are shares of the natural size of each state (those the integrator uses), the largest over all states.
    """

    settled: bool
    since: int | None
    period: int | None
    residual: Number | None
    ratio: Number | None
    remaining: Number | None
    threshold: Number


def usual_threshold(tolerance: float) -> float:
    """The threshold of settling of runs at a tolerance, where none is given."""
    return max(THRESHOLD, TOLERANCES * tolerance)


def settling(motion: Trajectory, *, threshold: float | None = None) -> Settling:
    """Decide whether a motion has settled, by the distance that it still has to go.

    A transient that keeps the share r of its distance in each period has step/(1/r - 1) still before it, a hundred
    steps for r = 0.99. So, for each period n from 1 to 16, with the differences d_k = |s_k - s_{k-n}| of stroboscopic
    states (without the cyclic coordinate, modulo whole turns),

        remaining = d r/(1 - r)

    where r, the contraction over n periods, is the slowest seen: between the last three blocks of max(n, 3)
    differences, and within the last block; and d is the last difference or, if larger, an earlier one of the last block
    continued at that rate. (For a transient that alternates, n = 2 gives the sharper bound.) Where the states of these
    blocks lie within 10 tolerances of one another the motion stands still; remaining is the largest difference.

    A slow mode hides below faster ones, most of all one near -1, whose states two periods apart hardly differ. So
    remaining is also at least the distance to the limit of five marks by reduced-rank extrapolation, n periods apart
    (of a motion that stands still up to 16), and ten times what its multipliers leave unexplained of the last step.

    The smallest n with remaining <= threshold is the period of the response. Where nothing drives a system in time,
    rest and steady sliding are settled, a cycle is not (`orbit` closes it).

    Limit: a mode that moves by less than a tenth of the threshold in n periods hides below faster ones. Within some
    1e-6 (relative) of a period doubling, one or two of a hundred settled runs still moved by 20 to 240 thresholds.

    threshold: share of the natural size of each state, by default max(1e-6, 1000 tolerance)
    A motion whose period n is tested needs n + 3 max(n, 3) periods: 10 for n = 1, 64 for n = 16.
    """
    if threshold is None:
        threshold = usual_threshold(motion.tolerance)
    if not threshold > 0.0:
        raise ArgumentError("threshold", f"should be > 0, got {threshold!r}")
    marks = Stroboscope(stroboscopic_states(motion))
    fallback = Settling(False, None, None, None, None, None, threshold)
    for n in range(1, 1 + (LONGEST_PERIOD if equations(motion.system).timed else 1)):
        if marks.last < n + 3 * max(n, 3):
            break
        ratio, remaining = marks.distance_to_go(n, motion.tolerance)
        if remaining is not None and remaining <= threshold:
            shortest = marks.shortest_period(n, ratio or 0.0, threshold)
            since = marks.settled_since(shortest, threshold - remaining)
            return Settling(True, since, shortest, marks.difference(shortest), ratio, remaining, threshold)
        if n == 1:
            fallback = Settling(False, None, None, marks.difference(1), ratio, remaining, threshold)
        elif remaining is not None and (fallback.remaining is None or remaining < fallback.remaining):
            fallback = dataclasses.replace(fallback, remaining=remaining)
    return fallback


def stroboscopic_states(motion: Trajectory) -> np.ndarray:
    """States at the period marks over their natural sizes, see `section_states`: [marks, kept]."""
    return section_states(motion.system, motion.sections, np.array(motion.system.scales(), dtype=float))


# A motion that has not settled is still converging where its best recurrence over the last quarter is below this share
# of the extent of the stroboscopic states, and by this factor smaller than over the quarter before.
NEAR_RECURRENCE = 0.1
STILL_FALLING = 0.9
MIRROR_SHARE = 10.0  # thresholds of settling within which a mirrored state is the same
ENOUGH_PERIODS = 4 * LONGEST_PERIOD  # fewer cannot tell a slow transient from a motion that settles to nothing


@dataclasses.dataclass(frozen=True)
class ResponseClass(Dimensional):
    """What a motion has become.

    kind: "period-1", "period-2", ...: settled, repeating after so many drive periods up to a shift of the cyclic
              coordinate and whole turns (what the paper calls quasi-periodic is this, erratum 6);
          "not settled": still converging, or too short to tell;
          "other": in at least 64 periods it neither repeated nor came nearer to repeating (aperiodic, of a period above
              16, or running away)
    period: that number; None unless settled
    residual: of the stroboscopic map, see `Settling.residual`
    symmetric: whether the settled motion is its own mirror image half a period later, so that its drift is exactly
        zero; None where it has not settled, or the drive is not odd and there is no such symmetry
    """

    kind: str
    period: int | None
    residual: Number | None
    symmetric: bool | None


def response_class(motion: Trajectory, *, threshold: float | None = None) -> ResponseClass:
    """Class of the response, from the stroboscopic map modulo the cyclic coordinate.

    The half-period symmetry S maps a steady motion to a steady motion: to itself (symmetric) or to a mirror-image
    solution. It is its own image if, at any one instant t, some later state y(t + T/2 + mT) is the mirrored y(t): the
    rest of both motions follows from that state. Compared at the settled end of the motion, to ten times
    `Settling.threshold`: either side may be that far away at a period mark, and some times as far half a period later.
    """
    verdict = settling(motion, threshold=threshold)
    if verdict.settled and verdict.period is not None:
        symmetric = None
        if motion.system.mirrored:
            symmetric = _asymmetry(motion, verdict.period) <= MIRROR_SHARE * verdict.threshold
        return ResponseClass(f"period-{verdict.period}", verdict.period, verdict.residual, symmetric)
    kind = "other" if _settles_to_nothing(motion) else "not settled"
    return ResponseClass(kind, None, verdict.residual, None)


def _asymmetry(motion: Trajectory, n: int) -> float:
    """Distance, over natural sizes, of the mirrored state from the nearest one an odd number of half periods later."""
    system = motion.system
    scales = np.array(system.scales(), dtype=float)
    start = whole_periods(motion) - n
    later = motion.start_time + (start + 0.5 + np.arange(n)) * motion.period
    mirrored = np.asarray(system.symmetry, dtype=float) * motion.sections[start]
    away = section_states(system, motion.states(later).T, scales) - section_states(system, mirrored, scales)
    return float(np.min(np.max(np.abs(away), axis=1)))


def _settles_to_nothing(motion: Trajectory) -> bool:
    """Whether a long enough motion shows no sign of coming to repeat itself."""
    states = stroboscopic_states(motion)
    if len(states) - 1 < ENOUGH_PERIODS:
        return False
    quarter = (len(states) - 1) // 4
    best = []
    for end in (len(states) - quarter, len(states)):
        latest = states[end - quarter : end]
        lags = (states[end - quarter - n : end - n] for n in range(1, LONGEST_PERIOD + 1))
        best.append(min(float(np.max(np.abs(latest - earlier))) for earlier in lags))
    extent = float(np.max(np.ptp(states[-2 * quarter :], axis=0)))
    return not (best[1] < NEAR_RECURRENCE * extent or best[1] < STILL_FALLING * best[0])
