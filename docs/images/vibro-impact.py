"""Draws vibro-impact.png, the picture of docs/machines.md: where the vibro-impact capsule goes forward and where back.

    python docs/images/vibro-impact.py

Steady drift over the drive's frequency and the gap, of motions from rest. The curve of zero progression and that of
grazing, beyond which the mass does not reach its stop, are lines of the map; `vibrocap crossing` gives their points to
rounding.
"""

from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes

import vibrocap as vc
from vibrocap.plotting import style as plots

FREQUENCIES, GAPS = np.linspace(0.5, 1.5, 241), np.linspace(0.0, 3.0, 241)
STRONG = 1.6  # drift per period at which the colours end
WORDS = ((0.62, 1.55, "back", "white"), (1.12, 1.2, "forward", "white"), (0.575, 2.7, "no impact", "#404040"))


def steady_drift() -> tuple[np.ndarray, np.ndarray]:
    """(drift per period, largest displacement of the mass less the gap), arrays [gaps, frequencies]."""
    friction = vc.Coulomb(coulomb_coefficient=1.0, static_coefficient=1.0)
    system = vc.System(vc.VibroImpactCapsule(), friction, vc.Harmonic(amplitude=1.6))
    frequency, gap = np.meshgrid(FREQUENCIES, GAPS)
    found = vc.ensemble(
        system,
        {"drive.frequency": frequency.ravel(), "machine.gap": gap.ravel()},
        measures=["drift", "largest_displacement"],
        periods=400,
        settle=1e-6,
        tolerance=1e-7,
    )
    return found["drift"].reshape(gap.shape), found["largest_displacement"].reshape(gap.shape) - gap


def draw(ax: Axes, drift: np.ndarray, reach: np.ndarray) -> None:
    """The map, its two kinds of curve, and what happens where."""
    colours = ax.pcolormesh(FREQUENCIES, GAPS, drift, cmap="RdBu", vmin=-STRONG, vmax=STRONG, rasterized=True)
    moving = np.where(reach > 0.0, drift, np.nan)  # without impacts nothing travels
    lines = {"zero progression": (moving, plots.BLACK, "-"), "grazing of the stop": (reach, plots.VERMILION, "--")}
    for name, (values, colour, style) in lines.items():
        ax.contour(FREQUENCIES, GAPS, values, [0.0], colors=[colour], linewidths=1.6, linestyles=[style])
        ax.plot([], [], color=colour, linestyle=style, linewidth=1.6, label=name)
    for x, y, words, colour in WORDS:
        ax.text(x, y, words, color=colour, ha="center", fontsize=9)
    ax.set(xlabel=r"drive frequency $\omega$", ylabel=r"gap $\delta$", title="Drift of the vibro-impact capsule")
    ax.figure.colorbar(colours, ax=ax, label="drift per period", extend="both")
    ax.legend(loc="lower right", fontsize=8)


def main() -> None:
    """Write vibro-impact.png beside this file."""
    figure, axes = plots.figure(1, 1, size=(7.0, 4.4))
    with matplotlib.rc_context(plots.STYLE):
        draw(axes[0][0], *steady_drift())
        figure.savefig(Path(__file__).with_name("vibro-impact.png"), dpi=130)


if __name__ == "__main__":
    main()
