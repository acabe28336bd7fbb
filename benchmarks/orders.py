"""Time against measured error for several orders of the series: the evidence for `motion.series_order`."""

import statistics
import time

import numpy as np

import vibrocap as vc
from benchmarks.named_motions import EXPONENTIAL_40, FIRST_SET, LUGRE_100
from vibrocap.numerics.run import motion as engine


def main() -> None:
    """Print milliseconds, steps per period and error for orders 8 to 20 at several tolerances."""
    series_order = engine.series_order
    try:
        for law, named in ((vc.Exponential(), EXPONENTIAL_40), (vc.LuGre(), LUGRE_100)):
            print(f"\nOrders of the series, {law.name}, {named.periods} periods: ms (error)")
            tolerances = (1e-6, 1e-8, 1e-9, 1e-10, 1e-12)
            print("  order" + "".join(f"{tolerance:>20.0e}" for tolerance in tolerances))
            for order in (8, 10, 12, 14, 16, 20):
                engine.series_order = lambda _tolerance, order=order: order
                cells = [_cell(law, named, tolerance) for tolerance in tolerances]
                print(f"  {order:5d}" + "".join(f"{cell:>20s}" for cell in cells))
    finally:
        engine.series_order = series_order


def _cell(law, named, tolerance: float) -> str:
    machine = vc.PendulumCapsule(
        mass_ratio=FIRST_SET.mass_ratio, stiffness=FIRST_SET.stiffness, damping=FIRST_SET.damping
    )
    system = vc.System(machine, law, vc.Harmonic())
    initial = dict(zip(system.state_names, named.initial, strict=True))
    times = []
    final = np.zeros(len(system.state_names))
    for _ in range(7):
        before = time.perf_counter()
        final = vc.simulate(system, periods=named.periods, initial=initial, tolerance=tolerance).sections[-1]
        times.append(time.perf_counter() - before)
    return f"{statistics.median(times[1:]) * 1e3:.2f} ({named.error(final):.0e})"
