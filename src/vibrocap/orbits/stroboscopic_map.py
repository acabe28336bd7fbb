"""The stroboscopic map: the state whole drive periods later, and its derivative, for many states at once."""

import dataclasses

import numpy as np

from vibrocap.equations import equations, parameter_values
from vibrocap.numerics.expressions.graph import evaluate
from vibrocap.numerics.kernel import memory_layout as memory
from vibrocap.numerics.run.ensemble import Budget, ensemble_run
from vibrocap.orbits.variations import variational_equations
from vibrocap.system import System

MOST_EVENTS = 100_000  # in one period
MOST_STEPS = 2_000_000
ORDER = 12  # of the series: one kernel serves all tolerances


@dataclasses.dataclass(frozen=True)
class Images:
    """Images of states under the stroboscopic map.

    state: [runs, states]; jacobian: [runs, states, states], entry (i, j) the derivative of image i by start j, or None
    finished: [runs] whether the run came to its end
    """

    state: np.ndarray
    jacobian: np.ndarray | None
    finished: np.ndarray


class StroboscopicMap:
    """The map of the state over drive periods, for one form of system; parameters and states differ from run to run.

    Derivatives are exact: the tangents of a motion are carried through its events by saltation, on the lanes of one
    kernel (`kernel/events/tangents.py`). What a sticking contact has forgotten is a direction in which the map is
    constant.
    """

    def __init__(self, system: System, tolerance: float = 1e-12, threads: int | None = None, plain: bool = False):
        """tolerance: error per step over the natural size of each state; plain: as plain Python, not compiled."""
        self.system = system
        self.tolerance = tolerance
        self.threads = threads
        self.plain = plain
        self.equations = equations(system)
        self.states = len(system.state_names)
        self.mirror = np.array(self.equations.symmetry, dtype=float)
        self.cyclic = self.equations.cyclic_state

    def parameters(self, system: System | None = None) -> np.ndarray:
        """Parameter vector of a system of this form."""
        return np.array(parameter_values(system or self.system))

    def scales(self, parameters: np.ndarray) -> np.ndarray:
        """Natural size of each state."""
        return np.array([float(value) for value in evaluate(self.equations.scales, 0.0, [], 1.0, parameters)])

    def period(self, parameters: np.ndarray) -> float:
        """Period of the drive."""
        return float(evaluate([self.equations.period], 0.0, [], 1.0, parameters)[0])

    def rates(self, state: np.ndarray, side: float, parameters: np.ndarray, time: float = 0.0) -> np.ndarray:
        """y' at a state and a time since the mark."""
        values = evaluate(self.equations.rates, time, state, side, parameters)
        return np.array([float(value) for value in values])

    def free(self, states: np.ndarray) -> np.ndarray:
        """Which states [runs, states] may be varied: not the velocity of a contact at rest, nor what is switched.

        A contact that is pushed a little while it sticks stops at once: the map does not depend on that push.
        """
        free = np.ones(states.shape, dtype=bool)
        if self.equations.hold is not None:
            contact = self.equations.contact_state
            free[:, contact] = states[:, contact] != 0.0
        for i, name in enumerate(self.system.state_names):
            if name in self.system.friction.switched:
                free[:, i] = False
        return free

    def images(
        self,
        states: np.ndarray,
        parameters: np.ndarray,
        periods: int = 1,
        tangents: bool = True,
        mark_distance: np.ndarray | None = None,
    ) -> Images:
        """Images of states [runs, states] with parameters [runs, parameters] after so many whole periods.

        mark_distance: [runs], in place of the drive's period (then periods should be 1)
        """
        runs, n = states.shape
        budget = Budget(periods, 1, 0.0, self.tolerance, MOST_EVENTS, MOST_STEPS)
        recording, each = self.equations, 1
        start, scales = states, np.ones((runs, n))
        if tangents:
            recording, each = variational_equations(self.equations), n
            scales = np.stack([self.scales(row) for row in parameters])
            start = np.zeros((runs, n, 2 * n))
            start[:, :, :n] = states[:, None, :]
            start[:, np.arange(n), n + np.arange(n)] = scales * self.free(states)
            start = start.reshape(runs * n, 2 * n)
        layout, results = ensemble_run(
            recording,
            np.repeat(parameters, each, axis=0),
            start,
            budget,
            threads=self.threads,
            order=ORDER,
            plain=self.plain,
            mark_distance=None if mark_distance is None else np.repeat(mark_distance, each),
        )
        first = len(memory.RESULT_HEAD) + layout.states
        ends = results[:, first : first + layout.states].reshape(runs, each, -1)
        finished = np.all(results[:, 0].reshape(runs, each) == memory.DONE, axis=1)
        jacobian = np.swapaxes(ends[:, :, n:], 1, 2) / scales[:, None, :] if tangents else None
        return Images(ends[:, 0, :n], jacobian, finished)

    def mirrored_half(self, states: np.ndarray, parameters: np.ndarray, tangents: bool = True) -> Images:
        """The mirrored state half a drive period later: S P_(T/2), of which symmetric motions are fixed points."""
        half = np.array([0.5 * self.period(row) for row in parameters])
        found = self.images(states, parameters, 1, tangents, mark_distance=half)
        jacobian = None if found.jacobian is None else self.mirror[:, None] * found.jacobian
        return Images(self.mirror * found.state, jacobian, found.finished)
