"""The summary of a motion: where it ends, how far it travels, its events, energy and certificate."""

import collections
import dataclasses
from typing import Annotated

from vibrocap.measures.recorded.energy import EnergyBalance, energy_balance
from vibrocap.measures.recorded.settling import usual_threshold
from vibrocap.measures.recorded.sticking import stick_fraction
from vibrocap.measures.recorded.travel import MeanVelocity, drift, mean_velocity, winding
from vibrocap.measures.recorded.windows import usual_window, whole_periods
from vibrocap.motion.certificate import Certificate
from vibrocap.motion.status import Status
from vibrocap.motion.trajectory import Trajectory
from vibrocap.motion.trust import residue
from vibrocap.physics import events
from vibrocap.physics.names import numbered
from vibrocap.quantities.declared import Force, In, Length, Number, States, Time
from vibrocap.quantities.dimensional import Dimensional

WorkPerDistance = Annotated[float, In("J/m")]


@dataclasses.dataclass(frozen=True)
class MotionSummary(Dimensional):
    """The measures of a motion; None where there is none: no whole period yet, no travel, no sticking.

    state, time: at the end; drift: of the last whole period; cost_of_transport: work of the drive per distance, in the
    window of the mean velocity; winding: turns in the last whole period of each coordinate that turns; events: how
    many of each kind; sticking: share of the run in which each contact sticks, by the name of the measure
    """

    state: States
    time: Time
    drift: Length | None
    mean_velocity: MeanVelocity | None
    cost_of_transport: WorkPerDistance | None
    winding: dict[str, Number] | None
    events: dict[str, int]
    sticking: dict[str, Number | None]
    least_reaction: Force | None
    energy: EnergyBalance | None
    certificate: Certificate | None
    status: Status


def motion_summary(motion: Trajectory) -> MotionSummary:
    whole, started = max(0, whole_periods(motion)), len(motion.piece_start) > 0
    velocity = mean_velocity(motion) if whole and motion.system.cyclic is not None else None
    counts, contacts = collections.Counter(motion.event_kinds), range(2, 1 + len(motion.system.laws))
    own = [kind for kind in dict.fromkeys(motion.system.placed.switch_events) if kind not in events.MEANINGS]
    further = (numbered(kind, i) for i in contacts for kind in events.CONTACT)
    certificate = motion.certificate if started else None
    return MotionSummary(
        state=motion.state,
        time=motion.end,
        drift=None if velocity is None else drift(motion),
        mean_velocity=velocity,
        cost_of_transport=None if velocity is None else _cost_of_transport(motion, velocity, whole),
        winding=winding(motion) if whole and motion.system.turns else None,
        events={kind: counts[kind] for kind in (*events.MEANINGS, *own, *further)},
        sticking={
            numbered("stick_fraction", i): stick_fraction(motion, contact=i) if started else None
            for i in range(1, 1 + len(motion.system.laws))
        },
        least_reaction=certificate.least_reaction if certificate else None,
        energy=energy_balance(motion) if started else None,
        certificate=certificate,
        status=motion.status,
    )


def _cost_of_transport(motion: Trajectory, velocity: MeanVelocity, whole: int) -> float | None:
    """Work of the drive per distance travelled; None for what does not travel."""
    threshold = usual_threshold(motion.tolerance) if velocity.settled else 0.0
    if abs(velocity.value) <= residue(motion.system, "mean_velocity", threshold):
        return None
    balance = energy_balance(motion, periods=usual_window(whole))
    start, end = balance.window
    return (balance.drive + balance.controller) / abs(velocity.value * (end - start))
