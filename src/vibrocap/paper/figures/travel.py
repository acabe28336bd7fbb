"""Data of Fig. 9 and of the figure on the half-period symmetry, which explains it."""

import numpy as np

from vibrocap.paper.averages import STEADY_WINDOW, averages, period_length, window_name
from vibrocap.paper.figures.figure import Curve, Figure, Mark, Panel
from vibrocap.paper.presets import SHORT, figures_5_to_8, figures_9_to_11
from vibrocap.paper.runs import LAST, Runs, last_period
from vibrocap.paper.steady_points import PRINTED

SHOWN_WINDOWS = {window_name(1): 0.3, window_name(5): 0.5, window_name(10): 0.7, window_name(40): 1.0}
SOFT_SPRINGS = {0.55: 0.4, 0.58: 1.0, 0.62: 0.6}  # rho, and how strongly it is drawn

SYMMETRIC_RATIO = 0.8


def figure_9(runs: Runs) -> Figure:
    """Average velocity over the mass ratio: averaging windows, the steady state, and a softer spring."""
    windows, steady, soft = [], [], []
    for name, short in SHORT.items():
        ratios, curves = runs.sweep(name).mass_ratio, averages(runs, name)
        for window, weight in SHOWN_WINDOWS.items():
            windows.append(Curve(f"{short}, {window}", short, ratios, curves[window], weight))
        steady.append(Curve(f"{short}, steady (last {LAST} of 150)", short, ratios, curves[STEADY_WINDOW]))
    for stiffness, weight in SOFT_SPRINGS.items():
        for name, short in SHORT.items():
            sweep = runs.sweep(name, stiffness)
            velocity = -sweep.mean_velocity(period_length(), LAST, last=True)
            soft.append(Curve(f"{short}, ρ = {stiffness:g}", short, sweep.mass_ratio, velocity, weight))
    marks = tuple(Mark(f"${letter}_{number}$", PRINTED[letter + number]) for letter, number in ("P1", "O2", "O1", "P2"))
    near = (-0.012, 0.022)
    return Figure(
        "fig09",
        "Average velocity over the mass ratio",
        "h 1.8, omega 1, nu 1.2. (a, b) rho = 4, as printed: averages over the first periods, of a transient (the "
        "paler, the shorter); vertical lines: the printed points. (c) the steady state: zero for every lambda. (d) for "
        "comparison only, a softer spring, for which the upright pendulum buckles: steady averages of the mirror twin, "
        "with the printed shape; no one stiffness gives all four printed points.",
        (
            Panel("(a) averages of the transient", "mass_ratio", "mean_velocity", tuple(windows), marks),
            Panel("(b) the same, enlarged", "mass_ratio", "mean_velocity", tuple(windows), marks, y_limits=near),
            Panel("(c) steady state", "mass_ratio", "mean_velocity", tuple(steady), marks, y_limits=near),
            Panel("(d) soft springs (not the paper's), steady", "mass_ratio", "mean_velocity", tuple(soft), marks),
        ),
    )


def figure_symmetry(runs: Runs) -> Figure:
    """The half-period symmetry: a motion that is its own mirror image, one that is not, and what each travels."""
    panels = []
    cases = (("Figs 9-11, λ = 0.8", figures_9_to_11("lugre", SYMMETRIC_RATIO)), ("Figs 5-8", figures_5_to_8("lugre")))
    for letter, (title, system) in zip("ab", cases, strict=True):
        period = last_period(runs.motion(system, 200), samples=1024)
        phase, velocity = period.time[:-1] / period.motion.period, period["velocity"][:-1]
        image = -np.roll(velocity, -velocity.size // 2)
        curves = (
            Curve("$X'(\\tau)$", "LM", phase, velocity),
            Curve("mirror image, $-X'(\\tau + T/2)$", "twin", phase, image),
        )
        panels.append(Panel(f"({letter}) {title}: settled velocity, LM", "phase", "velocity", curves))
    for letter, (title, system) in zip("cd", cases, strict=True):
        curves = []
        for label, role, twin in (("motion", "LM", False), ("mirror twin", "twin", True)):
            motion = runs.motion(system, twin=twin)
            time = np.linspace(0.0, 15 * motion.period, 3001)
            curves.append(Curve(label, role, time, motion.at(time, "position")))
        panels.append(Panel(f"({letter}) {title}: position, LM", "time", "position", tuple(curves)))
    return Figure(
        "symmetry",
        "The half-period symmetry",
        "Left: at the parameters of Fig. 9 the settled motion is its own mirror image, so that what it gains in one "
        "half of the period it loses in the other: its drift is exactly zero. Right: at the parameters of Figs 5-8 the "
        "motion has lost the symmetry and travels; its mirror twin travels exactly the other way.",
        tuple(panels),
    )
