"""What makes results: the code, by a fingerprint of every source that can change a digit, and what it runs with."""

import functools
import hashlib
import importlib.metadata
import platform
import re
from pathlib import Path

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
    it draws the runs. Devices that other packages bring add what they know, see `numerics.run.devices`.
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
