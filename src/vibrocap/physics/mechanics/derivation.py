"""The equations of motion of what a machine is made of.

A quantity along the motion has slopes along the generalised speeds u (`speeds.py`). With places x_i, z_i and angles
phi_i so sloped, weight g_n towards the ground and g_t back along it,

    M_ij = sum of m (x_i x_j + z_i z_j) + J phi_i phi_j
    h_i  = sum of a drive s_i - k s s_i - c s' s_i - V_i - m [x_i (x_c + g_t) + z_i (z_c + g_n)] - J phi_i phi_c
    M u' = h - sum of R s_i of each contact, s its path

Speeds that are no contact's are eliminated first, so that what is left is the acceleration of each contact and what
each friction force takes off it. A direction along which nothing moves, one that lifts a body or stretches what the
drive imposes, has a row of M and h as well: with u' put in, that is the force along it, the load on a contact or the
push of the actuator. The row of time is the power that supports put in, for time runs at the rate 1.
"""

import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from vibrocap.physics.mechanics.formulas import Program, add, mul, sub
from vibrocap.physics.mechanics.parts import Contact, Drag, Mass, MechanicsError, Support, as_sum, is_word
from vibrocap.physics.mechanics.quantities import Direction, Quantity
from vibrocap.physics.mechanics.speeds import TIME, Motion
from vibrocap.physics.mechanics.stops import elastic_force, springs, stopped
from vibrocap.physics.mechanics.sums import Sum, back_substituted, eliminate, total, written


class Derivation(Motion):
    """The mechanics of one form of a machine, as formulas."""

    def inertia(self, i: Direction, j: Direction) -> Sum:
        """M_ij."""
        both = ((x, size) for x, size in self.moved if i in x.slopes and j in x.slopes)
        return total(size * (x.slope(i) * x.slope(j)) for x, size in both)

    @property
    def moved(self) -> Iterator[tuple[Quantity, Sum]]:
        """Every place and angle of a body, with the mass or the inertia that it moves."""
        return ((x, as_sum(size)) for m in self.masses for x, size in m.moved)

    def applied(self, i: Direction) -> Sum:
        """Force of drive, springs, dampers and elastic stops along a direction."""
        force = total(as_sum(d.share) * Quantity.of(d.path).slope(i) * self.drive for d in self.drives)
        force = force - total(Quantity.of(p.energy).slope(i) for p in self.potentials)
        for spring in self.springs:
            stretch = self.stretches[id(spring)]
            force = force - as_sum(spring.stiffness) * (stretch.value * stretch.slope(i))
        for damper in self.dampers:
            force = force - damper.force * Quantity.of(damper.stretch).slope(i)
        for _, stop, touching in self.switching:
            if stop.elastic and (slope := stop.way.slope(i)):
                force = force - elastic_force(stop, touching) * slope
        return force

    @property
    def drive(self) -> Any:
        return 0.0 if self.imposes else self.inputs.drive

    def weight(self, i: Direction) -> Sum:
        """What the weight of all pulls along a direction."""
        return -total(
            as_sum(m.mass) * (m.along.slope(i) * self.back + m.height.slope(i) * self.normal) for m in self.masses
        )

    def push(self, i: Direction) -> Sum:
        """h_i."""
        bent = total(size * (x.slope(i) * x.curvature) for x, size in self.moved)
        return self.applied(i) + self.weight(i) - bent

    def whole_mass(self) -> Any:
        """The sum of all masses and inertias."""
        return written(total(as_sum(m.mass) + as_sum(m.inertia) for m in self.masses))

    def numbers(self) -> tuple:
        """(what, number, most) of what may not be negative, nor more than that."""
        numbers = [(f"the mass of {m.name!r}", as_sum(m.mass), math.inf) for m in self.masses]
        numbers += [(f"the inertia of {m.name!r}", as_sum(m.inertia), math.inf) for m in self.masses]
        for damper in self.dampers:
            names = ("drag", "speed") if isinstance(damper, Drag) else ("damping",)
            kind = type(damper).__name__
            numbers += [(f"the {name} of a {kind}", as_sum(getattr(damper, name)), math.inf) for name in names]
        factors = {contact.body.name: Quantity.of(contact.factor) for contact in self.contacts}
        numbers += [(f"the factor on {name!r}", by.value, math.inf) for name, by in factors.items() if not by.moves]
        numbers += [("the restitution of a Stop", as_sum(stop.restitution), 1.0) for stop in self.stops if stop.rigid]
        return tuple((what, written(number), most) for what, number, most in numbers)

    # --- accelerations -----------------------------------------------------------------------------------------------

    @functools.cached_property
    def rubbing(self) -> list[str]:
        """The coordinates whose speeds are those of contacts."""
        return list(self.pivots) if not self.imposes else list(self.names)

    @functools.cached_property
    def order(self) -> list[str]:
        """The coordinates, those of contacts last."""
        return [*(name for name in self.names if name not in self.rubbing), *self.rubbing]

    def _free(self, name: Direction) -> Sum:
        """1; 0 where a rigid stop holds the coordinate."""
        free = Sum.of(1.0)
        for _, stop, touching in self.switching:
            if stop.rigid and stopped(self, stop) == name:
                free = free - Sum.of(mul(touching, touching))
        return free

    @functools.cached_property
    def reduced(self) -> list[list[Sum]]:
        """Rows [M | h], all but those of contacts eliminated; a rigid stop that is touched takes its row out."""
        rows = []
        for i in self.order:
            free = self._free(i)
            mass = [self.inertia(i, j) if i == j else free * self.inertia(i, j) for j in self.order]
            rows.append([*mass, free * self.push(i)])
        eliminate(rows, len(rows) - len(self.rubbing))
        return rows

    def _accelerated(self, columns: Callable[[str], Sequence[Any]]) -> dict[str, list[Any]]:
        """u' of each coordinate, of other right-hand sides of the rows of contacts; h stands in all others."""
        rows, inner = self.reduced, len(self.order) - len(self.rubbing)
        filled = []
        for i, row in zip(self.order, rows, strict=True):
            own = columns(i) if i in self.rubbing else None
            count = len(columns(self.rubbing[0]))
            right = [row[-1], *(Sum() for _ in range(count - 1))] if own is None else own
            filled.append([*row[:-1], *right])
        return dict(zip(self.order, back_substituted(filled, len(rows), inner), strict=True))

    @functools.cached_property
    def accelerations(self) -> dict[str, Any]:
        """u', given the friction at each contact."""
        row = dict(zip(self.order, self.reduced, strict=True))

        def right(name: str) -> list[Any]:
            force, free = written(row[name][-1]), written(self._free(name))
            for speed, friction in zip(self.speeds, self.inputs.frictions, strict=True):
                force = sub(force, mul(free, friction)) if speed == self.rates[name] else force
            return [Sum.of(force)]

        return {name: acceleration[0] for name, acceleration in self._accelerated(right).items()}

    @functools.cached_property
    def responses(self) -> dict[str, list[Any]]:
        """u' of each coordinate without friction, then what the force at each contact takes off it, negative."""
        row = dict(zip(self.order, self.reduced, strict=True))

        def right(name: str) -> list[Any]:
            free = self._free(name)
            return [row[name][-1], *(-free if speed == self.rates[name] else Sum() for speed in self.speeds)]

        return self._accelerated(right)

    def equations_of_motion(self) -> tuple | None:
        """(row of each speed, those of contacts last; row along the lift of each contact, None where none is known).

        Each is (force, pairs (factor, velocity of a place), share): force less all factor velocity' and share u' is
        (1 - share) R along a speed, the share 1 while a rigid stop holds it, and minus the load along a lift. None
        where the drive imposes the motion.
        """
        if self.imposes:
            return None
        plain = [
            self._borne(contact) and not (contact.scaled or self._given_load(contact)) for contact in self.contacts
        ]
        lifts = (
            self._told(contact.body.lift) if own else None for contact, own in zip(self.contacts, plain, strict=True)
        )
        return tuple(map(self._told, self.order)), tuple(lifts)

    def _told(self, i: Direction) -> tuple:
        """A row by velocities of places, whose rates take fewer products than M u' and h, or by a momentum."""
        free, moved = self._free(i), dict[Any, Sum]()
        for direction, size in self.moved:
            slope = direction.slope(i)
            factor, size = (1.0, size * slope) if self._constant([slope]) else (written(slope), size)
            moved[factor] = moved.get(factor, Sum()) + size * direction.rate
        pairs = tuple((written(free * Sum.of(factor)), written(rate)) for factor, rate in moved.items() if rate)
        return written(free * (self.applied(i) + self.weight(i))), pairs, written(1.0 - free)

    def _constant(self, sums: Sequence[Sum]) -> bool:
        return Program(tuple(map(written, sums)), 0).inputs.isdisjoint(self.inputs.changing)

    # --- contacts ----------------------------------------------------------------------------------------------------

    def _moves(self, contact: Contact) -> bool:
        """Whether the load on a contact, or a factor on its friction, follows the motion or the time."""
        if contact.scaled or not is_word(contact.load):
            return contact.scaled or Quantity.of(contact.load).moves
        return contact.load == "dynamic" and self._pressed_on(contact)

    def _pressed_on(self, contact: Contact) -> bool:
        """Whether the motion changes what presses on a contact."""
        lift = contact.body.lift
        borne = [m for m in self.masses if m.height.slope(lift) or m.along.slope(lift)]
        moved = any(m.along.slope(lift) or m.height.curvature or any(map(m.height.slope, self.names)) for m in borne)
        return moved or bool(self.applied(lift))

    @functools.cached_property
    def moving_loads(self) -> bool:
        return any(map(self._moves, self.contacts))

    def loads(self) -> tuple:
        """Constant loads, or those at rest."""
        return tuple(written(self.load_at_rest(contact)) for contact in self.contacts)

    def load_at_rest(self, contact: Contact) -> Sum:
        """A load that is constant or given, or the dynamic one at rest."""
        if not is_word(contact.load):
            return Quantity.of(contact.load).value
        normal = 1.0 if self.gravity is None else self.normal
        if contact.load == "weight":
            return total(as_sum(m.mass) for m in self.masses if m.stands_on(contact.body)) * normal
        return total(as_sum(m.mass) * m.height.slope(contact.body.lift) for m in self.masses) * normal

    def contact_results(self) -> tuple:
        """Of each contact (velocity, what holds it, its acceleration, its responses, its reaction, its factor)."""
        k = len(self.rubbing)
        if len(self.contacts) > k and self.moving_loads:
            name = next(contact.body.name for contact in self.contacts if self._moves(contact))
            raise MechanicsError(f"the load on {name!r} follows the motion: at imposed distances give a constant one")
        own = [row[len(self.order) - k :] for row in self.reduced[-k:]]
        alone = len(self.contacts) == k and (k == 1 or not self.moving_loads)
        alone = alone and not any(own[i][j] for i in range(k) for j in range(k) if i != j)
        results = []
        for c, (path, speed) in enumerate(zip(self.paths, self.speeds, strict=True)):
            name = next(name for name in self.rubbing if self.rates[name] == speed)
            at = self.rubbing.index(name)
            own_speed = written(self.speed[name]), Sum()
            velocity, bend = (written(path.rate), path.curvature) if self.imposes else own_speed
            if alone:
                held = written(own[at][k] + own[at][at] * bend)
                answer = held, None, ()
            else:
                free, *taken = self.responses[name]
                answer = None, add(free, written(bend)), tuple(mul(-1.0, x) for x in taken)
            factor = written(Quantity.of(self.contacts[c].factor).value)
            reaction = self._reaction(c)
            results.append((velocity, *answer, reaction and tuple(mul(x, factor) for x in reaction), factor))
        return tuple(results)

    def _given_load(self, contact: Contact) -> tuple | None:
        """The reaction of a load that is a function of place or time, among loads that follow the motion."""
        if not self.moving_loads or (is_word(contact.load) and contact.load == "dynamic"):
            return None
        return (written(self.load_at_rest(contact)), *(0.0 for _ in self.contacts))

    def _borne(self, contact: Contact) -> bool:
        """Whether the load that the motion makes is said: where it is the load, or else differs from the weight."""
        return self.moving_loads or (not self.imposes and self._pressed_on(contact))

    def _reaction(self, c: int) -> tuple | None:
        """(n, s_1, ...) of N = n + s_1 R_1 + ..."""
        contact = self.contacts[c]
        if (constant := self._given_load(contact)) is not None or not self._borne(contact):
            return constant
        row = [written(-self.push(contact.body.lift)), *(0.0 for _ in self.contacts)]
        for name, a in self.responses.items():
            by = written(self.inertia(contact.body.lift, name))
            row = [add(x, mul(by, z)) for x, z in zip(row, a, strict=True)]
        return tuple(row)

    # --- balances ----------------------------------------------------------------------------------------------------

    def rate_results(self) -> dict[str, Any]:
        """The rates of coordinates and speeds, by name."""
        results = {name: written(place.rate) for name, place in self.along.items()}
        return results | {self.rates[name]: a for name, a in self.accelerations.items()}

    def pressing(self, name: str, accelerations: Mapping[str, Any]) -> Any:
        """What presses along a coordinate that a rigid stop holds, beside these accelerations of the others."""
        push = written(self.push(name))
        for other, acceleration in accelerations.items():
            if other != name:
                push = sub(push, mul(written(self.inertia(name, other)), acceleration))
        for speed, friction in zip(self.speeds, self.inputs.frictions, strict=True):
            push = sub(push, friction) if speed == self.rates[name] else push
        return push

    def wall_force(self) -> Any:
        """Of a rigid stop on the ground that is touched: as much as the other forces need."""
        wall: Any = 0.0
        for _, stop, touching in self.switching:
            if stop.rigid and stop.on_ground:
                wall = sub(wall, mul(mul(touching, touching), self.pressing(stopped(self, stop), self.accelerations)))
        return wall

    def _outer(self, way: Quantity) -> bool:
        """Whether a way is more than relative motion that the drive imposes, and what acts along it bears itself."""
        return not self.imposes or bool(way.slope(self.names[0]))

    def energy(self) -> Any:
        """Kinetic and potential energy, without that of the weight along a slope."""
        if self.imposes:  # of the common centre: that of all relative motion is the drive's
            (name,) = self.names
            energy = 0.5 * self.inertia(name, name) * (self.speed[name] * Sum.of(self.speed[name]))
        else:
            energy = total(0.5 * size * (x.rate * x.rate) for x, size in self.moved)
        lifted = (m for m in self.masses if self._outer(m.height))
        energy = energy + total(as_sum(m.mass) * (self.normal * m.height.value) for m in lifted)
        for spring in self.springs:
            if self._outer(way := self.stretches[id(spring)]):
                energy = energy + 0.5 * as_sum(spring.stiffness) * (way.value * way.value)
        for _, stop, touching in self.switching:
            if stop.elastic and self._outer(stop.way):
                energy = energy + total(0.5 * k * (pressed * pressed) for _, pressed, k, _ in springs(stop, touching))
        stored = map(Quantity.of, (p.energy for p in self.potentials))
        return written(energy + total(energy.value for energy in stored if self._outer(energy)))

    def momentum(self, i: Direction) -> Sum:
        """Momentum along a direction."""
        return total(size * (x.slope(i) * x.rate) for x, size in self.moved)

    def common_momentum(self) -> Any:
        """Momentum along the speeds of all contacts together: of all that moves over one ground the common one."""
        if self.imposes:
            (name,) = self.names
            return written(self.inertia(name, name) * self.speed[name])
        return written(total(map(self.momentum, self.rubbing)))

    @functools.cached_property
    def bent(self) -> Sum:
        """Momentum that masses on curved paths gain as the slopes s of these change, sum of m x' s'."""
        inputs: list[Any] = [self.inputs.tape.input(number) for number in range(self.inputs.count)]
        moving = [(self.inputs.t, 1.0), *((value, slope) for value, slope, _ in self.inputs.signals.values())]
        moving += [(written(self.states[name]), place.rate) for name, place in self.along.items()]
        for value, rate in moving:
            inputs[value.operands[0]] = Quantity(value, rate=rate)
        bent = Sum()
        for direction, size in self.moved:
            slope = total(map(direction.slope, self.rubbing))
            if not self._constant([slope]):
                (slope,) = Program((written(slope),), self.inputs.count)(inputs)
                bent = bent + size * (direction.rate * slope.rate)
        return bent

    def line_momentum(self) -> Any:
        """Momentum of all masses along the line, over the ground at rest; the common one where the drive imposes."""
        if not self.imposes:
            return written(total(as_sum(m.mass) * m.along.rate for m in self.masses))
        (name,) = self.names
        return written(total(as_sum(m.mass) * m.along.slope(name) for m in self.masses) * self.speed[name])

    def weight_along(self) -> tuple:
        """What the weight of all pulls along the speed of each contact."""
        return tuple(written(self.weight(i)) for i in self.rubbing)

    def outer_force(self) -> Any:
        """The force along the same, but for friction and rigid stops, with what curved paths give."""
        return written(self.bent + total(self.applied(i) + self.weight(i) for i in self.rubbing))

    def ground_speeds(self) -> tuple:
        """Speed at which the ground moves under each contact of a body that slides on it; None of any other contact."""
        speeds = []
        for contact, path in zip(self.contacts, self.paths, strict=True):
            slides = isinstance(contact.body, Mass) and isinstance(contact.on, (Support, type(None)))
            slides = slides and contact.path is None and not isinstance(contact.body.on, Support)
            speeds.append(written(-path.slope(TIME)) if slides else None)
        return tuple(speeds)

    def powers(self) -> tuple:
        """(of the drive, of dampers, of supports).

        A drive that imposes the motion moves places past the common centre, at the speed u, against what acts there.
        """
        damped = [(d.force, way) for d in self.dampers if self._outer(way := Quantity.of(d.stretch))]
        lost = -total(force * way.rate for force, way in damped)
        for _, stop, touching in self.switching:
            if stop.elastic and self._outer(stop.way):
                rate = stop.way.rate
                lost = lost - total(c * closed * (rate * rate) for closed, _, _, c in springs(stop, touching))
        if not self.imposes:
            driven = total(as_sum(d.share) * (Quantity.of(d.path).rate * self.drive) for d in self.drives)
            return written(driven), written(lost), self._along(TIME)
        (name,) = self.names
        acting = [*zip(self.inputs.frictions, self.paths, strict=True), *damped]
        acting += [(as_sum(m.mass) * self.normal, m.height) for m in self.masses]
        stretches = ((spring, self.stretches[id(spring)]) for spring in self.springs)
        acting += [(as_sum(spring.stiffness) * stretch.value, stretch) for spring, stretch in stretches]
        acting += [(elastic_force(stop, touching), stop.way) for _, stop, touching in self.switching if stop.elastic]
        acting += [(1.0, Quantity.of(p.energy)) for p in self.potentials]
        past = [(way.rate - way.slope(name) * self.speed[name]) * force for force, way in acting if way.slope(name)]
        return written(total(past)), written(lost), 0.0

    def _along(self, direction: Direction) -> Any:
        """The force that a direction takes along which the motion is imposed."""
        force = written(-self.push(direction))
        for name, acceleration in self.accelerations.items():
            force = add(force, mul(written(self.inertia(direction, name)), acceleration))
        for path, friction in zip(self.paths, self.inputs.frictions, strict=True):
            force = add(force, mul(written(path.slope(direction)), friction))
        return force

    def actuators(self) -> tuple:
        """(force along each motion that is imposed, power of all)."""
        power, forces = 0.0, tuple(self._along(("imposed", k)) for k in range(len(self.imposed)))
        for path, force in zip(self.imposed, forces, strict=True):
            power = add(power, mul(force, written(path.rate)))
        return (*forces, power) if forces else ()
