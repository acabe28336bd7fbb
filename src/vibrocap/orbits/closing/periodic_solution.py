"""Periodic solutions modulo the drift: their record, multipliers and status."""

import dataclasses
from typing import Annotated, Any, TypeVar

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.motion.simulate import simulate
from vibrocap.motion.trajectory import Trajectory
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap
from vibrocap.orbits.walk.residual import CLOSE_TO_CIRCLE, FORGOTTEN
from vibrocap.physics.system import System
from vibrocap.quantities.declared import Context, Derivative, In, Length, Number, Speed, States
from vibrocap.results import Advised, Result

CERTIFIED = 1e-11  # least tolerance at which an orbit's motion is asked for its certificate: most orbits share a kernel


class OrbitStatus(Advised):
    """How the search for an orbit ended; `advice` says what to try."""

    CONVERGED = "converged", "The orbit closes within its residual."
    NOT_CONVERGED = (
        "not converged",
        "Newton's method did not converge. Start from a state nearer to the orbit (a longer simulation, or a "
        "neighbour on its branch), or name another period; the orbit may have ceased to exist.",
    )
    NOT_CERTIFIED = (
        "not certified",
        "The orbit closes, but the motion along it does not satisfy the equations: see `orbit.motion().certificate`. "
        "Set a smaller `tolerance`; if that does not help, see the failures of the certificate.",
    )
    RUN_FAILED = "run failed", "A run from the present state could not be completed; simulate it to see its status."
    NOT_SETTLED = (
        "not settled",
        "The simulation did not settle to a periodic motion. Raise `settle_periods`, start elsewhere, or name the "
        "period and a start; the motion may be quasi-periodic or chaotic.",
    )
    SECTION_NOT_MET = (
        "section not met",
        "The motion does not pass the section twice. Name an event or a value that it meets (simulate to see its "
        "events), start elsewhere, or raise `settle_periods`.",
    )
    MORE_RETURNS = (
        "more returns needed",
        "The motion does not repeat within the given number of returns to the section. Raise `returns` or "
        "`settle_periods`; the motion may be quasi-periodic or chaotic.",
    )
    COMES_TO_REST = (
        "comes to rest",
        "There is no cycle: the motion ends at rest, or comes to rest in the limit, by stops that become "
        "smaller and longer. `equilibria` shows where; start elsewhere for a cycle.",
    )
    SLIDES_STEADILY = (
        "slides steadily",
        "There is no cycle: the motion ends with a contact that slides at a constant velocity. `equilibria` shows "
        "where; start elsewhere for a cycle.",
    )
    CARRIED = (
        "carried along",
        "There is no cycle: all contacts stick in the end, and the machine moves with the ground that carries it.",
    )
    CONTRADICTED = (
        "multipliers contradicted",
        "The orbit closes, but runs beside it contradict its multipliers, so its stability is unknown. "
        "Shoot it again at another `tolerance`; simulate from its state to see its certificate.",
    )


CLOSED = (OrbitStatus.CONVERGED, OrbitStatus.NOT_CERTIFIED)


class Multipliers(In):
    """Floquet multipliers, which are shown of an orbit that converged."""

    def seen(self, value: Any, context: Context) -> Any:
        known = context.known("status")[0] is OrbitStatus.CONVERGED
        return super().seen(value if known else value[:0], context)


class OfClosed(In):
    """A number that is shown of an orbit that closes."""

    def seen(self, value: Any, context: Context) -> Any:
        failed = context.known("status")[0] not in (*CLOSED, OrbitStatus.CONTRADICTED)
        return None if failed else super().seen(value, context)


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class PeriodicSolution(Result):
    """A periodic solution modulo its drift and whole turns, as Newton's method left it.

    state: at the section (the start of a drive period), position zero
    period: its length; response_period: that in drive periods, 0 for an autonomous system
    returns: how often it passes the section at which its turns were counted; 0 where none was
    drift: what the cyclic coordinate gains over it (exactly zero where `symmetric`); None without such a coordinate
    winding: whole turns over it of each coordinate that turns, by name
    multipliers: Floquet multipliers modulo the drift, largest first: of the map without the cyclic coordinate (and
        without the direction along the motion of an autonomous system). Exactly zero for each direction that sticking
        forgets. Empty where the orbit is not closed
    residual: largest mismatch of the closing orbit over the natural size of each state
    symmetric: whether the orbit is its own mirror image half a period later; None without that symmetry
    derivative: of the map at the section, [states, states]
    status: `OrbitStatus`; anything but CONVERGED means that the numbers above are not to be trusted: of a motion whose
        multipliers are contradicted or whose certificate is refused, or (`failed`) of the last try, which has neither
        drift nor winding, multipliers or symmetry

    Two are equal if all of this is.
    """

    system: System
    state: States
    period: Annotated[float, OfClosed("s")]
    response_period: int
    drift: Length | None
    multipliers: Annotated[np.ndarray, Multipliers("1")]
    residual: Number
    symmetric: bool | None
    derivative: Derivative
    status: OrbitStatus
    iterations: int
    tolerance: Number
    mirrored_state: States | None = None
    winding: dict[str, int] = dataclasses.field(default_factory=dict)
    returns: int = 0

    def __post_init__(self):
        if not self.closes:
            object.__setattr__(self, "multipliers", np.empty(0, dtype=complex))
        if self.failed:
            for name, nothing in (("drift", None), ("symmetric", None), ("winding", {})):
                object.__setattr__(self, name, nothing)

    @property
    def heading(self) -> str:
        what = f"steady motion of {self.response_period} drive period(s)" if self.response_period else "cycle"
        what = "no closed steady motion" if self.failed else what
        return f"{what} of a {self.system.machine.name}, {self.system.law_names} friction"

    @property
    def facts(self) -> dict[str, str]:
        if self.failed:
            tried = f", residual {self.residual:.1e} where it was tried" if np.isfinite(self.residual) else ""
            return {"status": f"{self.status.value}{tried}"}
        facts = {"period": f"period {self.said('period')}"}
        if self.drift is not None:
            facts["travel"] = f"drift {self.said('drift')}, mean velocity {self.said('mean_velocity', 6)}"
        if self.winding:
            facts["turns"] = ", ".join(f"{turns} turn(s) of {name}" for name, turns in self.winding.items())
        if self.symmetric is not None:
            facts["symmetry"] = "its own mirror image" if self.symmetric else "has a mirror-image solution"
        if self.returns:
            facts["returns"] = f"{self.returns} return(s) to the section"
        words = {"neither": "neither stable nor unstable", "not known": "stability not known"}
        largest = "" if self.largest_multiplier is None else f", largest multiplier {self.largest_multiplier:.6g}"
        facts["stability"] = words.get(self.stability, self.stability) + largest
        return facts | {"status": f"{self.status.value}, residual {self.residual:.1e}"}

    @property
    def failed(self) -> bool:
        """Whether nothing closes, so that there is no steady motion with a drift or a velocity."""
        return self.status not in (*CLOSED, OrbitStatus.CONTRADICTED)

    @property
    def closes(self) -> bool:
        """Whether it is closed, with multipliers that nothing contradicts, whatever its certificate says."""
        return self.status in CLOSED

    def motion(self, periods: float | None = None, **options: Any) -> Trajectory:
        """The motion along the orbit, over its own period unless told otherwise (in drive periods).

        Raises ArgumentError for an orbit of a run that failed, of which no state is known.
        """
        if not np.all(np.isfinite(list(self.state.values()))):
            raise ArgumentError("orbit", f"has no motion, as no state of it is known: {self.status.value}")
        periods = self.period / self.system.drive.period if periods is None else periods
        options = {"tolerance": max(self.tolerance, 1e-13), **options}
        return simulate(self.system, periods=periods, initial=self.state, **options)

    @property
    def stable(self) -> bool:
        """Whether all multipliers are inside the unit circle; with one on it, it is neither stable nor unstable.

        Nor is an orbit that is not closed or whose motion is not certified.
        """
        known = self.status is OrbitStatus.CONVERGED
        return known and bool(np.all(np.abs(self.multipliers) < 1.0 - CLOSE_TO_CIRCLE))

    @property
    def unstable(self) -> bool:
        """Whether a multiplier is outside the unit circle: no simulation keeps such an orbit."""
        known = self.status is OrbitStatus.CONVERGED
        return known and bool(np.max(np.abs(self.multipliers), initial=0.0) > 1.0 + CLOSE_TO_CIRCLE)

    @property
    def stability(self) -> str:
        """ "stable", "unstable", "neither" with a multiplier on the unit circle, "not known" unless it converged."""
        if self.status is not OrbitStatus.CONVERGED:
            return "not known"
        return "stable" if self.stable else "unstable" if self.unstable else "neither"

    @property
    def largest_multiplier(self) -> Number | None:
        """The largest |multiplier|, 0 where there is none; None unless it converged."""
        if self.status is not OrbitStatus.CONVERGED:
            return None
        return float(np.max(np.abs(self.multipliers), initial=0.0))

    @property
    def mean_velocity(self) -> Speed | None:
        return None if self.drift is None else self.drift / self.period


Solution = TypeVar("Solution", bound=PeriodicSolution)


def judged(solution: Solution) -> Solution:
    """The same, NOT_CERTIFIED where it is closed and the certificate of the motion along it is refused.

    The motion is recorded over its period, at a tolerance of at least `CERTIFIED`.
    """
    if not solution.closes:
        return solution
    motion = solution.motion(tolerance=max(solution.tolerance, CERTIFIED))
    status = OrbitStatus.CONVERGED if motion.certified else OrbitStatus.NOT_CERTIFIED
    return solution if status is solution.status else dataclasses.replace(solution, status=status)


def floquet_multipliers(map_: StroboscopicMap, jacobian: np.ndarray, cycle: bool = False) -> np.ndarray:
    """Eigenvalues of the map's derivative without the cyclic coordinate, largest first; switched states have none.

    A direction that the contact forgets while it sticks has the multiplier zero exactly; of it rounding leaves some
    1e-17, so for a law that sticks a multiplier below FORGOTTEN is 0. That along a cycle, which is 1, is left out; none
    are known where the derivative is not finite.
    """
    moving = map_.smooth_states
    if not np.all(np.isfinite(jacobian)):
        return np.empty(0, dtype=complex)
    values = np.linalg.eigvals(jacobian[np.ix_(moving, moving)]).astype(complex)
    if map_.resting:
        values[np.abs(values) <= FORGOTTEN] = 0.0
    values = values[np.argsort(-np.abs(values), kind="stable")]
    return np.delete(values, np.argmin(np.abs(values - 1.0))) if cycle else values
