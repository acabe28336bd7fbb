"""How the time and the memory of a map grow with its runs, and what share of its time is arithmetic of the series.

Each size is a process of its own, so that its peak memory is its own.
"""

import importlib
import json
import subprocess
import sys
import time

import numpy as np

import vibrocap as vc
from benchmarks.named_sweeps import SWEEP_SET
from benchmarks.sweep_vibrocap import budget, problem
from vibrocap.numerics import linker as link
from vibrocap.numerics.run.budget import EnsembleStart
from vibrocap.numerics.run.ensemble import ensemble_order, ensemble_run, ensemble_source

SIZES = (1, 1_000, 10_000, 100_000, 1_000_000)
PERIODS = 20
CALLS = 20_000


def one(runs: int) -> dict[str, float]:
    """Seconds and peak memory [MB] of a map of so many runs over mass ratio and stiffness, in random order."""
    import resource

    machine = vc.PendulumCapsule(damping=SWEEP_SET.damping)
    system = vc.System(machine, vc.Exponential(), vc.Harmonic(amplitude=SWEEP_SET.amplitude))
    draw = np.random.default_rng(1)
    settings = {"initial": {"angle": np.pi / 3}, "periods": PERIODS, "window": 5, "tolerance": 5e-8}
    few = {"machine.mass_ratio": [1.0], "machine.stiffness": [1.0]}
    vc.ensemble(system, few, **settings)  # the kernel is made
    over = {"machine.mass_ratio": draw.uniform(0.01, 8.1, runs), "machine.stiffness": draw.uniform(0.2, 4.5, runs)}
    started = time.perf_counter()
    vc.ensemble(system, over, **settings)
    spent = time.perf_counter() - started
    return {"seconds": spent, "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}


def growth() -> None:
    """Print time per run and memory from 1 to 10^6 runs."""
    print(f"\nA map of so many runs, {PERIODS} periods each, all cores")
    print(f"  {'runs':>9s}{'s':>9s}{'us/run':>9s}{'peak MB':>9s}")
    for runs in SIZES:
        program = f"import json; from benchmarks.growth import one; print(json.dumps(one({runs})))"
        answer = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout
        content = json.loads(answer)
        print(f"  {runs:9d}{content['seconds']:9.3f}{content['seconds'] / runs * 1e6:9.1f}{content['megabytes']:9.0f}")


def series_seconds(law: str, masses: np.ndarray) -> tuple[float, int]:
    """(seconds of one call of the generated series, on a thread; lanes of a call)."""
    recorded, parameters, initial = problem(law, masses)
    layout, text = ensemble_source(recorded, ensemble_order(budget(law).tolerance), 8)
    sweep = text.replace("def advance_ensemble(", "def whole_sweep(")  # the entry is the series alone
    alone = "\n\ndef advance_ensemble(floats, ints, trace, calls):\n    for _ in range(calls):\n        jet(floats)\n"
    series = link.compiled_kernel(sweep + alone)
    floats, ints = layout.allocated()
    lanes, place = layout.lanes, layout.places
    floats[place["PARAMETER"] :][: layout.parameters * lanes] = parameters[:lanes].T.ravel()
    floats[place["STATE"] :][: layout.states * lanes] = initial[:lanes].T.ravel()
    floats[place["SIDE"] :][:lanes] = 1.0
    trace = np.zeros(1)
    series(floats, ints, trace, 1)
    times = []
    for _ in range(15):
        started = time.perf_counter()
        series(floats, ints, trace, CALLS)
        times.append(time.perf_counter() - started)
    return float(np.median(times)) / CALLS, lanes


def arithmetic() -> None:
    """Print the share of a sweep that is spent in the generated series."""
    print("\nShare of a sweep (one thread) that is arithmetic of the generated series")
    masses = importlib.import_module("benchmarks.named_sweeps").MASS_RATIOS
    for law in ("exponential", "lugre"):
        per_call, lanes = series_seconds(law, masses)
        arguments = problem(law, masses)
        ensemble_run(EnsembleStart(*arguments), budget(law), threads=1)
        times, steps = [], 0.0
        for _ in range(5):
            started = time.perf_counter()
            results = ensemble_run(EnsembleStart(*arguments), budget(law), threads=1)
            times.append(time.perf_counter() - started)
            steps = results.head("taylor_steps").sum()
        series, whole = steps / lanes * per_call, float(np.median(times))
        print(
            f"  {law:12s}{series / whole:6.0%}   ({per_call / lanes * 1e9:.0f} of {whole / steps * 1e9:.0f} ns a step)"
        )


def main() -> None:
    """Both tables."""
    growth()
    arithmetic()


if __name__ == "__main__":
    main()
