"""Branches of cycles between Hopf points and the end of sticking: no false folds, each cycle once, exact places."""

import itertools
import math

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.arguments import ArgumentError
from vibrocap.orbits.continuation.cycle_following import _at_zero
from vibrocap.orbits.walk.kinds import BranchEnd, SpecialKind

pytestmark = pytest.mark.slow
HOPF, END_OF_STICKING = math.log(10.0) / 2.0, 1.8366009722087555  # the second by an independent event-driven solver
OVER, RANGE = "machine.belt_speed", (0.5, 2.5)


def belt(duration=1.0):
    drive = vc.Constant(duration=duration)
    return vc.System(vc.Oscillator(damping=0.1, belt_speed=1.5), vc.Exponential(0.5, 1.0, 2.0), drive)


def cycles(duration):
    return vc.branch(belt(duration), OVER, RANGE, initial={"position": 2.0}, settle_periods=int(400 / duration) + 10)


@pytest.mark.parametrize("duration", exhaustive_but([0], [1.0, 0.1, 37.0]))
def test_stick_slip_goes_over_into_sliding_and_shrinks_to_its_hopf_point(duration, ceasing):
    """Issue 27: no fold, the Hopf point and the end of sticking within their errors, whatever the idle duration."""
    found = ceasing if duration == 1.0 else cycles(duration)
    end, birth = found.special_points
    assert (end.kind, birth.kind) == (SpecialKind.MODE_CHANGE, SpecialKind.HOPF)
    assert abs(end.parameter - END_OF_STICKING) <= end.error < 1e-9
    assert abs(birth.parameter - HOPF) <= birth.error < 1e-9
    assert found.ends == (BranchEnd.PARAMETER_BOUND, BranchEnd.HOPF)
    assert "Hopf point" in str(found)
    sticks = np.array(["S" in word for word in found.mode_sequence])
    assert np.all(found.stable == sticks)
    # Each cycle once: sticking ones up to the end of sticking, then sliding ones back to the Hopf point.
    up, down = found.parameter[sticks], found.parameter[~sticks]
    assert np.all(np.diff(up) > -1e-9)
    assert np.all(np.diff(down) < 1e-9)
    assert down[-1] == pytest.approx(HOPF, abs=1e-4)


@pytest.fixture(scope="module")
def born():
    return vc.hopf_cycles(vc.equilibrium_branch(belt(), OVER, RANGE))


@pytest.fixture(scope="module")
def ceasing():
    return cycles(1.0)


def test_cycles_are_born_at_the_hopf_point_and_are_those_of_the_other_way(born, ceasing):
    assert born.ends == (BranchEnd.HOPF, BranchEnd.PARAMETER_BOUND)
    assert [point.kind for point in born.special_points] == [SpecialKind.HOPF, SpecialKind.MODE_CHANGE]
    assert abs(born.special_points[0].parameter - HOPF) < 1e-9
    assert abs(born.special_points[1].parameter - END_OF_STICKING) <= born.special_points[1].error
    assert born.period[0] == pytest.approx(2.0 * math.pi, abs=1e-5)
    assert not born.stable[1]  # subcritical
    for value in (1.3, 1.7):
        ends = [sorted(orbit.period for orbit in branch.orbits_at(value)) for branch in (born, ceasing)]
        assert len(ends[0]) == len(ends[1]) == 2
        assert ends[0] == pytest.approx(ends[1], abs=1e-10)


def test_amplitude_grows_as_the_normal_form_says(born):
    """q - q_H is proportional to the square of the amplitude, on the side that the first Lyapunov coefficient says."""
    small = slice(0, 12)
    amplitude = np.hypot(*(born.states[small] - [0.55, -HOPF]).T)
    shares = (born.parameter[small] - HOPF) / amplitude**2
    assert np.all(shares > 0.0)
    assert np.ptp(shares) < 0.02 * np.mean(shares)


def test_supercritical_cycles_of_rock_are_stable():
    system = vc.System(vc.Oscillator(belt_speed=0.2, stiffness=300.0), vc.RateAndStateAgeing(), vc.Constant())
    sliding = vc.equilibrium_branch(system, "machine.stiffness", (300.0, 500.0))
    (birth,) = sliding.hopf_points
    born = vc.hopf_cycles(sliding, points=20)
    assert birth.criticality == "supercritical"
    assert np.all(born.stable[1:])
    assert np.all(born.parameter < birth.parameter)


def test_extrapolation_is_exact_for_polynomials():
    speeds = [0.1 * 1.7**k for k in range(6)]
    assert _at_zero(speeds, [2.0 - u + 3.0 * u**5 for u in speeds]) == pytest.approx(2.0, abs=1e-12)
    assert all(v > u for u, v in itertools.pairwise(speeds))


def test_bad_input_is_refused_by_name():
    sliding = vc.equilibrium_branch(belt(), OVER, (1.2, 2.0))
    with pytest.raises(ArgumentError, match="at should be given: the branch has 0 Hopf points"):
        vc.hopf_cycles(sliding)
    with pytest.raises(ArgumentError, match="one of the Hopf points"):
        vc.hopf_cycles(sliding, 3)  # type: ignore[arg-type]
    linear = vc.System(vc.ModeCouplingBlock(damping=0.05), vc.Coulomb(0.3, 3.0), vc.Constant())
    flutter = vc.equilibrium_branch(linear, "friction.coulomb_coefficient", (0.1, 1.0))
    with pytest.raises(ArgumentError, match="degenerate"):
        vc.hopf_cycles(flutter)
