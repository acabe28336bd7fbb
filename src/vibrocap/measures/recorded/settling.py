"""Whether a motion has settled: convergence of its stroboscopic state, modulo the cyclic coordinate and turns."""

import dataclasses

import numpy as np

from vibrocap.arguments import ArgumentError
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
