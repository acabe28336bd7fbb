"""The report of `vibrocap reproduce`: one HTML page that carries its figures and needs nothing else."""

import base64
import dataclasses
import math
import platform
from collections.abc import Iterable, Mapping
from html import escape
from importlib.metadata import version
from pathlib import Path
from string import Template

from vibrocap.files import write_text
from vibrocap.paper.claims.claim import Outcome, Verdict
from vibrocap.paper.errata import ERRATA, Erratum
from vibrocap.paper.figures.figure import Figure
from vibrocap.paper.main_finding import MainFinding
from vibrocap.paper.presets import START_ANGLE, START_BRISTLE, figures_5_to_8, figures_9_to_11
from vibrocap.paper.runs import LAST, SETTLING_PERIODS, SWEEP_PERIODS, TOLERANCE
from vibrocap.physics.parameters import parameter_table

PARTS = ("vibrocap", "numpy", "scipy", "llvmlite", "matplotlib")
BADGES = {Outcome.HOLDS: "holds", Outcome.ONLY_FOR: "only", Outcome.FAILS: "fails", Outcome.UNDECIDED: "open"}
FEW = 6  # numbers, shown at once; more are folded away


@dataclasses.dataclass
class Result:
    """What a reproduction has so far."""

    only: str | None = None
    figures: dict[str, tuple[Figure, Path]] = dataclasses.field(default_factory=dict)
    verdicts: dict[str, list[Verdict]] = dataclasses.field(default_factory=dict)  # by chapter
    finding: MainFinding | None = None
    seconds: float = 0.0
    finished: bool = False


def write_report(result: Result, path: Path) -> Path:
    """Write the report of what has been done so far."""
    claims = [verdict for chapter in result.verdicts.values() for verdict in chapter]
    keys = {verdict.claim.key for verdict in claims}
    errata = [erratum for erratum in ERRATA if result.only is None or keys & set(erratum.claims)]
    page = PAGE.substitute(
        notice="" if result.finished else '<p class="notice">This run did not finish; below is what it had done.</p>',
        scope="" if result.only is None else f"<p>Only {escape(result.only)} was asked for.</p>",
        counts=_counts(claims),
        finding="" if result.finding is None else _finding(result.finding, result.figures.get("symmetry")),
        presets=_presets(),
        figures="".join(_figure(*made) for key, made in result.figures.items() if key != "symmetry"),
        claims="".join(_chapter(title, verdicts) for title, verdicts in result.verdicts.items()),
        errata="".join(_erratum(erratum, keys) for erratum in errata),
        rerun="vibrocap reproduce" + (f" --only {escape(result.only)}" if result.only else ""),
        versions=", ".join(f"{part} {version(part)}" for part in PARTS) + f", Python {platform.python_version()}",
        seconds=f"{result.seconds:.0f}",
        tolerance=f"{TOLERANCE:g}",
        settling=SETTLING_PERIODS,
        sweep=SWEEP_PERIODS,
        last=LAST,
    )
    return write_text(path, page)


def number(value: float) -> str:
    """A number to read: six digits; "none" for one that does not exist."""
    if not math.isfinite(value):
        return "none"
    if value == round(value) and abs(value) < 1e6:
        return str(int(value))
    return f"{value:.6g}".replace("e-0", "e-").replace("e+0", "e+")


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """An HTML table; its cells are HTML already."""
    top = "".join(f"<th>{cell}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    return f'<div class="scroll"><table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table></div>'


def _counts(claims: list[Verdict]) -> str:
    cells = [f'<span class="badge total">{len(claims)} claims</span>']
    for outcome, badge in BADGES.items():
        count = sum(verdict.finding.outcome is outcome for verdict in claims)
        label = outcome.value + (" …" if outcome is Outcome.ONLY_FOR else "")
        cells.append(f'<span class="badge {badge}">{count} {label}</span>')
    return " ".join(cells)


def _picture(figure: Figure, path: Path) -> str:
    data = base64.b64encode(path.read_bytes()).decode("ascii")
    return f'<img alt="{escape(figure.title)}" src="data:image/png;base64,{data}">'


def _figure(figure: Figure, path: Path) -> str:
    name = f"Fig. {int(figure.key[3:])}" if figure.key.startswith("fig") else "Figure"
    return (
        f'<figure id="{figure.key}"><h3>{name}: {escape(figure.title)}</h3>{_picture(figure, path)}'
        f"<figcaption>{escape(figure.caption)} Data: <code>figures/{figure.key}.csv</code>.</figcaption></figure>"
    )


def _numbers(found: Mapping[str, float]) -> str:
    if not found:
        return ""
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td class='value'>{number(float(value))}</td></tr>"
        for name, value in found.items()
    )
    inner = f"<table class='numbers'>{rows}</table>"
    return inner if len(found) <= FEW else f"<details><summary>{len(found)} numbers</summary>{inner}</details>"


def _chapter(title: str, verdicts: list[Verdict]) -> str:
    rows = []
    for verdict in verdicts:
        claim, finding = verdict.claim, verdict.finding
        nearest = f'<p class="nearest"><b>Nearest true:</b> {escape(finding.nearest)}</p>' if finding.nearest else ""
        margin = f"<p class='small'>Tolerance {number(claim.tolerance.value)}: {escape(claim.tolerance.origin)}.</p>"
        rows.append(
            (
                f'<span class="where">{escape(claim.where)}</span><p id="{claim.key}">{escape(claim.says)}</p>'
                f'<p class="small"><code>{claim.key}</code></p>',
                f'<span class="badge {BADGES[finding.outcome]}">{escape(verdict.verdict)}</span>'
                f"<p>{escape(finding.why)}</p>{nearest}",
                f"<p class='small'>{escape(claim.test)}</p>{_numbers(finding.found)}{margin}",
            )
        )
    return f"<h3>{escape(title[0].upper() + title[1:])}</h3>" + table(
        ("the paper says", "verdict", "how tested, and what was found"), rows
    )


def _erratum(erratum: Erratum, keys: set[str]) -> str:
    links = ", ".join(f'<a href="#{key}">{key}</a>' if key in keys else f"<span>{key}</span>" for key in erratum.claims)
    return (
        f"<h3>{erratum.number}. {escape(erratum.title)}</h3><p class='where'>{escape(erratum.where)}</p>"
        f"<p><b>Printed.</b> {escape(erratum.printed)}</p><p><b>Right.</b> {escape(erratum.right)}</p>"
        f"<p class='small'>Claims: {links}.</p>"
    )


def _presets() -> str:
    rows = []
    first, second = figures_5_to_8(), figures_9_to_11()
    for part in ("machine", "drive"):
        for info in parameter_table(getattr(first, part)):
            path = f"{part}.{info.name}"
            values = [first.parameter(path), second.parameter(path)]
            cells = [escape(str(value)) for value in values]
            if part == "drive":
                cells[0] += " (not printed; as in Figs 9-11)"
            if info.name == "mass_ratio":
                cells[1] = "0.01 to 8.1"
            rows.append((escape(info.symbol), f"<code>{path}</code>", escape(info.meaning), *cells))
    for name in ("lugre", "exponential"):
        law = figures_5_to_8(name).friction
        for info in parameter_table(law):
            value = escape(str(getattr(law, info.name)))
            rows.append(
                (escape(info.symbol), f"<code>{law.name}.{info.name}</code>", escape(info.meaning), value, value)
            )
    start = f"Start: angle {number(START_ANGLE)} (pi/3), bristle {START_BRISTLE}, all else 0."
    return table(("symbol", "name", "meaning", "Figs 5-8", "Figs 9-11"), rows) + f"<p>{start}</p>"


def _finding(finding: MainFinding, symmetry: tuple[Figure, Path] | None) -> str:
    asymmetries = table(
        ("settled motion", "largest |X'(τ) + X'(τ + T/2)|", "drift per period", "drift of the mirror twin"),
        (
            (escape(row.case), number(row.largest_difference), number(row.drift), number(row.drift_of_twin))
            for row in finding.asymmetries
        ),
    )
    names = ("O1", "O2", "P1", "P2")
    points = table(
        ("average over", *names),
        ((escape(window), *(number(places[name]) for name in names)) for window, places in finding.points.items()),
    )
    soft = table(
        ("steady state at", *names),
        (
            ("printed (ρ = 4)", *(number(value) for value in finding.points["printed"].values())),
            *(
                (f"ρ = {row.stiffness:g}", *(_place(row.at[name], row.error[name]) for name in names))
                for row in (finding.stiff, *finding.soft)
            ),
        ),
    )
    picture = (
        ""
        if symmetry is None
        else (
            f'<figure id="symmetry">{_picture(*symmetry)}<figcaption>{escape(symmetry[0].caption)} '
            "Data: <code>figures/symmetry.csv</code>.</figcaption></figure>"
        )
    )
    ranges = [found for each in finding.stiff.equal.values() for found in each]
    nothing = f"from λ = {number(max(low for low, _ in ranges))} to {number(min(high for _, high in ranges))}"
    steady = " and ".join(f"{number(value)} ({short})" for short, value in finding.steady.items())
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
<li><b>Every travelling motion has a mirror twin</b> that travels exactly the other way. The motion of Figs 5-8 travels
because it has lost the symmetry by itself; which of the twins appears is decided by the start.</li>
</ul>
{picture}
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
    """A place with its error; "none" where there is none."""
    return "none" if at != at else f"{at:.10g} ± {error:.0e}"


PAGE = Template("""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>The paper, reproduced and judged</title>
<style>
:root { --ink: #1d1f23; --soft: #5b616b; --line: #dfe2e7;
  --holds: #0b6e4f; --only: #8a5a00; --fails: #a3182c; --open: #4b5563; }
* { box-sizing: border-box; }
body { font: 15px/1.5 system-ui, -apple-system, "Segoe UI", "DejaVu Sans", sans-serif; color: var(--ink); margin: 0; }
main { max-width: 1180px; margin: 0 auto; padding: 28px 24px 80px; }
h1 { font-size: 27px; line-height: 1.25; margin: 0 0 6px; }
h2 { font-size: 21px; margin: 44px 0 10px; padding-top: 14px; border-top: 2px solid var(--ink); }
h3 { font-size: 16px; margin: 26px 0 8px; }
p { margin: 6px 0; } ul { padding-left: 20px; } li { margin: 5px 0; }
nav a { margin-right: 16px; } a { color: #0b5394; }
code { font: 12.5px ui-monospace, "DejaVu Sans Mono", monospace; background: #f3f4f6; padding: 1px 4px;
  border-radius: 3px; }
.small, .where, figcaption { color: var(--soft); font-size: 13px; }
.notice { background: #fff3cd; border: 1px solid #e0c36a; padding: 10px 14px; border-radius: 6px; }
.badge { display: inline-block; border-radius: 5px; padding: 2px 9px; font-weight: 600; font-size: 13px; color: #fff; }
.total { background: var(--ink); } .holds { background: var(--holds); } .only { background: var(--only); }
.fails { background: var(--fails); } .open { background: var(--open); }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; }
th { text-align: left; font-size: 13px; color: var(--soft); border-bottom: 1.5px solid var(--ink);
  padding: 6px 12px 6px 0; }
td { vertical-align: top; border-bottom: 1px solid var(--line); padding: 8px 12px 8px 0; }
td p:first-child { margin-top: 0; }
.claims td:nth-child(1) { width: 29%; } .claims td:nth-child(2) { width: 31%; }
.numbers { width: auto; margin: 4px 0; }
.numbers td { border: 0; padding: 0 14px 0 0; font-size: 12.5px; width: auto !important; }
.value { font-family: ui-monospace, "DejaVu Sans Mono", monospace; white-space: nowrap; }
.nearest { border-left: 3px solid var(--line); padding-left: 9px; }
figure { margin: 18px 0 34px; } img { max-width: 100%; height: auto; display: block; }
summary { cursor: pointer; font-size: 13px; color: #0b5394; }
@media print { details { display: block; } nav { display: none; } main { max-width: none; } }
</style>
</head>
<body>
<main>
<h1>The paper, reproduced and judged</h1>
<p>P. Liu, H. Yu and S. Cang, <i>Modelling and analysis of dynamic frictional interactions of vibro-driven capsule
systems with viscoelastic property</i>. Every figure below is drawn from our own runs, every number is computed by
them, and nothing is tuned: where a claim fails, the nearest true statement stands beside it.</p>
$notice$scope
<p>$counts</p>
<nav><a href="#finding">Main finding</a><a href="#presets">Parameters</a><a href="#figures">Figures</a>
<a href="#claims">Claims</a><a href="#errata">Errata</a><a href="#rerun">How to run this again</a></nav>

<h2 id="finding">Main finding: why the capsule of Fig. 9 does not travel</h2>
$finding

<h2 id="presets">Parameters</h2>
<p>The paper prints neither h nor ω for Figs 5-8; the values printed for Figs 9-11 are used, which reproduce the motion
that section 3.1 describes. All quantities are dimensionless: lengths in l, time in √(l/g), forces in m g.</p>
$presets

<h2 id="figures">Figures</h2>
<p>LM (LuGre) red and solid, EM (exponential) blue and dashed, in the arrangement of the paper.</p>
$figures

<h2 id="claims">Claims</h2>
<p>AS and DS: stages in which the capsule accelerates and decelerates. "Settled" means the last of $settling periods for
Figs 5-8 and the last of $sweep for Figs 9-11; "steady" averages are over the last $last.</p>
<div class="claims">$claims</div>

<h2 id="errata">Errata</h2>
$errata

<h2 id="rerun">How to run this again</h2>
<p><code>$rerun</code>, or <code>make reproduce</code> in the sources. It took $seconds s. Motions are computed at
tolerance $tolerance per step; every change between sticking and sliding is located to rounding level.</p>
<p class="small">$versions</p>
</main>
</body>
</html>
""")
