"""A study: which runs of which system, what is measured on them and how; and what makes it this study and no other.

A part from outside the package can be edited while a study is stored, so the study remembers it by its file's digest,
or, for one that was registered by a script, by a fingerprint of its functions.
"""

import dataclasses
import functools
import hashlib
import json
from collections.abc import Iterable, Mapping
from types import CodeType
from typing import Any

from vibrocap.case.case import Case, CaseError, case_from_text, case_text
from vibrocap.case.sections import kind_paths, kinds_of
from vibrocap.measures.measure import Measure
from vibrocap.numerics import api as numerics
from vibrocap.physics.names import split_path
from vibrocap.physics.part_files import file_of
from vibrocap.studies.plan.code_version import code_version
from vibrocap.studies.plan.designs import Drawn
from vibrocap.studies.plan.runs import CaseList, Grid, ListedRuns, Runs


def part_fingerprint(part: type) -> str:
    """SHA-256 of the file that a part was loaded from; else of its functions and constants."""
    if (place := file_of(part)) is not None:
        return place[1]
    own = [kind for kind in part.__mro__ if not kind.__module__.startswith(("vibrocap.", "builtins"))]
    described = [(kind.__qualname__, sorted(_functions(kind).items())) for kind in own]
    return hashlib.sha256(repr(described).encode()).hexdigest()


def _functions(part: type) -> dict[str, str]:
    functions = {}
    for name, value in vars(part).items():
        if name.startswith("__") and name != "__post_init__":  # all others of these are made by Python
            continue
        inner = (getattr(value, holder, None) for holder in ("fget", "func", "__func__", "wrapped"))
        function = next((function for function in inner if function is not None), value)
        if hasattr(function, "__code__"):
            functions[name] = function_fingerprint(function)
        elif isinstance(value, (int, float, str, tuple, type(None))):
            functions[name] = repr(value)
    return functions


def function_fingerprint(function: Any) -> str:
    """SHA-256 of a function's compiled code, of the values it closes over and of the globals it names.

    Functions of the same module that it calls count too, what comes from other modules by name only. Another version of
    Python compiles differently: then the fingerprint is another one.
    """
    return hashlib.sha256(repr(_described(function, set())).encode()).hexdigest()


def _described(value: Any, seen: set[int]) -> Any:
    """Nested tuples of texts and numbers that stand for a value, without addresses in memory."""
    if isinstance(value, CodeType):
        constants = [_described(constant, seen) for constant in value.co_consts]
        return ("code", value.co_code.hex(), constants, value.co_names, value.co_varnames, value.co_freevars)
    code = getattr(value, "__code__", None)
    if code is None:
        plain = isinstance(value, (int, float, complex, str, bytes, tuple, list, dict, frozenset, type(None)))
        return repr(value) if plain else f"{type(value).__module__}.{type(value).__qualname__}"
    if id(value) in seen:
        return "itself"
    seen.add(id(value))
    cells = [_described(cell.cell_contents, seen) for cell in value.__closure__ or ()]
    defaults = [_described(default, seen) for default in value.__defaults__ or ()]
    used = {name: value.__globals__[name] for name in _names(code) if name in value.__globals__}
    module = value.__module__  # of globals those that are plain values, or functions of the module itself
    own = {x: _described(one, seen) for x, one in sorted(used.items()) if getattr(one, "__module__", module) == module}
    return (_described(code, seen), cells, defaults, own)


def _names(code: CodeType) -> set[str]:
    inner = (_names(constant) for constant in code.co_consts if isinstance(constant, CodeType))
    return set(code.co_names).union(*inner)


FORMAT = "vibrocap study, format 2"
PLANS: dict[str, type[Runs]] = {plan.kind: plan for plan in (Grid, CaseList, Drawn)}


@dataclasses.dataclass(frozen=True)
class Study:
    """Everything on which the results of a study depend, and nothing else; small, and it can be sent to other machines.

    case: the system on which the plan's values are put, where its runs start, and how they are run
    plan: the runs
    measures: names of what is measured, or measures of one's own
    window, settle, device, extrapolate: how, as `ensemble` takes them; each device has bits of its own
    code: with what the results are made, by name, see `code_version`; as it is here unless given

    How it is carried out (threads, workers, tiles, their order) is no part of it: results do not depend on that.
    """

    case: Case
    plan: Runs
    measures: tuple[str | Measure, ...]
    window: int = 10
    settle: float | None = None
    code: Mapping[str, str] = dataclasses.field(default_factory=dict)
    device: str = "cpu"
    extrapolate: bool = False

    def __post_init__(self):
        if not self.code:
            object.__setattr__(self, "code", code_of(self.plan, self.device))

    @property
    def settings(self) -> dict[str, Any]:
        return self.case.run | self._how

    @property
    def _how(self) -> dict[str, Any]:
        extrapolates = {} if self.settle is None else {"extrapolate": self.extrapolate}  # else it means nothing
        return {"window": self.window, "settle": self.settle, **extrapolates, "device": self.device}

    def record(self) -> dict[str, Any]:
        """The study as JSON can hold it: enough to run it again (with measures and parts of one's own given again)."""
        parts = {what: part_fingerprint(part) for what, part in self.own_parts.items()}
        measures = [_measure_record(measure) for measure in self.measures]
        what = {"case": case_text(self.case), "plan": self.plan.record(), "measures": measures}
        return what | self._how | {"code": dict(self.code)} | ({"parts": parts} if parts else {})

    @functools.cached_property
    def own_parts(self) -> dict[str, type]:
        """Parts that are not of this package, by what they are in the study, as in {"friction.law = own": Own}."""
        listed = self.plan.varied if isinstance(self.plan, ListedRuns) else ()
        names, parts = {column.path: column.values for column in listed}, dict[str, type]()
        for path in kind_paths(self.case.system.parts):
            section = split_path(path)[0]
            known = [kinds_of(section)[name] for name in names.get(path, ()) if isinstance(name, str)]
            for kind in (type(self.case.system.parts[section]), *known):
                part = getattr(kind, "wrapped", None) or kind
                if not part.__module__.startswith("vibrocap."):
                    parts[f"{path} = {part.name}"] = part
        return parts

    @classmethod
    def from_record(cls, record: Mapping[str, Any], measures: Iterable[Measure] = ()) -> "Study":
        """The study of a record; measures: those of one's own, which a record does not hold as functions.

        Raises CaseError where one of them is missing or is another than that of the record.
        """
        own = {measure.name: measure for measure in measures}
        known, complaints = [], []
        for entry in record["measures"]:
            if isinstance(entry, str):
                known.append(entry)
            elif entry["name"] in own and _measure_record(own[entry["name"]]) == entry:
                known.append(own[entry["name"]])
            else:
                complaints.append(f"measures: {entry['name']!r} is a measure of one's own; give it, as it was")
        if complaints:
            raise CaseError(complaints, "the study")
        plan = PLANS[record["plan"]["kind"]].from_record(record["plan"])
        case = case_from_text(record["case"], "the case of the study")
        how = {name: record[name] for name in ("window", "settle", "device")}
        how |= {"code": dict(record["code"]), "extrapolate": record.get("extrapolate", False)}
        return cls(case, plan, tuple(known), **how)

    @functools.cached_property
    def identity(self) -> str:
        """SHA-256 of all that makes this study, the order of its measures aside."""
        record = self.record()
        record |= {"measures": sorted(record["measures"], key=str), "format": FORMAT}
        text = json.dumps(record, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
        return hashlib.sha256(text.encode()).hexdigest()


def code_of(plan: Runs, device: str) -> dict[str, str]:
    """With what the results of a plan's runs would be made here."""
    drawn = isinstance(plan, Drawn) and plan.design.kind != "random"
    return {**code_version(drawn), **numerics.device(device).code}


def _measure_record(measure: str | Measure) -> Any:
    if isinstance(measure, str):
        return measure
    how = measure.how
    record = {"name": measure.name, "meaning": measure.meaning, "unit": measure.unit, "how": type(how).__name__}
    record |= {"si_unit": measure.si_unit} if measure.si_unit != "1" else {}
    record |= {name: getattr(how, name) for name in ("kind", "of") if hasattr(how, name)}
    record |= {"of": list(record["of"])} if "of" in record else {}
    return record | {"function": function_fingerprint(getattr(how, "function", how))}
