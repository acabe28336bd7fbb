"""`vibrocap calibrate`: parameters of a case from a measured table of settled motions."""

from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import Complaints
from vibrocap.cli.options import Refusal, pairs, refusing, writable_folder
from vibrocap.cli.terminal import OK, Page, progress
from vibrocap.files import made_folder, write_table, write_text
from vibrocap.io.motion_file import read_source
from vibrocap.quantities.dimensional import in_si
from vibrocap.quantities.json_text import json_text


def calibrate(
    case: Path,
    /,
    *,
    to: Path,
    over: list[str],
    held_out: list[int] | None = None,
    out: Path | None = None,
    starts: int = 256,
    seed: int = 0,
    periods: int = 300,
    json: bool = False,
) -> int:
    """Parameters of machine, friction and drive from a measured table, with joint 95 % intervals.

    Each row of the table is a settled motion: columns named by parameters say its
    conditions, columns named by measures what was read (mean_velocity, in SI where the
    case is, other units in the heading: drive.period_ms, mean_velocity [mm/s]),
    mean_velocity_error its standard error. Parameters that the table does not determine
    are marked, and a column that does not fit is named, as are rows that do not settle.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv): what is known of the machine
    to
        the table, a CSV file with a line of headings
    over
        PATH=LEAST:LARGEST, what is unknown and within which bounds; PATH,PATH=factor:LEAST:LARGEST for one factor of
        the values of the case; once for each parameter
    held_out
        rows, from 1, that the fit does not see and that judge it
    out
        a folder for calibration.json, residuals.csv and calibrated.toml, the case with the parameters found
    starts
        points from which the search begins
    seed
        of these points
    periods
        drive periods that the run of a row has to settle
    json
        print one JSON object in full precision instead of a table
    """
    from vibrocap.design.calibration.calibration import calibrate as calibrated

    given = read_source(case)
    complaints = Complaints()
    ranges: dict[str, Any] = dict(pairs("over", over, complaints, "PATH=LEAST:LARGEST, such as machine.damping=0.5:3"))
    if complaints:
        raise Refusal(*complaints)
    if out is not None:
        writable_folder("--out", out, "calibration.json", "residuals.csv", "calibrated.toml")
    rows = [row - 1 for row in held_out or ()]
    with progress("Calibrating") as report, refusing("starts", "seed", "periods", table="--to", held_out="--held-out"):
        found = calibrated(given, to, ranges, held_out=rows, starts=starts, seed=seed, periods=periods, progress=report)
    record = in_si(found)
    if out is not None:
        folder = made_folder(out)
        write_text(folder / "calibration.json", json_text(record) + "\n")
        columns = _residuals(found)
        write_table(folder / "residuals.csv", columns, zip(*columns.values(), strict=True))
        found.case().save(folder / "calibrated.toml")
    if json:
        print(json_text(record))
        return OK
    page = Page()
    page.say(f"Calibration of {case} on {found.measured.rows} rows of {to}", style="bold")
    page.rows(list(found.facts.items()), 2 + max(map(len, found.facts)))
    weak = [each for each in found.directions if not each.determined]
    page.rows([("not determined", str(each)) for each in weak], 16)
    if out is not None:
        page.rows([("case", str(out / "calibrated.toml"))], 16)
    return OK


def _residuals(found: Any) -> dict[str, list[float]]:
    """Columns by name with the conditions, and of each measure what was read, what is predicted and the residual."""
    columns = dict(found.measured.conditions)
    for name in found.measured.measures:
        columns[name] = found.measured.targets[name]
        columns[f"{name}_predicted"] = found.predicted[name]
        columns[f"{name}_residual"] = found.residuals[name]
    return {name: np.asarray(column, dtype=float).tolist() for name, column in columns.items()}
