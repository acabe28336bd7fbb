"""The page of a fit: what the records determine, what they do not, its curves and errors, and how to run it again."""

from collections.abc import Sequence
from html import escape
from pathlib import Path

from vibrocap.design.calibration.motion_fit import MotionFit
from vibrocap.identification.experiments.comparison import Comparison
from vibrocap.identification.result.fit_result import Chapter, Fit
from vibrocap.plotting.fits import comparison_figure, fit_figure, residual_figure
from vibrocap.plotting.look.finishing import save
from vibrocap.plotting.motion_fits import motion_fit_figure
from vibrocap.report.pieces import data_link, facts, listed, number, picture, table, write_page


def write_fit_page(found: Fit, folder: Path, command: str, more: Sequence[Chapter] = ()) -> list[Path]:
    """Write `report.html` and its pictures into the folder of a law's fit; the files.

    command: how to run the fit again; more: what was asked beside it, such as a bootstrap
    """
    drawn = [save(fit_figure(found), folder / "fit.png"), save(residual_figure(found), folder / "residuals.png")]
    parts = [
        ("The fit", facts(found.facts) + picture(drawn[0], "measured and fitted force, and intervals")),
        ("What was found", "".join(map(_chapter, (*found.chapters, *more)))),
        ("What the errors look like", picture(drawn[1], "residuals over time, position and velocity")),
        ("The law in a case", _text(folder / "friction.toml")),
    ]
    return [*drawn, write_page(folder, found.heading, parts, [command])]


def write_comparison_page(found: Comparison, folder: Path, command: str) -> list[Path]:
    """Write `report.html` and its picture into the folder of several laws' fits; each law has a page of its own."""
    drawn = save(comparison_figure(found), folder / "comparison.png")
    rows = [
        (
            data_link(f"{law.law}/report.html") if law.fit.ok else escape(law.law),
            *(number(100 * share) for share in (law.held_out, law.relative_rmse)),
            *(number(value) for value in (law.parameters, law.aic, law.bic)),
        )
        for law in found.laws
    ]
    head = ("law", "error held out [%]", "error fitted [%]", "parameters", "AIC", "BIC")
    ranked = table(head, rows) + f"<p>Held out: {escape(found.method)}.</p>"
    return [
        drawn,
        write_page(folder, "Friction laws compared", [("Ranked", ranked + picture(drawn, "the laws"))], [command]),
    ]


def write_motion_page(found: MotionFit, folder: Path, command: str) -> list[Path]:
    """Write `report.html` and its picture into the folder of a case fitted to records of its motion."""
    drawn = save(motion_fit_figure(found), folder / "predicted.png")
    parts = [
        ("The fit", facts(found.facts)),
        ("The motion, measured and predicted", picture(drawn, "measured and predicted motion with its band")),
        ("The fitted case", _text(folder / "fitted.toml")),
    ]
    return [drawn, write_page(folder, found.heading, parts, [command, "vibrocap simulate fitted.toml"])]


def _chapter(chapter: Chapter) -> str:
    if chapter.rows:
        return table((escape(chapter.title), *chapter.head), (map(escape, row) for row in chapter.rows))
    return listed(chapter.title, chapter.sentences)


def _text(path: Path) -> str:
    return f"<pre>{escape(path.read_text(encoding='utf-8'))}</pre>"
