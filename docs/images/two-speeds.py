"""Draws two-speeds.png, a picture of docs/orbits.md: how fast a weak motor turns its rotor, over its torque.

python docs/images/two-speeds.py
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import vibrocap as vc

if __name__ == "__main__":
    motor = vc.RotorCapsule(mass_ratio=4.0, damping=0.01)
    weak = vc.System(motor, vc.Exponential(0.1, 0.8, 3.0), vc.Constant(force=0.18, duration=6.0))
    slow = vc.orbit(weak, initial={"angle": 0.1}, settle_periods=300)
    found = vc.branch(weak, "drive.force", (0.14, 0.24), orbit=slow, points=1200)
    print(found)
    speed, stable = 2.0 * np.pi / found.period, found.stable
    figure, axes = plt.subplots(figsize=(6.4, 4.0), layout="constrained")
    axes.plot(found.parameter, np.where(stable, speed, np.nan), color="#0072B2", label="stable")
    axes.plot(found.parameter, np.where(stable, np.nan, speed), color="#D55E00", ls="--", label="unstable")
    for fold in found.kind(vc.SpecialKind.FOLD):
        place = fold.parameter, float(speed[fold.after_point])
        axes.plot(*place, "ko", ms=4)
        axes.annotate(f"fold {fold.parameter:.6f}", place, (8, -3), textcoords="offset points")
    axes.set(xlabel="torque at standstill $T$", ylabel="mean speed of the rotor $2\\pi$/period")
    axes.legend(frameon=False)
    figure.savefig(Path(__file__).with_suffix(".png"), dpi=150)
