"""`vibrocap calibrate`: parameters of a case from a measured table of settled motions."""

import dataclasses
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vibrocap.cli import completers
from vibrocap.cli.command import Answer, OfCase, Report, command
from vibrocap.cli.options import Json, Option, Seed, folder
from vibrocap.cli.terminal import Page
from vibrocap.cli.texts import checked_pairs
from vibrocap.files import made_folder, write_table, write_text
from vibrocap.io.json_text import json_text


@dataclasses.dataclass(frozen=True, kw_only=True)
class CalibrateRequest(OfCase):
    """The options of `vibrocap calibrate`."""

    to: Annotated[Path, Option("the table, a CSV file with a line of headings", sets=("table",))]
    over: Annotated[
        list[str],
        Option(
            "PATH=LEAST:LARGEST, an unknown parameter and its bounds; PATH,PATH=factor:LEAST:LARGEST for one factor of "
            "the values of the case; may be repeated",
            offers=completers.paths_of_case,
        ),
    ]
    held_out: Annotated[list[int] | None, Option("rows, from 1, that judge the fit and are not fitted")] = None
    out: Annotated[
        Path | None,
        folder(
            "a folder for calibration.json, residuals.csv and calibrated.toml, the calibrated case",
            *("calibration.json", "residuals.csv", "calibrated.toml"),
        ),
    ] = None
    json: Json = False
    starts: Annotated[int, Option("points from which the search begins", advanced=True)] = 256
    seed: Seed = 0
    periods: Annotated[int, Option("drive periods in which the run of a row has to settle", advanced=True)] = 300


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
    [mm/s]), mean_velocity_error a standard error. Parameters of machine, friction and drive are printed with joint 95 %
    intervals. Parameters that the table does not determine are marked; a column that does not fit is named, as are rows
    that do not settle.
    """
    from vibrocap.design.calibration.calibration import calibrate as calibrated

    ranges: dict[str, Any] = checked_pairs("over", request.over, "PATH=LEAST:LARGEST, such as machine.damping=0.5:3")
    found = calibrated(
        request.setup,
        request.to,
        ranges,
        held_out=[row - 1 for row in request.held_out or ()],
        starts=request.starts,
        seed=request.seed,
        periods=request.periods,
        progress=report,
    )
    record = calibration_record(found)
    written: tuple[tuple[str, Any], ...] = ()
    if request.out is not None:
        folder = made_folder(request.out)
        write_text(folder / "calibration.json", json_text(record) + "\n")
        columns = _residuals(found)
        write_table(folder / "residuals.csv", columns, zip(*columns.values(), strict=True))
        found.case().save(folder / "calibrated.toml")
        written = (("case", request.out / "calibrated.toml"),)

    def text(page: Page) -> None:
        page.say(f"Calibration of {request.case} on {found.table.rows} rows of {request.to}", style="bold")
        page.rows(list(found.facts.items()), 2 + max(map(len, found.facts)))
        page.rows([("not determined", str(each)) for each in found.directions if not each.determined], 16)

    return Answer(record, text, written=written)


def calibration_record(found: Any) -> dict[str, Any]:
    """What is known of a calibration, by name."""
    names = ("path", "value", "low", "high", "standard_error")
    parameters = [
        {name: getattr(each, name) for name in names} | {"verdict": each.verdict.value} for each in found.parameters
    ]
    doubt = found.doubt and {
        name: getattr(found.doubt, name) for name in ("column", "kind", "size", "probability", "gain")
    }
    return {
        "parameters": parameters,
        "correlation": found.correlation.tolist(),
        "directions": [{"exponents": dict(each.exponents), "deviation": each.deviation} for each in found.directions],
        "misfit": found.misfit,
        "rms": found.rms,
        "held_out_misfit": found.held_out_misfit,
        "doubt": doubt,
        "rows_not_trusted": {why: [row + 1 for row in rows] for why, rows in found.not_trusted.items()},
    }


def _residuals(found: Any) -> dict[str, list[float]]:
    """Columns by name with the conditions, and of each measure what was read, what is predicted and the residual."""
    columns = dict(found.table.conditions)
    for name in found.table.measures:
        columns[name] = found.table.targets[name]
        columns[f"{name}_predicted"] = found.predicted[name]
        columns[f"{name}_residual"] = found.residuals[name]
    return {name: np.asarray(column, dtype=float).tolist() for name, column in columns.items()}
