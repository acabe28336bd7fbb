"""What a fit leaves of its records, as a CSV file."""

import csv
from pathlib import Path
from typing import TYPE_CHECKING

from vibrocap.files import replacing

if TYPE_CHECKING:
    from vibrocap.identification.result.fit_result import Fit


def write_residuals(found: "Fit", path: Path) -> Path:
    """Every sample of every record as a line of CSV: motion, force and what the fit makes of it, in SI units."""
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        unit, speed = found.units.heading, found.units.velocity.replace("/", "_per_")
        forces = (f"measured_{unit}", f"fitted_{unit}", f"error_{unit}")
        table.writerow(("record", "held_out", "time_s", f"velocity_{speed}", *forces))
        for each in found.records:
            columns = (each.time, each.velocity, each.measured, each.predicted, each.predicted - each.measured)
            for row in zip(*columns, strict=True):
                table.writerow((each.name, int(each.held_out), *(f"{value:.9g}" for value in row)))
    return path
