"""Figures for print: fitted to a width, in the user's own settings, with nothing cut off and no text over another."""

from pathlib import Path

import matplotlib
import matplotlib.image
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.ticker import FixedLocator, MaxNLocator

import vibrocap as vc
from cases import refused
from crowding import crowded, texts_of
from test_stick_slip import Belt
from thinned import exhaustive_but, slow_but
from vibrocap.arguments import ArgumentError
from vibrocap.cli.main import main
from vibrocap.identification.experiments.experiment_design import ramp
from vibrocap.plotting.fits import residual_figure
from vibrocap.plotting.look.finishing import finished
from vibrocap.plotting.look.page import on_page
from vibrocap.plotting.look.style import figure as empty_figure
from vibrocap.records.stick_slip import regime_diagram, stick_slip

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
BELT = vc.System(
    vc.Oscillator(damping=0.1, belt_speed=1.5), vc.Exponential(0.5, 1.0, 2.0), vc.Constant(duration=2.0 * np.pi)
)
EXAMPLES = Path(__file__).parents[1] / "examples"
WIDTHS = {"column": 3.4, "page": 7.0}
PLANE = {"angle": (-3.0, 3.0), "angle_rate": (-3.0, 3.0)}
AXES = {"machine.mass_ratio": np.linspace(1.0, 4.0, 6), "drive.amplitude": np.linspace(1.0, 3.0, 5)}


def rubbed(name, speed):
    """A record of a contact that is rubbed to and fro, with noise."""
    time = np.linspace(0.0, 4.0 * np.pi / speed, 400)
    velocity = speed * 3e-3 * np.cos(speed * time)
    force = [np.sign(v) * (2.0 + 1.0 * np.exp(-40.0 * abs(v))) for v in velocity.tolist()]
    noise = 0.02 * np.random.default_rng(int(speed)).standard_normal(len(time))
    return vc.Record(name=name, time=time, velocity=velocity, force=np.array(force) + noise)


def pulled(speed):
    """The record of a block of 0.5 kg that is pulled through a spring of 2 N/m (`Belt` of test_stick_slip.py)."""
    return stick_slip(*Belt(0.5 / speed).record(0.02), **Belt(0.5 / speed).known)


BIHARMONIC = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Biharmonic())
DESIGNS = {"drive.second_phase": (0.0, 6.0), "machine.damping": (0.3, 3.0)}
RUBBED = [rubbed("slow", 2.0), rubbed("fast", 9.0)]
RESULTS = {
    "motion": lambda: vc.simulate(SYSTEM, periods=6, initial={"angle": 1.0}),
    "motion in SI": lambda: vc.read_case(EXAMPLES / "bench-in-si.toml").simulate(),
    "row of period two": lambda: vc.read_case(EXAMPLES / "three-blocks-shaken-on-a-belt.toml").simulate(),
    "undriven": lambda: vc.read_case(EXAMPLES / "vibrates-by-mode-coupling.toml").simulate(),
    "servo": lambda: vc.read_case(EXAMPLES / "hunts-about-its-goal.toml").simulate(),
    "maps of laws": lambda: vc.sweep(
        SYSTEM, {"friction.law": ["exponential", "coulomb"]} | AXES, settle=1e-5, periods=60, tolerance=1e-8
    ),
    "crawler": lambda: vc.simulate(vc.System(vc.TwoBodyCrawler(), vc.Coulomb(), vc.Harmonic()), periods=4),
    "orbit": lambda: vc.orbit(SYSTEM, initial={"angle": 1.0}),
    "branches": lambda: vc.branches(SYSTEM, "drive.amplitude", (1.2, 1.4), initial={"angle": 1.0}),
    "equilibria": lambda: vc.equilibrium_branch(BELT, "machine.belt_speed", (0.5, 2.5)),
    "basins": lambda: vc.basins(SYSTEM, PLANE, 12),
    "basins of a block": lambda: vc.basins(BELT, {"position": (-2, 2), "sliding_velocity": (-1.5, 0.5)}, 12),
    "diagram": lambda: vc.bifurcation_diagram(BELT, "machine.belt_speed", (1.4, 1.6), 5, starts=2, settle_periods=60),
    "law": vc.LuGre,
    "sheet": lambda: vc.test_sheet(vc.LuGre()),
    "map": lambda: vc.sweep(SYSTEM, AXES, settle=1e-5, periods=60, tolerance=1e-8),
    "fit": lambda: vc.fit(RUBBED, "exponential", held_out="fast", starts=1),
    "steady fit": lambda: vc.steady_fit(RUBBED, "stribeck", held_out="fast"),
    "comparison": lambda: vc.compare(RUBBED, ["exponential", "coulomb", "stribeck"], held_out="fast", starts=1),
    "match": lambda: vc.match("exponential", vc.Stribeck(), velocity=(0.01, 1.0), starts=1),
    "match of a motion": lambda: vc.match("exponential", vc.Stribeck(), motion=ramp(0.5, 4.0, 100), starts=1),
    "regularisation": lambda: vc.regularisation_error(
        SYSTEM, widths=[0.1, 0.03, 0.01], periods=4, initial={"angle": 1.0}
    ),
    "front": lambda: vc.pareto_front(BIHARMONIC, DESIGNS, starts=[{"angle": 1.0}], evaluations=600, points=8),
    "stick-slip": lambda: pulled(0.05),
    "steady pull": lambda: stick_slip(np.linspace(0.0, 9.0, 900), 10.0 + np.random.default_rng(0).standard_normal(900)),
    "regimes": lambda: regime_diagram([pulled(speed) for speed in (0.05, 0.1, 0.3)]),
    "lines": lambda: vc.sweep(SYSTEM, {"machine.mass_ratio": [1.0, 2.0, 3.0]}, settle=1e-5, periods=60, tolerance=1e-8),
}
KEPT = ["motion", "undriven", "maps of laws", "branches", "equilibria", "basins", "law", "fit", "front", "regimes"]


@pytest.fixture(scope="module")
def motion():
    return RESULTS["motion"]()


@pytest.mark.slow
def test_a_motion_fits_a_column(motion):
    figure = vc.figure(motion, width="column")
    assert figure.get_figwidth() == WIDTHS["column"]
    assert crowded(figure) == []
    for part in figure.subfigs:
        assert all(ax.get_window_extent().height > 0.6 * figure.dpi for ax in part.axes)
    panel = next(ax for ax in figure.findobj(Axes) if ax.get_legend())
    panel.xaxis.set_major_locator(MaxNLocator(40))  # planted faults are noticed
    assert "numbers touch" in [each[0] for each in crowded(figure)]
    panel.xaxis.set_major_locator(FixedLocator([3.0]))
    assert "one number" in [each[0] for each in crowded(figure)]
    panel.legend(loc="center")
    assert ("a legend", f"over the data of {panel.get_title(loc='left')}") in crowded(figure)
    figure.set_figwidth(0.6 * WIDTHS["column"])
    assert crowded(figure)


@pytest.mark.parametrize("kind", slow_but([0], exhaustive_but(map([*RESULTS].index, KEPT), [*RESULTS])))
@pytest.mark.parametrize(("width", "header"), exhaustive_but([0], [("column", True), ("page", False), (None, True)]))
def test_every_kind_of_picture_fits_a_column_a_page_and_a_screen(kind, width, header):
    if kind == "front":
        pytest.importorskip("pymoo")
    figure = vc.figure(RESULTS[kind](), width=width, header=header)
    assert width is None or figure.get_figwidth() == WIDTHS[width]
    assert crowded(figure) == []
    assert not [t for t in texts_of(figure) if t in (figure._suptitle, figure._supxlabel) and not header]


@pytest.mark.slow
@pytest.mark.parametrize("width", exhaustive_but([0], [*WIDTHS]))
def test_the_errors_of_a_fit_are_drawn_at_both_widths(width):
    fitted = vc.steady_fit(RUBBED, "exponential", held_out="fast")
    with on_page(width):
        assert crowded(finished(residual_figure(fitted))) == []


@pytest.mark.slow
def test_a_caption_takes_the_place_of_the_header():
    assert any("LuGre" in text.get_text() for text in texts_of(vc.figure(vc.LuGre(), width="column")))
    bare = vc.figure(vc.LuGre(), width="column", header=False)
    assert not any("LuGre" in text.get_text() or "units" in text.get_text() for text in texts_of(bare))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["equilibria", "diagram"])
def test_diagrams_over_a_parameter_name_the_others(kind):
    heading = vc.figure(RESULTS[kind]())._suptitle.get_text()
    assert all(name in heading for name in (r"$\eta_{c}$", "$c$", "$N$"))
    assert "$v_{b}$" not in heading  # which varies


def test_the_users_settings_hold_over_those_of_the_package(motion):
    with matplotlib.rc_context({"font.size": 6.0, "font.family": "DejaVu Serif", "axes.grid": False}):
        label = vc.plot(motion).xaxis.label
        figure = vc.figure(vc.LuGre(), width="column")
    assert label.get_fontfamily() == ["DejaVu Serif"]
    assert all("DejaVu Serif" in text.get_fontfamily() for text in texts_of(figure))
    assert vc.plot(motion).xaxis.label.get_fontfamily() == ["DejaVu Sans"]


@pytest.mark.slow
def test_lines_have_the_users_widths_and_colours(motion, tmp_path):
    own = {"lines.linewidth": 0.75, "axes.prop_cycle": matplotlib.cycler("color", ["0.0", "0.5"])}
    (usual, *_), frame = vc.plot(motion).get_lines(), empty_figure()[1][0, 0]
    (given,) = frame.plot([0.0, 1.0], [0.0, 0.0], color="#0072B2", linewidth=2.0)
    with matplotlib.rc_context(own):
        drawn = next(line for line in vc.plot(motion, ax=frame).get_lines() if line is not given)
        loops = vc.plot(motion, "friction loop")
        sheet = finished(vc.figure(motion, width="column"))  # finished again, as when it is saved
        path = tmp_path / "sheet.svg"
        vc.figure(motion, path, width="column")
    assert drawn.get_color() == "0.0"
    assert drawn.get_linewidth() == usual.get_linewidth() / 2.0  # once, as the usual width is 1.5
    assert (given.get_color(), given.get_linewidth()) == ("#0072B2", 2.0)  # not ours
    assert {"0.0", "0.5"} <= {line.get_color() for line in loops.get_lines()}
    lines = [line for ax in sheet.findobj(Axes) for line in ax.get_lines()]
    assert {line.get_color() for line in lines} & {"#0072B2", "#D55E00"} == set()
    assert min(line.get_linewidth() for line in lines if line.get_color() == "0.0") > 0.3  # of 0.8 and 1.5: halved once
    assert "#0072b2" not in path.read_text(encoding="utf-8").lower()
    legends = [line for ax in sheet.findobj(Axes) if ax.get_legend() for line in ax.get_legend().get_lines()]
    assert legends
    assert "#0072B2" not in {line.get_color() for line in legends}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "without", "within"),
    [("pdf", b"/Subtype /Type3", b"/FontFile2"), ("svg", b"<text", b'id="DejaVuSans-')],
)
def test_letters_are_outlines_of_a_font_that_journals_take(tmp_path, kind, without, within):
    vc.figure(vc.LuGre(), tmp_path / f"one.{kind}", width="column")
    file = (tmp_path / f"one.{kind}").read_bytes()
    assert without not in file
    assert within in file


@pytest.mark.slow
def test_the_command_line_takes_a_width_and_a_style_sheet(tmp_path, capsys):
    sheet = tmp_path / "journal.mplstyle"
    sheet.write_text("savefig.dpi: 100\n")
    values = ["friction", "lugre", "--plot", str(tmp_path / "law.png")]
    assert main([*values, "--width", "column", "--style", str(sheet)]) == 0
    high, wide = matplotlib.image.imread(tmp_path / "law.png").shape[:2]
    assert wide == 340
    assert main([*values, "--width", "column", "--style", str(sheet), "--no-header"]) == 0
    assert matplotlib.image.imread(tmp_path / "law.png").shape[0] < high
    (tmp_path / "other.mplstyle").write_text("no setting\n")
    wrong = {"--width": "colum", "--style": str(tmp_path / "other.mplstyle")}
    for option, value in wrong.items():
        capsys.readouterr()
        assert option in refused(capsys, *values, option, value)
    assert matplotlib.rcParams["savefig.dpi"] != 100


@pytest.mark.parametrize("width", ["colum", 0.3, -7, float("nan"), None.__class__])
def test_a_width_that_is_none_is_refused(width):
    with pytest.raises(ArgumentError, match=r"width:? should be \"column\", \"page\" or a number of inches"):
        vc.figure(vc.LuGre(), width=width)
