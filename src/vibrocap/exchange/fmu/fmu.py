"""A case as an FMU: the file that Simulink, Dymola, OpenModelica, FMPy and other importers of FMI open.

It is a zip file of description, sources and machine code, the same bytes for the same case. Machine code is made by the
C compiler that is found, and for other platforms by zig, which comes as a package.
"""

import dataclasses
import hashlib
import io
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from importlib.resources import files as own_files
from pathlib import Path
from typing import Literal

from vibrocap.arguments import ArgumentError, check_one_of, lacking, listed, shown
from vibrocap.case.case import Case
from vibrocap.exchange.c_library import c_files, checked_name, number
from vibrocap.exchange.fmu import description as of
from vibrocap.exchange.fmu.description import Package, Variable, build_description, description
from vibrocap.exchange.stepped_case import Input, SteppedCase
from vibrocap.files import replacing, write_text
from vibrocap.physics.names import numbered

VERSIONS = ("3.0", "2.0")

Version = Literal["3.0", "2.0"]


def export_fmu(
    case: Case,
    path: str | Path,
    *,
    input: Input = None,
    fmi: Version = "3.0",
    name: str = "capsule",
    platforms: Sequence[str] | None = None,
) -> tuple[str, ...]:
    """Write a case as an FMU for co-simulation, exact inside; returns the platforms for which it holds machine code.

    None where it holds sources only.

    input: "drive" for a drive that the importer gives; None: that of the case
    name: of the model, as in `c_files`; platforms: see `checked_platforms`

    Raises ArgumentError for what cannot be exported so, BuildError where a compiler fails, WriteError.
    """
    checked_name(name)
    check_one_of("fmi", fmi, VERSIONS)
    asked = checked_platforms(platforms, fmi)
    archive = zipped(co_simulation(SteppedCase(case, input), name), fmi, asked)
    with replacing(path) as temporary:
        temporary.write_bytes(archive)
    return asked


def co_simulation(stepped: SteppedCase, name: str) -> Package:
    """What an FMU of a case for co-simulation is made of."""
    parameters, states = of.parameters(stepped), of.states(stepped)
    inputs, sides = of.inputs(stepped), of.sides(stepped.contacts)
    begun = [port.in_unit for port in (*stepped.parameters, *stepped.states)]
    changing = len(begun) + len(stepped.observables) + len(stepped.inputs) + 1
    scales = of.scales(stepped, changing)
    counted = list(dict.fromkeys(stepped.counted))  # several of a machine may have one name
    before = of.time(stepped), *parameters, *scales, *states, *inputs
    variables = (*before, *of.observables(stepped), *sides, *of.counts(counted, len(sides)), of.STATUS)
    values = [*begun, *[0.0] * (changing - len(begun)), *(scale.port.value for scale in scales)]
    constants = {
        "PARAMETER": 0,
        "STATE": len(parameters),
        "OBSERVED": len(begun),
        "HELD": len(begun) + len(stepped.observables),
        "TIME": changing - 1,
        "VALUES": len(values),
        "COUNTS": len(sides) + len(counted),
        "PARAMETERS": len(parameters),
        "STATES": len(states),
        "OBSERVABLES": len(stepped.observables),
        "CONTACTS": len(sides),
        "EVENT_KINDS": len(stepped.event_kinds),
        "INPUTS": len(inputs),
        "PARAMETER_VARIABLE": 1,  # behind the time
    }
    own = [
        f'#include "{name}.h"',
        f"#define STEPPER(function) {name}_##function",
        f"#define AT_EVENT {name.upper()}_AT_EVENT",
        f"#define TOLERANCE {stepped.case.tolerance.hex()}",
        '#define TOLERANCES "from 1e-14 to 1e-2"',
        f'#define STARTS "{"a finite number" if inputs else "0, where the drive of the case begins"}"',
        f"static const int count_of[][{len(sides) + 1}] = {{{', '.join(_places(stepped, counted))}}};",
        f"typedef struct {{ {name} motion; double tolerance, begun; int input_changed; }} own_state;",
    ]
    sources = c_files(stepped.case, name, stepped.input)
    return Package(
        name=name,
        variables=variables,
        case=stepped.case,
        sources={source: sources[source] for source in (f"{name}.h", f"{name}.c")},
        header=header(variables, constants, values, stepped, own),
    )


def _places(stepped: SteppedCase, counted: list[str]) -> Iterator[str]:
    """Of each kind of event its place among the counts, by contact, none first; -1: it is of no such contact."""
    for at, kind in enumerate(stepped.event_kinds):
        names = [kind if at >= stepped.contact_kinds else ""]
        names += [numbered(kind, c) if not names[0] else "" for c in range(1, stepped.contacts + 1)]
        yield f"{{{', '.join(str(counted.index(name)) if name else '-1' for name in names)}}}"


EPOCH = (1980, 1, 1, 0, 0, 0)  # of all files in the zip


def zipped(package: Package, fmi: str, platforms: Sequence[str]) -> bytes:
    """The FMU with machine code for these platforms. Raises BuildError where a compiler fails."""
    folder = own_files("vibrocap.exchange.fmu") / "c"
    own = (f"fmi{fmi[0]}.h", f"fmi{fmi[0]}.c", "instance.h", "stepping.h", "shared.h")
    sources = {**package.sources, **{name: (folder / name).read_text(encoding="utf-8") for name in own}}
    token = _token(package, sources)
    sources["variables.h"] = package.header.replace("@TOKEN@", token)
    compiled = [name for name in (*package.sources, own[1]) if name.endswith(".c")]
    files = {"modelDescription.xml": description(package, fmi, token, compiled)}
    if fmi != "2.0":
        files["sources/buildDescription.xml"] = build_description(package.name, compiled)
    files |= {f"sources/{name}": text.encode() for name, text in sources.items()}
    for target in platforms:
        known = PLATFORMS[target]
        folder_name = known.in_fmi_2 if fmi == "2.0" else target
        code = binary(sources, compiled, package.name, target)
        files[f"binaries/{folder_name}/{package.name}{known.ending}"] = code
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as file:
        for path_in_zip in sorted(files, key=lambda path: (path != "modelDescription.xml", path)):
            entry = zipfile.ZipInfo(path_in_zip, EPOCH)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(entry, files[path_in_zip], compresslevel=9)
    return packed.getvalue()


def _token(package: Package, sources: Mapping[str, str]) -> str:
    """A digest of all that the FMU computes, in the form of a GUID."""
    digest = hashlib.sha256(package.header.encode())
    for source in sorted(sources):
        digest.update(f"\0{source}\0{sources[source]}".encode())
    digits = digest.hexdigest()
    return f"{{{'-'.join((digits[:8], digits[8:12], digits[12:16], digits[16:20], digits[20:32]))}}}"


def header(
    variables: Sequence[Variable],
    constants: Mapping[str, int],
    values: Sequence[float],
    stepped: SteppedCase,
    own: Sequence[str],
) -> str:
    """variables.h: places of the memory, its values at the start, and the table of variables.

    values: of the memory at the start; own: further lines
    """
    statuses = [f'    case {code}: return "{text}";' for code, text in stepped.statuses.items()]
    begun = [f"  values[{i}] = {value.hex()};" for i, value in enumerate(values) if value]
    words = {
        "constants": "\n".join(f"#define {name} {place}" for name, place in constants.items()),
        "own": "\n".join(own),
        "rows": "\n".join(map(_row, variables)),
        "begun": "\n".join(begun),
        "statuses": "\n".join(statuses),
    }
    text = HEADER
    for name, filling in words.items():
        text = text.replace(f"@{name}@", filling)
    return text


def _row(row: Variable) -> str:
    causalities = {"parameter": "PARAMETER_OF_CASE", "input": "INPUT", "output": "START" if row.starts else "OTHER"}
    least, most = map(number, row.port.bounds)
    causality = causalities.get(row.causality, "OTHER")
    return f'  {{"{row.name}", {least}, {most}, {row.place}, {row.type}, {causality}}},'


HEADER = """/* What the variables of this FMU are, where they stand in memory, and their start values. */
#ifndef VARIABLES_H
#define VARIABLES_H

#include <math.h>
#include <stdint.h>

#define TOKEN "@TOKEN@"
@constants@
@own@

enum { REAL, WHOLE, TEXT };
enum { OTHER, PARAMETER_OF_CASE, START, INPUT };

/* least, most: what a value may be; place: in the memory of its type */
typedef struct {
  const char *name;
  double least, most;
  int place, type, causality;
} variable;

static const variable variables[] = {
@rows@
};
#define VARIABLES (sizeof variables / sizeof *variables)

static void start_values(double *values) {
@begun@
}

static const char *status_text(int status) {
  switch (status) {
@statuses@
    default: return "unknown";
  }
}

#endif
"""


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
