"""Grazing of a stop where a branch ends: how near the motion along an orbit is to touching its stop without speed.

At a rigid stop the image of an orbit depends on where it starts like a square root of that distance (Nordmark 1991), so
that Newton's method fails shortly before. On the side without the impact the distance itself goes straight to zero; on
the other side the speed of the impact does.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.motion.recording.equations import equations
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.expressions.graph import derivative, evaluate
from vibrocap.physics.events import IMPACT

FINE = np.linspace(0.0, 1.0, 17)  # of a piece, where a dip of the distance is looked for
BEFORE_GRAZING = 1e-5  # share of the parameter's range within which a branch that grazes ends
NEARLY = 0.03  # distance, or speed, over natural sizes up to which the motion may be about to graze


def grazing_beyond(motions: Sequence[Trajectory], at: Sequence[float], width: float) -> tuple[float, float] | None:
    """(parameter, how far off it may be) of a grazing beyond three motions of a branch, of parameters `at`; None: none.

    The distance from the stop, or the speed of the slowest impact, is followed through the last two of them to zero;
    how far the first two would lead is the error. width: of the parameter's range
    """
    for measure in (least_distance, slowest_impact):
        values = [measure(motion) for motion in motions]
        if not abs(values[2]) < min(abs(values[1]), NEARLY):
            continue
        coarser, place = (_zero(at[i : i + 2], values[i : i + 2]) for i in (0, 1))
        if abs(place - at[2]) <= BEFORE_GRAZING * width:
            return place, min(abs(place - coarser), abs(place - at[2]))
    return None


def _zero(at: Sequence[float], values: Sequence[float]) -> float:
    return at[1] + values[1] * (at[1] - at[0]) / (values[0] - values[1])


def _guards(motion: Trajectory) -> list[int]:
    """The guards that fall to zero at an impact, by their place among all."""
    recording = equations(motion.system)
    names = motion.system.placed.switch_events[: len(recording.switches) - recording.law_switches]
    return [recording.law_switches + i for i, name in enumerate(names) if name == IMPACT]


def _guard_at(motion: Trajectory, guard: int, index: np.ndarray, s: np.ndarray) -> np.ndarray:
    """A guard at times s since the start of the pieces."""
    recording = equations(motion.system)
    time, parameters = motion.drive_at(index, s)
    states = motion.piece_states(index, s)
    (value,) = evaluate([recording.switches[guard]], time, states, motion.sides(index), parameters)
    return np.broadcast_to(value, np.shape(s))


def least_distance(motion: Trajectory) -> float:
    """Least distance from a stop at which the mass turns back without touching it; infinite where it never does."""
    from scipy.optimize import minimize_scalar  # only here: it takes long to load

    pieces = np.arange(len(motion.piece_start))
    index = np.repeat(pieces, len(FINE))
    share = np.tile(FINE, len(pieces))
    least = np.inf
    for guard in _guards(motion):
        values = _guard_at(motion, guard, index, share * motion.piece_length[index]).reshape(len(pieces), -1)
        for piece in range(len(pieces)):
            place = int(np.argmin(values[piece]))
            ends = values[piece, 0], values[piece, -1]
            if 0 < place < len(FINE) - 1 and values[piece, place] < min(ends):
                low, high = FINE[place - 1], FINE[place + 1]

                def value(at: float, piece: int = piece, guard: int = guard) -> float:
                    local = np.array([at * motion.piece_length[piece]])
                    return float(_guard_at(motion, guard, np.array([piece]), local)[0])

                dip: Any = minimize_scalar(value, bounds=(low, high), method="bounded", options={"xatol": 1e-10})
                least = min(least, value(dip.x))
            elif place == 0 and piece > 0 and 0.0 < ends[0] < values[piece, 1]:
                *_, before, last = values[piece - 1]
                if last < before and abs(last - ends[0]) < 1e-9:
                    least = min(least, float(ends[0]))  # it turns at the border of two pieces
    return least


def slowest_impact(motion: Trajectory) -> float:
    """Least speed of an impact, over natural sizes; infinite where there is none."""
    recording, least = equations(motion.system), np.inf
    for time in motion.event_times[motion.event_kinds == IMPACT]:
        piece = int(np.searchsorted(motion.piece_start, time - 1e-12 * motion.period, side="right") - 1)
        if piece < 0:
            continue
        index, s = np.array([piece]), motion.piece_length[[piece]]
        local, parameters = motion.drive_at(index, s)
        states, slopes = motion.piece_states(index, s), motion.piece_slopes(index, s)
        for guard in _guards(motion):
            if abs(_guard_at(motion, guard, index, s)[0]) > 1e-9:
                continue
            slope = [derivative(recording.switches[guard], i) for i in range(len(recording.rates))]
            values = evaluate(slope, local, states, motion.sides(index), parameters)
            least = min(least, abs(float(np.sum(np.array([np.ravel(v)[0] for v in values]) * slopes[:, 0]))))
    return least
