"""`vibrocap export`: a case as what other programs run."""

from pathlib import Path
from typing import Literal

from vibrocap.arguments import ArgumentError
from vibrocap.cli.options import Refusal, own_names, writable_folder
from vibrocap.cli.terminal import OK, Page
from vibrocap.io.motion_file import read_source


def export(
    case: Path,
    /,
    *,
    to: Literal["c"] = "c",
    input: Literal["drive"] | None = None,
    out: Path,
    name: str = "capsule",
) -> int:
    """A case for other programs, with its exact contact: a library in C99 that moves it on, and a program that calls it.

    The sources need a C compiler and no other library; they give the same bits with every compiler and optimisation.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    to
        what to write: c for C sources
    input
        what the caller sets from step to step: drive; by default nothing, and the case's own drive goes on
    out
        folder for NAME.c, NAME.h, main.c and README.txt; made where it is missing
    name
        of the library, with which all its names begin
    """
    from vibrocap.exchange.c_library import export_c

    setup = read_source(case)
    writable_folder("--out", out)
    own_names("--out", out, f"{name}.c", f"{name}.h", "main.c", "README.txt")
    try:
        written = export_c(setup, out, name, input)
    except ArgumentError as error:
        raise Refusal(f"--{error}") from None
    Page().say(f"Written to {out}: {', '.join(path.name for path in written)}")
    return OK
