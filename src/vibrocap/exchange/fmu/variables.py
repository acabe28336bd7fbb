"""The variables of an FMU: what an importer sees of a case, in SI where the case is, and where each stands in memory."""

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any

from vibrocap.case.case import Case
from vibrocap.motion.equations import Equations, parameter_values
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.system import System
from vibrocap.physics.units import Units, one_way, over_seconds, parameter_keys, shortest

ANYWHERE, ABOVE_ZERO, FROM_ZERO = "ANYWHERE", "ABOVE_ZERO", "FROM_ZERO"  # where a parameter may lie
REAL, WHOLE, TEXT = "REAL", "WHOLE", "TEXT"
SIDES = {"slides back": -1, "rests": 0, "slides forward": 1}


@dataclasses.dataclass(frozen=True)
class Variable:
    """One variable of an FMU.

    place: in the memory of its type, by an expression of C; factor: what one dimensionless unit is in `unit`
    causality: "parameter", "input", "output", "local" or "independent"; start: None where it is computed
    derivative: name of the state whose rate this is
    """

    name: str
    meaning: str
    place: str
    type: str = REAL
    causality: str = "output"
    variability: str = "continuous"
    unit: str = "1"
    factor: float = 1.0
    start: float | None = None
    bound: str = ANYWHERE
    derivative: str = ""
    values: str = ""  # the type of an enumeration

    @property
    def initial(self) -> str:
        """"exact" with a start value, else "calculated"; "" of inputs and of time."""
        if self.causality in ("input", "independent"):
            return ""
        return "calculated" if self.start is None else "exact"


@dataclasses.dataclass(frozen=True)
class InUnits:
    """How the quantities of a case are shown: in SI where its results are, else without units."""

    system: System
    si: Units | None

    @classmethod
    def of(cls, case: Case) -> "InUnits":
        """Of a case."""
        return cls(case.system, None if case.system.units is None else case.system.si)

    def of_quantity(self, name: str) -> dict[str, Any]:
        """Unit and factor of a quantity of a motion."""
        return {} if self.si is None else {"unit": self.si.unit(name), "factor": self.si.factor(name)}

    def of_rate(self, state: str) -> dict[str, Any]:
        """Of the rate of a state."""
        if self.si is None:
            return {}
        return {
            "unit": over_seconds(self.si.unit(state)),
            "factor": self.si.factor(state) / self.si.factor("time"),
        }

    def parameter(self, path: str, value: float, place: str) -> Variable:
        """A parameter by its path, such as "machine.stiffness"."""
        part, _, name = path.rpartition(".")
        record = self.system.parts[part]
        info = next(each for each in parameter_table(record) if each.name == name)
        given: dict[str, Any] = {"name": path, "start": value}
        key = None if self.si is None else one_way(parameter_keys(type(record), self.si.effort), name)
        if key is not None and self.si is not None:
            factor = self.si.per_key(key)
            start = shortest(value, factor)
            given = {
                "name": f"{part}.{key.stem}",
                "unit": key.unit,
                "factor": factor,
                "start": value * factor if start is None else start,
            }
        bound = _bound(type(record), name)
        return Variable(
            meaning=info.meaning, place=place, causality="parameter", variability="fixed", bound=bound, **given
        )


def parameters(case: Case, recorded: Equations) -> list[Variable]:
    """The parameters of a case, without the numbers of a drive's present segment."""
    shown, values = InUnits.of(case), parameter_values(case.system)
    count = len(values) if recorded.corners is None else recorded.corners.place
    paths = recorded.parameter_paths[:count]
    return [
        shown.parameter(path, value, f"PARAMETER + {i}")
        for i, (path, value) in enumerate(zip(paths, values, strict=False))
    ]


def states(case: Case, initial: Sequence[float]) -> list[Variable]:
    """The states, with their start values."""
    shown, found = InUnits.of(case), []
    for i, (name, value) in enumerate(zip(case.system.state_names, initial, strict=True)):
        known = shown.of_quantity(name)
        factor = known.get("factor", 1.0)
        start = shortest(value, factor) if known else value
        start = value * factor if start is None else start
        found.append(Variable(name, f"state: {name.replace('_', ' ')}", f"STATE + {i}", start=start, **known))
    return found


def rates(case: Case) -> list[Variable]:
    """The rates of the states."""
    shown = InUnits.of(case)
    return [
        Variable(
            f"der({name})", f"rate of {name}", f"RATE + {i}", causality="local", derivative=name, **shown.of_rate(name)
        )
        for i, name in enumerate(case.system.state_names)
    ]


def observables(case: Case, names: Iterable[str]) -> list[Variable]:
    """What else is seen of a motion: friction, reaction, energy and so on."""
    shown = InUnits.of(case)
    return [
        Variable(name, name.replace("_", " "), f"OBSERVED + {i}", **shown.of_quantity(name))
        for i, name in enumerate(names)
    ]


def time(case: Case) -> Variable:
    """The time."""
    known = InUnits.of(case).of_quantity("time")
    return Variable("time", "time", "TIME", causality="independent", **known)


def whole(name: str, meaning: str, place: int, values: str = "") -> Variable:
    """A whole number, or one of an enumeration."""
    return Variable(name, meaning, str(place), WHOLE, variability="discrete", values=values)


STATUS = Variable("status", "how the motion goes on or why it ended", "0", TEXT, "local", "discrete")


def _bound(record: type, name: str) -> str:
    """Where a parameter may lie, of what its type says."""
    limits: Any = record.__pydantic_fields__[name].metadata  # type: ignore[attr-defined]
    if any(getattr(each, "gt", None) == 0 for each in limits):
        return ABOVE_ZERO
    return FROM_ZERO if any(getattr(each, "ge", None) == 0 for each in limits) else ANYWHERE
