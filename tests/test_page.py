"""Figures for print: fitted to a width, in the user's own settings, with nothing cut off and no text over another."""

import itertools

import matplotlib
import matplotlib.image
import numpy as np
import pytest

import vibrocap as vc
from vibrocap.arguments import ArgumentError
from vibrocap.cli.main import main
from vibrocap.plotting.finishing import texts_of

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
BELT = vc.System(
    vc.Oscillator(damping=0.1, belt_speed=1.5), vc.Exponential(0.5, 1.0, 2.0), vc.Constant(duration=2.0 * np.pi)
)
WIDTHS = {"column": 3.4, "page": 7.0}
PLANE = {"angle": (-3.0, 3.0), "angle_rate": (-3.0, 3.0)}
AXES = {"machine.mass_ratio": np.linspace(1.0, 4.0, 6), "drive.amplitude": np.linspace(1.0, 3.0, 5)}
RESULTS = {
    "motion": lambda: vc.simulate(SYSTEM, periods=6, initial={"angle": 1.0}),
    "crawler": lambda: vc.simulate(vc.System(vc.TwoBodyCrawler(), vc.Coulomb(), vc.Harmonic()), periods=4),
    "orbit": lambda: vc.orbit(SYSTEM, initial={"angle": 1.0}),
    "branches": lambda: vc.branches(SYSTEM, "drive.amplitude", (1.2, 1.4), initial={"angle": 1.0}),
    "equilibria": lambda: vc.equilibrium_branch(BELT, "machine.belt_speed", (0.5, 2.5)),
    "basins": lambda: vc.basins(SYSTEM, PLANE, 12),
    "basins of a block": lambda: vc.basins(BELT, {"position": (-2, 2), "sliding_velocity": (-1.5, 0.5)}, 12),
    "diagram": lambda: vc.bifurcation_diagram(BELT, "machine.belt_speed", (1.4, 1.6), 5, starts=2, settle_periods=60),
    "law": vc.LuGre,
    "sheet": lambda: vc.test_sheet(vc.LuGre()),
    "map": lambda: vc.sweep(SYSTEM, AXES, settle=1e-5),
    "lines": lambda: vc.sweep(SYSTEM, {"machine.mass_ratio": [1.0, 2.0, 3.0]}, settle=1e-5),
}


@pytest.fixture(scope="module")
def motion():
    return RESULTS["motion"]()


def crowded(figure):
    """Pairs of texts that overlap, and texts that are cut off by the edge of the figure."""
    figure.draw_without_rendering()
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts_of(figure)]
    pairs = [(a, b) for (a, box), (b, other) in itertools.combinations(boxes, 2) if box.padded(-1).overlaps(other)]
    edge = figure.bbox.padded(1.0)
    cut = [a for a, box in boxes if not (edge.containsx(box.x0) and edge.containsx(box.x1))]
    return pairs + cut + [a for a, box in boxes if not (edge.containsy(box.y0) and edge.containsy(box.y1))]


def test_a_motion_fits_a_column(motion):
    figure = vc.figure(motion, width="column")
    assert figure.get_figwidth() == WIDTHS["column"]
    assert crowded(figure) == []
    for part in figure.subfigs:
        assert all(ax.get_window_extent().height > 0.6 * figure.dpi for ax in part.axes)
    figure.set_figwidth(0.6 * WIDTHS["column"])  # planted: the same figure squeezed is noticed
    assert crowded(figure)


@pytest.mark.slow
@pytest.mark.parametrize("kind", RESULTS)
def test_every_kind_of_picture_fits_a_column_and_a_page(kind):
    result = RESULTS[kind]()
    for (width, size), header in itertools.product(WIDTHS.items(), (True, False)):
        figure = vc.figure(result, width=width, header=header)
        assert figure.get_figwidth() == size
        assert crowded(figure) == [], (width, header)
        assert not [t for t in texts_of(figure) if t in (figure._suptitle, figure._supxlabel) and not header]


def test_a_caption_takes_the_place_of_the_header():
    assert any("LuGre" in text.get_text() for text in texts_of(vc.figure(vc.LuGre(), width="column")))
    bare = vc.figure(vc.LuGre(), width="column", header=False)
    assert not any("LuGre" in text.get_text() or "units" in text.get_text() for text in texts_of(bare))


def test_the_users_settings_hold_over_those_of_the_package(motion):
    with matplotlib.rc_context({"font.size": 6.0, "font.family": "DejaVu Serif", "axes.grid": False}):
        label = vc.plot(motion).xaxis.label
        figure = vc.figure(vc.LuGre(), width="column")
    assert label.get_fontfamily() == ["DejaVu Serif"]
    assert all("DejaVu Serif" in text.get_fontfamily() for text in texts_of(figure))
    assert vc.plot(motion).xaxis.label.get_fontfamily() == ["DejaVu Sans"]


def test_letters_of_a_pdf_are_outlines_of_a_font_that_journals_take(tmp_path):
    vc.figure(vc.LuGre(), tmp_path / "one.pdf", width="column")
    file = (tmp_path / "one.pdf").read_bytes()
    assert b"/Subtype /Type3" not in file
    assert b"/FontFile2" in file


def test_the_command_line_takes_a_width_and_a_style_sheet(tmp_path, capsys):
    sheet = tmp_path / "journal.mplstyle"
    sheet.write_text("savefig.dpi: 100\n")
    given = ["friction", "show", "lugre", "--plot", str(tmp_path / "law.png")]
    assert main([*given, "--width", "column", "--style", str(sheet)]) == 0
    high, wide = matplotlib.image.imread(tmp_path / "law.png").shape[:2]
    assert wide == 340
    assert main([*given, "--width", "column", "--style", str(sheet), "--no-header"]) == 0
    assert matplotlib.image.imread(tmp_path / "law.png").shape[0] < high
    (tmp_path / "other.mplstyle").write_text("no setting\n")
    wrong = {"--width": "colum", "--style": str(tmp_path / "other.mplstyle")}
    for option, value in wrong.items():
        capsys.readouterr()
        assert main([*given, option, value]) == 2
        assert option in capsys.readouterr().err
    assert matplotlib.rcParams["savefig.dpi"] != 100


@pytest.mark.parametrize("width", ["colum", 0.3, -7, float("nan"), None.__class__])
def test_a_width_that_is_none_is_refused(width):
    with pytest.raises(ArgumentError, match=r"width:? should be \"column\", \"page\" or a number of inches"):
        vc.figure(vc.LuGre(), width=width)
