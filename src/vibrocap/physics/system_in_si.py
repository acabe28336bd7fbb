"""The parts of a system in SI: their scales from the machine, and each part without units."""

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from vibrocap.arguments import ArgumentError
from vibrocap.physics.conversion import part_without_units
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.part import PartInSI
from vibrocap.physics.scales import Scales
from vibrocap.physics.units import Units, parameter_keys, same_without_units


def parts_without_units(given: Mapping[str, Any], scales: Scales | None) -> tuple[dict[str, Any], Scales]:
    """(the parts without units, the scales of the machine), of parts some of which are in SI.

    scales: those of a machine that is not given in SI
    Raises ArgumentError for parts of which some are in SI and others not, and for values that do not serve.
    """
    machine = given["machine"]
    if not isinstance(machine, PartInSI):
        if scales is None:
            raise ArgumentError(
                "machine", f"should be in SI like the other parts, {type(machine).__name__}.in_si(...), got {machine!r}"
            )
        in_si = {name: part for name, part in given.items() if isinstance(part, PartInSI)}
        return {**given, **{n: _without_units(n, part, scales, machine.effort) for n, part in in_si.items()}}, scales
    fields = [info.name for info in parameter_table(machine.part.si_scales)]
    own: Scales = _made("machine", machine.part.si_scales, {n: x for n, x in machine.values.items() if n in fields}, {})
    rest = PartInSI(machine.part, {name: value for name, value in machine.values.items() if name not in fields})
    parts = {**given, "machine": rest}
    return {name: _without_units(name, part, own, machine.part.effort) for name, part in parts.items()}, own


def _without_units(name: str, part: Any, scales: Scales, effort: str) -> Any:
    if not isinstance(part, PartInSI):
        keys = parameter_keys(type(part), effort)
        if not all(same_without_units(keys, info.name) for info in parameter_table(part)):
            kind = type(part).__name__
            raise ArgumentError(name, f"should be in SI like the machine, {kind}.in_si(...), got {part!r}")
        return part
    found = part_without_units(part.part, part.values, Units(scales, effort, {}))
    for complaint in found.complaints:
        raise ArgumentError(f"{name}.{complaint.field}", complaint.text)  # type: ignore[attr-defined]
    return _made(name, part.part, found.values, {own: (key, part.values[key]) for own, key in found.keys.items()})


def _made(name: str, record: Any, values: Mapping[str, Any], given: Mapping[str, tuple[str, Any]]) -> Any:
    """A record; what it refuses is named by the key under which it was given."""
    try:
        return record(**values)
    except ValidationError as error:
        problem = error.errors()[0]
        field = ".".join(map(str, problem["loc"]))
        key, value = given.get(field, (field, problem["input"]))
        wanted = problem["msg"].removeprefix("Value error, ").replace("Input should", "should")
        got = f", got {value!r}" if key and problem["type"] != "missing" else ""
        raise ArgumentError(f"{name}.{key}" if key else name, f"{wanted}{got}") from None
