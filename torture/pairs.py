"""Single runs beside the same runs in an ensemble: both end with the same status."""

import random
import warnings
from pathlib import Path

import vibrocap as vc
from torture.outcome import Outcome
from vibrocap.motion.status import Status

RANGES = {
    "machine.mass_ratio": (0.05, 8.0),
    "machine.stiffness": (0.0, 4.0),
    "machine.damping": (0.0, 2.0),
    "drive.amplitude": (0.0, 40.0),
    "drive.frequency": (0.05, 5.0),
    "initial.angle": (-3.0, 3.0),
}
LAWS = (vc.Exponential(), vc.LuGre(), vc.Coulomb(), vc.Stribeck())
PERIODS = 4
LIMITS = ({}, {"max_events_per_period": 3}, {"max_steps": 8})  # within which some runs fail
WRONG = 1e300  # a start from which states leave the numbers


def pairs(folder: Path, trials: int, seed: int) -> Outcome:
    """So many pairs over four laws and three sets of limits."""
    outcome, chance, ends = Outcome("pairs"), random.Random(seed), {}
    groups = [(law, limits) for law in LAWS for limits in LIMITS]
    for number, (law, limits) in enumerate(groups):
        runs = trials // len(groups) + (number < trials % len(groups))
        if not runs:
            continue
        system = vc.System(vc.PendulumCapsule(), law, vc.Harmonic())
        over = {path: [chance.uniform(*ends) for _ in range(runs)] for path, ends in RANGES.items()}
        if not limits:
            over["initial.angle"][0] = WRONG
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            many = vc.ensemble(system, over, periods=PERIODS, window=PERIODS, tolerance=1e-8, **limits)
            for run in range(runs):
                pair(system, {path: values[run] for path, values in over.items()}, limits, many, run, outcome, ends)
    outcome.words = ", ".join(f"{count} {status}" for status, count in sorted(ends.items()))
    return outcome


def pair(system, values: dict, limits: dict, many: dict, run: int, outcome: Outcome, ends: dict[str, int]) -> None:
    """One run alone beside the same among others."""
    start = {path.partition(".")[2]: value for path, value in values.items() if path.startswith("initial.")}
    rest = {path: value for path, value in values.items() if not path.startswith("initial.")}
    motion = vc.simulate(system.with_parameters(rest), periods=PERIODS, tolerance=1e-8, initial=start, **limits)
    status = list(Status)[many["status"][run]]
    ends[status.value] = ends.get(status.value, 0) + 1
    said = f"{system.friction.name} {values} {limits}: {status.value} among others, {motion.status.value} alone"
    outcome.check(status == motion.status, said)
