"""Fits of friction laws: time and error on the rotary damper, coverage of the intervals law by law.

`python -m benchmarks.fitting [folder of arts-rotary-damper]` times the fits; with `--recovery N` it repeats simulated
experiments N times for every law (100 take about 25 minutes on one core).
"""

import argparse
import dataclasses
import os
import statistics
import sys
import time
from pathlib import Path

import numpy as np

from vibrocap.identification.fit import fit
from vibrocap.identification.problem.prediction import Prediction
from vibrocap.physics import catalogue
from vibrocap.records.published import rotary_damper

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests"))  # repeated experiments, which the tests use too
from recovery import recovery

BESIDE = Path(__file__).resolve().parents[2] / "shared" / "data" / "arts-rotary-damper"
EARTHQUAKE = "eq_KocaeliMCE_window"
LAWS = ("lugre", "anisotropic-lugre", "backlash-anisotropic-lugre")
ROUNDS = 3


def damper_fits(folder: Path) -> None:
    """Time and errors of fits to the four harmonic records together; the earthquake is predicted only."""
    records = rotary_damper(folder)
    print(f"rotary damper, four records together, {os.cpu_count()} cores; relative to the force's standard deviation")
    for law in LAWS:
        for intervals in ("covariance", "profile"):
            fit(records, law, held_out=EARTHQUAKE, starts=1, intervals="covariance")  # warm
            seconds = []
            for _ in range(ROUNDS):
                begin = time.perf_counter()
                fitted = fit(records, law, held_out=EARTHQUAKE, intervals=intervals)
                seconds.append(time.perf_counter() - begin)
            print(
                f"  {law:28s} {intervals:10s} {statistics.median(seconds):6.2f} s   fitted {fitted.relative_rmse:.2%}  "
                f"earthquake {fitted.held_out_relative_rmse:.2%}"
            )
            if intervals == "covariance" and fitted.problem is not None:
                driven(fitted.problem.prediction, fitted.problem.best.u)


def driven(prediction: Prediction, u: np.ndarray) -> None:
    """Time of the forces and of their slopes, the work of which a fit consists."""
    rows = {}
    for label, call in (("forces", prediction.errors), ("slopes", prediction.slopes)):
        seconds = []
        for _ in range(7):
            begin = time.perf_counter()
            call(u)
            seconds.append(time.perf_counter() - begin)
        rows[label] = statistics.median(seconds)
    texts = ", ".join(f"{label} {1e3 * seconds:.1f} ms" for label, seconds in rows.items())
    print(f"    {prediction.size:,} samples, {len(u)} coordinates: {texts}")


def coverage(repetitions: int) -> None:
    """How many 95 % intervals hold the truth, for every law and parameter."""
    changes = {"viscous_damping": 0.05, "smoothing_velocity": 0.02}
    for name in (*catalogue.laws(), "anisotropic-lugre", "backlash-lugre"):
        law = catalogue.law(name)()
        own = {field: value for field, value in changes.items() if hasattr(law, field)}
        own |= {"bristle_damping": 0.2} if hasattr(law, "gap") else {}
        begin = time.perf_counter()
        law = dataclasses.replace(law, **own)  # type: ignore[type-var]
        found = recovery(law, repetitions=repetitions, starts=8 if "backlash" in name else 4)
        print(f"{name}: {time.perf_counter() - begin:.0f} s, {found.failed} failed")
        for p in found.parameters:
            note = "" if p in found.identifiable else "   (not identifiable here)"
            print(f"  {p.name:24s} inside {p.inside} of {repetitions}   width {p.width:.2%}   bias {p.bias:+.2f}{note}")


def report() -> None:
    """What `python -m benchmarks` shows of fits."""
    if BESIDE.is_dir():
        damper_fits(BESIDE)
    else:
        print("  rotary damper: the measurements are not here (see `vibrocap list datasets`)")


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", nargs="?", type=Path, default=BESIDE)
    parser.add_argument("--recovery", type=int, default=0)
    asked = parser.parse_args()
    if asked.recovery:
        coverage(asked.recovery)
    else:
        damper_fits(asked.folder)
