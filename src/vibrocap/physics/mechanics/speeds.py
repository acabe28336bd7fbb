"""The coordinates of a machine, how they move, and its parts along that motion.

Coordinates q move at generalised speeds u (Kane): the rate of a coordinate, or in place of it the sliding velocity of a
contact, so that one at rest is at rest exactly,

    A q' + a = u,     q' = B u + b,     B = A^-1

Where the drive imposes a motion, u is the velocity of the common centre of mass instead, which continues where the rate
of the drive jumps.
"""

import itertools
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any

from vibrocap.arguments import suggestion
from vibrocap.physics.mechanics.formulas import Formula, Program, Tape, div
from vibrocap.physics.mechanics.parts import (
    Contact,
    Damper,
    Drag,
    Drive,
    Inertia,
    Mass,
    MechanicsError,
    Placed,
    Potential,
    Spring,
    Stop,
    as_sum,
    is_word,
)
from vibrocap.physics.mechanics.quantities import Quantity
from vibrocap.physics.mechanics.sums import Sum, solved, total, written
from vibrocap.physics.names import numbered

TIME, DRIVE = "time", "drive"
FOLDED = 1e-4  # slope of a contact's path over the way of its body, below which it is singular: errors grow by 1e4
WORDS = ("dynamic", "weight")  # for loads
MOST_BOUNDED = 4  # coordinates with rigid stops: which of them hold in a blow is chosen among all their subsets
PARTS = (Placed, Spring, Damper, Drag, Drive, Potential, Stop, Contact)


class Inputs:
    """The formulas that stand for time, drive, states, friction forces, parameters, gravity and further inputs.

    least: of each parameter what it may be at least
    signals: names of inputs of which value, slope and curvature are known, "drive" of one that imposes a motion
    """

    def __init__(self, states: int, contacts: int, least: Sequence[float], signals: Sequence[str] = ()):
        self.tape = tape = Tape()
        number = iter(range(5 + states + contacts + len(least) + 3 * len(signals)))

        def block(count: int) -> tuple[Any, ...]:
            return tuple(tape.input(next(number)) for _ in range(count))

        (self.t, self.drive), self.gravity = block(2), block(2)
        self.parameters, self.states, self.frictions = block(len(least)), block(states), block(contacts)
        self.least = {own: value for own, value in zip(self.parameters, least, strict=True) if value >= 0.0}
        self.signals = {name: block(3) for name in signals}
        moving = self.t, self.drive, *self.states, *itertools.chain(*self.signals.values())
        self.changing = {name.operands[0] for name in moving}
        self.count = 4 + states + contacts + len(least) + 3 * len(signals)


class Space:
    """What `parts` is given: coordinates and other quantities by name."""

    time: Quantity
    drive: Quantity
    imposed: Callable[[Any], Quantity]

    def __getattr__(self, name: str) -> Any:
        raise MechanicsError(f"q.{name}: there is no such quantity; {suggestion(name, vars(self))}")


class Motion:
    """The parts of one form of a machine along its motion.

    describe: the parts, given coordinates, `time`, signals and `imposed` by name
    coordinates: the names of all, each with the name of its rate   counts: of those that are several, how many
    gravity: (g_n, g_t); None: not known, and nothing weighs
    states: formulas by name; None: only what does not depend on them
    touching: of stops by their number, the states that say whether they are touched   own: other switched states
    """

    def __init__(
        self,
        describe: Callable[[Any], Iterable],
        coordinates: Mapping[str, str],
        inputs: Inputs,
        gravity: tuple[Any, Any] | None = (1.0, 0.0),
        states: Mapping[str, Any] | None = None,
        counts: Mapping[str, int] | None = None,
        touching: Mapping[int, Any] | None = None,
        own: tuple[str, ...] = (),
    ):
        self.describe, self.names, self.counts, self.inputs = describe, tuple(coordinates), counts or {}, inputs
        self.coordinates, self.gravity, self.touching, self.own = coordinates, gravity, touching or {}, own
        self.normal, self.back = map(Sum.of, gravity or (0.0, 0.0))
        self.imposes = "drive" in inputs.signals
        self.rates = dict(coordinates)
        self.folds: list[Sum] = []
        self._find_speeds()
        self._judge()
        if states is not None:
            self._move(states)

    def at(self, states: Mapping[str, Any], touching: Mapping[int, Any] | None = None) -> Any:
        """The same at other states; touching: stops besides, by their number."""
        fixed = self.describe, self.coordinates, self.inputs, self.gravity, states, self.counts
        return type(self)(*fixed, self.touching if touching is None else touching, self.own)

    @property
    def switching(self) -> Iterator[tuple[int, Stop, Formula]]:
        """Stops that are touched and left: number, stop and state: 1 in front, -1 behind, 0 where it is not touched."""
        return ((i, self.stops[i], stop) for i, stop in self.touching.items() if self.stops[i].switches)

    def _space(self, places, slopes, rates, curvatures) -> Space:
        q, self.imposed = Space(), []
        q.time = Quantity(self.inputs.t, {TIME: Sum.of(1.0)}, 1.0)
        q.drive = Quantity(self.inputs.drive, {DRIVE: Sum.of(1.0)})  # for loads; no motion, unless it is imposed
        for name, (value, slope, bend) in self.inputs.signals.items():
            setattr(q, name, Quantity(value, {TIME: Sum.of(slope)}, slope, bend))
        quantities = {name: Quantity(places[name], slopes[name], rates[name], curvatures[name]) for name in self.names}
        self.along = quantities
        for name, quantity in quantities.items():
            setattr(q, name, quantity)
        for name, count in self.counts.items():
            setattr(q, name, tuple(quantities[numbered(name, i + 1)] for i in range(count)))
        for name in self.own:
            setattr(q, name, Quantity(places[name]))
        q.imposed = self._imposed
        return q

    def _imposed(self, path: Any) -> Quantity:
        """A coordinate that moves as this path: the force along it is the actuator's."""
        path = Quantity.of(path)
        self.imposed.append(
            Quantity(path.value, {("imposed", len(self.imposed)): Sum.of(1.0)}, path.rate, path.curvature)
        )
        return self.imposed[-1]

    def _take(self, q: Any) -> None:
        self.parts = tuple(_flat(self.describe(q)))
        if strange := [part for part in self.parts if not isinstance(part, PARTS)]:
            raise MechanicsError(f"should be parts, masses, springs and so on, got {strange[0]!r}")
        self.masses = self._of(Mass, Inertia)
        self.contacts, self.stops = self._of(Contact), self._of(Stop)
        self.springs, self.drives, self.potentials = map(self._of, (Spring, Drive, Potential))
        self.dampers = self._of(Damper, Drag)
        self.bodies = self._of(Placed)
        self.paths = [_path(contact) for contact in self.contacts]
        self.stretches = {id(spring): Quantity.of(spring.stretch) - spring.rest for spring in self.springs}

    def everything(self) -> Iterator[tuple[Any, Quantity]]:
        """Each part with its places, its stretch, its path or its energy."""
        yield from ((body, x) for body in self.bodies for x in (body.along, body.height, body.turn))
        yield from ((stop, stop.way) for stop in self.stops)
        yield from zip(self.contacts, self.paths, strict=True)
        for part in self._of(Spring, Damper, Drag, Drive, Potential):
            for name in {"stretch", "rest", "path", "energy"} & vars(part).keys():
                yield part, Quantity.of(getattr(part, name))

    def _of(self, *kinds: type) -> list[Any]:
        return [part for part in self.parts if isinstance(part, kinds)]

    def _find_speeds(self) -> None:
        """Which coordinate gives its rate to the sliding velocity of which contact."""
        nothing, unit = dict.fromkeys(self.names, 0.0), {name: {name: Sum.of(1.0)} for name in self.names}
        sample = {name: self.inputs.tape.formula("place", i) for i, name in enumerate((*self.names, *self.own))}
        self._take(self._space(sample, unit, nothing, nothing))
        self.pivots: dict[str, int] = {}
        self.speeds: list[str] = []  # of the contacts, names of states
        if not self.contacts:
            raise MechanicsError("there is no Contact: something should rub")
        if self.imposes:
            self.speeds, self.place = [self.rates[self.names[0]]] * len(self.contacts), self.names[0]
            return
        for k, (contact, path) in enumerate(zip(self.contacts, self.paths, strict=True)):
            if not self._pivoted(k, set()):
                why = "its sliding velocity follows from those before it"
                why = why if any(map(path.slope, self.names)) else "no coordinate moves it"
                raise MechanicsError(f"contact {k + 1} ({contact.body.name}): {why}")
        self.pivots = dict(sorted(self.pivots.items(), key=operator.itemgetter(1)))
        alone = [name for name, k in self.pivots.items() if self.paths[k].slopes.keys() & {*self.names} == {name}]
        for pivot, k in self.pivots.items():
            contact = self.contacts[k]
            if contact.speed is not None or pivot not in alone or self.paths[k].slope(pivot).number != 1.0:
                self.rates[pivot] = contact.speed or numbered("sliding_velocity", k + 1)
            self.speeds.append(self.rates[pivot])
        self.place = [*alone, *self.pivots][0]
        names = [*self.names, *self.rates.values()]
        if twice := [name for name in names if names.count(name) > 1]:
            raise MechanicsError(f"two states have the name {twice[0]!r}")

    def _pivoted(self, k: int, asked: set[str]) -> bool:
        """Find the coordinate that gives its rate to a contact; another contact may have to take another one."""
        moved = [name for name in reversed(self.names) if self.paths[k].slope(name)]
        for name in sorted(moved, key=self.pivots.__contains__):  # free ones first
            if name not in asked:
                asked.add(name)
                if name not in self.pivots or self._pivoted(self.pivots[name], asked):
                    self.pivots[name] = k
                    return True
        return False

    def _judge(self) -> None:
        """MechanicsError for what the parts cannot mean."""
        known, rules, words = {id(body) for body in self.bodies}, [], " or ".join(WORDS)
        for body in self.bodies:
            again = sum(other.name == body.name for other in self.bodies) > 1
            rules.append((again, f"two bodies have the name {body.name!r}"))
            missing = body.on is not None and id(body.on) not in known
            rules.append(
                (missing, f"{body.name!r} stands on {getattr(body.on, 'name', '')!r}, which is not among the parts")
            )
        for contact in self.contacts:
            name, word = contact.body.name, is_word(contact.load)
            strange = [end.name for end in (contact.body, contact.on) if end is not None and id(end) not in known]
            rules += [
                (strange, f"the contact of {name!r} is with {strange}, not among the parts"),
                (word and contact.load not in WORDS, f"the load on {name!r} should be {words}, or a quantity"),
                (
                    word and isinstance(contact.body, Inertia),
                    f"the load on {name!r}, which turns, is a torque: give it",
                ),
                (
                    self.imposes and contact.speed is not None,
                    f"the contact of {name!r} has a speed: leave it out, the state is {self.rates[self.names[0]]!r}",
                ),
            ]
        what = "give the body that it moves a mass, or write it as a function of the others"
        for name in self.names:
            still = not any(as_sum(size) and x.slope(name) for m in self.masses for x, size in m.moved)
            rules.append((still, f"the coordinate {name!r} moves no mass: {what}"))
        for m in self.masses:
            slopes = [mass.along.slope(self.place).number for mass in (m.on, m) if mass is not None]
            twice = slopes == [1.0, 2.0]
            where = (
                f"its x counts from {getattr(m.on, 'name', '')!r}, on which it stands: leave {self.place!r} out there"
            )
            rules.append((twice, f"{m.name!r} moves twice as far as {self.place!r}; {where}"))
            carried = any(m.stands_on(contact.body) for contact in self.contacts)
            borne = carried or not as_sum(m.mass) or any(map(m.height.slope, self.names))
            dynamic = any(is_word(contact.load) and contact.load == "dynamic" for contact in self.contacts)
            rules.append((dynamic and not borne, f"nothing carries {m.name!r}: name the body below it, on=..."))
        placed = [x for body in self.bodies for x in (body.along, body.height, body.turn)]
        moved = any(x.slope(DRIVE) for x in (*placed, *self.stretches.values()))
        rules.append((moved, "a place follows q.drive, a force here: let the effort be a motion, or write a signal"))
        for part in (*self.springs, *self.dampers, *self.drives):
            path = Quantity.of(getattr(part, "stretch", None) or getattr(part, "path", 0.0))
            rules.append((not path.moves, f"a {type(part).__name__} acts along a path that never moves"))
        for stop in (stop for stop in self.stops if not stop.elastic):
            one = any(not (stop.way - self.along[name]).moves for name in self.names)
            rules.append((not one, "a stop should bound one coordinate, which grows one to one with its stretch"))
        bounded = {name for name in self.names for stop in self.stops if stop.rigid and stop.way.slope(name)}
        rules.append((len(bounded) > MOST_BOUNDED, f"rigid stops should bound {MOST_BOUNDED} coordinates at most"))
        held = [stop for stop in self.stops if stop.rigid and any(map(stop.way.slope, self.pivots))]
        rules.append((held and len(self.contacts) > 1, "a rigid stop bounds a rubbing body, among several contacts"))
        rules.append((self.imposes and len(self.names) != 1, "a machine whose drive is a motion has one coordinate"))
        rules.append((self.imposes and self.drives, "a machine whose drive is a motion has no Drive, but q.drive"))
        if wrong := [rule for broken, rule in rules if broken]:
            raise MechanicsError("; ".join(dict.fromkeys(wrong)))

    def _move(self, states: Mapping[str, Formula]) -> None:
        """Let the coordinates move at their generalised speeds."""
        self.states = {name: Sum.of(state) for name, state in states.items()}
        places = self.states
        self.speed = {name: self.states[self.rates[name]] for name in self.names}
        nothing, unit = dict.fromkeys(self.names, 0.0), {name: {name: Sum.of(1.0)} for name in self.names}
        shifts, bends, slopes = dict(nothing), dict(nothing), unit
        paths = [(name, self.paths[k]) for name, k in self.pivots.items()]
        plain = all(path.slopes.keys() == {name} and path.slope(name).number == 1.0 for name, path in paths)
        if self.imposes or not plain:
            self._take(self._space(places, unit, nothing, nothing))
            if self.imposes:
                (name,) = self.names
                moved = [(size * x.slope(name), x) for m in self.masses for x, size in m.moved if x.slope(name)]
                lines = Program(tuple(written(x.slope(name)) for _, x in moved), self.inputs.count)
                if not lines.inputs.isdisjoint(self.inputs.changing):
                    raise MechanicsError(f"a machine whose drive is a motion moves along straight lines with {name!r}")
                whole = written(total(size * x.slope(name) for size, x in moved))
                along = total(size * x.rate for size, x in moved), total(size * x.curvature for size, x in moved)
                shifts[name], bends[name] = (-div(written(x), whole) for x in along)
            else:
                self.folds = [*self._folds()]
                slopes, shifts = self._kinematics()
                rates = {n: total(s * self.speed[j] for j, s in slopes[n].items()) + shifts[n] for n in self.names}
                self._take(self._space(places, unit, rates, nothing))
                bent = {name: self.paths[k].curvature for name, k in self.pivots.items()}
                bends = {n: -total(slopes[n].get(j, Sum()) * bend for j, bend in bent.items()) for n in self.names}
        rates = {n: total(s * self.speed[j] for j, s in slopes[n].items()) + shifts[n] for n in self.names}
        self._take(self._space(places, slopes, rates, bends))

    def _folds(self) -> Iterator[Sum]:
        """What is positive while the path of a contact moves with its coordinate, so that its velocity tells of that.

        The slope s of the path is compared with the way of the body, s^2 - FOLDED^2 (x_q^2 + z_q^2 + phi_q^2).
        """
        for name, k in self.pivots.items():
            slope, body = self.paths[k].slope(name), self.contacts[k].body
            if slope.number is None:
                slopes = (direction.slope(name) for direction in (body.along, body.height, body.turn))
                yield slope * slope - FOLDED**2 * total(own * own for own in slopes)

    def _kinematics(self) -> tuple[dict, dict]:
        n, rows = len(self.names), []
        for i, name in enumerate(self.names):
            path = self.paths[self.pivots[name]] if name in self.pivots else None
            own = [Sum.of(float(j == i)) if path is None else path.slope(other) for j, other in enumerate(self.names)]
            own += [Sum.of(float(j == i)) for j in range(n)]
            rows.append([*own, Sum() if path is None else path.rate])
        kinematics = solved(rows, n)
        slopes = {
            name: {speed: Sum.of(b) for speed, b in zip(self.names, row, strict=False)}
            for name, row in zip(self.names, kinematics, strict=True)
        }
        return slopes, {name: -Sum.of(row[n]) for name, row in zip(self.names, kinematics, strict=True)}


def _flat(parts: Iterable) -> Iterator:
    """Parts, out of the lists and tuples in which they may stand."""
    for part in parts:
        if isinstance(part, (list, tuple)):
            yield from _flat(part)
        else:
            yield part


def _path(contact: Contact) -> Quantity:
    if contact.path is not None:
        return Quantity.of(contact.path)
    body, on = contact.body, contact.on
    if isinstance(body, Inertia):
        return body.turn if on is None else body.turn - on.turn
    return body.along if on is None else body.along - on.along
