"""The whole paper in one run: figures with their data, claims with their verdicts, errata, one report."""

import dataclasses
import json
import time
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path

from vibrocap.files import made_folder, write_table, write_text
from vibrocap.paper.claims import verdicts
from vibrocap.paper.claims.claim import Verdict
from vibrocap.paper.figures import FIGURES, KEYS, LOADED, chosen_figures
from vibrocap.paper.load_finding import loaded_figure, loaded_motions
from vibrocap.paper.runs import Runs
from vibrocap.paper.travel import main_finding, steady_travel
from vibrocap.report.figures import draw, draw_branches, draw_map, write_branches, write_map
from vibrocap.report.page import TRAVEL_PICTURES, Result, write_report
from vibrocap.studies.workers import processes

__all__ = ["KEYS", "Reproduction", "reproduce"]

Progress = Callable[[str, float], None]
COLUMNS = ("key", "where", "says", "test", "tolerance", "tolerance_origin", "outcome", "verdict", "why", "nearest")
POINTS = ("panel", "curve", "x_name", "y_name", "x", "y")  # columns of the data of a figure, a row per point
FIGURES_SHARE, CLAIMS_SHARE = 0.5, 0.85  # of the time, at the end of each, roughly


@dataclasses.dataclass(frozen=True)
class Reproduction:
    """What a run of `reproduce` made and where it lies."""

    report: Path
    claims: tuple[Verdict, ...]
    figures: tuple[Path, ...]
    seconds: float
    finished: bool


def reproduce(out: Path, only: str | None = None, progress: Progress | None = None) -> Reproduction:
    """Draw the paper's figures from our own runs, judge its claims, and write everything into a folder.

    out: made if it does not exist: report.html (it works alone, and links to the data beside it), claims.json,
        claims.csv, load.json, figures/figNN.png and .csv
    only: the key of one figure, such as "fig09", which is drawn with its claims alone; its report and claims have its
        name too (report-fig09.html, claims-fig09.json), so that those of the whole paper stay as they are
    progress: called with what is being done and the share done

    What is done is written even if the run is interrupted or fails, marked as not finished. Raises ValueError for an
    unknown figure and WriteError where the folder cannot be written, both before any work.
    """
    wanted = chosen_figures(only)
    out = Path(out)
    made_folder(made_folder(out) / "figures", own=True)
    name = "" if only is None else f"-{only}"
    if not (out / f"claims{name}.json").exists():  # a folder that takes no files is noticed before any work
        write_text(out / f"claims{name}.json", "[]\n")
    began, runs = time.perf_counter(), Runs()
    tell = progress or (lambda what, share: None)
    result = Result(only=only)
    drawn: dict[str, Future[Path]] = {}
    try:
        with processes(1) as second:  # which draws, and follows branches, as the first goes on
            travel = second.submit(steady_travel) if only is None else None
            for i, key in enumerate(wanted):
                tell(f"figure {key}", FIGURES_SHARE * i / len(wanted))
                figure = FIGURES[key](runs)
                write_table(out / "figures" / f"{key}.csv", POINTS, figure.rows)
                result.figures[key] = (figure, out / "figures" / f"{key}.png")
                drawn[key] = second.submit(draw, *result.figures[key])
                if key in LOADED:
                    result.loaded[key] = loaded_figure(runs, key)
            if only in (None, "fig09"):
                tell("the half-period symmetry", FIGURES_SHARE)
                result.finding = main_finding(runs)
            for chapter, verdict in verdicts(
                runs, only, lambda what, share: tell(what, FIGURES_SHARE + (CLAIMS_SHARE - FIGURES_SHARE) * share)
            ):
                result.verdicts.setdefault(chapter, []).append(verdict)
            if travel is not None:
                tell("steady travel", CLAIMS_SHARE)
                result.loaded_motions = loaded_motions(runs)
                places = [out / "figures" / f"{name}.png" for name in TRAVEL_PICTURES]
                for place, drawing, writing in zip(
                    places, (draw_map, draw_branches), (write_map, write_branches), strict=True
                ):
                    writing(travel.result(), place.with_suffix(".csv"))
                    drawing(travel.result(), place)
                result.travel = travel.result(), places
            for picture in drawn.values():
                picture.result()
            result.finished = True
    finally:
        for key, picture in drawn.items():
            if not picture.done() or picture.cancelled() or picture.exception():  # an interrupt came before it
                draw(*result.figures[key])
        result.seconds = time.perf_counter() - began
        claims = tuple(verdict for chapter in result.verdicts.values() for verdict in chapter)
        write_claims(claims, out / f"claims{name}.json")
        if result.loaded:
            loaded = {key: dataclasses.asdict(run) for key, run in result.loaded.items()}
            write_text(out / f"load{name}.json", json.dumps(loaded, indent=2, ensure_ascii=False) + "\n")
        report = write_report(result, out / f"report{name}.html")
    tell("report", 1.0)
    pictures = [path for _, path in result.figures.values()]
    pictures += [] if result.travel is None else result.travel[1]
    return Reproduction(report, claims, tuple(pictures), result.seconds, True)


def write_claims(claims: tuple[Verdict, ...], path: Path) -> None:
    """The verdicts as JSON, and beside it as a table."""
    rows, table = [verdict.row for verdict in claims], []
    write_text(path, json.dumps(rows, indent=2, ensure_ascii=False) + "\n")
    for row in rows:
        numbers = "; ".join(f"{name} = {value!r}" for name, value in row["found"].items())
        table.append((*(row[name] for name in COLUMNS), " ".join(row["figures"]), numbers))
    write_table(path.with_suffix(".csv"), (*COLUMNS, "figures", "found"), table)
