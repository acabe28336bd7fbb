"""Draws two-blocks.png, a picture of docs/orbits.md: where two blocks on a belt begin to stick, over the belt's speed.

python docs/images/two-blocks.py
"""

from pathlib import Path

import vibrocap as vc

if __name__ == "__main__":
    laws = [vc.HyperbolicStribeck(0.0, level, 1.0 / 3.0) for level in (1.0, 1.3)]
    row = vc.TwoBlockRow(coupling_stiffness=1.2, belt_speed=0.1)
    system = vc.System(row, laws, vc.Constant(duration=10.0))
    found = vc.bifurcation_diagram(
        system, "machine.belt_speed", (0.05, 0.3), 251, starts=3, settle_periods=100, section="stick_2"
    )
    vc.figure(found, Path(__file__).with_suffix(".png"), state="position_2")
