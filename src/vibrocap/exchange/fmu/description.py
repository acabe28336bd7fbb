"""The description of an FMU in XML, in the words of FMI 3.0 or 2.0: what it is, its variables, how it is built."""

import dataclasses
import re
from collections.abc import Mapping, Sequence
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from vibrocap import __version__
from vibrocap.case.case import Case
from vibrocap.exchange.fmu.variables import REAL, SIDES, TEXT, Variable
from vibrocap.physics.parameters import dimension_of_unit

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
    """The enumeration of sides."""
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
