"""`python -m benchmarks stepping`: what a step and a whole motion cost from outside, in C, in Python and in an FMU.

The capsule of the README. A step: under a random torque, held for 0.2. A motion: 40 periods of its own drive in one
step, beside the package's kernel, which records it, and `simulate`. All run in turn, again and again; medians of
processor times. Needs a C compiler; the FMU needs FMPy, and is left out without.
"""

import ctypes
import math
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import vibrocap as vc
from vibrocap.arguments import lacking
from vibrocap.case.case import Case
from vibrocap.exchange.c_library import export_c
from vibrocap.exchange.fmu.fmu import compiler
from vibrocap.exchange.stepped_case import Input
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.simulate import initial_state
from vibrocap.numerics.api import Budget, MotionStart, recorded_run

ROUNDS, MOTION_ROUNDS = 200, 100
STEPS, LENGTH = 500, 0.2
SLOW_STEPS = 50  # by `simulate`
MANY = 1000
START = {"angle": math.pi / 3}
SYSTEM = vc.System(
    vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0), vc.Exponential(), vc.Harmonic(1.8, 1.0)
)
CASE = Case(SYSTEM, START, periods=40, tolerance=1e-10)
LOOPS = """#include "capsule.h"
static capsule c;
#if CAPSULE_INPUTS
double run(const double *torques, int steps, double h) {
  int i;
  capsule_case(&c);
  capsule_begin(&c);
  for (i = 0; i < steps; i++) {
    capsule_set_input(&c, torques[i], 0.0, 0.0);
    capsule_step(&c, h);
  }
  return capsule_look(&c)[2];
}
#else
double run(const double *torques, int steps, double h) {
  (void)torques, (void)steps;
  capsule_case(&c);
  capsule_begin(&c);
  capsule_step(&c, h);
  return capsule_look(&c)[2];
}
#endif
"""


def in_c(folder: Path, input: Input) -> Callable[..., float]:
    """`run` of a library in C, with the drive as an input or the case's own."""
    export_c(CASE, folder, input=input)
    (folder / "loops.c").write_text(LOOPS)
    out = folder / "loops.so"
    sources = [folder / "loops.c", folder / "capsule.c"]
    subprocess.run([str(compiler()), "-std=c99", "-O2", "-fPIC", "-shared", "-o", out, *sources, "-lm"], check=True)
    call = ctypes.CDLL(str(out)).run
    call.restype, call.argtypes = ctypes.c_double, [ctypes.c_void_p, ctypes.c_int, ctypes.c_double]
    return call


def in_turn(runs: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """Median processor time [s] of each, after one call that prepares."""
    times: dict[str, list[float]] = {label: [] for label in runs}
    for run in runs.values():
        run()
    for _ in range(rounds):
        for label, run in runs.items():
            before = time.thread_time()
            run()
            times[label].append(time.thread_time() - before)
    return {label: statistics.median(each) for label, each in times.items()}


def steps(folder: Path) -> None:
    """Microseconds of one step."""
    torques = np.random.default_rng(1).uniform(-1.8, 1.8, STEPS)
    values, call = torques.tolist(), in_c(folder, "drive")
    begun, many = vc.stepper(CASE, input="drive"), vc.stepper(CASE, input="drive", count=MANY)
    motion, rows = begun.copy(), np.random.default_rng(2).uniform(-1.8, 1.8, (20, MANY))

    def in_python() -> None:
        motion.restore(begun)
        for value in values:
            motion.step(value, LENGTH)

    def side_by_side() -> None:
        for row in rows:
            many.step(row, LENGTH)

    def by_simulate() -> None:
        """Runs of a square wave whose first half is the step."""
        state: dict = dict(START)
        for value in values[:SLOW_STEPS]:
            drive = vc.Square(amplitude=value, frequency=math.pi / LENGTH)
            held = vc.System(SYSTEM.machine, SYSTEM.friction, drive)
            state = dict(vc.simulate(held, periods=0.5, initial=state, tolerance=CASE.tolerance).state)

    counts = {
        "in C, -O2": (lambda: call(torques.ctypes.data, STEPS, LENGTH), STEPS),
        "in Python": (in_python, STEPS),
        f"of each of {MANY} side by side": (side_by_side, len(rows) * MANY),
    }
    turn = in_turn({label: run for label, (run, _) in counts.items()}, ROUNDS)
    turn |= in_turn({"by simulate, from state to state": by_simulate}, 5)
    counts["by simulate, from state to state"] = (by_simulate, SLOW_STEPS)
    print(f"\nA step of {LENGTH:g} under a random torque")
    for label, spent in turn.items():
        print(f"  {label:36s}{1e6 * spent / counts[label][1]:10.2f} us")


def motions(folder: Path) -> None:
    """Milliseconds of 40 periods."""
    call, end = in_c(folder, None), CASE.periods * SYSTEM.drive.period
    values = equations(SYSTEM), parameter_values(SYSTEM), [*initial_state(SYSTEM, START).values()], SYSTEM.drive.period
    begun = vc.stepper(CASE)
    motion = begun.copy()

    def in_python() -> None:
        motion.restore(begun)
        motion.step(end)

    runs: dict[str, Callable[[], object]] = {
        "the package's kernel, recording": lambda: recorded_run(MotionStart(*values), Budget(**CASE.run)),
        "simulate": CASE.simulate,
        "one step in C, -O2": lambda: call(None, 1, end),
        "one step in Python": in_python,
    }
    if not lacking("fmpy"):
        runs["one step of an FMU"] = in_fmu(folder / "capsule.fmu", end)
    turn = in_turn(runs, MOTION_ROUNDS)
    first = next(iter(turn.values()))
    print(f"\n{CASE.periods:g} periods of the case's own drive, tolerance {CASE.tolerance:g}")
    for label, spent in turn.items():
        print(f"  {label:36s}{1e3 * spent:10.3f} ms{spent / first:8.2f}")


def in_fmu(path: Path, end: float) -> Callable[[], object]:
    """The same step in FMPy, of an instance that is reset before."""
    import fmpy  # pyright: ignore[reportMissingImports]
    from fmpy.fmi3 import FMU3Slave  # pyright: ignore[reportMissingImports]

    from vibrocap.exchange.fmu.fmu import export_fmu

    export_fmu(CASE, path)
    guid = fmpy.read_model_description(str(path)).guid
    slave = FMU3Slave(instanceName="one", guid=guid, unzipDirectory=fmpy.extract(str(path)), modelIdentifier="capsule")
    slave.instantiate()

    def run() -> None:
        slave.reset()
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        slave.doStep(0.0, end)

    return run


def main() -> None:
    """Print both tables of docs/exchange.md."""
    if not compiler():
        print("stepping: no C compiler is installed")
        return
    with tempfile.TemporaryDirectory() as folder:
        for name, table in (("steps", steps), ("motions", motions)):
            (Path(folder) / name).mkdir()
            table(Path(folder) / name)


if __name__ == "__main__":
    main()
