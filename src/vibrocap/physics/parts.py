"""The parts of a system, checked as they are put together, by name and with the parameters of all of them by path."""

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any, Never, Self

from vibrocap.arguments import ArgumentError, suggestion
from vibrocap.physics.actuator import Actuator
from vibrocap.physics.conversion import parts_without_units
from vibrocap.physics.drives.drive import Drive
from vibrocap.physics.environment import Environment
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Imposed, Machine
from vibrocap.physics.numbering import number_in, numbered
from vibrocap.physics.parameters import ParameterError, parameter_table
from vibrocap.physics.part import PartInSI
from vibrocap.physics.scales import Scales
from vibrocap.physics.states import further_laws

PARTS = ("machine", "friction", "drive")  # of every system
OPTIONAL = ("environment", "actuator")  # besides laws of further contacts
CONTRACTS = {
    "machine": Machine,
    "friction": Law,
    "drive": Drive,
    "environment": Environment,
    "actuator": Actuator,
}


@dataclasses.dataclass(frozen=True, init=False)
class Parts:
    """What a `System` is made of, which has the equations of it all; the fields are described there."""

    machine: Machine
    friction: Law
    drive: Drive
    units: Scales | None = None
    environment: Environment | None = None
    actuator: Actuator | None = None
    further: tuple[Law | None, ...] = ()

    def __init__(
        self,
        machine: Machine,
        friction: Law | Sequence[Law | None],
        drive: Drive,
        units: Scales | None = None,
        environment: Environment | None = None,
        actuator: Actuator | None = None,
        further: Sequence[Law | None] = (),
        **others: Never,
    ):
        for name in others:
            if number_in(name, "friction"):
                what = "friction=[law, law_2, ...], that of the first contact first; None: the same as the first"
                raise ArgumentError(name, f"there is no such argument; give the laws of all contacts, {what}")
            raise TypeError(f"System.__init__() got an unexpected keyword argument {name!r}")
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
        )
        self.__post_init__()

    def __post_init__(self):
        given = self.parts
        if any(isinstance(part, PartInSI) for part in given.values()):
            found, scales = parts_without_units(given, self.units)
            self._set(**_fields(found), units=scales)
        if self.units is not None and not isinstance(self.units, Scales):
            wanted = self.machine.si_scales.__name__
            raise TypeError(f"units should be scales, {wanted}(...), got {self.units!r}")
        for part, given in self.parts.items():
            contract = Law if number_in(part, "friction") else CONTRACTS[part]
            if not isinstance(given, contract):
                what = contract.__name__.lower()
                raise TypeError(f"{part} should be {'an' if what[0] in 'aeiou' else 'a'} {what}, got {given!r}")
        if self.friction.internal and self.machine.normal_load == 0:
            raise ArgumentError("machine.normal_load", f"should be > 0 with the {self.friction.name} law, got 0")
        _check_contacts(self.machine, 1 + len(self.further))
        for number, (law, load) in enumerate(zip(self.further_laws, self.machine.further_loads(), strict=True), 2):
            if law.internal and load == 0:
                path = numbered("machine.normal_load", number)
                raise ArgumentError(path, f"should be > 0 with the {law.name} law, got 0")
        if isinstance(self.machine, Imposed):
            self._check_imposed()
            if self.actuator is not None:
                what = f"imposes a motion on the {self.machine.name}, whatever force that takes"
                raise ArgumentError("actuator", f"should be left out: the drive {what}")
        if self.environment is not None:
            self.environment.check(self.machine)

    def _set(self, **values: Any) -> None:
        """Give fields their values, while the system is made."""
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _check_imposed(self) -> None:
        """ArgumentError for a drive that cannot impose a motion."""
        if type(self.drive).slope is Drive.slope:
            what = f"imposes a motion on the {self.machine.name}, but does not say how fast that is (slope, curvature)"
            raise ArgumentError("drive", f"the waveform {self.drive.name} {what}")
        if not self.drive.continuous:
            what = f"jumps, while the {self.machine.name} takes it for a displacement, of which only the rate may jump"
            raise ArgumentError("drive", f"the waveform {self.drive.name} {what}")

    @classmethod
    def of_parts(cls, parts: Mapping[str, Any], units: Scales | None = None) -> Self:
        """The system of parts by name, as `parts` gives them back."""
        return cls(**_fields(parts), units=units)

    @classmethod
    def unchecked(cls, parts: Mapping[str, Any]) -> Self:
        """The same of parts that hold something else in the place of numbers, such as symbols; of no units."""
        made = object.__new__(cls)
        made._set(**_fields(parts))
        return made

    @property
    def parts(self) -> dict[str, Any]:
        """The parts by name: machine, friction, drive, then those that may be left out and are not, the laws of further
        contacts ("friction_2", ...) last."""
        found = {part: getattr(self, part) for part in (*PARTS, *OPTIONAL)}
        found |= {numbered("friction", i): law for i, law in enumerate(self.further, 2)}
        return {part: record for part, record in found.items() if record is not None or part in PARTS}

    @property
    def further_laws(self) -> tuple[Law, ...]:
        """The law of each further contact of the machine."""
        return further_laws(self.parts) if self.machine.contacts else ()

    @property
    def parameter_paths(self) -> tuple[str, ...]:
        """Paths of all parameters, such as "machine.mass_ratio"."""
        return tuple(f"{part}.{info.name}" for part, record in self.parts.items() for info in parameter_table(record))

    def parameter(self, path: str) -> Any:
        """The value of the parameter at a path such as "machine.mass_ratio"; ValueError for a path that is none."""
        part, name = self._resolved(path)
        return getattr(self.parts[part], name)

    def with_parameters(self, values: dict[str, Any]) -> Self:
        """The same system with other values at the given parameter paths; ValueError for what a part does not take."""
        changes: dict[str, dict[str, Any]] = {}
        for path, value in values.items():
            part, name = self._resolved(path)
            changes.setdefault(part, {})[name] = value
        parts = self.parts
        for part, fields in changes.items():
            try:
                parts[part] = dataclasses.replace(parts[part], **fields)
            except ParameterError as error:
                raise error.within(part) from None
        return self.of_parts(parts, self.units)

    def _resolved(self, path: str) -> tuple[str, str]:
        if path not in self.parameter_paths:
            if str(path).startswith("environment.") and self.environment is None:
                raise ArgumentError(str(path), "this system has no environment; give it one, environment=Environment()")
            if str(path).startswith("actuator.") and self.actuator is None:
                raise ArgumentError(str(path), "this system has no actuator; give it one, actuator=Actuator()")
            part = str(path).partition(".")[0]
            if 2 <= number_in(part, "friction") <= 1 + len(self.machine.contacts):
                what = f"friction=[law, law_2, ...]; in a case by a section [{part}]"
                raise ArgumentError(str(path), f"this contact has the law of the first; give it its own, {what}")
            near = suggestion(path, self.parameter_paths, cutoff=0.0)
            raise ArgumentError(str(path), f"there is no such parameter in this system; {near}")
        part, name = path.split(".", 1)
        return part, name


def _fields(parts: Mapping[str, Any]) -> dict[str, Any]:
    """The fields of a system by its parts: the laws of further contacts are one field, in the order of the contacts."""
    numbers = {name: number for name in parts if (number := number_in(name, "friction")) > 1}
    most = max(numbers.values(), default=1)
    _check_contacts(parts["machine"], most)  # before so many are written down
    laws: list[Any] = [None] * (most - 1)
    for name, number in numbers.items():
        laws[number - 2] = parts[name]
    return {name: part for name, part in parts.items() if name not in numbers} | {"further": tuple(laws)}


def _check_contacts(machine: Any, number: int) -> None:
    """ArgumentError for the law of a contact that the machine does not have."""
    kind = machine.part if isinstance(machine, PartInSI) else machine
    contacts = 1 + len(kind.contacts)
    if number > contacts:
        said = "one contact" if contacts == 1 else f"{contacts} contacts"
        raise ArgumentError(numbered("friction", number), f"should be left out: the {kind.name} has {said}")
