"""What came after the paper: where settled motions travel, over mass ratio and spring, and where travel is born.

The map has two loads, the printed one and that of the motion. The diagram of branches follows one capsule over its
spring, unstable motions included. Both are of the exponential law (EM), on which compiling takes less time than on LM.
"""

import dataclasses

import numpy as np

from vibrocap.measures.ensemble import ensemble
from vibrocap.motion.status import Status
from vibrocap.motion.trust import Trust, residue
from vibrocap.orbits.continuation.branch_diagram import BranchDiagram, branches
from vibrocap.paper.presets import MASS_RATIOS, SHORT, figures_5_to_8, figures_9_to_11, start, with_load

STIFFNESSES = (0.01, 4.5)
POINTS = 40  # along each axis of the map
PERIODS, SETTLE, TOLERANCE = 600, 1e-6, 5e-8
FOLLOWED = (1.45, 4.0)  # stiffness of the diagram of branches
FRICTION = "exponential"
LOADS: tuple[float | str, ...] = (1.0, "dynamic")


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyPanel:
    """Settled motions of one law under one load. Arrays [mass ratio, stiffness]."""

    friction: str
    load: float | str
    residue: float  # mean velocities up to this are no travel
    mean_velocity: np.ndarray
    status: np.ndarray  # index into list(Status)
    settled: np.ndarray
    least_load: np.ndarray  # of the true load; negative: a constant load hides a lift-off

    @property
    def finished(self) -> np.ndarray:
        """Runs that went to their end."""
        return self.status == list(Status).index(Status.FINISHED)

    @property
    def travelling(self) -> float:
        """Share of all runs that have settled and travel."""
        direction = Trust(self.status, self.settled, self.residue).direction(self.mean_velocity)
        return float(np.mean(np.abs(np.nan_to_num(direction))))

    @property
    def ended(self) -> dict[str, int]:
        """How many runs did not go to their end, by status."""
        statuses = list(Status)
        codes, counts = np.unique(self.status[~self.finished], return_counts=True)
        return {statuses[int(code)].value: int(count) for code, count in zip(codes, counts, strict=True)}

    @property
    def hidden(self) -> int:
        """Runs to whose end a constant load hid that the true one was negative."""
        return int(np.sum(self.finished & (self.least_load < 0.0)))


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyTravel:
    """The map, a panel for each load, and the diagram of branches."""

    mass_ratio: np.ndarray
    stiffness: np.ndarray
    panels: tuple[SteadyPanel, ...]
    branches: BranchDiagram


def steady_panel(friction: str, load: float | str, mass_ratio: np.ndarray, stiffness: np.ndarray) -> SteadyPanel:
    """Settled motions from the paper's start, over a grid of mass ratios and stiffnesses."""
    system = with_load(figures_9_to_11(friction), load)
    ratios, springs = np.meshgrid(mass_ratio, stiffness, indexing="ij")
    measured = ensemble(
        system,
        {"machine.mass_ratio": ratios.ravel(), "machine.stiffness": springs.ravel()},
        measures=("mean_velocity", "least_reaction"),
        initial=start(system),
        periods=PERIODS,
        settle=SETTLE,
        tolerance=TOLERANCE,
    )
    names = ("mean_velocity", "status", "settled", "least_reaction")
    columns = (measured[name].reshape(ratios.shape) for name in names)
    return SteadyPanel(SHORT[friction], load, residue(system, "mean_velocity", SETTLE), *columns)


def steady_travel() -> SteadyTravel:
    """The map and the diagram."""
    mass_ratio, stiffness = np.linspace(*MASS_RATIOS, POINTS), np.linspace(*STIFFNESSES, POINTS)
    panels = tuple(steady_panel(FRICTION, load, mass_ratio, stiffness) for load in LOADS)
    followed = figures_5_to_8(FRICTION)
    diagram = branches(followed, "machine.stiffness", FOLLOWED, initial=start(followed))
    return SteadyTravel(mass_ratio, stiffness, panels, diagram)
