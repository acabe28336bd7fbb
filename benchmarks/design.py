"""Speed of design: settled designs a second, a front, a gradient, and SciPy's search over SciPy's solver.

`python -m benchmarks.design` prints medians of alternating runs, on one thread. The machine of the pendulum capsule is
that of the other benchmarks, under the exponential law.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import numpy as np

import vibrocap as vc
from benchmarks import peers_scipy
from benchmarks.named_motions import FIRST_SET
from vibrocap.design.search.evolution import Evaluations, evolve
from vibrocap.design.search.problem import stated_problem

TURNS = 5
OVER = {
    "machine.stiffness": (0.5, 4.0),
    "machine.damping": (0.3, 3.0),
    "drive.frequency": (0.5, 2.0),
    "drive.amplitude": (0.8, 2.2),
}
START = [{"angle": np.pi / 3}]


def capsule() -> vc.System:
    """The first set: constant load, harmonic drive."""
    machine = vc.PendulumCapsule(FIRST_SET.mass_ratio, FIRST_SET.stiffness, FIRST_SET.damping)
    return vc.System(machine, vc.Exponential(), vc.Harmonic(FIRST_SET.amplitude, FIRST_SET.frequency))


def searched(members: int, designs: int) -> Callable[[], int]:
    """A search of so many designs in populations of one size; how many were run."""
    from unittest import mock

    asked = {"periods": 300, "settle": 1e-6, "tolerance": 1e-8, "margin": 1e-3, "threads": 1}
    problem = stated_problem(capsule(), OVER, ["mean_velocity"], [None], (), START, **asked)

    def run() -> int:
        made = Evaluations(problem, designs, None, None)
        with mock.patch("vibrocap.design.search.evolution.members_of", return_value=members):
            evolve(made, 0, 0, designs)
        return made.designs

    return run


def scipy_designs() -> Callable[[], int]:
    """One design by SciPy's solver with events: the settled motion of 40 periods, to the same error."""
    run = peers_scipy.prepare_events(relative=1e-7, absolute=1e-8)

    def one() -> int:
        run()
        return 1

    return one


def gradient_seconds(turns: int = 50) -> float:
    """Median seconds of a gradient over two parameters."""
    orbit = vc.orbit(capsule(), initial=START[0])
    later = []
    for _ in range(turns):
        used = time.process_time()
        orbit.gradients(["machine.stiffness", "drive.frequency"])
        later.append(time.process_time() - used)
    return statistics.median(later[1:] or later)


def first_gradient() -> float:
    """CPU seconds of the first gradient where no kernel has been compiled, beyond those of the next one."""
    asked = "from benchmarks.design import *; o = vc.orbit(capsule(), initial=START[0]); t = time.process_time(); "
    asked += "o.gradients(['machine.stiffness', 'drive.frequency']); print(time.process_time() - t)"
    with tempfile.TemporaryDirectory() as kernels:
        environment = os.environ | {"VIBROCAP_CACHE": kernels}
        done = subprocess.run(
            [sys.executable, "-c", asked], env=environment, capture_output=True, text=True, check=True
        )
    return float(done.stdout)


def main() -> None:
    """Run all in turn and print a table."""
    tasks = {
        "designs in populations of 256": searched(256, 4096),
        "designs in populations of 16": searched(16, 512),
        "designs by SciPy, 40 periods of one": scipy_designs(),
    }
    for task in tasks.values():
        task()
    seconds: dict[str, list[float]] = {name: [] for name in tasks}
    for _ in range(TURNS):
        for name, task in tasks.items():
            used = time.process_time()
            number = task()
            seconds[name].append((time.process_time() - used) / number)
    for name, each in seconds.items():
        print(f"{name:40s} {1.0 / statistics.median(each):10.1f} per CPU second")
    ratio = statistics.median(seconds["designs by SciPy, 40 periods of one"])
    print(f"ratio at 256: {ratio / statistics.median(seconds['designs in populations of 256']):.0f}")
    front = []
    for seed in range(3):
        used = time.process_time()
        found = vc.pareto_front(capsule(), OVER, starts=START, evaluations=10_000, seed=seed, threads=1, progress=False)
        front.append(time.process_time() - used)
    print(f"front of {len(found)} points, 10,000 designs: {statistics.median(front):.1f} CPU s")
    first, later = first_gradient(), gradient_seconds()
    print(f"gradient over two parameters: {1e3 * later:.2f} ms; the first, whose kernel is compiled: {first:.1f} s")


if __name__ == "__main__":
    main()
