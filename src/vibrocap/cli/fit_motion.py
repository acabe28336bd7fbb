"""`vibrocap fit --machine CASE`: parameters of a case from motions under a measured force, and what it predicts."""

from typing import TYPE_CHECKING, Any

from vibrocap.cli.command import Answer, Report
from vibrocap.cli.destinations import own_names
from vibrocap.cli.fit_request import FitRequest
from vibrocap.cli.terminal import Page
from vibrocap.cli.texts import checked_pairs
from vibrocap.files import made_folder, write_table, write_text
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.dimensional import in_si
from vibrocap.quantities.json_text import json_text

if TYPE_CHECKING:
    from vibrocap.design.calibration.motion_fit import MotionFit
    from vibrocap.records.record import Record

FILES = ("motion-fit.json", "fitted.toml", "predicted.csv")  # what it writes into --out


def fit_machine(request: FitRequest, records: "list[Record]", hidden: list[str], report: Report) -> Answer:
    """A case fitted to records."""
    from vibrocap.design.calibration.motion_fit import fit_motion

    assert request.machine is not None
    ranges: dict[str, Any] = checked_pairs("over", request.over, "PATH=LEAST:LARGEST, such as machine.mass_kg=1:10")
    if request.out is not None:
        own_names("--out", request.out, *FILES)
    found = fit_motion(
        read_source(request.machine),
        records,
        ranges,
        predict=request.predict,
        held_out=hidden,
        starts=request.starts,
        seed=request.seed,
        progress=report,
    )
    written = []
    if request.out is not None:
        folder = made_folder(request.out)
        written.append(write_text(folder / FILES[0], json_text(in_si(found)) + "\n"))
        written.append(found.case().save(folder / FILES[1]))
        written.append(write_table(folder / FILES[2], COLUMNS, _rows(found)))

    def text(page: Page) -> None:
        page.say(f"{found.heading}, by {request.machine}", style="bold")
        page.rows(list(found.facts.items()), 2 + max(map(len, found.facts)))

    return Answer(in_si(found), text, found, written=tuple(("Written:", path) for path in written))


COLUMNS = ("record", "held_out", "time", "measured", "predicted", "band")


def _rows(found: "MotionFit") -> Any:
    """Every sample of every record that judges the fit."""
    for name in found.measured:
        columns = (found.time[name], found.measured[name], found.predicted[name], found.band[name])
        for row in zip(*columns, strict=True):
            yield (name, int(name in found.held_out), *(f"{value:.9g}" for value in row))
