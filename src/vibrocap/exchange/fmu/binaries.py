"""Machine code for FMUs: by the C compiler that is found, and for other platforms by zig, which comes as a package."""

import dataclasses
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from vibrocap.arguments import ArgumentError, lacking, listed, shown
from vibrocap.files import write_text

COMPILERS = ("cc", "gcc", "clang")


@dataclasses.dataclass(frozen=True)
class Platform:
    """What a platform is called by FMI 2.0 ("": by no name) and by zig, and how the names of its libraries end."""

    in_fmi_2: str
    in_zig: str
    ending: str


PLATFORMS = {  # by their names in FMI 3.0
    "x86_64-linux": Platform("linux64", "x86_64-linux-gnu.2.17", ".so"),
    "aarch64-linux": Platform("", "aarch64-linux-gnu.2.17", ".so"),
    "x86_64-windows": Platform("win64", "x86_64-windows-gnu", ".dll"),
    "x86_64-darwin": Platform("darwin64", "x86_64-macos", ".dylib"),
    "aarch64-darwin": Platform("", "aarch64-macos", ".dylib"),
}
OPTIONS = ("-std=c99", "-O2", "-g0", "-shared", "-fvisibility=hidden", "-ffp-contract=off")


class BuildError(RuntimeError):
    """A compiler that did not compile; the message holds what it said."""


def own_platform() -> str:
    """The name of this computer's platform in FMI 3.0."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    return f"{machine}-{platform.system().lower()}"


def checked_platforms(platforms: Sequence[str] | None, fmi: str) -> tuple[str, ...]:
    """The platforms for which machine code is made: by default that of this computer, where there is a compiler.

    platforms: names in FMI 3.0; "all" of them; "none": sources only; fmi: the version, 2.0 knows no other processors
    Raises ArgumentError for a platform that is not known, or that needs zig where the package `ziglang` is missing.
    """
    known = {name: known for name, known in PLATFORMS.items() if fmi != "2.0" or known.in_fmi_2}
    own = own_platform() if own_platform() in known and (compiler() or not lacking("ziglang")) else None
    if platforms is None:
        return () if own is None else (own,)
    if list(platforms) == ["none"]:
        return ()
    asked = tuple(known) if list(platforms) == ["all"] else tuple(dict.fromkeys(platforms))
    for wanted in asked:
        if wanted not in known:
            names = listed((*known, "all", "none"), " or ")
            raise ArgumentError("platforms", f"should be {names} in FMI {fmi}, got {shown(wanted)}")
        if wanted != own and (why := lacking("ziglang")):
            raise ArgumentError("platforms", f"{wanted} {why}")
    return asked


def compiler() -> str | None:
    """The C compiler of this computer."""
    return next((path for name in COMPILERS if (path := shutil.which(name))), None)


def binary(sources: Mapping[str, str], compiled: Sequence[str], name: str, target: str) -> bytes:
    """The shared library of C sources, by file name, for a platform.

    compiled: the files that are compiled, the others being included
    Raises BuildError with what the compiler said.
    """
    own, known = compiler() if target == own_platform() else None, PLATFORMS[target]
    command = [own] if own else [sys.executable, "-m", "ziglang", "cc", "-target", known.in_zig]
    position, library = ([], []) if target.endswith("windows") else (["-fPIC"], ["-lm"])
    with tempfile.TemporaryDirectory() as folder:
        for file, text in sources.items():
            write_text(Path(folder) / file, text)
        out = f"{name}{known.ending}"
        strip = [] if target.endswith("darwin") else ["-s"]
        line = [*command, *OPTIONS, *position, *strip, "-o", out, *compiled, *library]
        done = subprocess.run(line, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise BuildError(f"{' '.join(command)} for {target} failed:\n{done.stderr.strip()[-2000:]}")
        return (Path(folder) / out).read_bytes()
