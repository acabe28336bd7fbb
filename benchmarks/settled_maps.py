"""Settled maps: periods that a run takes, and CPU time, where runs wait and where they go on from extrapolated limits.

`python -m benchmarks.settled_maps` prints both laws on maps of 100 x 100 runs, medians of alternating runs, one thread.
"""

import math
import statistics
import time
from typing import Any

import numpy as np

import vibrocap as vc
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.run.ensemble import Budget, ensemble_run
from vibrocap.physics.friction.law import Law

MASS_RATIOS, AMPLITUDES = np.linspace(0.1, 8.0, 100), np.linspace(1.0, 3.0, 100)
PERIODS, THRESHOLD, TOLERANCE = 60, 1e-6, 1e-8
TURNS = 5


def problem(law: Law) -> tuple[Any, np.ndarray, np.ndarray]:
    """(equations, parameters, initial) of the map of a law."""
    system = vc.System(vc.PendulumCapsule(), law, vc.Harmonic())
    recorded = equations(system)
    masses, amplitudes = (each.ravel() for each in np.meshgrid(MASS_RATIOS, AMPLITUDES))
    parameters = np.tile(parameter_values(system), (len(masses), 1))
    parameters[:, recorded.parameter_paths.index("machine.mass_ratio")] = masses
    parameters[:, recorded.parameter_paths.index("drive.amplitude")] = amplitudes
    start = [math.pi / 3 if name == "angle" else 0.0 for name in system.state_names]
    return recorded, parameters, np.tile(start, (len(masses), 1))


def main() -> None:
    """Run both laws both ways and print a table."""
    print("\nsettled maps of 10,000 runs, one thread: periods a run (refused trials included), settled, CPU s")
    for law in (vc.Exponential(), vc.LuGre()):
        given = problem(law)
        seconds: dict[bool, list[float]] = {False: [], True: []}
        said = {}
        for turn in range(TURNS + 1):
            for extrapolate, each in seconds.items():
                budget = Budget(
                    PERIODS, 10, THRESHOLD, TOLERANCE, 10_000, 50_000_000, evidence=1, extrapolate=extrapolate
                )
                used = time.process_time()
                found = ensemble_run(*given, budget, threads=1)
                if turn > 0:  # the first one compiles
                    each.append(time.process_time() - used)
                periods = float(np.mean(found.head("periods") + found.head("refused_trials")))
                said[extrapolate] = f"{periods:6.2f} {np.mean(found.response_period > 0):8.4f}"
        for extrapolate, each in seconds.items():
            how = "extrapolated" if extrapolate else "waiting"
            print(f"  {law.name:12s} {how:13s} {said[extrapolate]} {statistics.median(each):8.3f}")


if __name__ == "__main__":
    main()
