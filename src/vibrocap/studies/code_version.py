"""The version of the code that makes results: its number, and a fingerprint of every source that can change a digit."""

import functools
import hashlib
import importlib.metadata
import platform
from pathlib import Path

# Folders and modules of the package from which a run and its measures come; the others plan, store and show.
FOLDERS = ("drives", "friction", "machines", "measures", "numerics")
MODULES = ("elementary.py", "ensemble*.py", "equations.py", "parameters.py", "system.py", "trajectory.py")


@functools.cache
def source_fingerprint(package: Path | None = None) -> str:
    """SHA-256 of these sources, names included; line ends do not count. package: the folder of the package."""
    package = package or Path(__file__).resolve().parents[1]
    files = [path for folder in FOLDERS for path in (package / folder).rglob("*.py")]
    files += [path for module in MODULES for path in package.glob(module)]
    digest = hashlib.sha256()
    for path in sorted(files, key=lambda path: path.relative_to(package).as_posix()):
        text = path.read_bytes().replace(b"\r\n", b"\n")
        digest.update(f"{path.relative_to(package).as_posix()} {len(text)}\n".encode() + text)
    return digest.hexdigest()


_version = functools.cache(importlib.metadata.version)


def code_version() -> dict[str, str]:
    """What identifies the code."""
    return {"version": _version("vibrocap"), "sources": source_fingerprint()}


def surroundings() -> dict[str, str]:
    """With what the code ran: for information, it identifies nothing."""
    packages = {name: _version(name) for name in ("numpy", "llvmlite", "scipy", "zarr")}
    return {"python": platform.python_version(), "machine": platform.machine(), **packages}
