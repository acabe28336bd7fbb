"""Branches and crossings in SI, to be printed and drawn: their numbers along the parameter and of the motions."""

import dataclasses
from typing import Any

from vibrocap.measures.during_run import known_measure
from vibrocap.orbits.continuation.branch import Branch
from vibrocap.orbits.continuation.branch_diagram import BranchDiagram
from vibrocap.orbits.crossings.crossing import Crossing, Crossings
from vibrocap.physics.conversion import Quantity
from vibrocap.physics.system import System


def branch_units(over: Quantity) -> dict[str, str]:
    """Unit of what the record of branches over a quantity holds, by name."""
    along = dict.fromkeys(("between", "parameter", over.path, "error"), over.unit)
    return along | {"period": "s", "drift": "m", "mean_velocity": "m/s"}


def diagram_in_si(found: BranchDiagram, over: Quantity) -> BranchDiagram:
    """A diagram whose parameter, periods, drifts and velocities are in SI, to be shown.

    The states and what it is followed with stay as they are, so that nothing can be computed from it.
    """
    low, high = found.between
    return dataclasses.replace(
        found,
        over=over.path,
        between=(low * over.scale, high * over.scale),
        branches=tuple(_branch_in_si(each, over) for each in found.branches),
        transitions=tuple(dataclasses.replace(t, parameter=t.parameter * over.scale) for t in found.transitions),
    )


def _branch_in_si(branch: Branch, over: Quantity) -> Branch:
    si, (low, high) = branch.system.si, branch.between
    special = [
        dataclasses.replace(
            each,
            parameter=each.parameter * over.scale,
            error=each.error * over.scale,
            drift=None if each.drift is None else each.drift * si.factor_of("m"),
        )
        for each in branch.special_points
    ]
    return dataclasses.replace(
        branch,
        over=over.path,
        between=(low * over.scale, high * over.scale),
        parameter=branch.parameter * over.scale,
        period=branch.period * si.factor_of("s"),
        drift=branch.drift * si.factor_of("m"),
        mean_velocity=branch.mean_velocity * si.factor_of("m/s"),
        special_points=tuple(special),
    )


def measure_scale(name: str, system: System) -> tuple[str, float]:
    """(unit, what one dimensionless unit is in it) of a measure of a system that knows its scales."""
    measure = known_measure(name, system)
    unit = "1" if measure is None or system.units is None else measure.si_unit
    return unit, 1.0 if unit == "1" else system.si.factor_of(unit)


def crossing_units(found: Crossings, over: Quantity, system: System) -> dict[str, Any]:
    """Unit of what the record of crossings holds, in its form."""
    unit, _ = measure_scale(found.measure, system)
    place = dict.fromkeys(("at", "bracket", "error"), over.unit) | dict.fromkeys(("differences", "values"), unit)
    found_units = {"value": unit, "found": {**place, "slope": f"{unit} per {over.unit}"}}
    return found_units | dict.fromkeys(("equal", "unsettled", "parameters"), over.unit) | {"differences": unit}


def crossings_in_si(found: Crossings, over: Quantity, system: System) -> Crossings:
    """Crossings whose parameter and measure are in SI."""
    _, size = measure_scale(found.measure, system)

    def along(values: Any) -> tuple:
        return tuple(value * over.scale for value in values)

    def measured(values: Any) -> tuple:
        return tuple(value * size for value in values)

    def crossing(each: Crossing) -> Crossing:
        return dataclasses.replace(
            each,
            at=each.at * over.scale,
            bracket=along(each.bracket),
            error=each.error * over.scale,
            differences=measured(each.differences),
            values=measured(each.values),
            slope=each.slope * size / over.scale,
        )

    return dataclasses.replace(
        found,
        over=over.path,
        value=found.value * size,
        found=tuple(map(crossing, found.found)),
        equal=tuple(along(each) for each in found.equal),
        unsettled=along(found.unsettled),
        parameters=found.parameters * over.scale,
        differences=found.differences * size,
    )
