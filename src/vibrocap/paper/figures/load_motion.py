"""Data of Figs 5-8 once more, under the dynamic load: motions, phase planes and friction."""

import numpy as np

from vibrocap.measures.recorded.friction_loop import friction_curve
from vibrocap.motion.trajectory import Trajectory
from vibrocap.paper.figures.figure import Curve, Figure, Panel
from vibrocap.paper.figures.motion import PRINTED_FIRST, SHOWN, SYMBOL, history
from vibrocap.paper.presets import SHORT, figures_5_to_8, with_load
from vibrocap.paper.runs import SHOWN_PERIODS, Runs

PALE = 0.25  # how strongly the curves of the printed load are drawn
LOADS: dict[float | str, tuple[str, float]] = {1.0: ("N = 1", PALE), "dynamic": ("dynamic load", 1.0)}
FRICTION_SHOWN = 4  # periods in Fig. 6
LETTERS = "abcd"


def figure_load_5(runs: Runs) -> Figure:
    """theta, theta', X, X' over time, the load, and where the capsule gets to."""
    panels = [
        Panel(f"({letter}) {SYMBOL[quantity]}", "time", quantity, _histories(runs, quantity, SHOWN))
        for letter, quantity in zip(LETTERS, SYMBOL, strict=True)
    ]
    dynamic = [
        history(_motion(runs, name, "dynamic"), SHORT[name], "reaction", SHOWN, f"{SHORT[name]}, dynamic load")
        for name in SHORT
    ]
    shown = np.array([0.0, dynamic[0].x[-1]])
    printed = Curve("N = 1, as printed", "limit", shown, np.ones(2))
    return Figure(
        "load05",
        "Motion with LM and EM, under the dynamic load",
        f"As Fig. 5 ({PRINTED_FIRST}). Pale: N = 1, as printed; strong: the load that the motion makes, with its mean "
        "lambda + 1. (e) that load; it would lift off at zero. (f) all forty periods.",
        (
            *panels,
            Panel("(e) load N", "time", "reaction", (printed, *dynamic), zero=True),
            Panel("(f) X, forty periods", "time", "position", _histories(runs, "position", SHOWN_PERIODS)),
        ),
        one_legend=True,
    )


def figure_load_6(runs: Runs) -> Figure:
    """Bristle deflection and friction over time."""
    panels = tuple(
        Panel(title, "time", quantity, _histories(runs, quantity, FRICTION_SHOWN, (name,)))
        for title, name, quantity in (
            ("(a) bristle deflection, LM", "lugre", "bristle"),
            ("(b) friction force, LM", "lugre", "friction"),
            ("(c) friction force, EM", "exponential", "friction"),
        )
    )
    return Figure(
        "load06",
        "Bristle deflection and friction force over time, under the dynamic load",
        "As Fig. 6. Pale: N = 1, as printed; strong: the load that the motion makes.",
        panels,
        columns=1,
        one_legend=True,
    )


def figure_load_7(runs: Runs) -> Figure:
    """Phase planes of the pendulum and of the capsule, one settled period."""
    pendulum, capsule = [], []
    for load, (words, weight) in LOADS.items():
        for name, short in SHORT.items():
            period = runs.steady(name, load=load)
            arrows = (0.1, 0.6) if weight == 1.0 else ()
            label = f"{short}, {words}"
            pendulum.append(Curve(label, short, period["angle"][::8], period["angle_rate"][::8], weight, arrows))
            position = period["position"] - period["position"][0]
            capsule.append(Curve(label, short, position[::8], period["velocity"][::8], weight))
    return Figure(
        "load07",
        "Phase planes, under the dynamic load",
        "As Fig. 7: one settled drive period; X counts from its start. Pale: N = 1, as printed, with a gap of the "
        "travel of the period; strong: the load that the motion makes.",
        (
            Panel("(a) pendulum", "angle", "angle_rate", tuple(pendulum)),
            Panel("(b) capsule", "position", "velocity", tuple(capsule)),
        ),
        one_legend=True,
    )


def figure_load_8(runs: Runs) -> Figure:
    """Friction against velocity in the settled period: under N = 1, and under the dynamic load."""
    panels = []
    for letter, (load, (words, _)) in zip(LETTERS, LOADS.items(), strict=False):
        curves = []
        for name in ("exponential", "lugre"):
            points = friction_curve(runs.steady(name, load=load).motion)
            curves.append(Curve(SHORT[name], SHORT[name], points.velocity, points.friction))
        panels.append(Panel(f"({letter}) {words}", "velocity", "friction", tuple(curves)))
    return Figure(
        "load08",
        "Friction over velocity, under the dynamic load",
        "The settled period, whole. (a) N = 1, as printed: EM is one curve. (b) the load that the motion makes: EM, "
        "which has no memory, draws a loop as well, because the load has changed when a velocity comes again.",
        tuple(panels),
    )


def _motion(runs: Runs, name: str, load: float | str) -> Trajectory:
    return runs.motion(with_load(figures_5_to_8(name), load))


def _histories(runs: Runs, quantity: str, periods: int, names: tuple[str, ...] = tuple(SHORT)) -> tuple[Curve, ...]:
    """A quantity over time under both loads."""
    return tuple(
        history(_motion(runs, name, load), SHORT[name], quantity, periods, f"{SHORT[name]}, {words}", weight)
        for load, (words, weight) in LOADS.items()
        for name in names
    )
