"""Draws travel.png, the picture of the README: one period of the reference motion, and its travel.

    python docs/images/travel.py

The machine is that of examples/travels-by-stick-slip.toml. The smoothed contacts are those of
docs/why-not-solve-ivp.md: the same equations with sgn(v) rounded off to tanh(v/eps), integrated at tight tolerances.
"""

import math
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.patches import BoxStyle, Circle, FancyBboxPatch
from scipy.integrate import solve_ivp

import vibrocap as vc
from vibrocap.motion.trajectory import BACK, FORWARD, STUCK
from vibrocap.plotting.histories import Trace
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.style import BLUE, GREEN, VERMILION

PERIODS = 40
FRAMES = (0.0, 0.14, 0.235, 0.43, 0.55, 0.75, 1.0)  # instants of the last period, in periods
CONTACT = {STUCK: ("#7A7A7A", "sticks"), FORWARD: (GREEN, "slips forward"), BACK: (VERMILION, "slips back")}
GREY = "#404040"
MINUS = "\N{MINUS SIGN}"  # as on the axes


def reference_motion() -> vc.Trajectory:
    """The motion of the paper's first set on exponential friction."""
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    return vc.simulate(system, periods=PERIODS, initial={"angle": math.pi / 3}, tolerance=1e-10)


def smoothed_states(system: vc.System, width: float, times: np.ndarray) -> np.ndarray:
    """States at the given times with sgn(v) replaced by tanh(v/width)."""

    def rates(t, y):
        y = y.tolist()
        force = math.tanh(y[3] / width) * system.friction.steady_force(abs(y[3]), system.machine.loads()[0])
        return system.machine.rates(t, y, system.drive.value(t), (force,))

    start = [math.pi / 3, 0.0, 0.0, 0.0]
    return solve_ivp(rates, (0.0, times[-1]), start, "LSODA", t_eval=times, rtol=1e-9, atol=1e-11).y


def draw_machine(axes, x: float, angle: float, side: int, moved: float) -> None:
    """The capsule with its pendulum at a place of the strip, its contact coloured, how far it has moved below."""
    colour, words = CONTACT[side]
    shape = BoxStyle("round", pad=0, rounding_size=0.12)
    body = FancyBboxPatch((x - 0.42, 0.0), 0.84, 0.34, boxstyle=shape, facecolor="#DCE6EF", edgecolor=GREY)
    bob = x - math.sin(angle), 0.34 + math.cos(angle)
    axes.add_patch(body)
    axes.plot([x - 0.36, x + 0.36], [-0.02, -0.02], color=colour, linewidth=5, solid_capstyle="butt", zorder=3)
    axes.plot([x, bob[0]], [0.34, bob[1]], color=GREY, linewidth=2.0, zorder=4)
    axes.add_patch(Circle(bob, 0.12, facecolor=BLUE, edgecolor=GREY, zorder=5))
    axes.plot([x], [0.34], marker="o", markersize=4.5, color="white", markeredgecolor=GREY, zorder=6)
    axes.text(x, -0.17, words, ha="center", va="top", fontsize=8.5, color=colour, weight="bold")
    axes.text(x, -0.42, f"{moved:+.3f}".replace("-", MINUS), ha="center", va="top", fontsize=8, color=GREY)


def draw_strip(axes, motion: vc.Trajectory, start: float) -> None:
    """The machine at a few instants of the last period."""
    axes.set_axis_off()
    axes.set_aspect("equal")
    axes.plot([-0.9, 1.75 * len(FRAMES) - 0.85], [-0.05, -0.05], color=GREY, linewidth=1.0)
    for number, share in enumerate(FRAMES):
        t = start + share * motion.period
        angle, moved = motion.at(t, "angle")[0], motion.at([start, t], "position")
        draw_machine(axes, 1.75 * number, angle, int(motion.at(t, "side")[0]), moved[1] - moved[0])
    axes.set(xlim=(-1.0, 1.75 * len(FRAMES) - 0.75), ylim=(-0.62, 1.55))
    title = r"One drive period: the pendulum swings, the contact slips and sticks (below: moved so far, in $l$)"
    axes.set_title(title)


def draw_velocity(axes, motion: vc.Trajectory, start: float) -> None:
    """Capsule velocity over the last period, its stick phases shaded, the frames of the strip marked."""
    trace = Trace(motion, start, motion.end)
    share = (trace.time - start) / motion.period
    velocity, side = trace["velocity"], trace["side"]
    axes.axhline(0.0, color="#808080", linewidth=0.7, zorder=1)
    for phase in motion.phases:
        if phase.side == STUCK and phase.end > start:
            axes.axvspan(
                (phase.start - start) / motion.period, (phase.end - start) / motion.period, **plots.STICK_SHADE
            )
    for chosen, (colour, words) in CONTACT.items():
        held = np.where(side == chosen, velocity, np.nan)
        axes.plot(share, held, color=colour, linewidth=2.2, label=words, zorder=3)
    marks = start + np.array(FRAMES) * motion.period
    axes.plot(FRAMES, motion.at(marks, "velocity"), "o", color="black", markersize=3.5, zorder=5)
    axes.set(title="Capsule velocity", xlabel=r"time in the period $\tau/T$", ylabel=r"velocity $X'$")
    plots.legend(axes, loc="upper center")


def draw_travel(axes, motion: vc.Trajectory) -> None:
    """Travel over the whole run, exact and with the contact smoothed."""
    times = np.linspace(0.0, motion.end, 64 * PERIODS + 1)
    periods = times / motion.period
    exact = motion.at(times, "position")
    lines = [("exact", exact, BLUE, 2.0, "-")]
    for width, colour, dashes in ((1e-3, GREEN, (0, (5, 1.5))), (1e-2, VERMILION, (0, (2, 1.2)))):
        found = smoothed_states(motion.system, width, times)[2]
        error = 100.0 * (found[-1] / exact[-1] - 1.0)
        words = f"{error:+.0f} %".replace("-", MINUS)
        lines.append((rf"$\tanh(v/{width:g})$: {words}", found, colour, 1.3, dashes))
    for label, found, colour, width, dashes in lines:
        axes.plot(periods, found, color=colour, linewidth=width, linestyle=dashes, label=label)
    axes.set(title="Travel, contact exact and smoothed", xlabel=r"drive periods $\tau/T$", ylabel="position $X$")
    plots.legend(axes, loc="upper left")


def main() -> None:
    """Write travel.png beside this file."""
    motion = reference_motion()
    start = motion.end - motion.period
    figure = plots.blank_figure((9.2, 5.2))
    grid = figure.add_gridspec(2, 2, height_ratios=(1.0, 1.45), width_ratios=(1.15, 1.0))
    with matplotlib.rc_context(plots.STYLE):
        draw_strip(figure.add_subplot(grid[0, :]), motion, start)
        draw_velocity(figure.add_subplot(grid[1, 0]), motion, start)
        draw_travel(figure.add_subplot(grid[1, 1]), motion)
        figure.savefig(Path(__file__).with_name("travel.png"), dpi=130)


if __name__ == "__main__":
    main()
