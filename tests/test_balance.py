"""The acceleration from the balance of momentum is that of the equations, and is used only where it is."""

import numpy as np
import pytest

import vibrocap as vc
from plain_kernels import kernel_of
from planted import planted
from vibrocap.mechanics import Damper
from vibrocap.motion.recording.equations import equations
from vibrocap.numerics.codegen import series_source
from vibrocap.numerics.codegen.jets import JetWriter
from vibrocap.physics.machines.oscillator import Oscillator
from vibrocap.physics.parameters import parameters

EPSILON = 2.0**-52
LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre(viscous_damping=0.1)}
STATE = {"capsule": (0.7, -0.4, 0.2, 0.3), "oscillator": (0.7, 0.3), "bare": (0.7, -0.4, 0.2, 0.3)}


@parameters
class Bare(vc.PendulumCapsule):
    """A capsule with a second damper of one: the rate of the angle stands in its own rate, beside the acceleration."""

    name = "bare"

    def parts(self, q):
        return [*super().parts(q), Damper(1.0, q.angle)]


@planted(vc.PendulumCapsule)
class Forgetful:
    """A capsule whose momentum is wrong: the pendulum's share is left out."""

    name = "forgetful"

    def momentum(self, t, y):
        return (self.mass_ratio + 1.0) * y[3]


@planted(vc.PendulumCapsule)
class Curved:
    """A capsule whose momentum is right and written in a way that the writer does not take apart."""

    name = "curved"

    def momentum(self, t, y):
        squared = vc.PendulumCapsule.momentum(self, t, y) + 10.0
        return squared * squared / squared


def series(system, start, side, balanced):
    """[states, order + 1] from the balance or from the solved equations."""
    with pytest.MonkeyPatch.context() as patch:
        if not balanced:

            def explicit(equations, layout, code, slow):
                return JetWriter(equations.graph, list(equations.rates), code)

            patch.setattr(series_source, "series_writer", explicit)
        kernel = kernel_of(system, 12)
    kernel.fill("SIDE", side)
    kernel.fill("TIME", 0.3)
    kernel.fill("STATE", start)
    kernel["jet"](kernel.floats)
    return np.array([kernel.series(i) for i in range(len(start))])


MACHINES = {
    "capsule": vc.PendulumCapsule(),
    "oscillator": Oscillator(damping=0.3, belt_speed=0.2),
    "bare": Bare(),
}


@pytest.mark.parametrize(
    ("machine", "law", "side"),
    [
        *[(machine, law, 1) for machine in MACHINES for law in LAWS],
        *[("capsule", law, -1) for law in LAWS],
        *[(machine, "exponential", 0) for machine in MACHINES],
    ],
)
def test_both_ways_give_one_series(machine, law, side):
    """To rounding: each of the 12 orders adds some to what it takes from all before."""
    system = vc.System(MACHINES[machine], LAWS[law], vc.Harmonic())
    assert equations(system).balance is not None
    start = np.array([*STATE[machine], *([0.002] if law == "lugre" else [])])
    start[len(STATE[machine]) - 1] *= side
    balanced, solved = (series(system, start, side, balanced) for balanced in (True, False))
    size = np.maximum.accumulate(np.abs(solved).max(axis=0))
    assert np.all(np.abs(balanced - solved) <= 1e3 * EPSILON * size)


@pytest.mark.parametrize("machine", [Forgetful(), Curved()])
def test_a_balance_that_does_not_serve_is_left_alone(machine):
    """A momentum that does not agree with the equations, or is no sum of products: the solved equations serve."""
    system = vc.System(machine, vc.Exponential(), vc.Harmonic())
    usual = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    assert (equations(system).balance is None) == isinstance(machine, Forgetful)
    assert np.array_equal(series(system, STATE["capsule"], 1, True), series(usual, STATE["capsule"], 1, False))
