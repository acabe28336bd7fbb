"""`vibrocap calibrate`: parameters of a case from a measured table of settled motions."""

from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.cli import completers
from vibrocap.cli.command import Answer, Drawn, OfCase, Report, command
from vibrocap.cli.options import JSON, SEED, folder, option, picture, required
from vibrocap.cli.terminal import Page
from vibrocap.cli.texts import checked_pairs
from vibrocap.files import made_folder, write_table, write_text
from vibrocap.quantities.dimensional import in_si
from vibrocap.quantities.json_text import json_text


class CalibrateRequest(OfCase, Drawn):
    to: Path = required("the table, a CSV file with a line of headings", sets=("table",))
    over: list[str] = required(
        "PATH=LEAST:LARGEST, an unknown parameter and its bounds; PATH,PATH=factor:LEAST:LARGEST for one factor of "
        "the values of the case; may be repeated",
        offers=completers.paths_of_case,
    )
    held_out: list[int] | None = option("rows, from 1, that judge the fit and are not fitted")
    out: Path | None = folder(
        "a folder for calibration.json, residuals.csv and calibrated.toml, the calibrated case",
        *("calibration.json", "residuals.csv", "calibrated.toml"),
    )
    plot: Path | None = picture("measured and predicted rows, residuals and intervals")
    json: bool = JSON
    starts: int = option("points from which the search begins", 256, advanced=True)
    seed: int = SEED
    periods: int = option("drive periods in which the run of a row has to settle", 300, advanced=True)


@command(
    "design",
    "vibrocap calibrate examples/bench-in-si.toml --to examples/bench-in-si-speeds.csv "
    "--over friction.coulomb_coefficient=0.02:0.2 --over machine.damping_N_m_s_per_rad=0.02:0.3 --out calibrated",
    doing="Calibrating",
)
def calibrate(request: CalibrateRequest, report: Report) -> Answer:
    """Parameters of a case from a measured table of motions.

    Each row of the table is a settled motion: columns named by parameters are its conditions, columns named by measures
    the readings (mean_velocity, in SI where the case is, other units in the heading: drive.period_ms, mean_velocity
    [mm/s]), mean_velocity_error a standard error. The report has the parameters of machine, friction and drive with
    joint 95 % intervals. It marks parameters that the table does not determine, and names columns that do not fit and
    rows that do not settle.
    """
    from vibrocap.design.calibration.calibration import calibrate as calibrated

    ranges: dict[str, Any] = checked_pairs("over", request.over, "PATH=LEAST:LARGEST, such as machine.damping=0.5:3")
    held_out, settings = [row - 1 for row in request.held_out or ()], request.given("starts", "seed", "periods")
    result = calibrated(request.setup, request.to, ranges, held_out=held_out, progress=report, **settings)
    record = in_si(result)
    written = []
    if request.out is not None:
        folder = made_folder(request.out)
        write_text(folder / "calibration.json", json_text(record) + "\n")
        columns = _residuals(result)
        write_table(folder / "residuals.csv", columns, zip(*columns.values(), strict=True))
        result.case().save(folder / "calibrated.toml")
        written = [("case", request.out / "calibrated.toml")]

    def text(page: Page) -> None:
        page.say(f"Calibration of {request.case} on {result.measured.rows} rows of {request.to}", style="bold")
        page.rows(list(result.facts.items()), 2 + max(map(len, result.facts)))
        page.rows([("not determined", str(line)) for line in result.directions if not line.determined], 16)

    return Answer(record, text, result, written=tuple(written))


def _residuals(calibration: Any) -> dict[str, list[float]]:
    """Columns by name with the conditions, and of each measure what was read, what is predicted and the residual."""
    columns = dict(calibration.measured.conditions)
    for name in calibration.measured.measures:
        columns[name] = calibration.measured.targets[name]
        columns[f"{name}_predicted"] = calibration.predicted[name]
        columns[f"{name}_residual"] = calibration.residuals[name]
    return {name: np.asarray(column, dtype=float).tolist() for name, column in columns.items()}
