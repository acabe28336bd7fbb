"""A stretch of a motion as points of its pieces, from which its pictures are drawn."""

import numpy as np

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.motion.trajectory import Trajectory
from vibrocap.plotting.look.labels import scale

MOST_POINTS = 200_000
MOST_PER_PIECE = 24


class Trace:
    """A stretch of a motion as points of its pieces, each with both its ends: jumps stand upright, peaks are round.

    time: [points]; a border of two pieces is there twice, as what each of them says
    """

    def __init__(self, motion: Trajectory, start: float, end: float):
        self.motion = motion
        begin, length = motion.piece_start, motion.piece_length
        pieces = np.flatnonzero((begin < end) & (begin + length > start))
        low = np.maximum(begin[pieces], start) - begin[pieces]
        high = np.minimum(begin[pieces] + length[pieces], end) - begin[pieces]
        most = max(2, min(MOST_PER_PIECE, MOST_POINTS // max(len(pieces), 1)))
        share = np.linspace(0.0, 1.0, most)
        self.index = np.repeat(pieces, most)
        self.since = (low[:, None] + (high - low)[:, None] * share).ravel()
        self.time = begin[self.index] + self.since

    def __getitem__(self, name: str) -> np.ndarray:
        """A quantity at these points, in SI where the system knows its scales; an angle that turns without end within
        half a turn of zero, cut where it begins again."""
        motion, values = self.motion, self._plain(name)
        if turn := motion.system.machine.turns.get(name):
            values = (values + turn / 2) % turn - turn / 2
            values[1:][np.abs(np.diff(values)) > turn / 2] = np.nan
        return values * (1.0 if name.startswith("side") else scale(name, motion.system))

    def _plain(self, name: str) -> np.ndarray:
        motion = self.motion
        if name in motion.state_names:
            return motion.piece_states(self.index, self.since)[motion.state_names.index(name)]
        if name in motion.observable_names:
            return motion.piece_observables((name,), self.index, self.since)[0]
        if name not in motion.names:
            raise ArgumentError("name", f"a motion has no {name!r}; {suggestion(name, motion.names)}")
        if name in motion.side_names:
            return motion.side_of(name)[self.index]
        integral = motion.integral_names.index(name)
        return (motion.piece_marks[:, self.index] + motion.piece_integrals(self.index, self.since))[integral]
