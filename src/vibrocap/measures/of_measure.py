"""What numbers are that belong to a measure: they have the unit of the measure that a record or a call names."""

from typing import Annotated, Any

import numpy as np

from vibrocap.measures.measure import Measure
from vibrocap.measures.standard import known_measure
from vibrocap.physics.dimensions.conversion import Along, quantity
from vibrocap.quantities.declared import AsGiven, Context, Declared, In, WithUnit

FINAL = "final."  # before the name of a state in which a run ended


class OfMeasure(Declared):
    """A value of the measure that the record or the call around names `measure`."""

    def unit(self, context: Context) -> str:
        return _unit(next(iter(context.known("measure")), ""), context)


class Wanted(OfMeasure):
    """The same, or a share of one where the call around says `relative`."""

    def unit(self, context: Context) -> str:
        return "1" if context.known("relative")[0] else super().unit(context)


class OverParameter(OfMeasure):
    """A slope of a measure over the parameter `over`."""

    def unit(self, context: Context) -> str:
        return f"{super().unit(context)} per {Along().unit(context)}"

    def scale(self, context: Context) -> float:
        return OfMeasure().scale(context) / Along().scale(context)


class OfMeasures(Declared):
    """Values of measures by their names, in the units of those that the call around asked for."""

    def converted(self, value: Any, context: Context, back: bool = False) -> Any:
        asked = next(iter(context.known("measures")), ())
        asked = (asked,) if isinstance(asked, (str, Measure)) else asked
        own = {item.name: item for item in asked if isinstance(item, Measure)}
        units = {name: _unit(own.get(name) or name, context) for name in value}
        if context.units is not None:
            states = {name: name.removeprefix(FINAL) for name in value if name.startswith(FINAL)}
            units |= {name: context.units.unit(state) for name, state in states.items()}
        return {name: In(units[name]).converted(one, context, back) for name, one in value.items()}


class InUnits(AsGiven):
    """A value of the measure that its record names, which is in the unit of the results already."""

    def seen(self, value: Any, context: Context) -> Any:
        return value if context.system is None else self.with_units(value, context)

    def with_units(self, value: Any, context: Context) -> Any:
        return in_unit_of(context.known("measure")[0], value, context)


class ByMeasureInUnits(InUnits):
    """The same by names that begin with that of a measure."""

    def with_units(self, value: Any, context: Context) -> Any:
        return {name: in_unit_of(name.split()[0], one, context) for name, one in value.items()}


class OneSlopeInUnits(InUnits):
    """A slope of the `measure` of its record over its `parameter`."""

    def with_units(self, value: Any, context: Context) -> Any:
        return slope_over(context.known("measure")[0], context.known("parameter")[0], value, context)


class SlopesByPath(InUnits):
    """Slopes of the measure of a record below and above, by the path of a parameter."""

    def with_units(self, value: Any, context: Context) -> Any:
        measure = context.known("measure")[0]
        return {path: [slope_over(measure, path, one, context) for one in pair] for path, pair in value.items()}


def in_unit_of(measure: str, value: Any, context: Context) -> Any:
    """A value of a measure with its unit."""
    unit, scale = measure_unit(measure, context.system)
    return value if value is None or scale is None else WithUnit(value, unit, value / scale)


def slope_over(measure: str, path: str, value: Any, context: Context) -> Any:
    """A slope of a measure over a parameter with its unit."""
    unit, scale = measure_unit(measure, context.system)
    along = quantity(path, context.system)
    if value is None or unit == along.unit == "1":
        return value
    return WithUnit(value, f"{unit} per {along.unit}", value * along.scale / (scale or 1.0))


def measure_unit(measure: str | Measure, system: Any) -> tuple[str, float | None]:
    """(unit of a measure in the results of a system, what one dimensionless unit is in it; None where it has none)."""
    known = measure if isinstance(measure, Measure) else known_measure(measure, system)
    return ("1", None) if known is None else unit_in(known.unit, known.si_unit, system)


def unit_in(unit: str, si_unit: str, system: Any) -> tuple[str, float | None]:
    """The same of a measure that has these units, without scales and in SI."""
    context = system.si_context()
    if context is None or si_unit == "1":
        return unit, None
    own = context.units.of_contact(si_unit)
    return own, context.units.factor_of(own)


def _unit(measure: str | Measure, context: Context) -> str:
    known = known_measure(measure, context.system) if isinstance(measure, str) else measure
    return known.si_unit if isinstance(known, Measure) else "1"  # a user's own function has none


OneOfMeasure = Annotated[float, OfMeasure()]
OneWanted = Annotated[float, Wanted()]
ManyOfMeasure = Annotated[np.ndarray, OfMeasure()]
SlopeOfMeasure = Annotated[float, OverParameter()]
ByMeasure = Annotated[dict[str, Any], OfMeasures()]
MeasureInUnit = Annotated[float, InUnits()]
MeasuresInUnits = Annotated[dict[str, float], ByMeasureInUnits()]
SlopeInUnit = Annotated[float, OneSlopeInUnits()]
Slopes = Annotated[dict[str, Any], SlopesByPath()]
