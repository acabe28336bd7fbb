"""The door of the numerics: what the rest of the package calls. Expressions have their own (`expressions/`).

- Record equations as graphs of `expressions`; of a law under an imposed motion: `DrivenEquations`.
- Run one motion: `recorded_run`. Run many, measured as they run: `ensemble_run`, on a card `cuda_ensemble_run`; with a
  tangent where the equations carry one. Run a law under an imposed motion: `driven_runs`.
- What a run measures is measured of a stored motion by `replayed` and `Stroboscope`.

`memory` names the numbers in what comes back: why a run ended, kinds of event, groups of measures, places in a result.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from vibrocap.numerics.codegen.driven_source import DrivenEquations
from vibrocap.numerics.codegen.resolution import sharpness
from vibrocap.numerics.codegen.source import Integrands, ScalarWriter, integrands_source
from vibrocap.numerics.kernel import memory_layout as memory
from vibrocap.numerics.kernel.memory_layout import (
    ASK_EXTREMES,
    ASK_INTEGRALS,
    ASK_MAGNITUDE,
    ASK_PEAK,
    ASK_SYMMETRY,
    ASK_WORD,
    LETTERS_PER_PLACE,
    RESULT_HEAD,
    Layout,
)
from vibrocap.numerics.kernel.observe.settle import LONGEST_PERIOD
from vibrocap.numerics.run.driven_run import DrivenRuns, driven_runs
from vibrocap.numerics.run.ensemble import Budget, ensemble_run
from vibrocap.numerics.run.motion import Recorded, recorded_run
from vibrocap.numerics.run.replay import replayed
from vibrocap.numerics.run.stroboscope import Stroboscope
from vibrocap.numerics.run.threads import available_threads

if TYPE_CHECKING:
    import numpy as np

__all__ = [
    "ASK_EXTREMES",
    "ASK_INTEGRALS",
    "ASK_MAGNITUDE",
    "ASK_PEAK",
    "ASK_SYMMETRY",
    "ASK_WORD",
    "LETTERS_PER_PLACE",
    "LONGEST_PERIOD",
    "RESULT_HEAD",
    "Budget",
    "DrivenEquations",
    "DrivenRuns",
    "Integrands",
    "Layout",
    "Recorded",
    "ScalarWriter",
    "Stroboscope",
    "available_threads",
    "cuda_ensemble_run",
    "cuda_problem",
    "driven_runs",
    "ensemble_run",
    "integrands_source",
    "memory",
    "recorded_run",
    "replayed",
    "sharpness",
]


def cuda_problem() -> str | None:
    """Why ensembles cannot run on a graphics card here, and what was found; None if they can."""
    from vibrocap.numerics.run import cuda  # only here: it imports the kernels' arithmetic, and so LLVM

    return cuda.cuda_problem()


def cuda_ensemble_run(
    equations: Any,
    parameters: "np.ndarray",
    initial: "np.ndarray",
    budget: Budget,
    progress: Callable[[int], None] | None = None,
    integrands: Integrands | None = None,
) -> "tuple[Layout, np.ndarray]":
    """`ensemble_run` on the first graphics card; ValueError, saying what was found, where there is none."""
    from vibrocap.numerics.run import cuda

    return cuda.cuda_ensemble_run(equations, parameters, initial, budget, progress, integrands=integrands)
