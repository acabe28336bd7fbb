"""Draws travel.webp, the film of the README: the machine of travel.png, its contact solved exactly and smoothed.

    python docs/images/film.py

It shows the last four of the forty periods of travel.png. Both machines begin at a mark on the ground.
"""

import io
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image
from travel import BACK, BLUE, FORWARD, GREY, VERMILION, draw_machine, plots, reference_motion, smoothed_states

PERIODS, SECONDS, RATE = 4, 10, 15  # shown, in so long, by so many pictures a second
WIDTH = 1e-2  # of the smoothed contact
SHARES = np.linspace(0.0, 1.0, SECONDS * RATE)  # of the film
Machine = tuple[str, str, np.ndarray, np.ndarray, np.ndarray]  # title, colour, angle, way since the mark, side


def machines() -> list[Machine]:
    """Both machines at the instants of the film."""
    motion = reference_motion()
    times = motion.end - (1.0 - SHARES) * PERIODS * motion.period
    exact = (motion.at(times, name) for name in ("angle", "position", "side"))
    angle, _, position, velocity = smoothed_states(motion.system, WIDTH, times)
    smoothed = angle, position, np.where(velocity > 0.0, FORWARD, BACK)
    rows = ("Contact solved exactly", BLUE, exact), (rf"Contact smoothed: $\tanh(v/{WIDTH:g})$", VERMILION, smoothed)
    return [(title, colour, angle, position - position[0], side) for title, colour, (angle, position, side) in rows]


def picture(at: int, shown: list[Machine]) -> Image.Image:
    """One picture of the film: the machines, and below them how far they have come."""
    figure = plots.blank_figure((7.2, 4.0))
    grid = figure.add_gridspec(2, 2, height_ratios=(1.5, 1.0))
    below = figure.add_subplot(grid[1, :])
    ways = [way for _, _, _, way, _ in shown]
    hindmost, furthest = np.min(ways), np.max(ways)
    for place, (title, colour, angle, way, side) in enumerate(shown):
        above = figure.add_subplot(grid[0, place])
        above.set_axis_off()
        above.set_aspect("equal")
        above.plot([hindmost - 1.3, furthest + 1.3], [-0.05, -0.05], color=GREY, linewidth=1.0)
        above.vlines(np.arange(-1.4, furthest + 1.3, 0.2), -0.1, -0.05, color=GREY, linewidth=0.7)
        above.vlines([0.0], -0.1, 1.5, color=GREY, linewidth=0.8, linestyle=(0, (2, 2)))
        draw_machine(above, way[at], angle[at], int(side[at]), way[at])
        above.set(xlim=(hindmost - 1.3, furthest + 1.3), ylim=(-0.62, 1.5))
        above.set_title(title, color=colour)
        periods = PERIODS * SHARES[: at + 1]
        below.plot(periods, way[: at + 1], color=colour, linewidth=2.0)
        below.plot(periods[-1:], way[at : at + 1], "o", color=colour, markersize=5, clip_on=False)
    below.set(xlim=(0.0, PERIODS), ylim=(1.1 * hindmost, 1.1 * furthest))
    below.set(xlabel=r"drive periods $\tau/T$", ylabel="travel, in $l$")
    drawn = io.BytesIO()
    figure.savefig(drawn, format="png", dpi=100)
    return Image.open(drawn).convert("RGB")


def main() -> None:
    """Write travel.webp beside this file."""
    with matplotlib.rc_context(plots.STYLE):
        shown = machines()
        first, *others = [picture(at, shown) for at in range(len(SHARES))]
    place = Path(__file__).with_name("travel.webp")
    first.save(place, save_all=True, append_images=others, duration=1000 // RATE, loop=0, lossless=True, method=6)


if __name__ == "__main__":
    main()
