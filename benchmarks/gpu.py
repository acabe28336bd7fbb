"""`python -m benchmarks.gpu [runs]`: a sweep on the GPU beside the same runs on the processor.

The capsule of `named_sweeps` over its mass ratio and the amplitude of its drive, 40 drive periods each, at a tolerance
at which 99 % of the runs end within 1e-6 of a tight one; that share is measured here on runs drawn from the sweep.
Times are those of a whole call, upload and results included, after one that compiles. Where no GPU can be used it
says why and ends.
"""

import math
import statistics
import sys
import time

import numpy as np

import vibrocap as vc
from benchmarks.named_sweeps import SWEEP_SET
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.run import cuda
from vibrocap.numerics.run.ensemble import Budget, ensemble_run

RUNS = 1_000_000
PERIODS = 40
TOLERANCE, TIGHT = 1e-7, 1e-11
SAMPLE = 2_000  # runs that the processor makes too
REPEATS = 3
RESIDENT = (128, 256, 512)  # threads per multiprocessor


def sweep_of(law, runs: int):
    """(equations, parameters, initial): a grid over mass ratio and amplitude, in random order."""
    machine = vc.PendulumCapsule(stiffness=SWEEP_SET.stiffness, damping=SWEEP_SET.damping)
    system = vc.System(machine, law, vc.Harmonic(amplitude=SWEEP_SET.amplitude))
    recorded = equations(system)
    parameters = np.tile(parameter_values(system), (runs, 1))
    side = math.isqrt(runs - 1) + 1
    place = np.random.default_rng(1).permutation(side * side)[:runs]
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
    return Budget(PERIODS, 10, 0.0, tolerance, 10_000, 50_000_000)


def seconds_of(call) -> float:
    """Median of some calls, after one that compiles."""
    call()
    times = []
    for _ in range(REPEATS):
        started = time.perf_counter()
        call()
        times.append(time.perf_counter() - started)
    return statistics.median(times)


def compare(law, runs: int) -> None:
    """One table: the GPU with several numbers of threads, then the processor on the sample."""
    recorded, parameters, initial = sweep_of(law, runs)
    sample = slice(0, min(SAMPLE, runs))
    few = recorded, parameters[sample], initial[sample]
    print(f"\n{type(law).__name__}: {runs} runs of {PERIODS} periods, tolerance {TOLERANCE:g}")
    print(f"  {'':32s}{'s':>9s}{'runs/s':>12s}{'ns/period':>11s}")

    def row(label: str, count: int, seconds: float) -> None:
        print(f"  {label:32s}{seconds:9.3f}{count / seconds:12.0f}{seconds / count / PERIODS * 1e9:11.1f}")

    kept = cuda.RESIDENT
    for cuda.RESIDENT in RESIDENT:
        seconds = seconds_of(lambda: cuda.cuda_ensemble_run(recorded, parameters, initial, budget(TOLERANCE)))
        row(f"GPU, {cuda.RESIDENT} threads a multiprocessor", runs, seconds)
    cuda.RESIDENT = kept
    row("processor", len(few[1]), seconds_of(lambda: ensemble_run(*few, budget(TOLERANCE))))
    results = cuda.cuda_ensemble_run(*few, budget(TOLERANCE))
    same, exact = (ensemble_run(*few, budget(tolerance)) for tolerance in (TOLERANCE, TIGHT))
    error = np.quantile(np.abs(results.state - exact.state).max(axis=1), 0.99)
    apart = np.quantile(np.abs(results.state - same.state).max(axis=1), 0.99)
    agree = np.mean(results.status == same.status)
    print(f"  99 % of {len(few[1])} runs within {error:.1e} of the tight ones, within {apart:.1e} of the processor's;")
    print(f"  {agree:.2%} of the statuses are the processor's")


def main() -> None:
    """Both laws, or why not."""
    problem = cuda.cuda_problem()
    if problem is not None:
        print(f"Not measured: {problem}")
        return
    gpu = cuda.first_gpu()
    major, minor = (gpu.attribute(f"COMPUTE_CAPABILITY_{part}") for part in ("MAJOR", "MINOR"))
    multiprocessors = gpu.attribute("MULTIPROCESSOR_COUNT")
    print(f"{gpu.name}, {multiprocessors} multiprocessors, compute capability {major}.{minor}")
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else RUNS
    compare(vc.Exponential(), runs)
    compare(vc.LuGre(), max(1, runs // 10))


if __name__ == "__main__":
    main()
