"""The pictures of what came after the paper: the map of steady travel, and the branches on which travel is born."""

import csv
import types
from pathlib import Path

import numpy as np

from vibrocap.files import replacing
from vibrocap.motion.trajectory import Status
from vibrocap.paper.steady_travel import PERIODS, STILL, SteadyPanel, SteadyTravel
from vibrocap.plotting.branches import branch_figure
from vibrocap.plotting.maps import plot_view
from vibrocap.plotting.study_view import Panel, View, ViewAxis
from vibrocap.plotting.style import save

TITLES = {"LM": "LM (LuGre)", "EM": "EM (exponential)"}


def draw_map(found: SteadyTravel, path: Path) -> Path:
    """The map into a file: mean velocity over mass ratio and spring, a panel for each load."""
    view = View(
        "mean_velocity",
        "of the settled motion",
        "1",
        "signed",
        STILL,
        (
            ViewAxis("machine.mass_ratio", found.mass_ratio, r"mass ratio $\lambda$"),
            ViewAxis("machine.stiffness", found.stiffness, r"spring $\rho$"),
        ),
        tuple(_panel(panel) for panel in found.panels),
        None,
        "h 1.8, omega 1, nu 1.2, the paper's friction and start",
        f"each run until it has settled, at most {PERIODS} periods",
    )
    return plot_view(view, path)


def _panel(panel: SteadyPanel) -> Panel:
    load = "N = 1, as printed" if panel.load == 1.0 else "dynamic load"
    least = types.SimpleNamespace(values=panel.least_load)
    return Panel(
        f"{TITLES[panel.friction]}, {load}",
        panel.mean_velocity,
        panel.status,
        panel.settled,
        {"least_reaction": least},
    )


def draw_branches(found: SteadyTravel, path: Path) -> Path:
    """The diagram of branches into a file."""
    return save(branch_figure(found.branches, "drift"), path)


def write_map(found: SteadyTravel, path: Path) -> None:
    """The runs of the map: a row for each, full precision."""
    statuses = list(Status)
    head = ("friction", "normal_load", "mass_ratio", "stiffness", "mean_velocity", "least_load", "settled", "status")
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(head)
        for panel in found.panels:
            for i, j in np.ndindex(panel.status.shape):
                place = repr(float(found.mass_ratio[i])), repr(float(found.stiffness[j]))
                values = repr(float(panel.mean_velocity[i, j])), repr(float(panel.least_load[i, j]))
                how = bool(panel.settled[i, j]), statuses[int(panel.status[i, j])].value
                writer.writerow((panel.friction, panel.load, *place, *values, *how))


def write_branches(found: SteadyTravel, path: Path) -> None:
    """The points of the branches: a row for each, full precision."""
    with replacing(path) as temporary, temporary.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(("branch", "stiffness", "drift", "stable"))
        for number, branch in enumerate(found.branches.branches):
            for place, drift, stable in zip(branch.parameter, branch.drift, branch.stable, strict=True):
                writer.writerow((number, repr(float(place)), repr(float(drift)), bool(stable)))
