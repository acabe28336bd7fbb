"""Laws of several pieces: an elastic contact that slips at its level, against an independent solver."""

import math
from typing import ClassVar

import numpy as np
import pytest

import vibrocap as vc
from independent import motion as independent_motion
from plain_kernels import kernel_of, running_on
from thinned import exhaustive_but
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.run.budget import Budget, EnsembleStart, Form
from vibrocap.numerics.run.ensemble import ensemble_run
from vibrocap.physics.friction.law import Law, Positive, parameter, parameters

TOLERANCE = 1e-9
START = {"angle": math.pi / 3}


@parameters
class Prandtl(Law):
    """Elastic, then perfectly plastic: R = k z, z' = v until |R| reaches the level, then z' = 0 until the reversal."""

    stiffness: Positive = parameter(30.0, "k", "stiffness")
    level: Positive = parameter(0.3, "F", "level of slipping")

    name: ClassVar[str] = "prandtl"
    kind: ClassVar = "kinked"
    internal: ClassVar = ("deflection", "slips")
    switched: ClassVar = ("slips",)
    internal_symmetry: ClassVar = (-1, 1)

    def force(self, velocity, internal, side, load):
        deflection, slips = internal
        return self.stiffness * deflection, ((1.0 - slips) * velocity, 0.0)

    def switches(self, velocity, internal, side, load):
        deflection, slips = internal
        return (slips + (1.0 - slips) * (load * self.level / self.stiffness - side * deflection),)

    def after_switch(self, which, velocity, internal, side, load):
        return internal[0], 1.0

    def after_reversal(self, internal, side, load):
        return internal[0], 0.0

    def internal_scales(self, load):
        return load * self.level / self.stiffness, 1.0

    def losses(self, velocity, internal, side, load):
        deflection, slips = internal
        return slips * self.stiffness * deflection * velocity, 0.0

    def stored_energy(self, internal):
        return 0.5 * self.stiffness * internal[0] * internal[0]


@parameters
class Endless(Prandtl):
    """A law whose switch changes nothing: its guard never becomes positive."""

    name: ClassVar[str] = "endless"

    def after_switch(self, which, velocity, internal, side, load):
        return internal


@parameters
class Relaxing(Prandtl):
    """Slips with a memory that decays fast while it slips: stiff."""

    name: ClassVar[str] = "relaxing"

    def force(self, velocity, internal, side, load):
        deflection, slips = internal
        level = side * 0.5 * load * self.level / self.stiffness
        return self.stiffness * deflection, ((1.0 - slips) * velocity + slips * 3000.0 * (level - deflection), 0.0)


def system_with(law):
    return vc.System(vc.PendulumCapsule(), law, vc.Harmonic())


def motion_of(system, periods, order=12, initial=START):
    kernel = kernel_of(system, order)
    with running_on(kernel):
        return vc.simulate(system, periods=periods, initial=initial, tolerance=TOLERANCE)


def times(motion, kind):
    return [event.time for event in motion.events if event.kind == kind]


@pytest.mark.slow  # a compilation each
@pytest.mark.parametrize("law", exhaustive_but([0], [Prandtl(), Relaxing()]))
def test_against_an_independent_solver(law):
    """Errors: 1e-9 per step over some hundred steps, and what the equations make of it over a period and a half."""
    system = system_with(law)
    motion, theirs = motion_of(system, 1.5), independent_motion(system, START, 1.5)
    assert len(times(motion, "switch")) >= 3
    reversals = [float(time) for time, kind in theirs.events if kind == "reversal"]
    assert times(motion, "reversal") == pytest.approx(reversals, abs=1e-6)
    assert motion.state == pytest.approx(theirs.state, abs=1e-6)
    assert motion.certificate.sign_kept
    if isinstance(law, Relaxing):
        assert motion.certificate.implicit_steps > 0
    else:
        assert np.max(np.abs(motion["deflection"])) * law.stiffness == pytest.approx(law.level, rel=1e-9)
        assert motion.certificate.energy_residual < 100 * TOLERANCE


def test_a_start_beyond_its_piece_goes_over_at_once():
    motion = motion_of(system_with(Prandtl()), 0.01, initial={**START, "velocity": 1.0, "deflection": 0.011})
    first = motion.events[0]
    assert (first.time, first.kind, first.state["slips"]) == (0.0, "switch", 1.0)


def test_a_piece_that_cannot_begin_is_no_endless_loop():
    motion = motion_of(system_with(Endless()), 1.0)
    assert motion.status is vc.Status.UNDECIDED_CONTACT


def test_lanes_together_are_single_runs():
    """The vector step takes a lane where its piece is sure to last; others take the step of a single motion."""
    system = system_with(Prandtl())
    recorded = equations(system)
    runs = 5
    parameters = np.tile(parameter_values(system), (runs, 1))
    parameters[:, recorded.parameter_paths.index("machine.mass_ratio")] = np.linspace(0.5, 5.0, runs)
    initial = np.zeros((runs, len(recorded.rates)))
    initial[:, 0] = START["angle"]
    budget = Budget(1, TOLERANCE, 1000, 10**6)
    with np.errstate(all="ignore"):  # free lanes are computed along
        simd, alone = (
            ensemble_run(
                EnsembleStart(recorded, parameters, initial), budget, Form(order=10, lanes=lanes, plain=True), threads=1
            )
            for lanes in (0, 1)
        )
    assert np.all(simd.finished)
    assert simd.state == pytest.approx(alone.state, abs=1e-7)
    assert np.ptp(simd.state, axis=0)[2] > 0.1
