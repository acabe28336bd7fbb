"""Motions of machines on any number of contacts, by SciPy, and the decision of their modes by trying all 3^n of them.

What it takes of the package are the formulas of the parts alone: rates of a machine given all friction forces, its
contact velocities and loads, forces of its laws, the value of its drive. Which of its contacts rest, to which side the
others slide, and when that changes, is found anew:

- a mode is a side for every contact (0: rests). As all is affine in the friction forces R, which are R = rho N where a
  contact slides and leave it without acceleration where it rests, they follow from one linear problem, whose matrix is
  read off the rates. Where contacts at imposed distances rest together only what they hold together is determined; each
  takes the same share of its range;
- between events DOP853 follows the motion of one mode to 1e-12. Zeros of the velocities of those that slide, and of
  what is to spare of those that rest, are bracketed on its dense output and polished on real steps;
- at an event, a corner and at the start all modes of the contacts at rest are tried, with the series of the motion in
  each of them: that of a contact which begins to slide must move it to its side, that of one which rests must leave its
  force within what it holds, in the first order in which it is not zero.

At rest a contact holds more than while it slides. So a trial takes the static limits; who slides in it has given way
and is tried again as a slider (those that came from a slide first, for they pass), until nobody else gives way.
"""

import dataclasses
import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.integrate import DOP853
from scipy.optimize import brentq, minimize_scalar

from jets import Jet
from vibrocap.physics.drives.drive import Piecewise, segment_in_time, segment_table
from vibrocap.physics.drives.loadings import Ramp

ORDERS = 7  # of the series in which modes are told apart
ROUNDING = 1e-9  # of what is zero in them, over the largest acceleration or force
STILL = 1e-10  # speed of contacts that come to rest together with another
CLEAR = 1e-12  # of a guard that began at zero
SAMPLES, STEPS_PER_PERIOD = 8, 40
EXACT = (1e-12, 1e-13)  # rtol, atol


class Undecided(Exception):
    """None or several of the modes can go on; they are its argument."""


# --- modes as numbers -------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Problem:
    """Contacts at one instant: a = free - response R, N = loads - raised R; forces over N, and of all contacts.

    sliding: of those that move; least, most: what the others hold at rest; down, up: with which they begin to slide
    """

    free: np.ndarray
    response: np.ndarray
    loads: np.ndarray
    raised: np.ndarray
    sliding: np.ndarray
    least: np.ndarray
    most: np.ndarray
    down: np.ndarray
    up: np.ndarray

    def bound(self, i: int, side: int, gave: Sequence[int] | set[int]) -> float:
        """Force over load of contact i where it leaves rest."""
        if i in gave:
            return self.up[i] if side > 0 else self.down[i]
        return self.most[i] if side > 0 else self.least[i]

    def drops(self, i: int) -> bool:
        """Whether contact i holds more at rest than as it begins to slide."""
        little = ROUNDING * (self.most[i] - self.least[i])
        return bool(self.most[i] > self.up[i] + little or self.least[i] < self.down[i] - little)

    @property
    def sizes(self) -> tuple[float, float]:
        """(acceleration, force) below which all is rounding."""
        forces = np.concatenate([(self.most - self.least) * self.loads, self.sliding * self.loads])
        force = float(np.max(np.abs(forces)))
        return ROUNDING * (float(np.max(np.abs(self.free))) + force * float(np.max(np.abs(self.response)))), (
            ROUNDING * (force or 1.0)
        )


def solved(
    response: np.ndarray, free: np.ndarray, rests: np.ndarray, rows: np.ndarray, right: np.ndarray, middle, width
):
    """R of the rows of those that slide, and of no acceleration of those that rest, by least distance from middles."""
    n = len(rests)
    matrix, target = np.where(rests[:, None], response, rows), np.where(rests, free, right)
    held = np.flatnonzero(rests)
    singular = len(held) > 1 and np.linalg.matrix_rank(response[np.ix_(held, held)], tol=1e-9 * np.max(response)) < len(
        held
    )
    if not singular:
        return np.linalg.solve(matrix, target)
    slides = np.flatnonzero(~rests)
    force = np.zeros(n)  # its loads are constants: what slides is known
    force[slides] = np.linalg.solve(matrix[np.ix_(slides, slides)], target[slides]) if len(slides) else 0.0
    spread = np.sqrt(width[held])
    left = free[held] - response[np.ix_(held, slides)] @ force[slides] - response[np.ix_(held, held)] @ middle[held]
    shares = np.linalg.pinv(response[np.ix_(held, held)] * spread, rcond=1e-9) @ left
    force[held] = middle[held] + spread * shares
    return force


def consistent(problem: Problem, rest: Sequence[int], gave: set[int]) -> Iterator[tuple[tuple[int, ...], set[int]]]:
    """Every set of sides of the contacts `rest` that this order allows, with those of them that it leaves open."""
    n = len(problem.free)
    tiny, little = problem.sizes
    choices = [(0, 1, -1) if problem.most[i] > problem.least[i] else (1, -1) for i in rest]
    for sides in itertools.product(*choices):
        rests, level = np.zeros(n, bool), problem.sliding.copy()
        for i, side in zip(rest, sides, strict=True):
            rests[i] = side == 0
            level[i] = problem.bound(i, side, gave)
        middle = np.array([0.5 * (problem.bound(i, 1, gave) + problem.bound(i, -1, gave)) for i in range(n)])
        width = np.array([0.5 * (problem.bound(i, 1, gave) - problem.bound(i, -1, gave)) for i in range(n)])
        rows = np.eye(n) + level[:, None] * problem.raised
        try:
            force = solved(
                problem.response,
                problem.free,
                rests,
                rows,
                level * problem.loads,
                middle * problem.loads,
                width * problem.loads,
            )
        except np.linalg.LinAlgError:
            continue
        rates, loads = problem.free - problem.response @ force, problem.loads - problem.raised @ force
        open_, fits = set(), True
        for i, side in zip(rest, sides, strict=True):
            if side == 0:
                spare = min(
                    problem.bound(i, 1, gave) * loads[i] - force[i], force[i] - problem.bound(i, -1, gave) * loads[i]
                )
                fits &= spare >= -little and abs(rates[i]) <= tiny
                if spare <= little:
                    open_.add(i)
            else:
                fits &= side * rates[i] >= -tiny
                if side * rates[i] <= tiny:
                    open_.add(i)
        if fits:
            yield sides, open_


def decided(
    problem: Problem, asked: Sequence[int], came: set[int], before: Mapping[int, int], lasts: Any = None
) -> dict[int, int]:
    """Side of every contact that is `asked` as it is at rest, by enumeration, those that give way asked again.

    came: those that slid until now; before: sides until now, which kinked contacts keep that do not move at all
    lasts: (whether a mode lasts for an instant, in which order each slider leaves), given the sides by contact and who
        gave way, where forces alone leave it open; without it those rest that do not have to slide
    Raises Undecided where none or several of the modes can go on.
    """
    gave: set[int] = set()
    kinked = {i for i in asked if problem.most[i] <= problem.least[i]}
    while True:
        values = []
        for sides, open_ in consistent(problem, asked, gave):
            tried = dict(zip(asked, sides, strict=True))
            left = dict.fromkeys((i for i in asked if tried[i]), 0)
            if open_ and lasts is not None:
                fits, left = lasts(tried, gave)
                if not fits:
                    continue
            elif any(tried[i] for i in open_ - kinked):
                continue  # it would not move
            values.append((tried, left, open_ & kinked))
        if len(values) > 1:
            kept = [value for value in values if all(value[0][i] == before[i] for i in value[2])]
            values = kept if len(kept) == 1 else values
        if len(values) != 1:
            raise Undecided([tuple(each.values()) for each, *_ in values])
        sides, left, _ = values[0]
        new = {i for i in asked if i not in kinked | gave and sides[i]}
        first = min((left[i] for i in new if problem.drops(i)), default=None)
        if first is None:
            return sides
        new = {i for i in new if left[i] <= first}
        gave |= (new & came) or new


# --- a system as what is asked above ----------------------------------------------------------------------------------


class Mechanics:
    """The formulas of a system in one segment of its drive, times from the start of the period.

    y: states of the machine, then those of the law of each contact, `names`
    """

    def __init__(self, system: Any, drive: Any):
        self.system, self.drive, self.around = system, drive, system.environment
        machine = system.machine.driven_by(drive)
        self.machine = machine = machine if self.around is None else self.around.placed(machine)
        self.laws = system.laws
        self.follows = machine.follows_load
        self.constant_loads = None if self.follows else machine.loads()
        self.names, self.own = list(machine.states), []
        for number, law in enumerate(self.laws, start=1):
            first = len(self.names)
            self.names += [name if number == 1 else f"{name}_{number}" for name in law.internal]
            self.own.append(slice(first, len(self.names)))
        self.contacts, self.states = len(self.laws), len(machine.states)
        self.places = [machine.states.index(name) for name in machine.contact_states]
        self.sticks = [law.kind == "set-valued" for law in self.laws]
        self.turns = [law.kind != "smooth" or self.around is not None for law in self.laws]
        draw = np.random.default_rng(0)
        self._response = None
        if not self.follows:
            responses = [
                self._responses(0.3 * drive.period, draw.uniform(-0.1, 0.1, len(self.names)).tolist()) for _ in "ab"
            ]
            if np.array_equal(*(np.round(response[0], 14) for response in responses)):
                self._response = responses[0]

    def velocities(self, t, y) -> list:
        """Of all contacts."""
        if not self.machine.imposes_motion:
            return [y[place] for place in self.places]
        return [contact.velocity for contact in self.machine.contacts(t, tuple(y[: self.states]), 0.0)]

    def rates(self, t, y, taken) -> list:
        """Of the states of the machine; taken: in the place of friction."""
        return list(self.machine.rates(t, tuple(y[: self.states]), self.drive.value(t), tuple(taken)))

    def loads(self, t, y, taken) -> list:
        """N of all contacts where it follows the motion; else 1, and all that is said of loads is said of forces."""
        if not self.follows:
            return [1.0] * self.contacts
        mechanical, drive = tuple(y[: self.states]), self.drive.value(t)
        return [
            own + sum(slope * force for slope, force in zip(slopes, taken, strict=True))
            for own, *slopes in (contact.reaction for contact in self.machine.contacts(t, mechanical, drive))
        ]

    def outside(self, v, sides) -> list:
        """What acts on each contact's body besides friction, against forward."""
        if self.around is None:
            return [0.0] * self.contacts
        drags = [self.around.drag(each, side) for each, side in zip(v, sides, strict=True)]
        ground = self.machine.ground_speed()
        drags[0] = self.around.drag(v[0] + ground, sides[0]) - self.around.force
        return drags

    def law_load(self, i) -> float:
        """With which the law of a contact is asked."""
        return 1.0 if self.follows else self.constant_loads[i]

    def force(self, i, v, y, side) -> tuple:
        """(R over load, rates of the internal states) of contact i while it slides."""
        return self.laws[i].force(v, tuple(y[self.own[i]]), side, self.law_load(i))

    def held(self, i) -> tuple[float, float]:
        """Least and largest force over load at rest."""
        law, load = self.laws[i], self.law_load(i)
        if not self.sticks[i]:
            return 0.0, 0.0
        return law.holding_centre(load) - law.holding_limit(load), law.holding_centre(load) + law.holding_limit(load)

    def acceleration(self, t, y, rates) -> np.ndarray:
        """Rates of the contact velocities along rates of the machine's states."""
        along = [Jet([value, rate]) for value, rate in zip(y[: self.states], rates, strict=True)]
        velocities = self.velocities(Jet([t, 1.0]), along)
        return np.array([velocity.c[1] if isinstance(velocity, Jet) else 0.0 for velocity in velocities])

    def _responses(self, t, y) -> tuple[np.ndarray, np.ndarray]:
        """(response, raised): by how much all accelerations and loads fall with each force."""
        zero = [0.0] * self.contacts
        units = np.eye(self.contacts).tolist()
        at = [self.acceleration(t, y, self.rates(t, y, each)) for each in (zero, *units)]
        loads = [np.array(self.loads(t, y, each), float) for each in (zero, *units)]
        return np.column_stack([at[0] - each for each in at[1:]]), np.column_stack(
            [loads[0] - load for load in loads[1:]]
        )

    def responses(self, t, y) -> tuple[np.ndarray, np.ndarray]:
        """The same, where it is constant asked once."""
        return self._responses(t, y) if self._response is None else self._response

    def flow(self, t, y, sides) -> tuple[list, np.ndarray, np.ndarray]:
        """(y', R over load where a load is constant, loads) in a mode."""
        y = [float(value) for value in y]
        v = [float(velocity) for velocity in self.velocities(t, y)]
        slid = [self.force(i, v[i], y, side or 1) for i, side in enumerate(sides)]
        outside = self.outside(v, sides)
        response, raised = self.responses(t, y)
        free = self.acceleration(t, y, self.rates(t, y, outside))
        loads = np.array(self.loads(t, y, outside), float)
        rests, level = np.array([side == 0 for side in sides]), np.array([each[0] for each in slid], float)
        if not rests.any() and not self.follows:
            force = level
        else:
            middle, width = np.array(
                [[0.5 * (hi + lo), 0.5 * (hi - lo)] for lo, hi in map(self.held, range(len(sides)))]
            ).T
            rows = np.eye(len(sides)) + level[:, None] * raised
            force = solved(response, free, rests, rows, level * loads, middle * loads, width * loads)
        rates = self.rates(t, y, [f + more for f, more in zip(force.tolist(), outside, strict=True)])
        return [*rates, *(z for each in slid for z in each[1])], force, loads - raised @ force

    # --- decisions ----------------------------------------------------------------------------------------------------

    def problem(self, t, y, sides) -> Problem:
        """At one instant; sides: 0 for those that are asked."""
        v = [0.0 if side == 0 else float(velocity) for side, velocity in zip(sides, self.velocities(t, y), strict=True)]
        response, raised = self.responses(t, y)
        outside = self.outside(v, sides)
        free = self.acceleration(t, y, self.rates(t, y, outside))
        loads = np.array(self.loads(t, y, outside), float)
        ways = [[self.force(i, v[i], y, side)[0] for side in (sides[i] or 1, -1, 1)] for i in range(self.contacts)]
        held = [self.held(i) if self.sticks[i] else (way[0], way[0]) for i, way in enumerate(ways)]
        return Problem(
            free,
            response,
            loads,
            raised,
            *np.array(ways, float).T[:1],
            *np.array(held, float).T,
            *np.array(ways, float).T[1:],
        )

    def series(self, t, y, sides, static: Mapping[int, float]) -> tuple[list[Jet], list[Jet], list[Jet]]:
        """(contact velocities less what they are now, friction forces, loads) of a mode.

        static: force over load of those that slide with a constant one
        """
        n = self.contacts
        response, raised = self.responses(t, [float(value) for value in y])
        rests = np.array([side == 0 for side in sides])
        states = [[float(value)] for value in y]
        forces: list[list[float]] = [[] for _ in range(n)]
        for k in range(ORDERS):
            time, now = Jet([t, 1.0, *([0.0] * k)][: k + 1]), [Jet(value) for value in states]
            v = self.velocities(time, now)
            slid = [self.force(i, v[i], now, side or 1) for i, side in enumerate(sides)]
            outside = self.outside(v, sides)
            known = [Jet([*force, 0.0]) for force in forces]

            def after(given, now=now, time=time, outside=outside, k=k):
                taken = [force + more for force, more in zip(given, outside, strict=True)]
                rates = [_coefficient(rate, k) for rate in self.rates(time, now, taken)]
                longer = [Jet([*value, rate / (k + 1)]) for value, rate in zip(states, rates, strict=False)]
                ahead = self.velocities(Jet([t, 1.0, *([0.0] * (k + 1))][: k + 2]), longer)
                loads = self.loads(time, now, taken)
                return rates, np.array([(k + 1) * _coefficient(each, k + 1) for each in ahead]), loads

            _, free, loads = after(known)
            own = np.array([_coefficient(load, k) for load in loads])
            level = [Jet([static[i], *([0.0] * k)]) if i in static else each[0] for i, each in enumerate(slid)]
            level = [each if isinstance(each, Jet) else Jet([each, *([0.0] * k)]) for each in level]
            right = np.array([_coefficient(each * load, k) for each, load in zip(level, loads, strict=True)])
            rows = np.eye(n) + np.array([each.c[0] for each in level])[:, None] * raised
            middle, width = np.zeros(n), np.ones(n)
            for i in range(n):
                if self.sticks[i]:
                    least, most = self.held(i)
                    middle[i], width[i] = (
                        0.5 * (least + most) * own[i],
                        0.5 * (most - least) * own[i] if k == 0 else 1.0,
                    )
                    if k and not self.follows:
                        middle[i], width[i] = 0.0, 0.5 * (most - least)
            found = solved(response, free, rests, rows, right, middle, width)
            for force, value in zip(forces, found.tolist(), strict=True):
                force.append(value)
            rates, _, _ = after([Jet(force) for force in forces])
            rates += [_coefficient(rate, k) for each in slid for rate in each[1]]
            for value, rate in zip(states, rates, strict=True):
                value.append(rate / (k + 1))
        time, now = Jet([t, 1.0, *([0.0] * (ORDERS - 1))]), [Jet(value) for value in states]
        v = [
            velocity if isinstance(velocity, Jet) else Jet([velocity] + [0.0] * ORDERS)
            for velocity in self.velocities(time, now)
        ]
        outside, short = self.outside(v, sides), [Jet(force) for force in forces]
        loads = self.loads(time, now, [force + more for force, more in zip(short, outside, strict=True)])
        loads = [load if isinstance(load, Jet) else Jet([load] + [0.0] * (ORDERS - 1)) for load in loads]
        return v, short, loads

    def lasts(self, t, y, sides, rest, gave, problem) -> tuple[bool, dict[int, int]]:
        """(whether a mode lasts for an instant, in which order each slider leaves): by its series."""
        static = {
            i: problem.bound(i, sides[i], gave)
            for i in rest
            if sides[i] and i not in gave and self.sticks[i] and problem.drops(i)
        }
        try:
            v, forces, loads = self.series(t, y, sides, static)
        except np.linalg.LinAlgError:
            return False, {}
        tiny, little = problem.sizes
        speed = 1.0
        left = {}
        for i in rest:
            if sides[i]:
                order, sign = _first(v[i].c[1:], tiny * speed)
                if sign != sides[i] and (sign or self.sticks[i]):
                    return False, {}
                left[i] = order
            else:
                if _first(v[i].c[1:], tiny * speed)[1]:
                    return False, {}
                for side in (1, -1):
                    spare = side * (problem.bound(i, side, gave) * loads[i] - forces[i])
                    if _first(spare.c, little)[1] < 0:
                        return False, {}
        return True, left

    def decided(self, t, y, sides: Sequence[int], asked: Sequence[int], came: set[int]) -> tuple[int, ...]:
        """Sides of all contacts; sides: as they are, asked: those that are at rest now, came: which of them slid."""
        start = [0 if i in asked else side for i, side in enumerate(sides)]
        problem = self.problem(t, y, start)

        def lasts(tried, gave):
            whole = list(start)
            for i, side in tried.items():
                whole[i] = side
            return self.lasts(t, y, whole, list(tried), gave, problem)

        found = decided(problem, [i for i in asked if self.turns[i]], came, dict(enumerate(sides)), lasts)
        return tuple(found.get(i, side) for i, side in enumerate(start))


def _coefficient(value: Any, k: int) -> float:
    if isinstance(value, Jet):
        return value.c[k]
    return float(value) if k == 0 else 0.0


def _first(coefficients: Sequence[float], tiny: float) -> tuple[int, int]:
    """(order, sign) of the first coefficient that is not zero; sign 0: there is none."""
    for k, value in enumerate(coefficients):
        if abs(value) > tiny:
            return k, 1 if value > 0.0 else -1
    return len(coefficients), 0


# --- motions ----------------------------------------------------------------------------------------------------------


@dataclasses.dataclass
class Motion:
    """status: "finished", or why it ended; state: by name; events: (time, kind); history: (time, sides from there)."""

    status: str
    end: float
    state: dict[str, float]
    sides: tuple[int, ...]
    events: list[tuple[float, str]]
    history: list[tuple[float, tuple[int, ...]]]


def segments(drive: Any) -> list[tuple[float, float, Any]]:
    """(start, end, drive) of all segments of a period."""
    if not isinstance(drive, Piecewise):
        return [(0.0, drive.period, drive)]
    table, values, start = segment_table(drive), [], 0.0
    for row in table:
        middle = 0.5 * (start + min(row[0], 1.0))
        held = drive.on_segment(*segment_in_time(table, middle, drive.period))
        values.append((start * drive.period, min(row[0], 1.0) * drive.period, held))
        start = row[0]
    return values


class Solver:
    """Follows a motion; `run` gives it."""

    def __init__(self, system: Any, initial: Mapping[str, float], exact: tuple[float, float] = EXACT):
        drive = system.drive
        self.exact, self.period = exact, drive.period
        self.parts = [(start, end, Mechanics(system, held)) for start, end, held in segments(drive)]
        self.smooth = not isinstance(drive, (Piecewise, Ramp))
        self.now = self.parts[0][2]
        unknown = set(initial) - set(self.now.names)
        assert not unknown, unknown
        self.y = np.array([float(initial.get(name, 0.0)) for name in self.now.names])
        self.sides: tuple[int, ...] = ()
        self.events: list[tuple[float, str]] = []
        self.history: list[tuple[float, tuple[int, ...]]] = []

    def run(self, periods: float) -> Motion:
        """The motion over so many periods from time 0."""
        end, done, status = periods * self.period, 0.0, "finished"
        pieces = [
            (turn * self.period, start, min(stop, end - turn * self.period), mechanics)
            for turn in range(int(np.ceil(periods - 1e-12)))
            for start, stop, mechanics in self.parts
            if turn * self.period + start < end * (1.0 - 1e-14)
        ]
        if self.smooth:
            pieces = [(0.0, 0.0, end, self.now)]
        try:
            for self.origin, start, stop, self.now in pieces:
                self._corner(start, first=not self.history)
                status, done = self._segment(start, stop), self.at
                if status != "finished":
                    break
        except Undecided as why:
            status, done = f"ambiguous contacts: {why}", self.at
        state = dict(zip(self.now.names, self.y.tolist(), strict=True))
        return Motion(status, done, state, self.sides, self.events, self.history)

    def _corner(self, t, first) -> None:
        """Velocities and forces may jump: who moves has the side of its velocity, who does not is asked."""
        self.at = self.origin + t
        v = np.array(self.now.velocities(t, self.y.tolist()), float)
        before = self.sides or (0,) * len(v)
        still = [i for i in range(len(v)) if abs(v[i]) <= STILL or (not first and before[i] == 0 and not self._jumps)]
        moved = [int(np.sign(each)) if turns else 1 for each, turns in zip(v, self.now.turns, strict=True)]
        asked = [i for i in still if self.now.turns[i]]
        self._still(t, [i for i in asked if self.now.sticks[i]])
        came = set() if first else {i for i in asked if before[i]}
        sides = [before[i] if i in asked and not first else side for i, side in enumerate(moved)]
        self._turned(t, self.now.decided(t, self.y.tolist(), sides, asked, came), silent=first)

    @property
    def _jumps(self) -> bool:
        return self.now.machine.effort in ("displacement", "angle", "number")

    def _still(self, t, those) -> None:
        """Velocities that are zero exactly."""
        machine = self.now.machine
        for i in those:
            v = float(self.now.velocities(t, self.y.tolist())[i])
            self.y[self.now.names.index(machine.contact_states[i])] -= v

    def _turned(self, t, sides, silent=False) -> None:
        before = self.sides or sides
        for i, (was, now) in enumerate(zip(before, sides, strict=True), start=1):
            if was != now and not silent:
                kind = "stick" if now == 0 else "reversal" if was else "slip_forward" if now > 0 else "slip_back"
                self.events.append((self.origin + t, kind if i == 1 else f"{kind}_{i}"))
                if was and now and not self.now.sticks[i - 1]:
                    law, own = self.now.laws[i - 1], self.now.own[i - 1]
                    self.y[own] = law.after_reversal(tuple(self.y[own]), now, self.now.law_load(i - 1))
        self.sides = tuple(sides)
        self.history.append((self.origin + t, self.sides))

    def _guards(self, t, y) -> np.ndarray:
        """Positive within the present mode: two for each contact, then of pieces of laws, loads and bounds."""
        now, y = self.now, [float(value) for value in y]
        v = now.velocities(t, y)
        results: list[float] = []
        force = loads = None
        if now.follows or 0 in self.sides:
            _, force, loads = now.flow(t, y, self.sides)
        for i, side in enumerate(self.sides):
            if side or not now.turns[i]:
                results += [side * v[i] if now.turns[i] else 1.0, 1.0]
            else:
                least, most = now.held(i)
                results += [most * loads[i] - force[i], force[i] - least * loads[i]]
        for i, side in enumerate(self.sides):
            if not now.sticks[i]:
                results += now.laws[i].switches(v[i], tuple(y[now.own[i]]), side, now.law_load(i))
        results += list(loads) if now.follows else []
        results += list(now.machine.bounds(t, tuple(y[: now.states])))
        return np.array(results, float)

    def _segment(self, t, end) -> str:
        """On to the end of a segment of the drive."""
        while t < end:
            t, which = self._until_event(t, end)
            self.at = self.origin + t
            if which < 0:
                return "finished"
            n, now = self.now.contacts, self.now
            pieces = [
                (i, k)
                for i in range(n)
                if not now.sticks[i]
                for k in range(len(now.laws[i].switches(0.1, (0.0,) * len(now.laws[i].internal), 1, 1.0)))
            ]
            if which >= 2 * n + len(pieces):
                return "lift off" if now.follows and which < 2 * n + len(pieces) + n else "stop reached"
            if which >= 2 * n:
                i, k = pieces[which - 2 * n]
                v = float(now.velocities(t, self.y.tolist())[i])
                self.y[now.own[i]] = now.laws[i].after_switch(
                    k, v, tuple(self.y[now.own[i]]), self.sides[i], now.law_load(i)
                )
                continue
            i = which // 2
            if self.sides[i]:
                self._still(t, [i])
            v = np.array(now.velocities(t, self.y.tolist()), float)
            asked = [k for k in range(n) if now.turns[k] and (k == i or self.sides[k] == 0 or abs(v[k]) <= STILL)]
            came = {k for k in asked if self.sides[k]}
            self._turned(t, now.decided(t, self.y.tolist(), self.sides, asked, came))
        self.at = self.origin + t
        return "finished"

    def _until_event(self, t, end) -> tuple[float, int]:
        """(time, guard that ended the mode or -1), with the state there."""
        longest, sides, now = self.period / STEPS_PER_PERIOD, self.sides, self.now

        def flow(s, y):
            return now.flow(s, y, sides)[0]

        def stepper(start, state, bound, first):
            return DOP853(flow, start, state, bound, longest, *self.exact, first_step=min(first, bound - start))

        solver = stepper(t, self.y, end, 1e-5 * self.period)
        armed = self._guards(t, self.y) > CLEAR
        while solver.status == "running":
            old_t, old_y = solver.t, solver.y.copy()
            if message := solver.step():
                raise RuntimeError(message)
            path = solver.dense_output()
            times = np.linspace(old_t, solver.t, SAMPLES + 1)
            values = np.array([self._guards(s, old_y if s == old_t else path(s)) for s in times])
            numbers: list[tuple[float, int]] = []
            for g in range(values.shape[1]):
                for k in range(1, SAMPLES + 1):
                    value = values[k, g]
                    if not armed[g]:
                        if value < -CLEAR:
                            raise RuntimeError(
                                f"at {self.origin + old_t!r} guard {g} of the mode {sides} fails at once"
                            )
                        armed[g] = value > CLEAR
                        continue
                    low, high = times[k - 1], times[k]
                    if value > 0.0:
                        if not (k < SAMPLES and value < min(values[k - 1, g], values[k + 1, g])):
                            continue
                        dip = minimize_scalar(
                            lambda s, g=g, path=path: self._guards(s, path(s))[g],
                            bounds=(low, times[k + 1]),
                            method="bounded",
                        )
                        if dip.fun > 0.0:
                            continue
                        high = float(dip.x)

                    def guard(s, g=g, path=path):
                        return float(self._guards(s, path(s))[g])

                    root = low if guard(low) <= 0.0 else brentq(guard, low, high, xtol=1e-15, rtol=1e-15)
                    numbers.append((float(root), g))
                    break
            if numbers:
                root, g = min(numbers)
                slope = (guard_at(self, root + 1e-6, path, g) - guard_at(self, root - 1e-6, path, g)) / 2e-6
                for _ in range(2):
                    y = old_y.copy()
                    if root > old_t:
                        short = stepper(old_t, old_y, root, root - old_t)
                        while short.status == "running":
                            short.step()
                        y = short.y
                    value = self._guards(root, y)[g]
                    if not slope < 0.0 or not abs(value / slope) < 1e-6 or root - value / slope <= old_t:
                        break
                    root -= value / slope
                self.y = y.copy()
                return root, g
        self.y = solver.y.copy()
        return end, -1


def guard_at(solver: Solver, t: float, path: Any, g: int) -> float:
    """Guard g on the dense output."""
    return float(solver._guards(t, path(t))[g])


def motion(system: Any, initial: Mapping[str, float], periods: float, exact: tuple[float, float] = EXACT) -> Motion:
    """The motion of a system from a state by name (what is not named is 0) over so many periods."""
    return Solver(system, initial, exact).run(periods)


def random_problem(draw: np.random.Generator) -> tuple[Problem, list[int], set[int], dict[int, int]]:
    """(problem, contacts at rest, those of them that slid, sides until now) of one to six contacts.

    Bodies that share springs, bodies at imposed distances (half of these with none of them changing, so that contacts
    can rest together), loads that follow friction a little; with and without drops, kinked contacts among them.
    """
    n, kind = int(draw.integers(1, 7)), int(draw.integers(4))
    masses = draw.uniform(0.3, 2.0, n)
    free, raised = draw.normal(0.0, 1.0, n) * draw.uniform(0.05, 1.0), np.zeros((n, n))
    if kind in (0, 1):
        response = np.full((n, n), 1.0 / np.sum(masses))
        free = np.full(n, free[0]) if kind == 0 else free
        if kind == 1 and n > 2:  # some of them keep their distance
            free[1] = free[0]
    else:
        mixing = np.eye(n) + draw.normal(0.0, 0.3, (n, n)) * (draw.random() < 0.7)
        response = mixing @ np.diag(1.0 / masses) @ mixing.T
        if kind == 3:
            raised = draw.uniform(-0.3, 0.3, (n, n)) / max(1, n - 1)
    kinetic = draw.uniform(0.05, 0.4, (2, n))
    static = kinetic * np.where(draw.random(n) < 0.5, 1.0, draw.uniform(1.0, 2.0, (2, n)))
    kinked = draw.random(n) < 0.1
    push = draw.uniform(-0.3, 0.3, n)
    up, down = np.where(kinked, push, kinetic[0]), np.where(kinked, push, -kinetic[1])
    most, least = np.where(kinked, push, static[0]), np.where(kinked, push, -static[1])
    sides = draw.choice([-1, 1], n)
    asked = [i for i in range(n) if draw.random() < 0.75] or [0]
    sliding = np.where(sides > 0, up, down)
    loads = draw.uniform(0.5, 1.5, n)
    came = {i for i in asked if draw.random() < 0.3}
    problem = Problem(free, response, loads, raised, sliding, least, most, down, up)
    return problem, asked, came, dict(enumerate(sides.tolist()))
