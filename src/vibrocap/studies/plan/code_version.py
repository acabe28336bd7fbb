"""What makes results: the code, by a fingerprint of every source that can change a digit, and what it runs with.

In what two studies, or what made their results, differ is said in words: why one cannot continue the other.
"""

import functools
import hashlib
import importlib.metadata
import platform
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from vibrocap.measures.standard import LOAD_WATCH

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
    from vibrocap.numerics.api import code_made_for

    versions = {"version": _version("vibrocap"), "sources": source_fingerprint(), **code_made_for()}
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
    here, there = _described(stored), _described(asked)
    lines = []
    for what in {**here, **there}:
        if here.get(what, ("", None))[1] != there.get(what, ("", None))[1]:
            texts = [side[what][0] if what in side else "none" for side in (here, there)]
            further = ", not the same" if texts[0] == texts[1] else ""
            lines.append(f"{what}: stored {texts[0]}, asked {texts[1]}{further}")
    return lines


def _described(record: Mapping[str, Any]) -> Said:
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
