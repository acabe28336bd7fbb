"""Machine code for FMUs: by the C compiler that is found, and for other platforms by zig, which comes as a package."""

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
# of a platform: its name in FMI 2.0 (None: it has none), the ending of a library, and what zig calls it
PLATFORMS: dict[str, tuple[str | None, str, str]] = {
    "x86_64-linux": ("linux64", ".so", "x86_64-linux-gnu.2.17"),
    "aarch64-linux": (None, ".so", "aarch64-linux-gnu.2.17"),
    "x86_64-windows": ("win64", ".dll", "x86_64-windows-gnu"),
    "x86_64-darwin": ("darwin64", ".dylib", "x86_64-macos"),
    "aarch64-darwin": (None, ".dylib", "aarch64-macos"),
}
OPTIONS = ("-std=c99", "-O2", "-g0", "-shared", "-fvisibility=hidden", "-ffp-contract=off")


class BuildError(RuntimeError):
    """A compiler that did not compile; the message holds what it said."""


def own_platform() -> str:
    """The name of this computer's platform in FMI 3.0."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    return f"{machine}-{platform.system().lower()}"


def checked_platforms(platforms: Sequence[str] | None) -> tuple[str, ...]:
    """The platforms for which machine code is made: by default that of this computer, if there is a compiler.

    platforms: names in FMI 3.0; "all" of them; "none": sources only
    Raises ArgumentError for a platform that is not known, or that needs zig where the package `ziglang` is missing.
    """
    if platforms is None:
        return (own_platform(),) if compiler() else ()
    if list(platforms) == ["none"]:
        return ()
    asked = tuple(PLATFORMS) if list(platforms) == ["all"] else tuple(dict.fromkeys(platforms))
    for each in asked:
        if each not in PLATFORMS:
            names = listed((*PLATFORMS, "all", "none"), " or ")
            raise ArgumentError("platforms", f"should be {names}, got {shown(each)}")
        if (each != own_platform() or not compiler()) and (said := lacking("ziglang")):
            raise ArgumentError("platforms", f"{each} {said}")
    return asked


def compiler() -> str | None:
    """The C compiler of this computer."""
    return next((found for name in COMPILERS if (found := shutil.which(name))), None)


def binary(sources: Mapping[str, str], compiled: Sequence[str], name: str, target: str) -> bytes:
    """The shared library of C sources, by file name, for a platform.

    compiled: the files that are compiled, the others being included
    Raises BuildError with what the compiler said.
    """
    own = compiler() if target == own_platform() else None
    _, ending, triple = PLATFORMS.get(target, (None, ".so", ""))
    command = [own] if own else [sys.executable, "-m", "ziglang", "cc", "-target", triple]
    position = [] if target.endswith("windows") else ["-fPIC"]
    library = [] if target.endswith("windows") else ["-lm"]
    with tempfile.TemporaryDirectory() as folder:
        for each, text in sources.items():
            write_text(Path(folder) / each, text)
        out = f"{name}{ending}"
        options = [*OPTIONS, *position, *([] if target.endswith("darwin") else ["-s"])]
        done = subprocess.run(
            [*command, *options, "-o", out, *compiled, *library], cwd=folder, capture_output=True, text=True, check=False
        )
        if done.returncode != 0:
            raise BuildError(f"{' '.join(command)} for {target} failed:\n{done.stderr.strip()[-2000:]}")
        return (Path(folder) / out).read_bytes()

