"""Output error in 40 synthetic laboratories: are parameters within their intervals, predicted motions in their band?

`python -m benchmarks.motion_laboratories [FIRST] [LAST]` prints a line for each and, at the end, how often both hold.
"""

import sys

import numpy as np

import vibrocap as vc

BLOCK = vc.System(vc.Oscillator(), vc.Coulomb(0.3, 0.4), vc.Harmonic(1.0, 1.0))
TIME = np.linspace(0.0, 60.0, 600)
NOISE = 0.02  # of a position
UNKNOWN = {
    "machine.mass": (0.3, 6.0),
    "machine.stiffness": (0.0, 4.0),
    "machine.damping": (0.0, 2.0),
    "friction.coulomb_coefficient": (0.02, 2.0),
    "friction.static_coefficient": (0.02, 3.0),
}


def laboratory(seed: int) -> tuple[list[vc.Record], dict[str, float]]:
    """(a record to fit and one to predict, true parameters): a block under sums of five sinusoids."""
    rng = np.random.default_rng(seed)
    truth = {
        "machine.mass": rng.uniform(0.5, 3.0),
        "machine.stiffness": rng.uniform(0.2, 2.0),
        "machine.damping": rng.uniform(0.05, 0.6),
        "friction.coulomb_coefficient": rng.uniform(0.1, 0.8),
    }
    truth["friction.static_coefficient"] = truth["friction.coulomb_coefficient"] * rng.uniform(1.0, 1.6)
    system, records = BLOCK.with_parameters(truth), []
    for name in ("fitted", "predicted"):
        waves = [rng.uniform(0.5, 1.5) * np.sin(w * TIME + rng.uniform(0.0, 6.0)) for w in rng.uniform(0.2, 2.5, 5)]
        force = np.sum(waves, axis=0)
        drive = vc.DriveTable((*TIME, 2 * TIME[-1] - TIME[-2]), (*force, force[0]))
        motion = vc.simulate(vc.System(system.machine, system.friction, drive), periods=TIME[-1] / drive.period)
        position = motion.at(TIME, "position") + NOISE * rng.standard_normal(len(TIME))
        records.append(vc.Record(name, TIME, force, displacement=position))
    return records, truth


def outcome(seed: int) -> tuple[vc.MotionFit, list[bool], float]:
    """(fit, which parameters lie within their intervals, share of the predicted samples within the band)."""
    records, truth = laboratory(seed)
    fitted = vc.fit_motion(BLOCK, records, UNKNOWN, held_out="predicted", starts=32, progress=False)
    errors = np.abs(fitted.predicted["predicted"] - fitted.measured["predicted"])
    inside = [truth[parameter.path] in parameter for parameter in fitted.parameters]
    return fitted, inside, float(np.mean(errors <= fitted.band["predicted"]))


def main(first: int = 0, last: int = 40) -> None:
    """Fit in some laboratories and print how it went."""
    every, shares = [], []
    for seed in range(first, last):
        found, inside, share = outcome(seed)
        outside = [parameter.path for parameter, held in zip(found.parameters, inside, strict=True) if not held]
        every, shares = [*every, *inside], [*shares, share]
        print(
            f"{seed:3d} outside {outside or 'none'}, {share:.1%} in the band, noise {found.noise_ratio:.2f}", flush=True
        )
    print(
        f"{sum(every)} of {len(every)} parameters within their intervals, {np.mean(shares):.1%} of samples in the band"
    )


if __name__ == "__main__":
    main(*(int(each) for each in sys.argv[1:3]))
