"""Data of Figs 9-11 once more, under the dynamic load: travel, and runs that the load ends."""

from collections.abc import Callable

import numpy as np

from vibrocap.motion.trajectory import Trajectory
from vibrocap.paper.averages import STEADY_WINDOW, averages, period_length, window_name
from vibrocap.paper.figures.figure import Curve, Ending, Figure, Panel
from vibrocap.paper.figures.load_motion import LOADS, PALE
from vibrocap.paper.figures.motion import history, plane
from vibrocap.paper.presets import DISPLACEMENT_MASS_RATIOS, SHORT, figures_9_to_11, with_load
from vibrocap.paper.runs import LAST, SHOWN_PERIODS, LoadedRun, Runs

RISEN = 6  # periods in Fig. 10
WANDERED = 20  # periods in Fig. 11


def figure_load_9(runs: Runs) -> Figure:
    """Average velocity over the mass ratio: of the transient, of the steady state, and of light capsules."""
    window = window_name(SHOWN_PERIODS)
    transient = _pale(runs, window) + _strong(runs, lambda run: run.mean_velocity(period_length(), SHOWN_PERIODS))
    steady = _pale(runs, STEADY_WINDOW) + _strong(runs, lambda run: run.mean_velocity(period_length(), LAST, True))
    light = _strong(runs, lambda run: run.mean_velocity(period_length(), SHOWN_PERIODS), light=True)
    ends, light_ends = _endings(runs), _endings(runs, light=True)
    near = (-0.002, 0.002)
    return Figure(
        "load09",
        "Average velocity over the mass ratio, under the dynamic load",
        f"As Fig. 9 (h 1.8, omega 1, rho 4, nu 1.2). Pale: N = 1, as printed; strong: the load that the motion makes. "
        f"(a, b) averages over the first {SHOWN_PERIODS} periods, of a transient. (c) the steady state. (d) light "
        "capsules. Marks at the foot: runs that the load ended.",
        (
            Panel("(a) averages of the transient", "mass_ratio", "mean_velocity", transient, endings=ends),
            Panel("(b) the same, enlarged", "mass_ratio", "mean_velocity", transient, y_limits=near, endings=ends),
            Panel(
                f"(c) steady state (last {LAST} of 150)", "mass_ratio", "mean_velocity", steady, y_limits=near,
                endings=ends,
            ),
            Panel("(d) the transient of light capsules", "mass_ratio", "mean_velocity", light, endings=light_ends),
        ),
        one_legend=True,
    )  # fmt: skip


def figure_load_10(runs: Runs) -> Figure:
    """Pendulum phase planes, capsule velocity and load over time, at three mass ratios."""
    planes, histories, loads = [], [], []
    for ratio in DISPLACEMENT_MASS_RATIOS:
        motions, title = _motions(runs, ratio), f"λ = {ratio:g}"
        by_law = motions.items()
        curves = tuple(plane(motion, SHORT[name], RISEN, *_look(name, load)) for (name, load), motion in by_law)
        planes.append(Panel(f"{title}: pendulum", "angle", "angle_rate", curves))
        curves = _histories(motions, "velocity", RISEN)
        histories.append(Panel(f"{title}: capsule velocity", "time", "velocity", curves, y_limits=(-0.35, 0.42)))
        dynamic = {key: motion for key, motion in motions.items() if key[1] == "dynamic"}
        loads.append(Panel(f"{title}: load N", "time", "reaction", _histories(dynamic, "reaction", RISEN), zero=True))
    return Figure(
        "load10",
        "Phase planes, velocity of the capsule and its load, under the dynamic load",
        "As Fig. 10: the first six drive periods. Pale: N = 1, as printed; strong: the load of the motion, "
        "which the last row shows.",
        (*planes, *histories, *loads),
        columns=3,
        one_legend=True,
    )


def figure_load_11(runs: Runs) -> Figure:
    """Displacement over time at three mass ratios."""
    panels = []
    for ratio in DISPLACEMENT_MASS_RATIOS:
        curves = _histories(_motions(runs, ratio), "position", WANDERED)
        panels.append(Panel(f"λ = {ratio:g}", "time", "position", curves, y_limits=(-0.4, 0.55)))
    return Figure(
        "load11",
        "Displacement of the capsule, under the dynamic load",
        "As Fig. 11: the first twenty drive periods. Pale: N = 1, as printed; strong: the load that the motion makes.",
        tuple(panels),
        columns=3,
        one_legend=True,
    )


def _motions(runs: Runs, ratio: float) -> dict[tuple[str, float | str], Trajectory]:
    """Both laws under both loads, at a mass ratio."""
    systems = {(name, load): with_load(figures_9_to_11(name, ratio), load) for load in LOADS for name in SHORT}
    return {key: runs.motion(system) for key, system in systems.items()}


def _histories(motions: dict[tuple[str, float | str], Trajectory], quantity: str, periods: int) -> tuple[Curve, ...]:
    by_law = motions.items()
    return tuple(history(motion, SHORT[name], quantity, periods, *_look(name, load)) for (name, load), motion in by_law)


def _look(name: str, load: float | str) -> tuple[str, float]:
    """Label and weight of a curve."""
    words, weight = LOADS[load]
    return f"{SHORT[name]}, {words}", weight


def _pale(runs: Runs, window: str) -> tuple[Curve, ...]:
    """The averages under N = 1, of Fig. 9."""
    return tuple(
        Curve(_look(name, 1.0)[0], SHORT[name], runs.sweep(name).mass_ratio, averages(runs, name)[window], PALE)
        for name in SHORT
    )


def _strong(runs: Runs, average: Callable[[LoadedRun], float], light: bool = False) -> tuple[Curve, ...]:
    """Averages of the runs that went to their end."""
    curves = []
    for name, short in SHORT.items():
        done = [run for run in runs.loaded_sweep(name, light) if run.status.ok]
        ratios, values = np.array([run.mass_ratio for run in done]), np.array([average(run) for run in done])
        curves.append(Curve(_look(name, "dynamic")[0], short, ratios, values))
    return tuple(curves)


def _endings(runs: Runs, light: bool = False) -> tuple[Ending, ...]:
    """The runs that did not go to their end, by law and status."""
    endings = []
    for name, short in SHORT.items():
        ended = [run for run in runs.loaded_sweep(name, light) if not run.status.ok]
        for status in sorted({run.status.value for run in ended}):
            listed = [run for run in ended if run.status.value == status]
            place, time = np.array([run.mass_ratio for run in listed]), np.array([run.end for run in listed])
            endings.append(Ending(f"{short}: {status}", short, place, time))
    return tuple(endings)
