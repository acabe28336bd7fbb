"""A steady motion: an orbit that closes modulo a shift along the cyclic coordinate."""

import dataclasses
import enum
from typing import Any

import numpy as np

from vibrocap.measures.sticking import spelled
from vibrocap.simulate import simulate
from vibrocap.system import System
from vibrocap.trajectory import Trajectory

CLOSE_TO_CIRCLE = 1e-8  # a multiplier whose size is this close to 1 is neither stable nor unstable


class OrbitStatus(enum.Enum):
    """How the search for an orbit ended; `advice` says what to try."""

    CONVERGED = "converged"
    NOT_CONVERGED = "not converged"
    RUN_FAILED = "run failed"
    NOT_SETTLED = "not settled"

    @property
    def advice(self) -> str:
        """What it means and what can be done."""
        return ADVICE[self]


ADVICE = {
    OrbitStatus.CONVERGED: "The orbit closes within its residual.",
    OrbitStatus.NOT_CONVERGED: "Newton's method did not converge. Start from a state nearer to the orbit (a longer "
    "simulation, or a neighbour on its branch), or name another period; the orbit may have ceased to exist.",
    OrbitStatus.RUN_FAILED: "A run from the present state could not be completed; simulate it to see its status.",
    OrbitStatus.NOT_SETTLED: "The simulation did not settle to a periodic motion. Raise `settle_periods`, start "
    "elsewhere, or name the period and a start; the motion may be quasi-periodic or chaotic.",
}


@dataclasses.dataclass(frozen=True)
class Orbit:
    """A steady motion, periodic modulo its drift.

    state: at the section (the start of a drive period), position zero
    period: its length; response_period: that in drive periods, 0 for an autonomous system
    drift: what the cyclic coordinate gains over it (exactly zero where `symmetric`); None without such a coordinate
    multipliers: Floquet multipliers modulo the drift, largest first: of the map without the cyclic coordinate (and
        without the direction along the motion of an autonomous system). Exactly zero for each direction that sticking
        forgets
    residual: largest mismatch of the closing orbit over the natural size of each state
    symmetric: whether the orbit is its own mirror image half a period later; None without that symmetry
    derivative: of the map at the section, [states, states]
    status: `OrbitStatus`; anything but CONVERGED means that the numbers above are those of the last try
    passed: the unstable orbit near which the motion from the start seemed to have settled before it went on to this
        one; None as a rule
    """

    system: System
    state: dict[str, float]
    period: float
    response_period: int
    drift: float | None
    multipliers: np.ndarray
    residual: float
    symmetric: bool | None
    derivative: np.ndarray
    status: OrbitStatus
    iterations: int
    tolerance: float
    mirrored_state: dict[str, float] | None = None
    passed: "Orbit | None" = None

    @property
    def stable(self) -> bool:
        """Whether all multipliers are inside the unit circle; with one on it, it is neither stable nor unstable."""
        return bool(np.all(np.abs(self.multipliers) < 1.0 - CLOSE_TO_CIRCLE))

    @property
    def unstable(self) -> bool:
        """Whether a multiplier is outside the unit circle: no simulation keeps such an orbit, see `pushed_off`."""
        return bool(np.max(np.abs(self.multipliers), initial=0.0) > 1.0 + CLOSE_TO_CIRCLE)

    @property
    def mean_velocity(self) -> float | None:
        """Drift over the period."""
        return None if self.drift is None else self.drift / self.period

    def motion(self, periods: float | None = None, **options: Any) -> Trajectory:
        """The motion along the orbit, over its own period unless told otherwise (in drive periods)."""
        periods = self.period / self.system.drive.period if periods is None else periods
        options = {"tolerance": max(self.tolerance, 1e-13), **options}
        return simulate(self.system, periods=periods, initial=self.state, **options)

    @property
    def word(self) -> str:
        """Phases of the motion over its whole period, read as a cycle: F forward, S stuck, B back; "" if smooth."""
        if self.system.friction.kind == "smooth":
            return ""
        motion = self.motion()
        return spelled(motion, 0.0, motion.end)

    def pushed_off(self, *, settle_periods: int = 2000) -> "tuple[Orbit, ...]":
        """The orbits that attract what is pushed off this one, if it is unstable: see `orbits.unstable.pushed_off`."""
        from vibrocap.orbits.closing.push_off import pushed_off

        return pushed_off(self, settle_periods=settle_periods)

    def twin(self) -> "Orbit":
        """The mirror twin, which drifts the other way; the orbit itself where it is symmetric.

        Raises ValueError for a system without the half-period symmetry.
        """
        if self.mirrored_state is None:
            raise ValueError(
                "the system has no half-period symmetry (an even drive, machine or law), so no mirror twins"
            )
        if self.symmetric:
            return self
        from vibrocap.orbits.closing.shooting import shoot

        return shoot(self.system, self.mirrored_state, self.response_period, tolerance=self.tolerance)
