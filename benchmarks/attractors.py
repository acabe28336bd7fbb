"""All attractors at one parameter from 1,000 starts, and what else looks at motions that many starts lead to.

Medians of warm calls, with the time of all cores beside them: on a machine that does other things too, the latter
divided by the number of cores is what the call costs.
"""

import statistics
import time
from collections.abc import Callable

import vibrocap as vc
from vibrocap.orbits.attractors.attractors import attractors
from vibrocap.orbits.attractors.basins import basins
from vibrocap.orbits.attractors.bifurcation_diagram import bifurcation_diagram
from vibrocap.orbits.attractors.lyapunov import lyapunov_exponent

STARTS = 1000
ASKED = 5.0  # seconds on two cores


def capsule(law, stiffness: float = 2.0, damping: float = 1.0, amplitude: float = 1.8) -> vc.System:
    """The capsule of the first set, or one with a softer spring."""
    machine = vc.PendulumCapsule(mass_ratio=2.5, stiffness=stiffness, damping=damping)
    return vc.System(machine, law, vc.Harmonic(amplitude=amplitude, frequency=1.0))


def timed(run: Callable[[], object], rounds: int = 3) -> tuple[float, float, object]:
    """(median time, median time of all cores, result) of warm calls."""
    result = run()
    times, cores = [], []
    for _ in range(rounds):
        before, busy = time.perf_counter(), time.process_time()
        result = run()
        times.append(time.perf_counter() - before)
        cores.append(time.process_time() - busy)
    return statistics.median(times), statistics.median(cores), result


def main() -> None:
    """Print times, and what was found."""
    print(f"\nAll attractors from {STARTS:,} starts: at most {ASKED:g} s on two cores")
    print(f"  {'':44s}{'s':>8s}{'core s':>8s}  found (share)")
    for label, system in (
        ("EM, first set", capsule(vc.Exponential())),
        ("LM, first set", capsule(vc.LuGre())),
        ("LM, delta1 = 1", capsule(vc.LuGre(bristle_damping=1.0))),
        ("EM, chaotic (rho 0.6, nu 0.3, h 1.2)", capsule(vc.Exponential(), 0.6, 0.3, 1.2)),
    ):
        spent, cores, found = timed(lambda system=system: attractors(system, STARTS))
        assert isinstance(found, vc.Attractors)
        words = ", ".join(f"{attractor.motion.kind} ({attractor.share:.3f})" for attractor in found.attractors)
        print(f"  {label:44s}{spent:8.2f}{cores:8.2f}  {words}")
    first = capsule(vc.Exponential())
    for label, run in (
        ("basins, EM, 100 x 100", lambda: basins(first, {"angle": (-3, 3), "angle_rate": (-3, 3)}, 100)),
        ("the same, of phase and angle", lambda: basins(first, {"phase": (0, 1), "angle": (-3, 3)}, 100)),
        ("diagram, EM, 200 points, 2 x 4 runs", lambda: bifurcation_diagram(first, "drive.amplitude", (1, 3), 200)),
        ("exponents, EM, 1,000 periods", lambda: lyapunov_exponent(first, {"angle": 1.0})),
        ("exponents, LM, 1,000 periods", lambda: lyapunov_exponent(capsule(vc.LuGre()), {"angle": 1.0})),
    ):  # fmt: skip
        spent, cores, _ = timed(run)
        print(f"  {label:44s}{spent:8.2f}{cores:8.2f}")


if __name__ == "__main__":
    main()
