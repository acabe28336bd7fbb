"""`python -m benchmarks ratios`: what drives, loads, bristles and further bodies cost, over what they replace.

The two of a pair run in turn, again and again, and medians of their processor times are compared; each within the limit
that was set when it was built. Motions of a pair are not the same and take other numbers of steps; their ratio stands
last: where it is 0.9 and that of the times 1.08, a step costs 1.2 times as much.
"""

import dataclasses
import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import vibrocap as vc

ROUNDS = 21
PERIODS = 100
TOLERANCE = 1e-8
START = {"angle": 0.5}
MASSES = np.linspace(3.5, 4.5, 1000)  # mass ratios of the runs side by side


@dataclasses.dataclass(frozen=True)
class Pair:
    """A system over the one that it is compared with; limit: of the ratio of their times.

    masses: the parameter of both over which an ensemble runs
    """

    title: str
    over: vc.System
    plain: vc.System
    limit: float | None
    start: Mapping[str, float] = dataclasses.field(default_factory=lambda: START)
    masses: str = "machine.mass_ratio"

    @property
    def systems(self) -> tuple[vc.System, vc.System]:
        """Both."""
        return self.over, self.plain


LEVELS = {"coulomb_coefficient": 0.1, "static_coefficient": 0.2}
MASS_RATIO = 4.0


def capsule(load="weight", drive=None, law=None, **more) -> vc.System:
    """The capsule of all pairs: it slides, sticks and does not lift off, whatever its load and drive."""
    machine = vc.PendulumCapsule(mass_ratio=MASS_RATIO, normal_load=load)
    return vc.System(machine, law or vc.Exponential(**LEVELS), drive or vc.Harmonic(amplitude=1.5), **more)


def on_bristles(load: str) -> vc.System:
    """The same on the LuGre law, whose bristles are given at the load 1 where the load is that of the motion.

    So that under the weight, lambda + 1, both contacts are one; else they relax five times as fast in one of them.
    """
    at_load = 1.0 if load == "dynamic" else MASS_RATIO + 1.0
    law = vc.LuGre(bristle_stiffness=100.0 * at_load, bristle_damping=10.0 * at_load, **LEVELS)
    return capsule(load, law=law)


def bodies(count: int, law) -> vc.System:
    """So many bodies in a row, of which the second is heavier."""
    return vc.System(vc.crawler(count)(mass_2=MASS_RATIO), law, vc.Harmonic(amplitude=1.5))


COULOMB, BRISTLES = vc.Coulomb(**LEVELS), vc.LuGre(**LEVELS)
ROW = {"start": {}, "masses": "machine.mass_2"}
PAIRS = (
    Pair("square drive over harmonic drive", capsule(drive=vc.Square(amplitude=1.2)), capsule(), 1.3),
    Pair("dynamic load over constant load", capsule("dynamic"), capsule(), 1.5),
    Pair("the same, LuGre law", on_bristles("dynamic"), on_bristles("weight"), 1.5),
    Pair("with an actuator over without", capsule(actuator=vc.Actuator(0.3, 1.2)), capsule(), None),
    Pair("two bodies, LuGre over Coulomb", bodies(2, BRISTLES), bodies(2, COULOMB), None, **ROW),
    Pair("five bodies over two, Coulomb", bodies(5, COULOMB), bodies(2, COULOMB), None, **ROW),
    Pair("five bodies over two, LuGre", bodies(5, BRISTLES), bodies(2, BRISTLES), None, **ROW),
)


def alone(pair: Pair, system: vc.System) -> Callable[[], Any]:
    """A motion of its own, everything recorded."""
    return lambda: vc.simulate(system, periods=PERIODS, initial=pair.start, tolerance=TOLERANCE)


def side_by_side(pair: Pair, system: vc.System) -> Callable[[], object]:
    """An ensemble of a thousand masses on one thread."""
    over = {pair.masses: MASSES}
    return lambda: vc.ensemble(system, over, initial=pair.start, periods=20, tolerance=TOLERANCE, threads=1)


def ratio(one: Callable[[], object], other: Callable[[], object]) -> tuple[float, float, float]:
    """(ratio of the medians, both medians in seconds) of processor times, taken in turn."""
    times: tuple[list[float], list[float]] = ([], [])
    for run in (one, other):
        run()
    for _ in range(ROUNDS):
        for run, measured in zip((one, other), times, strict=True):
            before = time.process_time()
            run()
            measured.append(time.process_time() - before)
    medians = [statistics.median(each) for each in times]
    return medians[0] / medians[1], *medians


def main() -> None:
    """Print the ratio of every pair, alone and side by side, beside its limit."""
    print("\nWhat drives and loads cost: ratios of processor times, medians of alternating runs")
    print(f"  {'':36s}{'':14s}{'ms':>9s}{'plain ms':>10s}{'ratio':>8s}{'limit':>8s}{'steps':>8s}")
    for pair in PAIRS:
        one, other = (alone(pair, system)() for system in pair.systems)
        steps = len(one.piece_start) / len(other.piece_start)
        for how, prepared in (("alone", alone), ("side by side", side_by_side)):
            found, dear, plain = ratio(*(prepared(pair, system) for system in pair.systems))
            limit = "-" if pair.limit is None else f"{pair.limit:.2f}"
            missed = "  above its limit" if pair.limit is not None and found > pair.limit else ""
            times = f"{dear * 1e3:9.2f}{plain * 1e3:10.2f}{found:8.2f}{limit:>8s}{steps:8.2f}"
            print(f"  {pair.title:36s}{how:14s}{times}{missed}")


if __name__ == "__main__":
    main()
