"""Attractors from many starts: told apart, matched with their twins, counted; diagrams by brute force beside orbits."""

import itertools
import math
import types

import numpy as np
import pytest

import vibrocap as vc
from systems import capsule
from vibrocap.motion.simulate import period_marks
from vibrocap.orbits.attractors.attractors import FAILED, NOT_SETTLED, NOT_TOLD, attractors, attractors_of
from vibrocap.orbits.attractors.bifurcation_diagram import bifurcation_diagram
from vibrocap.orbits.attractors.classification import same_set, within_set
from vibrocap.orbits.attractors.starts import evenly_spread
from vibrocap.orbits.closing import settling_runs
from vibrocap.orbits.closing.settling_runs import distinct_orbits
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap
from vibrocap.physics.friction.bristles import ElastoPlastic

CHAOTIC = vc.System(vc.PendulumCapsule(stiffness=0.6, damping=0.3), vc.Exponential(), vc.Harmonic(amplitude=1.2))


# --- starts and sets -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dimensions", [1, 2, 3, 4])
def test_starts_fill_the_ranges_evenly(dimensions):
    """Every box of an eighth of the volume holds its share to within a quarter; chance alone would miss by as much."""
    points = evenly_spread(1000, dimensions)
    assert np.all((points >= 0.0) & (points < 1.0))
    assert np.array_equal(evenly_spread(100, dimensions), points[:100])
    side = 0.125 ** (1.0 / dimensions)
    for corner in np.random.default_rng(0).uniform(0.0, 1.0 - side, (50, dimensions)):
        inside = np.mean(np.all((points >= corner) & (points < corner + side), axis=1))
        assert inside == pytest.approx(0.125, abs=0.03)


def test_sets_are_told_apart_by_where_their_marks_lie():
    draw = np.random.default_rng(1)
    turn = draw.uniform(0.0, 2.0 * math.pi, (3, 400))
    ring = [np.column_stack((np.cos(each), np.sin(each))) for each in turn]
    assert same_set(ring[0], ring[1])
    assert not same_set(ring[0], 1.1 * ring[2])
    assert not same_set(ring[0], ring[1][ring[1][:, 0] > 0.0])  # half of it
    assert within_set(ring[1][:20], ring[0])
    assert not within_set(1.1 * ring[1][:20], ring[0])


# --- settled runs, in plain Python -----------------------------------------------------------------------------------


def test_settled_runs_near_orbits_that_are_known_are_theirs_without_shooting(monkeypatch):
    """That of the nearer one of two, and of none where both are farther than what counts as settled."""
    monkeypatch.setattr(settling_runs, "closed", None)
    map_ = types.SimpleNamespace(section=lambda states: states)
    points = np.array([[0.0], [1.0]]), np.array([[1.5 * settling_runs.NEAR]])
    known = [settling_runs.OrbitPoints(None, point) for point in points]  # type: ignore[arg-type]
    ends = np.array([[0.0], [1.0], [1.4], [0.7], [2.6], [0.9999]]) * settling_runs.NEAR
    found, which = distinct_orbits(map_, ends, np.ones(6, dtype=int), 0, known)  # type: ignore[arg-type]
    assert found == known
    assert list(which) == [0, 1, 1, 0, -1, 1]


# --- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("law", "arguments", "complaint"),
    [
        (None, {"starts": 0}, "starts should be a whole number from 1"),
        (None, {"ranges": {"position": (0, 1)}}, "nothing depends on 'position'"),
        (None, {"ranges": {"speed": (0, 1)}}, "'speed' is no state"),
        (None, {"ranges": {"angle": (1, 0)}}, "ranges: angle should be finite with low < high"),
        (None, {"ranges": {"angle": 1.0}}, "ranges: angle should be two numbers"),
        (None, {"ranges": {}}, "at least one state"),
        (None, {"initial": {"angel": 1.0}}, "did you mean 'angle'"),
        (None, {"settle_periods": 5}, "settle_periods should be"),
        (None, {"tolerance": -1.0}, "tolerance should be"),
        (ElastoPlastic(), {"ranges": {ElastoPlastic.switched[0]: (0, 1)}}, "is a mode of the law"),
    ],
)
def test_bad_input_to_attractors_is_refused(law, arguments, complaint):
    with pytest.raises(ValueError, match=complaint):
        attractors(capsule(law), **arguments)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"over": "friction.attraction"}, "there is no such parameter in this system"),
        ({"over": "machine.normal_load", "system": "weight"}, "should be a parameter that is a number"),
        ({"between": (3.0, 1.0)}, "between should be finite with low < high"),
        ({"between": 3.0}, "between should be two numbers"),
        ({"over": "machine.mass_ratio", "between": (-1.0, 1.0)}, "machine.mass_ratio cannot be -1"),
        ({"points": 1}, "points should be"),
        ({"directions": ("sideways",)}, "directions should be"),
        ({"starts": 0}, "starts should be"),
        ({"kept": 2}, "kept should be"),
    ],
)
def test_bad_input_to_a_diagram_is_refused(arguments, complaint):
    system = capsule(vc.Exponential())
    if arguments.pop("system", None):
        system = system.with_parameters({"machine.normal_load": "weight"})
    settings = {"over": "drive.amplitude", "between": (1.0, 3.0), **arguments}
    with pytest.raises(ValueError, match=complaint):
        bifurcation_diagram(system, **settings)


# --- attractors ------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_exactly_the_two_travelling_twins_attract():
    """The ranges of the starts are symmetric, so that each twin has half of them."""
    system, shares = capsule(), []
    steady = attractors(system, 200, progress=shares.append)
    assert max(shares) == 1.0
    assert all(low == -high and high >= 2.0 for low, high in steady.ranges.values())
    assert "position" not in steady.ranges
    one, other = steady.attractors
    assert (one.twin, other.twin, one.share + other.share) == (1, 0, 1.0)
    assert one.motion.drift + other.motion.drift == pytest.approx(0.0, abs=1e-10)
    assert abs(one.motion.drift) == pytest.approx(0.16434774668148, abs=1e-12)
    assert one.starts == np.sum(steady.label == 0)
    assert 0.4 < one.share < 0.6
    for k in range(0, 200, 67):  # each start on its own
        start = dict(zip(system.state_names, steady.starts[k], strict=True))
        _, path = period_marks(system, periods=150, initial=start)
        drift = path[-1][2] - path[-2][2]
        assert drift == pytest.approx(steady.attractors[steady.label[k]].motion.drift, abs=1e-6)


@pytest.mark.slow
def test_runs_caught_by_unstable_orbits_are_noticed():
    """A start on a symmetric orbit from which travel has branched stays there."""
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic(amplitude=1.6))
    map_ = StroboscopicMap(system, 1e-12)
    stable = vc.orbit(system, initial={"angle": 1.0})
    symmetric = vc.shoot(system, vc.orbit(system.with_parameters({"drive.amplitude": 1.25})).state, half=True)
    starts = np.array([list(orbit.state.values()) for orbit in (symmetric, stable)])
    assert symmetric.unstable
    assert not stable.unstable
    runs = settling_runs.settling_runs(map_, starts, 1000)
    runs.response_period[0] = 1  # as where it looks settled
    found, _, _ = attractors_of(map_, runs, 1000)
    assert not any(each.motion.orbit.unstable for each in found)


@pytest.mark.slow
def test_chaos_is_one_attractor_that_is_its_own_mirror_image():
    steady = attractors(CHAOTIC, 60)
    assert [attractor.motion.kind for attractor in steady.attractors] == ["chaotic"]
    assert steady.attractors[0].twin == 0
    assert steady.attractors[0].share + steady.share(NOT_SETTLED) == 1.0
    assert steady.attractors[0].share > 0.97


@pytest.mark.slow
@pytest.mark.parametrize("starts", [20, 300])
def test_rests_of_a_block_are_a_continuum_that_is_not_told_apart(starts):
    """A spring that pulls less than the contact holds: every start comes to rest somewhere else."""
    system = vc.System(vc.Oscillator(damping=0.5), vc.Exponential(), vc.Harmonic(amplitude=0.05))
    steady = attractors(system, starts)
    assert steady.share(NOT_TOLD) == 1.0
    assert steady.attractors == ()


@pytest.mark.slow
def test_failed_runs_are_counted_as_failed(monkeypatch):
    monkeypatch.setattr(settling_runs, "MOST_EVENTS", 1)
    steady = attractors(capsule(vc.Exponential()), 20, {"angle": (-1.0, 1.0)})
    assert steady.share(FAILED) == 1.0
    assert steady.attractors == ()


# --- diagrams --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_diagram_agrees_with_orbits_wherever_it_settled():
    """To the threshold of settling, 1e-6 of natural sizes, times what the drift magnifies it by (some 10)."""
    diagram = bifurcation_diagram(capsule(), "drive.amplitude", (1.1, 2.9), 10)
    assert np.mean(diagram.response_period > 0) > 0.9
    compared = 0
    for d, k in itertools.product(range(len(diagram.directions)), range(0, 10, 2)):
        start = k // 2 % 2  # the second is recorded by its mirror image
        if (n := diagram.response_period[d, start, k]) < 1:
            continue
        state = dict(zip(diagram.state_names, diagram.states[d, start, k, 0], strict=True))
        orbit = vc.shoot(capsule(**{"drive.amplitude": float(diagram.values[k])}), state, int(n))
        assert (orbit.status, orbit.stable) == (vc.OrbitStatus.CONVERGED, True)
        assert diagram.drift[d, start, k] == pytest.approx(orbit.drift / n, abs=2e-5)
        assert list(orbit.state.values()) == pytest.approx(list(state.values()), abs=2e-5)
        compared += 1
    assert compared > 7


@pytest.mark.slow
def test_a_sweep_leaves_what_becomes_unstable():
    """A pendulum upright on its spring, on a capsule that sticks, buckles below rho = 1: sin(theta) = rho theta."""
    system = capsule(vc.Exponential(), **{"drive.amplitude": 0.0})
    diagram = bifurcation_diagram(system, "machine.stiffness", (0.5, 1.5), 11, starts=2, settle_periods=1000)
    down = diagram.states[1, :, 0, 0, 0]
    buckled = 1.8954942670339812  # root of sin(x) = x/2
    assert math.sin(buckled) == pytest.approx(0.5 * buckled, abs=1e-15)
    assert np.abs(down) == pytest.approx([buckled, buckled], abs=1e-5)
    assert down[0] == pytest.approx(-down[1], abs=1e-5)
    assert diagram.states[1, 0, -1, 0, 0] == pytest.approx(0.0, abs=1e-5)
