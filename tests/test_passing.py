"""`motion.crossings`: the exact times at which a quantity of a motion passes a value."""

import numpy as np
import pytest
import scipy.optimize

import vibrocap as vc
from vibrocap.arguments import ArgumentError

CAPSULE = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())


@pytest.fixture(scope="module")
def motion():
    return vc.simulate(CAPSULE, periods=6.3)


@pytest.mark.parametrize(
    ("name", "value"), [("angle", 0.5), ("energy", 1.1), ("friction", 0.2), ("drive", -0.3), ("drive_work", 0.4)]
)
def test_are_the_sign_changes_that_a_bracketing_solver_finds(motion, name, value):
    assert motion.crossings(name, value) == pytest.approx(bracketed(motion, name, value), rel=0, abs=1e-12)


@pytest.mark.plain
def test_pieces_on_which_a_law_changes_faster_than_the_states_are_halved():
    motion = vc.simulate(vc.System(vc.PendulumCapsule(), vc.SmoothedTanh(), vc.Harmonic()), periods=5, tolerance=1e-4)
    expected = bracketed(motion, "friction", 0.1)
    assert len(expected) > 10
    assert motion.crossings("friction", 0.1) == pytest.approx(expected, rel=0, abs=1e-11)


def bracketed(motion, name, value):
    """Where the quantity changes sides on a fine grid, by Brent's method."""
    t = np.linspace(0.0, motion.end, 20_001)
    above = motion.at(t, name) > value
    brackets = np.flatnonzero(above[1:] != above[:-1])
    return [
        scipy.optimize.brentq(lambda x: motion.at(x, name)[0] - value, t[i], t[i + 1], xtol=1e-14) for i in brackets
    ]


def test_directions_are_those_of_the_slope(motion):
    up, down = motion.crossings("angle", 0.5, direction=1), motion.crossings("angle", 0.5, direction=-1)
    assert np.all(motion.at(up, "angle_rate") > 0.0)
    assert np.all(motion.at(down, "angle_rate") < 0.0)
    assert np.array_equal(np.sort([*up, *down]), motion.crossings("angle", 0.5))


def test_the_greatest_value_is_touched_and_what_lies_below_it_is_passed_twice(motion):
    turns = motion.crossings("angle_rate", 0.0)
    top = turns[np.argmax(motion.at(turns, "angle"))]
    greatest = motion.at(top, "angle")[0]
    assert not len(motion.crossings("angle", greatest + 1e-14))
    near = motion.crossings("angle", greatest - 1e-9)
    assert near == pytest.approx([top, top], rel=0, abs=1e-3)
    assert near.sum() / 2 == pytest.approx(top, rel=0, abs=1e-7)


def test_a_velocity_passes_zero_where_the_capsule_turns_or_leaves_rest_for_the_other_side(motion):
    sliding = motion.piece_sides[:, 0][motion.piece_sides[:, 0] != 0]
    starts = motion.piece_start[motion.piece_sides[:, 0] != 0]
    expected = starts[1:][sliding[1:] != sliding[:-1]]
    assert len(expected) > 5
    assert motion.crossings("velocity", 0.0) == pytest.approx(expected, rel=0, abs=1e-13)


@pytest.mark.plain
def test_a_jump_over_a_value_passes_it():
    motion = vc.simulate(vc.System(vc.RigidStopCapsule(), vc.Coulomb(), vc.Harmonic()), periods=12)
    blow = next(event.time for event in motion.events if event.kind == "impact")
    rate = motion.at([blow * (1.0 - 1e-12), blow], "displacement_rate")
    assert abs(rate[1] - rate[0]) > 1e-2
    assert blow in motion.crossings("displacement_rate", rate.mean(), direction=int(np.sign(rate[1] - rate[0])))


def test_modulo_something_every_value_so_far_apart_counts(motion):
    step, low, high = 0.02, motion["position"].min(), motion["position"].max()
    places = 0.013 + step * np.arange(np.floor(low / step) - 1, np.ceil(high / step) + 1)
    expected = np.sort(np.concatenate([motion.crossings("position", place, -1) for place in places]))
    assert len(expected) > 2 * len(places)
    assert motion.crossings("position", 0.013, -1, modulo=step) == pytest.approx(expected, rel=0, abs=1e-12)


def test_bad_input_is_named(motion):
    with pytest.raises(KeyError, match="'angel' is not known of this motion; it has angle"):
        motion.crossings("angel", 0.5)
    with pytest.raises(ArgumentError, match=r"direction should be 1 \(upwards\)"):
        motion.crossings("angle", 0.5, direction=0)
    with pytest.raises(ArgumentError, match="modulo should be a positive number or None, got 0"):
        motion.crossings("angle", 0.5, modulo=0)
    with pytest.raises(ArgumentError, match="value should be a finite number, got nan"):
        motion.crossings("angle", float("nan"))
