"""The command `vibrocap plot`: a study as a picture."""

from pathlib import Path

from vibrocap.case import CaseError
from vibrocap.cli.exits import OK
from vibrocap.cli.terminal import PICTURES, Page, Refusal, needs, writable_file


def plot(
    source: Path,
    /,
    *,
    measure: str | None = None,
    out: Path | None = None,
    at: list[str] | None = None,
    border: str | None = None,
    dead_band: float | None = None,
) -> int:
    """A picture of a study: a map over two axes, lines over one, panels for friction laws side by side.

    Failed, unsettled and missing runs are hatched and counted in the legend; no travel has a colour of its own.

    Example: vibrocap plot map --measure mean_velocity --border word --out map.png

    Parameters
    ----------
    source
        the folder of a study (`vibrocap sweep --out`), or FILE.nc with an exported one
    measure
        which of its measures, or status, settled, response_period [default: the first measure]
    out
        FILE.png, .svg or .pdf [default: a .png beside the study, named after it and the measure]
    at
        where further axes are fixed: PATH=VALUE, once for each; the nearest value is taken
    border
        draw the lines where this changes over a map, such as word or response_period
    dead_band
        travel up to this size is none [default: 10 times the threshold to which the runs settled, or 1e-6]
    """
    needs("plot", "sweep", "xarray", "zarr")
    needs("plot", "plot", "matplotlib")
    from vibrocap.plotting.study_view import ViewError, first_measure, study_view

    complaints = []
    fixed: dict[str, str] = {}
    for text in at or ():
        path, equals, value = (piece.strip() for piece in text.partition("="))
        if not (path and equals and value):
            complaints.append(f"--at {text}: should be PATH=VALUE, such as drive.frequency=1.2")
        elif path in fixed:
            complaints.append(f"--at {path}: is given twice")
        fixed[path] = value
    if dead_band is not None and not 0.0 <= dead_band < float("inf"):
        complaints.append(f"--dead-band: should be a number >= 0, got {dead_band:g}")
    try:
        if out is not None:
            writable_file("--out", out, PICTURES)
    except Refusal as refusal:
        complaints.append(str(refusal))
    from vibrocap.studies.dataset import open_study

    try:
        dataset = open_study(source)
    except CaseError as error:
        complaints += [f"{source}: {complaint}" for complaint in error.complaints]
        raise Refusal("\n".join(complaints)) from None
    path = out or picture_path(source, measure or first_measure(dataset))
    try:
        view = study_view(dataset, measure, fixed, dead_band)
        writable_file("--out", path, PICTURES)
        if not complaints:
            from vibrocap.plotting.maps import plot_view

            path.parent.mkdir(parents=True, exist_ok=True)
            plot_view(view, path, border)
    except (ViewError, Refusal) as error:
        complaints += [text for text in str(error).splitlines() if text not in complaints]
    if complaints:
        raise Refusal("\n".join(complaints))
    Page().print(f"Picture: {path}", soft_wrap=True)
    return OK


def picture_path(source: Path, measure: str) -> Path:
    """Where the picture of a study goes that is given no place: beside it."""
    place = source if source.name not in ("", "..") else source.resolve()
    return place.with_name(f"{place.stem if place.is_file() else place.name}-{measure}.png")
