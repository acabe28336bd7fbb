"""A study: which runs of which system, what is measured on them and how; and what makes it this study and no other.

Its results depend on the code, by a fingerprint of every source that can change a digit, and on what it runs with. A
part from outside the package can be edited while a study is stored, so the study remembers it by its file's digest, or,
for one that was registered by a script, by a fingerprint of its functions. In what two studies differ is said in words:
why one cannot continue the other.
"""

import dataclasses
import functools
import hashlib
import importlib.metadata
import json
import platform
import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import CodeType
from typing import Any

from vibrocap.case.case import Case, CaseError, case_from_text, case_text
from vibrocap.case.sections import kind_paths, kinds_of
from vibrocap.measures.measure import Measure
from vibrocap.measures.standard import LOAD_WATCH
from vibrocap.numerics import api as numerics
from vibrocap.physics.names import split_path
from vibrocap.physics.part_files import file_of
from vibrocap.studies.plan.designs import Drawn
from vibrocap.studies.plan.runs import CaseList, Grid, ListedRuns, Runs

PACKAGE = "vibrocap"
# From where a run and its measures come: the ensemble, and the parts and the numerics, which are found by looking into
# folders. What these import counts as well; the other modules plan, store and show.
RUNS = ("measures/ensemble.py",)
# Statements that import from the package; to parse 170 files for them would take longer than a small sweep.
IMPORT = re.compile(rf"^[ \t]*(?:from|import)[ \t]+({PACKAGE}[\w.]*)(?:[ \t]+import[ \t]+(\([^)]*\)|[^\n]*))?", re.M)
NAME = re.compile(r"(?<!as )\b\w+")
FOLDERS = ("physics/drives", "physics/friction", "physics/machines", "physics/mechanics", "numerics")


@functools.cache
def source_fingerprint(package: Path | None = None) -> str:
    """SHA-256 of these sources, names included; line ends do not count. package: the folder of the package."""
    package = package or Path(__file__).resolve().parents[2]
    digest = hashlib.sha256()
    for path in sorted(deciding_sources(package), key=lambda path: path.relative_to(package).as_posix()):
        text = path.read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"{path.relative_to(package).as_posix()} {len(text)}\n".encode() + text)
    return digest.hexdigest()


def deciding_sources(package: Path) -> set[Path]:
    """The sources of a package that can change a digit of a run: where runs come from, and all that they import."""
    waiting = [package / name for name in RUNS]
    waiting += [path for folder in FOLDERS for path in (package / folder).rglob("*.py")]
    paths: set[Path] = set()
    while waiting:
        path = waiting.pop()
        if path not in paths and path.is_file():
            paths.add(path)
            waiting += imported_files(path, package)
    return paths


def imported_files(path: Path, package: Path) -> list[Path]:
    """The files that a module may import from its package, whether they are there or not."""
    names: set[str] = set()
    for module, imported in IMPORT.findall(path.read_text(encoding="utf-8")):
        names |= {module, *(f"{module}.{name}" for name in NAME.findall(imported))}
    steps = [name.split(".")[1:] for name in names if name.startswith(f"{PACKAGE}.")]
    return [package.joinpath(*step[:-1], f"{step[-1]}.py") for step in steps]


_version = functools.cache(importlib.metadata.version)


def code_version(drawn: bool = False) -> dict[str, str]:
    """What decides the bits of a study's results, beside the study itself, by name.

    The package, the processor and its instructions, LLVM, the system's mathematical functions, NumPy; and SciPy where
    it draws the runs. Devices that other packages bring add what they know, see `numerics.run.ensemble`.
    """
    versions = {"version": _version("vibrocap"), "sources": source_fingerprint(), **numerics.code_made_for()}
    versions |= {"system": _system(), "numpy": _version("numpy")}
    return versions | ({"scipy": _version("scipy")} if drawn else {})


@functools.cache
def _system() -> str:
    return " ".join(part for part in (platform.system(), *platform.libc_ver()) if part)


def surroundings() -> dict[str, str]:
    """With what else the code ran: for information, no number depends on it."""
    return {"python": platform.python_version(), **{name: _version(name) for name in ("zarr", "numcodecs")}}


Said = dict[str, tuple[str, Any]]  # name: (a short text, what is to be equal)


def differences(stored: Mapping[str, Any], asked: Mapping[str, Any]) -> list[str]:
    """In what the records of two studies differ, one line each."""
    here, there = _entries(stored), _entries(asked)
    lines = []
    for what in {**here, **there}:
        if here.get(what, ("", None))[1] != there.get(what, ("", None))[1]:
            texts = [side[what][0] if what in side else "none" for side in (here, there)]
            further = ", not the same" if texts[0] == texts[1] else ""
            lines.append(f"{what}: stored {texts[0]}, asked {texts[1]}{further}")
    return lines


def _entries(record: Mapping[str, Any]) -> Said:
    described: Said = {}
    for section, entries in tomllib.loads(record["case"]).items():
        for key, value in entries.items() if isinstance(entries, dict) else ():
            described[key if section == "run" else f"{section}.{key}"] = (str(value), value)
    described |= {name: (str(record[name]), record[name]) for name in ("window", "settle", "device")}
    described["extrapolate"] = (str(extrapolate := record.get("extrapolate", False)), extrapolate)
    names = [measure if isinstance(measure, str) else measure["name"] for measure in record["measures"]]
    asked = [measure for measure in record["measures"] if measure != LOAD_WATCH]
    described["measures"] = (", ".join(name for name in names if name != LOAD_WATCH), sorted(map(str, asked)))
    described["watch of the load"] = ("on", True) if LOAD_WATCH in names else ("off", False)
    described |= _plan(record["plan"])
    for what, digest in record.get("parts", {}).items():
        described[f"the code of {what}"] = (digest[:12], digest)
    return described


def code_differences(stored: Mapping[str, str], here: Mapping[str, str]) -> list[str]:
    """In what two codes, and what they run with, differ, one line each."""
    keys = ("version", "sources")
    lines = []
    if any(stored.get(key) != here.get(key) for key in keys):
        texts = [f"vibrocap {code['version']} with sources {code['sources'][:12]}" for code in (stored, here)]
        lines.append(f"code: stored {texts[0]}, here {texts[1]}")
    for key in dict.fromkeys((*stored, *here)):
        then, now = stored.get(key, "unknown"), here.get(key, "unknown")
        if key in keys or then == now:
            continue
        if key == "features":  # only those that one of them lacks
            old, new = {*then.split()}, {*now.split()}
            then, now = " ".join(sorted(old - new)), " ".join(sorted(new - old))
        lines.append(f"{key}: stored {then or 'fewer'}, here {now or 'fewer'}")
    return lines


def _plan(plan: Mapping[str, Any]) -> Said:
    varied = plan.get("axes") or plan.get("ranges") or plan.get("columns") or []
    names = [entry["path"] for entry in varied]
    entries: Said = {"plan": (f"{plan['kind']} of {', '.join(names)}", (plan["kind"], names))}
    for name, value in plan.get("design", {}).items():
        entries[f"design.{name}"] = (str(value), value)
    for entry in varied:
        if "values" in entry:
            values = entry["values"]
            few = f"{values[0]} ... {values[-1]}" if len(values) > 3 else ", ".join(map(str, values))
            entries[f"values of {entry['path']}"] = (f"{len(values)} ({few})", values)
        else:
            scale = "log:" if entry["logarithmic"] else ""
            entries[f"range of {entry['path']}"] = (f"{scale}{entry['low']}:{entry['high']}", entry)
    return entries


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
