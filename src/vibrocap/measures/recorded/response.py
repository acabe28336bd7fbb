"""The class of a response: after how many drive periods it repeats, and whether it is its own mirror image."""

import dataclasses

import numpy as np

from vibrocap.measures.recorded.settling import LONGEST_PERIOD, settling, stroboscopic_states
from vibrocap.measures.recorded.windows import whole_periods
from vibrocap.motion.recording.section import section_states
from vibrocap.motion.trajectory import Trajectory
from vibrocap.quantities.declared import Number
from vibrocap.quantities.dimensional import Dimensional

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
        symmetric = (
            _asymmetry(motion, verdict.period) <= MIRROR_SHARE * verdict.threshold if motion.system.mirrored else None
        )
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
