"""`python -m benchmarks`: this engine beside its peers at equal measured error; medians of alternating runs.

Every competitor is prepared (compiled, warmed) first; then all run in turn, again and again, so that a machine whose
speed drifts slows them all alike. The ratios are the message, not the milliseconds.
"""

import statistics
import sys
import time
from collections.abc import Callable

import numpy as np

import vibrocap as vc
from benchmarks import (
    attractors,
    branches,
    canonical,
    cold_start,
    driven_law,
    growth,
    impacts,
    named_sweeps,
    orders,
    ratios,
    settled_maps,
    stepping,
    stiff,
    three_bodies,
    two_threads,
)
from benchmarks.named_motions import EXPONENTIAL_40, FIRST_SET, LUGRE_100, NamedMotion

Run = Callable[[], np.ndarray]


def first_set(law) -> vc.System:
    """The capsule of the named motions on a friction law."""
    machine = vc.PendulumCapsule(
        mass_ratio=FIRST_SET.mass_ratio, stiffness=FIRST_SET.stiffness, damping=FIRST_SET.damping
    )
    return vc.System(machine, law, vc.Harmonic(amplitude=FIRST_SET.amplitude, frequency=FIRST_SET.frequency))


def prepare_vibrocap(law, motion: NamedMotion, tolerance: float) -> Run:
    """The whole of `simulate`, everything recorded, as a user calls it."""
    system = first_set(law)
    initial = dict(zip(system.state_names, motion.initial, strict=True))

    def run() -> np.ndarray:
        done = vc.simulate(system, periods=motion.periods, initial=initial, tolerance=tolerance)
        return done.sections[-1]

    run()
    return run


def peers(name: str) -> dict[str, Run]:
    """Prepared runs of the peers that are installed, by label; a missing one is reported."""
    table: dict[str, Run] = {}
    try:
        from benchmarks import peers_heyoka
    except ImportError:
        print("  heyoka: not installed (pip install -e '.[ref]')")
    else:
        if name == "exponential":
            table["heyoka, tuned (fast_math)"] = peers_heyoka.prepare_exponential()
            table["heyoka, its default tolerance"] = peers_heyoka.prepare_exponential(2.3e-16, fast_math=False)
        else:
            table["heyoka, tuned (fast_math)"] = peers_heyoka.prepare_lugre()
            table["heyoka, its default tolerance"] = peers_heyoka.prepare_lugre(2.3e-16, fast_math=False)
    if name == "exponential":
        from benchmarks import peers_scipy

        table["SciPy DOP853 with events"] = peers_scipy.prepare_events()
    return table


def compare(title: str, motion: NamedMotion, runs: dict[str, Run], seconds: float = 20.0) -> None:
    """Run all in turn and print median times, ratios to the first and measured errors."""
    print(f"\n{title}: error asked {motion.error_asked:g}")
    times: dict[str, list[float]] = {label: [] for label in runs}
    errors = {}
    slow = "SciPy"
    started, rounds = time.perf_counter(), 0
    while rounds < 5 or (time.perf_counter() - started < seconds and rounds < 200):
        for label, run in runs.items():
            if label.startswith(slow) and rounds >= 5:
                continue
            before = time.perf_counter()
            final = run()
            times[label].append(time.perf_counter() - before)
            errors[label] = motion.error(final)
        rounds += 1
    first = statistics.median(next(iter(times.values())))
    print(f"  {'':36s}{'median ms':>11s}{'ratio':>8s}{'error':>10s}")
    for label, measured in times.items():
        median = statistics.median(measured)
        missed = "" if errors[label] <= motion.error_asked else "  above the error asked"
        print(f"  {label:36s}{median * 1e3:11.3f}{median / first:8.2f}{errors[label]:10.1e}{missed}")


def main() -> None:
    """All tables, or those named on the command line; their names are those below."""
    tables = {
        "canonical": canonical,
        "stiff": stiff,
        "sweeps": named_sweeps,
        "impacts": impacts,
        "three": three_bodies,
        "threads": two_threads,
        "growth": growth,
        "driven": driven_law,
        "attractors": attractors,
        "branches": branches,
        "ratios": ratios,
        "settled": settled_maps,
        "stepping": stepping,
    }
    wanted = set(sys.argv[1:]) or {"single", *tables, "orders", "cold"}
    del sys.argv[1:]  # the tables below read it when they are run alone
    if "single" in wanted:
        runs = {"vibrocap.simulate": prepare_vibrocap(vc.Exponential(), EXPONENTIAL_40, 2e-10), **peers("exponential")}
        compare("One EM motion, 40 periods (exact sticking)", EXPONENTIAL_40, runs)
        runs = {"vibrocap.simulate": prepare_vibrocap(vc.LuGre(), LUGRE_100, 1e-6), **peers("lugre")}
        compare("One LM motion, 100 periods", LUGRE_100, runs)
    for name, table in tables.items():
        if name in wanted:
            table.main()
    if "orders" in wanted:
        orders.main()
    if "cold" in wanted:
        cold_start.main()


if __name__ == "__main__":
    main()
