"""Known optima, each searched from 20 seeds: how near every search comes, and how long it takes.

`python -m benchmarks.optima [FILE.csv] [SEEDS] [PROBLEM ...]` adds a line for each search to the file, leaves out those
that the file holds already, and prints a table of all. An optimum counts as found to 1e-9 in V (of the crawler, in V
over sqrt(mu k L)).
"""

import csv
import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import vibrocap as vc

FOUND = 1e-9
FIELDS = ("problem", "seed", "value", "missed_by", "multiplier", "seconds", "design", "limits")
START = [{"angle": math.pi / 3}]
SHARE, DECELERATION = 0.3, 0.2  # of the crawler: share of the inner mass, deceleration by friction
SLOW = DECELERATION / SHARE  # w*, at which the body just rests


@dataclass(frozen=True)
class Known:
    """A problem whose optimum is known.

    best: V there; at_least: whether it is only the best that was known before (of the harmonic drive the best that pi/3
        leads to: other starts lead to a faster motion, at least 0.1647299); per: unit in which V is compared
    """

    system: Callable[[], vc.System]
    over: dict[str, tuple[float, float]]
    evaluations: int
    best: float
    at_least: bool = False
    per: float = 1.0
    subject_to: tuple[str, ...] = ()
    starts: tuple[dict[str, float], ...] | None = (START[0],)


def biharmonic() -> vc.System:
    """Dynamic load, friction 0.05 and 0.1, amplitudes 1.2 and 0.4."""
    machine = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0, normal_load="dynamic")
    return vc.System(machine, vc.Exponential(0.05, 0.1), vc.Biharmonic(amplitude=1.2, second_amplitude=0.4))


def harmonic() -> vc.System:
    """Constant load, one harmonic: the motion that travels has a twin."""
    return vc.System(vc.PendulumCapsule(mass_ratio=2.5), vc.Exponential(), vc.Harmonic(amplitude=1.8))


def trap() -> vc.System:
    """Dynamic load, one harmonic: the closed orbit with the largest V is unstable."""
    machine = vc.PendulumCapsule(mass_ratio=1.0, stiffness=1.2, damping=1.0, normal_load="dynamic")
    return vc.System(machine, vc.Exponential(), vc.Harmonic(amplitude=0.8))


def three_phases(factor: float) -> Callable[[], vc.System]:
    """The crawler under three phases, the second with the acceleration factor times w*."""
    total = 1.0 / SHARE
    law = vc.Coulomb(DECELERATION * total, DECELERATION * total)

    def system() -> vc.System:
        drive = vc.ThreePhase(1.0, 0.5 * SLOW, factor * SLOW, 0.5 * SLOW)
        return vc.System(vc.TwoMassCrawler(mass_ratio=total - 1.0), law, drive)

    return system


def accelerations(most: float) -> dict[str, tuple[float, float]]:
    """Bounds of the first and the third acceleration, the larger one in w*."""
    return {f"drive.{name}_acceleration": (0.1 * SLOW, most * SLOW) for name in ("first", "third")}


TWO = {"drive.frequency": (0.5, 3.0), "drive.second_phase": (0.0, 2.0 * math.pi)}
FOUR = TWO | {"machine.stiffness": (1.2, 6.0), "machine.damping": (0.3, 3.0)}
THREE = {"machine.stiffness": (0.5, 4.0), "machine.damping": (0.3, 3.0), "drive.frequency": (0.5, 2.0)}
FIVE = {
    "machine.mass_ratio": (0.2, 6.0),
    "machine.stiffness": (0.1, 6.0),
    "machine.damping": (0.1, 3.0),
    "drive.amplitude": (0.5, 3.0),
    "drive.frequency": (0.3, 3.0),
}
UNIT = math.sqrt(SHARE * DECELERATION)
PROBLEMS = {
    "biharmonic, frequency and phase": Known(biharmonic, TWO, 2000, 0.104919431678),
    "biharmonic, stiffness and damping too": Known(biharmonic, FOUR, 8000, 0.129810242, True),
    "harmonic with twins": Known(harmonic, THREE, 10_000, 0.082456224884, True),
    "three phases, w1 and w3 <= w*, s = 2": Known(
        three_phases(2.0), accelerations(1.0), 1000, 0.0707106781187 / UNIT, per=UNIT, starts=None
    ),
    "three phases, w1 and w3 <= s w*, s = 2": Known(
        three_phases(2.0), accelerations(2.0), 1000, 0.288675134595, per=UNIT, starts=None
    ),
    "three phases, w1 and w3 <= s w*, s = 4": Known(
        three_phases(4.0), accelerations(4.0), 1000, 0.6, per=UNIT, starts=None
    ),
    "trap": Known(trap, FIVE, 10_000, 0.3899, True, subject_to=("least_reaction > 0.1",)),
}


def search(name: str, seed: int) -> dict[str, object]:
    """A line of the file: one search."""
    known = PROBLEMS[name]
    begun = time.perf_counter()
    best = vc.optimise(
        known.system(),
        known.over,
        subject_to=known.subject_to,
        starts=known.starts,
        evaluations=known.evaluations,
        seed=seed,
        progress=False,
    )
    value = (best.value or 0.0) / known.per
    multiplier = float(np.max(np.abs(best.orbit.multipliers), initial=0.0)) if best.orbit else math.nan
    design = " ".join(f"{x:.10g}" for x in (best.design or {}).values())
    seconds = time.perf_counter() - begun
    row = (name, seed, value, known.best - value, multiplier, round(seconds, 2), design, "; ".join(best.limits))
    return dict(zip(FIELDS, row, strict=True))


def main(file: str = "optima.csv", seeds: str = "20", *problems: str) -> None:
    """Search what the file lacks, and print what it holds."""
    path = Path(file)
    rows = list(csv.DictReader(path.read_text(encoding="utf-8").splitlines())) if path.exists() else []
    done = {(row["problem"], int(row["seed"])) for row in rows}
    names = [name for name in PROBLEMS if not problems or name in problems]
    for name in names:
        for seed in (k for k in range(int(seeds)) if (name, k) not in done):
            row = search(name, seed)
            with path.open("a", encoding="utf-8", newline="") as stream:
                table = csv.DictWriter(stream, FIELDS, lineterminator="\n")
                if not rows:
                    table.writeheader()
                table.writerow(row)
            rows.append({key: str(value) for key, value in row.items()})
            print(f"{name}, seed {seed}: V {row['value']}, missed by {row['missed_by']:.2e}", flush=True)
    print(table_of(rows))


def table_of(rows: list[dict[str, str]]) -> str:
    """How many searches found each optimum, the worst and the best V, the median of the seconds."""
    lines = [f"{'problem':40s} found  worst V          best V           seconds"]
    for name, known in PROBLEMS.items():
        own = [row for row in rows if row["problem"] == name]
        if not own:
            continue
        missed = np.array([float(row["missed_by"]) for row in own])
        values = np.array([float(row["value"]) for row in own])
        good = np.sum(missed <= FOUND) if known.at_least else np.sum(np.abs(missed) <= FOUND)
        seconds = np.median([float(row["seconds"]) for row in own])
        lines.append(f"{name:40s} {good:2d}/{len(own):2d}  {values.min():.12f}   {values.max():.12f}   {seconds:.1f}")
    return "\n".join(lines)


if __name__ == "__main__":
    main(*sys.argv[1:])
