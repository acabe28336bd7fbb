"""`vibrocap fit --machine CASE`: parameters of a case from motions under a measured force, and what it predicts."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.arguments import Complaints
from vibrocap.cli.options import Refusal, own_names, pairs, refusing
from vibrocap.cli.terminal import OK, Page, progress
from vibrocap.files import made_folder, write_table, write_text
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.dimensional import in_si
from vibrocap.quantities.json_text import json_text

if TYPE_CHECKING:
    from vibrocap.design.calibration.motion_fit import MotionFit
    from vibrocap.records.record import Record

FILES = ("motion-fit.json", "fitted.toml", "predicted.csv", "motion-fit.png")  # what it writes into --out


def fit_machine(
    machine: Path,
    records: "list[Record]",
    over: "list[str] | None",
    predict: str,
    hidden: list[str],
    settings: dict[str, Any],
    out: Path | None,
    plot: Path | None,
    json: bool,
) -> int:
    """Fit a case to records, and show, draw and write what was found."""
    from vibrocap.design.calibration.motion_fit import fit_motion

    complaints = Complaints()
    ranges: dict[str, Any] = dict(pairs("over", over, complaints, "PATH=LEAST:LARGEST, such as machine.mass_kg=1:10"))
    if out is not None:
        own_names("--out", out, *FILES)
    if complaints:
        raise Refusal(*complaints)
    case = read_source(machine)
    with progress(f"Fitting {predict}") as report, refusing(*settings, "predict", held_out="--hold-out"):
        found = fit_motion(
            case,
            records,
            ranges,
            predict=predict,
            held_out=hidden,
            progress=report,
            **settings,
        )
    written = []
    if out is not None:
        folder = made_folder(out)
        written.append(write_text(folder / FILES[0], json_text(in_si(found)) + "\n"))
        written.append(found.case().save(folder / FILES[1]))
        written.append(write_table(folder / FILES[2], COLUMNS, _rows(found)))
    if plot is not None:
        from vibrocap.plotting.look.finishing import save
        from vibrocap.plotting.motion_fits import motion_fit_figure

        written.append(save(motion_fit_figure(found), plot))
    if json:
        print(json_text(in_si(found)))
        return OK
    page = Page()
    page.say(f"{found.heading} by {machine}", style="bold")
    page.rows(list(found.facts.items()), 2 + max(map(len, found.facts)))
    for path in written:
        page.say(f"Written: {path}")
    return OK


COLUMNS = ("record", "held_out", "time", "measured", "predicted", "band")


def _rows(found: "MotionFit") -> Any:
    """Every sample of every record that judges the fit."""
    for name in found.measured:
        columns = (found.time[name], found.measured[name], found.predicted[name], found.band[name])
        for row in zip(*columns, strict=True):
            yield (name, int(name in found.held_out), *(f"{value:.9g}" for value in row))
