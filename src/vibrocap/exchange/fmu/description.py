"""The description of an FMU in XML, in the words of FMI 3.0 or 2.0: what it is, its variables, how it is built.

The variables are what an importer sees, in SI where the case is, each with its place in memory.
"""

import dataclasses
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from vibrocap import __version__
from vibrocap.case.case import Case
from vibrocap.exchange.stepped_case import Port, SteppedCase
from vibrocap.physics.dimensions.units import one_way, parameter_keys, suffix
from vibrocap.physics.names import numbered, split_path
from vibrocap.physics.parameters import dimension_of_unit, parameter_table

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


CYCLES = {"Hz": "1/s"}  # units that are none of products
CATEGORIES = ("logStatusError", "logStatusWarning")
ABLE = {
    "3.0": (
        *("canGetAndSetFMUState", "canSerializeFMUState", "canHandleVariableCommunicationStepSize"),
        *("hasEventMode", "mightReturnEarlyFromDoStep"),
    ),
    "2.0": ("canHandleVariableCommunicationStepSize", "canGetAndSetFMUstate", "canSerializeFMUstate"),
}
REALS, WHOLES = {"3.0": "Float64", "2.0": "Real"}, {"3.0": "Int64", "2.0": "Integer"}
MEANING = (
    "The motion of a vibro-driven capsule with its exact stick-slip contact: sticking is a mode, and events are "
    "located inside the FMU, whatever the step of the importer."
)


@dataclasses.dataclass(frozen=True)
class Package:
    """The parts of an FMU that depend on its case.

    sources: texts in C by file name; header: what stands in variables.h besides the token
    """

    name: str
    variables: tuple[Variable, ...]
    case: Case
    sources: Mapping[str, str]
    header: str


def description(package: Package, fmi: str, token: str, sources: Sequence[str]) -> bytes:
    """modelDescription.xml of an FMU; value references are places in its variables.

    sources: files in C that are compiled, which stand here in FMI 2.0
    """
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": fmi,
            "modelName": package.name,
            "guid" if fmi == "2.0" else "instantiationToken": token,
            "description": MEANING,
            "generationTool": f"vibrocap {__version__}",
            "variableNamingConvention": "structured",
        },
    )
    kind = SubElement(root, "CoSimulation", {"modelIdentifier": package.name, **dict.fromkeys(ABLE[fmi], "true")})
    if fmi == "2.0":
        files = SubElement(kind, "SourceFiles")
        for source in sources:
            SubElement(files, "File", name=source)
    _units(root, package.variables)
    _sides(SubElement(root, "TypeDefinitions"), fmi)
    categories = SubElement(root, "LogCategories")
    for category in CATEGORIES:
        SubElement(categories, "Category", name=category)
    case = package.case
    end = case.periods * case.system.drive.period * package.variables[0].port.scale
    SubElement(root, "DefaultExperiment", startTime="0.0", stopTime=f"{end:.15g}", tolerance=repr(case.tolerance))
    listed = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(package.variables):
        _variable(listed, variable, str(reference), fmi)
    _structure(SubElement(root, "ModelStructure"), package.variables, fmi)
    return _text(root)


def _sides(types: Element, fmi: str) -> None:
    if fmi == "2.0":
        sides = SubElement(SubElement(types, "SimpleType", name="Side"), "Enumeration")
    else:
        sides = SubElement(types, "EnumerationType", name="Side")
    for side, value in SIDES.items():
        SubElement(sides, "Item", name=side, value=str(value))


def _variable(listed: Element, variable: Variable, reference: str, fmi: str) -> None:
    common = {
        "name": variable.name,
        "valueReference": reference,
        "description": variable.meaning,
        "causality": variable.causality,
        "variability": variable.variability,
    }
    common |= {"initial": variable.initial} if variable.initial else {}
    typed = {"declaredType": variable.values} if variable.values else {}
    typed |= {"unit": variable.unit} if variable.unit != "1" else {}
    typed |= {} if variable.start is None else {"start": repr(float(variable.start))}
    tag = {REAL: REALS[fmi], TEXT: "String"}.get(variable.type, "Enumeration" if variable.values else WHOLES[fmi])
    if fmi == "2.0":
        SubElement(SubElement(listed, "ScalarVariable", common), tag, typed)
    else:
        SubElement(listed, tag, {**common, **typed})


def _structure(structure: Element, variables: Sequence[Variable], fmi: str) -> None:
    """Outputs, and what is computed at the start: by value references, in FMI 2.0 by places counted from 1."""
    outputs = [i for i, variable in enumerate(variables) if variable.causality == "output"]
    computed = [i for i in outputs if variables[i].initial == "calculated"]
    for tag, places in (("Output", outputs), ("InitialUnknown", computed)):
        if fmi == "2.0":
            unknowns = SubElement(structure, f"{tag}s")
            for i in places:
                SubElement(unknowns, "Unknown", index=str(1 + i))
        else:
            for i in places:
                SubElement(structure, tag, valueReference=str(i))


def build_description(name: str, files: Sequence[str]) -> bytes:
    """buildDescription.xml of FMI 3.0: how the sources are compiled."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=name)
    sources = SubElement(configuration, "SourceFileSet", language="C99")
    for file in files:
        SubElement(sources, "SourceFile", name=file)
    return _text(root)


def _units(root: Element, variables: Sequence[Variable]) -> None:
    """The units, each by its exponents of the base units where they are whole."""
    names = sorted({variable.unit for variable in variables} - {"1"})
    if not names:
        return
    units = SubElement(root, "UnitDefinitions")
    for name in names:
        unit = SubElement(units, "Unit", name=name)
        exponents = base_exponents(name)
        if all(value == int(value) for value in exponents.values()):
            SubElement(unit, "BaseUnit", {base: str(int(value)) for base, value in exponents.items() if value})


def base_exponents(unit: str) -> dict[str, float]:
    """Exponents of kg, m, s and rad of a unit such as "N m s/rad"."""
    own = dimension_of_unit(CYCLES.get(unit, unit))
    above, _, below = unit.partition("/")
    turns = sum(
        sign * float(power[1] or 1)
        for sign, text in ((1.0, above), (-1.0, below))
        for power in re.finditer(r"\brad(?:\^([\d.]+))?(?!\w)", text)
    )
    return {"kg": own.force, "m": own.length + own.force, "s": own.time - 2.0 * own.force, "rad": turns}


def _text(root: Any) -> bytes:
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"
