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
from types import SimpleNamespace

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
PERIODS, SETTLE = 300, 1e-6  # of a run, at most, and when it has settled


def capsule() -> vc.System:
    """The first set: constant load, harmonic drive."""
    machine = vc.PendulumCapsule(FIRST_SET.mass_ratio, FIRST_SET.stiffness, FIRST_SET.damping)
    return vc.System(machine, vc.Exponential(), vc.Harmonic(FIRST_SET.amplitude, FIRST_SET.frequency))


def searched(members: int, designs: int) -> Callable[[], int]:
    """A search of so many designs in populations of one size; how many were run."""
    from unittest import mock

    asked = {"periods": PERIODS, "settle": SETTLE, "tolerance": 1e-8, "margin": 1e-3, "threads": 1}
    problem = stated_problem(capsule(), OVER, ["mean_velocity"], [None], (), START, **asked)

    def run() -> int:
        evaluations = Evaluations(problem, designs, None, None)
        with mock.patch("vibrocap.design.search.evolution.members_of", return_value=members):
            evolve(evaluations, 0, 0, designs)
        return evaluations.designs

    return run


def settled_speed(values: np.ndarray) -> float:
    """The speed of the settled motion of a design by SciPy's solver with events; 0 where it stalls or does not settle.

    It has settled where its stroboscopic state is that of one to four periods before, to the threshold of the search.
    """
    own = {path.partition(".")[2]: float(x) for path, x in zip(OVER, values, strict=True)}
    p = SimpleNamespace(**(vars(FIRST_SET) | own))
    y = np.array([np.pi / 3, 0.0, 0.0, 0.0])
    period, side, before = 2.0 * np.pi / p.frequency, peers_scipy.first_side(p, y), [y]
    for k in range(PERIODS):
        try:
            y, side = peers_scipy.moved_on(p, k * period, (k + 1) * period, y, side, relative=1e-7, absolute=1e-8)
        except RuntimeError:
            return 0.0
        for lag, known in enumerate(before[:-5:-1], start=1):
            if np.max(np.abs(y - known)[[0, 1, 3]]) <= SETTLE:
                return abs(y[2] - known[2]) / (lag * period)
        before.append(y)
    return 0.0


def scipy_search(designs: int) -> tuple[float, float]:
    """(CPU seconds a design, the best speed) of SciPy's differential evolution over SciPy's solver with events."""
    from scipy.optimize import differential_evolution
    from scipy.stats import qmc

    begun = qmc.scale(qmc.Sobol(len(OVER), rng=np.random.default_rng(0)).random(16), *zip(*OVER.values(), strict=True))
    used = time.process_time()
    evolution = differential_evolution(
        lambda values: -settled_speed(values), list(OVER.values()), init=begun, maxiter=designs // 16 - 1, polish=False,
        tol=0.0, rng=np.random.default_rng(0),
    )  # fmt: skip
    return (time.process_time() - used) / evolution.nfev, -float(evolution.fun)


def designs_to(share: float, seeds: int = 5) -> tuple[float, float]:
    """(median over searches of the designs until the best is within a share of the best of all, that best speed)."""
    searches = []
    for seed in range(seeds):
        design = vc.optimise(
            capsule(), OVER, starts=START, seed=seed, refinement=0, spread_starts=0, threads=1, progress=False
        )
        searches.append(np.minimum.accumulate(design.population.best_cost))
    best = min(float(each[-1]) for each in searches)
    reached = [
        int(np.argmax(each <= best * (1.0 - share))) + 1 for each in searches if each[-1] <= best * (1.0 - share)
    ]
    return statistics.median(reached), -best


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
    }
    for task in tasks.values():
        task()
    seconds: dict[str, list[float]] = {name: [] for name in tasks}
    for _ in range(TURNS):
        for name, task in tasks.items():
            used = time.process_time()
            number = task()
            seconds[name].append((time.process_time() - used) / number)
    for name, second in seconds.items():
        print(f"{name:40s} {1.0 / statistics.median(second):10.1f} per CPU second")
    slow, fast = scipy_search(64), statistics.median(seconds["designs in populations of 256"])
    print(f"{'designs by SciPy alone, 64 of them':40s} {1.0 / slow[0]:10.2f} per CPU second, best {slow[1]:.6f}")
    print(f"ratio at 256: {slow[0] / fast:.0f}")
    needed, best = designs_to(1e-3)
    print(f"to within a thousandth of {best:.6f}: {needed:.0f} designs, {needed * fast:.2f} CPU s here; extrapolated,")
    print(f"not run: {needed * slow[0] / 60.0:.0f} CPU minutes for as many designs by SciPy alone")
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
