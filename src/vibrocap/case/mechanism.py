"""[mechanism] of a case: a machine described in TOML, by its parts (`vibrocap.mechanics`), without any Python.

[mechanism] is the class, [machine] has the values of its parameters. `PARTS` and `TABLES` list all keys. A description
becomes a class like that of any kind; it keeps the tables that it was read from, so that cases, studies and other
processes have it again. Nothing of a description is run: its expressions are parsed (`expressions`).
"""

import contextlib
import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, ClassVar

from vibrocap.arguments import ArgumentError, Complaints, listed, shown
from vibrocap.case.expressions import Expression
from vibrocap.physics.dimensions.scales import STANDARD_GRAVITY_M_PER_S2, SIScales
from vibrocap.physics.elementary import sqrt
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.mechanics.forms import Derived
from vibrocap.physics.mechanics.parts import (
    Contact,
    Damper,
    Drag,
    Drive,
    Inertia,
    Mass,
    Motor,
    Point,
    Potential,
    Spring,
    Stop,
    Support,
    as_sum,
)
from vibrocap.physics.mechanics.sums import total
from vibrocap.physics.names import numbered
from vibrocap.physics.parameters import ParameterError, parameter_table

KIND = "mechanism"  # in [machine], besides the mechanism's own name
VERSION = 1
NAME, BODY, BODIES, STRETCH = "a name", "a body", "two bodies", "m or rad"
LOADS = ("dynamic", "weight")
NARROWEST_M = 1e-9  # a gap of a stop, where it has none
PLACE = {"name": NAME, "on": BODY, "x": "m", "z": "m"}

# part: (what makes it, {key: what stands there or its unit}, the keys that it needs)
PARTS: dict[str, tuple[Callable, dict[str, str], tuple[str, ...]]] = {
    "support": (Support, PLACE | {"angle": "rad"}, ("name",)),
    "mass": (Mass, PLACE | {"mass": "kg", "inertia": "kg m^2", "angle": "rad"}, ("name", "mass")),
    "inertia": (Inertia, {"name": NAME, "on": BODY, "inertia": "kg m^2", "angle": "rad"}, ("name", "inertia")),
    "point": (Point, PLACE, ("name", "on")),
    "spring": (Spring, {"stiffness": "J/stretch^2", "stretch": STRETCH, "rest": "stretch"}, ("stiffness", "stretch")),
    "damper": (Damper, {"damping": "J s/stretch^2", "stretch": STRETCH}, ("damping", "stretch")),
    "drag": (Drag, {"drag": "J s^2/stretch^3", "stretch": STRETCH, "speed": "stretch/s"}, ("drag", "stretch", "speed")),
    "potential": (Potential, {"energy": "J"}, ("energy",)),
    "drive": (Drive, {"path": "J/drive", "share": "1"}, ("path",)),
    "motor": (Motor, {"path": "J/drive", "drop": "J s/stretch^2", "share": "1"}, ("path", "drop")),
    "stop": (
        Stop,
        {
            "stretch": STRETCH,
            "between": BODIES,
            "gap": "stretch",
            "back_gap": "stretch",
            "restitution": "1",
            "stiffness": "J/stretch^2",
            "damping": "J s/stretch^2",
            "back_stiffness": "J/stretch^2",
            "back_damping": "J s/stretch^2",
        },
        ("gap",),
    ),
    "contact": (
        Contact,
        {"body": BODY, "on": BODY, "path": STRETCH, "load": "J/stretch", "factor": "1", "speed": NAME},
        ("body",),
    ),
}
# table: its keys
TABLES: dict[str, tuple[str, ...]] = {
    "parameters": ("default", "role", "unit", "range", "words", "symbol", "meaning"),
    "coordinates": ("unit", "symbol", "meaning", "rate", "repeat", "repeats"),
    "signals": ("unit", "symbol", "meaning"),
}
HEAD = ("version", "name", "source", "effort", "units", "gravity", "travels")


class MechanismError(ValueError):
    """A description that cannot be a machine: `complaints` holds every one, with its path."""

    def __init__(self, complaints: Iterable[str]):
        self.complaints = tuple(complaints)
        super().__init__("; ".join(self.complaints))

    def __reduce__(self):
        return type(self), (self.complaints,)


class Mechanism(Machine):
    """A machine that a case describes; `description`: the tables of [mechanism].

    weight: gravity; weighs: whether it is said, or counts in loads that a parameter makes the weight
    """

    description: ClassVar[Mapping[str, Any]]
    planned: ClassVar[tuple["Planned", ...]]
    weight: ClassVar[float]
    weighs: ClassVar[bool]
    required: ClassVar[tuple[str, ...]]
    gravity: ClassVar[Any] = Derived(lambda kind, owner: (owner.weight, 0.0) if kind.gravity or owner.weighs else None)

    def parts(self, q):
        """What stands in the description, at these coordinates."""
        at = {info.name: getattr(self, info.name) for info in parameter_table(type(self))}
        for name, var in vars(q).items():
            several = var if isinstance(var, tuple) else ()
            at |= {numbered(name, i): x for i, x in enumerate(several, 1)} if several else {name: var}
            at |= {f"{name}_1": several[0]} if several else {}
        if self.imposes_motion:
            at["drive"] = q.imposed(q.drive)
        bodies: dict[str, Any] = {"ground": None}
        parts = [plan.made(at, bodies) for plan in self.planned]
        if self.si_scales is SIScales:
            self._size_stops(parts)
        return parts

    def _size_stops(self, parts: list[Any]) -> None:
        """Give rigid stops in metres natural sizes: the speed of a fall through their gaps, the weight of all masses.

        1 m/s and 1 N say nothing of a stage that moves by nanometres.
        """
        weight = STANDARD_GRAVITY_M_PER_S2 * total(as_sum(part.mass) for part in parts if isinstance(part, Mass))
        for stop in parts:
            if isinstance(stop, Stop) and stop.rigid:
                units = {own.unit for name, own in self.all_coordinates.items() if name in stop.way.slopes}
                if units == {"m"}:
                    gap, back = as_sum(stop.gap), as_sum(stop.back_gap or 0.0)
                    fall = sqrt(gap * gap + back * back + NARROWEST_M * NARROWEST_M)
                    stop.speed, stop.force = sqrt(STANDARD_GRAVITY_M_PER_S2 * fall), weight

    def check_start(self, system: Any, initial: Mapping[str, float]) -> None:
        """MechanismError where its equations cannot be computed at the start of a run: they divide by zero there."""
        with placed(KIND):
            y = tuple(float(initial.get(name, 0.0)) for name in self.states)
            nothing = (0.0,) * len(self.contact_states)
            try:
                rates = self.driven_by(system.drive, system.drives).rates(0.0, y, system.drive.value(0.0), nothing)
            except ZeroDivisionError:
                why = "an expression does, or its mass matrix is singular there"
                raise ValueError(f"divides by zero at the start: {why}") from None
            if not all(map(math.isfinite, rates)):
                lost = listed(name for name, rate in zip(self.states, rates, strict=True) if not math.isfinite(rate))
                raise ValueError(f"the rate of {lost} is not finite at the start")


@dataclasses.dataclass(frozen=True)
class Planned:
    """A part of a description: its path there, what makes it, and what it is made of."""

    where: str
    make: Callable
    fields: Mapping[str, Any]

    @property
    def needs(self) -> tuple[str, ...]:
        """The bodies that it names."""
        named = (self.fields.get(key) for key in ("on", "body", "between"))
        names = [name for entry in named if entry for name in ([entry] if isinstance(entry, str) else entry)]
        for field in self.fields.values():
            names += field.bodies_named if isinstance(field, Expression) else ()
        return tuple(name for name in names if name != "ground")

    def made(self, at: Mapping[str, Any], bodies: dict[str, Any]) -> Any:
        """The part, where names stand for these; a body is known to later ones by its name."""
        arguments = {}
        for key, field in self.fields.items():
            if key in ("on", "body"):
                arguments[key] = bodies[field]
            elif key == "between":
                arguments[key] = tuple(bodies[name] for name in field)
            elif isinstance(field, Expression):
                with placed(f"{self.where}.{key}", field.text):
                    arguments[key] = field(at, bodies)
            else:
                arguments[key] = field
        with placed(self.where):
            part = self.make(**arguments)
        if isinstance(arguments.get("name"), str):
            bodies[arguments["name"]] = part
        return part


@contextlib.contextmanager
def placed(where: str, text: str = "") -> Iterator[None]:
    """Errors of mechanics and arithmetic become complaints about a place of the description."""
    try:
        yield
    except (MechanismError, ArgumentError, ParameterError):
        raise
    except (ArithmeticError, TypeError, ValueError, KeyError) as error:
        words = "divides by zero" if isinstance(error, ZeroDivisionError) else str(error)
        complaints = Complaints()
        complaints.add(where, f"{shown(text)}: {words}" if text else words)
        raise MechanismError(complaints) from None
