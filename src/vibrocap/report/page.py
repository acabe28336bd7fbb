"""The report of `vibrocap reproduce`: one HTML page that carries its figures, fetches nothing and works from disk."""

import dataclasses
import platform
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.metadata import version
from pathlib import Path
from string import Template

from vibrocap.files import write_text
from vibrocap.motion.status import Status
from vibrocap.paper.claims.claim import Outcome, Verdict
from vibrocap.paper.errata import ERRATA, Erratum
from vibrocap.paper.figures.figure import Figure
from vibrocap.paper.load_finding import LoadedFigure, LoadedMotion
from vibrocap.paper.presets import START_ANGLE, START_BRISTLE, figures_5_to_8, figures_9_to_11
from vibrocap.paper.runs import LAST, SETTLING_PERIODS, SHOWN_PERIODS, SWEEP_PERIODS, TOLERANCE
from vibrocap.paper.travel import FOLLOWED, POINTS, MainFinding, SteadyTravel
from vibrocap.physics.parameters import parameter_table
from vibrocap.report.pieces import figure, law, links, number, numbers, page_part, table, titled

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
    main = "" if result.finding is None else _main_finding(result.finding, result.figures.get("symmetry"))
    yield Section("finding", "Main finding: why the capsule of Fig. 9 does not travel", main)
    yield Section("presets", "Parameters", _presets())
    yield Section("figures", "Figures", _figures(printed), tuple((key, f"Fig. {int(key[3:])}") for key in printed))
    chapters = tuple((chapter_key(title), title[0].upper() + title[1:]) for title in result.verdicts)
    yield Section("claims", "Claims", _claims(result, tuple(printed)), chapters)
    yield Section("errata", "Errata", errata(result.verdicts, result.only))
    yield Section(
        "load",
        "With the dynamic load",
        _under_the_load(loaded, result.loaded, result.loaded_motions) if loaded else "",
        tuple((key, f"Fig. {int(key[4:])}, dynamic load") for key in loaded),
    )
    travel = "" if result.travel is None else _steady_travel(result.travel[0], *result.travel[1])
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


BADGES = {Outcome.HOLDS: "holds", Outcome.ONLY_FOR: "only", Outcome.FAILS: "fails", Outcome.UNDECIDED: "open"}


def filters(verdicts: Sequence[Verdict]) -> str:
    """Buttons that show the claims of one verdict alone, with how many there are."""
    counts = Counter(verdict.finding.outcome for verdict in verdicts)
    buttons = [("all", "total", f"all {len(verdicts)}", "true")]
    for outcome, badge in BADGES.items():
        words = f"{counts[outcome]} {outcome.value}{' …' * (outcome is Outcome.ONLY_FOR)}"
        buttons += [(badge, badge, words, "false")] if counts[outcome] else []
    cells = "".join(
        f'<button type="button" class="badge {badge}" data-show="{name}" aria-pressed="{pressed}">{words}</button>'
        for name, badge, words, pressed in buttons
    )
    return f'<div class="filters" role="group" aria-label="claims to show">{cells}</div>'


def chapter_key(title: str) -> str:
    """The anchor of a chapter of claims."""
    return "claims-" + "-".join("".join(c if c.isalnum() else " " for c in title.lower()).split())


def chapter(title: str, verdicts: Sequence[Verdict], figures: Sequence[str]) -> str:
    """A chapter of claims. figures: keys of those on the page, which are linked."""
    claims = "".join(_claim(verdict, figures) for verdict in verdicts)
    heading = titled(3, chapter_key(title), title[0].upper() + title[1:])
    return f'<section class="chapter">{heading}{claims}</section>'


def _claim(verdict: Verdict, figures: Sequence[str]) -> str:
    claim, finding = verdict.claim, verdict.finding
    badge = BADGES[finding.outcome]
    links = [f'<a class="self" href="#{claim.key}"><code>{claim.key}</code></a>']
    links += [f'<a href="#{key}">Fig. {int(key[3:])}</a>' for key in claim.figures if key in figures]
    mine = [erratum.number for erratum in ERRATA if claim.key in erratum.claims]
    links += [f'<a href="#erratum-{number}">erratum {number}</a>' for number in mine]
    nearest = f'<p class="nearest"><b>Nearest true:</b> {escape(finding.nearest)}</p>' if finding.nearest else ""
    return (
        f'<article class="claim" id="{claim.key}" data-outcome="{badge}">'
        f'<div><p class="where">{escape(claim.where)}</p><p>{escape(claim.says)}</p>'
        f'<p class="small links">{" ".join(links)}</p></div>'
        f'<div><p class="badge {badge}">{escape(verdict.verdict)}</p><p>{escape(finding.why)}</p>{nearest}</div>'
        f'<div class="small"><p>{escape(claim.test)}</p>{numbers(finding.found)}'
        f"<p>Tolerance {number(claim.tolerance.value)}: {escape(claim.tolerance.origin)}.</p></div></article>"
    )


def errata(verdicts: Mapping[str, Sequence[Verdict]], only: str | None) -> str:
    """The errata; of a part of the paper those that its claims show."""
    keys = {verdict.claim.key for chapter in verdicts.values() for verdict in chapter}
    return "".join(_erratum(erratum, keys) for erratum in ERRATA if only is None or keys & set(erratum.claims))


def _erratum(erratum: Erratum, keys: set[str]) -> str:
    links = ", ".join(f'<a href="#{key}">{key}</a>' if key in keys else f"<span>{key}</span>" for key in erratum.claims)
    return (
        f'<section class="erratum">{titled(3, f"erratum-{erratum.number}", f"{erratum.number}. {erratum.title}")}'
        f'<p class="where">{escape(erratum.where)}</p>'
        f"<p><b>Printed.</b> {escape(erratum.printed)}</p><p><b>Right.</b> {escape(erratum.right)}</p>"
        f"<p class='small'>Claims: {links}.</p></section>"
    )


Drawn = tuple[Figure, Path]
NAMES = ("O1", "O2", "P1", "P2")


def _main_finding(finding: MainFinding, symmetry: Drawn | None) -> str:
    """Why the capsule of Fig. 9 does not travel."""
    head = ("settled motion", "largest |X'(τ) + X'(τ + T/2)|", "drift per period", "drift of the mirror-image solution")
    values = (dataclasses.astuple(asymmetry) for asymmetry in finding.asymmetries)
    asymmetries = table(head, ((escape(case), *map(number, own)) for case, *own in values))
    rows = ((escape(window), *(number(places[name]) for name in NAMES)) for window, places in finding.points.items())
    points = table(("average over", *NAMES), rows)
    springs = [("printed (ρ = 4)", *map(number, finding.points["printed"].values()))]
    for friction in (finding.stiff, *finding.soft):
        springs.append(
            (f"ρ = {friction.stiffness:g}", *(_place(friction.at[name], friction.error[name]) for name in NAMES))
        )
    soft = table(("steady state at", *NAMES), springs)
    shown = "" if symmetry is None else figure("symmetry", symmetry[0].title, symmetry[1], symmetry[0].caption)
    ranges = [limits for equal in finding.stiff.equal.values() for limits in equal]
    nothing = f"from λ = {number(max(low for low, _ in ranges))} to {number(min(high for _, high in ranges))}"
    steady = " and ".join(f"{number(value)} ({law(short)})" for short, value in finding.steady.items())
    return f"""
<p>The drive is odd under half a period, h cos(ω(τ + T/2)) = −h cos(ωτ), and the machine and both friction laws are odd,
too. So the mirror image of any motion, −(θ, θ′, X, X′, ξ)(τ + T/2), is a motion as well. What follows:</p>
<ul>
<li><b>A symmetric orbit cannot travel.</b> What it gains in one half of the period it loses in the other.</li>
<li><b>At the parameters of Fig. 9 every settled motion found is symmetric</b>: the steady average velocity is zero at
every mass ratio, with both laws: the largest found is {steady}, which is the error of the runs. So it is
from {finding.starts} random starts as well: {number(finding.from_random_starts)} at most.</li>
<li><b>What Fig. 9 can show is a transient.</b> The capsule is shifted once, while the motion settles; over a
longer window the average gets smaller, and its zeros and crossings are properties of the window.</li>
<li><b>Every travelling motion has a mirror-image solution</b> that travels the other way. The motion of Figs 5-8
travels because it has lost the symmetry by itself; which of the twins appears is decided by the start.</li>
</ul>
{shown}
<h3>How far settled motions are from their mirror image</h3>{asymmetries}
<h3>Where the printed points of Fig. 9 are, by averaging window (ρ = 4)</h3>
<p>The zeros of the curves (O1 for LM, O2 for EM) and their crossings (P1, P2, in order).</p>{points}
<h3>In the steady state, as printed and with softer springs</h3>
<p>Where the drift of settled motions vanishes (O1, O2) or is the same with both laws (P1, P2), bracketed and located
to rounding, with its error (<code>vibrocap crossing</code>). At the printed ρ = 4 there is no such point: the drift of
either law is nothing at every mass ratio, {nothing}. With ρ of 0.5 to 0.65, not the paper's, the upright
pendulum buckles and the symmetry is lost; from about 0.55 to 0.62 steady averages have the printed shape, but no one ρ
gives the four printed points.</p>{soft}
"""


def _place(at: float, error: float) -> str:
    """A place, with its error in the title; "none" where there is none."""
    if at != at:
        return "none"
    return f'<data class="n" value="{at!r}" title="{at:.12g} ± {error:.0e}">{at:.5g}</data>'


def _under_the_load(
    figures: Mapping[str, Drawn], results: Mapping[str, LoadedFigure], motions: tuple[LoadedMotion, ...]
) -> str:
    """Figs 5-11 under the dynamic load."""
    parts = ""
    for key, (drawn, path) in figures.items():
        sentence = f'<p class="result">{escape(results[key].sentence)}</p>' if key in results else ""
        parts += figure(key, f"Fig. {int(key[4:])} under the dynamic load", path, drawn.caption, sentence)
    return f"""
<p>The paper keeps the normal load constant, N&nbsp;=&nbsp;1, which is the weight of the pendulum alone
(<a href="#erratum-1">erratum 1</a>). On a real floor the load is what the ground has to give: it carries both bodies,
and it grows and shrinks as the bob rises and falls,
N = λ + 1 + (cos θ)″, with friction and load solved together (<code>normal_load = "dynamic"</code>). Below are the
paper's figures with that load, all else as before. No claim is judged by it: the claims are about the paper's
model.</p>
{_loads(motions)}{parts}
"""


def _loads(motions: tuple[LoadedMotion, ...]) -> str:
    if not motions:
        return ""
    words = {1.0: "N = 1, as printed", "weight": "λ + 1, constant", "dynamic": "dynamic"}
    rows = []
    for motion in motions:
        loads = f"{number(motion.least_load)} to {number(motion.largest_load)}"
        drift, exact = number(motion.drift), f'value="{motion.drift!r}" title="{motion.drift!r}"'
        drift = f'<data class="n" {exact}>0</data>' if abs(motion.drift) < 1e-9 else drift  # the error of the run
        rows.append((law(motion.friction), words[motion.load], number(motion.travel), drift, loads))
    head = ("law", "normal load", f"X after {SHOWN_PERIODS} periods", "drift per period, settled", "true load, settled")
    return (
        '<p class="before">The motion of Figs 5-8 under three loads. The true load is the reaction of the ground, '
        f"which a constant load does not follow.</p>{table(head, rows, names=2)}"
    )


def _steady_travel(steady: SteadyTravel, maps: Path, branches: Path) -> str:
    """The map of steady travel, and the branches on which travel is born."""
    words = {1.0: "N = 1", "dynamic": "dynamic load"}
    rows = []
    for panel in steady.panels:
        ended = ", ".join(f"{count} {escape(status)}" for status, count in panel.ended.items()) or "none"
        share, hidden = f"{100.0 * panel.travelling:.1f} %", str(panel.hidden) if panel.hidden else "none"
        rows.append((f"{law(panel.friction)}, {words[panel.load]}", share, ended, hidden))
    diagram = steady.branches
    born = {round(diagram.branches[join.parent].special_points[join.special].parameter, 6) for join in diagram.joins}
    places = " and ".join(f"{place:g}" for place in sorted(born))
    head = ("runs", "settled and travelling", "did not go to their end", "a constant load hid a lift-off")
    lift_off = Status.LIFT_OFF.value
    map_caption = (
        f"{POINTS} x {POINTS} settled runs for each load. Grey: no travel. The sign depends on the start, "
        "which chooses between mirror-image solutions. Pink: runs that did not go to their end, most with the status "
        f"“{lift_off}”. Hatched to the left: under a constant load, which does not notice it, the true load would be "
        "negative. The paper's ρ is 4."
    )
    branch_caption = (
        "The capsule of Figs 5-8 with the exponential law and N = 1, followed over its spring from "
        f"ρ = {FOLLOWED[0]:g} to {FOLLOWED[1]:g}, unstable motions included: the symmetric motion, which does not "
        f"travel, and mirror-image solutions that do. They are born and vanish at ρ = {places}. The paper has ρ = 2 in "
        "Figs 5-8 and ρ = 4 in Figs 9-11."
    )
    return (
        '<p class="before">Fig. 9 as it would have to be drawn for steady travel: over mass ratio and spring, each run '
        "until it has settled; then the birth of travel, a symmetry that breaks.</p>"
        + table(head, rows)
        + figure("steady-travel", "Where settled motions travel", maps, map_caption)
        + figure("branches", "How travel is born", branches, branch_caption)
    )
