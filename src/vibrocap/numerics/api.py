"""The public face of the numerics: what the rest of the package calls.

- Record equations as graphs of `expressions`; of a law under an imposed motion: `DrivenEquations`.
- Run one motion: `recorded_run`. Run many, measured as they run: `ensemble_run`, with a tangent where the equations
  carry one; on a `device` of another package its `run`. Run a law under an imposed motion: `driven_runs`.
- Kernels for a page, in WebAssembly: `browser_kernels`, `browser_module`.
- One motion that its caller moves on, compiled or in C: `stepper_kernel`.
- What a run measures is measured of a stored motion by `replayed` and `Stroboscope`.

What comes back is a record with names: `Recorded`, `RunResults`, `DrivenRuns`. `codes` are the numbers by which a
kernel says why a run ended and of what kind an event is, and by which groups of measures are asked for.

What stands behind a name is imported when the name is asked for.
"""

from typing import TYPE_CHECKING

from vibrocap.lazy_imports import lazy

if TYPE_CHECKING:
    from vibrocap.numerics.codegen.driven_source import DrivenEquations
    from vibrocap.numerics.codegen.resolution import sharpness
    from vibrocap.numerics.codegen.source import Integrands, integrands_source
    from vibrocap.numerics.compiler.machine import code_made_for
    from vibrocap.numerics.kernel import codes
    from vibrocap.numerics.kernel.codes import DEFECT_BOUND, LONGEST_PERIOD, SLIVER
    from vibrocap.numerics.run.browser import BrowserKernel, browser_kernels, browser_module
    from vibrocap.numerics.run.budget import Budget, EnsembleStart, Form, MotionStart
    from vibrocap.numerics.run.driven_run import DrivenRuns, driven_runs
    from vibrocap.numerics.run.ensemble import available_threads, device, ensemble_run
    from vibrocap.numerics.run.motion import Recorded, recorded_run, series_order
    from vibrocap.numerics.run.replay import replayed
    from vibrocap.numerics.run.results import PieceSeries, RunResults
    from vibrocap.numerics.run.stepper import StepperKernel, StepperMemory, stepper_kernel
    from vibrocap.numerics.run.stored_motion import StoredMotion
    from vibrocap.numerics.run.stroboscope import Stroboscope

__all__ = [
    "DEFECT_BOUND",
    "LONGEST_PERIOD",
    "SLIVER",
    "BrowserKernel",
    "Budget",
    "DrivenEquations",
    "DrivenRuns",
    "EnsembleStart",
    "Form",
    "Integrands",
    "MotionStart",
    "PieceSeries",
    "Recorded",
    "RunResults",
    "StepperKernel",
    "StepperMemory",
    "StoredMotion",
    "Stroboscope",
    "available_threads",
    "browser_kernels",
    "browser_module",
    "code_made_for",
    "codes",
    "device",
    "driven_runs",
    "ensemble_run",
    "integrands_source",
    "recorded_run",
    "replayed",
    "series_order",
    "sharpness",
    "stepper_kernel",
]

if not TYPE_CHECKING:
    __getattr__ = lazy(__name__)
