"""The stroboscopic map: the state whole drive periods later, and its derivative, for many states at once."""

import dataclasses
import functools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from vibrocap.motion.evidence import certified
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.recording.section import section_states, whole_turns
from vibrocap.numerics.api import Budget, EnsembleStart, Form, RunResults, ensemble_run
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import evaluate, evaluated
from vibrocap.orbits.maps.variations import variational_equations
from vibrocap.physics.closed_loop.sampling import check_smooth
from vibrocap.physics.system import System

MOST_EVENTS = 100_000  # in one period
MOST_STEPS = 2_000_000
AT_REST = 1e-11  # speed of a contact whose velocity is imposed in part, which is at rest as far as orbits are closed
PUSHES = 1e-5, 1e-6  # over the natural size, of the differences that check a derivative through turns at one instant
AGREE = 1e-3  # of derivatives that are the same, relative
BACKWARDS = -1e-6  # a slope that no rounding makes of one that is not negative
ORDER = 12  # of the series: one kernel serves all tolerances


@dataclasses.dataclass(frozen=True)
class Images:
    """Images of states under the stroboscopic map.

    state: [runs, states]; jacobian: [runs, states, states], entry (i, j) the derivative of image i by start j, or None
    finished: [runs] whether the run came to its end; judge: makes `certified` when it is asked for
    """

    state: np.ndarray
    jacobian: np.ndarray | None
    finished: np.ndarray
    judge: Callable[[], np.ndarray]

    @functools.cached_property
    def certified(self) -> np.ndarray:
        """[runs] whether its evidence, without tangents that of its events alone, is within a certificate's bounds."""
        return self.judge()


class StroboscopicMap:
    """The map of the state over drive periods, for one form of system; parameters and states differ from run to run.

    Derivatives are exact: the tangents of a motion are carried through its events by saltation, on the lanes of one
    kernel (`kernel/events/tangents.py`). What a sticking contact has forgotten is a direction in which the map is
    constant. Where contacts at imposed distances turn together, as those of a symmetric worm do, central differences
    take the place of saltation, which goes through one turn at a time; they are exact to some 1e-7.
    """

    def __init__(self, system: System, tolerance: float = 1e-12, threads: int | None = None, plain: bool = False):
        """tolerance: error per step over the natural size of each state; plain: as plain Python, not compiled."""
        check_smooth(system)
        self.system = system
        self.tolerance = tolerance
        self.threads = threads
        self.plain = plain
        self.stiff = False  # whether only the plain equations, which may be stepped implicitly, come to their end
        self.equations = equations(system)
        self.states = len(system.state_names)
        self.mirror = np.array(self.equations.symmetry, dtype=float)
        self.cyclic = self.equations.cyclic_state
        switched = system.switched
        self.switched = np.array([name in switched for name in system.state_names])
        self.section_states = np.flatnonzero(np.arange(self.states) != self.cyclic)  # all but the cyclic coordinate
        self.smooth_states = self.section_states[~self.switched[self.section_states]]  # nor what a law switches

    def __reduce__(self):
        return type(self), (self.system, self.tolerance, self.threads, self.plain)  # the equations are recorded anew

    def of(self, system: System) -> "StroboscopicMap":
        """The same map of another system, of this form but for what its numbers free."""
        if system.cyclic != self.system.cyclic:
            return type(self)(system, self.tolerance, self.threads, self.plain)
        other = object.__new__(type(self))
        vars(other).update(vars(self), system=system)
        return other

    @property
    def resting(self) -> tuple[int, ...]:
        """Velocities among the states that are exactly zero while their contact, whichever, rests."""
        return tuple(dict.fromkeys(contact.state for contact in self.equations.contacts if contact.sticks))

    @property
    def keeps_order(self) -> bool:
        """Whether motions cannot pass one another: there is one smooth state, which no event of the machine makes jump.

        So it is of the common centre of bodies whose relative motion is imposed, under laws without memory: solutions
        of one scalar equation merge or stay apart, and no derivative of the map is negative.
        """
        return len(self.smooth_states) == 1 and not self.system.machine.switched

    def parameters(self) -> np.ndarray:
        return np.array(parameter_values(self.system))

    def scales(self, parameters: np.ndarray) -> np.ndarray:
        """Natural size of each state [..., states], of parameters [..., parameters]."""
        return evaluated(self.equations.scales, 0.0, [], 1.0, parameters.T, parameters.shape[:-1]).T

    def period(self, parameters: np.ndarray) -> float:
        return float(self.periods(parameters))

    def periods(self, parameters: np.ndarray) -> np.ndarray:
        """The same [...] of parameters [..., parameters]."""
        return evaluated([self.equations.period], 0.0, [], 1.0, parameters.T, parameters.shape[:-1])[0]

    def rates(self, state: np.ndarray, side: Any, parameters: np.ndarray, time: float = 0.0) -> np.ndarray:
        """y' at a state [states] or [states, runs] and a time since the start of the drive's period."""
        parameters = self.equations.filled(parameters, time)
        return evaluated(self.equations.rates, time, state, side, parameters, state.shape[1:])

    def section(self, states: np.ndarray) -> np.ndarray:
        """Where states [..., states] are, see `section_states`: [..., kept]."""
        return section_states(self.system, states, self.scales(self.parameters()))

    def away(self, images: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Images less states [..., states], modulo whole turns."""
        gained = images - states
        return gained - whole_turns(self.system, gained)

    def contact_side(self, state: np.ndarray, parameters: np.ndarray) -> Any:
        """To which side the contact slides: +1, -1, or 0 where it sticks; of several contacts a tuple, one for each.

        state: [states] or [states, runs], then an array [runs] for each contact
        """
        parameters = self.equations.filled(parameters)
        contacts, sides = self.equations.contacts, []
        velocities = evaluate([contact.velocity for contact in contacts], 0.0, list(state), 1.0, parameters)
        for contact, velocity in zip(contacts, velocities, strict=True):
            side = np.where((velocity == 0.0) & contact.sticks, 0.0, np.where(velocity < 0.0, -1.0, 1.0))
            sides.append(side if side.ndim else float(side))
        return sides[0] if len(sides) == 1 else tuple(sides)

    def free(self, states: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        """Which states [runs, states] may be varied: not the velocity of a contact at rest, nor what a switch decides.

        parameters: [runs or 1, parameters]
        A contact that is pushed a little while it sticks stops at once: the map does not depend on that push.
        """
        free = np.ones(states.shape, dtype=bool)
        for contact, (_, rests) in zip(self.equations.contacts, self._at_rest(states, parameters, 0.0), strict=True):
            free[rests, contact.state] = False
        free[:, self.switched] = False
        for switch, names in self.system.placed.locked.items():
            closed = states[:, self.system.state_names.index(switch)] != 0.0
            for name in names:
                free[closed, self.system.state_names.index(name)] = False
        return free

    def _at_rest(self, states: np.ndarray, parameters: np.ndarray, time: Any) -> list[tuple[np.ndarray, np.ndarray]]:
        """(velocity [runs], in which runs it rests) of each contact: at exactly 0 where it is a state itself."""
        contacts, scales = self.equations.contacts, self.equations.scales
        values, shifts = self.equations.filled(parameters, time).T, []
        for contact in contacts:
            velocity, none = states[:, contact.state], 0.0
            if not contact.is_state:
                velocity, size = evaluate([contact.velocity, scales[contact.state]], time, states.T, 1.0, values)
                none = AT_REST * (np.abs(states[:, contact.state]) + size)
            shifts.append((velocity, contact.sticks & ~(np.abs(velocity) > none)))
        return shifts

    def run(
        self,
        budget: Budget,
        states: np.ndarray,
        parameters: np.ndarray,
        *,
        recording: Equations | None = None,
        order: int = 0,
        mark_distance: np.ndarray | None = None,
        start: np.ndarray | float = 0.0,
        progress: Callable[[int], None] | None = None,
    ) -> RunResults:
        """Run states [runs, states] with parameters, those of all or [runs, parameters], as far as a budget allows.

        recording: equations in place of the map's own; the others as for `EnsembleStart`; start: its time
        """
        recording = self.equations if recording is None else recording
        parameters = np.ascontiguousarray(in_rows(parameters, states))
        states, moved = states.copy(), np.zeros(len(states), dtype=bool)
        at_rest = self._at_rest(states, parameters, start)
        for contact, (velocity, rests) in zip(self.equations.contacts, at_rest, strict=True):
            if not contact.is_state:  # at rest but for rounding, it rests; of several by one state the first
                states[:, contact.state] -= np.where(rests & ~moved, velocity, 0.0)
                moved |= rests
        begin = EnsembleStart(recording, parameters, states, start, mark_distance)
        return ensemble_run(begin, budget, Form(order=order, plain=self.plain), self.threads, progress)

    def certified(self, ended: RunResults, parameters: np.ndarray) -> np.ndarray:
        """Whether the evidence of runs, taken as far as their budget asked, is within the bounds of a certificate."""
        return certified(self.equations, ended, parameters, self.tolerance)

    def images(
        self,
        states: np.ndarray,
        parameters: np.ndarray,
        periods: int = 1,
        tangents: bool = True,
        mark_distance: np.ndarray | None = None,
    ) -> Images:
        """Images of states [runs, states] with parameters, those of all or [runs, parameters], after whole periods.

        mark_distance: [runs], in place of the drive's period (then periods should be 1)
        """
        (runs, n), parameters = states.shape, in_rows(parameters, states)
        if tangents and self.stiff:
            return self._with_differences(states, parameters, periods, mark_distance)
        budget = Budget(periods, self.tolerance, MOST_EVENTS, MOST_STEPS, evidence=periods if tangents else 0)
        recording, lanes = self.equations, 1
        start, scales = states, np.ones((runs, n))
        if tangents:
            recording, lanes = variational_equations(self.equations), n
            scales = self.scales(parameters)
            start = np.zeros((runs, n, 2 * n))
            start[:, :, :n] = states[:, None, :]
            start[:, np.arange(n), n + np.arange(n)] = scales * self.free(states, parameters)
            start = start.reshape(runs * n, 2 * n)
        distance = None if mark_distance is None else np.repeat(mark_distance, lanes)
        rows = np.repeat(parameters, lanes, axis=0)
        ended = self.run(budget, start, rows, recording=recording, order=ORDER, mark_distance=distance)
        ends = ended.state.reshape(runs, lanes, -1)
        finished = np.all(ended.finished.reshape(runs, lanes), axis=1)
        if tangents and self.equations.maybe_stiff and not finished.all():
            images = self._with_differences(states, parameters, periods, mark_distance)
            self.stiff = bool(np.any(images.finished & ~finished))
            if self.stiff:
                return images
        jacobian = np.swapaxes(ends[:, :, n:], 1, 2) / scales[:, None, :] if tangents else None
        if jacobian is not None and self.system.machine.imposes_distances:
            self.through_joint_turns(jacobian, states, parameters, budget, mark_distance)
        return Images(ends[:, 0, :n], jacobian, finished, lambda: self.certified(ended[::lanes], parameters))

    def through_joint_turns(
        self, jacobian: np.ndarray, states: np.ndarray, parameters: np.ndarray, budget: Budget, distance: Any
    ) -> None:
        """Take differences for the column of the coordinate that all contacts share, where they say another derivative.

        jacobian: [runs, states, states] by the tangents, which is changed; of a machine that imposes distances
        Two pushes have to agree, so that a turn between them is not taken for a turn at one instant.
        """
        shared = self.equations.contacts[0].state
        parameters = np.broadcast_to(parameters, (len(states), parameters.shape[1]))
        (far, near), reliable = self._differences(states, parameters, shared, budget, distance, False)
        smooth = np.append(self.smooth_states, self.cyclic)
        scale = np.maximum(1.0, np.abs(far[:, smooth]).max(axis=1))
        same = np.abs(far - near)[:, smooth].max(axis=1) <= AGREE * scale
        other = np.abs(far - jacobian[:, :, shared])[:, smooth].max(axis=1) > AGREE * scale
        for run in np.flatnonzero(reliable & same & other):
            jacobian[run, smooth, shared] = far[run, smooth]

    def _differences(
        self, states: np.ndarray, parameters: np.ndarray, column: int, budget: Budget, distance: Any, sided: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """(differences of the map by a state, [pushes, runs, states]; whether their runs finished, [runs]).

        sided: whether no push turns the state's sign
        """
        ahead = np.outer(PUSHES, self.scales(parameters)[:, column])
        state = states[:, column]
        back = np.where(state == 0.0, ahead, np.minimum(ahead, 0.5 * np.abs(state))) if sided else ahead
        starts = np.tile(states, (4, 1, 1))
        starts[:, :, column] += np.where(state < 0.0, -1.0, 1.0) * np.concatenate([ahead, -back])
        times = None if distance is None else np.tile(distance, 4)
        rows = np.tile(parameters, (4, 1))
        ends = self.run(budget, starts.reshape(-1, self.states), rows, order=ORDER, mark_distance=times)
        first, second = ends.state.reshape(2, 2, *states.shape)
        slopes = (first - second) / (starts[:2] - starts[2:])[:, :, column, None]
        return slopes, np.all(ends.finished.reshape(4, -1), axis=0)

    def slopes_along(
        self,
        states: np.ndarray,
        directions: np.ndarray,
        images: np.ndarray,
        parameters: np.ndarray,
        periods: int = 1,
        mark_distance: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """(derivatives [runs, states] along directions, over natural sizes; whether the map has one there [runs]).

        states, directions, images: [runs, states]; parameters: [runs, parameters]
        It has none, as far as differences tell, where those ahead and behind, of a larger and a smaller push, do not
        agree: where a motion grazes, or its sequence of events changes. On the compiled kernel of the tangents, unless
        the equations are too stiff for it.
        """
        runs, n = states.shape
        steps = np.array([sign * push for push in PUSHES for sign in (1.0, -1.0)])
        starts = np.zeros((len(steps), runs, 2 * n))
        starts[:, :, :n] = states + steps[:, None, None] * directions
        rows = np.tile(parameters, (len(steps), 1))
        distance = None if mark_distance is None else np.tile(mark_distance, len(steps))
        budget = Budget(periods, self.tolerance, MOST_EVENTS, MOST_STEPS, window=1)
        recording, width = (self.equations, n) if self.stiff else (variational_equations(self.equations), 2 * n)
        starts = starts[:, :, :width].reshape(-1, width)
        ended = self.run(budget, starts, rows, recording=recording, order=ORDER, mark_distance=distance)
        ends = ended.state.reshape(len(steps), runs, width)[:, :, :n]
        sizes = self.scales(parameters)
        slopes = (ends - images) / steps[:, None, None] / sizes
        mean = slopes.mean(axis=0)
        apart = np.max(np.abs(slopes - mean), axis=(0, 2))
        finished = np.all(ended.finished.reshape(len(steps), runs), axis=0)
        return mean, finished & (apart <= AGREE * np.maximum(1.0, np.max(np.abs(mean), axis=1)))

    def _with_differences(
        self, states: np.ndarray, parameters: np.ndarray, periods: int, distance: np.ndarray | None
    ) -> Images:
        """Images of stiff equations, whose tangents no explicit step follows, with differences as derivatives."""
        budget = Budget(periods, self.tolerance, MOST_EVENTS, MOST_STEPS, evidence=periods)
        ended = self.run(budget, states, parameters, order=ORDER, mark_distance=distance)
        jacobian, finished, free = np.zeros((*states.shape, self.states)), ended.finished, self.free(states, parameters)
        scales = self.scales(parameters)
        for contact in self.equations.contacts:  # one that creeps below the error of the runs falls back at once
            if contact.is_state and not contact.sticks:
                own = contact.state
                free[:, own] &= np.abs(states[:, own]) > self.tolerance * scales[:, own]
        for column in self.section_states[np.any(free[:, self.section_states], axis=0)]:
            images, whole = self._differences(states, parameters, int(column), budget, distance, True)
            known = free[:, column]
            jacobian[:, :, column], finished = images[0] * known[:, None], finished & (whole | ~known)
        if self.cyclic >= 0:
            jacobian[:, self.cyclic, self.cyclic] = 1.0
        return Images(ended.state, jacobian, finished, lambda: self.certified(ended, parameters))

    def mirrored_half(self, states: np.ndarray, parameters: np.ndarray, tangents: bool = True) -> Images:
        """The mirrored state half a drive period later: S P_(T/2), of which symmetric motions are fixed points."""
        half_periods = 0.5 * self.periods(in_rows(parameters, states))
        images = self.images(states, parameters, 1, tangents, mark_distance=half_periods)
        jacobian = None if images.jacobian is None else self.mirror[:, None] * images.jacobian
        return dataclasses.replace(images, state=self.mirror * images.state, jacobian=jacobian)


def in_rows(parameters: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Parameters [runs, parameters] of states [runs, states], from a row for each or one for all."""
    return np.broadcast_to(parameters, (len(states), parameters.shape[-1]))


def is_driven(system: System) -> bool:
    """Whether the equations contain the time; otherwise motions have periods of their own.

    Raises ArgumentError for a controller that rounds what it measures.
    """
    check_smooth(system)
    return equations(system).timed


def named_states(system: System, state: np.ndarray) -> dict[str, float]:
    return dict(zip(system.state_names, map(float, state), strict=True))


def state_vector(system: System, named: Mapping[str, float]) -> np.ndarray:
    """A state vector [states] from its names; those not named are zero."""
    return np.array([float(named.get(name, 0.0)) for name in system.state_names])
