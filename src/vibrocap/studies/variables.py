"""Variables of a study's results: what each of them holds, in which type, and how it is labelled."""

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from vibrocap.case.case import case_text
from vibrocap.case.sections import is_kind, kinds_of
from vibrocap.measures.of_measure import measure_unit
from vibrocap.measures.standard import known_measure
from vibrocap.motion.status import Status
from vibrocap.physics.closed_loop.actuator import Actuator
from vibrocap.physics.dimensions.conversion import INITIAL, path_in_si
from vibrocap.physics.dimensions.units import Key
from vibrocap.physics.environment import Environment
from vibrocap.physics.names import split_path
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.symbols import state_symbols
from vibrocap.physics.system import System
from vibrocap.studies.plan.runs import Runs
from vibrocap.studies.plan.study import Study

TEXT = np.dtypes.StringDType()
WORDS, REALS = (TEXT, ""), (np.dtype(np.float64), np.nan)  # type, and what stands for nothing
NOT_RUN = -1  # status of a run whose tile is not stored yet
TITLE = "Study of vibro-driven capsules"


@dataclasses.dataclass(frozen=True)
class Variable:
    """One array of results: its type, what it holds where nothing was run, and its attributes.

    measured: whether `ensemble` returns it; if not, it is a value of the plan that lies along its runs
    scale: one dimensionless unit in the unit of the attributes. Values are stored without units, with this as their
        `scale_factor`, by which whoever reads them multiplies (CF conventions)
    """

    name: str
    dtype: Any
    fill: Any
    attributes: dict[str, Any]
    measured: bool = True
    scale: float = 1.0

    @property
    def stored_attributes(self) -> dict[str, Any]:
        return self.attributes if self.scale == 1.0 else self.attributes | {"scale_factor": self.scale}

    def shown(self, values: np.ndarray) -> np.ndarray:
        """Values as they are read from a store."""
        return values if self.scale == 1.0 else values * self.scale

    def empty(self, shape: tuple[int, ...]) -> np.ndarray:
        """An array in which nothing was run."""
        return np.full(shape, self.fill, dtype=self.dtype)


def _count(name: str, dtype: Any, fill: int, meaning: str) -> Variable:
    return Variable(name, np.dtype(dtype), fill, {"long_name": meaning, "units": "1"})


_STATUSES = {
    "long_name": "how the run ended",
    "flag_values": list(range(NOT_RUN, len(Status))),
    "flag_meanings": " ".join(words.replace(" ", "_") for words in ("not run", *(status.value for status in Status))),
}
ALWAYS = {  # of every run
    variable.name: variable
    for variable in (
        Variable("status", np.dtype(np.int8), NOT_RUN, _STATUSES),
        Variable("settled", np.dtype(bool), False, {"long_name": "whether the motion settled within its periods"}),
        _count("response_period", np.int16, 0, "drive periods after which the steady motion repeats; 0: not settled"),
        _count("window_start", np.int32, -1, "start of the window of the measures, in drive periods from the start"),
        _count("window_periods", np.int32, 0, "length of the window of the measures, in drive periods"),
    )
}


def variables(study: Study) -> tuple[Variable, ...]:
    """All that is computed and stored run by run."""
    return (*ALWAYS.values(), *_measures(study), *_along_runs(study.plan, study.case.system))


def coordinate_attributes(path: str, system: System | None = None) -> dict[str, Any]:
    """Name, symbol and unit of what varies; system: of which it varies, for paths in SI."""
    if is_kind(path):
        return {"long_name": path.replace(".", " ")}
    part, name = split_path(path)
    if system is not None and system.units is not None and (in_si := _key_in_si(path, system)) is not None:
        words = in_si.stem.replace("_", " ")
        before = {"initial": "initial ", "drive": "drive ", "actuator": "actuator "}.get(part, "")
        return {"long_name": f"{before}{words}", "units": in_si.unit}
    if path.startswith(INITIAL):
        symbol, meaning = (name, name) if system is None else state_symbols(system.parts).get(name, (name, name))
        return {"long_name": f"initial {meaning}", "symbol": symbol, "units": "1"}
    kinds = kinds_of(part).values() or [Environment, Actuator]
    own = [] if system is None else [system.parts[part]]  # another kind may call something else so
    info = next(info for kind in (*own, *kinds) for info in parameter_table(kind) if info.name == name)
    return {"long_name": info.meaning, "symbol": info.symbol, "units": "1"}


def _key_in_si(path: str, system: System) -> Key | None:
    """The key of a path in SI, of the system or of any other kind of its part."""
    parts, section = system.parts, split_path(path)[0]
    section = section if section in parts else "friction"  # of an initial state
    for kind in (parts[section], *kinds_of(section).values()):
        place = path_in_si(path, parts | {section: kind})
        if place is not None:
            return place[1]
    return None


def axis_values(study: Study) -> dict[str, np.ndarray]:
    """Coordinates of the dimensions of a grid, by path; words (and numbers among words) as text."""
    plan = study.plan
    if not plan.gridded:
        return {}
    values = {}
    for i, path in enumerate(plan.dims):
        block = tuple(slice(None) if j == i else slice(0, 1) for j in range(len(plan.dims)))
        values[path] = as_stored(plan.values(block)[path])
    return values


def as_stored(values: np.ndarray) -> np.ndarray:
    """Floats as they are, objects as text ("" for None)."""
    if values.dtype != object:
        return values
    return np.array(["" if value is None else str(value) for value in values.tolist()], dtype=TEXT)


def study_attributes(study: Study) -> dict[str, Any]:
    """What the whole dataset says of itself; what is not set is left out."""
    attributes = {"title": TITLE, "source": f"vibrocap {study.code['version']}", "identity": study.identity}
    settings = {name: value for name, value in study.settings.items() if value is not None}
    attributes |= {name: int(x) if isinstance(x, bool) else x for name, x in settings.items()}  # as NetCDF
    return attributes | {"case": case_text(study.case)}


def _measures(study: Study) -> Iterator[Variable]:
    for entry in study.measures:
        measure = known_measure(entry, study.case.system) if isinstance(entry, str) else entry
        assert measure is not None
        if measure.name in ALWAYS:
            continue
        unit, scale = measure_unit(measure, study.case.system)
        attributes: dict[str, Any] = {"long_name": measure.meaning, "units": unit}
        if scale is not None:
            attributes["dimensionless_unit"] = scale
        yield Variable(measure.name, *(WORDS if measure.is_text else REALS), attributes, scale=scale or 1.0)


def _along_runs(plan: Runs, system: System) -> Iterator[Variable]:
    """The values of a plan whose runs lie along one dimension: as many as there are results, so stored like these."""
    for path in () if plan.gridded else plan.paths:
        kind = WORDS if plan.is_text(path) else REALS
        yield Variable(path, *kind, coordinate_attributes(path, system), measured=False)
