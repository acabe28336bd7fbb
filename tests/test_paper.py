"""The paper: every claim has its verdict with a number and a tolerance, and the verdicts stay what they are."""

import csv
import functools
import html
import json
import math
import multiprocessing
import re
import time
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.motion.status import Status
from vibrocap.paper.claims import CHAPTERS, chapters
from vibrocap.paper.claims.claim import CLAIMS, Outcome, judged, printed
from vibrocap.paper.errata import ERRATA, errata_page
from vibrocap.paper.figures import FIGURES, LOADED, chosen_figures
from vibrocap.paper.load_finding import loaded_figure, loaded_motions
from vibrocap.paper.presets import figures_5_to_8, figures_9_to_11, law, start, with_load
from vibrocap.paper.runs import LIGHT_POINTS, SWEEP_POINTS, Runs
from vibrocap.paper.travel import PRINTED, SOFT, asymmetry, averages, crossings, meeting_points, steady_points, zeros
from vibrocap.report.pieces import number
from vibrocap.report.reproduce import KEYS, reproduce

HOLDS, ONLY_FOR, FAILS, UNDECIDED = Outcome.HOLDS, Outcome.ONLY_FOR, Outcome.FAILS, Outcome.UNDECIDED
CLAIMS_OF = {
    "O1": CLAIMS["control-point-o1"],
    "O2": CLAIMS["control-point-o2"],
    "P1": CLAIMS["boundary-point-p1"],
    "P2": CLAIMS["boundary-point-p2"],
}
ROOT = Path(__file__).resolve().parents[1]

KEYS_BY_OUTCOME = {
    HOLDS: """
        lagrangian scaling decoupling bristle-rate steady-slope-formula similar-patterns velocity-while-sticking
        sticking-stronger-with-em larger-displacement-with-em bristle-and-force-alike em-without-hysteresis
        forward-loop-in-presliding backward-loop-in-presliding branches-meet-at-the-end offset-points-of-the-loop
        periodic-for-every-mass-ratio velocity-declines-with-mass swing-falls-with-mass periodic-responses
        bidirectional
    """,
    ONLY_FOR: """
        load-counted-twice stribeck-term start-of-motion presliding-is-linear steady-sliding offset-points-exist
        monotone-between-offsets lower-offset upper-offset upper-offset-near-stribeck loop-of-imposed-sliding
        higher-velocity-with-em larger-cycle-of-capsule steps-at-zero-velocity not-strictly-periodic bounded
        bristle-reaches-the-same-level bristle-follows-speed sharp-fall-marks-sticking friction-rises-while-sticking
        forward-loop-in-sliding backward-loop-in-sliding order-reverses-at-m1 decline-beyond-m1 monotone-lm
        monotone-em em-slower-between em-overtakes-after-p2 larger-positive-velocities averages-drop-below-zero
        distance-decreases-with-mass energy-requirements loss-in-hysteretic-loop vibration-quenching lm-desirable
    """,
    FAILS: """
        load-is-the-weight one-alpha breakaway-point em-avoids-hysteretic-loss negative-slope-stabilises
        larger-cycle-of-pendulum quasi-periodic gap-from-hysteresis higher-frequency-with-em lower-peak-with-lm
        laws-coincide-at-m1 steady-progress direction-set-by-mass-ratio em-falls-more-steeply control-point-o1
        control-point-o2 boundary-point-p1 boundary-point-p2 em-faster-before-p1 signs-of-lm signs-of-em
        control-by-mass-ratio em-declines-more travel-goes-on
    """,
    UNDECIDED: """
        parameters-of-figures-5-to-8 agreement-with-experiments
    """,
}
EXPECTED = {key: outcome for outcome, keys in KEYS_BY_OUTCOME.items() for key in keys.split()}


@pytest.fixture(scope="module")
def runs() -> Runs:
    return Runs()


def found(runs: Runs, key: str) -> dict[str, float]:
    return dict(judged(CLAIMS[key], runs).finding.found)


def test_equations_2_and_3_follow_from_the_lagrangian():
    """The claim `lagrangian` asks it of numbers, `scaling` and `decoupling` hold the code to them."""
    import sympy as sp

    M, m, l, g, k, t = sp.symbols("M m l g k t", positive=True)  # noqa: E741
    a, x = sp.Function("theta")(t), sp.Function("x")(t)
    along, across = x.diff(t) - l * a.diff(t) * sp.cos(a), l * a.diff(t) * sp.sin(a)
    lagrangian = M * x.diff(t) ** 2 / 2 + m * (along**2 + across**2) / 2 - k * a**2 / 2 - m * g * l * sp.cos(a)
    pendulum = m * l**2 * a.diff(t, 2) - m * l * sp.cos(a) * x.diff(t, 2) - m * g * l * sp.sin(a) + k * a
    capsule = (M + m) * x.diff(t, 2) - m * l * sp.cos(a) * a.diff(t, 2) + m * l * sp.sin(a) * a.diff(t) ** 2
    for q, equation in ((a, pendulum), (x, capsule)):
        assert sp.simplify(lagrangian.diff(q.diff(t)).diff(t) - lagrangian.diff(q) - equation) == 0


def test_there_are_enough_claims_and_each_stands_in_a_chapter():
    assert len(CLAIMS) >= 40
    assert sum(len(claims) for claims in chapters().values()) == len(CLAIMS)
    assert list(chapters()) == list(CHAPTERS)
    assert {figure for claim in CLAIMS.values() for figure in claim.figures} <= set(KEYS)
    for key in KEYS:
        assert chapters(key), f"no claim belongs to {key}"


def test_every_claim_is_expected():
    assert set(EXPECTED) == set(CLAIMS)


# These need runs of their own, of a second or two each, the points of the steady state those of two springs.
POINTS = ("control-point-o1", "control-point-o2", "boundary-point-p1", "boundary-point-p2")
SLOW = (*POINTS, "load-is-the-weight")


@pytest.mark.parametrize("key", [pytest.param(key, marks=pytest.mark.slow) if key in SLOW else key for key in EXPECTED])
def test_verdict(runs, key):
    verdict = judged(CLAIMS[key], runs)
    claim, finding = verdict.claim, verdict.finding
    assert finding.outcome is EXPECTED[key]
    assert claim.where
    assert claim.says.endswith((".", ")", "loop."))
    assert claim.test
    assert finding.why
    assert claim.tolerance.origin
    assert (finding.outcome is ONLY_FOR) <= bool(finding.only_for)
    if key != "agreement-with-experiments":  # the paper prints no number that it could be judged by
        assert claim.tolerance.value > 0.0
        assert finding.found
    row = verdict.row
    assert json.loads(json.dumps(row, allow_nan=False)) == row


def test_printed_tolerance_is_half_a_unit_of_the_last_digit():
    assert printed("4.0").value == pytest.approx(0.05)
    assert printed("1.18").value == pytest.approx(0.005)
    assert printed("1").value == pytest.approx(0.5)


def test_presets_name_the_figures():
    system = figures_5_to_8("lugre")
    machine, drive = system.machine, system.drive
    assert (machine.mass_ratio, machine.stiffness, machine.damping) == (2.5, 2.0, 1.0)
    assert (drive.amplitude, drive.frequency) == (1.8, 1.0)
    assert start(system) == {"angle": math.pi / 3, "bristle": 0.0026}
    assert start(figures_9_to_11("exponential", 0.8), mirrored=True) == {"angle": -math.pi / 3}
    assert figures_9_to_11("lugre", 4.0).machine.stiffness == 4.0
    with pytest.raises(ValueError, match="law should be one of lugre, exponential, got 'coulomb'"):
        law("coulomb")


@pytest.mark.parametrize("friction", ["lugre", "exponential"])
@pytest.mark.parametrize("ratio", [0.05, 0.8, 2.2, 4.0, 8.1])
def test_steady_motion_of_figure_9_is_symmetric_and_does_not_travel(runs, friction, ratio):
    shown = asymmetry(runs, "", figures_9_to_11(friction, ratio))
    assert abs(shown.drift) < 1e-9
    assert shown.largest_difference < 1e-8


@pytest.mark.parametrize("friction", ["lugre", "exponential"])
def test_every_travelling_motion_has_a_mirror_twin(runs, friction):
    shown = asymmetry(runs, "", figures_5_to_8(friction))
    assert shown.drift > 0.1
    assert shown.drift_of_twin == pytest.approx(-shown.drift, rel=1e-12)
    assert shown.largest_difference > 0.01  # has lost the symmetry


def test_transient_averages_vanish_elsewhere_than_printed(runs):
    assert zeros(runs, "lugre")["first 40 periods"] == pytest.approx(1.929, abs=0.01)
    assert zeros(runs, "exponential")["first 40 periods"] == pytest.approx(1.776, abs=0.01)
    assert math.isnan(zeros(runs, "lugre")["last 10 periods"])
    # The capsule is displaced once: an average over twice the window is half as large.
    curves = averages(runs, "lugre")
    assert np.max(np.abs(curves["first 40 periods"] - 2.5 * curves["first 100 periods"])) < 1e-6


@pytest.mark.slow
def test_soft_spring_gives_the_printed_shape_but_not_all_points(runs):
    """The four points of the steady state at rho = 0.58; O1 and O2 as Newton shooting has them."""
    points = steady_points(runs, SOFT)
    assert points.at["P1"] < points.at["O2"] < points.at["O1"] < points.at["P2"]  # in the printed order
    assert points.at["O1"] == pytest.approx(4.215251621241, abs=1e-10)
    assert points.at["O2"] == pytest.approx(3.456230048645, abs=1e-10)
    assert all(0.0 < error < 1e-9 for error in points.error.values())
    for name, value in PRINTED.items():
        assert abs(points.at[name] - value) > CLAIMS_OF[name].tolerance.value
    assert points.equal == {"lugre": (), "exponential": (), "both": ()}


@pytest.mark.slow
@pytest.mark.parametrize("point", ["O1", "O2", "P1", "P2"])
def test_there_is_no_such_point_in_the_steady_state_and_the_claim_shows_it(runs, point):
    steady = steady_points(runs, 4.0)
    assert all(math.isnan(place) for place in steady.at.values())
    assert set(steady.equal.values()) == {((0.01, 8.1),)}
    finding = judged(CLAIMS_OF[point], runs).finding
    shown = {name: value for name, value in finding.found.items() if name.startswith("steady")}
    assert shown.pop("steady: it is nothing from lambda") == 0.01
    assert shown.pop("steady: it is nothing to lambda") == 8.1
    largest = [value for name, value in shown.items() if "largest" in name]
    assert len(largest) == 1
    assert largest[0] < 1e-9
    assert [value for name, value in shown.items() if "largest" not in name] == [0.0, 0.0]
    soft = steady_points(runs, SOFT).at[point]
    assert f"{soft:.10f}" in finding.nearest
    assert "there is no such point" in finding.nearest


def test_crossings_know_their_direction():
    x = np.linspace(0.0, 4.0, 401)
    y = np.sin(np.pi * x + 0.1)
    assert crossings(x, y) == pytest.approx([k - 0.1 / np.pi for k in (1, 2, 3, 4)], abs=1e-4)
    assert crossings(x, y, rising=True) == pytest.approx([k - 0.1 / np.pi for k in (2, 4)], abs=1e-4)
    assert crossings(x, np.full_like(x, 1e-12)) == []
    assert meeting_points(x, 0.0 * x, y) == pytest.approx((1 - 0.1 / np.pi, 2 - 0.1 / np.pi), abs=1e-4)


def test_errata_name_claims_that_show_them_and_the_page_lists_them():
    assert [erratum.number for erratum in ERRATA] == list(range(1, 9))
    for erratum in ERRATA:
        assert set(erratum.claims) <= set(CLAIMS)
        assert any(EXPECTED[key] in (FAILS, ONLY_FOR) for key in erratum.claims)
        assert f"**Right.** {erratum.right}" in errata_page()
    listed = re.findall(r"^\d+\. .+$", (ROOT / "docs" / "errata.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert listed == [f"{erratum.number}. {erratum.title}" for erratum in ERRATA]
    assert listed == re.findall(r"^## (.+)$", errata_page(), re.MULTILINE)


@pytest.mark.slow
def test_numbers_in_the_errata_are_those_found(runs):
    texts = {erratum.number: erratum.right for erratum in ERRATA}
    load = found(runs, "load-is-the-weight")
    assert f"{load['least N(tau)']:.2f} and {load['largest N(tau)']:.2f}" in texts[1]
    alpha = found(runs, "one-alpha")
    assert all(f"{value:.3f}" in texts[2] for value in alpha.values())
    assert f"{found(runs, 'offset-points-exist')['largest delta2']:.4f}" in texts[4]
    growth = found(runs, "negative-slope-stabilises")
    assert f"{growth['EM: growth rate']:.2f} with EM and {growth['LM: growth rate']:.2f} with LM" in texts[5]
    gaps = found(runs, "gap-from-hysteresis")
    assert f"{gaps['LM: gap']:.4f} with LM and {gaps['EM: gap']:.4f} with EM" in texts[6].replace("\n", " ")
    assert f"{found(runs, 'lower-peak-with-lm')['LM']:.3f}" in texts[7]
    soft = steady_points(runs, SOFT).at
    assert f"{soft['O1']:.4f} (LM) and {soft['O2']:.4f} (EM)" in texts[8]
    assert f"alike at {soft['P1']:.4f} and {soft['P2']:.4f}" in texts[8]


SLOW_FIGURES = ("fig09", *(f"load{number:02d}" for number in range(5, 12)))  # sweeps, and kernels of their own


@pytest.mark.parametrize(
    "key", [pytest.param(key, marks=[pytest.mark.slow] if key in SLOW_FIGURES else []) for key in FIGURES]
)
def test_figure_data_is_complete(runs, key):
    figure = FIGURES[key](runs)
    assert figure.key == key
    assert figure.caption
    assert len({panel.title for panel in figure.panels}) == len(figure.panels)
    for panel in figure.panels:
        assert panel.curves
        for curve in panel.curves:
            assert curve.label
            assert curve.x.shape == curve.y.shape
            assert curve.x.size > 1
            assert np.all(np.isfinite(curve.x))
            assert np.all(np.isfinite(curve.y))


def test_an_unknown_figure_is_refused():
    with pytest.raises(ValueError, match=r"only should be one of fig03, .*, got 'fig04'"):
        chosen_figures("fig04")
    assert chosen_figures("fig09") == ("fig09", "symmetry", "load09")
    assert chosen_figures("fig03") == ("fig03",)


# --- the dynamic load, and steady travel ------------------------------------------------------------------------------
@pytest.mark.slow
def test_motion_of_figure_5_under_the_dynamic_load_is_that_of_its_own_simulation(runs):
    """Recomputed from the equations' words alone: no preset, no kept run."""
    numbers = loaded_figure(runs, "load05").numbers
    rows = {(row.friction, row.load): row for row in loaded_motions(runs)}
    for short, friction, bristle in (("LM", vc.LuGre(), {"bristle": 0.0026}), ("EM", vc.Exponential(), {})):
        machine = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0, normal_load="dynamic")
        system = vc.System(machine, friction, vc.Harmonic(amplitude=1.8, frequency=1.0))
        motion = vc.simulate(system, periods=40, initial={"angle": math.pi / 3} | bristle, tolerance=1e-12)
        assert motion.certificate.ok
        assert numbers[f"{short}: X after forty periods"] == pytest.approx(motion.state["position"], abs=1e-7)
        assert rows[short, "dynamic"].travel == numbers[f"{short}: X after forty periods"]
        load = motion.at(np.linspace(39 * motion.period, motion.end, 20_001), "reaction")
        # Samples T/8192 apart miss turning points by N'' h^2/8, and the last period shown is a later one.
        assert rows[short, "dynamic"].least_load == pytest.approx(load.min(), abs=1e-5)
        assert rows[short, "dynamic"].largest_load == pytest.approx(load.max(), abs=1e-5)
    # As printed it travels; with the load that the motion makes it has its symmetry again.
    assert rows["LM", 1.0].drift > 0.1 > 1e-9 > abs(rows["LM", "dynamic"].drift)
    assert rows["EM", 1.0].drift > 0.1 > 1e-9 > abs(rows["EM", "dynamic"].drift)


@pytest.mark.slow
def test_runs_that_the_load_ends_are_shown_and_not_left_out(runs):
    names = {"LM": "lugre", "EM": "exponential"}
    panels = FIGURES["load09"](runs).panels
    for panel, count, light in ((panels[0], SWEEP_POINTS, False), (panels[3], LIGHT_POINTS, True)):
        for short, name in names.items():
            (shown,) = [curve for curve in panel.curves if curve.role == short and curve.weight == 1.0]
            ended = np.concatenate([ending.x for ending in panel.endings if ending.role == short])
            assert sorted([*shown.x, *ended]) == [run.mass_ratio for run in runs.loaded_sweep(name, light)]
            assert len(shown.x) + len(ended) == count
            assert ended.size
    lightest = runs.loaded_sweep("exponential", light=True)[0]
    assert lightest.status is Status.LIFT_OFF
    assert lightest.last_load == pytest.approx(0.0, abs=1e-8)
    single = vc.simulate(with_load(figures_9_to_11("exponential", lightest.mass_ratio), "dynamic"), periods=2,
                         initial={"angle": math.pi / 3}, tolerance=1e-12)  # fmt: skip
    assert single.end == pytest.approx(lightest.end, abs=1e-8)
    assert f"{lightest.end / single.period:.2f}" in loaded_figure(runs, "load09").sentence
    # Bristle damping takes LM beyond its static level, and light capsules into Painleve's paradox.
    stopped = [run for run in runs.loaded_sweep("lugre", light=True) if not run.status.ok]
    assert {run.status for run in stopped} == {Status.PARADOX}
    assert all(run.last_load > 1e3 for run in stopped)
    for run in stopped:
        assert run.last_coefficient > max(2.0 * math.sqrt(run.mass_ratio * (run.mass_ratio + 1.0)), 0.45)
    assert "Painlevé's paradox" in loaded_figure(runs, "load09").sentence
    rows = list(FIGURES["load09"](runs).rows)
    assert any(row[1] == "EM: lift off" and row[3] == "end_time" for row in rows)


def test_numbers_of_the_report_are_short_with_all_digits_in_the_title():
    assert number(3.0) == '<span class="n">3</span>'
    assert number(-0.25) == '<span class="n">\N{MINUS SIGN}0.25</span>'
    assert number(math.nan) == "none"
    shown = number(0.16434774668425692)
    assert re.sub("<.*?>", "", shown) == "0.1643"
    assert 'title="0.16434774668425692"' in shown
    assert re.sub("<.*?>", "", number(-1.53e-11 / 7)) == "\N{MINUS SIGN}2.186·10\N{MINUS SIGN}12"


def check_page(page, folder):
    """It fetches nothing; its links lead to places on it, each there once, and to files beside it."""
    assert not re.search(r'src="(?!data:)|url\(|@import|fetch\(', page)
    places = re.findall(r'\bid="([^"]+)"', page)
    assert len(places) == len(set(places))
    links = set(re.findall(r'href="([^"]+)"', page)) - {"data:,"}
    assert {link[1:] for link in links if link.startswith("#")} <= set(places)
    beside = {link for link in links if not link.startswith("#")}
    assert beside
    for link in beside:
        assert (folder / link).is_file(), link
    for outcome in re.findall(r'data-outcome="(\w+)"', page):
        assert f'data-show="{outcome}"' in page
    for short in ("LM", "EM"):
        assert page.index(f"<b>{short}</b> is the ") < page.index("<h2")
    assert len(re.findall("<(section|article|figure|details)[ >]", page)) == len(
        re.findall("</(section|article|figure|details)>", page)
    )


@pytest.mark.slow
def test_one_figure_is_written_with_its_claims(tmp_path):
    shares, helping = [], []
    whole = [tmp_path / "out" / name for name in ("report.html", "claims.json", "claims.csv")]
    (tmp_path / "out").mkdir()
    for path in whole:
        path.write_text("of the whole paper")
    before = {*multiprocessing.active_children()}

    def progress(what, share):
        shares.append(share)
        helping.append(len({*multiprocessing.active_children()} - before))

    made = reproduce(tmp_path / "out", "fig03", progress)
    assert {*helping[:-1]} == {1}  # the process that draws, which ends with the work
    assert helping[-1] == 0
    assert [path.read_text() for path in whole] == ["of the whole paper"] * 3
    assert made.finished
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert [path.name for path in made.figures] == ["fig03.png"]
    page = made.report.read_text(encoding="utf-8")
    assert "data:image/png;base64," in page
    check_page(page, made.report.parent)
    assert "loop-of-imposed-sliding" in page
    assert made.report.name == "report-fig03.html"
    rows = json.loads((tmp_path / "out" / "claims-fig03.json").read_text(encoding="utf-8"))
    assert [row["key"] for row in rows] == [verdict.claim.key for verdict in made.claims]
    with (tmp_path / "out" / "figures" / "fig03.csv").open(encoding="utf-8") as file:
        points = list(csv.DictReader(file))
    assert {point["curve"] for point in points}
    assert all(math.isfinite(float(point["x"])) and math.isfinite(float(point["y"])) for point in points)


def test_an_interrupt_waits_for_no_other_process_and_what_is_done_is_written(tmp_path, monkeypatch):
    """The second process is at work on branches, here for an hour: what it would draw is drawn by the first."""
    monkeypatch.setattr("vibrocap.report.reproduce.steady_travel", functools.partial(time.sleep, 3600.0))
    monkeypatch.setattr("vibrocap.report.reproduce.chosen_figures", lambda only: ("fig03",))

    def interrupt(what, share):
        if what.startswith("the half"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        reproduce(tmp_path, None, interrupt)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "did not finish" in page
    assert "data:image/png;base64," in page
    assert json.loads((tmp_path / "claims.json").read_text(encoding="utf-8")) == []


@pytest.mark.slow
def test_the_whole_paper(tmp_path, runs, monkeypatch):
    """From the runs that the tests above have made, where they were made here."""
    monkeypatch.setattr("vibrocap.report.reproduce.Runs", lambda: runs)
    made = reproduce(tmp_path)
    assert len(made.claims) == len(CLAIMS)
    assert len(made.figures) == len(FIGURES) + 2  # the map and the branches of steady travel
    page = made.report.read_text(encoding="utf-8")
    check_page(page, tmp_path)
    loaded = json.loads((tmp_path / "load.json").read_text(encoding="utf-8"))
    assert list(loaded) == list(LOADED)
    assert all(html.escape(each["sentence"]) in page for each in loaded.values())
    assert all(f'id="{key}"' in page for key in CLAIMS)
    assert all(erratum.title in page.replace("&#x27;", "'") for erratum in ERRATA)
