"""The equations of a system as they are recorded: what all writers and runs of the numerics are given."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np

from vibrocap.numerics.expressions.corners import Corners
from vibrocap.numerics.expressions.graph import Expression, Graph, depends_on_time, derivative, evaluate, sensitivity

POINTS = 5  # at which the balance is compared with the equations


@dataclasses.dataclass(frozen=True, eq=False)
class ContactEquations:
    """Recorded equations of one contact.

    velocity: of sliding; state: number of the state that moves one to one with it; kind: "set-valued" (it can rest),
    "kinked" or "smooth"; hold: the force that would hold it in the present modes of all others, over the middle of what
    it can hold; limit: how far that reaches (both None where it cannot rest); internal: numbers of the states of its
    law, without those that change at events only; after_reversal: all states after it has turned to its side
    """

    velocity: Expression
    state: int
    kind: str
    hold: Expression | None
    limit: Expression | None
    internal: tuple[int, ...]
    after_reversal: tuple[Expression, ...]

    @property
    def sticks(self) -> bool:
        """Whether it can rest."""
        return self.hold is not None

    @property
    def is_state(self) -> bool:
        """Whether its velocity is one of the states, whose series is then its own."""
        return self.velocity.index == self.velocity.graph.node("state", self.state).index


@dataclasses.dataclass(frozen=True, eq=False)
class DecisionRows:
    """The problem of several contacts at rest, recorded: see `physics/contacts.py`, and what each may take.

    b [n], response [n n], loads [n], load_response [n n] (none of constant loads); of each contact, as taken by the
    machine: force while it slides (per load), what pushes it then and at rest, least and most that it can hold, and
    least and most once it has given way (per load; None where it cannot rest)
    """

    b: tuple[Expression, ...]
    response: tuple[tuple[Expression, ...], ...]
    loads: tuple[Expression, ...]
    load_response: tuple[tuple[Expression, ...], ...]
    forces: tuple[Expression, ...]
    pushes: tuple[tuple[Expression, ...], ...]
    bounds: tuple[tuple[Expression, ...] | None, ...]

    @property
    def alike(self) -> tuple[int, ...]:
        """Of each contact the first that answers to all friction as it does, so that their distance is imposed."""
        rows = [tuple(entry.index for entry in row) for row in self.response]
        return tuple(map(rows.index, rows))

    @property
    def groups(self) -> tuple[int, ...]:
        """Of each contact the first of those with which the friction of one on another connects it."""
        found = list(range(len(self.b)))
        for answers in (self.response, self.load_response):
            for i, row in enumerate(answers):
                for j, entry in enumerate(row):
                    if entry.value != 0.0:
                        found = [min(found[i], found[j]) if each in (found[i], found[j]) else each for each in found]
        return tuple(found)


@dataclasses.dataclass(frozen=True, eq=False)
class NormalBalance:
    """load = mean + momentum', normal to the ground.

    moving, at_rest: the load as a function of the state, while the contact slides and where it rests
    """

    momentum: Expression
    mean: Expression
    moving: Expression
    at_rest: Expression


@dataclasses.dataclass(frozen=True, eq=False)
class Balance:
    """The balance of momentum, which gives the acceleration of the contact by few products.

    Solved for the acceleration a of the contact, the equations of a machine are fractions of products of series. The
    same acceleration follows from its momentum p, whose rate is the force from outside less friction,

        (p)_(k+1) (k+1) = F_k - R_k

    where all of (p)_(k+1) is known but for a_k, which stands in it with one and the same factor d at every order: that
    of the highest derivatives in the rate of p. So a_k = (F_k - R_k - what (p)_(k+1) (k+1) is without a_k)/d, one
    division per step. Without R, that numerator is the series of the force that holds a resting contact.

    A normal load that the motion makes follows likewise from the momentum q normal to the ground, N = mean + q'. Its
    coefficient N_k contains a_k with a factor e, and so does R_k with r e, r the slope of R by N:
    the divisor is d + r e.

    friction: while the contact slides; share: 1 where it slides, 0 where it sticks; middle: of the forces that the
    contact can hold at rest, None where it is a number; normal: of a load that the motion makes, or None
    """

    momentum: Expression
    outer: Expression
    friction: Expression
    share: Expression
    middle: Expression | None
    acceleration: Expression
    normal: NormalBalance | None = None

    def inertia(self, rates: Sequence[Expression]) -> Expression:
        """d + r e."""
        result = self.slope(self.momentum, rates)
        if self.normal is not None:
            share = sensitivity(self.friction, self.normal.moving.index)
            result = result + share * self.slope(self.normal.momentum, rates)
        return result

    def slope(self, momentum: Expression, rates: Sequence[Expression]) -> Expression:
        """Slope of the rate of a momentum with respect to the acceleration."""
        result = self.acceleration.graph.constant(0.0)
        for i, rate in enumerate(rates):
            result = result + derivative(momentum, i) * sensitivity(rate, self.acceleration.index)
        return result

    def holds(self, rates: Sequence[Expression], parameters: int) -> bool:
        """Whether the balance agrees with the equations, at a few points drawn at random, while the contact slides."""
        draw = np.random.default_rng(0)
        states, values = draw.uniform(0.1, 0.9, (len(rates), POINTS)), draw.uniform(0.5, 1.5, (parameters, POINTS))
        time = draw.uniform(0.1, 0.9, POINTS)
        pairs = [(rate_of(self.momentum, rates), self.outer - self.friction)]
        if self.normal is not None:
            pairs.append((self.normal.mean + rate_of(self.normal.momentum, rates), self.normal.moving))
        sides = [side for pair in pairs for side in pair]
        with np.errstate(all="ignore"):
            *values, inertia = evaluate([*sides, self.inertia(rates)], time, states, 1.0, values)
        close = all(
            np.all(np.abs(left - right) <= 1e-9 * (1.0 + np.abs(left) + np.abs(right)))
            for left, right in zip(values[::2], values[1::2], strict=True)
        )
        return bool(close and np.all(np.abs(inertia) > 0.0))


def rate_of(momentum: Expression, rates: Sequence[Expression]) -> Expression:
    """Rate of a function of time and state."""
    found = derivative(momentum, -1)
    for i, rate in enumerate(rates):
        found = found + derivative(momentum, i) * rate
    return found


@dataclasses.dataclass(frozen=True, eq=False)
class Equations:
    """Recorded equations of all systems of one form; their numbers are in the parameter vector.

    rates: y' per state; integrals: rates of the quantities carried along (energy channels, then the impulse of
    friction).
    """

    graph: Graph
    state_names: tuple[str, ...]
    integral_names: tuple[str, ...]
    parameter_paths: tuple[str, ...]
    rates: tuple[Expression, ...]
    integrals: tuple[Expression, ...]
    scales: tuple[Expression, ...]
    contacts: tuple[ContactEquations, ...]  # the first one before the others
    rows: DecisionRows | None  # of several contacts
    # at imposed distances, the velocity of each contact less the state that all share: functions of time
    shifts: tuple[Expression, ...]
    cyclic_state: int  # -1: none
    turns: tuple[tuple[int, float], ...]  # states that turn, each with its period
    symmetry: tuple[int, ...]  # sign of each state under the half-period symmetry
    period: Expression
    switches: tuple[Expression, ...]  # guards of the branches of the law, then of the machine
    law_switches: int  # how many of them are the laws'
    impact: int  # place among the integrals of the work of impacts; -1: there is none
    loads: tuple[Expression, ...]  # normal load of a contact that slips and of one at rest; none if it is constant
    quotients: tuple[Expression, ...]  # of contacts that act on one another, whose divisors are bounds
    bounds: tuple[Expression, ...]  # positive while the equations hold; a run ends where one of them is not
    bound_kinds: tuple[int, ...]  # number of each bound among those that there are
    located: tuple[bool, ...]  # of each bound: whether the run ends at the very instant, or at the start of a step
    after_switch: tuple[tuple[Expression, ...], ...]  # states, per guard
    maybe_stiff: bool  # whether a contact has a law with a force for every velocity
    observables: dict[str, Expression]
    base: int  # states of the motion itself; tangents may follow them
    balance: Balance | None  # of momentum, where it gives the acceleration of the contact
    guard_tangents: tuple[Expression, ...] = ()  # how the guards grow along the tangent
    corners: Corners | None = None  # of the drive; its present segment stands behind the other parameters
    true_load: Expression | None = None  # what the ground would have to give, where the load is held constant
    # (h, sign): that load is a constant and sign h'', where it follows from a height h.
    normal_height: tuple[Expression, float] | None = None

    @property
    def timed(self) -> bool:
        """Whether they contain the time; otherwise motions have periods of their own."""
        return self.corners is not None or depends_on_time(self.rates)

    @property
    def several(self) -> bool:
        """Whether there are several contacts."""
        return len(self.contacts) > 1

    @property
    def coupled(self) -> bool:
        """Whether friction at one contact accelerates another."""
        rows = () if self.rows is None else self.rows.response
        return any(entry.value != 0.0 for i, row in enumerate(rows) for entry in (*row[:i], *row[i + 1 :]))

    @property
    def imposed(self) -> tuple[ContactEquations, ...]:
        """Contacts whose velocities are no states."""
        return tuple(each for each in self.contacts if not each.is_state)

    @property
    def guards(self) -> tuple[Expression, ...]:
        """Of the branches of law and machine, then the bounds: a step ends where one of them falls to zero."""
        return (*self.switches, *self.bounds)

    def filled(self, parameters: Any, time: Any = 0.0) -> Any:
        """Parameter vectors with the segment of the drive at a time since the start of its period, where it has any."""
        if self.corners is None or not np.size(parameters):  # no drive that has corners, or no run
            return parameters
        return self.corners.filled(parameters, time)
