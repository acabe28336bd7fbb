"""`vibrocap plot`: a picture of a study."""

from pathlib import Path

from vibrocap.arguments import Complaints, Refusal
from vibrocap.case.case import CaseError
from vibrocap.cli.command import Answer, Drawn, command
from vibrocap.cli.options import needs, option, required, writable_picture
from vibrocap.cli.texts import pairs, split


class PlotRequest(Drawn):
    source: Path = required("the folder of a study (`vibrocap sweep --out`), or FILE.nc", place=True)
    measure: str | None = option(
        "the measure to draw, or status, settled, response_period [default: the first measure]"
    )
    out: Path | None = option(
        "FILE.png, .svg or .pdf [default: a .png beside the study, named after it and the measure]"
    )
    at: list[str] | None = option("PATH=VALUE, to fix a further axis (at the nearest value); may be repeated")
    border: list[str] | None = option("draw lines where this changes on a map, such as mode_sequence,travel")
    dead_band: float | None = option(
        "smaller velocities count as no travel [default: the residue of settled runs, or 1e-6]", advanced=True
    )


@command(
    "run",
    "vibrocap plot map --measure mean_velocity --out map.png",
    "vibrocap plot map --at drive.amplitude=1.8 --out line.pdf --width column --no-header",
)
def plot(request: PlotRequest) -> Answer:
    """A picture of a study: map, lines, panels of laws.

    A map over two axes, lines over one, panels for friction laws side by side. Failed, unsettled and missing runs are
    hatched and counted in the legend; runs without travel have a colour of their own. For --border mode_sequence the
    sweep must have had --measure mode_sequence. --border travel is where the direction of travel reverses, --border
    impacts where a mass grazes its stop.
    """
    needs("plot", "xarray", "zarr", "matplotlib")
    from vibrocap.plotting.studies.view import first_measure, study_view
    from vibrocap.studies.dataset import open_study

    complaints, source, out = Complaints(), request.source, request.out
    fixed = pairs("at", request.at, complaints, "PATH=VALUE, such as drive.frequency=1.2")
    dead_band = request.dead_band
    if dead_band is not None and not 0.0 <= dead_band < float("inf"):
        complaints.append(f"--dead-band: should be a number >= 0, got {dead_band:g}")
    with complaints.collected():
        writable_picture("--out", out)
    try:
        dataset = open_study(source)
    except CaseError as error:
        raise Refusal(*complaints, *(f"{source}: {complaint}" for complaint in error.complaints)) from None
    path = out or picture_path(source, request.measure or first_measure(dataset))
    if out is None and path.is_file() and b"Matplotlib" not in path.read_bytes()[:1000]:
        complaints.add("--out", f"{str(path)!r} is there, and was not drawn by this command; name a picture")
    with complaints.collected():
        view = study_view(dataset, request.measure, fixed, dead_band)
        writable_picture("--out", path)
        if not complaints:
            from vibrocap.plotting.studies.maps import plot_view

            plot_view(view, path, split(request.border))
    if complaints:
        raise Refusal(*dict.fromkeys(complaints))
    return Answer(text=f"Picture: {path}")


def picture_path(source: Path, measure: str) -> Path:
    """Where the picture of a study goes that is given no place: beside it."""
    place = source if source.name not in ("", "..") else source.resolve()
    word = "".join(c if c.isalnum() or c in "_.-" else "_" for c in measure)
    return place.with_name(f"{place.stem if place.is_file() else place.name}-{word}.png")
