"""Data of Figs 5-11 once more, under the dynamic load: motions, friction, travel, and runs that the load ends."""

from collections.abc import Callable, Sequence

import numpy as np

from vibrocap.measures.recorded.friction_loop import friction_curve
from vibrocap.paper.figures.figure import Curve, Ending, Panel, figure
from vibrocap.paper.figures.motion import (
    FORCES,
    FRICTION_SHOWN,
    LOADS,
    PALE,
    PRINTED_FIRST,
    RISEN,
    SHOWN,
    SYSTEMS,
    displacements,
    histories,
    look,
    over_time,
    risen,
)
from vibrocap.paper.presets import SHORT, figures_5_to_8
from vibrocap.paper.runs import LAST, SHOWN_PERIODS, LoadedRun, Runs
from vibrocap.paper.travel import PERIOD, STEADY_WINDOW, averages, window_name

LOADED = (1.0, "dynamic")


@figure(
    "load05",
    "Motion with LM and EM, under the dynamic load",
    f"As Fig. 5 ({PRINTED_FIRST}). Pale: N = 1, as printed; strong: the load that the motion makes, with its mean "
    "lambda + 1. (e) that load; it would lift off at zero. (f) all forty periods.",
    one_legend=True,
)
def figure_load_5(runs: Runs) -> Sequence[Panel]:
    dynamic = histories(runs, figures_5_to_8, "reaction", SHOWN, LOADED[1:])
    shown = np.array([0.0, dynamic[0].x[-1]])
    printed = Curve("N = 1, as printed", "limit", shown, np.ones(2))
    forty = histories(runs, figures_5_to_8, "position", SHOWN_PERIODS, LOADED)
    return (
        *over_time(runs, LOADED),
        Panel("(e) load N", "time", "reaction", (printed, *dynamic), zero=True),
        Panel("(f) X, forty periods", "time", "position", forty),
    )


@figure(
    "load06",
    "Bristle deflection and friction force over time, under the dynamic load",
    "As Fig. 6. Pale: N = 1, as printed; strong: the load that the motion makes.",
    columns=1,
    one_legend=True,
)
def figure_load_6(runs: Runs) -> Sequence[Panel]:
    return [
        Panel(title, "time", quantity, histories(runs, figures_5_to_8, quantity, FRICTION_SHOWN, LOADED, (name,)))
        for title, name, quantity in FORCES
    ]


@figure(
    "load07",
    "Phase planes, under the dynamic load",
    "As Fig. 7: one settled drive period; X counts from its start. Pale: N = 1, as printed, with a gap of the "
    "travel of the period; strong: the load that the motion makes.",
    one_legend=True,
)
def figure_load_7(runs: Runs) -> Sequence[Panel]:
    pendulum, capsule = [], []
    for load in LOADED:
        for name, short in SHORT.items():
            period = runs.steady(name, load=load)
            (label, role), weight = look(short, load), LOADS[load][1]
            arrows = (0.1, 0.6) if weight == 1.0 else ()
            pendulum.append(Curve(label, role, period["angle"][::8], period["angle_rate"][::8], weight, arrows))
            position = period["position"] - period["position"][0]
            capsule.append(Curve(label, role, position[::8], period["velocity"][::8], weight))
    return (
        Panel("(a) pendulum", "angle", "angle_rate", tuple(pendulum)),
        Panel("(b) capsule", "position", "velocity", tuple(capsule)),
    )


@figure(
    "load08",
    "Friction over velocity, under the dynamic load",
    "The settled period, whole. (a) N = 1, as printed: EM is one curve. (b) the load that the motion makes: EM, "
    "which has no memory, draws a loop as well, because the load has changed when a velocity comes again.",
)
def figure_load_8(runs: Runs) -> Sequence[Panel]:
    panels = []
    for letter, load in zip("ab", LOADED, strict=True):
        curves = []
        for name in ("exponential", "lugre"):
            points = friction_curve(runs.steady(name, load=load).motion)
            curves.append(Curve(SHORT[name], SHORT[name], points.velocity, points.friction))
        panels.append(Panel(f"({letter}) {LOADS[load][0]}", "velocity", "friction", tuple(curves)))
    return panels


@figure(
    "load09",
    "Average velocity over the mass ratio, under the dynamic load",
    f"As Fig. 9 (h 1.8, omega 1, rho 4, nu 1.2). Pale: N = 1, as printed; strong: the load that the motion makes. "
    f"(a, b) averages over the first {SHOWN_PERIODS} periods, of a transient. (c) the steady state. (d) light "
    "capsules. Marks at the foot: runs that the load ended.",
    one_legend=True,
)
def figure_load_9(runs: Runs) -> Sequence[Panel]:
    window = window_name(SHOWN_PERIODS)
    transient = _pale(runs, window) + _strong(runs, lambda run: run.mean_velocity(PERIOD, SHOWN_PERIODS))
    steady = _pale(runs, STEADY_WINDOW) + _strong(runs, lambda run: run.mean_velocity(PERIOD, LAST, True))
    light = _strong(runs, lambda run: run.mean_velocity(PERIOD, SHOWN_PERIODS), light=True)
    ends, light_ends = _endings(runs), _endings(runs, light=True)
    near, last = (-0.002, 0.002), f"(c) steady state (last {LAST} of 150)"
    return (
        Panel("(a) averages of the transient", "mass_ratio", "mean_velocity", transient, endings=ends),
        Panel("(b) the same, enlarged", "mass_ratio", "mean_velocity", transient, y_limits=near, endings=ends),
        Panel(last, "mass_ratio", "mean_velocity", steady, y_limits=near, endings=ends),
        Panel("(d) the transient of light capsules", "mass_ratio", "mean_velocity", light, endings=light_ends),
    )


@figure(
    "load10",
    "Phase planes, velocity of the capsule and its load, under the dynamic load",
    "As Fig. 10: the first six drive periods. Pale: N = 1, as printed; strong: the load of the motion, "
    "which the last row shows.",
    columns=3,
    one_legend=True,
)
def figure_load_10(runs: Runs) -> Sequence[Panel]:
    loads = {ratio: histories(runs, system, "reaction", RISEN, LOADED[1:]) for ratio, system in SYSTEMS.items()}
    lower = (Panel(f"λ = {ratio:g}: load N", "time", "reaction", x, zero=True) for ratio, x in loads.items())
    return (*risen(runs, LOADED), *lower)


@figure(
    "load11",
    "Displacement of the capsule, under the dynamic load",
    "As Fig. 11: the first twenty drive periods. Pale: N = 1, as printed; strong: the load that the motion makes.",
    columns=3,
    one_legend=True,
)
def figure_load_11(runs: Runs) -> Sequence[Panel]:
    return displacements(runs, LOADED)


def _pale(runs: Runs, window: str) -> tuple[Curve, ...]:
    """The averages under N = 1, of Fig. 9."""
    return tuple(
        Curve(*look(SHORT[name], 1.0), runs.sweep(name).mass_ratio, averages(runs, name)[window], PALE)
        for name in SHORT
    )


def _strong(runs: Runs, average: Callable[[LoadedRun], float], light: bool = False) -> tuple[Curve, ...]:
    curves = []
    for name, short in SHORT.items():
        done = [run for run in runs.loaded_sweep(name, light) if run.status.ok]
        ratios, values = np.array([run.mass_ratio for run in done]), np.array([average(run) for run in done])
        curves.append(Curve(*look(short, "dynamic"), ratios, values))
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
