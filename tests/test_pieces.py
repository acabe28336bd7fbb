"""Laws of several pieces: an elastic contact that slips at its level, against an independent solver."""

import math
from typing import ClassVar

import numpy as np
import pytest

import vibrocap as vc
from independent import motion as independent_motion
from plain_kernels import kernel_of, running_on
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


def system_with(law):
    return vc.System(vc.PendulumCapsule(), law, vc.Harmonic())


def motion_of(system, periods, order=12, initial=START):
    kernel = kernel_of(system, order)
    with running_on(kernel):
        return vc.simulate(system, periods=periods, initial=initial, tolerance=TOLERANCE)


def times(motion, kind):
    return [event.time for event in motion.events if event.kind == kind]


@pytest.mark.slow  # its kernel
def test_against_an_independent_solver():
    """Errors: 1e-9 per step over some hundred steps, and what the equations make of it over a period and a half."""
    law = Prandtl()
    system = system_with(law)
    motion, theirs = motion_of(system, 1.5), independent_motion(system, START, 1.5)
    assert len(times(motion, "switch")) >= 3
    reversals = [float(time) for time, kind in theirs.events if kind == "reversal"]
    assert times(motion, "reversal") == pytest.approx(reversals, abs=1e-6)
    assert motion.state == pytest.approx(theirs.state, abs=1e-6)
    assert motion.certificate.sign_kept
    assert np.max(np.abs(motion["deflection"])) * law.stiffness == pytest.approx(law.level, rel=1e-9)
    assert motion.certificate.energy_residual < 100 * TOLERANCE


def test_a_start_beyond_its_piece_goes_over_at_once():
    motion = motion_of(system_with(Prandtl()), 0.01, initial={**START, "velocity": 1.0, "deflection": 0.011})
    first = motion.events[0]
    assert (first.time, first.kind, first.state["slips"]) == (0.0, "switch", 1.0)


def test_a_piece_that_cannot_begin_is_no_endless_loop():
    motion = motion_of(system_with(Endless()), 1.0)
    assert motion.status is vc.Status.UNDECIDED_CONTACT
