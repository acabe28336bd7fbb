"""Data of Figs 3 to 11: motions, phase planes, friction, and Fig. 9 with the half-period symmetry behind it."""

import dataclasses
import functools
from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.measures.recorded.friction_loop import friction_curve
from vibrocap.motion.trajectory import Trajectory
from vibrocap.paper.figures.figure import Curve, Mark, Panel, figure
from vibrocap.paper.presets import DISPLACEMENT_MASS_RATIOS, SHORT, figures_5_to_8, figures_9_to_11, with_load
from vibrocap.paper.runs import AMPLITUDE, LAST, MEAN, Runs, imposed_cycle, last_period
from vibrocap.paper.travel import PERIOD, PRINTED, STEADY_WINDOW, averages, window_name
from vibrocap.physics.friction.bristles import LuGre
from vibrocap.physics.system import System

PRINTED_FIRST = "lambda 2.5, rho 2, nu 1; h 1.8 and omega 1, which are not printed, are those of Figs 9-11"
SHOWN, FRICTION_SHOWN, RISEN, WANDERED = 8, 4, 6, 20  # periods in Figs 5, 6, 10, 11
RISEN_LIMITS = -0.35, 0.42
JUMPING = ("friction", "reaction")  # forces
PALE = 0.25  # how strongly the curves of the printed load are drawn where there is another
# words of a load, and how strongly its curves are drawn; without a name where no other is shown
LOADS: dict[float | str, tuple[str, float]] = {"": ("", 1.0), 1.0: ("N = 1", PALE), "dynamic": ("dynamic load", 1.0)}
SYMBOL = {"angle": "θ", "angle_rate": "θ′", "position": "X", "velocity": "X′"}


def history(motion: Trajectory, role: str, quantity: str, periods: int, load: float | str = "") -> Curve:
    """A quantity over the first periods of a motion, named by its load; jumps of forces stand upright."""
    time = np.linspace(0.0, periods * motion.period, 300 * periods + 1)
    if quantity in JUMPING:
        time = np.unique(np.concatenate((time, around_events(motion, periods * motion.period))))
    return Curve(*look(role, load), time, motion.at(time, quantity), LOADS[load][1])


def histories(
    runs: Runs,
    system: Callable[[str], System],
    quantity: str,
    periods: int,
    loads: Sequence[float | str] = ("",),
    names: Sequence[str] = tuple(SHORT),
) -> tuple[Curve, ...]:
    """A quantity over the first periods, of each law under each load; without a name it is the printed one."""
    return tuple(
        history(runs.motion(with_load(system(name), load or 1.0)), SHORT[name], quantity, periods, load)
        for load in loads
        for name in names
    )


def planes(
    runs: Runs, system: Callable[[str], System], periods: int, loads: Sequence[float | str] = ("",)
) -> tuple[Curve, ...]:
    """The phase plane of the pendulum over the first periods, likewise."""
    both = (histories(runs, system, quantity, periods, loads) for quantity in ("angle", "angle_rate"))
    return tuple(dataclasses.replace(rate, x=angle.y) for angle, rate in zip(*both, strict=True))


def over_time(runs: Runs, loads: Sequence[float | str] = ("",)) -> list[Panel]:
    """Angle, place and their rates over the first periods of Figs 5-8."""
    return [
        Panel(f"({letter}) {symbol}", "time", quantity, histories(runs, figures_5_to_8, quantity, SHOWN, loads))
        for letter, (quantity, symbol) in zip("abcd", SYMBOL.items(), strict=True)
    ]


def look(role: str, load: float | str) -> tuple[str, str]:
    """Label and role of a curve."""
    return ", ".join(filter(None, (role, LOADS[load][0]))), role


def around_events(motion: Trajectory, end: float) -> np.ndarray:
    """Instants just before and after each event until then."""
    times = motion.event_times[(motion.event_times > 0.0) & (motion.event_times < end)]
    return np.concatenate((times - 1e-9, times + 1e-9))


@figure(
    "fig05",
    "Motion with LM and EM",
    f"The first eight drive periods from the paper's start ({PRINTED_FIRST}). (e, f) the last of them: where EM "
    "rests, LM creeps on.",
)
def figure_5(runs: Runs) -> Sequence[Panel]:
    panels = over_time(runs)
    em = runs.first_set("exponential")
    window = ((SHOWN - 1) * em.period, SHOWN * em.period)
    rests = tuple((p.start, p.end) for p in em.phases if p.side == 0 and window[0] < p.start < window[1])
    for letter, whole, limits in (("e", panels[2], None), ("f", panels[3], (-0.12, 0.12))):
        title = f"({letter}) {SYMBOL[whole.y]}, enlarged; shaded: EM sticks"
        panels.append(dataclasses.replace(whole, title=title, spans=rests, x_limits=window, y_limits=limits))
    return panels


@figure(
    "fig07",
    "Phase planes",
    f"One settled drive period ({PRINTED_FIRST}); X counts from its start. The gap in (b) is the travel of the "
    "period: modulo X both motions are exactly periodic.",
)
def figure_7(runs: Runs) -> Sequence[Panel]:
    pendulum, capsule = [], []
    for name, short in SHORT.items():
        period = runs.steady(name)
        pendulum.append(Curve(short, short, period["angle"][::8], period["angle_rate"][::8], arrows=(0.1, 0.6)))
        position, velocity = (period["position"] - period["position"][0])[::8], period["velocity"][::8]
        label = f"{short} (gap = drift {period.drift:.3f})"
        capsule.append(Curve(label, short, position, velocity, arrows=(0.2, 0.45, 0.85)))
    return (
        Panel("(a) pendulum", "angle", "angle_rate", tuple(pendulum)),
        Panel("(b) capsule", "position", "velocity", tuple(capsule)),
    )


@figure(
    "fig10",
    "Phase planes of the pendulum and velocity of the capsule",
    "The first six drive periods (h 1.8, omega 1, rho 4, nu 1.2). After the transient forward and backward "
    "velocity peaks are equal.",
    columns=3,
)
def figure_10(runs: Runs) -> Sequence[Panel]:
    return risen(runs)


SYSTEMS = {ratio: functools.partial(figures_9_to_11, mass_ratio=ratio) for ratio in DISPLACEMENT_MASS_RATIOS}


def risen(runs: Runs, loads: Sequence[float | str] = ("",)) -> tuple[Panel, ...]:
    """Phase planes of the pendulum at three mass ratios, and below them the velocity of the capsule."""
    upper, lower = [], []
    for ratio, system in SYSTEMS.items():
        upper.append(Panel(f"λ = {ratio:g}: pendulum", "angle", "angle_rate", planes(runs, system, RISEN, loads)))
        curves = histories(runs, system, "velocity", RISEN, loads)
        lower.append(Panel(f"λ = {ratio:g}: capsule velocity", "time", "velocity", curves, y_limits=RISEN_LIMITS))
    return (*upper, *lower)


def displacements(runs: Runs, loads: Sequence[float | str] = ("",)) -> tuple[Panel, ...]:
    """Displacement over time at three mass ratios."""
    curves = {ratio: histories(runs, system, "position", WANDERED, loads) for ratio, system in SYSTEMS.items()}
    return tuple(Panel(f"λ = {ratio:g}", "time", "position", x, y_limits=(-0.4, 0.55)) for ratio, x in curves.items())


@figure(
    "fig11",
    "Displacement of the capsule",
    "The first twenty drive periods (h 1.8, omega 1, rho 4, nu 1.2). X gains or loses something in the transient "
    "and then swings about a fixed place.",
    columns=3,
)
def figure_11(runs: Runs) -> Sequence[Panel]:
    return displacements(runs)


SHOWN_WINDOWS = {window_name(1): 0.3, window_name(5): 0.5, window_name(10): 0.7, window_name(40): 1.0}
SOFT_SPRINGS = {0.55: 0.4, 0.58: 1.0, 0.62: 0.6}  # rho, and how strongly it is drawn

SYMMETRIC_RATIO = 0.8


@figure(
    "fig09",
    "Average velocity over the mass ratio",
    "h 1.8, omega 1, nu 1.2. (a, b) rho = 4, as printed: averages over the first periods, of a transient (the "
    "paler, the shorter); vertical lines: the printed points. (c) the steady state: zero for every lambda. (d) for "
    "comparison only, a softer spring, for which the upright pendulum buckles: steady averages of the mirror image, "
    "with the printed shape; no one stiffness gives all four printed points.",
)
def figure_9(runs: Runs) -> Sequence[Panel]:
    windows, steady, soft = [], [], []
    for name, short in SHORT.items():
        ratios, curves = runs.sweep(name).mass_ratio, averages(runs, name)
        for window, weight in SHOWN_WINDOWS.items():
            windows.append(Curve(f"{short}, {window}", short, ratios, curves[window], weight))
        steady.append(Curve(f"{short}, steady (last {LAST} of 150)", short, ratios, curves[STEADY_WINDOW]))
    for stiffness, weight in SOFT_SPRINGS.items():
        for name, short in SHORT.items():
            sweep = runs.sweep(name, stiffness)
            velocity = -sweep.mean_velocity(PERIOD, LAST, last=True)
            soft.append(Curve(f"{short}, ρ = {stiffness:g}", short, sweep.mass_ratio, velocity, weight))
    marks = tuple(Mark(f"${letter}_{number}$", PRINTED[letter + number]) for letter, number in ("P1", "O2", "O1", "P2"))
    near = (-0.012, 0.022)
    return (
        Panel("(a) averages of the transient", "mass_ratio", "mean_velocity", tuple(windows), marks),
        Panel("(b) the same, enlarged", "mass_ratio", "mean_velocity", tuple(windows), marks, y_limits=near),
        Panel("(c) steady state", "mass_ratio", "mean_velocity", tuple(steady), marks, y_limits=near),
        Panel("(d) soft springs (not the paper's), steady", "mass_ratio", "mean_velocity", tuple(soft), marks),
    )


@figure(
    "symmetry",
    "The half-period symmetry",
    "Left: at the parameters of Fig. 9 the settled motion is its own mirror image, so that what it gains in one "
    "half of the period it loses in the other: its drift is exactly zero. Right: at the parameters of Figs 5-8 the "
    "motion has lost the symmetry and travels; its mirror-image solution travels exactly the other way.",
)
def figure_symmetry(runs: Runs) -> Sequence[Panel]:
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
        for label, role, twin in (("motion", "LM", False), ("mirror-image solution", "twin", True)):
            motion = runs.motion(system, twin=twin)
            time = np.linspace(0.0, 15 * motion.period, 3001)
            curves.append(Curve(label, role, time, motion.at(time, "position")))
        panels.append(Panel(f"({letter}) {title}: position, LM", "time", "position", tuple(curves)))
    return panels


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
        end = FRICTION_SHOWN * motion.period
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
