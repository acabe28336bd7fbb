"""A driven LuGre law beside SciPy's stiff solvers at equal measured error: time per sample of a record.

The record is two seconds of a motion of two tones at 1024 samples per second, linear in between, like a measured one.
SciPy follows it in one call, as a user would write it; each solver gets the loosest tolerance at which its error stays
within the one asked.
"""

import statistics
import time
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

import vibrocap as vc
from vibrocap.laboratory.driven import driven_force, driven_forces

RATE = 1024.0  # samples per second
SECONDS = 2.0
ASKED = 1e-5  # largest error of the deflection, over its natural size
TOLERANCES = 10.0 ** -np.arange(3.0, 13.0)
STIFFNESSES = (1e6, 1e8)  # N/m
LEVELS = {"coulomb_coefficient": 15e3, "static_coefficient": 20e3, "stribeck_velocity": 0.01}  # N, N, m/s
SETS = 64  # parameter sets at once


def record() -> tuple[np.ndarray, np.ndarray]:
    """Time [s] and velocity [m/s]."""
    t = np.arange(int(SECONDS * RATE)) / RATE
    return t, 0.12 * np.sin(2.0 * np.pi * t) + 0.03 * np.sin(6.6 * np.pi * t + 1.0)


def by_scipy(law: vc.LuGre, method: str, tolerance: float) -> np.ndarray:
    """Deflections [m] by `solve_ivp` with the exact Jacobian."""
    t, v = record()
    slopes = np.diff(v) * RATE
    values, starts = v.tolist(), slopes.tolist()

    def velocity(now: float) -> float:
        i = min(int(now * RATE), len(starts) - 1)
        return values[i] + starts[i] * (now - i / RATE)

    def rate(now: float, z: np.ndarray) -> tuple[float]:
        u = velocity(now)
        return law.force(u, (z[0],), 1.0 if u >= 0.0 else -1.0, 1.0)[1]

    def jacobian(now: float, z: np.ndarray) -> list[list[float]]:
        speed = abs(velocity(now))
        return [[-law.bristle_stiffness * speed / law.steady_force(speed, 1.0)]]

    scale = law.static_coefficient / law.bristle_stiffness
    solution = solve_ivp(
        rate, (t[0], t[-1]), [0.0], method, t_eval=t, rtol=tolerance, atol=tolerance * scale, jac=jacobian
    )
    return solution.y[0]


def by_vibrocap(law: vc.LuGre, tolerance: float) -> np.ndarray:
    """Deflections [m] by `driven_force`."""
    return driven_force(law, *record(), tolerance=tolerance).internal[:, 0]


def loosest(run: Callable[[float], np.ndarray], exact: np.ndarray, scale: float) -> tuple[float, float]:
    """The loosest tolerance at which the error stays within the one asked (or the tightest tried), and that error."""
    tolerance = error = np.inf
    for tolerance in TOLERANCES.tolist():
        error = float(np.abs(run(tolerance) - exact).max()) / scale
        if error <= ASKED:
            break
    return tolerance, error


def seconds(run: Callable[[], object], rounds: int) -> float:
    """Median time of a call, after one that prepares."""
    run()
    times = []
    for _ in range(rounds):
        before = time.perf_counter()
        run()
        times.append(time.perf_counter() - before)
    return statistics.median(times)


def main() -> None:
    """Print microseconds per sample, with the tolerance that each solver needed and the error that it left."""
    t, v = record()
    print(f"\nA driven LuGre law, {len(t)} samples: error asked {ASKED:g} of the deflection")
    for stiffness in STIFFNESSES:
        law = vc.LuGre(bristle_stiffness=stiffness, bristle_damping=100.0, **LEVELS)
        scale = law.static_coefficient / stiffness
        exact = by_vibrocap(law, 1e-13)
        competitors: dict[str, tuple[Callable[[float], np.ndarray], int]] = {
            "vibrocap driven_force": (lambda tolerance, law=law: by_vibrocap(law, tolerance), 31)
        }
        for method in ("Radau", "LSODA"):
            competitors[f"SciPy {method}"] = (
                lambda tolerance, law=law, method=method: by_scipy(law, method, tolerance),
                3,
            )
        print(
            f"  stiffness {stiffness:g} N/m\n  {'':24s}{'tolerance':>10s}{'us/sample':>11s}{'ratio':>9s}{'error':>10s}"
        )
        first = 0.0
        for label, (run, rounds) in competitors.items():
            tolerance, error = loosest(run, exact, scale)
            per_sample = seconds(lambda run=run, tolerance=tolerance: run(tolerance), rounds) / len(t) * 1e6
            first = first or per_sample
            print(f"  {label:24s}{tolerance:10.0e}{per_sample:11.3f}{per_sample / first:9.1f}{error:10.1e}")
        values = np.geomspace(0.5, 2.0, SETS)[:, None] * stiffness
        for threads in (1, 2):
            spent = seconds(
                lambda law=law, values=values, threads=threads: driven_forces(
                    law, values, ("bristle_stiffness",), t, v, tolerance=1e-6, threads=threads
                ),
                11,
            )
            label = f"{SETS} sets, {threads} thread{'s' if threads > 1 else ''}"
            print(f"  {label:24s}{1e-6:10.0e}{spent / (SETS * len(t)) * 1e6:11.3f}")


if __name__ == "__main__":
    main()
