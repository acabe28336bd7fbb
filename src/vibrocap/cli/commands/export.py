"""`vibrocap export`: a case as what other programs run."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from vibrocap.arguments import ArgumentError
from vibrocap.cli.options import Refusal, needs, own_names, split, writable_file, writable_folder
from vibrocap.cli.terminal import INCOMPLETE, OK, Page, complain, progress, said, table
from vibrocap.io.motion_file import read_source

if TYPE_CHECKING:
    from vibrocap.case.case import Case
    from vibrocap.exchange.mjcf import MujocoModel
    from vibrocap.exchange.mujoco_motion import Ending


def export(
    case: Path,
    /,
    *,
    to: Literal["c", "fmu", "mjcf"] = "c",
    input: Literal["drive"] | None = None,
    out: Path,
    name: str = "capsule",
    fmi: Literal["3.0", "2.0"] | None = None,
    platforms: list[str] | None = None,
    judge: bool = False,
) -> int:
    """Write a case for other programs: with its exact contact as C99 or as an FMU, or as the nearest MuJoCo model.

    --to c writes a stepper in C, which needs no other library and gives the same bits with every compiler.
    --to fmu writes a file for Simulink, Dymola, OpenModelica, FMPy and other importers of FMI.
    --to mjcf writes a MuJoCo model and says what it loses: its friction has one level and creeps at rest.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    to
        what to write: C sources (c), an FMU for co-simulation (fmu), a MuJoCo model (mjcf)
    input
        what the caller sets from step to step: drive; by default nothing, and the case's own drive continues
    out
        folder of the C sources, made where it is missing; of an FMU FILE.fmu, of a MuJoCo model FILE.xml
    name
        of the library or of the model, with which all its names begin
    fmi
        version of an FMU: 3.0 by default
    platforms
        of an FMU's machine code, such as x86_64-windows, all or none; by default this computer's if it has a compiler
    judge
        run the MuJoCo model, too (needs mujoco), and print where it ends beside the exact motion
    """
    setup = read_source(case)
    of_fmu = {"fmi": fmi, "platforms": platforms}
    if judge and to != "mjcf":
        raise Refusal("--judge: should be left out without --to mjcf: other exports are the exact motion")
    if to == "fmu":
        return _fmu(setup, out, input=input, name=name, **{each: value for each, value in of_fmu.items() if value})
    if given := [each for each, value in of_fmu.items() if value]:
        raise Refusal(*(f"--{each}: should be left out without --to fmu" for each in given))
    if to == "mjcf":
        if input is not None:
            raise Refusal("--input: should be left out with --to mjcf, whose controls are always set from outside")
        return _mjcf(setup, out, judge)
    return _c(setup, out, name, input)


def _c(case: "Case", out: Path, name: str, input: Literal["drive"] | None) -> int:
    """The C library."""
    from vibrocap.exchange.c_library import export_c

    writable_folder("--out", out)
    own_names("--out", out, f"{name}.c", f"{name}.h", "main.c", "README.txt")
    try:
        written = export_c(case, out, name, input)
    except ArgumentError as error:
        raise Refusal(f"--{error}") from None
    Page().say(f"Written to {out}: {', '.join(path.name for path in written)}")
    return OK


def _fmu(case: "Case", out: Path, platforms: list[str] | None = None, **options) -> int:
    """The FMU."""
    from vibrocap.exchange.fmu.binaries import BuildError
    from vibrocap.exchange.fmu.fmu import export_fmu

    writable_file("--out", out, (".fmu",))
    try:
        compiled = export_fmu(case, out, platforms=split(platforms) or None, **options)
    except ArgumentError as error:
        raise Refusal(f"--{error}") from None
    except BuildError as error:
        complain(str(error))
        return INCOMPLETE
    holds = f"machine code for {', '.join(compiled)}, and its sources" if compiled else "its sources"
    Page().say(f"Written to {out}: an FMU with {holds}.")
    if not compiled and platforms is None:
        Page().say("No C compiler was found: its importer has to compile it.")
    return OK


def _mjcf(case: "Case", out: Path, judge: bool) -> int:
    """The MuJoCo model, what it loses, and how far it ends from the exact motion."""
    from vibrocap.exchange.mjcf import export_mjcf

    writable_file("--out", out, (".xml",))
    if judge:
        needs("--judge", "mujoco")
    try:
        model = export_mjcf(case, out)
    except ArgumentError as error:
        raise Refusal(f"CASE: {error}") from None
    page = Page()
    page.say(f"Written to {out}; what MuJoCo cannot say of this case:")
    for sentence in model.lost:
        page.say(f"  {sentence}")
    return _judged(page, case, model) if judge else OK


def _judged(page: Page, case: "Case", model: "MujocoModel") -> int:
    from vibrocap.exchange.mujoco_motion import judgement

    with progress("Running MuJoCo"):
        found = judgement(case, model)
    length = 1.0 if case.system.units is None else case.system.si.factor_of("m")
    unit = "" if case.system.units is None else "m"
    rows = table(f"After {found.steps} steps of MuJoCo", "motion", "place", "off by", "drift")
    rows.add_row("exact", *_said(found.exact_ending, found.exact_ending, length, unit))
    rows.add_row("MuJoCo, the file as it is", *_said(found.as_written, found.exact_ending, length, unit))
    rows.add_row("MuJoCo, friction rewritten at each step", *_said(found.rewritten, found.exact_ending, length, unit))
    page.print(rows)
    if found.exact.status.ok:
        return OK
    complain(f"The exact motion ended early ({found.exact.status.value}). {found.exact.status.advice}")
    return INCOMPLETE


def _said(ending: "Ending", exact: "Ending", length: float, unit: str) -> tuple[str, str, str]:
    off = "" if ending is exact else said(length * (ending.place - exact.place), unit, 3)
    travel = "" if ending.drift is None else said(length * ending.drift, unit, 4)
    return said(length * ending.place, unit, 6), off, travel
