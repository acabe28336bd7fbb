"""The zip file of an FMU: description, sources and machine code, the same bytes for the same case."""

import hashlib
import io
import zipfile
from collections.abc import Mapping, Sequence
from importlib.resources import files as own_files

from vibrocap.exchange.c_library import number
from vibrocap.exchange.fmu.binaries import PLATFORMS, binary
from vibrocap.exchange.fmu.description import Package, build_description, description
from vibrocap.exchange.fmu.variables import Variable
from vibrocap.exchange.stepped_case import SteppedCase

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
    for platform in platforms:
        known = PLATFORMS[platform]
        folder_name = known.in_fmi_2 if fmi == "2.0" else platform
        code = binary(sources, compiled, package.name, platform)
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
