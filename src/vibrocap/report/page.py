"""The report of `vibrocap reproduce`: one HTML page that carries its figures, fetches nothing and works from disk."""

import dataclasses
import platform
from collections.abc import Iterable
from html import escape
from importlib.metadata import version
from pathlib import Path
from string import Template

from vibrocap.files import write_text
from vibrocap.paper.claims.claim import Verdict
from vibrocap.paper.figures.figure import Figure
from vibrocap.paper.load_finding import LoadedFigure, LoadedMotion
from vibrocap.paper.main_finding import MainFinding
from vibrocap.paper.presets import START_ANGLE, START_BRISTLE, figures_5_to_8, figures_9_to_11
from vibrocap.paper.runs import LAST, SETTLING_PERIODS, SWEEP_PERIODS, TOLERANCE
from vibrocap.paper.steady_travel import SteadyTravel
from vibrocap.physics.parameters import parameter_table
from vibrocap.report import findings
from vibrocap.report.findings import chapter, chapter_key, errata, filters
from vibrocap.report.pieces import figure, law, links, number, page_part, table, titled

PARTS = ("vibrocap", "numpy", "scipy", "llvmlite", "matplotlib")
TRAVEL_PICTURES = ("steady-travel", "branches")


@dataclasses.dataclass
class Result:
    """What a reproduction has so far."""

    only: str | None = None
    figures: dict[str, tuple[Figure, Path]] = dataclasses.field(default_factory=dict)
    verdicts: dict[str, list[Verdict]] = dataclasses.field(default_factory=dict)  # by chapter
    finding: MainFinding | None = None
    loaded: dict[str, LoadedFigure] = dataclasses.field(default_factory=dict)  # by figure
    loaded_motions: tuple[LoadedMotion, ...] = ()
    travel: tuple[SteadyTravel, list[Path]] | None = None  # with its `TRAVEL_PICTURES`
    seconds: float = 0.0
    finished: bool = False


@dataclasses.dataclass(frozen=True)
class Section:
    """A part of the page, with what the contents list below it: (anchor, title)."""

    key: str
    title: str
    inner: str
    below: tuple[tuple[str, str], ...] = ()

    @property
    def html(self) -> str:
        return f"<section>{titled(2, self.key, self.title)}{self.inner}</section>"


def write_report(result: Result, path: Path) -> Path:
    """Write the report of what has been done so far."""
    sections = [section for section in _sections(result) if section.inner]
    contents = "".join(links([(x.key, x.title)], f"<ul>{links(x.below)}</ul>" if x.below else "") for x in sections)
    page = Template(page_part("page.html")).substitute(
        style=page_part("page.css"),
        script=page_part("page.js"),
        contents=f'<ul>{contents}<li><a href="#rerun">How to run this again</a></li></ul>',
        body="".join(section.html for section in sections),
        notice="" if result.finished else '<p class="notice">This run did not finish; its results so far:</p>',
        scope="" if result.only is None else f"<p>Only {escape(result.only)} was asked for.</p>",
        claims_file="claims" + ("" if result.only is None else f"-{escape(result.only)}"),
        rerun="vibrocap reproduce" + (f" --only {escape(result.only)}" if result.only else ""),
        versions=", ".join(f"{part} {version(part)}" for part in PARTS) + f", Python {platform.python_version()}",
        seconds=f"{result.seconds:.0f}",
        tolerance=f"{TOLERANCE:g}",
    )
    return write_text(path, page)


def _sections(result: Result) -> Iterable[Section]:
    printed = {key: drawn for key, drawn in result.figures.items() if key.startswith("fig")}
    loaded = {key: drawn for key, drawn in result.figures.items() if key.startswith("load")}
    main = "" if result.finding is None else findings.main(result.finding, result.figures.get("symmetry"))
    yield Section("finding", "Main finding: why the capsule of Fig. 9 does not travel", main)
    yield Section("presets", "Parameters", _presets())
    yield Section("figures", "Figures", _figures(printed), tuple((key, f"Fig. {int(key[3:])}") for key in printed))
    chapters = tuple((chapter_key(title), title[0].upper() + title[1:]) for title in result.verdicts)
    yield Section("claims", "Claims", _claims(result, tuple(printed)), chapters)
    yield Section("errata", "Errata", errata(result.verdicts, result.only))
    yield Section(
        "load",
        "With the dynamic load",
        findings.load(loaded, result.loaded, result.loaded_motions) if loaded else "",
        tuple((key, f"Fig. {int(key[4:])}, dynamic load") for key in loaded),
    )
    travel = "" if result.travel is None else findings.travel(result.travel[0], *result.travel[1])
    yield Section("travel", "Steady travel, mapped and followed", travel)


def _figures(printed: dict[str, tuple[Figure, Path]]) -> str:
    if not printed:
        return ""
    shown = "".join(
        figure(key, f"Fig. {int(key[3:])}: {drawn.title}", path, drawn.caption)
        for key, (drawn, path) in printed.items()
    )
    words = f"{law('LM')} (LuGre) red and solid, {law('EM')} (exponential) blue and dashed"
    return f'<p class="before">{words}, in the arrangement of the paper.</p>{shown}'


def _claims(result: Result, figures: tuple[str, ...]) -> str:
    if not result.verdicts:
        return ""
    listed = [verdict for verdicts in result.verdicts.values() for verdict in verdicts]
    shown = "".join(chapter(title, verdicts, figures) for title, verdicts in result.verdicts.items())
    return (
        f'{filters(listed)}<p class="before">AS and DS: stages in which the capsule accelerates and decelerates. '
        f"“Settled” means the last of {SETTLING_PERIODS} periods for Figs 5-8 and the last of {SWEEP_PERIODS} for Figs "
        f"9-11; “steady” averages are over the last {LAST}.</p>{shown}"
    )


def _presets() -> str:
    rows = []
    first, second = figures_5_to_8(), figures_9_to_11()
    for part in ("machine", "drive"):
        for info in parameter_table(getattr(first, part)):
            path = f"{part}.{info.name}"
            cells = [escape(str(system.parameter(path))) for system in (first, second)]
            if part == "drive":
                cells[0] += " (not printed; as in Figs 9-11)"
            if info.name == "mass_ratio":
                cells[1] = "0.01 to 8.1"
            rows.append((escape(info.symbol), f"<code>{path}</code>", escape(info.meaning), *cells))
    for name in ("lugre", "exponential"):
        friction = figures_5_to_8(name).friction
        for info in parameter_table(friction):
            value, path = escape(str(getattr(friction, info.name))), f"{friction.name}.{info.name}"
            rows.append((escape(info.symbol), f"<code>{path}</code>", escape(info.meaning), value, value))
    start = f"Start: angle {number(START_ANGLE)} (pi/3), bristle {START_BRISTLE}, all else 0."
    return (
        '<p class="before">The paper prints neither h nor ω for Figs 5-8; the values printed for Figs 9-11 are used, '
        "which reproduce the motion that section 3.1 describes. All quantities are dimensionless: lengths in l, time "
        "in √(l/g), forces in m g.</p>"
        f"{table(('symbol', 'name', 'meaning', 'Figs 5-8', 'Figs 9-11'), rows, names=2)}<p>{start}</p>"
    )
