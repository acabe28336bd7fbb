"""A stretch of a motion on one side of a contact, on which friction is smooth: its values, roots and integrals."""

import dataclasses
import functools
from collections.abc import Callable

import numpy as np

from vibrocap.motion.recording.equations import equations
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.expressions.graph import derivative, evaluate
from vibrocap.physics.names import numbered

GAUSS_POINTS = 16  # per piece; a piece is one step of a Taylor series, which 16 points integrate to rounding
SCAN = 16  # intervals per piece in which sign changes are looked for
HALVINGS = 64  # of an interval at most: to rounding
DIFFERENCE = 2e-3  # of a piece: step of the difference quotient; (2e-3)^4 and 1e-16/2e-3 are both small


@dataclasses.dataclass(frozen=True)
class Nodes:
    """Quadrature points of a stretch: an integral over time is the sum of weight times integrand. All are [points]."""

    time: np.ndarray
    weight: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    friction: np.ndarray


@dataclasses.dataclass(frozen=True)
class Stretch:
    """A motion between two times of one phase of a contact. At an end the values are those within, not those beyond a
    jump.
    """

    motion: Trajectory
    contact: int  # 1 for the first
    start: float
    end: float
    side: int

    @functools.cached_property
    def pieces(self) -> np.ndarray:
        """Indices of the pieces that it covers, at least in part."""
        motion = self.motion
        inside = (motion.piece_start < self.end) & (motion.piece_start + motion.piece_length > self.start)
        return np.flatnonzero(inside & (motion.piece_sides[:, self.contact - 1] == self.side))

    @property
    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        start = self.motion.piece_start[self.pieces]
        length = self.motion.piece_length[self.pieces]
        return np.maximum(start, self.start), np.minimum(start + length, self.end)

    def velocity(self, t: np.ndarray) -> np.ndarray:
        return self._observed("contact_velocity", t, self._piece_at(t))

    def acceleration(self, t: np.ndarray) -> np.ndarray:
        """Its rate along the polynomials of the states."""
        piece, velocity = self._piece_at(t), equations(self.motion.system).contacts[self.contact - 1].velocity
        local, parameters = self.motion.drive_at(piece, t - self.motion.piece_start[piece])
        rates = (*self.motion.piece_slopes(piece, t - self.motion.piece_start[piece]), np.ones(len(t)))
        slopes = [derivative(velocity, i) for i in (*range(len(rates) - 1), -1)]
        slopes = evaluate(slopes, local, self._states(t, piece), 1.0, parameters)
        return np.sum([slope * rate for slope, rate in zip(slopes, rates, strict=True)], axis=0)

    def friction(self, t: np.ndarray) -> np.ndarray:
        return self._observed("friction", t, self._piece_at(t))

    def friction_rate(self, t: np.ndarray) -> np.ndarray:
        """dR/dt, by a difference quotient of fourth order on the piece's series, which continues beyond its ends."""
        piece = self._piece_at(t)
        h = DIFFERENCE * self.motion.piece_length[piece]
        ahead, back, ahead2, back2 = (self._observed("friction", t + k * h, piece) for k in (1, -1, 2, -2))
        return (8.0 * (ahead - back) - (ahead2 - back2)) / (12.0 * h)

    def position(self, t: np.ndarray) -> np.ndarray:
        """Place of the contact on its ground."""
        return contact_place(self.motion, self.contact, t, self._piece_at(t))

    def roots(self, function: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Times at which a function of time changes its sign, to rounding."""
        start, end = self.edges
        if not len(start):
            return np.empty(0)
        share = np.linspace(0.0, 1.0, SCAN + 1)
        times = np.unique((start[:, None] + (end - start)[:, None] * share).ravel())
        signs = np.sign(function(times))
        times, signs = times[signs != 0.0], signs[signs != 0.0]
        change = np.flatnonzero(signs[1:] != signs[:-1])
        low, high, below = times[change], times[change + 1], signs[change]
        return bisected(low, high, lambda middle: np.sign(function(middle)) == below)

    def nodes(self, cuts: np.ndarray | None = None) -> Nodes:
        """Gauss points on every piece; at `cuts`, times at which an integrand changes its form, pieces are cut."""
        start, end = self.edges
        cuts = np.empty(0) if cuts is None else cuts
        marks = np.unique(np.concatenate((start, end, cuts[(cuts > self.start) & (cuts < self.end)])))
        points, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        half, centre = 0.5 * np.diff(marks), 0.5 * (marks[1:] + marks[:-1])
        t = (centre[:, None] + half[:, None] * points).ravel()
        return Nodes(t, (half[:, None] * weights).ravel(), self.velocity(t), self.acceleration(t), self.friction(t))

    def _piece_at(self, t: np.ndarray) -> np.ndarray:
        return np.minimum(np.maximum(self.motion.piece_at(t), self.pieces[0]), self.pieces[-1])

    def _states(self, t: np.ndarray, piece: np.ndarray) -> np.ndarray:
        return self.motion.piece_states(piece, t - self.motion.piece_start[piece])

    def _observed(self, name: str, t: np.ndarray, piece: np.ndarray) -> np.ndarray:
        sides = list(self.motion.sides(piece))
        sides[self.contact - 1] = np.full(len(t), float(self.side))
        drive, names = self.motion.drive_at(piece, t - self.motion.piece_start[piece]), (numbered(name, self.contact),)
        return self.motion.observe(names, t, self._states(t, piece), tuple(sides), drive)[0]


def bisected(low: np.ndarray, high: np.ndarray, early: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """The places [n] between low and high up to which `early` holds, by bisection to rounding."""
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        lower = early(middle)
        before = low, high
        low, high = np.where(lower, middle, low), np.where(lower, high, middle)
        if all(map(np.array_equal, before, (low, high))):  # all else would be the same again
            break
    return 0.5 * (low + high)


def contact_place(motion: Trajectory, contact: int, t: np.ndarray, piece: np.ndarray | None = None) -> np.ndarray:
    """Way of a contact over its ground since the start, at times t (on given pieces)."""
    piece = motion.piece_at(t) if piece is None else piece
    (distance,) = motion.piece_integrals(piece, t - motion.piece_start[piece], (numbered("contact_velocity", contact),))
    return motion.piece_distances[contact - 1, piece] + distance


def stretches(motion: Trajectory, start: float, end: float, contact: int = 1) -> list[Stretch]:
    """The stretches of a window, in order: the phases of a contact, cut at its ends."""
    phases = motion.phases_of(contact)
    cut = (Stretch(motion, contact, max(p.start, start), min(p.end, end), p.side) for p in phases)
    return [stretch for stretch in cut if stretch.end - stretch.start > 0.0 and len(stretch.pieces)]
