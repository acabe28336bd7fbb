"""Settled maps: CPU time of runs that wait, over that of runs that continue from extrapolated limits.

`python -m benchmarks settled` compares them on maps of the documentation, at the same budget of periods, and at the
budget with which as many waiting runs settle. One thread, medians of alternating runs.
"""

import statistics
import time

import numpy as np

import vibrocap as vc
from vibrocap.physics.friction.law import Law

SIZE = 50  # runs along either axis
THRESHOLD, PERIODS = 1e-6, 40
LONGER = (1, 1.5, 2, 3, 4, 6)  # budgets of the waiting runs, in PERIODS
TURNS = 5
MASSES, DRIVE = "machine.mass_ratio", "drive.amplitude"
MAPS: dict[str, tuple[Law, dict[str, np.ndarray], float]] = {
    "README.md": (vc.Exponential(), {MASSES: np.linspace(0.1, 8.0, SIZE), DRIVE: np.linspace(1.0, 3.0, SIZE)}, 1e-10),
    "sweeps.md": (vc.Exponential(), {MASSES: np.linspace(0.2, 8.0, SIZE), DRIVE: np.linspace(0.5, 3.0, SIZE)}, 1e-10),
    "its LuGre": (vc.LuGre(), {MASSES: np.geomspace(0.2, 8.0, SIZE), DRIVE: np.linspace(1.0, 3.0, SIZE)}, 1e-8),
}


def main() -> None:
    """Run the maps and print a table."""
    print(f"\nsettled maps of {SIZE} x {SIZE} runs: CPU time of waiting runs over that of extrapolated ones")
    machine, drive = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0), vc.Harmonic(1.8, 1.0)
    for name, (law, axes, tolerance) in MAPS.items():
        over = dict(zip(axes, map(np.ravel, np.meshgrid(*axes.values())), strict=True))
        system = vc.System(machine, law, drive)
        ways = [(PERIODS, True), *((int(factor * PERIODS), False) for factor in LONGER)]
        seconds: dict[tuple[int, bool], list[float]] = {way: [] for way in ways}
        settled: dict[tuple[int, bool], float] = {}
        velocity: dict[tuple[int, bool], np.ndarray] = {}
        for turn in range(TURNS + 1):
            for periods, extrapolate in ways:
                used = time.process_time()
                results = vc.ensemble(
                    system,
                    over,
                    measures=["mean_velocity"],
                    initial={"angle": np.pi / 3},
                    periods=periods,
                    settle=THRESHOLD,
                    tolerance=tolerance,
                    extrapolate=extrapolate,
                    threads=1,
                )
                if turn > 0:  # the first one compiles
                    seconds[periods, extrapolate].append(time.process_time() - used)
                settled[periods, extrapolate] = float(np.mean(results["settled"]))
                velocity[periods, extrapolate] = np.where(results["settled"], results["mean_velocity"], np.nan)
        medians = {name: statistics.median(second) for name, second in seconds.items()}
        print(f"  {name:10s} extrapolated: {settled[ways[0]]:.1%} settle within {PERIODS} periods")
        for way in ways[1:]:
            apart = np.nanmax(np.abs(velocity[way] - velocity[ways[0]]))
            ratio = medians[way] / medians[ways[0]]
            print(
                f"  {'':10s} {way[0]:4d} periods: {ratio:.2f}, {settled[way]:.1%} settle; velocities {apart:.1e} apart"
            )


if __name__ == "__main__":
    main()
