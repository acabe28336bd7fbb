"""Figures for print: fitted to a width, in the user's own settings, with nothing cut off and no text over another."""

import itertools

import matplotlib
import pytest

import vibrocap as vc
from vibrocap.plotting.fitted import texts_of

SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())


@pytest.fixture(scope="module")
def motion():
    return vc.simulate(SYSTEM, periods=6, initial={"angle": 1.0})


def crowded(figure):
    """Pairs of texts that overlap, and texts that are cut off by the edge of the figure."""
    figure.draw_without_rendering()
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts_of(figure)]
    pairs = [(a, b) for (a, box), (b, other) in itertools.combinations(boxes, 2) if box.padded(-1).overlaps(other)]
    edge = figure.bbox.padded(1.0)
    cut = [a for a, box in boxes if not (edge.containsx(box.x0) and edge.containsx(box.x1))]
    return pairs + cut + [a for a, box in boxes if not (edge.containsy(box.y0) and edge.containsy(box.y1))]


@pytest.mark.parametrize(("width", "size"), [("column", 3.4), ("page", 7.0)])
def test_a_motion_fits_a_column_and_a_page(motion, width, size):
    figure = vc.figure(motion, width=width)
    assert figure.get_figwidth() == size
    assert crowded(figure) == []
    for part in figure.subfigs:
        assert all(ax.get_window_extent().height > 0.6 * figure.dpi for ax in part.axes)
    figure.set_figwidth(0.6 * size)  # planted: the same figure squeezed is noticed
    assert crowded(figure)


def test_a_caption_takes_the_place_of_the_header(motion):
    assert any("Harmonic" in text.get_text() for text in texts_of(vc.figure(motion, width="column")))
    bare = vc.figure(motion, width="column", header=False)
    assert not any("Harmonic" in text.get_text() or "dimensionless" in text.get_text() for text in texts_of(bare))


def test_the_users_settings_hold_over_those_of_the_package(motion):
    with matplotlib.rc_context({"font.size": 6.0, "font.family": "DejaVu Serif", "axes.grid": False}):
        label = vc.plot(motion).xaxis.label
        figure = vc.figure(motion, width="column")
    assert label.get_fontfamily() == ["DejaVu Serif"]
    assert all("DejaVu Serif" in text.get_fontfamily() for text in texts_of(figure))
    assert vc.plot(motion).xaxis.label.get_fontfamily() == ["DejaVu Sans"]


def test_letters_of_a_pdf_are_outlines_of_a_font_that_journals_take(motion, tmp_path):
    vc.figure(motion, tmp_path / "one.pdf", width="column")
    file = (tmp_path / "one.pdf").read_bytes()
    assert b"/Subtype /Type3" not in file
    assert b"/FontFile2" in file


@pytest.mark.parametrize("width", ["colum", 0.3, -7, float("nan"), None.__class__])
def test_a_width_that_is_none_is_refused(motion, width):
    with pytest.raises(vc.ArgumentError, match=r"width:? should be \"column\", \"page\" or a number of inches"):
        vc.figure(motion, width=width)
