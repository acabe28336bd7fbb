"""A friction law's formulas, recorded once: evaluated on arrays, with exact derivatives; the states that it visits."""

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.laboratory.driven import check_numbers
from vibrocap.numerics.expressions.graph import Expression, Graph, derivative, evaluated
from vibrocap.physics.friction.law import Law


@dataclasses.dataclass(frozen=True, eq=False)
class RecordedLaw:
    """Formulas of one law at one normal load, in which velocity and internal states are symbols.

    force: R; rates: z', one per internal state; stored: energy in the contact; switches, after_switch,
    after_reversal: see `friction.law`. Node ("state", 0) of the graph is the velocity, the internal states follow.
    """

    law: Law
    load: float
    graph: Graph
    force: Expression
    rates: tuple[Expression, ...]
    stored: Expression
    switches: tuple[Expression, ...]
    after_switch: tuple[tuple[Expression, ...], ...]
    after_reversal: tuple[Expression, ...]

    def values(self, expressions: Sequence[Expression], velocity: Any, internal: Any, side: Any) -> np.ndarray:
        """Values [expressions, ...] of formulas at velocities [...] and internal states [states, ...].

        `side` is the direction of sliding, +1 or -1, which a velocity of zero does not tell. What is not defined there
        (a logarithm of zero, for instance) is not finite.
        """
        velocity = np.asarray(velocity, dtype=float)
        internal = np.asarray(internal, dtype=float)
        shape = np.broadcast_shapes(velocity.shape, internal.shape[1:], np.shape(side))
        with np.errstate(all="ignore"):
            return evaluated(expressions, 0.0, [velocity, *internal], side, (), shape)

    @functools.cached_property
    def force_slopes(self) -> tuple[Expression, ...]:
        """dR/dv, then dR/dz for each internal state."""
        return tuple(derivative(self.force, i) for i in range(1 + len(self.rates)))

    @functools.cached_property
    def rate_slopes(self) -> tuple[Expression, ...]:
        """dz'/dv, then dz'/dz, for each internal state in turn: a matrix [states, 1 + states] row by row."""
        return tuple(derivative(rate, i) for rate in self.rates for i in range(1 + len(self.rates)))

    def jacobian(self, velocity: Any, internal: np.ndarray, side: Any) -> np.ndarray:
        """dz'/d(v, z) [states, 1 + states, n] at internal states [states, n]."""
        states, count = internal.shape
        return self.values(self.rate_slopes, velocity, internal, side).reshape(states, 1 + states, count)

    def quickness(self, velocity: Any, internal: np.ndarray, side: Any, sizes: np.ndarray) -> np.ndarray:
        """How fast internal states [states, n] change [n], over themselves and over their natural sizes [states]."""
        slope, rate = self.jacobian(velocity, internal, side)[:, 1:], self.values(self.rates, velocity, internal, side)
        relaxing = np.max(np.abs(slope), axis=(0, 1), initial=0.0)
        return np.maximum(relaxing + np.max(np.abs(rate) / sizes[:, None], axis=0), 1e-300)

    @functools.cached_property
    def storing(self) -> Expression:
        """Rate of the stored energy, the sum of dS/dz z'."""
        total = self.graph.constant(0.0)
        for i, rate in enumerate(self.rates, start=1):
            total = total + derivative(self.stored, i) * rate
        return total

    @functools.cached_property
    def continuous(self) -> np.ndarray:
        """Indices of the internal states that have rates: those that are not whole numbers."""
        return np.array([i for i, name in enumerate(self.law.internal) if name not in self.law.switched], dtype=int)

    def settled_pieces(self, velocity: Any, internal: Any, side: Any) -> np.ndarray:
        """Internal states [states, ...] on the piece of the law that holds; NaN where none is found to."""
        velocity, state = np.asarray(velocity, float), np.asarray(internal, float)
        shape = np.broadcast_shapes(velocity.shape, state.shape[1:], np.shape(side))
        state = np.array(np.broadcast_to(state, (len(state), *shape)))
        open_ = np.ones(shape, bool)
        for _ in range(2 * len(self.switches) + 2):
            guards = self.values(self.switches, velocity, state, side)
            open_ = np.ones(shape, bool)
            for guard, after in zip(guards, self.after_switch, strict=True):
                fallen = open_ & ~(guard >= 0.0)
                if fallen.any():
                    state = np.where(fallen, self.values(after, velocity, state, side), state)
                    open_ &= ~fallen
            if open_.all():
                return state
        state[:, ~open_] = np.nan
        return state

    def turned(self, internal: Any, side: Any, new_side: Any) -> np.ndarray:
        """Internal states [states, ...] after the contact has turned from one side to another (or has not)."""
        after = self.values(self.after_reversal, 0.0, internal, new_side)
        return np.where(np.asarray(side) == new_side, internal, after)


def recorded_law(law: Law, load: float = 1.0) -> RecordedLaw:
    """Record the formulas of a law at one normal load.

    Raises ValueError for what is no law, and for a load that is no positive number.
    """
    if not isinstance(law, Law):
        raise ArgumentError("law", f"should be a friction law such as LuGre(), got {law!r}")
    check_numbers(load=load)
    graph, load = Graph(), float(load)
    velocity, side = graph.node("state", 0), graph.node("side")
    internal = tuple(graph.node("state", 1 + i) for i in range(len(law.internal)))
    force, rates = law.force(velocity, internal, side, load)
    switches = law.switches(velocity, internal, side, load)

    def recorded(values: Sequence[Any]) -> tuple[Expression, ...]:
        return tuple(graph.expression(value) for value in values)

    after = [law.after_switch(which, velocity, internal, side, load) for which in range(len(switches))]
    return RecordedLaw(
        law=law,
        load=load,
        graph=graph,
        force=graph.expression(force),
        rates=recorded(rates),
        stored=graph.expression(law.stored_energy(internal)),
        switches=recorded(switches),
        after_switch=tuple(map(recorded, after)),
        after_reversal=recorded(law.after_reversal(internal, side, load)),
    )


MOTIONS, LEVELS, STEPS = 48, 24, 12  # side by side, levels of velocity of each, steps within a level


def visited_states(recorded: RecordedLaw, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """States [states, n] visited from rest under random levels of velocity, and the side [n] of each.

    speeds: the levels are drawn from these, forward and backward; each is held for a time that is drawn between a
    hundredth and thirty relaxation times of the internal states. The same draw every time.

    Steps are linearly implicit (L-stable, first order): enough to see where states go, not to measure by them.
    """
    states, draw = len(recorded.rates), np.random.default_rng(20)
    size = np.asarray([float(scale) for scale in recorded.law.internal_scales(recorded.load)])
    state, side = np.zeros((states, MOTIONS)), np.ones(MOTIONS)
    visited, sides = [state], [side]
    for _ in range(LEVELS):
        turn = draw.choice([-1.0, 1.0], MOTIONS)
        velocity = turn * draw.choice(speeds, MOTIONS)
        state, side = recorded.turned(state, side, turn), turn
        state = recorded.settled_pieces(velocity, state, side)
        duration = 10.0 ** draw.uniform(-2.0, 1.5, MOTIONS) / recorded.quickness(velocity, state, side, size)
        for share in np.diff(np.geomspace(1e-3, 1.0, STEPS + 1), prepend=0.0):
            state = implicit_euler(recorded, velocity, state, side, share * duration)
            state = recorded.settled_pieces(velocity, state, side)
            visited.append(state)
            sides.append(side)
    every, where = np.concatenate(visited, axis=1), np.concatenate(sides)
    finite = np.all(np.isfinite(every), axis=0)
    return every[:, finite], where[finite]


def implicit_euler(recorded: RecordedLaw, velocity, state, side, step) -> np.ndarray:
    """Internal states [states, n] a step [n] later, at constant velocity, by (1 - h J) dz = h z'.

    Where that is not finite the state stays.
    """
    states, rate = len(state), recorded.values(recorded.rates, velocity, state, side)
    slopes = recorded.jacobian(velocity, state, side)[:, 1:]
    matrix = np.eye(states)[:, :, None] - step * slopes
    good = np.all(np.isfinite(matrix), axis=(0, 1)) & np.all(np.isfinite(rate), axis=0)
    if states == 1:
        change = (step * rate[0] / np.where(good, matrix[0, 0], 1.0))[None]
    else:
        matrix = np.where(good, matrix, np.eye(states)[:, :, None])
        change = np.linalg.solve(np.moveaxis(matrix, 2, 0), (step * np.where(good, rate, 0.0)).T[:, :, None])[:, :, 0].T
    after = state + change
    return np.where(good & np.all(np.isfinite(after), axis=0), after, state)
