"""`python -m benchmarks.mujoco_contact`: MuJoCo's friction beside the exact one, as its step and constraints get finer.

Two motions of the capsule of the README, in SI with a pendulum of 40 mm: 40 periods on the exponential law, whose
friction loss is rewritten at every step to the level at the present speed, and the drift on a contact of MuJoCo's own,
with Coulomb's law, under a load that follows the motion. Needs mujoco.
"""

import math
import time

import vibrocap as vc
from vibrocap.case.case import Case
from vibrocap.exchange.mjcf import mujoco_ending, mujoco_model
from vibrocap.measures.recorded.travel import drift
from vibrocap.physics.dimensions.scales import PendulumScales

SCALES = PendulumScales(pendulum_mass_kg=0.02, pendulum_length_m=0.04)
CAPSULE = {"mass_ratio": 2.5, "stiffness": 2.0, "damping": 1.0}
SETTINGS = ((2e-3, False), (1e-4, False), (1e-4, True), (2e-5, True))  # step in s, tight


def loss_case() -> Case:
    """The capsule of the README: friction is the loss of a joint."""
    machine = vc.PendulumCapsule(**CAPSULE)
    system = vc.System(machine, vc.Exponential(), vc.Harmonic(amplitude=1.8, frequency=1.0), units=SCALES)
    return Case(system, {"angle": math.pi / 3}, periods=40, tolerance=1e-10)


def contact_case() -> Case:
    """The same under a load that follows the motion: friction is that of a contact."""
    machine = vc.PendulumCapsule(**CAPSULE, normal_load="dynamic")
    law = vc.Coulomb(coulomb_coefficient=0.1, static_coefficient=0.1)
    system = vc.System(machine, law, vc.Biharmonic(amplitude=1.2, second_amplitude=0.4), units=SCALES)
    return Case(system, periods=30, tolerance=1e-10)


def main() -> None:
    """Print the table of docs/exchange.md."""
    loss, contact = loss_case(), contact_case()
    motions = loss.simulate().dimensionless, contact.simulate().dimensionless
    print("| | position after 40 periods | drift per period | time of both |\n| --- | --- | --- | --- |")
    print(f"| exact | {motions[0].state['position']:.4f} | {drift(motions[1]):.6f} | |")
    for step, tight in SETTINGS:
        begun = time.perf_counter()
        position = mujoco_ending(loss, mujoco_model(loss, step, tight), motions[0].end, rewritten=True).place
        travel = mujoco_ending(contact, mujoco_model(contact, step, tight), motions[1].end, rewritten=True).drift
        took, text = time.perf_counter() - begun, "tight" if tight else "default `solref`"
        print(f"| {1e3 * step:g} ms, {text} | {position:.3f} | {travel:.4f} | {took:.1f} s |", flush=True)


if __name__ == "__main__":
    main()
