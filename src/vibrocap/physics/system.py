"""A system: a machine on a friction law, moved by a drive, in an environment. Here alone their equations meet."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, Never

from vibrocap.arguments import ArgumentError, check_mapping, is_number, suggestion
from vibrocap.physics.closed_loop.actuator import ActuatedMachine, Actuator
from vibrocap.physics.closed_loop.controlled_machine import ControlledMachine
from vibrocap.physics.closed_loop.measuring import check_controller
from vibrocap.physics.closed_loop.sampling import SampledReference, check_samples
from vibrocap.physics.controllers.controller import SIDE, Controller
from vibrocap.physics.dimensions.conversion import (
    Quantity,
    parts_without_units,
    quantity,
    quantity_in_si,
    values_without_units,
)
from vibrocap.physics.dimensions.scales import Scales
from vibrocap.physics.dimensions.units import NoUnits, Units, units_of
from vibrocap.physics.drives.drive import Drive, Piecewise
from vibrocap.physics.environment import Environment
from vibrocap.physics.flow import CONTACT_CHANNELS, Flow, flow_of
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.names import (
    NAMED_LAW,
    SIGNAL,
    by_name,
    check_contacts,
    fields_of,
    kind_of,
    laws_by_state,
    laws_of,
    number_in,
    numbered,
    own_laws,
    plain_path,
    split_path,
    state_names,
    waves_of,
)
from vibrocap.physics.parameters import ParameterError, PartInSI, parameter_table
from vibrocap.quantities.declared import Context
from vibrocap.quantities.dimensional import said

PARTS = ("machine", "friction", "drive")  # of every system
# Besides laws of further contacts, each with one that may be given.
OPTIONAL = {"environment": "Environment", "actuator": "Actuator", "controller": "PositionPID"}
CONTRACTS = {
    "machine": Machine,
    "friction": Law,
    "drive": Drive,
    "environment": Environment,
    "actuator": Actuator,
    "controller": Controller,
}


@dataclasses.dataclass(frozen=True, init=False)
class System:
    """Machine, friction and drive, with an environment if any.

    The state vector holds the machine's states, then the internal states of the law. A set-valued law is given the
    force that holds the contact wherever it sticks (side 0), so that one set of equations serves sliding and sticking.

    A load that follows the motion depends on the friction that it makes, N = n + s R (`Contact.reaction`). The law then
    acts per load, R = mu N with its force at the load 1, and both follow together:

        slip   N = n/(1 - s mu)            stick   N = n + s R,  R the force that holds

    A law's stiffness and damping at the contact then grow with the load as well as its levels. While n > 0 a contact at
    rest has one continuation, stuck or slipping to one side; where n <= 0 it has lifted off. But if 1 - s mu <= 0 for a
    side, a stuck contact may also slip there, and one that slips there has no continuation, or could be at rest.

    friction: a law; of a machine with several contacts (`contacts.py`) also a list of laws, the first contact's first,
    or a mapping by the contacts' names ({"bit": law}). A contact whose law is None or missing has that of the first.
    `friction` is then the law of the first contact, `further` holds the others as they were given, `laws` that of each
    contact; in cases and paths they are "friction_2", "friction_3" and so on, or "frictions.bit"
    actuator: a lag and limits between the drive and the machine, which then feels `actuator_output`
    controller: computes the command from its measurement and from a reference, the drive
    environment: a slope, drag and a force from outside; None: level ground and nothing else
    drives: waveforms of the machine's signals by name, "drives.clamp" among the parts; by default those of the class
    units: SI value of one unit of each quantity, or None. The computation is dimensionless; a system with scales has
    results in SI (`motion.si`, columns of a sweep, files and pictures). Parts in SI, `PendulumCapsule.in_si(...)` and
    so on, bring their scales with them
    """

    machine: Machine
    friction: Law
    drive: Drive
    units: Scales | None = None
    environment: Environment | None = None
    actuator: Actuator | None = None
    further: tuple[Law | None, ...] = ()
    controller: Controller | None = None
    drives: tuple[Drive, ...] = ()

    def __init__(
        self,
        machine: Machine,
        friction: Law | Sequence[Law | None] | Mapping[str, Law],
        drive: Drive,
        units: Scales | None = None,
        environment: Environment | None = None,
        actuator: Actuator | None = None,
        further: Sequence[Law | None] = (),
        controller: Controller | None = None,
        drives: Mapping[str, Drive] | Sequence[Drive] = (),
        **others: Never,
    ):
        for name in others:
            if number_in(name, "friction"):
                what = "friction=[law, law_2, ...], that of the first contact first; None: the same as the first"
                raise ArgumentError(name, f"there is no such argument; give the laws of all contacts, {what}")
            raise TypeError(f"System.__init__() got an unexpected keyword argument {name!r}")
        kind = kind_of(machine)
        if not hasattr(kind, "signals"):
            raise TypeError(f"machine should be a machine, got {machine!r}")
        if isinstance(friction, Mapping):
            friction = by_name(friction, kind.contact_names, "frictions", "contact", {})
        laws: tuple[Any, ...] = (friction, *further)
        if isinstance(friction, (list, tuple)) and friction:
            laws = tuple(friction)
        while laws[1:] and laws[-1] is None:
            laws = laws[:-1]
        self._set(
            machine=machine,
            friction=laws[0],
            drive=drive,
            units=units,
            environment=environment,
            actuator=actuator,
            further=laws[1:],
            controller=controller,
            drives=waves_of(kind, drives),
        )
        self.__post_init__()

    def __post_init__(self):
        if any(isinstance(part, PartInSI) for part in self.parts.values()):
            plain_parts, scales = parts_without_units(self.parts, self.units)
            self._set(**fields_of(plain_parts), units=scales)
        if self.units is not None and not isinstance(self.units, Scales):
            wanted = self.machine.si_scales.__name__
            raise TypeError(f"units should be scales, {wanted}(...), got {self.units!r}")
        for part, record in self.parts.items():
            contract = Law if number_in(part, "friction") else Drive if part.startswith(SIGNAL) else CONTRACTS[part]
            if not isinstance(record, contract):
                what = contract.__name__.lower()
                raise TypeError(f"{part} should be {'an' if what[0] in 'aeiou' else 'a'} {what}, got {record!r}")
        if getattr(self.drive, "frequency", 1.0) is None:
            raise ArgumentError("drive.frequency", "should be a positive number; only a signal takes it from the drive")
        check_contacts(self.machine, 1 + len(self.further))
        for number, law in enumerate(self.laws, 1):
            if law.internal and self.machine.loads()[number - 1] == 0:
                path = numbered("machine.normal_load", number)
                raise ArgumentError(path, f"should be > 0 with the {law.name} law, got 0")
        if self.machine.imposes_motion:
            self._check_imposed()
        for name, wave in zip(self.machine.signals, self.drives, strict=True):
            if type(wave).slope is Drive.slope or isinstance(wave, Piecewise):
                what = f"{wave.name} has breakpoints or no slope; a signal is smooth"
                raise ArgumentError(f"{SIGNAL}{name}", f"the waveform {what}, such as harmonic")
        if not self.machine.driven_by(self.drive, self.drives).repeats_after(self.drive.period):
            period = said(self.drive.period * self.result_units.factor("time"), self.result_units.unit("time"), 6)
            what = f"has the period {period}, after which the {self.machine.name} is another: all that"
            with_it = "a signal without a frequency has that of the drive"
            raise ArgumentError("drive", f"{what} depends on time should repeat in it; {with_it}")
        if self.machine.imposes_motion and self.actuator is not None:
            what = f"imposes a motion on the {self.machine.name}, whatever force that takes"
            raise ArgumentError("actuator", f"should be left out: the drive {what}")
        if self.controller is not None:
            if self.controller.sampled:
                check_samples(self)
            check_controller(self.parts, self.placed)
        if self.environment is not None:
            self.environment.check(self.machine)
        if self.units is not None:
            self.machine.check_scales(self.units)

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _check_imposed(self) -> None:
        name, what = self.machine.name, ""
        if type(self.drive).slope is Drive.slope:
            what = f"imposes a motion on the {name}, but has no slope and curvature"
        elif not self.drive.continuous:
            what = f"jumps, while the {name} takes it for a displacement, of which only the rate may jump"
        if what:
            raise ArgumentError("drive", f"the waveform {self.drive.name} {what}")

    @classmethod
    def of_parts(cls, parts: Mapping[str, Any], units: Scales | None = None) -> "System":
        """The system of parts by name, as `parts` gives them back."""
        return cls(**fields_of(parts), units=units)

    @classmethod
    def unchecked(cls, parts: Mapping[str, Any]) -> "System":
        """The same of parts that hold something else in place of numbers, such as symbols; of no units."""
        system = object.__new__(cls)
        system._set(**fields_of(parts))
        return system

    @property
    def parts(self) -> dict[str, Any]:
        """The parts by name: machine, friction, drive, what else there is, laws of further contacts, signals."""
        parts = {part: getattr(self, part) for part in (*PARTS, *OPTIONAL)}
        parts |= {numbered("friction", i): law for i, law in enumerate(self.further, 2)}
        parts |= dict(zip((SIGNAL + name for name in kind_of(self.machine).signals), self.drives, strict=False))
        return {part: record for part, record in parts.items() if record is not None or part in PARTS}

    @property
    def placed(self) -> Any:
        """The machine under its drive as it stands in its environment, on the slope, behind its actuator."""
        machine = self.machine.driven_by(self.drive, self.drives)
        machine = machine if self.environment is None else self.environment.placed(machine)
        machine = machine if self.actuator is None else ActuatedMachine(machine, self.actuator)
        return machine if self.controller is None else ControlledMachine(machine, self.controller, self.timed_drive)

    @property
    def timed_drive(self) -> Any:
        """The drive; as a sampled controller is given it where there is one, in segments from sample to sample."""
        controller = self.controller
        if controller is None or not controller.sampled or isinstance(self.drive, SampledReference):
            return self.drive
        return SampledReference(self.drive, controller)

    @property
    def cyclic(self) -> str | None:
        """The state on which nothing depends, at these numbers of the machine; one that is measured is none."""
        place = self.machine.cyclic or self.machine.free_place
        return None if self.controller is not None and place in self.placed.measured_states else place

    @property
    def turns(self) -> Mapping[str, float]:
        """The states on which everything depends with a period: those of the machine that no controller measures."""
        return self.machine.turns if self.controller is None else self.placed.turns

    @property
    def si(self) -> Units:
        """Factor and SI unit of every quantity. ValueError where the scales are not known."""
        if self.units is None:
            wanted = type(self.machine).si_scales.__name__
            raise ValueError(f"units: are not known; make the system of parts in SI, or give it units={wanted}(...)")
        return units_of(self.parts, self.units)

    @property
    def result_units(self) -> Units | NoUnits:
        """Factor and unit of every quantity as results show it: in SI where the scales are known."""
        return NoUnits() if self.units is None else self.si

    def si_context(self) -> Context | None:
        """Where numbers of this system stand in SI; None where the scales are not known."""
        return None if self.units is None else Context(self)

    @property
    def dimensionless(self) -> "System":
        """The same system without units, whose results have none."""
        return self if self.units is None else dataclasses.replace(self, units=None)

    @property
    def laws(self) -> tuple[Law, ...]:
        """The law of each contact of the machine, that of the first one first."""
        return laws_of(self.parts)

    @property
    def law_names(self) -> str:
        """Their names in words, one for all contacts that have it."""
        return ", ".join(dict.fromkeys(law.name for law in self.laws))

    @property
    def contact_kinds(self) -> tuple[str, ...]:
        """The kind of each contact: that of its law, with a kink by drag and by a controller that measures its side."""
        kinked = self.environment is not None
        kinked = kinked or (self.controller is not None and SIDE in self.controller.measures(self.machine))
        return tuple("kinked" if law.kind == "smooth" and kinked else law.kind for law in self.laws)

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states, in the order of the state vector."""
        if len(self.machine.contact_states) == 1 and self.actuator is self.controller is None:  # at once: often asked
            return self.machine.states + self.friction.internal
        return state_names(self.parts)

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the energy channels, in the order of `Flow.powers`.

        Under a load that follows the motion bristles give back another energy than they took: all that they take counts
        as `contact_storage`, and none is kept.
        """
        outside = () if self.environment is None else self.environment.channels(self.machine)
        lost, stored = [], []
        for i, law in enumerate(self.laws, start=1):
            *losses, storage = (numbered(channel, i) for channel in CONTACT_CHANNELS)
            lost.append(losses)
            stored.append([storage] if law.internal and self.machine.follows_load else [])
        further = (name for names in (*lost[1:], *stored[1:]) for name in names)
        return (*self.placed.channels, *further, *outside, *lost[0], *stored[0])

    @property
    def law_loads(self) -> tuple:
        """The load that the law of each contact is given: 1 where loads follow the motion, see above."""
        return (1.0,) * len(self.machine.contact_states) if self.machine.follows_load else self.placed.loads()

    @property
    def symmetry(self) -> tuple[int, ...]:
        """Sign of each state under the half-period symmetry."""
        symmetry = self.placed.symmetry
        for _, law in laws_by_state(self.parts):
            symmetry += (-1,) * len(law.internal) if law.internal_symmetry is None else law.internal_symmetry
        return symmetry

    @property
    def switched(self) -> tuple[str, ...]:
        """Names of the states that are whole numbers: they select the branch of machine and laws."""
        laws = (numbered(name, i) for i, law in laws_by_state(self.parts) for name in law.switched)
        return (*self.placed.switched, *laws)

    def scales(self) -> tuple:
        """Natural size of each state, over which its error is measured."""
        loads = self.law_loads
        internal = (size for i, law in laws_by_state(self.parts) for size in law.internal_scales(loads[i - 1]))
        return (*self.placed.scales(self.drive.time_scale), *internal)

    @property
    def mirrored(self) -> bool:
        """Whether the half-period symmetry holds: the mirror image of a motion, half a period later, is a motion."""
        alike = self.environment is None or self.environment.symmetric
        laws = all(law.symmetric for law in self.laws)
        return self.drive.odd and self.placed.symmetric and laws and alike

    def flow(self, t, y, side) -> Flow:
        """The equations at time t and state y, each contact sliding to its `side` or stuck, see `flow_of`."""
        return flow_of(self, t, y, side)

    def rates(self, t, y, side) -> tuple:
        """y' at time t and state y, sliding to `side` or stuck (0)."""
        return self.flow(t, y, side).rates

    @property
    def parameter_paths(self) -> tuple[str, ...]:
        """Paths of all parameters, such as "machine.mass_ratio"."""
        return tuple(f"{part}.{info.name}" for part, record in self.parts.items() for info in parameter_table(record))

    def parameter(self, path: str) -> Any:
        """The value of the parameter at a path such as "machine.mass_ratio"; ValueError for a path that is none.

        Of a system that knows its scales also in SI, by the keys of a case in SI, such as "drive.frequency_Hz".
        """
        asked = quantity(path, self) if self.units is not None else Quantity(path, plain_path(path, self.machine))
        part, name = self._resolved(asked.plain)
        value = getattr(self.parts[part], name)
        return value if asked.plain == path or not is_number(value) else value * asked.scale

    def with_parameters(self, values: Mapping[str, Any]) -> "System":
        """The same system with other values at the given parameter paths; ValueError for a value that a part refuses.

        A path such as "drive.frequency" takes a value without units; of a system that knows its scales there are the
        keys of a case in SI besides, such as "drive.frequency_Hz". The scales themselves stay as they are.
        """
        check_mapping("values", values, '{"drive.amplitude": 2.0}')
        if own := own_laws(self.parts, [path for path in values if str(path).startswith(NAMED_LAW)]):
            return self.of_parts(self.parts | own, self.units).with_parameters(values)
        changes: dict[str, dict[str, Any]] = {}
        asked: dict[str, tuple[str, Any, Any]] = {}
        known = self.parameter_paths
        plain = values_without_units(values, self.units, self.parts)
        for original, (path, value) in zip(values, plain.items(), strict=True):
            part, name = split_path(path) if path in known else self._resolved(path)
            changes.setdefault(part, {})[name] = value
            asked[f"{part}.{name}"] = original, value, values[original]
        parts = self.parts
        for part, fields in changes.items():
            try:
                parts[part] = dataclasses.replace(parts[part], **fields)
            except ParameterError as error:
                raise error.within(part, asked) from None
        return self.of_parts(parts, self.units)

    def _resolved(self, path: str) -> tuple[str, str]:
        if path not in self.parameter_paths:
            part = split_path(str(path))[0]
            if part in OPTIONAL and getattr(self, part) is None:
                what = f"this system has no {part}; give it one, {part}={OPTIONAL[part]}()"
                raise ArgumentError(str(path), what)
            if 2 <= number_in(part, "friction") <= len(self.machine.contact_states):
                what = f"friction=[law, law_2, ...]; in a case by a section [{part}]"
                raise ArgumentError(str(path), f"this contact has the law of the first; give it its own, {what}")
            _ = quantity(path, self)  # in SI, where no scales are known: that is said
            known = [quantity_in_si(parameter_path, self).path for parameter_path in self.parameter_paths]
            near = suggestion(path, known, cutoff=0.0)
            raise ArgumentError(str(path), f"there is no such parameter in this system; {near}")
        return split_path(path)
