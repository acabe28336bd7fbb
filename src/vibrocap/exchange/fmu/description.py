"""The description of an FMU in XML: modelDescription.xml of FMI 3.0, and buildDescription.xml of its sources."""

import re
from collections.abc import Sequence
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import vibrocap
from vibrocap.exchange.fmu.variables import REAL, SIDES, TEXT, Variable
from vibrocap.physics.roles import dimension_of_unit

CYCLES = {"Hz": "1/s"}  # units that are none of products
CATEGORIES = ("logStatusError", "logStatusWarning")


def description_3(
    name: str,
    token: str,
    meaning: str,
    kind: str,
    able: dict[str, str],
    variables: Sequence[Variable],
    indicators: Sequence[str],
    experiment: dict[str, float],
) -> bytes:
    """modelDescription.xml of FMI 3.0; value references are places in `variables`.

    kind: "ModelExchange" or "CoSimulation"; able: its attributes; indicators: names of the event indicators
    experiment: start and stop time, tolerance, step
    """
    root = Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=name,
        instantiationToken=token,
        description=meaning,
        generationTool=f"vibrocap {vibrocap.__version__}",
        variableNamingConvention="structured",
    )
    SubElement(root, kind, modelIdentifier=name, **able)
    _units(root, variables, "Unit")
    sides = SubElement(SubElement(root, "TypeDefinitions"), "EnumerationType", name="Side")
    for side, value in SIDES.items():
        SubElement(sides, "Item", name=side, value=str(value))
    _categories(root)
    SubElement(root, "DefaultExperiment", {each: repr(value) for each, value in experiment.items()})
    listed = SubElement(root, "ModelVariables")
    references = {each.name: str(i) for i, each in enumerate(variables)}
    for each in variables:
        _variable_3(listed, each, references)
    structure = SubElement(root, "ModelStructure")
    for each in variables:
        if each.causality == "output":
            SubElement(structure, "Output", valueReference=references[each.name])
    derivatives = [each for each in variables if each.derivative]
    for each in derivatives:
        SubElement(structure, "ContinuousStateDerivative", valueReference=references[each.name])
    for each in variables:
        if each.initial == "calculated" and (each.causality == "output" or each.derivative):
            SubElement(structure, "InitialUnknown", valueReference=references[each.name])
    for each in indicators:
        SubElement(structure, "EventIndicator", valueReference=references[each])
    return _text(root)


def _variable_3(listed: Element, each: Variable, references: dict[str, str]) -> None:
    tag = {REAL: "Float64", TEXT: "String"}.get(each.type, "Enumeration" if each.values else "Int64")
    given = {
        "name": each.name,
        "valueReference": references[each.name],
        "description": each.meaning,
        "causality": each.causality,
        "variability": each.variability,
    }
    if each.initial:
        given["initial"] = each.initial
    if each.values:
        given["declaredType"] = each.values
    if each.unit != "1":
        given["unit"] = each.unit
    if each.start is not None:
        given["start"] = repr(each.start)
    if each.derivative:
        given["derivative"] = references[each.derivative]
    SubElement(listed, tag, given)


def build_description(name: str, files: Sequence[str]) -> bytes:
    """buildDescription.xml of FMI 3.0: how the sources are compiled."""
    root = Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=name)
    sources = SubElement(configuration, "SourceFileSet", language="C99")
    for each in files:
        SubElement(sources, "SourceFile", name=each)
    return _text(root)


def _units(root: Element, variables: Sequence[Variable], tag: str) -> None:
    """The units, each by its exponents of the base units where they are whole."""
    names = sorted({each.unit for each in variables} - {"1"})
    if not names:
        return
    units = SubElement(root, "UnitDefinitions")
    for name in names:
        unit = SubElement(units, tag, name=name)
        exponents = base_exponents(name)
        if all(value == int(value) for value in exponents.values()):
            SubElement(unit, "BaseUnit", {base: str(int(value)) for base, value in exponents.items() if value})


def base_exponents(unit: str) -> dict[str, float]:
    """Exponents of kg, m, s and rad of a unit such as "N m s/rad"."""
    own = dimension_of_unit(CYCLES.get(unit, unit))
    above, _, below = unit.partition("/")
    turns = sum(
        sign * float(found[1] or 1)
        for sign, text in ((1.0, above), (-1.0, below))
        for found in re.finditer(r"\brad(?:\^([\d.]+))?(?!\w)", text)
    )
    return {"kg": own.force, "m": own.length + own.force, "s": own.time - 2.0 * own.force, "rad": turns}


def _categories(root: Element) -> None:
    categories = SubElement(root, "LogCategories")
    for each in CATEGORIES:
        SubElement(categories, "Category", name=each)


def _text(root: Any) -> bytes:
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"
