"""Draws branches.png, the picture of docs/orbits.md: steady motions over the drive's amplitude, for both laws.

python docs/images/branches.py
"""

import math
from pathlib import Path

import vibrocap as vc
from vibrocap.plotting.look.finishing import save
from vibrocap.plotting.steady.branches import branch_figure

if __name__ == "__main__":
    start = {"angle": math.pi / 3}
    diagrams, swept = [], []
    for law in (vc.Exponential(), vc.LuGre()):
        system = vc.System(vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0), law, vc.Harmonic())
        diagrams.append(vc.branches(system, "drive.amplitude", (1.0, 3.0), initial=start))
        swept.append(vc.bifurcation_diagram(system, "drive.amplitude", (1.0, 3.0), 41, initial=start))
        print(diagrams[-1])
    save(branch_figure(diagrams, multipliers=True, swept=swept), Path(__file__).with_suffix(".png"))
