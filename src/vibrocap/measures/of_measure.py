"""What numbers are that belong to a measure: they have the unit of the measure that a record or a call names."""

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np

from vibrocap.measures.measure import Measure
from vibrocap.physics.conversion import Along
from vibrocap.quantities.declared import Context, Declared, In


class OfMeasure(Declared):
    """A value of the measure that the record or the call around names `measure`."""

    def unit(self, context: Context) -> str:
        return _unit(next(iter(context.known("measure")), ""), context)


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
        own = {each.name: each for each in ((asked,) if isinstance(asked, (str, Measure)) else asked)
               if isinstance(each, Measure)}  # fmt: skip
        return {
            name: In(_unit(own.get(name, name), context)).converted(each, context, back) for name, each in value.items()
        }


def unit_and_scale(measure: str | Measure, system: Any) -> tuple[str, float]:
    """(SI unit, what one dimensionless unit is in it) of a measure of a system; ("1", 1.0) where there is none."""
    context = system.si_context()
    unit = "1" if context is None else _unit(measure, context)
    return unit, 1.0 if unit == "1" else context.units.factor_of(unit)


def _unit(measure: Any, context: Context) -> str:
    from vibrocap.measures.during_run import known_measure

    known = measure if isinstance(measure, Measure) else known_measure(measure, context.system)
    return "1" if known is None else known.si_unit


OneOfMeasure = Annotated[float, OfMeasure()]
ManyOfMeasure = Annotated[np.ndarray, OfMeasure()]
SlopeOfMeasure = Annotated[float, OverParameter()]
ByMeasure = Annotated[Mapping[str, Any], OfMeasures()]
