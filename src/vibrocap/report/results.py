"""Pages of results: of a design or a front of designs, and of a fit; each says how to run it again."""

from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from vibrocap.design.calibration.motion_fit import MotionFit
from vibrocap.design.front import ParetoFront
from vibrocap.design.optimise import Optimum
from vibrocap.identification.experiments.comparison import Comparison
from vibrocap.identification.fit_result import Chapter, Fit
from vibrocap.physics.dimensions.conversion import quantity
from vibrocap.plotting.animation import animate_motion
from vibrocap.plotting.designs import draw_front, motion_fit_figure, search_figure
from vibrocap.plotting.fits import comparison_figure, fit_figure, residual_figure
from vibrocap.plotting.look.finishing import save
from vibrocap.plotting.motion import motion_figure
from vibrocap.quantities.dimensional import computed, in_si
from vibrocap.report.pieces import data_link, facts, listed, number, picture, table, write_page

FILMED = 2  # drive periods of the film
SHOWN = 3  # and more, of the motion on its orbit


def write_design_page(optimum: Optimum, folder: Path, command: str) -> Path:
    """Write `report.html` into the folder of a search that found a design, with its pictures beside it.

    command: how to run the search again
    """
    assert optimum.orbit is not None
    assert optimum.value is not None
    motion = computed(optimum.case(max(SHOWN, FILMED) * optimum.orbit.response_period).simulate())
    motion_figure(motion).savefig(folder / "motion.png")
    search_figure(optimum).savefig(folder / "search.png")
    shown = picture(folder / "motion.png", "the motion on its orbit")
    animate_motion(motion, folder / "film.gif", FILMED * optimum.orbit.response_period)
    shown += f'<p><img alt="film of {FILMED} responses" src="film.gif" width="960"></p>'
    parts = [
        ("The design", _design(optimum)),
        ("Its steady motion", facts(in_si(optimum.orbit).facts) + shown),
        ("What limits it", _limits(optimum)),
        ("What starts lead to", _motions(optimum)),
        ("The search", facts({k: v for k, v in optimum.facts.items() if k in ("designs", "under uncertainty")})
         + listed("Better candidates that do not win", optimum.rejected)
         + picture(folder / "search.png", "the best design over the evaluations")),
        ("The case", f"<pre>{escape((folder / 'best.toml').read_text(encoding='utf-8'))}</pre>"),
    ]  # fmt: skip
    value = f"{optimum.measure.replace('_', ' ')} {optimum.value:.8g}{_unit(optimum.unit)}"
    return write_page(folder, f"The best design: {value}", parts, [command, "vibrocap simulate best.toml"])


def write_front_page(front: ParetoFront, folder: Path, command: str) -> Path:
    """Write `report.html` into the folder of a Pareto front that has designs: its picture and its table."""
    ax = draw_front(front)
    ax.figure.savefig(folder / "front.png")  # type: ignore[union-attr]
    rows = front.table()
    cells = [[str(i), *map(_cell, row.values())] for i, row in enumerate(rows)]
    parts = [
        ("The front", picture(folder / "front.png", "the Pareto front") + facts(front.facts)),
        ("Its designs", table(["", *map(escape, rows[0])], cells)),
    ]
    heading = f"Pareto front of {front.measures[0].replace('_', ' ')} and {front.measures[1].replace('_', ' ')}"
    return write_page(folder, heading, parts, [command, "vibrocap simulate cases/000.toml"])


def _cell(value: float | str) -> str:
    return escape(value) if isinstance(value, str) else number(value)


def _unit(unit: str) -> str:
    return "" if unit in ("", "1") else f" {unit}"


def _design(optimum: Optimum) -> str:
    """The variables, with the slopes of the measure and its elasticities."""
    assert optimum.design is not None
    assert optimum.value is not None
    assert optimum.orbit is not None
    rows = []
    for path, value in optimum.design.items():
        low, high = optimum.slopes.get(path, (None, None))
        slope = low if high is None else high if low is None else 0.5 * (low + high)
        elasticity = ""
        if slope is not None and not isinstance(value, str) and optimum.value != 0.0:
            elasticity = number(float(slope * value / optimum.value))
        unit = quantity(path, optimum.orbit.system).unit
        shown = _cell(value) + ("" if isinstance(value, str) else _unit(unit))
        rows.append([escape(path), shown, *("" if x is None else number(x) for x in (low, high)), elasticity])
    head = ["variable", "value", "slope of the measure below", "above", "elasticity"]
    constraints = [[escape(words), number(value)] for words, value in optimum.constraints.items()]
    return table(head, rows) + (table(["constraint", "value"], constraints) if constraints else "")


def _limits(optimum: Optimum) -> str:
    assert optimum.orbit is not None
    optimal = in_si(optimum, optimum.orbit.system).starts
    starts = [", ".join(f"{k} {v:g}" for k, v in optimal[i].items()) or "rest" for i in optimum.reached_from]
    reached = f"reached from {'; '.join(starts)}" if starts else "reached from none of the starts within the periods"
    multipliers = [[number(float(part(m))) for part in (np.real, np.imag, np.abs)] for m in optimum.orbit.multipliers]
    return (
        listed("It is limited by", optimum.limits)
        + f"<p>The motion is {escape(reached)}.</p>"
        + table(["real part", "imaginary part", "size of the multiplier"], multipliers, names=0)
    )


def _motions(optimum: Optimum) -> str:
    """What starts spread over the states lead to at the design."""
    if optimum.attractors is None:
        return ""
    shown = in_si(optimum.attractors)
    rows = []
    for k, row in enumerate(shown.table()):
        twin = optimum.attractor is not None and row["twin"] == optimum.attractor
        whose = "the design's" if k == optimum.attractor else "its mirror-image solution" if twin else ""
        drift, multiplier = row["drift"], row["largest_multiplier"]
        cells = [number(100.0 * row["share"]), *("" if x is None else number(x) for x in (drift, multiplier)), whose]
        rows.append([escape(row["kind"]), *cells])
    drift = shown.attractors[0].unit_of("drift") if shown.attractors else "1"
    unit = "" if drift == "1" else f" [{escape(drift)}]"
    head = ["motion", "of the starts [%]", f"drift per drive period{unit}", "largest multiplier", ""]
    return f"<p>{escape(optimum.reached[0].upper() + optimum.reached[1:])}.</p>" + table(head, rows)


def write_fit_page(fit: Fit, folder: Path, command: str, more: Sequence[Chapter] = ()) -> list[Path]:
    """Write `report.html` and its pictures into the folder of a law's fit; the files.

    command: how to run the fit again; more: what was asked beside it, such as a bootstrap
    """
    drawn = [save(fit_figure(fit), folder / "fit.png"), save(residual_figure(fit), folder / "residuals.png")]
    parts = [
        ("The fit", facts(fit.facts) + picture(drawn[0], "measured and fitted force, and intervals")),
        ("What was found", "".join(map(_chapter, (*fit.chapters, *more)))),
        ("What the errors look like", picture(drawn[1], "residuals over time, position and velocity")),
        ("The law in a case", _text(folder / "friction.toml")),
    ]
    return [*drawn, write_page(folder, fit.heading, parts, [command])]


def write_comparison_page(comparison: Comparison, folder: Path, command: str) -> list[Path]:
    """Write `report.html` and its picture into the folder of several laws' fits; each law has a page of its own."""
    drawn = save(comparison_figure(comparison), folder / "comparison.png")
    rows = [
        (
            data_link(f"{law.law}/report.html") if law.fit.ok else escape(law.law),
            *(number(100 * share) for share in (law.held_out, law.relative_rmse)),
            *(number(value) for value in (law.parameters, law.aic, law.bic)),
        )
        for law in comparison.laws
    ]
    head = ("law", "error held out [%]", "error fitted [%]", "parameters", "AIC", "BIC")
    ranked = table(head, rows) + f"<p>Held out: {escape(comparison.method)}.</p>"
    return [
        drawn,
        write_page(folder, "Friction laws compared", [("Ranked", ranked + picture(drawn, "the laws"))], [command]),
    ]


def write_motion_page(fit: MotionFit, folder: Path, command: str) -> list[Path]:
    """Write `report.html` and its picture into the folder of a case fitted to records of its motion."""
    drawn = save(motion_fit_figure(fit), folder / "predicted.png")
    parts = [
        ("The fit", facts(fit.facts)),
        ("The motion, measured and predicted", picture(drawn, "measured and predicted motion with its band")),
        ("The fitted case", _text(folder / "fitted.toml")),
    ]
    return [drawn, write_page(folder, fit.heading, parts, [command, "vibrocap simulate fitted.toml"])]


def _chapter(chapter: Chapter) -> str:
    if chapter.rows:
        return table((escape(chapter.title), *chapter.head), (map(escape, row) for row in chapter.rows))
    return listed(chapter.title, chapter.sentences)


def _text(path: Path) -> str:
    return f"<pre>{escape(path.read_text(encoding='utf-8'))}</pre>"
