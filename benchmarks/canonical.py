"""LuGre's stick-slip test with its authors' parameters: this engine, as plain Python and compiled, beside SciPy.

A mass of 1 kg is pulled at 0.1 m/s through a spring of 2 N/m for 20 s, three slips (Canudas de Wit et al. 1995). The
bristles relax within some ten microseconds while the mass slides and rest while it sticks, so the equations are stiff
by turns. Every competitor runs at the loosest tolerance found to meet the error asked for in the place of the mass at
the end; SciPy's Radau and BDF are given the Jacobian, and LSODA is compiled Fortran around Python's rates.
"""

import math
import statistics
import time
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

import vibrocap as vc
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.run.budget import Budget, Form, MotionStart
from vibrocap.numerics.run.motion import recorded_run

END = 20.0
# Stretch [m], velocity [m/s] and bristle [m] at the end: our runs at 1e-11 and 1e-13 and Radau at 1e-11 agree to these.
FINAL = (-0.727403587676, 6.710689832e-05, 1.453842909323e-05)
ERROR_ASKED = 1e-7  # m
SIGMA0, SIGMA1, SIGMA2, COULOMB, STATIC, STRIBECK = 1e5, math.sqrt(1e5), 0.4, 1.0, 1.5, 1e-3
SPEED, STIFFNESS = 0.1, 2.0

Run = Callable[[], np.ndarray]


def pulled_block() -> vc.System:
    """The pulled block; one period of the drive, which does nothing, is the whole run."""
    law = vc.LuGre(SIGMA0, SIGMA1, SIGMA2, COULOMB, STATIC, STRIBECK)
    return vc.System(vc.Oscillator.pulled(SPEED, stiffness=STIFFNESS), law, vc.Constant(duration=END))


def prepare_compiled(tolerance: float) -> Run:
    """The whole of `simulate`, everything recorded, as a user calls it."""
    system = pulled_block()
    return lambda: vc.simulate(system, periods=1, tolerance=tolerance).sections[-1]


def prepare_plain(tolerance: float) -> Run:
    """The same source, not compiled: the kernel as Python runs it."""
    system = pulled_block()
    start = MotionStart(equations(system), parameter_values(system), (0.0, 0.0, 0.0), END)
    return lambda: recorded_run(start, Budget(1, tolerance, 10_000, 10**7), Form(plain=True)).sections[-1]


def _rates(_t, y):
    x, v, z = y.tolist()
    stiffness = SIGMA0 / (COULOMB + (STATIC - COULOMB) * math.exp(-((v / STRIBECK) ** 2)))
    rate = v - abs(v) * z * stiffness
    return v - SPEED, -STIFFNESS * x - SIGMA0 * z - SIGMA1 * rate - SIGMA2 * v, rate


def _jacobian(_t, y):
    _, v, z = y.tolist()
    drop = (STATIC - COULOMB) * math.exp(-((v / STRIBECK) ** 2))
    stiffness = SIGMA0 / (COULOMB + drop)
    slope = stiffness**2 / SIGMA0 * drop * 2.0 * v / STRIBECK**2  # of 1/g
    by_v = 1.0 - math.copysign(1.0, v) * z * stiffness - abs(v) * z * slope
    by_z = -abs(v) * stiffness
    return [[0.0, 1.0, 0.0], [-STIFFNESS, -SIGMA1 * by_v - SIGMA2, -SIGMA0 - SIGMA1 * by_z], [0.0, by_v, by_z]]


def prepare_scipy(method: str, relative: float) -> Run:
    """solve_ivp; absolute tolerances follow the sizes of the three states."""
    absolute = relative * np.array([1e-1, 1e-2, 1e-6])
    options = {} if method == "LSODA" else {"jac": _jacobian}

    def run() -> np.ndarray:
        solution = solve_ivp(_rates, (0.0, END), (0.0, 0.0, 0.0), method, rtol=relative, atol=absolute, **options)
        assert solution.success, solution.message
        return solution.y[:, -1]

    return run


def main(rounds: int = 7) -> None:
    """Run all in turn and print median times, ratios to Radau and measured errors."""
    runs = {
        "SciPy Radau": prepare_scipy("Radau", 1.5e-7),
        "SciPy BDF": prepare_scipy("BDF", 1.5e-9),
        "SciPy LSODA (Fortran)": prepare_scipy("LSODA", 2e-9),
        "vibrocap, plain Python": prepare_plain(1e-7),
        "vibrocap.simulate, compiled": prepare_compiled(1e-7),
    }
    print(f"\nLuGre's stick-slip test, {END:g} s: error asked {ERROR_ASKED:g} m")
    for run in runs.values():
        run()
    times: dict[str, list[float]] = {label: [] for label in runs}
    errors = {}
    for _ in range(rounds):
        for label, run in runs.items():
            before = time.perf_counter()
            final = run()
            times[label].append(time.perf_counter() - before)
            errors[label] = abs(final[0] - FINAL[0])
    radau = statistics.median(times["SciPy Radau"])
    print(f"  {'':36s}{'median ms':>11s}{'faster':>8s}{'error':>10s}")
    for label, measured in times.items():
        median = statistics.median(measured)
        print(f"  {label:36s}{median * 1e3:11.3f}{radau / median:8.2f}{errors[label]:10.1e}")


if __name__ == "__main__":
    main()
