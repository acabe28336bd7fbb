"""`vibrocap lab`: the exact capsule in one HTML page."""

import contextlib
import tempfile
import webbrowser
from pathlib import Path

from vibrocap.arguments import Complaints, suggestion
from vibrocap.cli import completers
from vibrocap.cli.command import Answer, Report, WithParts, command
from vibrocap.cli.examples import examples_folder
from vibrocap.cli.options import file, option
from vibrocap.cli.texts import split
from vibrocap.files import write_text
from vibrocap.physics import catalogue

KINDS = {"machines": catalogue.machines, "laws": catalogue.laws, "drives": catalogue.drives}


class LabRequest(WithParts):
    case: Path | None = option("a case file to begin with", place=True, sets=("system",))
    out: Path | None = file(
        "FILE.html to write; without it the page is written to a temporary folder and opened", ".html"
    )
    open: bool = option("open the page that --out writes in the browser", False, needs="out")
    machines: list[str] | None = option(
        "machines by name [default: the case's, or pendulum-capsule]", offers=completers.machine_names
    )
    laws: list[str] | None = option(
        "friction laws [default: exponential and lugre, and the case's]", offers=completers.law_names
    )
    drives: list[str] | None = option(
        "waveforms [default: harmonic and biharmonic, and the case's]", offers=completers.drive_names
    )

    def plan(self, refused: Complaints) -> None:
        """Known machines, laws and drives."""
        for kind, known in KINDS.items():
            for name in split(getattr(self, kind)):
                if name not in known():
                    refused.add(f"--{kind}", f"there is no {name!r}; {suggestion(name, known())}")


@command(
    "start",
    "vibrocap lab examples/travels-by-stick-slip.toml --laws exponential --drives harmonic --out lab.html",
    doing="The lab",
)
def lab(request: LabRequest, report: Report) -> Answer:
    """The exact capsule in a browser page.

    Drag a slider and the motion follows. The page is one file that works from disk, without a network: give it to a
    colleague, or use it in a lecture. Your own law, machine or drive (--parts) is in the page too.
    """
    from vibrocap.lab.bundle import bundle, contents, file_preset
    from vibrocap.lab.page import page

    names = {f"{kind[:-1]}_names": split(getattr(request, kind)) for kind in KINDS}
    opened = None if request.case is None else file_preset(request.case)
    text = page(bundle(contents(opened, examples=examples_folder(), **names), report))
    target = request.out or Path(tempfile.mkdtemp(prefix="vibrocap-")) / "lab.html"
    write_text(target, text)
    if request.out is None or request.open:
        with contextlib.suppress(webbrowser.Error):
            webbrowser.open(target.resolve().as_uri())
    return Answer(text=f"Written: {target} ({len(text) / 1000:.0f} kB)")
