"""Calibration in 100 synthetic laboratories: are the parameters within their intervals, is a wrong column named?

`python -m benchmarks.laboratories [FIRST] [LAST]` prints a line for each and, at the end, how often the intervals of
determined parameters hold the truth. Every tenth laboratory has one wrong column.
"""

import sys
from typing import Any

import numpy as np

import vibrocap as vc

UNKNOWN = {
    "machine.stiffness": (1.0, 5.0),
    "machine.damping": (0.4, 3.0),
    "friction.coulomb_coefficient": (0.02, 0.2),
    "drive.amplitude": (0.5, 2.0),
    "machine.mass_ratio": (1.0, 6.0),
}
TRUTHS = {  # within which the truth is drawn
    "machine.stiffness": (1.5, 4.0),
    "machine.damping": (0.6, 2.0),
    "friction.coulomb_coefficient": (0.04, 0.12),
    "drive.amplitude": (0.8, 1.4),
    "machine.mass_ratio": (1.5, 4.0),
}
MEASURES = ("mean_velocity", "drive_work")
NOISE, FLOOR = 0.03, 1e-4  # of a reading, relative and absolute
FACTORS, SHIFT = (0.7, 1.4), 0.15  # of a wrong column; of a wrong duty


def known_system() -> vc.System:
    """A capsule under its dynamic load, driven by a square wave."""
    machine = vc.PendulumCapsule(normal_load="dynamic")
    return vc.System(machine, vc.Exponential(0.08, 0.2), vc.Square(amplitude=1.0, duty=0.35))


def laboratory(seed: int, rows: int = 30) -> tuple[dict[str, Any], dict[str, float], str | None]:
    """(table, true parameters, the wrong column or None): settled speeds and works over frequency and duty.

    Rows whose run lifts off are left out; a machine of which a third or more does is drawn anew.
    """
    rng = np.random.default_rng(seed)
    while True:
        truth = {path: float(rng.uniform(*ends)) for path, ends in TRUTHS.items()}
        conditions = {"drive.frequency": rng.uniform(0.6, 2.0, rows), "drive.duty": rng.uniform(0.2, 0.8, rows)}
        system = known_system().with_parameters(truth)
        runs = vc.ensemble(system, conditions, measures=MEASURES, periods=300, settle=1e-7, tolerance=1e-9)
        good = runs["status"] == 0
        if np.mean(good) > 2.0 / 3.0:
            break
    table = {path: column[good] for path, column in conditions.items()}
    for name in MEASURES:
        value = runs[name][good]
        error = NOISE * np.abs(value) + FLOOR
        table[name] = value + error * rng.standard_normal(len(value))
        table[f"{name}_error"] = error
    wrong = None
    if seed % 10 == 9:
        wrong = str(rng.choice(["drive.frequency", "drive.duty", *MEASURES]))
        factor = float(rng.choice(FACTORS))
        if wrong == "drive.duty":
            table[wrong] = table[wrong] + SHIFT
        else:
            for name in (wrong, f"{wrong}_error"):
                if name in table:
                    table[name] = table[name] * factor
    return table, truth, wrong


def main(first: int = 0, last: int = 100) -> None:
    """Calibrate in some laboratories and print how it went."""
    covered, named, false = [], [], 0
    for seed in range(first, last):
        table, truth, wrong = laboratory(seed)
        calibration = vc.calibrate(known_system(), table, UNKNOWN, progress=False)
        inside = {parameter.path: truth[parameter.path] in parameter for parameter in calibration.parameters}
        if wrong is None:
            covered += [
                inside[parameter.path]
                for parameter in calibration.parameters
                if parameter.verdict.value == "determined"
            ]
            false += calibration.doubt is not None
        else:
            named.append(calibration.doubt is not None and calibration.doubt.column == wrong)
        outside = [path for path, held in inside.items() if not held]
        fit = f"rows {calibration.measured.rows}, misfit {calibration.misfit:.3f}, outside {outside or 'none'}"
        print(f"{seed:3d} {fit}, wrong {wrong}, doubt {calibration.doubt}", flush=True)
    print(
        f"{sum(covered)} of {len(covered)} determined parameters within their intervals, {100 * np.mean(covered):.1f} %"
    )
    print(f"{sum(named)} of {len(named)} wrong columns named, {false} doubts without cause")


if __name__ == "__main__":
    main(*(int(each) for each in sys.argv[1:3]))
