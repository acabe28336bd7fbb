"""States whose rates vanish: the equations with exact derivatives, and the search from many starts in every mode."""

import dataclasses
import functools
import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.expressions.graph import Expression, derivative, evaluate, evaluated, sensitivity
from vibrocap.orbits.maps.closing_map import recorded_with
from vibrocap.orbits.maps.stroboscopic_map import is_driven
from vibrocap.physics.system import System

PASSES = 12  # over rows and columns, until both are of one size


def balanced(matrix: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(derivative [..., rows, unknowns] with rows and columns of one size, sizes of the rows, units of the unknowns).

    So rank and shortest step depend on no unit, nor on natural sizes decades from those of a state (Ruiz 2001).
    """
    even = matrix * sizes
    rows, units = np.ones(matrix.shape[:-1]), np.ones(matrix.shape[:-2] + matrix.shape[-1:]) * sizes
    for _ in range(PASSES):
        high, wide = (np.sqrt(np.max(np.abs(even), axis=axis, initial=0.0)) for axis in (-1, -2))
        high, wide = np.where(high > 0.0, high, 1.0), np.where(wide > 0.0, wide, 1.0)
        even = even / high[..., None] / wide[..., None, :]
        rows, units = rows * high, units / wide
    return even, rows, units


class SteadyEquations:
    """Rates of one form of system as functions of its states, in a mode that the sides of its contacts say.

    unknowns: numbers of the states whose rates vanish: all but the cyclic one, which travels, and those that are
    switched at events. Arrays of states are [unknowns, ...], of sides [contacts, ...]; a contact at rest has the side 0
    where its law is set-valued. `path` names a parameter by which derivatives are wanted, too.
    """

    def __init__(self, system: System, path: str | None = None):
        """Raises ArgumentError for a system that is driven in time."""
        if is_driven(system):
            waves = " and ".join(wave.name for wave in (system.drive, *system.drives))
            text = f"should not be driven in time, as by waveforms that are {waves}"
            raise ArgumentError("system", f"{text}: it has no equilibria; orbit(system) finds its steady motions")
        self.system = system
        recorded = system if path is None else recorded_with(system, path)
        self.recording = equations(recorded)
        self.graph, self.path = self.recording.graph, path
        # One of another form keeps the row of its own: the parameter is put in before anything is evaluated.
        self.row = np.array(parameter_values(recorded))
        self.index = -1 if path is None else self.recording.parameter_paths.index(path)
        if path is not None:
            self.row[self.index] = float(system.parameter(path))
        names, aside = system.state_names, {*system.switched, recorded.cyclic}
        self.unknowns = np.array([i for i, name in enumerate(names) if name not in aside], dtype=int)
        self.sizes = np.array(evaluate(self.recording.scales, 0.0, [0.0] * len(names), 1.0, self.row), dtype=float)
        self.sizes = np.where(self.sizes > 0.0, self.sizes, 1.0)
        self.rates = tuple(self.recording.rates[i] for i in self.unknowns)
        self.velocities = tuple(contact.velocity for contact in self.recording.contacts)
        self._jacobian = self._slopes(self.rates)
        self._velocity_slopes = self._slopes(self.velocities)

    def _slopes(self, expressions: Sequence[Expression]) -> tuple[Expression, ...]:
        return tuple(derivative(expression, int(k)) for expression in expressions for k in self.unknowns)

    @property
    def scales(self) -> np.ndarray:
        return self.sizes[self.unknowns]

    def states(self, y: np.ndarray, switched: np.ndarray) -> list:
        """All states, of unknowns [unknowns, ...] and switched states [states, ...], the cyclic one at 0."""
        columns = [np.broadcast_to(number, y.shape[1:]) for number in switched]
        for place, value in zip(self.unknowns, y, strict=True):
            columns[place] = value
        return columns

    def values(
        self, expressions: Sequence[Expression], y: np.ndarray, sides: np.ndarray, switched: np.ndarray, row: Any = None
    ) -> np.ndarray:
        """Values [expressions, ...] of recorded expressions; what is not defined there is not finite."""
        row, shape = self.row if row is None else row, y.shape[1:]
        # Nothing depends on the time. Sides of several contacts are a tuple.
        side = tuple(np.broadcast_to(side, shape).astype(float) for side in sides)
        with np.errstate(all="ignore"):
            return evaluated(expressions, 0.0, self.states(y, switched), side, row, shape)

    def jacobian(self, y: np.ndarray, sides: np.ndarray, switched: np.ndarray, row: Any = None) -> np.ndarray:
        """Derivative of the rates by the states, [unknowns, unknowns, ...]."""
        n = len(self.unknowns)
        return self.values(self._jacobian, y, sides, switched, row).reshape(n, n, *y.shape[1:])

    @functools.cached_property
    def _curvatures(self) -> tuple[Expression, ...]:
        """Second derivatives of the rates by the states: of each entry of the Jacobian by each unknown."""
        return self._slopes(self._jacobian)

    @functools.cached_property
    def _parameter_slopes(self) -> tuple[Expression, ...]:
        """Derivatives by the parameter: of the rates, then of the entries of the Jacobian."""
        node = self.graph.node("parameter", self.index)
        return tuple(sensitivity(expression, node.index) for expression in (*self.rates, *self._jacobian))


STARTS = 48  # in each mode
MOST_MODES = 243  # beyond, all contacts slide to one side or all rest
MOST_STEPS = 120
CLOSED = 1e-9  # share of a state that the last step of Newton's method may still change
ROUNDED = 1e-15  # natural sizes below which a state is zero
ROUNDINGS = 16.0  # rounding errors of one evaluation of the rates, over the product of their terms with eps
GUARDED = 1e-9  # value of a guard down to which its branch of the equations holds
STANDS = 1e-14  # speed over its natural size and the ground's below which a contact is at rest
FARTHEST = 1e6  # natural sizes within which equilibria are looked for
SAME = 1e-7  # distance over natural sizes within which two states are one
RANK = 1e-9  # singular value over the largest, of rows and columns of one size, that counts as zero


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyState:
    """A state whose rates vanish in a mode.

    y: [unknowns]; sides, rests: [contacts]; switched: [states], whole numbers where the equations have branches
    directions: [unknowns, dimension] along which the rates stay zero
    """

    y: np.ndarray
    sides: np.ndarray
    rests: np.ndarray
    switched: np.ndarray
    directions: np.ndarray

    @property
    def dimension(self) -> int:
        """Of the set of states of which it is one."""
        return self.directions.shape[1]


def steady_states(problem: SteadyEquations) -> list[SteadyState]:
    """States whose rates vanish, in all modes; of a set of them those that Newton's method meets.

    A contact at rest need not be held by what friction it has: that is looked at where sets of rest are made.
    Starts are spread over eight decades, the same ones every time. A start of its own for every solution is no
    certainty: of equations with very many solutions some may be missed.
    """
    modes = _modes(problem)
    sides = np.repeat(np.array([[side for side, _ in mode] for mode in modes]).T, STARTS, axis=1)
    rests = np.repeat(np.array([[rest for _, rest in mode] for mode in modes]).T, STARTS, axis=1)
    switched = np.zeros((len(problem.system.state_names), sides.shape[1]))
    y = _starts(problem, sides, rests)
    for _ in range(1 + 2 * len(problem.recording.switches)):
        y = solved(problem, y, sides, rests, switched)
        after = _on_their_branch(problem, y, sides, switched)
        if np.array_equal(after, switched):
            break
        switched = after
    states: list[SteadyState] = []
    y = _tidied(problem, y, rests)
    good = _newton_step(problem, y, sides, rests, switched)[2] & _valid(problem, y, sides, rests, switched)
    for lane in np.flatnonzero(good):
        at = y[:, lane], sides[:, lane], rests[:, lane], switched[:, lane]
        state = SteadyState(*at, directions=free_directions(problem, *at))
        if not any(_alike(problem, state, other) for other in states):
            states.append(state)
    return states


def _modes(problem: SteadyEquations) -> list[tuple[tuple[float, bool], ...]]:
    """(side, whether it rests) of all contacts, in each mode."""
    choices = []
    for contact in problem.recording.contacts:
        resting = [(0.0 if contact.sticks else 1.0, True)] if contact.kind != "smooth" else []
        choices.append([(1.0, False), *([(-1.0, False)] if contact.kind != "smooth" else []), *resting])
    if np.prod([float(len(choice)) for choice in choices]) <= MOST_MODES:
        return list(itertools.product(*choices))
    return [tuple(choice[min(i, len(choice) - 1)] for choice in choices) for i in range(3)]


def _starts(problem: SteadyEquations, sides: np.ndarray, rests: np.ndarray) -> np.ndarray:
    """Where Newton's method starts, [unknowns, lanes]: spread over many sizes; contacts slide the way of their mode."""
    draw, shape = np.random.default_rng(11), (len(problem.unknowns), sides.shape[1])
    sizes = 10.0 ** draw.uniform(-4.0, 2.0, shape)
    y = problem.scales[:, None] * sizes * draw.choice([-1.0, 1.0], shape)
    y[:, ::STARTS] = 0.0
    places = {int(state): i for i, state in enumerate(problem.unknowns)}
    for i, contact in enumerate(problem.recording.contacts):
        if contact.is_state and contact.state in places:
            k = places[contact.state]
            y[k] = np.where(rests[i], 0.0, np.where(sides[i] == 0.0, 1.0, sides[i]) * np.maximum(np.abs(y[k]), 1e-9))
    return y


def _stacked(problem: SteadyEquations, y, sides, rests, switched) -> tuple[np.ndarray, np.ndarray]:
    """(rates and the velocities of contacts at rest [rows, lanes], their derivative [lanes, rows, unknowns])."""
    rates = problem.values(problem.rates, y, sides, switched)
    slopes = problem.jacobian(y, sides, switched)
    velocities = problem.values(problem.velocities, y, sides, switched) * rests
    still = problem.values(problem._velocity_slopes, y, sides, switched).reshape(len(velocities), *slopes.shape[1:])
    return np.concatenate([rates, velocities]), np.moveaxis(np.concatenate([slopes, still * rests[:, None]]), 2, 0)


def solved(problem: SteadyEquations, y, sides, rests, switched) -> np.ndarray:
    """States [unknowns, lanes] after Newton's method, halved while it does not reduce the residual; NaN where lost."""
    y, share = y.copy(), np.ones(y.shape[1])
    merit, step = _newton_step(problem, y, sides, rests, switched)[:2]
    for _ in range(MOST_STEPS):
        if np.all(np.abs(step) <= 1e-16 * (problem.scales[:, None] + np.abs(y))):
            break
        trial = y + share * step
        solution, following = _newton_step(problem, trial, sides, rests, switched)[:2]
        better = solution <= merit * (1.0 - 0.1 * share)
        y, step = np.where(better, trial, y), np.where(better, following, step)
        merit = np.where(better, solution, merit)
        share = np.where(better, np.minimum(1.0, 4.0 * share), 0.5 * share)
        if np.all(share < 1e-6):
            break
    return y


@np.errstate(all="ignore")  # wild starts
def _newton_step(problem: SteadyEquations, y, sides, rests, switched) -> tuple[np.ndarray, ...]:
    """(length of the rates [lanes], step [unknowns, lanes], whether the step is rounding and leaves nothing [lanes]).

    The step is the shortest that solves a lane as well as can be. The length is infinite where rates or derivatives are
    not finite.
    """
    rates, matrix = _stacked(problem, y, sides, rests, switched)
    even, rows, units = balanced(matrix, problem.scales)
    good = np.all(np.isfinite(even), axis=(1, 2)) & np.all(np.isfinite(rates), axis=0)
    rates, matrix = np.where(good, rates, 0.0).T, np.where(good[:, None, None], matrix, 0.0)
    even = np.where(good[:, None, None], even, 0.0)
    inverse = np.linalg.pinv(even, rcond=RANK) * units[:, :, None] / rows[:, None]
    step = -(inverse @ rates[:, :, None])[:, :, 0]
    terms = np.abs(matrix) @ np.abs(y.T)[:, :, None]
    rounding = ROUNDINGS * np.finfo(float).eps * (np.abs(inverse) @ terms)[:, :, 0] + ROUNDED * problem.scales
    slack = CLOSED * np.abs(y.T) + rounding
    left = np.abs(rates + (matrix @ step[:, :, None])[:, :, 0]) <= (np.abs(matrix) @ slack[:, :, None])[:, :, 0]
    closed = np.all(np.abs(step) <= slack, axis=1) & np.all(left, axis=1)
    return np.where(good, np.linalg.norm(rates, axis=1), np.inf), step.T, good & closed


def _tidied(problem: SteadyEquations, y: np.ndarray, rests: np.ndarray) -> np.ndarray:
    """States without rounding where they are zero, and within a turn where they turn."""
    y = np.where(np.abs(y) <= ROUNDED * problem.scales[:, None], 0.0, y)
    places = {int(state): i for i, state in enumerate(problem.unknowns)}
    for contact, rest in zip(problem.recording.contacts, rests, strict=True):
        if contact.is_state and contact.state in places:
            y[places[contact.state]] = np.where(rest, 0.0, y[places[contact.state]])
    for state, turn in problem.recording.turns:
        if state in places:
            y[places[state]] -= turn * np.ceil(y[places[state]] / turn - 0.5 - SAME)
    return y


def _on_their_branch(problem: SteadyEquations, y, sides, switched) -> np.ndarray:
    """Switched states [states, lanes] after the first guard of each lane that is negative has been passed."""
    if not problem.recording.switches:
        return switched
    guards = problem.values(problem.recording.switches, y, sides, switched)
    after, done = switched.copy(), np.zeros(y.shape[1], dtype=bool)
    places = [i for i, name in enumerate(problem.system.state_names) if name in problem.system.switched]
    for guard, states in zip(guards, problem.recording.after_switch, strict=True):
        fallen = (guard < 0.0) & ~done
        done |= fallen
        values = problem.values([states[i] for i in places], y, sides, switched)
        for i, value in zip(places, values, strict=True):
            after[i] = np.where(fallen, value, after[i])
    return after


def _valid(problem: SteadyEquations, y, sides, rests, switched) -> np.ndarray:
    """Which lanes are in their mode: contacts slide the way that it says, and the equations hold."""
    recording = problem.recording
    velocities = problem.values(problem.velocities, y, sides, switched)
    good = np.all(np.isfinite(velocities), axis=0) & np.all(np.abs(y.T) <= FARTHEST * problem.scales, axis=1)
    places = {int(state): problem.sizes[state] for state in problem.unknowns}
    for velocity, side, rest, contact in zip(velocities, sides, rests, recording.contacts, strict=True):
        if contact.kind != "smooth":
            good &= rest | (side * velocity > STANDS * places.get(contact.state, 1.0))
    for rest, contact in zip(rests, recording.contacts, strict=True):  # a contact at rest that ages is none
        internal = [recording.rates[i] for i in contact.internal]
        if internal and contact.kind == "kinked":
            good &= ~rest | np.all(problem.values(internal, y, sides, switched) == 0.0, axis=0)
    for name in problem.system.placed.locked:  # at a stop, or a limit, another equation holds its state
        good &= switched[problem.system.state_names.index(name)] == 0.0
    good &= np.all(problem.values(recording.switches, y, sides, switched) >= -GUARDED, axis=0)
    return good & np.all(problem.values(recording.bounds, y, sides, switched) > 0.0, axis=0)


def free_directions(problem: SteadyEquations, y, sides, rests, switched) -> np.ndarray:
    """[unknowns, dimension]: along which the rates stay zero, over natural sizes."""
    lane = (y[:, None], sides[:, None], rests[:, None], switched[:, None])
    _, matrix = _stacked(problem, *lane)
    even, _, units = balanced(matrix[0], problem.scales)
    _, values, vectors = np.linalg.svd(even)
    rank = int(np.sum(values > RANK * max(values[0], 1e-300))) if len(values) else 0
    return vectors[rank:].T * (units / problem.scales)[:, None]


def _alike(problem: SteadyEquations, one: SteadyState, other: SteadyState) -> bool:
    """Whether two solutions are one, or lie in one set."""
    same = np.array_equal(one.sides, other.sides) and np.array_equal(one.rests, other.rests)
    if not (same and np.array_equal(one.switched, other.switched) and one.dimension == other.dimension):
        return False
    size = np.maximum(np.abs(one.y), np.abs(other.y))
    return bool(np.all(np.abs(one.y - other.y) <= SAME * size + STANDS * problem.scales))
