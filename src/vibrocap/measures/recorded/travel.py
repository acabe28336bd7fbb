"""Travel: how far and how fast the machine gets. Only a window makes such a number mean something (erratum 8)."""

import dataclasses

from vibrocap.measures.recorded.settling import settling
from vibrocap.measures.recorded.windows import period_index, usual_window, whole_periods, window_times
from vibrocap.motion.trajectory import Trajectory
from vibrocap.physics.system import System
from vibrocap.quantities.declared import Length, Number, Speed, Time
from vibrocap.quantities.dimensional import Dimensional


@dataclasses.dataclass(frozen=True)
class MeanVelocity(Dimensional):
    """Mean velocity over a window, and whether the motion had settled when the window began."""

    value: Speed
    window: tuple[Time, Time]
    settled: bool


def displacement(motion: Trajectory, window: tuple[Time, Time] | None = None, *, periods: int | None = None) -> Length:
    """Change of the machine's cyclic coordinate (the travel X) over a window (`windows.window_times`)."""
    start, end = window_times(motion, window, periods)
    before, after = motion.states([start, end])[_cyclic(motion)]
    return float(after - before)


def drift(motion: Trajectory, period: int = -1) -> Length:
    """What the cyclic coordinate gains in one whole period, the last unless named.

    Steady motions are periodic only up to this shift: they are relative periodic orbits, since nothing depends on X.
    ValueError where the motion has no such period.
    """
    index = period_index(motion, period)
    column = _cyclic(motion)
    return float(motion.sections[index + 1, column] - motion.sections[index, column])


def winding(motion: Trajectory, period: int = -1) -> dict[str, Number]:
    """Turns in one whole period, the last unless named, of each coordinate of the machine that turns, by name.

    A steady motion turns by a whole number over its response, its winding number. ValueError as of `drift`.
    """
    index = period_index(motion, period)
    gained = motion.sections[index + 1] - motion.sections[index]
    turns = motion.system.turns.items()
    return {name: float(gained[motion.state_names.index(name)] / turn) for name, turn in turns}


def mean_velocity(motion: Trajectory, periods: int | None = None, *, threshold: float | None = None) -> MeanVelocity:
    """Mean velocity over the last `periods` whole periods: by default the last ten, or all where there are fewer.

    Over whole periods the swing within a period cancels, and travel remains. `settled` says whether the motion was
    settled (`settling.settling`, with that threshold) from the start of the window on: if it was not, part of the value
    belongs to the transient. For a response of period n take a multiple of n periods.

    Raises ValueError for more periods than the motion has.
    """
    done, column = whole_periods(motion), _cyclic(motion)
    periods = usual_window(done) if periods is None else periods
    window = window_times(motion, periods=periods)
    gained = motion.sections[done, column] - motion.sections[done - periods, column]
    verdict = settling(motion, threshold=threshold)
    settled = verdict.settled and verdict.since is not None and verdict.since <= done - periods
    return MeanVelocity(float(gained / (window[1] - window[0])), window, settled)


def _cyclic(motion: Trajectory) -> int:
    return motion.state_names.index(travelling(motion.system))


def travelling(system: System) -> str:
    """The cyclic coordinate of a system; ValueError for one that does not travel."""
    if system.cyclic is None:
        instead = f"measure its states instead, such as largest_{system.machine.place}"
        raise ValueError(f"the {system.machine.name} does not travel: it has no drift or mean velocity; {instead}")
    return system.cyclic
