"""Data of Figs 5, 7, 10 and 11: motions over time and phase planes."""

import dataclasses

import numpy as np

from vibrocap.motion.trajectory import Trajectory
from vibrocap.paper.figures.figure import Curve, Figure, Panel
from vibrocap.paper.presets import DISPLACEMENT_MASS_RATIOS, SHORT, figures_9_to_11
from vibrocap.paper.runs import Runs

PRINTED_FIRST = "lambda 2.5, rho 2, nu 1; h 1.8 and omega 1, which are not printed, are those of Figs 9-11"
SHOWN = 8  # periods in Fig. 5
FORCES = ("friction", "reaction")  # which jump
SYMBOL = {"angle": "θ", "angle_rate": "θ′", "position": "X", "velocity": "X′"}


def history(
    motion: Trajectory, role: str, quantity: str, periods: float, label: str = "", weight: float = 1.0
) -> Curve:
    """A quantity over the first periods of a motion; jumps of forces stand upright."""
    time = np.linspace(0.0, periods * motion.period, round(300 * periods) + 1)
    if quantity in FORCES:
        time = np.unique(np.concatenate((time, around_events(motion, periods * motion.period))))
    return Curve(label or role, role, time, motion.at(time, quantity), weight)


def plane(motion: Trajectory, role: str, periods: int, label: str = "", weight: float = 1.0) -> Curve:
    """The phase plane of the pendulum over the first periods of a motion."""
    time = np.linspace(0.0, periods * motion.period, 300 * periods + 1)
    return Curve(label or role, role, motion.at(time, "angle"), motion.at(time, "angle_rate"), weight)


def around_events(motion: Trajectory, end: float) -> np.ndarray:
    """Instants just before and after each event until then."""
    times = motion.event_times[(motion.event_times > 0.0) & (motion.event_times < end)]
    return np.concatenate((times - 1e-9, times + 1e-9))


def figure_5(runs: Runs) -> Figure:
    """theta, theta', X, X' over time."""
    panels = []
    for letter, quantity in zip("abcd", SYMBOL, strict=True):
        curves = tuple(history(runs.first_set(name), SHORT[name], quantity, SHOWN) for name in SHORT)
        panels.append(Panel(f"({letter}) {SYMBOL[quantity]}", "time", quantity, curves))
    em = runs.first_set("exponential")
    window = ((SHOWN - 1) * em.period, SHOWN * em.period)
    rests = tuple((p.start, p.end) for p in em.phases if p.side == 0 and window[0] < p.start < window[1])
    for letter, whole, limits in (("e", panels[2], None), ("f", panels[3], (-0.12, 0.12))):
        title = f"({letter}) {SYMBOL[whole.y]}, enlarged; shaded: EM sticks"
        panels.append(dataclasses.replace(whole, title=title, spans=rests, x_limits=window, y_limits=limits))
    return Figure(
        "fig05",
        "Motion with LM and EM",
        f"The first eight drive periods from the paper's start ({PRINTED_FIRST}). (e, f) the last of them: where EM "
        "rests, LM creeps on.",
        tuple(panels),
    )


def figure_7(runs: Runs) -> Figure:
    """Phase planes of the pendulum and of the capsule, one settled period."""
    pendulum, capsule = [], []
    for name, short in SHORT.items():
        period = runs.steady(name)
        pendulum.append(Curve(short, short, period["angle"][::8], period["angle_rate"][::8], arrows=(0.1, 0.6)))
        position, velocity = (period["position"] - period["position"][0])[::8], period["velocity"][::8]
        label = f"{short} (gap = drift {period.drift:.3f})"
        capsule.append(Curve(label, short, position, velocity, arrows=(0.2, 0.45, 0.85)))
    return Figure(
        "fig07",
        "Phase planes",
        f"One settled drive period ({PRINTED_FIRST}); X counts from its start. The gap in (b) is the travel of the "
        "period: modulo X both motions are exactly periodic.",
        (
            Panel("(a) pendulum", "angle", "angle_rate", tuple(pendulum)),
            Panel("(b) capsule", "position", "velocity", tuple(capsule)),
        ),
    )


def figure_10(runs: Runs) -> Figure:
    """Pendulum phase planes and capsule velocity over time, at three mass ratios."""
    planes, histories = [], []
    for ratio in DISPLACEMENT_MASS_RATIOS:
        motions = {SHORT[name]: runs.motion(figures_9_to_11(name, ratio)) for name in SHORT}
        curves = tuple(plane(motion, short, 6) for short, motion in motions.items())
        planes.append(Panel(f"λ = {ratio:g}: pendulum", "angle", "angle_rate", curves))
        curves = tuple(history(motion, short, "velocity", 6) for short, motion in motions.items())
        title = f"λ = {ratio:g}: capsule velocity"
        histories.append(Panel(title, "time", "velocity", curves, y_limits=(-0.35, 0.42)))
    return Figure(
        "fig10",
        "Phase planes of the pendulum and velocity of the capsule",
        "The first six drive periods (h 1.8, omega 1, rho 4, nu 1.2). After the transient forward and backward "
        "velocity peaks are equal.",
        (*planes, *histories),
        columns=3,
    )


def figure_11(runs: Runs) -> Figure:
    """Displacement over time at three mass ratios."""
    panels = []
    for ratio in DISPLACEMENT_MASS_RATIOS:
        motions = {SHORT[name]: runs.motion(figures_9_to_11(name, ratio)) for name in SHORT}
        curves = tuple(history(motion, short, "position", 20) for short, motion in motions.items())
        panels.append(Panel(f"λ = {ratio:g}", "time", "position", curves, y_limits=(-0.4, 0.55)))
    return Figure(
        "fig11",
        "Displacement of the capsule",
        "The first twenty drive periods (h 1.8, omega 1, rho 4, nu 1.2). X gains or loses something in the transient "
        "and then swings about a fixed place.",
        tuple(panels),
        columns=3,
    )
