"""The steady motion that a start leads to, by simulation alone: run until it is there to rounding."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from vibrocap.measures.during_run import measured
from vibrocap.motion.simulate import period_marks, simulate
from vibrocap.numerics.api import Stroboscope
from vibrocap.orbits.closing.periodic_solution import OrbitStatus, named_states, state_vector
from vibrocap.orbits.closing.shooting import closed, shortest
from vibrocap.orbits.maps.settling_runs import SETTLED
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap
from vibrocap.physics.system import System

ARRIVED = 20.0  # tolerances of the run within which a motion stands still: what is left is error of the integration
FIRST_LOOK = 24  # drive periods after which it is first asked; then after twice as many, and so on


@dataclasses.dataclass(frozen=True)
class SettledMotion:
    """A steady motion at the start of a drive period.

    state: by name, position as it came; response_period: in drive periods
    drift: per drive period; None for a machine that does not travel
    """

    system: System
    state: Mapping[str, float]
    response_period: int
    drift: float | None
    tolerance: float

    def value(self, measure: str) -> float:
        """A measure of one response."""
        if self.drift is not None and measure in ("drift", "mean_velocity"):
            return self.drift / (1.0 if measure == "drift" else self.system.drive.period)
        motion = simulate(self.system, periods=self.response_period, initial=self.state, tolerance=self.tolerance)
        return float(measured(motion, [measure], window=self.response_period)[measure])


def settled_motion(
    system: System, initial: Mapping[str, float] | None, periods: int, tolerance: float = 1e-12
) -> SettledMotion | None:
    """The motion to which a start leads; None where it has not settled after so many drive periods, or a run fails.

    The motion is run until its stroboscopic states repeat within `ARRIVED` tolerances; that costs about 10 microseconds
    per period and no derivative. A motion that settles too slowly for that, but has come within `SETTLED` of where it
    goes, is closed by shooting.
    """
    state, done, most = initial, 0, FIRST_LOOK
    sizes = np.array(system.scales(), dtype=float)
    names = list(system.state_names)
    kept = [i for i, name in enumerate(names) if name != system.machine.cyclic]
    while True:
        length = min(most, periods - done)
        status, marks = period_marks(system, periods=length, initial=state, tolerance=tolerance)
        if not status.ok:
            return None
        done += length
        most = done
        state = named_states(system, marks[-1])
        over = Stroboscope(marks[:, kept] / sizes[kept])
        response = over.settled_response(ARRIVED * tolerance, tolerance)[0]
        if response:
            return SettledMotion(system, state, response, _drift(system, marks, response), tolerance)
        if done >= periods:
            response = over.settled_response(SETTLED, tolerance)[0]
            return _closed(system, state, response, tolerance) if response else None


def _drift(system: System, marks: np.ndarray, response: int) -> float | None:
    """Travel per drive period over the last response."""
    if system.machine.cyclic is None:
        return None
    place = system.state_names.index(system.machine.cyclic)
    return float(marks[-1, place] - marks[-1 - response, place]) / response


def _closed(system: System, state: Mapping[str, float], response: int, tolerance: float) -> SettledMotion | None:
    """The orbit near a state, by shooting."""
    map_ = StroboscopicMap(system, tolerance)
    found = shortest(map_, closed(map_, state_vector(system, state), response))
    if found.status is not OrbitStatus.CONVERGED:
        return None
    drift = None if found.drift is None else found.drift / found.response_period
    return SettledMotion(system, found.state, found.response_period, drift, tolerance)
