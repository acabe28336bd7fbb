"""A case as an FMU: the file that Simulink, Dymola, OpenModelica, FMPy and other importers of FMI open."""

from collections.abc import Sequence
from pathlib import Path

from vibrocap.case.case import Case
from vibrocap.exchange.c_library import checked_name
from vibrocap.exchange.fmu.binaries import checked_platforms
from vibrocap.exchange.fmu.model_exchange import model_exchange
from vibrocap.exchange.fmu.package import zipped
from vibrocap.files import replacing


def export_fmu(
    case: Case,
    path: str | Path,
    kind: str = "co-simulation",
    fmi: str = "3.0",
    name: str = "capsule",
    platforms: Sequence[str] | None = None,
) -> tuple[str, ...]:
    """Write a case as an FMU; returns the platforms for which it holds machine code, none where it holds sources only.

    kind: "model-exchange": rates and event indicators for the importer's integrator, whose error it has
    name: of the model, as in `c_files`; platforms: see `checked_platforms`
    Raises ArgumentError for what cannot be exported so, BuildError where a compiler fails, WriteError.
    """
    name, asked = checked_name(name), checked_platforms(platforms)
    made = zipped(model_exchange(case, name), asked)
    with replacing(path) as temporary:
        temporary.write_bytes(made)
    return asked
