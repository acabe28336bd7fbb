"""Draws smoothing.png, the picture of docs/why-not-solve-ivp.md: what a smoothed contact gets wrong, and its price.

    python docs/images/smoothing.py

The machine is that of examples/travels-by-stick-slip.toml. The explicit solver is SciPy's DOP853, as on that page.
"""

import math
from pathlib import Path

import matplotlib
import numpy as np
from scipy.integrate import solve_ivp

import vibrocap as vc
from vibrocap.laboratory.regularisation import regularisation_error, width_for
from vibrocap.plotting.laboratory import draw_errors, draw_steps
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.style import BLACK

START = {"angle": math.pi / 3}
WIDTHS = np.logspace(-1, -7, 13)
EXPLICIT = WIDTHS[WIDTHS > 2e-6]  # below, it takes minutes


def explicit_steps(system: vc.System, width: float, end: float) -> int:
    """Steps of DOP853 with sgn(v) replaced by tanh(v/width)."""

    def rates(t, y):
        y = y.tolist()
        force = math.tanh(y[3] / width) * system.friction.steady_force(abs(y[3]), system.machine.loads()[0])
        return system.machine.rates(t, y, system.drive.value(t), (force,))

    return len(solve_ivp(rates, (0.0, end), [math.pi / 3, 0.0, 0.0, 0.0], "DOP853", rtol=1e-9, atol=1e-11).t) - 1


def main() -> None:
    """Write smoothing.png beside this file."""
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    reports = [regularisation_error(system, widths=WIDTHS, shape=shape, initial=START) for shape in ("tanh", "arctan")]
    needed = [width_for(system, error=0.01, shape=report.shape, initial=START) for report in reports]
    steps = [explicit_steps(system, width, 40 * system.drive.period) for width in EXPLICIT]
    figure, axes = plots.figure(1, 2, size=(9.2, 3.7))
    left, right = axes[0]
    with matplotlib.rc_context(plots.STYLE):
        draw_errors(left, reports, needed)
        left.set(title="Travel over 40 periods: error of a smoothed contact", ylim=(1e-5, 2.0), xlim=(7e-8, 0.15))
        for found, side in zip(needed, ("left", "right"), strict=True):
            words = rf"1 % at $\epsilon$ = {found.width:.0e}".replace("e-0", "e-")
            at = (found.width, 1.3e-5)
            left.annotate(words, at, (4 if side == "left" else -4, 0), textcoords="offset points", ha=side, fontsize=8)
        draw_steps(right, reports)
        label = r"$\tanh(v/\epsilon)$, SciPy's DOP853"
        right.loglog(EXPLICIT, steps, "s--", color=BLACK, markersize=3.5, label=label)
        right.set(ylim=(1.5e3, 1.5e5), xlim=(7e-8, 0.15))
        for ax in (left, right):
            plots.legend(ax, loc="upper left" if ax is left else "upper right")
        figure.savefig(Path(__file__).with_name("smoothing.png"), dpi=130)


if __name__ == "__main__":
    main()
