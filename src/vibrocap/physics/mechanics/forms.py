"""The forms of a class of machines: everything that is derived of them, once, as programs of their numbers.

A machine is evaluated by its form (`Described`), a class says by `Derived` what follows from its parts.
"""

import inspect
import itertools
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from vibrocap.physics.events import IMPACT
from vibrocap.physics.mechanics.dead_points import loose, pivots
from vibrocap.physics.mechanics.derivation import Derivation
from vibrocap.physics.mechanics.formulas import Program, affine, numbers_in
from vibrocap.physics.mechanics.mirror import conditions, free_conditions
from vibrocap.physics.mechanics.parts import as_sum, is_word
from vibrocap.physics.mechanics.pictures import fields_of, mechanism_of, places_of, scene_of
from vibrocap.physics.mechanics.speeds import TIME, Inputs
from vibrocap.physics.mechanics.stops import ends, guards, outcomes, rooms, switch_events
from vibrocap.physics.mechanics.sums import Sum, total, written
from vibrocap.physics.names import number_in, numbered
from vibrocap.physics.parameters import Part, bounds, parameter_table

BELT = "belt"  # channel of the energy that supports put in, and whatever else moves in time
NO_NUMBERS = (str, bool, type(None), tuple)  # values of parameters that belong to the form of the equations
NUMBER = object()  # stands for a parameter that is a number
REPEATED = 1e-9  # of rates and loads over the largest: by how much they may differ a period later


def whole_pattern(kind: type) -> tuple:
    """The parameters of a class in which every part is there that may be: a number for each that may be left out."""
    values = (info.default for info in parameter_table(kind))
    return tuple(value if isinstance(value, (str, bool, tuple)) else NUMBER for value in values)


def own_states(kind: Any) -> tuple[str, ...]:
    """Switched states that a class declares itself: `q.NAME` in its parts, changed by its own `after_switch`."""
    declared = inspect.getattr_static(kind, "switched")
    return tuple(name for name in declared if number_in(name, "touching") == 0) if isinstance(declared, tuple) else ()


class Form:
    """The mechanics of all machines of a class whose parameters that are no numbers are the same.

    pattern: the parameters in order, NUMBER for each that is one. Programs are derived when they are first asked for.
    """

    def __init__(self, kind: Any, pattern: tuple, states: tuple[str, ...], level: bool = True):
        names = [info.name for info in parameter_table(kind)]
        numbers = [name for name, value in zip(names, pattern, strict=True) if value is NUMBER]
        machine = object.__new__(kind)
        signals = (*(("drive",) if kind.imposes_motion else ()), *kind.signals)
        contacts = len(kind.kind().contact_states) if states else 0
        self.inputs = Inputs(len(states), contacts, [bounds(kind, name)[0] for name in numbers], signals)
        vars(machine).update(zip(names, pattern, strict=True))
        vars(machine).update(zip(numbers, map(Sum.of, self.inputs.parameters), strict=True))
        self.kind, self.states = kind, states
        at = dict(zip(states, self.inputs.states, strict=True))
        self.derived = Derivation(
            machine.parts,
            kind.coordinates,
            self.inputs,
            kind.gravity if level and states else self.inputs.gravity,
            at or None,
            kind.counts,
            {i: at[name] for name, i in kind.stops.items()} if states else {},
            own_states(kind),
        )
        self._programs: dict[str, Program] = {}
        self._made = kind, pattern, states, level

    def again(self) -> "Form":
        """The same anew: what is no part of the equations is derived there, so that their order stays the same."""
        return Form(*self._made)

    def dead_points(self) -> tuple:
        """What is positive until the mass matrix is singular: nothing where the parts say that it never is."""
        kind, pattern, *_ = self._made
        still = Form(kind, pattern, ()).derived  # parts without a motion: soon made
        return tuple(pivots(self.again().derived)) if loose(still) else ()

    def program(self, name: str) -> Program:
        if name not in self._programs:
            form = self.again() if name in JUDGED else self
            result = RESULTS[name](form) if name in RESULTS else getattr(form.derived, name)()
            self._programs[name] = Program(result, self.inputs.count)
        return self._programs[name]

    # --- results by name ---------------------------------------------------------------------------------------------

    def rates(self) -> tuple:
        rates = self.derived.rate_results()
        return tuple(rates.get(name, 0.0) for name in self.states)

    def powers(self) -> tuple:
        drive, damper, support = self.derived.powers()
        known = {"drive": drive, "damper": damper, BELT: support, IMPACT: 0.0}
        own = [known[name] for name in self.kind.kind().channels]
        return (*own, *(0.0 for _ in self.kind.channels[len(own) :]))  # a channel of one's own stands last

    def effects(self) -> tuple:
        """(of each rate: without effort and friction, what the effort and each friction add; of each reaction the same,
        None where it has none)."""
        effort, frictions = self.inputs.drive, self.inputs.frictions
        rates = tuple(affine(rate, (effort, *frictions)) for rate in self.rates())
        reactions = (reaction for *_, reaction, _ in self.derived.contact_results())
        loads = (reaction and (*affine(reaction[0], (effort,)), *reaction[1:]) for reaction in reactions)
        return rates, tuple(loads)

    def straight(self) -> tuple:
        """(mass of all bodies, stiffness of all springs along coordinates that are lengths)."""
        derived, stiffness = self.derived, Sum()
        for name, spring in itertools.product(derived.names, derived.springs):
            slope = derived.stretches[id(spring)].slope(name)
            if self.kind.all_coordinates[name].unit == "m" and slope.number is not None:
                stiffness = stiffness + as_sum(spring.stiffness) * (slope * slope)
        return written(total(as_sum(m.mass) for m in derived.masses)), written(stiffness)

    def outcomes(self) -> tuple:
        number, states_after = dict(self.kind.stops), []
        for outcome in outcomes(self.derived):
            after = {
                name: outcome.get(number.get(name, name), old)
                for name, old in zip(self.states, self.inputs.states, strict=True)
            }
            states_after.append(tuple(after.values()))
        return tuple(states_after)


JUDGED = ("mirror", "free", "numbers", "places")  # results that are no part of the equations
RESULTS: dict[str, Callable[[Form], Any]] = {  # all others are functions of `Derivation` by their own name
    "rates": Form.rates,
    "powers": Form.powers,
    "straight": Form.straight,
    "effects": Form.effects,
    "after_switch": Form.outcomes,
    "scene": lambda form: tuple(map(fields_of, scene_of(form.derived))),
    "places": lambda form: places_of(form.derived),
    "mechanism": lambda form: mechanism_of(form.derived),
    "contacts": lambda form: form.derived.contact_results(),
    "momentum": lambda form: form.derived.common_momentum(),
    "actuator": lambda form: form.derived.actuators(),
    "mirror": lambda form: conditions(form.derived),
    "free": lambda form: free_conditions(form.derived),
    "switches": lambda form: guards(form.derived),
    "bounds": lambda form: (*ends(form.derived), *form.dead_points()),
    "room": lambda form: rooms(form.derived),
}


class Kind:
    """What is the same of all machines of a class: it follows from one in which every part is there that may be."""

    def __init__(self, kind: Any):
        pattern = whole_pattern(kind)
        whole = self.whole = Form(kind, pattern, ()).derived
        stops = [(i, stop) for i, stop in enumerate(whole.stops) if stop.switches]
        self.contact_states = tuple(whole.speeds)
        rubs = [contact.body.name for contact in whole.contacts]
        self.contact_names = tuple(numbered(name, 1 + rubs[:i].count(name)) for i, name in enumerate(rubs))
        self.stops = {numbered("touching", k): i for k, (i, _) in enumerate(stops, start=1)}
        self.switched = (*self.stops, *own_states(kind))
        pairs = ((name, whole.rates[name]) for name in whole.names)
        self.states = (*(name for pair in pairs for name in pair), *self.switched)
        self.symmetry = tuple(1 if name in own_states(kind) else -1 for name in self.states)
        self.switch_events = switch_events(whole.stops)
        bounces = [stop for _, stop in stops if stop.restitution is not None]
        self.strikes_ground = (IMPACT,) if any(stop.on_ground for stop in bounces) else ()
        moved = any(each.slope(TIME) for _, each in whole.everything()) and not whole.imposes
        self.channels = ("drive", "damper", *((BELT,) if moved else ()), *((IMPACT,) if bounces else ()))
        self.place = whole.place
        self.rates = dict(whole.rates)
        weighs = any(is_word(contact.load) for contact in whole.contacts)
        rises = any(i in (*whole.names, TIME) or i[0] == "imposed" for m in whole.masses for i in m.height.slopes)
        self.gravity = (1.0, 0.0) if rises or weighs else None


class Described(Part):
    """A part that is evaluated by the formulas of its form."""

    gravity: Any
    states: Any
    signals: ClassVar[Mapping[str, Any]]
    imposes_motion: ClassVar[bool]
    imposed: ClassVar[Any] = None  # the drive, where it imposes a motion
    waves: ClassVar[tuple | None] = None  # of the signals; None: as the class has them

    @classmethod
    def kind(cls) -> Kind:
        """What is the same of all its machines."""
        if "_kind" not in vars(cls):
            cls._kind = Kind(cls)
            cls._forms: dict[tuple, Form] = {}
            cls._known: dict[Derived, Any] = {}
        return cls._kind

    @classmethod
    def form(cls, pattern: tuple, level: bool = True) -> Form:
        """The form of its machines with these parameters that are no numbers."""
        cls.kind()
        if (pattern, level) not in cls._forms:
            cls._forms[pattern, level] = Form(cls, pattern, cls.states, level)
        return cls._forms[pattern, level]

    def _form(self) -> tuple[Form, list]:
        values = [vars(self)[info.name] for info in parameter_table(self)]
        pattern = tuple(value if isinstance(value, NO_NUMBERS) else NUMBER for value in values)
        return self.form(pattern, self.level), [value for value in values if not isinstance(value, NO_NUMBERS)]

    @property
    def derived(self) -> Any:
        """The mechanics of its form, as formulas."""
        return self._form()[0].derived

    def evaluated(self, name: str, t: Any = 0.0, y: Any = None, drive: Any = 0.0, frictions: Any = None) -> Any:
        """What the formulas of this name give (`RESULTS`)."""
        form, numbers = self._form()
        program, contacts = form.program(name), len(form.derived.speeds)
        inputs = [t, drive, *(self.gravity or (0.0, 0.0)), *numbers]
        inputs.extend((0.0,) * len(form.states) if y is None else y)
        inputs.extend((0.0,) * contacts if frictions is None else frictions)
        own = [signal.default for signal in self.signals.values()] if self.waves is None else self.waves
        for waveform in [self.imposed, *own] if self.imposes_motion else own:  # asked for no more than is needed
            for quantity in ("value", "slope", "curvature"):
                needed = waveform is not None and len(inputs) in program.inputs
                inputs.append(getattr(waveform, quantity)(t) if needed else 0.0)
        return program(inputs)

    def constant(self, name: str) -> bool:
        """Whether the formulas of this name depend on its numbers alone."""
        return self._form()[0].program(name).inputs.isdisjoint(self.derived.inputs.changing)

    def _with(self, name: str, value: Any) -> Any:
        """The same machine with another attribute."""
        copy = object.__new__(type(self))
        vars(copy).update(vars(self) | {name: value})
        return copy

    def driven_by(self, drive, waves=None) -> Any:
        """The machine under a drive, whose value each function is given; of a motion and of signals it knows all."""
        driven = self
        if waves is not None and self.signals:
            driven = self._with("waves", tuple(wave and wave.beside(drive) for wave in waves))
        return driven._with("imposed", drive) if self.imposes_motion else driven

    def tilted(self, normal, along) -> Any:
        """The same machine under gravity with these parts, normal to the line and along it, against forward."""
        return self._with("gravity", (normal, along))

    def repeats_after(self, period: float) -> bool:
        """Whether what depends on time in its parts is the same a period later, as far as some instants tell."""
        form, names = self._form()[0], ("rates", "contacts")
        own = (value for name, values in form.inputs.signals.items() if name != "drive" for value in values)
        timed = {value.operands[0] for value in (form.inputs.t, *own)}
        if all(timed.isdisjoint(form.program(name).inputs) for name in names):
            return True
        y = [0.01 * (1 + i) for i in range(len(self.states))]
        for share in (0.0, 0.31, 0.77):
            now, later = (
                [*numbers_in([self.evaluated(name, (share + whole) * period, y) for name in names])] for whole in (0, 1)
            )
            if max(abs(a - b) for a, b in zip(now, later, strict=True)) > REPEATED * max(map(abs, now)):
                return False
        return True

    @property
    def level(self) -> bool:
        """Whether it stands on level ground, under the gravity of its class."""
        return self.gravity is type(self).gravity


# --- what a class of machines declares to follow ----------------------------------------------------------------------


class Derived:
    """A constant of a class that follows from what its machines are made of; computed when it is first asked for.

    value: of (what is the same of all machines of the class, the class); by default what has the constant's name there
    """

    def __init__(self, value: Callable[[Any, type], Any] | None = None):
        self.value = value

    def __set_name__(self, owner: type, name: str) -> None:
        self.value = self.value or (lambda kind, _: getattr(kind, name))

    def __get__(self, instance: Any, owner: Any) -> Any:
        kind, known = owner.kind(), owner._known
        if self not in known:
            assert self.value is not None
            known[self] = self.value(kind, owner)
        return known[self]


class SwitchEvents(Derived):
    """What happens at each guard: of a class at those of every stop that there may be, of a machine at its own."""

    def __get__(self, instance: Any, owner: Any) -> Any:
        return super().__get__(None, owner) if instance is None else switch_events(instance.derived.stops)


def result(name: str, doc: str) -> Any:
    """A function of a machine that is what the formulas of this name give."""

    def function(self, t, y, drive=0.0, frictions=None):
        return self.evaluated(name, t, y, drive, frictions)

    function.__name__, function.__qualname__, function.__doc__ = name, f"Machine.{name}", doc
    return function


def units_of_states(kind: Kind, owner: Any) -> dict[str, str]:
    """Of coordinates and their rates."""
    pairs = ((name, kind.rates[name], coordinate.unit) for name, coordinate in owner.all_coordinates.items())
    return {state: unit for name, rate, own in pairs for state, unit in ((name, own), (rate, f"{own}/s"))}


def cyclic_place(kind: Kind, owner: Any) -> str | None:
    """The place of the first contact, where nothing depends on it, whatever the numbers."""
    form = owner.form(whole_pattern(owner))
    at = 4 + len(form.inputs.parameters) + form.states.index(kind.place)
    names = ("rates", "energy", "contacts", "switches", "bounds")
    return None if any(at in form.program(name).inputs for name in names) else kind.place
