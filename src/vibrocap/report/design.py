"""The page of a design: what was asked, what was found, its motion, what limits it, and how to run it again."""

from html import escape
from pathlib import Path

import numpy as np

from vibrocap.design.front import ParetoFront
from vibrocap.design.optimise import Optimum
from vibrocap.physics.dimensions.conversion import quantity
from vibrocap.plotting.animation import animate_motion
from vibrocap.plotting.fronts import draw_front, search_figure
from vibrocap.plotting.motion import motion_figure
from vibrocap.quantities.dimensional import computed, in_si
from vibrocap.report.pieces import facts, listed, number, picture, table, write_page

FILMED = 2  # drive periods of the film
SHOWN = 3  # and more, of the motion on its orbit


def write_design_page(found: Optimum, folder: Path, command: str) -> Path:
    """Write `report.html` into the folder of a search that found a design, with its pictures beside it.

    command: how to run the search again
    """
    assert found.orbit is not None
    assert found.value is not None
    motion = computed(found.case(max(SHOWN, FILMED) * found.orbit.response_period).simulate())
    motion_figure(motion).savefig(folder / "motion.png")
    search_figure(found).savefig(folder / "search.png")
    shown = picture(folder / "motion.png", "the motion on its orbit")
    animate_motion(motion, folder / "film.gif", FILMED * found.orbit.response_period)
    shown += f'<p><img alt="film of {FILMED} responses" src="film.gif" width="960"></p>'
    parts = [
        ("The design", _design(found)),
        ("Its steady motion", facts(in_si(found.orbit).facts) + shown),
        ("What limits it", _limits(found)),
        ("What starts lead to", _motions(found)),
        ("The search", facts({k: v for k, v in found.facts.items() if k in ("designs", "under uncertainty")})
         + listed("Better candidates that do not win", found.rejected)
         + picture(folder / "search.png", "the best design over the evaluations")),
        ("The case", f"<pre>{escape((folder / 'best.toml').read_text(encoding='utf-8'))}</pre>"),
    ]  # fmt: skip
    value = f"{found.measure.replace('_', ' ')} {found.value:.8g}{_unit(found.unit)}"
    return write_page(folder, f"The best design: {value}", parts, [command, "vibrocap simulate best.toml"])


def write_front_page(found: ParetoFront, folder: Path, command: str) -> Path:
    """Write `report.html` into the folder of a Pareto front that has designs: its picture and its table."""
    ax = draw_front(found)
    ax.figure.savefig(folder / "front.png")  # type: ignore[union-attr]
    rows = found.table()
    cells = [[str(i), *map(_cell, row.values())] for i, row in enumerate(rows)]
    parts = [
        ("The front", picture(folder / "front.png", "the Pareto front") + facts(found.facts)),
        ("Its designs", table(["", *map(escape, rows[0])], cells)),
    ]
    heading = f"Pareto front of {found.measures[0].replace('_', ' ')} and {found.measures[1].replace('_', ' ')}"
    return write_page(folder, heading, parts, [command, "vibrocap simulate cases/000.toml"])


def _cell(value: float | str) -> str:
    return escape(value) if isinstance(value, str) else number(value)


def _unit(unit: str) -> str:
    return "" if unit in ("", "1") else f" {unit}"


def _design(found: Optimum) -> str:
    """The variables, with the slopes of the measure and its elasticities."""
    assert found.design is not None
    assert found.value is not None
    assert found.orbit is not None
    rows = []
    for path, value in found.design.items():
        low, high = found.slopes.get(path, (None, None))
        slope = low if high is None else high if low is None else 0.5 * (low + high)
        elasticity = ""
        if slope is not None and not isinstance(value, str) and found.value != 0.0:
            elasticity = number(float(slope * value / found.value))
        unit = quantity(path, found.orbit.system).unit
        shown = _cell(value) + ("" if isinstance(value, str) else _unit(unit))
        rows.append([escape(path), shown, *("" if x is None else number(x) for x in (low, high)), elasticity])
    head = ["variable", "value", "slope of the measure below", "above", "elasticity"]
    constraints = [[escape(words), number(value)] for words, value in found.constraints.items()]
    return table(head, rows) + (table(["constraint", "value"], constraints) if constraints else "")


def _limits(found: Optimum) -> str:
    assert found.orbit is not None
    given = in_si(found, found.orbit.system).starts
    starts = [", ".join(f"{k} {v:g}" for k, v in given[i].items()) or "rest" for i in found.reached_from]
    reached = f"reached from {'; '.join(starts)}" if starts else "reached from none of the starts within the periods"
    multipliers = [[number(float(part(m))) for part in (np.real, np.imag, np.abs)] for m in found.orbit.multipliers]
    return (
        listed("It is limited by", found.limits)
        + f"<p>The motion is {escape(reached)}.</p>"
        + table(["real part", "imaginary part", "size of the multiplier"], multipliers, names=0)
    )


def _motions(found: Optimum) -> str:
    """What starts spread over the states lead to at the design."""
    if found.attractors is None:
        return ""
    shown = in_si(found.attractors)
    rows = []
    for k, row in enumerate(shown.table()):
        twin = found.attractor is not None and row["twin"] == found.attractor
        whose = "the design's" if k == found.attractor else "its mirror twin" if twin else ""
        drift, multiplier = row["drift"], row["largest_multiplier"]
        cells = [number(100.0 * row["share"]), *("" if x is None else number(x) for x in (drift, multiplier)), whose]
        rows.append([escape(row["kind"]), *cells])
    drift = shown.attractors[0].unit_of("drift") if shown.attractors else "1"
    unit = "" if drift == "1" else f" [{escape(drift)}]"
    head = ["motion", "of the starts [%]", f"drift per drive period{unit}", "largest multiplier", ""]
    return f"<p>{escape(found.reached[0].upper() + found.reached[1:])}.</p>" + table(head, rows)
