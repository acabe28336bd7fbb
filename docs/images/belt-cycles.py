"""Draws belt-cycles.png, a picture of docs/orbits.md: steady sliding on a belt, and the cycles born at its Hopf point.

python docs/images/belt-cycles.py
"""

from pathlib import Path

import vibrocap as vc

if __name__ == "__main__":
    machine, law = vc.Oscillator(damping=0.1, belt_speed=1.5), vc.Exponential(0.5, 1.0, 2.0)
    sliding = vc.equilibrium_branch(vc.System(machine, law, vc.Constant()), "machine.belt_speed", (0.5, 2.5))
    cycles = vc.hopf_cycles(sliding)
    print(sliding, cycles, sep="\n")
    vc.figure(sliding, Path(__file__).with_suffix(".png"), cycles=[cycles])
