"""Data of Figs 3, 6 and 8: the friction force."""

from collections.abc import Sequence

import numpy as np

from vibrocap.measures.recorded.friction_loop import friction_curve
from vibrocap.paper.figures.figure import Curve, Mark, Panel, figure
from vibrocap.paper.figures.motion import around_events
from vibrocap.paper.presets import SHORT
from vibrocap.paper.runs import AMPLITUDE, MEAN, Runs, imposed_cycle
from vibrocap.physics.friction.bristles import LuGre

SHOWN = 4  # periods in Fig. 6
SLIDING = "LM in pure sliding, $X' = 0.1 + 0.05\\,\\sin\\tau$"
FORCES = (  # panels of Fig. 6: title, law, quantity
    ("(a) bristle deflection, LM", "lugre", "bristle"),
    ("(b) friction force, LM", "lugre", "friction"),
    ("(c) friction force, EM", "exponential", "friction"),
)
DAMPINGS = (10.0, 1.0)  # delta1: as printed, and one for which the paper's words hold


@figure(
    "fig03",
    "Reversible and non-reversible friction",
    "Friction against an imposed velocity, from the laws. Accelerating and decelerating take different ways; "
    "in pure sliding the loop is clockwise, as the paper draws it, for delta1 = 1 (right), but not for the printed "
    "delta1 = 10 (left), for which it turns round above v* = 0.0405.",
)
def figure_3(runs: Runs) -> Sequence[Panel]:
    loops, excesses = [], []
    for damping in DAMPINGS:
        friction = LuGre(bristle_damping=damping)
        speeds = np.linspace(0.0, 0.35, 176)
        steady = np.array([friction.steady_force(float(v), 1.0) for v in speeds])
        swing, swung = (values[::4] for values in imposed_cycle(friction, 0.0, 0.3))
        velocity, force = (values[::4] for values in imposed_cycle(friction, MEAN, AMPLITUDE))
        excess = force - np.array([friction.steady_force(float(v), 1.0) for v in velocity])
        name = _named(damping)
        both_ways, odd = (np.concatenate((-values[::-1], values)) for values in (speeds, steady))
        reversal = (0.02, 0.045, 0.45, 0.505, 0.545, 0.95)
        curves = (
            Curve("reversible: steady friction (11)", "steady", both_ways, odd),
            Curve("non-reversible: LM, $X' = 0.3\\,\\sin\\tau$", "EM", swing, swung, arrows=reversal),
            Curve(SLIDING, "sliding", velocity, force),
        )
        loops.append(Panel(name, "velocity", "friction", curves))
        curve = Curve(SLIDING, "sliding", velocity, excess, arrows=(0.1, 0.3, 0.6, 0.8))
        title = f"{name}: pure sliding, off the steady curve"
        excesses.append(Panel(title, "velocity", "excess", (curve,), y_limits=(-0.024, 0.024)))
    return (*loops, *excesses)


@figure(
    "fig06",
    "Bristle deflection and friction force over time",
    "The first four drive periods from the paper's start (lambda 2.5, rho 2, nu 1; h 1.8 and omega 1, which are "
    "not printed, are those of Figs 9-11).",
    columns=1,
)
def figure_6(runs: Runs) -> Sequence[Panel]:
    panels = []
    for title, name, quantity in FORCES:
        motion = runs.first_set(name)
        end = SHOWN * motion.period
        time = np.unique(np.concatenate((np.linspace(0.0, end, 3000), around_events(motion, end))))
        curve = Curve(SHORT[name], SHORT[name], time, motion.at(time, quantity))
        panels.append(Panel(title, "time", quantity, (curve,)))
    return panels


@figure(
    "fig08",
    "Friction near zero velocity",
    "The settled period. Arrows: direction of the LM loop; dots: M1, forward and back. As printed "
    "(left) the pure-sliding loop runs anticlockwise and the largest force exceeds N eta_s = 0.45; with delta1 = 1 "
    "(right) it runs clockwise.",
)
def figure_8(runs: Runs) -> Sequence[Panel]:
    panels = []
    for letter, damping in zip("ab", DAMPINGS, strict=True):
        period = runs.steady("lugre", bristle_damping=damping)
        loop = period.loop
        lm, em = friction_curve(period.motion), friction_curve(runs.steady("exponential").motion)
        # one curve: no hysteresis. Side by side, so that no line crosses the jump but the one upright at rest
        order = [i for i in np.lexsort((em.friction, em.velocity, em.side)) if em.side[i] != 0]
        marks = tuple(
            Mark(label, side.escape.velocity, side.escape.friction)
            for label, side in (("$M_1$", loop.forward), ("", loop.back))
            if side is not None and side.escape is not None
        )
        width = np.array([-0.3, 0.3])
        curves = (
            *(Curve(r"$\pm N\eta_s$", "limit", width, np.full(2, sign * 0.45)) for sign in (1, -1)),
            Curve("EM", "EM", em.velocity[order], em.friction[order]),
            Curve("LM", "LM", lm.velocity, lm.friction, arrows=_arrows(lm.velocity, lm.friction)),
        )
        title = rf"({letter}) {_named(damping)}"
        panel = Panel(title, "velocity", "friction", curves, marks, x_limits=(-0.22, 0.26), y_limits=(-0.54, 0.56))
        panels.append(panel)
    return panels


def _named(damping: float) -> str:
    return rf"$\delta_1 = {damping:g}$" + (" (as printed)" if damping == DAMPINGS[0] else "")


def _arrows(velocity: np.ndarray, friction: np.ndarray) -> tuple[float, ...]:
    """Where arrows go: evenly along the part of the loop that is shown, by drawn length."""
    shown = np.abs(velocity) < 0.2
    length = np.hypot(np.diff(velocity) / 0.4, np.diff(friction) / 0.9) * shown[1:]
    along = np.concatenate(([0.0], np.cumsum(length)))
    count = 14
    places = np.searchsorted(along, (np.arange(count) + 0.5) / count * along[-1])
    return tuple(float(place) / (velocity.size - 1) for place in places)
