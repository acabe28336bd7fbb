"""The page of the report, with its style."""

from string import Template

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
