"""Units of stored arrays: those that follow from the study's own case, and no others.

Measures are stored without units, with the factor by which whoever reads them multiplies (`scale_factor`, CF
conventions). Another factor would be other results, so it is compared with what the scales of the case give.
"""

import contextlib
from collections.abc import Mapping
from typing import Any

from vibrocap.case.case import CaseError, case_from_text
from vibrocap.measures.of_measure import measure_unit, unit_in
from vibrocap.measures.standard import known_measure
from vibrocap.physics.system import System
from vibrocap.studies.store.record import plan_of
from vibrocap.studies.variables import coordinate_attributes

FACTORS = ("dimensionless_unit", "scale_factor")


class ArrayUnits:
    """What the attributes of a study's arrays should say of units; record: that of the study.

    A case whose parts are not loaded tells nothing of its scales. Then only arrays without factors are let in.
    """

    def __init__(self, record: Mapping[str, Any]):
        self._paths = plan_of(record).paths
        self._measures = {each if isinstance(each, str) else each["name"]: each for each in record["study"]["measures"]}
        self._system: System | None = None
        self._unknown = ""
        try:
            self._system = case_from_text(record["study"]["case"], "its case").system
        except CaseError as error:
            self._unknown = "; ".join(error.complaints)

    def complaints(self, name: str, given: Mapping[str, Any]) -> list[str]:
        """In what the attributes of an array differ; given: its attributes, None for one that is not there."""
        if self._system is None:
            told = [key for key in FACTORS if given.get(key) is not None]
            return [f"{key} cannot be compared with the case of the study: {self._unknown}" for key in told]
        expected = self._expected(name, self._system)
        found = []
        for key, value in expected.items():
            if given.get(key) != value and not (key == "units" and given.get(key) is None):
                wanted = "not be there" if value is None else f"be {value!r}, by the case of the study"
                found.append(f"{key} should {wanted}, got {given.get(key)!r}")
        return found

    def _expected(self, name: str, system: System) -> dict[str, Any]:
        """Attributes by name, None for one that should not be there; without those of which nothing is known here."""
        factors: dict[str, Any] = dict.fromkeys(FACTORS)
        if name in self._paths:
            with contextlib.suppress(KeyError, StopIteration):  # a path of a part that is not loaded
                return factors | {"units": coordinate_attributes(name, system).get("units")}
            return factors
        if name not in self._measures:
            return factors
        entry = self._measures[name]
        if isinstance(entry, str):
            measure = known_measure(entry, system)
            if measure is None:
                return factors
            unit, scale = measure_unit(measure, system)
        else:
            unit, scale = unit_in(entry["unit"], entry.get("si_unit") or "1", system)
        return {"units": unit, "dimensionless_unit": scale, "scale_factor": None if scale == 1.0 else scale}
