"""Draws steering.png, a picture of docs/controllers.md: a schedule that brings a capsule to a place and holds it there.

python docs/images/steering.py
"""

from pathlib import Path

import vibrocap as vc

if __name__ == "__main__":
    machine = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0)
    system = vc.System(machine, vc.Exponential(), vc.Harmonic(amplitude=1.8))
    vc.figure(vc.steer(system, 5.0, tolerance=0.01), Path(__file__).with_suffix(".png"))
