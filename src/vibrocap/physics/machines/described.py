"""A machine that says what it is made of: all of the contract of a machine follows (`vibrocap.physics.mechanics`)."""

import dataclasses
import functools
import itertools
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar

from vibrocap.physics.bodies import Mechanism, Shape
from vibrocap.physics.machines.machine import Contact, Machine
from vibrocap.physics.mechanics.forms import NO_NUMBERS, NUMBER, Form, Kind, own_states, table, whole_pattern
from vibrocap.physics.mechanics.parts import Coordinate, MechanicsError, Signal
from vibrocap.physics.mechanics.pictures import filled
from vibrocap.physics.mechanics.stops import stopped
from vibrocap.physics.names import numbered

SAMPLES = (0.037, -0.021, 0.055, 0.013, -0.044, 0.029)  # states at which a machine is compared with its mirror image


class Derived:
    """A constant of a class that follows from what its machines are made of; computed when it is first asked for.

    value: of (what is the same of all machines of the class, the class); by default what has the constant's name there
    """

    def __init__(self, value: Callable[[Any, type], Any] | None = None):
        self.value = value

    def __set_name__(self, owner: type, name: str) -> None:
        self.value = self.value or (lambda kind, _: getattr(kind, name))

    def __get__(self, instance: Any, owner: type["Described"]) -> Any:
        assert self.value is not None
        return self.value(owner.kind(), owner)


def result(name: str, doc: str) -> Any:
    """A function of a machine that is what the formulas of this name give."""

    def function(self, t, y, drive=0.0, frictions=None):
        return self._result(name, t, y, drive, frictions)

    function.__name__, function.__qualname__, function.__doc__ = name, f"Described.{name}", doc
    return function


class Described(Machine):
    """A machine that says in `parts` what it is made of, as a function of its coordinates; all else follows.

    A class declares its parameters, its coordinates, `angle = coordinate("theta", "angle of the pendulum", "rad")`, its
    name and what the drive is (`effort`). With the effort "displacement" or "number" the drive imposes a motion,
    `q.drive`; along `q.imposed(path)` what this takes is shown as the actuator's. A class with `switched` states of its
    own has them as `q.NAME`, and defines `switches` and `after_switch`.
    """

    declared: ClassVar[Mapping[str, Any]] = {}
    weighs: ClassVar[bool] = True
    states: ClassVar[Any] = Derived()
    contact_states: ClassVar[Any] = Derived()
    switched: ClassVar[Any] = Derived()
    switch_events: ClassVar[Any] = Derived()
    strikes_ground: ClassVar[Any] = Derived()
    channels: ClassVar[Any] = Derived()
    stops: ClassVar[Any] = Derived()
    place: ClassVar[Any] = Derived()
    gravity: ClassVar[Any] = Derived()
    symmetry: ClassVar[Any] = Derived(lambda _, owner: tuple(1 if n in own_states(owner) else -1 for n in owner.states))
    cyclic: ClassVar[Any] = Derived(lambda kind, owner: _cyclic(owner))
    turns: ClassVar[Any] = Derived(
        lambda kind, owner: {name: each.repeats for name, each in owner.all_coordinates.items() if each.repeats}
    )
    state_units: ClassVar[Any] = Derived(
        lambda kind, owner: {
            state: unit
            for name, each in owner.all_coordinates.items()
            for state, unit in ((name, each.unit), (kind.rates[name], f"{each.unit}/s"))
        }
    )

    def __init_subclass__(cls, **given: Any):
        super().__init_subclass__(**given)
        own = {name: value for name, value in vars(cls).items() if isinstance(value, (Coordinate, Signal))}
        cls.declared = {**cls.declared, **own}
        for name in own:
            delattr(cls, name)
        declared = cls.declared.items()
        cls.signals = {name: each for name, each in declared if isinstance(each, Signal)}
        cls.counts = {name: each.count for name, each in declared if isinstance(each, Coordinate) and each.count}
        cls.all_coordinates = {
            numbered(name, i + 1): each
            for name, each in declared
            if isinstance(each, Coordinate)
            for i in range(each.count or 1)
        }
        cls.coordinates = {
            numbered(name, i + 1): numbered(each.rate or ("velocity" if name == "position" else f"{name}_rate"), i + 1)
            for name, each in declared
            if isinstance(each, Coordinate)
            for i in range(each.count or 1)
        }

    def parts(self, q: Any) -> Iterable:
        """What the machine is made of, at coordinates q."""
        raise MechanicsError("should give what the machine is made of: def parts(self, q)")

    @classmethod
    def kind(cls) -> Kind:
        """What is the same of all its machines."""
        if "_kind" not in vars(cls):
            cls._kind = Kind(cls)
            cls._forms: dict[tuple, Form] = {}
        return cls._kind

    @classmethod
    def form(cls, pattern: tuple, level: bool = True) -> Form:
        """The form of its machines with these parameters that are no numbers."""
        cls.kind()
        if (pattern, level) not in cls._forms:
            cls._forms[pattern, level] = Form(cls, pattern, cls.states, level)
        return cls._forms[pattern, level]

    # --- evaluation --------------------------------------------------------------------------------------------------

    def _form(self) -> tuple[Form, list]:
        """Its form, and its numbers."""
        cls, values = type(self), vars(self)
        given = [values[info.name] for info in table(cls)]
        numbers = [each for each in given if not isinstance(each, NO_NUMBERS)]
        pattern = tuple(each if isinstance(each, NO_NUMBERS) else NUMBER for each in given)
        return cls.form(pattern, self.level), numbers

    def _result(self, name: str, t: Any = 0.0, y: Any = None, drive: Any = 0.0, frictions: Any = None) -> Any:
        """What the formulas of this name give."""
        form, numbers = self._form()
        program, contacts = form.program(name), len(form.derived.speeds)
        normal, along = self.gravity or (0.0, 0.0)
        inputs = [t, drive, normal, along, *numbers]
        inputs.extend((0.0,) * len(form.states) if y is None else y)
        inputs.extend((0.0,) * contacts if frictions is None else frictions)
        for waveform in self._signals():  # asked for no more than the formulas need
            for quantity in ("value", "slope", "curvature"):
                needed = waveform is not None and len(inputs) in program.inputs
                inputs.append(getattr(waveform, quantity)(t) if needed else 0.0)
        return program(inputs)

    def _signals(self) -> list:
        """The waveform of each signal, that of the drive first where it imposes a motion."""
        own = [each.default for each in type(self).signals.values()]
        return [self.imposed, *own] if self.imposes_motion else own

    # --- what follows ------------------------------------------------------------------------------------------------

    @property
    def symmetric(self) -> bool:
        """Whether its equations are their own mirror image; of numbers that are written down, those of the defaults.

        A class in which it depends on its numbers, and that is to be shown in a page, declares the condition itself.
        """
        plain = all(isinstance(value, (int, float, str, tuple, type(None))) for value in vars(self).values())
        return _symmetric(self if plain else type(self)())

    @property
    def follows_load(self) -> bool:
        """Whether the load on a contact follows the motion."""
        return self._form()[0].derived.moving_loads

    @property
    def locked(self) -> Mapping[str, tuple[str, ...]]:  # type: ignore[override]
        """At a rigid stop the coordinate and its speed stay as they are."""
        derived = self._form()[0].derived
        held = {name: derived.stops[i] for name, i in self.stops.items() if derived.stops[i].rigid}
        names = {name: stopped(derived, stop) for name, stop in held.items()}
        return {name: (each, derived.rates[each]) for name, each in names.items()}

    @property
    def bound_kinds(self) -> tuple[str, ...]:  # type: ignore[override]
        """A run ends at each stop that is neither elastic nor rigid."""
        ends = [stop for stop in self._form()[0].derived.stops if not stop.switches]
        return tuple("stop_reached" for stop in ends for _ in range(1 if stop.back_gap is None else 2))

    @property
    def over_ground(self) -> bool:  # type: ignore[override]
        """Whether all contacts are of bodies with the ground, which stands or moves uniformly, the same under all."""
        program, inputs = self._form()[0].program("ground_speeds"), self._form()[0].inputs
        fixed = range(2, 4 + len(inputs.parameters))
        speeds = set(program.results)
        return len(speeds) == 1 and None not in speeds and program.inputs <= {*fixed}

    def ground_speed(self):
        """Speed at which the ground moves uniformly under all contacts."""
        return self._result("ground_speeds")[0] if self.over_ground else 0.0

    def masses(self) -> Mapping[str, Any]:
        """The mass whose weight pulls along each contact, on a slope."""
        return dict(zip(dict.fromkeys(self.contact_states), self._result("masses"), strict=True))

    def loads(self) -> tuple:
        """Load on each contact, or the one at rest."""
        return self._result("loads")

    rates = result("rates", "y'.")
    energy = result("energy", "Kinetic and potential energy, but for that of the weight along a slope.")
    momentum = result("momentum", "Momentum along the line of sliding.")
    line_momentum = result("line_momentum", "Momentum of all masses along the line.")
    vertical_momentum = result("vertical_momentum", "Momentum normal to the ground of what stands on the one contact.")
    outer_force = result("outer_force", "Force from outside along the line of sliding, its weight on a slope included.")
    wall_force = result("wall_force", "Force of a rigid stop on the ground that is touched.")
    powers = result("powers", "Power through each channel.")
    switches = result("switches", "Of each stop: it is reached in front, left, reached behind.")
    bounds = result("bounds", "Ways to the stops at which a run ends.")

    def contacts(self, t, y, drive) -> tuple[Contact, ...]:
        """Its contacts."""
        return tuple(Contact(*each) for each in self._result("contacts", t, y, drive))

    def after_switch(self, which, t, y, drive, frictions) -> tuple:
        """All states after a stop is reached or left."""
        return self._result("after_switch", t, y, drive, frictions)[which]

    def room(self) -> Mapping[str, tuple[Any, Any]]:
        """Between the stops that no motion passes."""
        return {name: (low, high) for name, low, high in self._result("room")}

    def actuator(self, t, y, frictions) -> Mapping[str, Any]:
        """The force along each imposed coordinate, and the power of all."""
        if not self.imposes_motion or not (found := self._result("actuator", t, y, 0.0, frictions)):
            return {}
        name = "actuator_torque" if self.effort == "number" else "actuator_force"
        named = {numbered(name, i): force for i, force in enumerate(found[:-1], start=1)}
        return {**named, "actuator_power": found[-1]}

    def mechanism(self, t, y) -> Mechanism | None:
        """Its bodies and joints, where programs of rigid bodies have them."""
        results = self._result("mechanism", t, y)
        bodies = self._form()[0].bodies
        return None if bodies is None else filled(bodies, results)

    def scene(self, t, y) -> tuple[Shape, ...]:
        """A box for each body that rubs, a disc for each other one, and what joins them."""
        results = self._result("scene", t, y)
        shapes = self._form()[0].shapes
        return tuple(dataclasses.replace(each, points=points) for each, points in zip(shapes, results, strict=True))


class Sample:
    """A motion that a drive may impose, or its mirror image."""

    def __init__(self, sign: float):
        self.sign = sign

    def value(self, t):
        """z."""
        return self.sign * 0.31

    def slope(self, t):
        """z'."""
        return self.sign * 0.23

    def curvature(self, t):
        """z''."""
        return self.sign * -0.17


def _cyclic(kind: type[Described]) -> str | None:
    """The place of the first contact, where nothing depends on it."""
    form, place = kind.form(whole_pattern(kind)), kind.kind().place
    at = 4 + len(form.inputs.parameters) + form.states.index(place)
    names = ("rates", "energy", "contacts", "switches", "bounds")
    return None if any(at in form.program(name).inputs for name in names) else place


@functools.lru_cache(maxsize=256)
def _symmetric(machine: Described) -> bool:
    """Whether the equations of a machine are their own mirror image, by what they are at two states."""
    sample = [SAMPLES[i % len(SAMPLES)] for i in range(len(machine.states))]
    try:
        return all(_mirrored(machine, sample, touching) for touching in ((0.0, 1.0) if machine.switched else (0.0,)))
    except (ValueError, ZeroDivisionError):  # the mirror image is beyond what the machine can reach
        return False


@functools.lru_cache(maxsize=256)
def free_place(machine: Machine) -> str | None:
    """The place of a machine on which nothing depends at its numbers, as with a spring of no stiffness; else None."""
    if machine.place is None:
        return None
    at, found = machine.states.index(machine.place), []
    frictions = tuple(0.3 - 0.2 * i for i in range(len(machine.contact_states)))
    machine = machine.driven_by(Sample(1.0))
    try:
        for touching, moved in itertools.product((0.0, 1.0), (0.0, 0.41, -0.37)):
            y = [SAMPLES[i % len(SAMPLES)] for i in range(len(machine.states))]
            y = [touching if name in machine.switched else x for name, x in zip(machine.states, y, strict=True)]
            y[at] += moved
            given, state = (0.7, y, 0.4), (0.7, y)
            known = (machine.rates(*given, frictions), machine.energy(*state), machine.contacts(*given))
            found.append((*known, machine.switches(*given, frictions), machine.bounds(*state)))
    except (ValueError, ZeroDivisionError):  # beyond what the machine can reach
        return None
    return machine.place if found[0] == found[1] == found[2] and found[3] == found[4] == found[5] else None


def _mirrored(given: Described, sample: list[float], touching: float) -> bool:
    y = tuple(touching if name in given.switched else x for name, x in zip(given.states, sample, strict=True))
    frictions, found = tuple(0.3 - 0.2 * i for i in range(len(given.contact_states))), []
    for sign in (1.0, -1.0):
        machine = given.driven_by(Sample(sign))
        mirrored = tuple(sign * x if s < 0 else x for s, x in zip(given.symmetry, y, strict=True))
        at = 0.7, mirrored, sign * 0.4, tuple(sign * each for each in frictions)
        loads = [each.reaction for each in machine.contacts(*at[:3]) if each.reaction is not None]
        pressed = [(n + sum(s * r for s, r in zip(more, at[3], strict=True))) / b for b, n, *more in loads]
        rates = [sign * x if s < 0 else x for s, x in zip(given.symmetry, machine.rates(*at), strict=True)]
        found.append([*rates, *pressed, machine.energy(*at[:2]), *sorted(machine.switches(*at))])
    return all(abs(a - b) <= 1e-13 * (1.0 + abs(a)) for a, b in zip(*found, strict=True))
