"""A case as an FMU: the file that Simulink, Dymola, OpenModelica, FMPy and other importers of FMI open."""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from vibrocap.arguments import ArgumentError, check_one_of
from vibrocap.case.case import Case
from vibrocap.exchange.c_library import checked_name
from vibrocap.exchange.fmu.binaries import checked_platforms
from vibrocap.exchange.fmu.co_simulation import co_simulation
from vibrocap.exchange.fmu.model_exchange import model_exchange
from vibrocap.exchange.fmu.package import zipped
from vibrocap.exchange.stepped_case import Input, SteppedCase
from vibrocap.files import replacing

KINDS = {"co-simulation": co_simulation, "model-exchange": model_exchange}
VERSIONS = ("3.0", "2.0")

Kind = Literal["co-simulation", "model-exchange"]
Version = Literal["3.0", "2.0"]


def export_fmu(
    case: Case,
    path: str | Path,
    *,
    input: Input = None,
    kind: Kind = "co-simulation",
    fmi: Version = "3.0",
    name: str = "capsule",
    platforms: Sequence[str] | None = None,
) -> tuple[str, ...]:
    """Write a case as an FMU; returns the platforms for which it holds machine code, none where it holds sources only.

    input: "drive" for a drive that the importer gives; None: that of the case
    kind: "co-simulation": exact inside; "model-exchange": rates and event indicators for the integrator of the
        importer, whose error it has, in FMI 3.0
    name: of the model, as in `c_files`; platforms: see `checked_platforms`

    Raises ArgumentError for what cannot be exported so, BuildError where a compiler fails, WriteError.
    """
    checked_name(name)
    check_one_of("kind", kind, KINDS)
    check_one_of("fmi", fmi, VERSIONS)
    if fmi == "2.0" and kind == "model-exchange":
        raise ArgumentError("fmi", "should be 3.0 for model exchange, got 2.0")
    asked = checked_platforms(platforms, fmi)
    made = zipped(KINDS[kind](SteppedCase(case, input), name), fmi, asked)
    with replacing(path) as temporary:
        temporary.write_bytes(made)
    return asked
