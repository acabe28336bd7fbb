"""Three blocks in a row and a wall: how long a run of a sweep takes where contacts and a stop end its steps.

The machine is described here, as none of the catalogue has three bodies and a stop.

`python -m benchmarks three` prints medians of runs on one thread.
"""

import statistics
import time
from typing import ClassVar

import numpy as np

import vibrocap as vc
from vibrocap.mechanics import NonNegative, Positive, Stop, parameter, parameters

BLOCKS = vc.ThreeBlockRow
RUNS, PERIODS, ROUNDS = 512, 40, 5
DRIVE = vc.Harmonic(amplitude=2.5, frequency=1.1)
LAW = vc.Coulomb(coulomb_coefficient=0.4, static_coefficient=0.4)


@parameters
class BlocksAndWall(BLOCKS):
    """A row of three blocks whose last one strikes a soft wall on the ground, as far ahead as the gap: a spring."""

    gap: NonNegative = parameter(0.3, "delta", "way of the last block to the wall", "gap")
    wall_stiffness: Positive = parameter(15.0, "kappa_w", "spring of the wall", "stiffness")

    name: ClassVar[str] = "blocks-and-wall"

    def scales(self, time=1.0):
        """Those of the blocks."""
        return *super().scales(time), 1.0

    def parts(self, q):
        """With the wall, on the last block."""
        return [*super().parts(q), Stop(q.position[-1], self.gap, stiffness=self.wall_stiffness)]


def blocks() -> vc.System:
    """The blocks on Coulomb friction."""
    return vc.System(BlocksAndWall(), LAW, DRIVE)


def main() -> None:
    """Print the time of a run and period, and how often a run strikes the wall in a period."""
    system, options = blocks(), {"periods": PERIODS, "window": PERIODS, "tolerance": 1e-6, "threads": 1}
    varied = {"machine.coupling_stiffness": np.linspace(0.5, 3.0, RUNS)}
    times = []
    for _ in range(ROUNDS + 1):
        before = time.process_time()
        results = vc.ensemble(system, varied, measures=["impacts"], **options)
        times.append(time.process_time() - before)
    spent = statistics.median(times[1:]) / RUNS / PERIODS
    print(f"\nThree blocks and a wall, {RUNS} couplings, {PERIODS} periods, one thread")
    print(f"  {spent * 1e6:.2f} us a run and period; {np.mean(results['impacts']):.2f} impacts a period")


if __name__ == "__main__":
    main()
