"""What vanishes along a branch of cycles that nothing drives in time: their period is an unknown too."""

import copy
import dataclasses

import numpy as np

from vibrocap.motion.simulate import simulate
from vibrocap.orbits.maps.closing_map import ClosingMap, OrbitClosing
from vibrocap.orbits.maps.stroboscopic_map import named_states
from vibrocap.physics.system import System

SAMPLES = 256  # of a cycle, to see how far its states reach
PUSHED = 1e-9  # velocity over its natural size up to which a contact that sticks in a neighbour counts as at rest


@dataclasses.dataclass(frozen=True, eq=False)
class CycleClosing(OrbitClosing):
    """A closing whose unknowns are the states, the period over that of the start, and q.

    mismatch: [m + 1] of the states, and of the section; bordered: [m + 1, m + 2] its derivative by x
    jacobian: [m - 1, m - 1] of the return to the section, whose eigenvalues are the multipliers but the trivial one
    """

    bordered: np.ndarray = dataclasses.field(kw_only=True)

    @property
    def derivative(self) -> np.ndarray:
        return self.bordered


class CycleMap(ClosingMap):
    """P_T of one form of system, as a function of the start, of the period T and of one parameter.

        P_T(y; p) - y = 0,      n . (y - y_0) = 0

    The section is the plane across the flow n at a cycle of the branch, amid one of its phases.
    """

    nudge = 1e-7  # shorter: cycles end where a nudge may lead beyond

    def __init__(
        self,
        system: System,
        path: str,
        between: tuple[float, float],
        state: np.ndarray,
        period: float,
        tolerance: float = 1e-12,
        plain: bool = False,
        sizes: np.ndarray | None = None,
    ):
        """state, period: of the cycle from which the branch is followed; sizes: [states], by default its extents"""
        super().__init__(system, path, between, 0, False, tolerance, False, plain)
        self.start_period = period
        self.sizes = self._extents(state, period) if sizes is None else sizes
        self._across(state, self.row)

    def _extents(self, state: np.ndarray, period: float) -> np.ndarray:
        """Half the range of each state along the cycle at the start, where that is above its natural size.

        The natural size of a state may follow the duration of the idle drive, which is nothing to a cycle.
        """
        start = named_states(self.system, state)
        motion = simulate(self.system, periods=period / self.system.drive.period, initial=start)
        values = np.array([motion.at(np.linspace(0.0, motion.end, SAMPLES), name) for name in motion.state_names])
        half = 0.5 * np.ptp(values, axis=1)
        half[self.map.cyclic if self.map.cyclic >= 0 else []] = 0.0
        return np.maximum(self.sizes, half)

    def _across(self, state: np.ndarray, row: np.ndarray) -> None:
        """Set the section across the flow at a state."""
        flow = self.map.rates(state, self.map.contact_side(state, row), row)[self.unknowns]
        flow = flow / self.sizes[self.unknowns]
        self.normal = flow / np.linalg.norm(flow)
        self.level = float(self.normal @ (state / self.sizes)[self.unknowns])

    def with_section(self, state: np.ndarray, parameter: float) -> "CycleMap":
        """The same with the section across the flow at another state and value of the parameter."""
        other = copy.copy(self)
        row = self.row.copy()
        row[self.index] = parameter
        other._across(state, row)
        return other

    def point(self, state: np.ndarray, parameter: float, period: float | None = None) -> np.ndarray:
        """x of a whole state vector, a value of the parameter and a period (that of the start unless given)."""
        x = super().point(state, parameter)
        return np.insert(x, -1, 1.0 if period is None else period / self.start_period)

    def state(self, x: np.ndarray, like: OrbitClosing | None = None) -> np.ndarray:
        return super().state(np.delete(x, -2), like)

    def period(self, x: np.ndarray) -> float:
        return float(x[-2]) * self.start_period

    def coarser(self) -> "CycleMap":
        """The map over half the period, of which a cycle that has doubled its period is no fixed point."""
        other = copy.copy(self)
        other.start_period = 0.5 * self.start_period
        return other

    def lengths(self, x: np.ndarray, rows: np.ndarray) -> np.ndarray:
        return np.full(len(rows), self.period(x))

    def attempt(self, x: np.ndarray, like: OrbitClosing | None = None) -> CycleClosing:
        map_, m = self.map, len(self.unknowns)
        if like is not None:
            # With a static limit above the kinetic one a contact that is pushed however little may slide away: the
            # velocity of one that sticks in a neighbour is exactly zero, where rounding has moved it.
            x = x.copy()
            x[:-1][like.at_rest & (np.abs(x[:-1]) <= PUSHED)] = 0.0
        if not 0.0 < self.period(x) < np.inf:
            nothing, bordered = np.full(m + 1, np.nan), np.full((m + 1, m + 2), np.nan)
            failed = x, nothing, np.zeros((m - 1, m - 1)), nothing, np.zeros(m + 1, dtype=bool), False
            return CycleClosing(*failed, image=self.state(x, like), bordered=bordered)
        row, closing = self.row_at(x), super().attempt(x, like)
        flow = map_.rates(closing.image, map_.contact_side(closing.image, row), row)[self.unknowns]
        flow = flow / self.sizes[self.unknowns]
        above = np.column_stack((closing.jacobian - np.eye(m), flow * self.start_period, closing.slope))
        changed = {
            "mismatch": np.append(closing.mismatch, self.normal @ x[:m] - self.level),
            "jacobian": self._returned(closing.jacobian, flow),
            "slope": np.append(closing.slope, 0.0),
            "at_rest": np.append(closing.at_rest, False),
            "turns": np.append(self.turns, (np.inf, np.inf)),
            "bordered": np.vstack((above, np.append(self.normal, (0.0, 0.0)))),
        }
        return CycleClosing(**vars(closing) | changed)

    def _returned(self, monodromy: np.ndarray, flow: np.ndarray) -> np.ndarray:
        """Derivative of the return to the section, in a basis of it: what goes along the flow is taken off."""
        along = float(self.normal @ flow)
        basis = np.linalg.svd(self.normal[None])[2][1:].T
        taken = np.eye(len(flow)) - np.outer(flow, self.normal) / (along if along != 0.0 else np.nan)
        returned = basis.T @ taken @ monodromy @ basis
        return np.where(np.isfinite(returned), returned, 0.0)
