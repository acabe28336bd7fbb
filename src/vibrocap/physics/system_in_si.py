"""The parts of a system in SI: their scales from the machine, and each part without units."""

from collections.abc import Mapping
from typing import Any

from vibrocap.arguments import ArgumentError, Complaint, shown
from vibrocap.physics.conversion import part_without_units
from vibrocap.physics.parameters import ParameterError, parameter_table
from vibrocap.physics.part import PartInSI
from vibrocap.physics.scales import Scales
from vibrocap.physics.units import Units, parameter_keys, same_without_units


def parts_without_units(given: Mapping[str, Any], scales: Scales | None) -> tuple[dict[str, Any], Scales]:
    """(the parts without units, the scales of the machine), of parts some of which are in SI.

    scales: those of a machine that is not given in SI
    Raises ArgumentError for parts of which some are in SI and others not, ParameterError for values that do not serve.
    """
    machine = given["machine"]
    if not isinstance(machine, PartInSI):
        if scales is None:
            kind = type(machine).__name__
            raise ArgumentError("machine", f"should be in SI like the other parts, {kind}.in_si(...), got {machine!r}")
        in_si = {name: part for name, part in given.items() if isinstance(part, PartInSI)}
        return {**given, **_without_units(in_si, scales, machine.effort)}, scales
    fields = [info.name for info in parameter_table(machine.part.si_scales)]
    try:
        own: Scales = machine.part.si_scales(**{name: x for name, x in machine.values.items() if name in fields})
    except ParameterError as error:
        raise error.within("machine") from None
    rest = PartInSI(machine.part, {name: value for name, value in machine.values.items() if name not in fields})
    return _without_units({**given, "machine": rest}, own, machine.part.effort), own


def _without_units(given: Mapping[str, Any], scales: Scales, effort: str) -> dict[str, Any]:
    """The parts without units; ParameterError with every complaint, named by the keys that were given."""
    found: dict[str, Any] = {}
    complaints: list[Complaint] = []
    for name, part in given.items():
        if not isinstance(part, PartInSI):
            keys = parameter_keys(type(part), effort)
            if not all(same_without_units(keys, info.name) for info in parameter_table(part)):
                kind = type(part).__name__
                raise ArgumentError(name, f"should be in SI like the machine, {kind}.in_si(...), got {part!r}")
            found[name] = part
            continue
        plain = part_without_units(part.part, part.values, Units(scales, effort, {}))
        complaints += [each.about(f"{name}.{each.field}") for each in plain.complaints]  # type: ignore[attr-defined]
        try:
            found[name] = part.part(**plain.values)
        except ParameterError as error:
            complaints += [_as_given(each, name, part.values, plain.values, plain.keys) for each in error.complaints]
    if complaints:
        raise ParameterError("the system", complaints)
    return found


def _as_given(
    complaint: Complaint, part: str, given: Mapping[str, Any], plain: Mapping[str, Any], keys: Mapping[str, str]
) -> Complaint:
    """A complaint about a value without units, about what was given."""
    name = complaint.field
    if name not in keys:
        return complaint.about(f"{part}.{name}")
    text, got, _ = complaint.text.rpartition(f", got {shown(plain[name])}")
    return Complaint(f"{part}.{keys[name]}", f"{text}, got {shown(given[keys[name]])}" if got else complaint.text)
