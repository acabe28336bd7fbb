"""A case as an FMU: the file that Simulink, Dymola, OpenModelica, FMPy and other importers of FMI open."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from vibrocap.arguments import check_one_of
from vibrocap.case.case import Case
from vibrocap.exchange.c_library import checked_name
from vibrocap.exchange.fmu.binaries import checked_platforms
from vibrocap.exchange.fmu.co_simulation import co_simulation
from vibrocap.exchange.fmu.package import zipped
from vibrocap.exchange.stepped_case import Input, SteppedCase
from vibrocap.files import replacing

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
    made = zipped(co_simulation(SteppedCase(case, input), name), fmi, asked)
    with replacing(path) as temporary:
        temporary.write_bytes(made)
    return asked
