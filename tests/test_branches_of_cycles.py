"""Branches of cycles that nothing drives in time: a block on a belt, whose period is an unknown; closed forms.

Slow: the oscillator's tangents need kernels of their own.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import vibrocap as vc
from cases import printed_json
from thinned import exhaustive_but
from vibrocap.orbits.walk.kinds import BranchEnd

pytestmark = pytest.mark.slow
STATIC, KINETIC, STIFFNESS, SPEED = 1.5, 1.0, 2.0, 0.1


def belt(damping=0.0):
    return vc.System(
        vc.Oscillator(mass=1.0, stiffness=STIFFNESS, damping=damping, belt_speed=SPEED),
        vc.Coulomb(static_coefficient=STATIC, coulomb_coefficient=KINETIC),
        vc.Constant(),
    )


def closed_form(static=STATIC, stiffness=STIFFNESS, speed=SPEED):
    """docs/model.md: (stick time, slip time)."""
    drop, w = (static - KINETIC) / stiffness, np.sqrt(stiffness)
    return 2.0 * drop / speed, 2.0 / w * (math.pi - np.arctan(w * drop / speed))


@pytest.mark.parametrize(
    ("over", "between", "name"),
    [
        ("machine.stiffness", (0.5, 8.0), "stiffness"),  # the place of the stick phase moves away from the section
        pytest.param("machine.belt_speed", (0.02, 1.0), "speed", marks=pytest.mark.exhaustive),
        pytest.param("friction.static_coefficient", (1.01, 3.0), "static", marks=pytest.mark.exhaustive),
    ],
)
def test_period_is_that_of_the_closed_form_all_along(over, between, name):
    branch = vc.branch(belt(), over, between, settle_periods=200)
    assert branch.ends == (BranchEnd.PARAMETER_BOUND, BranchEnd.PARAMETER_BOUND)
    assert branch.parameter[[0, -1]] == pytest.approx(between, abs=1e-12)
    assert np.all(np.diff(branch.parameter) > -1e-12)  # where the section is set anew there are two points
    expected = sum(closed_form(**{name: branch.parameter}))
    # A point is closed to 3e-11 of natural sizes, 0.024 for the place; the belt carries it with its speed.
    speed = branch.parameter if name == "speed" else SPEED
    assert np.max(np.abs(branch.period - expected) * speed) < 1e-12
    assert np.all(branch.multipliers == 0.0)  # sticking forgets all but the way along the cycle
    assert np.all(branch.stable)
    assert branch.response_period == 0
    assert np.all(np.isnan(branch.drift))
    assert "Branch of cycles over" in str(branch)


@pytest.fixture(scope="module")
def over_speed():
    return vc.branch(belt(), "machine.belt_speed", (0.05, 0.3), settle_periods=200)


def test_orbits_of_the_branch_are_those_of_a_simulation(over_speed):
    (orbit,) = over_speed.orbits_at(0.2)
    assert orbit.status is vc.OrbitStatus.CONVERGED
    assert orbit.period == pytest.approx(sum(closed_form(speed=0.2)), abs=1e-12)
    assert orbit.residual < 1e-11
    assert over_speed.orbit(3).period == pytest.approx(over_speed.period[3], abs=1e-11)
    simulated = vc.orbit(belt().with_parameters({"machine.belt_speed": 0.2}), settle_periods=200)
    assert simulated.period == pytest.approx(orbit.period, abs=1e-12)


def test_a_measure_takes_a_value_where_the_closed_form_does(over_speed):
    """The block sticks half of the time where 2 D/v is the slip time."""
    (place,) = over_speed.crossings("stick_fraction", 0.5)
    exact = brentq(lambda speed: np.subtract(*closed_form(speed=speed)), 0.05, 0.3, xtol=1e-14)
    assert abs(place.at - exact) <= place.error < 1e-9


def test_the_branch_ends_where_the_block_slips_for_good():
    """At the damping at which it just reaches the belt's speed again, by DOP853 at 1e-13."""
    branch = vc.branch(belt(), "machine.damping", (0.0, 2.0), settle_periods=200)
    assert branch.ends[0] is BranchEnd.PARAMETER_BOUND
    assert branch.ends[1].early
    assert branch.parameter[-1] == pytest.approx(0.71015782933, abs=1e-6)
    assert "Try another" in str(branch)
    assert branch.kind(vc.SpecialKind.FOLD) == ()  # the multiplier stays zero: the cycle ceases, it does not turn back


def test_a_block_that_comes_to_rest_has_no_branch():
    still = vc.System(vc.Oscillator(damping=5.0, belt_speed=1.0), vc.Coulomb(1.0, 1.0), vc.Constant())
    branch = vc.branch(still, "machine.belt_speed", (0.5, 2.0), settle_periods=50)
    assert len(branch) == 0
    assert branch.ends == (BranchEnd.START_FAILED, BranchEnd.START_FAILED)


def test_command_follows_cycles(tmp_path, capsys):
    case, picture = tmp_path / "belt.toml", tmp_path / "belt.png"
    vc.save_case(belt(), case)
    over = ("--over", "machine.belt_speed=0.05:0.3", "--plot", picture)
    (branch,) = printed_json(capsys, "branch", case, *over)["branches"]
    assert branch["period"] == pytest.approx(sum(closed_form(speed=np.array(branch["parameter"]))), abs=1e-10)
    assert picture.stat().st_size > 10_000


@pytest.mark.slow
@pytest.mark.parametrize(
    "section",
    exhaustive_but([1], [None, "slip_back_2", vc.Section(observable="position", value=0.4, direction=-1)]),
)
def test_a_branch_of_doubled_cycles_ends_at_the_flip_of_the_short_one(section):
    """Whatever its section, which may lie in a stick of either contact; not past it along the short cycle, nor back."""
    row = vc.TwoBlockRow(coupling_stiffness=1.2, belt_speed=0.3)
    laws = [vc.HyperbolicStribeck(0.0, level, 1.0 / 3.0) for level in (1.0, 1.3)]
    blocks = vc.System(row, laws, vc.Constant(duration=10.0))
    start = {"position": 1.0, "position_2": 1.0}
    cycle = vc.orbit(blocks, initial=start, settle_periods=120, section=section)
    branch = vc.branch(blocks, "machine.belt_speed", (0.25, 0.4), orbit=cycle, towards="up")
    assert branch.ends[1] is BranchEnd.FLIP
    assert branch.special_points[-1].kind is vc.SpecialKind.FLIP
    assert branch.special_points[-1].parameter == pytest.approx(0.2571722021, abs=1e-9)
    assert branch.period[-1] == pytest.approx(2.0 * 4.5772738414, abs=1e-7)
