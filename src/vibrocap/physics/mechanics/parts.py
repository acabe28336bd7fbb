"""What a machine is made of.

Places are counted from what a part stands `on`, x along the line and z up, and turn with it: lifting or turning a body
lifts or turns what it carries. All numbers of a part may be parameters; its places, stretches and paths are functions
of the coordinates, of the time and of what the drive imposes.
"""

import dataclasses
from typing import Any

from vibrocap.physics.elementary import sqrt
from vibrocap.physics.mechanics.quantities import Direction, Quantity
from vibrocap.physics.mechanics.sums import Sum


class MechanicsError(ValueError):
    """What a description cannot mean."""


# --- bodies and places ---------------------------------------------------------------------------------------------


class Placed:
    """What has a place: `along` and `height` over the ground, and the angle `turn`, from what it stands `on`.

        along = x_0 + x cos(phi_0) - z sin(phi_0),     height = z_0 + x sin(phi_0) + z cos(phi_0) + lift

    lift stays 0: the force along it is what carries the body and all that stands on it.
    """

    name: str
    x: Any = 0.0
    z: Any = 0.0
    angle: Any = 0.0
    on: Any = None

    def __post_init__(self):
        if not isinstance(self.on, (Placed, type(None))):
            what = f"should be a body, a support or a point, None for the ground, got {self.on!r}"
            raise TypeError(f"{self.name}: the body that it stands on {what}")
        x, z, angle = Quantity.of(self.x), Quantity.of(self.z), Quantity.of(self.angle)
        self.along, self.height, self.turn = x, z, angle
        if (under := self.on) is not None:
            if under.turn.value or under.turn.moves:
                sine, cosine = under.turn.sin(), under.turn.cos()
                x, z = x * cosine - z * sine, x * sine + z * cosine
            self.along, self.height, self.turn = under.along + x, under.height + z, under.turn + angle
        self.height = self.height + Quantity(0.0, {self.lift: Sum.of(1.0)})

    @property
    def moved(self) -> tuple:
        """Its places and its angle, each with the mass or the inertia that it moves."""
        mass, inertia = getattr(self, "mass", 0.0), getattr(self, "inertia", 0.0)
        return (self.along, mass), (self.height, mass), (self.turn, inertia)

    @property
    def lift(self) -> Direction:
        """The direction that lifts it."""
        return "lift", self.name

    def stands_on(self, other: "Placed") -> bool:
        """Whether it stands on another body, or on what stands on that, or is that itself."""
        return self is other or (self.on is not None and self.on.stands_on(other))


@dataclasses.dataclass(eq=False)
class Mass(Placed):
    """A body of mass m at (x, z), and of inertia J where it turns: T = m (x'^2 + z'^2)/2 + J phi'^2/2, V = m g z.

    on: the body, support or point on which it stands; None: the ground
    """

    name: str
    mass: Any
    x: Any = 0.0
    z: Any = 0.0
    on: Any = None
    inertia: Any = 0.0
    angle: Any = 0.0


@dataclasses.dataclass(eq=False)
class Inertia(Placed):
    """A body that turns only: T = J phi'^2/2; `angle` is counted from that of what it stands on."""

    name: str
    inertia: Any
    angle: Any = 0.0
    on: Any = None
    mass = 0.0


@dataclasses.dataclass(eq=False)
class Support(Placed):
    """A belt, a table, a plate or a tube: it moves as a function of time, whatever force that takes.

    Of one that turns, and bears inertias, give the angle.
    """

    name: str
    x: Any = 0.0
    z: Any = 0.0
    on: Any = None
    angle: Any = 0.0


@dataclasses.dataclass(eq=False)
class Point(Placed):
    """A massless point of a body, which moves and turns with it."""

    name: str
    x: Any = 0.0
    z: Any = 0.0
    on: Any = None


def distance(a: Placed, b: Placed) -> Quantity:
    """Length of the line from a to b; MechanicsError where it is a level one, whose length turns round as they pass."""
    x, z = b.along - a.along, b.height - a.height
    if not z.value:
        raise MechanicsError(
            f"{a.name!r} and {b.name!r} are at one height: take their offset, whose sign says the order"
        )
    return (x * x + z * z).sqrt()


def offset(a: Placed | None, b: Placed) -> Quantity:
    """How far b is in front of a, along the line; None: the ground."""
    return b.along if a is None else b.along - a.along


# --- what acts along a stretch ---------------------------------------------------------------------------------------


@dataclasses.dataclass
class Spring:
    """V = k (s - rest)^2/2, of the stretch s."""

    stiffness: Any
    stretch: Any
    rest: Any = 0.0


@dataclasses.dataclass
class Potential:
    """What stores an energy V that is a function of the coordinates."""

    energy: Any


@dataclasses.dataclass
class Damper:
    """A force c s' against the rate of the stretch s; it takes the power c s'^2."""

    damping: Any
    stretch: Any

    @property
    def force(self) -> Sum:
        return as_sum(self.damping) * Quantity.of(self.stretch).rate


@dataclasses.dataclass
class Drag:
    """A force c s' sqrt(s'^2 + w^2) against the rate of the path s: of a fluid, quadratic above the speed w.

    Below it drag is linear, as at low Reynolds numbers; without that |s'| s' has a corner at rest.
    """

    drag: Any
    stretch: Any
    speed: Any

    @property
    def force(self) -> Sum:
        rate, slow = Quantity.of(self.stretch).rate, as_sum(self.speed)
        return as_sum(self.drag) * rate * sqrt(rate * rate + slow * slow)


@dataclasses.dataclass
class Drive:
    """A share of the drive, a force or a torque, that acts along a path s: its power is share drive s'."""

    path: Any
    share: Any = 1.0


def Motor(path: Any, drop: Any, share: Any = 1.0) -> tuple[Drive, Damper]:
    """A drive whose force falls by `drop` times the rate of its path (Kononenko 1969, linear characteristic)."""
    return Drive(path, share), Damper(drop, path)


@dataclasses.dataclass
class Stop:
    """Stops of a stretch s, in front at s = gap and, where it is given, behind at s = -back_gap.

    stiffness: of an elastic stop, a spring without mass that is touched and left where it carries nothing; damping: of
        the damper beside it; those of the stop behind, where they differ (`Stop`)
    restitution: e of a rigid one, s' := -e s'; of neither, the run ends at the stop, as "stop reached"
    between: two bodies in place of a stretch, the second in front of the first; None, or a support: the ground, which
        takes the impulse
    size: natural size of the way, by default 1 + gap; speed, force: natural sizes of a rebound and of what presses
    """

    stretch: Any = None
    gap: Any = None
    back_gap: Any = None
    between: Any = None
    stiffness: Any = None
    back_stiffness: Any = None
    damping: Any = None
    back_damping: Any = None
    restitution: Any = None
    size: Any = None
    speed: Any = 1.0
    force: Any = 1.0

    @property
    def way(self) -> Quantity:
        return Quantity.of(self.stretch) if self.between is None else offset(*self.between)

    @property
    def on_ground(self) -> bool:
        """Whether it stands on the ground or on a support."""
        return self.between is not None and any(isinstance(body, (Support, type(None))) for body in self.between)

    @property
    def elastic(self) -> bool:
        return self.stiffness is not None

    @property
    def rigid(self) -> bool:
        """Whether what strikes it bounces."""
        return self.stiffness is None and self.restitution is not None

    @property
    def switches(self) -> bool:
        """Whether it is touched and left."""
        return self.elastic or self.rigid


@dataclasses.dataclass
class Contact:
    """A body that rubs on another, or on a support or the ground: friction R acts along the path of the one on it.

    load: "dynamic", what the motion makes; "weight", of the body and of all that it carries; or a number or a function
        of coordinates and time
    factor: on the friction, which depends on place, time or coordinates; the load stays what it is. Of one that repeats
        along the ground let the coordinate say so (`repeats`): orbits are closed modulo its period
    path: of sliding, by default x of the body less x of what it rubs on (of inertias the angle)
    speed: name of the sliding velocity as a state, by default the rate of the coordinate that moves the contact alone
    """

    body: Any
    on: Any = None
    load: Any = "dynamic"
    factor: Any = 1.0
    path: Any = None
    speed: str | None = None

    @property
    def scaled(self) -> bool:
        """Whether a factor acts on its friction."""
        factor = Quantity.of(self.factor)
        return factor.moves or factor.value != 1.0


# --- what a class declares -------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Coordinate:
    """A number that says where things are; its rate is a state too.

    rate: its name, by default NAME_rate, "velocity" of the position; repeats: everything has this period in it, as in
    the angle of a rotor; count: so many of them, NAME, NAME_2, ..., in `parts` a tuple
    """

    symbol: str
    meaning: str
    unit: str
    rate: str | None = None
    repeats: float | None = None
    count: int | None = None

    def rate_of(self, name: str) -> str:
        """The name of the rate of the coordinate of a name."""
        return self.rate or ("velocity" if name == "position" else f"{name}_rate")


@dataclasses.dataclass(frozen=True)
class Signal:
    """An input beside the drive: a waveform of its own."""

    symbol: str
    meaning: str
    unit: str
    default: Any


coordinate: Any = Coordinate
signal: Any = Signal


def as_sum(x: Any) -> Sum:
    """A number or a parameter, as a sum."""
    return x.value if isinstance(x, Quantity) else Sum.of(x)


def is_word(load: Any) -> bool:
    """Whether a load is "dynamic" or "weight"."""
    return isinstance(load, str)
