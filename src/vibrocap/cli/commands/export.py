"""`vibrocap export`: a case as what other programs run."""

from pathlib import Path
from typing import TYPE_CHECKING, Literal

from vibrocap.arguments import Complaints
from vibrocap.cli.command import Answer, OfCase, command
from vibrocap.cli.options import needs, option, own_names, required, writable_file, writable_folder
from vibrocap.cli.terminal import Page, progress, said, table
from vibrocap.cli.texts import split

if TYPE_CHECKING:
    from vibrocap.case.case import Case
    from vibrocap.exchange.mjcf import MujocoModel


class ExportRequest(OfCase):
    to: Literal["c", "fmu", "mjcf"] = option(
        "C sources (c), an FMU for co-simulation (fmu), a MuJoCo model (mjcf)", "c"
    )
    out: Path = required("folder of the C sources, FILE.fmu of an FMU, FILE.xml of a MuJoCo model")
    input: Literal["drive"] | None = option("the caller sets the drive from step to step [default: the case's drive]")
    judge: bool = option(
        "run the MuJoCo model too (needs mujoco), and compare its end with that of the exact motion", False
    )
    name: str = option("of the library or of the model, with which all its names begin", "capsule", advanced=True)
    fmi: Literal["3.0", "2.0"] | None = option("version of an FMU [default: 3.0]", advanced=True)
    platforms: list[str] | None = option(
        "of an FMU's machine code, such as x86_64-windows, all or none [default: this computer's if it has a compiler]",
        advanced=True,
    )

    def plan(self, refused: Complaints) -> None:
        """Some options are of one form only."""
        if self.judge and self.to != "mjcf":
            refused.add("--judge", "should be left out without --to mjcf: other exports are the exact motion")
        for name in self.given("fmi", "platforms") if self.to != "fmu" else ():
            refused.add(f"--{name}", "should be left out without --to fmu")
        if self.to == "mjcf" and self.input is not None:
            refused.add("--input", "should be left out with --to mjcf, whose controls are always set from outside")


@command(
    "out",
    "vibrocap export examples/travels-by-stick-slip.toml --to c --out capsule",
    "vibrocap export examples/travels-by-stick-slip.toml --to c --input drive --out capsule",
    "vibrocap export examples/travels-by-stick-slip.toml --to mjcf --out capsule.xml",
    "vibrocap export examples/bench-in-si.toml --to fmu --input drive --out capsule.fmu",
)
def export(request: ExportRequest) -> Answer:
    """A case for other programs: C99, FMU or MuJoCo.

    --to c writes a stepper in C with the exact contact, which needs no other library and gives the same bits with every
    compiler. --to fmu writes a file for Simulink, Dymola, OpenModelica, FMPy and other importers of FMI. --to mjcf
    writes a MuJoCo model and lists its losses: its friction has one level and creeps at rest.
    """
    if request.to == "fmu":
        options = request.given("fmi", "platforms")
        return _fmu(request.setup, request.out, input=request.input, name=request.name, **options)
    if request.to == "mjcf":
        return _mjcf(request.setup, request.out, request.judge)
    from vibrocap.exchange.c_library import export_c

    writable_folder("--out", request.out)
    own_names("--out", request.out, f"{request.name}.c", f"{request.name}.h", "main.c", "README.txt")
    written = export_c(request.setup, request.out, request.name, request.input)
    return Answer(text=f"Written to {request.out}: {', '.join(path.name for path in written)}")


def _fmu(case: "Case", out: Path, platforms: list[str] | None = None, **options) -> Answer:
    from vibrocap.exchange.fmu.fmu import BuildError, export_fmu

    writable_file("--out", out, (".fmu",))
    try:
        compiled = export_fmu(case, out, platforms=split(platforms) or None, **options)
    except BuildError as error:
        return Answer(incomplete=str(error))
    holds = f"machine code for {', '.join(compiled)}, and its sources" if compiled else "its sources"
    missing = "\nNo C compiler was found: its importer has to compile it."
    return Answer(text=f"Written to {out}: an FMU with {holds}.{missing * (not compiled and platforms is None)}")


def _mjcf(case: "Case", out: Path, judge: bool) -> Answer:
    """The MuJoCo model, what it loses, and how far it ends from the exact motion."""
    from vibrocap.exchange.mjcf import export_mjcf

    writable_file("--out", out, (".xml",))
    if judge:
        needs("--judge", "mujoco")
    model = export_mjcf(case, out)
    lines = [f"Written to {out}; MuJoCo cannot express of this case:", *(f"  {line}" for line in model.lost)]
    return _judged(lines, case, model) if judge else Answer(text="\n".join(lines))


def _judged(lines: list[str], case: "Case", model: "MujocoModel") -> Answer:
    """The same, with a table of where MuJoCo ends."""
    from vibrocap.exchange.mjcf import judgement

    with progress("Running MuJoCo"):
        result = judgement(case, model)
    length = 1.0 if case.system.units is None else case.system.si.factor_of("m")
    unit = "" if case.system.units is None else "m"
    rows = table(f"After {result.steps} steps of MuJoCo", "motion", "place", "off by", "drift")
    exact = result.exact_ending
    for motion, ending in (
        ("exact", exact),
        ("MuJoCo, the file as it is", result.as_written),
        ("MuJoCo, friction rewritten at each step", result.rewritten),
    ):
        off = "" if ending is exact else said(length * (ending.place - exact.place), unit, 3)
        travel = "" if ending.drift is None else said(length * ending.drift, unit, 4)
        rows.add_row(motion, said(length * ending.place, unit, 6), off, travel)
    incomplete = f"The exact motion ended early ({result.exact.status.value}). {result.exact.status.advice}"

    def text(page: Page) -> None:
        page.say("\n".join(lines))
        page.print(rows)

    return Answer(text=text, incomplete="" if result.exact.status.ok else incomplete)
