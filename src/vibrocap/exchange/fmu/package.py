"""The zip file of an FMU: description, sources and machine code, the same bytes for the same case."""

import dataclasses
import hashlib
import io
import zipfile
from collections.abc import Mapping, Sequence
from importlib.resources import files as own_files

from vibrocap.exchange.fmu.binaries import PLATFORMS, binary
from vibrocap.exchange.fmu.description import build_description, description_3
from vibrocap.exchange.fmu.variables import Variable

EPOCH = (1980, 1, 1, 0, 0, 0)  # of all files in the zip
KIND_FILES = {"ModelExchange": "model_exchange.c", "CoSimulation": "co_simulation.c"}


@dataclasses.dataclass(frozen=True)
class Package:
    """What an FMU is made of, besides what all have in common.

    kind: "ModelExchange" or "CoSimulation"; able: what its description says that it can do
    indicators: names of the event indicators; experiment: start and stop time, tolerance, step
    sources: texts in C by file name; header: what stands in variables.h besides the token
    """

    name: str
    kind: str
    meaning: str
    able: Mapping[str, str]
    variables: tuple[Variable, ...]
    indicators: tuple[str, ...]
    experiment: Mapping[str, float]
    sources: Mapping[str, str]
    header: str


def zipped(package: Package, platforms: Sequence[str]) -> bytes:
    """The FMU, of FMI 3.0, with machine code for these platforms.

    Raises BuildError where a compiler fails.
    """
    own = own_files("vibrocap.exchange.fmu") / "c"
    kind = KIND_FILES[package.kind]
    sources = {**package.sources}
    for each in ("fmi3.h", "fmi3.c", "instance.h", kind):
        sources[each] = (own / each).read_text(encoding="utf-8")
    token = _token(package, sources)
    sources["variables.h"] = package.header.replace("@TOKEN@", token).replace("@KIND_FILE@", kind)
    compiled = [each for each in (*package.sources, "fmi3.c") if each.endswith(".c")]
    description = description_3(
        package.name,
        token,
        package.meaning,
        package.kind,
        package.able,
        package.variables,
        package.indicators,
        package.experiment,
    )
    files = {"modelDescription.xml": description}
    files["sources/buildDescription.xml"] = build_description(package.name, compiled)
    files |= {f"sources/{each}": text.encode() for each, text in sources.items()}
    for each in platforms:
        ending = PLATFORMS[each][1]
        files[f"binaries/{each}/{package.name}{ending}"] = binary(sources, compiled, package.name, each)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as file:
        for each in sorted(files, key=lambda name: (name != "modelDescription.xml", name)):
            entry = zipfile.ZipInfo(each, EPOCH)
            entry.external_attr = 0o644 << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            file.writestr(entry, files[each], compresslevel=9)
    return packed.getvalue()


def _token(package: Package, sources: Mapping[str, str]) -> str:
    """A digest of all that the FMU computes."""
    found = hashlib.sha256(package.header.encode())
    for each in sorted(sources):
        found.update(f"\0{each}\0{sources[each]}".encode())
    return f"{{{found.hexdigest()[:32]}}}"


def header(
    variables: Sequence[Variable],
    constants: Mapping[str, int],
    values: Mapping[int, float],
    statuses: Mapping[int, str],
    time_factor: float,
    own: Sequence[str],
) -> str:
    """variables.h: places of the memory, its values at the start, and the table of variables.

    values: of the memory at the start, by place; own: lines of one kind of FMU
    """
    causalities = {"parameter": "PARAMETER_OF_CASE", "input": "INPUT", "independent": "OTHER", "local": "OTHER"}
    rows = []
    for each in variables:
        is_start = each.causality == "output" and each.start is not None
        causality = "START" if is_start else causalities.get(each.causality, "OTHER")
        factor = each.factor.hex() if isinstance(each.factor, float) else repr(each.factor)
        rows.append(f'  {{"{each.name}", {factor}, {each.place}, {each.type}, {causality}, {each.bound}}},')
    begun = [f"  d->values[{i}] = {value.hex()};" for i, value in values.items() if value]
    cases = [f'    case {code}: return "{text}";' for code, text in statuses.items()]
    return "\n".join(
        [
            "/* What the variables of this FMU are, where they stand in memory, and their start values. */",
            "#ifndef VARIABLES_H",
            "#define VARIABLES_H",
            "",
            "#include <stdint.h>",
            "",
            '#define TOKEN "@TOKEN@"',
            '#define KIND_FILE "@KIND_FILE@"',
            f"#define TIME_FACTOR {time_factor.hex()}",
            *(f"#define {each} {place}" for each, place in constants.items()),
            *own,
            "",
            "enum { REAL, WHOLE, TEXT };",
            "enum { OTHER, PARAMETER_OF_CASE, START, INPUT };",
            "enum { ANYWHERE, ABOVE_ZERO, FROM_ZERO };",
            "/* place: in the memory of its type; factor: what one dimensionless unit is in the unit of the variable */",
            "typedef struct {",
            "  const char *name;",
            "  double factor;",
            "  int place, type, causality, bound;",
            "} variable;",
            f"#define VARIABLES {len(rows)}",
            "static const variable variables[VARIABLES] = {",
            *rows,
            "};",
            "",
            "static void start_values(double *values) {",
            *(line.replace("d->values", "values") for line in begun),
            "}",
            "",
            "static const char *status_text(int status) {",
            "  switch (status) {",
            *cases,
            '    default: return "unknown";',
            "  }",
            "}",
            "",
            "#endif",
            "",
        ]
    )
