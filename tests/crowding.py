"""What overlaps or is cut off in a figure."""

import itertools

from matplotlib.axes import Axes
from matplotlib.legend import Legend
from matplotlib.text import Text


def texts_of(fig):
    """All texts of a figure that are seen."""
    hidden = set()
    for ax in fig.findobj(Axes):
        for axis in (ax.xaxis, ax.yaxis):
            shown = {id(box) for box in axis.get_ticklabels()}
            low, high = sorted(axis.get_view_interval())
            room = 1e-9 * (high - low)
            for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]:
                out = not low - room <= tick.get_loc() <= high + room
                hidden |= {id(label) for label in (tick.label1, tick.label2) if out or id(label) not in shown}
    for text in fig.findobj(Text):
        if text.get_visible() and text.get_text().strip() and id(text) not in hidden:
            yield text


def crowded(figure):
    """Pairs of texts, legends or panels that overlap, legends over data, flat panels, axes without two numbers, and
    texts cut off by the edge of the figure."""
    figure.set_dpi(300)  # as it is printed
    figure.draw_without_rendering()
    boxes = [(text.get_text(), text.get_window_extent()) for text in texts_of(figure)]
    pairs = [(a, b) for (a, box), (b, other) in itertools.combinations(boxes, 2) if box.padded(-1).overlaps(other)]
    panels = [(ax.get_title(loc="left") or ax.get_ylabel(), ax.get_window_extent()) for ax in figure.findobj(Axes)]
    pairs += [(a, b) for (a, box), (b, other) in itertools.combinations(panels, 2) if box.padded(-1).overlaps(other)]
    pairs += [(a, "is flat") for a, box in panels if box.width * box.height < 0.15 * figure.dpi**2]
    for legend in figure.findobj(Legend):
        own, box = {text.get_text() for text in legend.get_texts()}, legend.get_window_extent().padded(-1)
        pairs += [("a legend", a) for a, other in boxes if a not in own and box.overlaps(other)]
    for ax in figure.findobj(Axes):
        if legend := ax.get_legend():
            box = legend.get_window_extent().padded(-2)
            inside = [line for line in ax.lines if _within(box, line.get_transform().transform(line.get_xydata()))]
            pairs += [("a legend", f"over the data of {ax.get_title(loc='left')}")] * bool(inside)
        for axis in (ax.xaxis, ax.yaxis):
            numbers = [tick.label1 for tick in axis._update_ticks() if tick.label1.get_visible()]
            room = [number.get_window_extent().padded(3) for number in numbers if number.get_text()]  # 0.7 points
            pairs += [("numbers touch", axis.label.get_text()) for a, b in itertools.pairwise(room) if a.overlaps(b)]
            if len(numbers) == 1 and numbers[0].get_text():
                pairs += [("one number", ax.get_title(loc="left") or axis.label.get_text())]
    edge = figure.bbox.padded(1.0)
    cut = [a for a, box in boxes if not (edge.containsx(box.x0) and edge.containsx(box.x1))]
    return pairs + cut + [a for a, box in boxes if not (edge.containsy(box.y0) and edge.containsy(box.y1))]


def _within(box, points):
    """Whether any of some points lies in a box."""
    return any(box.contains(x, y) for x, y in points)
