"""The contract of a machine with one sliding contact or several: one file per machine in this folder.

Mechanical states come first in the state vector, the internal states of the friction law after them.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from vibrocap.physics.bodies import Body, Link, Mechanism, Shape, block
from vibrocap.physics.dimensions.scales import FreeScales, Scales, SIScales
from vibrocap.physics.elementary import cos, sin, sqrt
from vibrocap.physics.mechanics.stops import IMPACT, rebounds
from vibrocap.physics.names import numbered
from vibrocap.physics.parameters import NonNegative, Number, Part, Positive, parameter, parameters

__all__ = [
    "IMPACT",
    "Body",
    "Contact",
    "Link",
    "Machine",
    "Mechanism",
    "NonNegative",
    "Number",
    "Positive",
    "SIScales",
    "Scales",
    "Shape",
    "cos",
    "parameter",
    "parameters",
    "rebounds",
    "sin",
    "sqrt",
]

IMPOSED = ("displacement", "number")  # efforts that are motions


@dataclasses.dataclass(frozen=True)
class Contact:
    """One contact of a machine at one instant: how fast it slides, what would hold it, what the ground carries there.

    velocity: sliding velocity v. holding_force: friction force that would keep it at rest, of a contact on a body of
    its own, whose acceleration depends on no other friction. acceleration, response: in place of that, of contacts
    that act on one another, the acceleration without friction and what each friction force R_j takes off it:

        a = acceleration - (response_1 R_1 + response_2 R_2 + ...)

    reaction: normal reaction N of the ground as the motion makes it, (b, n, s_1, s_2, ...) with b positive of

        b N = n + s_1 R_1 + s_2 R_2 + ...

    It is the load where the load follows the motion (`Machine.follows_load`); where loads are constants it says what a
    true one would be. None: the machine does not say.
    """

    velocity: Any
    holding_force: Any = None
    acceleration: Any = None
    response: tuple = ()
    reaction: tuple | None = None


# What machines once said of their contacts, under what stands in place of it.
BEFORE = {
    "write `contact_states`, a tuple of one name for each contact, of the state that moves with its velocity": (
        "contact_state",
    ),
    "write `contacts(self, t, y, drive)`, which gives a tuple of one `Contact` for each contact": (
        *("contacts", "contact_velocity", "holding_force", "further_velocities", "further_holding_forces"),
    ),
    "write `loads(self)`, a tuple of the load on each contact, or leave it out where the parameters normal_load, "
    "normal_load_2 and so on are the loads": ("load", "further_loads"),
    "write it as the `reaction` of a `Contact`, (b, n, s_1, ...)": ("reaction",),
    "give each `Contact` its `acceleration` and its `response`": ("coupled", "coupling"),
}


def _arguments(function: Any) -> tuple[str, ...]:
    """Names of the arguments of a function; of what is none, none."""
    code = getattr(function, "__code__", None)
    return () if code is None else code.co_varnames[: code.co_argcount]


class Machine(Part):
    """What every machine offers, as scalar functions of time, mechanical state y, drive and friction forces.

    Its contacts stand in one order everywhere, from one to as many as there are: in `contact_states`, `loads`,
    `contacts` and in the friction forces that `rates` and the others are given, a tuple.

    states: names of the mechanical states; cyclic: the one on which nothing depends (its change is the travel), None
    for a machine that is held to its place. turns: states on which everything depends with a period, such as the angle
    of a rotor, by name with that period: a motion that has gained whole turns is where it was, like one that has
    travelled.
    contact_states: of each contact, the state that moves one to one with its sliding velocity. Where distances between
    contacts are imposed, they share one state, which stands there for each of them.
    symmetry: sign of each state under the half-period symmetry. switched: those of the states that are whole numbers:
    they say which branch of the equations holds (a stop touched or not), have the rate 0.0 and change only where a
    guard of `switches` falls to zero; a run starts with all of them at 0, and with the branch that its other states ask
    for.
    switch_events: the name of what happens at each guard, "impact" for instance. strikes_ground: those of them at which
    the ground takes an impulse, as of a mass that strikes a wall on it, so that `momentum` may change. locked: states
    that stay as they are while a switched state is not 0, by the name of that state. bound_kinds: what is reached at
    each of `bounds`.
    place: the state whose rate is the velocity of the first contact plus `ground_speed`; None: `cyclic`.
    effort: what the drive is, a force along the line of sliding or a torque; or a displacement or an angle (a number)
    that it imposes.
    si_scales: the record that says what one unit of mass, length and time is in SI; its fields stand in [machine] of a
    case in SI. si_names: names in SI of parameters that are ratios without units. si_load: what may be given in SI as
    the load besides a force. state_units: SI units of states that no other machine has, "rad/s" for instance.
    gravity: its parts normal to the line and along it, against forward, as `tilted` gives them; of the class that on
    level ground, None where the units of the machine say nothing of it. weighs: whether its equations hold all of its
    weight along a slope; else `masses` says how the environment adds it.
    over_ground: whether all contacts are of bodies with the ground, which stands or moves at `ground_speed`.
    imposes_motion: whether the drive is a motion, by its effort. `driven_by` tells the machine of slope and curvature;
    contact velocities then depend on the time, and jump where the slope does.
    """

    name: ClassVar[str]
    states: ClassVar[tuple[str, ...]]
    cyclic: ClassVar[str | None]
    turns: ClassVar[Mapping[str, float]] = {}
    contact_states: ClassVar[tuple[str, ...]]
    symmetry: ClassVar[tuple[int, ...]]
    switched: ClassVar[tuple[str, ...]] = ()
    switch_events: ClassVar[tuple[str, ...]] = ()
    strikes_ground: ClassVar[tuple[str, ...]] = ()
    locked: ClassVar[Mapping[str, tuple[str, ...]]] = {}
    bound_kinds: ClassVar[tuple[str, ...]] = ()
    channels: ClassVar[tuple[str, ...]]
    effort: ClassVar[Literal["force", "torque", "displacement", "number"]] = "force"
    place: ClassVar[str | None] = None
    si_scales: ClassVar[type[Scales]] = FreeScales
    si_names: ClassVar[Mapping[str, str]] = {}
    si_load: ClassVar[str] = ""
    state_units: ClassVar[Mapping[str, str]] = {}
    gravity: ClassVar[Any] = None
    weighs: ClassVar[bool] = False
    over_ground: ClassVar[bool] = True
    imposes_motion: ClassVar[bool] = False
    imposed: ClassVar[Any] = None  # the drive, of a machine on which it imposes a motion

    def __init_subclass__(cls, **given: Any):
        """TypeError for a class that speaks of its contacts in the words of `BEFORE`, with what to write instead."""
        super().__init_subclass__(**given)
        cls.imposes_motion = cls.effort in IMPOSED
        own = {name: value for name, value in vars(cls).items() if name != "contacts" or not callable(value)}
        said = ((wanted, [name for name in names if name in own]) for wanted, names in BEFORE.items())
        found = [f"{', '.join(names)}: {wanted}" for wanted, names in said if names]
        functions = ("rates", "powers", "switches", "after_switch", "wall_force", "actuator")
        if names := [name for name in functions if "force" in _arguments(own.get(name))]:
            found.append(f"{', '.join(names)}: take the friction forces of all contacts as one tuple, `frictions`")
        if found:
            raise TypeError(f"{cls.__name__}: {'; '.join(found)}")

    @property
    def symmetric(self) -> bool:
        """Whether the machine's equations are their own mirror image, with these parameters."""
        return True

    def scales(self, time=1.0):
        """Natural size of each state, over which its error is measured, under a drive with the period `time`."""
        return (1.0,) * len(self.states)

    def effort_scale(self):
        """Natural size of the force or torque of a drive, over which the error of an actuator's is measured."""
        return 1.0

    def driven_by(self, drive) -> "Machine":
        """The machine under a drive, whose value each function is given; of a motion it knows slope and curvature."""
        if not self.imposes_motion:
            return self
        copy = object.__new__(type(self))
        vars(copy).update(vars(self) | {"imposed": drive})
        return copy

    def actuator(self, t, y, frictions) -> Mapping[str, Any]:
        """What an imposed motion takes, by name: `actuator_force` or `actuator_torque`, and `actuator_power`."""
        return {}

    def check_scales(self, scales: Scales) -> None:
        """ArgumentError for parameters that mean something else in these units."""

    def ground_speed(self):
        """Speed at which the ground moves under the contact."""
        return 0.0

    def masses(self) -> Mapping[str, Any]:
        """Every mass on which gravity acts along the line, by the state that is its velocity, over the ground or
        relative to the body at the first contact; the mass of that body stands at its contact state.

        With these a machine whose masses all move along the line can stand on a slope; one with further contacts counts
        the weight of their bodies to the forces on them itself, by `gravity`. One whose masses also move
        normal to it has their sum here and reads the rest of gravity's effect from `gravity`. Empty, the default: the
        machine does not know its weight.
        """
        return {}

    @property
    def level(self) -> bool:
        """Whether it stands on level ground, under the gravity of its class."""
        return self.gravity is type(self).gravity

    def tilted(self, normal, along) -> "Machine":
        """The same machine under gravity with these parts, normal to the line and along it, against forward."""
        copy = object.__new__(type(self))
        vars(copy).update(vars(self) | {"gravity": (normal, along)})
        return copy

    @property
    def imposes_distances(self) -> bool:
        """Whether the distances between its contacts are imposed, so that they share one state."""
        return len({*self.contact_states}) < len(self.contact_states)

    @property
    def follows_load(self) -> bool:
        """Whether the load on each contact is its `reaction`, which the motion makes, and no constant."""
        return False

    def loads(self) -> tuple:
        """Normal load on each contact, where it is constant; of loads that follow the motion what they are at rest.

        By default the parameters `normal_load`, `normal_load_2` and so on.
        """
        return tuple(getattr(self, numbered("normal_load", i + 1)) for i in range(len(self.contact_states)))

    def contacts(self, t, y, drive) -> tuple[Contact, ...]:
        """Its contacts, each as a `Contact`."""
        raise NotImplementedError

    def vertical_momentum(self, t, y) -> Any:
        """Momentum normal to the ground, whose rate is the reaction of the one contact less its load at rest.

        Given, it makes the load of a motion a short series. None: the `reaction` of the contact alone is used.
        """
        return None

    def rates(self, t, y, drive, frictions) -> tuple:
        """y', given the drive and the friction force at each contact. With its holding force as friction the
        acceleration of a contact is exactly zero, which is how one at rest is integrated.
        """
        raise NotImplementedError

    def switches(self, t, y, drive, frictions) -> tuple:
        """Guards of the branches of the equations, each positive while its branch lasts.

        Their natural size is 1. A guard may be zero after its own switch, where a stop was just reached: then its
        first derivative that is not zero says whether the branch lasts.
        """
        return ()

    def after_switch(self, which, t, y, drive, frictions) -> tuple:
        """All states after guard number `which` of `switches` has fallen to zero.

        It may change velocities, too, if it keeps `momentum`, or if its name stands in `strikes_ground`. Energy that is
        lost then is work of the channel `impact`.
        """
        raise NotImplementedError

    def bounds(self, t, y) -> tuple:
        """What is positive as long as the equations hold: a run ends where one of them falls to zero."""
        return ()

    def room(self) -> Mapping[str, tuple[float, float]]:
        """Between which values of a state a motion may start, by name, of those that rigid stops bound."""
        return {}

    def energy(self, t, y):
        """Kinetic and potential energy."""
        raise NotImplementedError

    def momentum(self, t, y):
        """Momentum along the line of sliding, whose rate is `outer_force` and `wall_force` less all friction."""
        raise NotImplementedError

    def line_momentum(self, t, y):
        """Momentum of all masses along the line: `momentum`, unless contacts are not all with the ground."""
        return self.momentum(t, y)

    def outer_force(self, t, y, drive):
        """Force from outside along the line of sliding, other than friction; none on a machine that pushes itself."""
        return 0.0

    def wall_force(self, t, y, drive, frictions):
        """Force of a wall on the ground that stops a body: as much as the other forces need, friction among them."""
        return 0.0

    def powers(self, t, y, drive, frictions):
        """Power taken in or given off through each of `channels` (positive: into the machine), but for -R v of each
        contact.
        """
        raise NotImplementedError

    def mechanism(self, t, y) -> Mechanism | None:
        """Its bodies, joints and links, at a state, for programs of rigid bodies (`Mechanism`); None, the default,
        where such a program has no parts for it: imposed motions, stops, bodies that move in a plane.
        """
        return None

    def scene(self, t, y) -> tuple[Shape, ...]:
        """What is drawn of the machine: shapes, see `Shape`; by default a block where the travelling state says."""
        place = self.place or self.cyclic
        return block(0.0 if place is None else y[self.states.index(place)], self.name)
