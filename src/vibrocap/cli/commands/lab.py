"""`vibrocap lab`: the exact capsule in one HTML page."""

import contextlib
import tempfile
import webbrowser
from pathlib import Path

from vibrocap.arguments import ArgumentError, Complaints, suggestion
from vibrocap.case.case import CaseError
from vibrocap.cli.command_examples import examples_folder
from vibrocap.cli.options import Refusal, split, writable_file
from vibrocap.cli.terminal import OK, Page, progress
from vibrocap.files import write_text
from vibrocap.physics import catalogue


def lab(
    case: Path | None = None,
    /,
    *,
    out: Path | None = None,
    open: bool | None = None,
    machines: list[str] | None = None,
    laws: list[str] | None = None,
    drives: list[str] | None = None,
) -> int:
    """The exact capsule in a browser page: drag a slider and the motion follows.

    The page is one file that works from disk, without a network: give it to a colleague, or use it in a lecture.

    Parameters
    ----------
    case
        a case file to begin with; its parts are in the page, with your own law, machine or drive (--parts) too
    out
        FILE.html to write; without it the page is written to a temporary folder and opened
    open
        open the page in the browser [default: without --out]
    machines
        kinds of machine in the page, by name with commas between [default: the case's, or pendulum-capsule]
    laws
        friction laws in the page [default: exponential and lugre, and the case's]
    drives
        waveforms in the page [default: harmonic and biharmonic, and the case's]
    """
    from vibrocap.lab.bundle import bundle, contents
    from vibrocap.lab.page import page
    from vibrocap.lab.presets import file_preset

    complaints = Complaints()
    asked = {
        "--machines": (split(machines), catalogue.machines()),
        "--laws": (split(laws), catalogue.laws()),
        "--drives": (split(drives), catalogue.drives()),
    }
    for option, (names, known) in asked.items():
        for name in names:
            if name not in known:
                complaints.add(option, f"there is no {name!r}; {suggestion(name, known)}")
    with complaints.collected():
        writable_file("--out", out, (".html",))
    opened = None
    if case is not None:
        try:
            opened = file_preset(case)
        except CaseError as error:
            raise CaseError([*error.complaints, *complaints], error.source) from None
    if complaints:
        raise Refusal(*complaints)
    names = {f"{option[2:-1]}_names": given for option, (given, _) in asked.items()}
    try:
        chosen = contents(opened, examples=examples_folder(), **names)
        with progress("The lab") as report:
            text = page(bundle(chosen, report))
    except ArgumentError as error:
        raise Refusal(f"{case}: {error}" if case is not None else str(error)) from None
    target = out or Path(tempfile.mkdtemp(prefix="vibrocap-")) / "lab.html"
    write_text(target, text)
    Page().say(f"Written: {target} ({len(text) / 1000:.0f} kB)")
    if out is None if open is None else open:
        with contextlib.suppress(webbrowser.Error):
            webbrowser.open(target.resolve().as_uri())
    return OK
