"""The variables of an FMU: what its importer sees, in SI where the case is, and where each stands in memory."""

import dataclasses
from collections.abc import Iterable

from vibrocap.exchange.stepped_case import Port, SteppedCase
from vibrocap.physics.dimensions.units import one_way, parameter_keys, suffix
from vibrocap.physics.names import numbered, split_path
from vibrocap.physics.parameters import parameter_table

REAL, WHOLE, TEXT = "REAL", "WHOLE", "TEXT"
INPUT = "drive"
SIDES = {"slides back": -1, "rests": 0, "slides forward": 1}


@dataclasses.dataclass(frozen=True)
class Variable:
    """One variable of an FMU.

    place: in the memory of its type, by an expression of C; port: its name, unit, factor and bounds
    causality: "parameter", "input", "output", "local" or "independent"; starts: whether the value of the port is
    its start value, else it is computed; values: the type of an enumeration
    """

    port: Port
    meaning: str
    place: str
    type: str = REAL
    causality: str = "output"
    variability: str = "continuous"
    starts: bool = False
    values: str = ""

    @property
    def name(self) -> str:
        return self.port.name

    @property
    def unit(self) -> str:
        """SI unit, "1" of what has none."""
        return self.port.unit

    @property
    def initial(self) -> str:
        """ "exact" with a start value, else "calculated"; "" of inputs and of time."""
        if self.causality in ("input", "independent"):
            return ""
        return "exact" if self.starts else "calculated"

    @property
    def start(self) -> float | None:
        """The start value in the unit."""
        return self.port.in_unit if self.starts else None


def time(stepped: SteppedCase) -> Variable:
    return Variable(stepped.time, "time", "TIME", causality="independent")


def parameters(stepped: SteppedCase) -> list[Variable]:
    """The parameters of the case, by their paths, in SI without the unit in them."""
    attributes = {"causality": "parameter", "variability": "fixed", "starts": True}
    variables = []
    for i, parameter in enumerate(stepped.parameters):
        name, meaning = _in_words(stepped, parameter.name)
        variables.append(Variable(dataclasses.replace(parameter, name=name), meaning, f"PARAMETER + {i}", **attributes))
    return variables


def scales(stepped: SteppedCase, before: int) -> list[Variable]:
    """The scales in which a case in SI counts, such as the mass of its pendulum: constants, as the case has them.

    before: numbers that stand before them in the memory
    """
    if (units := stepped.system.units) is None:
        return []
    variables = []
    stated = [info for info in parameter_table(type(units)) if getattr(units, info.name) is not None]
    for i, info in enumerate(stated, start=before):  # a unit of time that is left out follows from the others
        name = f"machine.{info.name.removesuffix(suffix(info.unit))}"
        port = Port(name, info.unit, value=getattr(units, info.name))
        variables.append(Variable(port, info.meaning, str(i), causality="local", variability="constant", starts=True))
    return variables


def _in_words(stepped: SteppedCase, path: str) -> tuple[str, str]:
    """Name and meaning of a parameter by its path."""
    part, name = split_path(path)
    record = stepped.system.parts[part]
    meaning = next(info.meaning for info in parameter_table(record) if info.name == name)
    if stepped.system.units is None:
        return path, meaning
    key = one_way(parameter_keys(type(record), stepped.system.si.of_part(part).effort), name)
    if key is None or not key.has_unit:
        return path, meaning
    return f"{part}.{key.stem}", f"{_words(key.stem)}; without units: {meaning}"


def states(stepped: SteppedCase) -> list[Variable]:
    named = [(f"state: {_words(state.name)}", f"STATE + {i}") for i, state in enumerate(stepped.states)]
    return [Variable(state, *words, starts=True) for state, words in zip(stepped.states, named, strict=True)]


def inputs(stepped: SteppedCase) -> list[Variable]:
    """The input, where there is one, held from step to step.

    A machine whose motion the drive imposes feels nothing of a held input but its slope and curvature: three inputs.
    """
    meanings = ["what drives the machine, from when it is set on"]
    if stepped.system.machine.imposes_motion:
        meanings += ["slope of the drive from then on", "its curvature"]
    attributes = {"causality": "input", "variability": "discrete", "starts": True}
    ports = zip(stepped.inputs, meanings, strict=False)
    return [Variable(port, meaning, f"HELD + {i}", **attributes) for i, (port, meaning) in enumerate(ports)]


def observables(stepped: SteppedCase) -> list[Variable]:
    """What else is seen of a motion: friction, reaction, energy and so on; an input is not seen twice."""
    names = []
    for i, observable in enumerate(stepped.observables):
        if observable.name == INPUT and stepped.inputs:
            if stepped.system.actuator is None:
                continue
            observable = dataclasses.replace(observable, name="actuator_output")
        names.append(Variable(observable, _words(observable.name), f"OBSERVED + {i}"))
    return names


def sides(contacts: int) -> list[Variable]:
    """Of each contact whether it rests and which way it slides."""
    names = [numbered("side", i) for i in range(1, contacts + 1)]
    meaning = "+1, -1: the contact slides forward, back; 0: it rests"
    return [_whole(name, meaning, i, "Side") for i, name in enumerate(names)]


def counts(kinds: Iterable[str], before: int) -> list[Variable]:
    """How many events of each kind and contact there were. before: whole numbers that stand before them."""
    return [_whole(f"events.{kind}", f"events: {_words(kind)}", i) for i, kind in enumerate(kinds, start=before)]


STATUS = Variable(
    Port("status"), "that the motion continues, or why it ended", "0", TEXT, causality="local", variability="discrete"
)


def _whole(name: str, meaning: str, place: int, values: str = "") -> Variable:
    return Variable(Port(name), meaning, str(place), WHOLE, variability="discrete", values=values)


def _words(name: str) -> str:
    return name.replace("_", " ")
