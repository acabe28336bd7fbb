"""The contract of a machine: it says what it is made of, and all else follows (`vibrocap.physics.mechanics`).

Mechanical states come first in the state vector, the internal states of the friction law after them.
"""

import dataclasses
import itertools
from collections.abc import Iterable, Mapping
from types import FunctionType
from typing import Any, ClassVar, Literal

from vibrocap.physics.dimensions.scales import (
    STANDARD_GRAVITY_M_PER_S2,
    FreeScales,
    Scales,
    SIScales,
    oscillation,
)
from vibrocap.physics.mechanics.forms import Derived, Described, SwitchEvents, cyclic_place, result, units_of_states
from vibrocap.physics.mechanics.parts import Coordinate, MechanicsError, Signal
from vibrocap.physics.mechanics.pictures import Body, Link, Mechanism, Shape
from vibrocap.physics.mechanics.stops import stopped
from vibrocap.physics.names import numbered
from vibrocap.physics.parameters import NonNegative, Number, Positive, parameter, parameters  # noqa: F401

IMPOSED = ("displacement", "angle", "number")  # efforts that are motions


@dataclasses.dataclass(frozen=True)
class Contact:
    """One contact of a machine at one instant: how fast it slides, what would hold it, what the ground carries there.

    velocity: sliding velocity v. holding_force: friction force that would keep it at rest, of a contact whose
    acceleration depends on no other friction. acceleration, response: in place of that, of contacts that act on one
    another. reaction: (n, s_1, ...) of the normal reaction N of the ground as the motion makes it:

        a = acceleration - (response_1 R_1 + response_2 R_2 + ...),     N = n + s_1 R_1 + s_2 R_2 + ...

    N is the load where that follows the motion (`Machine.follows_load`), else what a true one would be. None: not
    known. factor: on the friction, by which N is multiplied here.
    """

    velocity: Any
    holding_force: Any = None
    acceleration: Any = None
    response: tuple = ()
    reaction: tuple | None = None
    factor: Any = 1.0


class Machine(Described):
    """A machine says in `parts` what it is made of, as a function of its coordinates; all else follows.

    A class declares its parameters, its coordinates, `angle = coordinate("theta", "angle of the pendulum", "rad")`, its
    `name` and:

    effort: what the drive is, a force along the line of sliding or a torque; or a displacement or an angle (a number)
    that it imposes, `q.drive`: what `q.imposed(path)` takes along the path is shown as the actuator's
    si_scales: the record of what one unit of mass, length and time is in SI, whose fields stand in [machine] of a case
    in SI. si_names: names in SI of parameters that are ratios. si_load: what may be given in SI as the load but a force
    first_case: values by path with which a new case begins in place of defaults, so that it shows what the machine does
    gravity: its parts normal to the line and back along it, of the class those on level ground. It follows, but for
    None: the units of the machine say nothing of it, and only the environment does

    It may define `scales`, `effort_scale`, `check_scales` and `scene`, give other names to `channels`, and let `cyclic`
    be None where travel means nothing. One with `switched` states of its own has them as `q.NAME`, and defines
    `switch_events`, `switches` and `after_switch`. What follows, of the class:

    states: coordinates and their speeds in order, then `touching` of each stop. place: the state whose rate is the
    velocity of the first contact plus `ground_speed` (of the first that one coordinate alone moves). cyclic: that place
    where nothing depends on it (its change is the travel), else None. turns: coordinates that repeat, with the period
    contact_states: of each contact, in one order everywhere, the state that moves one to one with its sliding velocity;
    where distances between contacts are imposed, they share one. contact_names: the name of the body that rubs
    switched: states that are whole numbers, 1 or -1 while a stop is touched, else 0. They have the rate 0.0 and change
    where a guard of `switches` falls to zero; a run starts with all of them at 0 and the branch that its other states
    ask for. switch_events: what happens at each guard. strikes_ground: those of them that may change `momentum`
    symmetry: sign of each state under the half-period symmetry
    channels: of energy, as in `powers`: drive, damper, the belts and what else moves in time, impacts

    Frictions are one tuple, of all contacts.
    """

    name: ClassVar[str]
    effort: ClassVar[Literal["force", "torque", "displacement", "angle", "number"]] = "force"
    si_scales: ClassVar[type[Scales]] = FreeScales
    si_names: ClassVar[Mapping[str, str]] = {}
    si_load: ClassVar[str] = ""
    first_case: ClassVar[Mapping[str, float]] = {}
    gravity: ClassVar[Any] = Derived()
    symmetry: ClassVar[Any] = Derived()
    declared: ClassVar[Mapping[str, Any]] = {}
    imposes_motion: ClassVar[bool] = False

    states, contact_states, contact_names, stops, place = (Derived() for _ in range(5))
    switched, strikes_ground, channels = (Derived() for _ in range(3))
    switch_events: ClassVar[Any] = SwitchEvents()
    cyclic: ClassVar[Any] = Derived(cyclic_place)
    turns: ClassVar[Any] = Derived(
        lambda kind, owner: {name: own.repeats for name, own in owner.all_coordinates.items() if own.repeats}
    )
    state_units: ClassVar[Any] = Derived(units_of_states)

    def __init_subclass__(cls, **options: Any):
        """TypeError for a class that defines what follows from its parts."""
        super().__init_subclass__(**options)
        if own := [name for name in vars(cls) if name in FOLLOWS]:
            raise TypeError(f"{cls.__name__}: {', '.join(own)}: should be left out, it follows from `parts`")
        cls.imposes_motion = cls.effort in IMPOSED
        own = {name: value for name, value in vars(cls).items() if isinstance(value, (Coordinate, Signal))}
        cls.declared = {**cls.declared, **own}
        for name in own:
            delattr(cls, name)
        cls.signals = {name: own for name, own in cls.declared.items() if isinstance(own, Signal)}
        coordinates = {name: own for name, own in cls.declared.items() if isinstance(own, Coordinate)}
        cls.counts = {name: own.count for name, own in coordinates.items() if own.count}
        several = [(name, own, i + 1) for name, own in coordinates.items() for i in range(own.count or 1)]
        cls.all_coordinates = {numbered(name, i): own for name, own, i in several}
        cls.coordinates = {numbered(name, i): numbered(own.rate_of(name), i) for name, own, i in several}

    def parts(self, q: Any) -> Iterable:
        """The parts of the machine at coordinates q."""
        raise MechanicsError("should list the parts of the machine: def parts(self, q)")

    # --- what a class may say itself ---------------------------------------------------------------------------------

    def scales(self, time=1.0):
        """Natural size of each state, over which its error is measured, under a drive with the period `time`.

        1; in SI of lengths and speeds what the weight of all bodies gives them on all springs, where that is less: of a
        machine that only turns there is none.
        """
        sizes: dict[str, Any] = dict.fromkeys(self.states, 1.0)
        mass, stiffness = self.evaluated("straight") if self.si_scales is SIScales else (0.0, 0.0)
        if not (isinstance(mass, float) and mass == 0.0):
            moved = oscillation(mass, stiffness, mass * STANDARD_GRAVITY_M_PER_S2, time)
            for place, rate in self.rate_states.items():
                if self.all_coordinates[place].unit == "m":
                    sizes |= zip((place, rate), (size / (1.0 + size) for size in moved), strict=True)
        return tuple(sizes.values())

    def effort_scale(self):
        """Natural size of the force or torque of a drive, over which the error of an actuator's is measured."""
        return 1.0

    def check_scales(self, scales: Scales) -> None:
        """ArgumentError for parameters that mean something else in these units."""

    def scene(self, t, y) -> tuple[Shape, ...]:
        """A box for each body that rubs, a disc for each other one, and their joints."""
        return tuple(Shape(*shape) for shape in self.evaluated("scene", t, y))

    # --- what follows ------------------------------------------------------------------------------------------------

    @property
    def rate_states(self) -> dict[str, str]:
        """The state that stands for the rate of each coordinate: that of a contact, where it slides with it alone."""
        return {place: rate for place, rate in itertools.pairwise(self.states) if place in self.coordinates}

    @property
    def follows_load(self) -> bool:
        """Whether the load on each contact is its `reaction`, which the motion makes, and no constant."""
        return self.derived.moving_loads

    @property
    def symmetric(self) -> bool:
        """Whether its equations are their own mirror image, with these numbers."""
        return all(condition == 0.0 for condition in self.evaluated("mirror"))

    @property
    def free_place(self) -> str | None:
        """Its place, where nothing depends on it with these numbers, as with a spring of no stiffness; else None."""
        return self.place if all(condition == 0.0 for condition in self.evaluated("free")) else None

    @property
    def imposes_distances(self) -> bool:
        """Whether the distances between its contacts are imposed, so that they share one state."""
        return len({*self.contact_states}) < len(self.contact_states)

    @property
    def locked(self) -> Mapping[str, tuple[str, ...]]:
        """States that stay as they are while a rigid stop is touched, by the name of its state."""
        held = {name: self.derived.stops[i] for name, i in self.stops.items() if self.derived.stops[i].rigid}
        names = {name: stopped(self.derived, stop) for name, stop in held.items()}
        return {name: (coordinate, self.derived.rates[coordinate]) for name, coordinate in names.items()}

    @property
    def bound_kinds(self) -> tuple[str, ...]:
        """What is reached at each of `bounds`: stops at which a run ends, singular paths, dead points."""
        ends = [stop for stop in self.derived.stops if not stop.switches]
        stops = ("stop_reached" for stop in ends for _ in range(1 if stop.back_gap is None else 2))
        known = (*stops, *("singular_path" for _ in self.derived.folds))
        count = len(self._form()[0].program("bounds").results)
        return (*known, *("singular_mass_matrix" for _ in range(count - len(known))))

    @property
    def over_ground(self) -> bool:
        """Whether all contacts are of bodies with the ground, which stands or moves uniformly, the same under all."""
        speeds = {*self._form()[0].program("ground_speeds").results}
        return len(speeds) == 1 and None not in speeds and self.constant("ground_speeds")

    def ground_speed(self):
        """Speed at which the ground moves uniformly under all contacts."""
        return self.evaluated("ground_speeds")[0] if self.over_ground else 0.0

    def weight_along(self) -> tuple:
        """What gravity pulls along the speed of each contact, on a slope."""
        return self.evaluated("weight_along")

    def loads(self) -> tuple:
        """Load on each contact where it is constant; of loads that follow the motion what they are at rest."""
        return self.evaluated("loads")

    rates = result("rates", "y', given the drive and the friction force at each contact.")
    switches = result("switches", "Guards, positive while their branch lasts: a stop is reached, left, reached behind.")
    bounds = result("bounds", "What is positive while the equations hold: ways to the stops at which a run ends.")
    energy = result("energy", "Kinetic and potential energy, but for that of the weight along a slope.")
    momentum = result("momentum", "Momentum whose rate is `outer_force` and `wall_force` less all friction.")
    line_momentum = result("line_momentum", "Momentum of all masses along the line.")
    equations_of_motion = result("equations_of_motion", "Its equations of motion before they are solved.")
    outer_force = result("outer_force", "Force from outside along the line of sliding, its weight on a slope included.")
    wall_force = result("wall_force", "Force of a rigid stop on the ground that is touched.")
    powers = result("powers", "Power into the machine through each of `channels`, but for -R v of each contact.")

    def contacts(self, t, y, drive) -> tuple[Contact, ...]:
        return tuple(Contact(*contact) for contact in self.evaluated("contacts", t, y, drive))

    def after_switch(self, which, t, y, drive, frictions) -> tuple:
        """All states after guard number `which` of `switches` has fallen to zero."""
        return self.evaluated("after_switch", t, y, drive, frictions)[which]

    def room(self) -> Mapping[str, tuple[Any, Any]]:
        """Between which values of a state a motion may start, by name, of those that stops bound."""
        return {name: (low, high) for name, low, high in self.evaluated("room")}

    def actuator(self, t, y, frictions) -> Mapping[str, Any]:
        """What an imposed motion takes, by name: `actuator_force` or `actuator_torque`, and `actuator_power`."""
        if not self.imposes_motion or not (actuator := self.evaluated("actuator", t, y, 0.0, frictions)):
            return {}
        name = "actuator_torque" if self.effort in ("angle", "number") else "actuator_force"
        named = {numbered(name, i): force for i, force in enumerate(actuator[:-1], start=1)}
        return {**named, "actuator_power": actuator[-1]}

    def mechanism(self, t, y) -> Mechanism | None:
        """Its bodies, joints and links, at a state; None where programs of rigid bodies have no parts for it."""
        if (mechanism := self.evaluated("mechanism", t, y)) is None:
            return None
        bodies, links = mechanism
        return Mechanism(tuple(Body(*body) for body in bodies), tuple(Link(*link) for link in links))


SWITCHED = {"switched", "switch_events", "strikes_ground", "switches", "after_switch"}
OWN = SWITCHED | {"cyclic", "channels", "gravity", "scales", "effort_scale", "check_scales", "scene", "parts"}
FOLLOWS = {
    name
    for name, value in {**vars(Described), **vars(Machine)}.items()
    if name[0] != "_" and name not in OWN and isinstance(value, (Derived, property, FunctionType))
}


class ConsistentUnits(Machine):
    """A machine whose parameters stand in any consistent units, SI as well as none: its loads give natural sizes."""

    stiffness: Any
    si_scales: ClassVar = SIScales

    def sized_by(self):
        """The stiffness by which the sizes are told."""
        return self.stiffness

    def scales(self, time=1.0):
        """Amplitude and speed that a force of the size of all loads gives to all masses, of each coordinate."""
        sizes = oscillation(self.evaluated("whole_mass"), self.sized_by(), self.effort_scale(), time)
        return sizes * len(self.coordinates) + (1.0,) * len(self.switched)

    def effort_scale(self):
        return sum(self.loads())
