"""The text of a case: every parameter written out, without units or in SI, so that it reads back equal."""

import json
from collections.abc import Mapping
from typing import Any

from vibrocap.case.sections import DIMENSIONLESS, SI, WORDS, kind_key
from vibrocap.physics.dimensions.scales import Scales
from vibrocap.physics.dimensions.units import state_keys, units_of, written, written_in_si
from vibrocap.physics.parameters import given_parameters, parameter_table
from vibrocap.physics.system import System

Section = Mapping[str, Any]


def as_text(system: System, kept: Scales | None, initial: Section, run: Section, units: str | None) -> str:
    """The TOML text of a case; kept: scales of a system whose results stay without units.

    In SI the numbers are those with the fewest digits that read back exactly; where there are none for some of them,
    the numbers are written without units, with their scales, unless SI is asked for: then to rounding.
    """
    if units not in (None, *WORDS):
        raise ValueError(f'units should be "SI" or "dimensionless", got {units!r}')
    own = system.machine.si_scales
    scales = system.units or kept or (None if parameter_table(own) else own())
    in_si = units == SI or (units is None and system.units is not None)
    if in_si and scales is None:
        fields = ", ".join(info.name for info in parameter_table(own))
        raise ValueError(f"units: SI needs to know the scales of the machine: {fields}")
    head, sections = "", None
    if in_si and scales is not None:
        sections = _in_si(system, scales, initial, exactly=units is None)
    if sections is None:
        sections = {name: _chosen(name, part) | given_parameters(part) for name, part in system.parts.items()}
        if scales is not None and parameter_table(scales):
            sections["scales"] = given_parameters(scales)
            head = f'units = "{DIMENSIONLESS}"\n\n' if units == DIMENSIONLESS or system.units is None else ""
        sections["initial"] = dict(initial)
    sections["run"] = dict(run)
    blocks = [_rows(f"[{name}]", rows) for name, rows in sections.items()]
    if (description := getattr(system.machine, "description", None)) is not None:
        blocks.append(description_text(description))
    return head + "\n".join(blocks)


def description_text(description: Section) -> str:
    """[mechanism], with a table below it for each part, parameter, coordinate and signal."""
    rows = {name: value for name, value in description.items() if not isinstance(value, (dict, list))}
    blocks = [_rows("[mechanism]", rows)]
    for name, value in description.items():
        if isinstance(value, dict):
            blocks += [_rows(f"[mechanism.{name}.{key}]", row) for key, row in value.items()]
        elif isinstance(value, list):
            blocks += [_rows(f"[[mechanism.{name}]]", row) for row in value]
    return "\n".join(blocks)


def _rows(head: str, rows: Section) -> str:
    return f"{head}\n" + "".join(f"{key} = {toml_value(x)}\n" for key, x in rows.items())


def _chosen(section: str, part: Any) -> dict[str, Any]:
    return {key: part.name} if (key := kind_key(section)) else {}


def _in_si(system: System, scales: Scales, initial: Section, exactly: bool) -> dict[str, dict[str, Any]] | None:
    """The sections in SI; None where `exactly` is asked for and not possible."""
    units = units_of(system.parts, scales)
    sections: dict[str, dict[str, Any]] = {}
    for name, part in system.parts.items():
        values = written_in_si(part, units.of_part(name), exactly)
        if values is None:
            return None
        own = given_parameters(scales) if name == "machine" else {}
        sections[name] = _chosen(name, part) | own | values
    start = written(initial, state_keys(units.states), units, exactly)
    return None if start is None else sections | {"initial": start}


def toml_value(value: Any) -> str:
    """A word, a number or a list of numbers as TOML writes it."""
    if isinstance(value, (tuple, list)):
        return f"[{', '.join(map(toml_value, value))}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, int):  # true and false too
        return json.dumps(value)
    return repr(float(value))
