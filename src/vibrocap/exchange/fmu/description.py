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
    written = Written2(package) if fmi == "2.0" else Written3(package)
    written.kind(root, sources)
    _units(root, package.variables)
    written.sides(SubElement(root, "TypeDefinitions"))
    categories = SubElement(root, "LogCategories")
    for category in CATEGORIES:
        SubElement(categories, "Category", name=category)
    case = package.case
    end = case.periods * case.system.drive.period * package.variables[0].port.scale
    SubElement(root, "DefaultExperiment", startTime="0.0", stopTime=f"{end:.15g}", tolerance=repr(case.tolerance))
    listed = SubElement(root, "ModelVariables")
    for variable in package.variables:
        written.variable(listed, variable)
    written.structure(SubElement(root, "ModelStructure"))
    return _text(root)


class Written:
    """What the versions of FMI write in their own ways."""

    def __init__(self, package: Package):
        self.package, self.variables = package, package.variables
        self.references = {variable.name: str(i) for i, variable in enumerate(self.variables)}

    def _common(self, each: Variable) -> dict[str, str]:
        given = {
            "name": each.name,
            "valueReference": self.references[each.name],
            "description": each.meaning,
            "causality": each.causality,
            "variability": each.variability,
        }
        return given | ({"initial": each.initial} if each.initial else {})

    def _typed(self, each: Variable) -> dict[str, str]:
        given = {"declaredType": each.values} if each.values else {}
        given |= {"unit": each.unit} if each.unit != "1" else {}
        return given | ({} if each.start is None else {"start": repr(float(each.start))})

    def _outputs(self) -> list[Variable]:
        return [variable for variable in self.variables if variable.causality == "output"]

    def _unknown_at_start(self) -> list[Variable]:
        return [output for output in self._outputs() if output.initial == "calculated"]


class Written3(Written):
    """FMI 3.0."""

    def kind(self, root: Element, sources: Sequence[str]) -> None:
        """What it is and can do; the sources stand in buildDescription.xml."""
        able = (
            *("canGetAndSetFMUState", "canSerializeFMUState", "canHandleVariableCommunicationStepSize"),
            *("hasEventMode", "mightReturnEarlyFromDoStep"),
        )
        SubElement(root, "CoSimulation", {"modelIdentifier": self.package.name, **dict.fromkeys(able, "true")})

    def sides(self, types: Element) -> None:
        """The enumeration of sides."""
        sides = SubElement(types, "EnumerationType", name="Side")
        for side, value in SIDES.items():
            SubElement(sides, "Item", name=side, value=str(value))

    def variable(self, listed: Element, each: Variable) -> None:
        """One variable."""
        tag = {REAL: "Float64", TEXT: "String"}.get(each.type, "Enumeration" if each.values else "Int64")
        SubElement(listed, tag, {**self._common(each), **self._typed(each)})

    def structure(self, structure: Element) -> None:
        """Outputs, and what is computed at the start."""
        for tag, unknowns in (("Output", self._outputs()), ("InitialUnknown", self._unknown_at_start())):
            for unknown in unknowns:
                SubElement(structure, tag, valueReference=self.references[unknown.name])


class Written2(Written):
    """FMI 2.0."""

    def kind(self, root: Element, sources: Sequence[str]) -> None:
        """What it is and can do, and its sources."""
        able = ("canHandleVariableCommunicationStepSize", "canGetAndSetFMUstate", "canSerializeFMUstate")
        given = {"modelIdentifier": self.package.name, **dict.fromkeys(able, "true")}
        kind = SubElement(root, "CoSimulation", given)
        files = SubElement(kind, "SourceFiles")
        for source in sources:
            SubElement(files, "File", name=source)

    def sides(self, types: Element) -> None:
        """The enumeration of sides."""
        sides = SubElement(SubElement(types, "SimpleType", name="Side"), "Enumeration")
        for side, value in SIDES.items():
            SubElement(sides, "Item", name=side, value=str(value))

    def variable(self, listed: Element, each: Variable) -> None:
        """One variable."""
        tag = {REAL: "Real", TEXT: "String"}.get(each.type, "Enumeration" if each.values else "Integer")
        SubElement(SubElement(listed, "ScalarVariable", self._common(each)), tag, self._typed(each))

    def structure(self, structure: Element) -> None:
        """Outputs, and what is computed at the start, by their places."""
        for tag, unknowns in (("Outputs", self._outputs()), ("InitialUnknowns", self._unknown_at_start())):
            listed = SubElement(structure, tag)
            for unknown in unknowns:
                SubElement(listed, "Unknown", index=str(1 + int(self.references[unknown.name])))


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
