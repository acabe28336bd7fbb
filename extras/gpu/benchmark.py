"""`python extras/gpu/benchmark.py [runs]`: a sweep on the GPU beside the same runs on all cores of the processor.

The capsule of `named_sweeps` over its mass ratio and the amplitude of its drive, 40 drive periods each. Neighbours of a
grid are alike, so threads that work together have about the same steps; in random order they have not. The error of
both devices is measured on runs drawn from the sweep. Times are those of a whole call, upload and results included,
after one that compiles. Where no GPU can be used it says why and ends.
"""

import math
import statistics
import sys
import time

import numpy as np
from vibrocap_gpu.driver import first_gpu, gpu_problem
from vibrocap_gpu.ensemble import gpu_ensemble_run

import vibrocap as vc
from benchmarks.named_sweeps import SWEEP_SET
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.run.budget import Budget, EnsembleStart
from vibrocap.numerics.run.ensemble import ensemble_run

RUNS = 1_000_000
PERIODS = 40
TOLERANCE, TIGHT = 1e-7, 1e-11
SAMPLE = 2_000  # runs whose error is measured
REPEATS = 3


def sweep_of(law, runs: int, shuffled: bool = True):
    """(equations, parameters, initial): a grid over mass ratio and amplitude, in random order or row by row."""
    machine = vc.PendulumCapsule(stiffness=SWEEP_SET.stiffness, damping=SWEEP_SET.damping)
    system = vc.System(machine, law, vc.Harmonic(amplitude=SWEEP_SET.amplitude))
    recorded = equations(system)
    parameters = np.tile(parameter_values(system), (runs, 1))
    side = math.isqrt(runs - 1) + 1
    place = np.random.default_rng(1).permutation(side * side)[:runs]
    place = place if shuffled else np.sort(place)
    for path, low, high, step in (
        ("machine.mass_ratio", 0.01, 8.1, place % side),
        ("drive.amplitude", 0.3, 3.0, place // side),
    ):
        parameters[:, recorded.parameter_paths.index(path)] = np.linspace(low, high, side)[step]
    initial = np.zeros((runs, len(recorded.rates)))
    initial[:, 0] = math.pi / 3
    return recorded, parameters, initial


def budget(tolerance: float) -> Budget:
    """Every run to its end, the last ten periods measured."""
    return Budget(PERIODS, tolerance, 10_000, 50_000_000, window=10)


def seconds_of(run, sweep) -> float:
    """Median of some runs of a sweep, after one that compiles."""

    def call() -> None:
        run(*sweep, budget(TOLERANCE))

    call()
    times = []
    for _ in range(REPEATS):
        started = time.perf_counter()
        call()
        times.append(time.perf_counter() - started)
    return statistics.median(times)


def compare(law, runs: int) -> None:
    """One table: sweeps of growing size on the GPU and on the processor, then the errors of a sample."""
    print(f"\n{type(law).__name__}: runs of {PERIODS} periods, tolerance {TOLERANCE:g}, seconds")
    print(f"  {'runs':>9s}{'GPU, random':>14s}{'GPU, grid':>12s}{'processor':>12s}")
    sizes = [size for size in (1_000, 10_000, 100_000, 1_000_000) if size < runs]
    for size in (*sizes, runs):
        random, grid = sweep_of(law, size), sweep_of(law, size, shuffled=False)
        times = [seconds_of(gpu_ensemble_run, sweep) for sweep in (random, grid)]
        times.append(seconds_of(ensemble_run, random))
        print(f"  {size:9d}{times[0]:14.3f}{times[1]:12.3f}{times[2]:12.3f}", flush=True)
    few = sweep_of(law, min(SAMPLE, runs))
    results = gpu_ensemble_run(EnsembleStart(*few), budget(TOLERANCE))
    same, exact = (ensemble_run(EnsembleStart(*few), budget(tolerance)) for tolerance in (TOLERANCE, TIGHT))
    errors = np.abs(results.state - exact.state).max(axis=1)
    apart = np.quantile(np.abs(results.state - same.state).max(axis=1), 0.99)
    agree = np.mean(results.status == same.status)
    print(f"  of {len(errors)} runs {np.mean(errors <= 1e-6):.1%} are within 1e-6 of tight ones,")
    print(f"  99 % within {apart:.1e} of the processor's; {agree:.2%} of the statuses are the processor's")


def main() -> None:
    """Both laws, or why not."""
    problem = gpu_problem()
    if problem is not None:
        print(f"Not measured: {problem}")
        return
    gpu = first_gpu()
    major, minor = (gpu.attribute(f"COMPUTE_CAPABILITY_{part}") for part in ("MAJOR", "MINOR"))
    multiprocessors = gpu.attribute("MULTIPROCESSOR_COUNT")
    print(f"{gpu.name}, {multiprocessors} multiprocessors, compute capability {major}.{minor}")
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else RUNS
    compare(vc.Exponential(), runs)
    compare(vc.LuGre(), runs)


if __name__ == "__main__":
    main()
