"""A case as an FMU: the file that Simulink, Dymola, OpenModelica, FMPy and other importers of FMI open."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

from vibrocap.arguments import check_one_of
from vibrocap.case.case import Case
from vibrocap.exchange.c_library import c_files, checked_name
from vibrocap.exchange.fmu import variables as of
from vibrocap.exchange.fmu.binaries import checked_platforms
from vibrocap.exchange.fmu.description import Package
from vibrocap.exchange.fmu.package import header, zipped
from vibrocap.exchange.stepped_case import Input, SteppedCase
from vibrocap.files import replacing
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
