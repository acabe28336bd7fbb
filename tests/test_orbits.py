"""Steady motions: closed by shooting, their drift, multipliers and twins, and what is said where none is found."""

import dataclasses
import math

import numpy as np
import pytest

import vibrocap as vc
from thinned import exhaustive_but
from vibrocap.motion.simulate import period_marks
from vibrocap.orbits.closing import shooting
from vibrocap.orbits.closing.orbit import shoot
from vibrocap.orbits.maps import stroboscopic_map
from vibrocap.orbits.maps.stroboscopic_map import StroboscopicMap

START = {"angle": math.pi / 3}
NEAR = {  # the first set of docs/model.md, after 40 periods
    "exponential": {"angle": 0.61055219, "angle_rate": 1.50592954, "velocity": 0.2974614},
    "lugre": {"angle": 0.612854564, "angle_rate": 1.50530877, "velocity": 0.285652635, "bristle": 0.00150072416},
}
LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre()}
DRIFTS = {"exponential": 0.1643477, "lugre": 0.1071890}  # there, LM not quite settled yet


def system_with(law, **parameters):
    system = vc.System(vc.PendulumCapsule(), law, vc.Harmonic())
    return system.with_parameters(parameters) if parameters else system


def plain_map(system, tolerance=1e-10):
    return StroboscopicMap(system, tolerance, threads=1, plain=True)


def near_orbit(system, start, **options):
    """The orbit to which shooting comes from this start, no periods before."""
    return shoot(system, start, map_=StroboscopicMap(system, 1e-10, threads=1), **options)


def random_system(law, seed):
    draw = np.random.default_rng([seed, len(law)])
    low, high = (1.0, 1.5, 0.8, 1.0, 0.7), (5.0, 5.0, 1.5, 3.0, 1.5)
    paths = ("machine.mass_ratio", "machine.stiffness", "machine.damping", "drive.amplitude", "drive.frequency")
    system = system_with(LAWS[law], **dict(zip(paths, draw.uniform(low, high).tolist(), strict=True)))
    start = np.array([draw.uniform(-1, 1), draw.uniform(-1, 1), 0.0, draw.uniform(-0.5, 0.5), 0.002])
    return system, start[: len(system.state_names)]


def differences(system, start, step=1e-6):
    """Derivative of the map over one period by central differences of single runs."""
    map_ = StroboscopicMap(system, 1e-13)
    scales = map_.scales(map_.parameters())

    def end(state):
        initial = dict(zip(system.state_names, state, strict=True))
        return vc.simulate(system, periods=1, initial=initial, tolerance=1e-13).sections[1][: len(start)] / scales

    moves = step * np.diag(scales)
    return np.array([(end(start + move) - end(start - move)) / (2 * step) for move in moves]).T


# --- the map and its derivative --------------------------------------------------------------------------------------


def test_derivative_goes_through_stick_and_slip():
    """Against differences of neighbouring runs, whose own error is about 1e-10/1e-5 by rounding of the tolerance."""
    system = system_with(vc.Exponential())
    map_ = plain_map(system, 1e-11)
    start = np.array([[0.61, 1.5, 0.0, 0.3]])
    step = 1e-5
    moves = np.repeat(start, 8, axis=0) + step * np.concatenate([np.eye(4), -np.eye(4)])
    parameters = np.tile(map_.parameters(), (9, 1))
    with np.errstate(all="ignore"):
        exact = map_.images(start, parameters[:1]).jacobian[0]
        ends = map_.images(moves, parameters[:8], tangents=False).state
    expected = (ends[:4] - ends[4:]).T / (2 * step)
    assert exact == pytest.approx(expected, abs=1e-5)
    assert np.max(np.abs(exact)) > 0.5
    assert exact[:, 2] == pytest.approx([0.0, 0.0, 1.0, 0.0], abs=1e-12)  # the position is cyclic


@pytest.mark.slow
@pytest.mark.parametrize("seed", exhaustive_but([3], range(4)))
@pytest.mark.parametrize("law", LAWS)
def test_multipliers_are_those_of_differences(law, seed):
    system, start = random_system(law, seed)
    map_ = StroboscopicMap(system, 1e-12)
    scales = map_.scales(map_.parameters())
    images = map_.images(start[None], map_.parameters()[None])
    exact = images.jacobian[0] * scales / scales[:, None]
    expected = differences(system, start)
    assert exact == pytest.approx(expected, abs=1e-6 * max(1.0, np.max(np.abs(expected))))
    ours, theirs = (np.sort(np.abs(np.linalg.eigvals(matrix))) for matrix in (exact, expected))
    assert ours == pytest.approx(theirs, abs=1e-6 * max(1.0, ours[-1]))


# --- orbits ----------------------------------------------------------------------------------------------------------


def test_orbit_closes_and_drifts_as_the_simulation_does():
    orbit = near_orbit(system_with(vc.Exponential()), NEAR["exponential"])
    assert orbit.status is vc.OrbitStatus.CONVERGED
    assert orbit.residual < 1e-11
    assert orbit.drift == pytest.approx(DRIFTS["exponential"], abs=5e-8)
    assert orbit.stable
    assert orbit.symmetric is False
    assert orbit.multipliers[-1] == 0.0  # sticking forgets a direction
    assert orbit.state["position"] == 0.0


def test_symmetric_orbit_among_the_twins_is_found_unstable_and_does_not_drift():
    orbit = near_orbit(system_with(vc.Exponential()), NEAR["exponential"], half=True)
    assert orbit.status is vc.OrbitStatus.CONVERGED
    assert orbit.symmetric
    assert orbit.drift == 0.0
    assert not orbit.stable
    assert orbit.multipliers[0].real > 1.5


@pytest.mark.slow
@pytest.mark.parametrize("law", exhaustive_but([0], [*LAWS]))
def test_drift_is_that_of_a_long_simulation_and_the_twin_goes_the_other_way(law):
    system = system_with(LAWS[law])
    orbit = vc.orbit(system, initial=START)
    assert orbit.response_period == 1
    assert orbit.drift == pytest.approx(DRIFTS[law], abs=1e-5 if law == "lugre" else 5e-8)
    _, sections = period_marks(system, periods=2000, initial=START, tolerance=1e-12)
    column = system.state_names.index("position")
    assert orbit.drift == pytest.approx(sections[-1][column] - sections[-2][column], abs=1e-10)
    twin = orbit.twin()
    assert twin.status is vc.OrbitStatus.CONVERGED
    assert twin.drift == pytest.approx(-orbit.drift, abs=1e-12)
    assert np.abs(twin.multipliers) == pytest.approx(np.abs(orbit.multipliers), abs=1e-8)
    assert orbit.motion()["position"][-1] == pytest.approx(orbit.drift, abs=1e-10)
    assert orbit.mode_sequence == {"exponential": "FBSB", "lugre": "FBFB"}[law]
    still = vc.orbit(system.with_parameters({"machine.stiffness": 4.0, "machine.damping": 1.2}), initial=START)
    assert (still.symmetric, still.drift, still.stable) == (True, 0.0, True)
    assert still.twin() is still


# --- systems that nothing drives in time -----------------------------------------------------------------------------


@pytest.mark.slow
def test_block_on_a_belt_with_static_and_kinetic_friction():
    """docs/model.md: period 2D/v + (2/w)(pi - atan(w D/v)); sticking forgets all but the way along the cycle."""
    level, speed, k = 0.25, 0.1, 2.0
    belt = vc.System(
        vc.Oscillator(mass=1.0, stiffness=k, damping=0.0, belt_speed=speed),
        vc.Coulomb(static_coefficient=1.5, coulomb_coefficient=1.0),
        vc.Constant(),
    )
    orbit = vc.orbit(belt, settle_periods=200)
    w = math.sqrt(k)
    assert orbit.status is vc.OrbitStatus.CONVERGED
    assert orbit.period == pytest.approx(
        2 * level / speed + 2 / w * (math.pi - math.atan(w * level / speed)), abs=1e-12
    )
    assert list(orbit.multipliers) == [0.0]


# --- what goes wrong -------------------------------------------------------------------------------------------------


def test_a_search_that_ends_early_says_so_and_gives_its_last_state(monkeypatch):
    monkeypatch.setattr(shooting, "MOST_STEPS", 1)
    orbit = near_orbit(system_with(vc.Exponential()), {"angle": 1.5, "angle_rate": -1.0})
    assert orbit.status is vc.OrbitStatus.NOT_CONVERGED
    assert "nearer" in orbit.status.advice
    assert 1e-9 < orbit.residual < 10.0


def test_a_run_that_fails_is_no_orbit(monkeypatch):
    monkeypatch.setattr(stroboscopic_map, "MOST_STEPS", 5)
    orbit = near_orbit(system_with(vc.Exponential()), NEAR["exponential"])
    assert (orbit.status, orbit.mode_sequence) == (vc.OrbitStatus.RUN_FAILED, "")
    lost = dataclasses.replace(orbit, state=dict.fromkeys(orbit.state, math.nan))
    assert lost.mode_sequence == ""
    with pytest.raises(ValueError, match="orbit: has no motion, as no state of it is known: run failed"):
        lost.motion()


@pytest.mark.parametrize(
    ("function", "arguments", "complaint"),
    [
        (shoot, {"start": {"speed": 1.0}}, "start should name states"),
        (shoot, {"start": START, "response_period": 0}, "response_period should be a whole number"),
        (shoot, {"start": START, "response_period": 2, "half": True}, "response_period should be odd"),
        (vc.orbit, {"initial": START, "response_period": 0}, "response_period should be a whole number"),
        (vc.orbit, {"initial": START, "settle_periods": 0}, "settle_periods should be a whole number"),
        (vc.orbit, {"initial": START, "tolerance": 1.0}, "tolerance should be a number from"),
    ],
)
def test_bad_input_is_refused(function, arguments, complaint):
    with pytest.raises(ValueError, match=complaint):
        function(system_with(vc.Exponential()), **arguments)


def test_half_period_search_needs_the_symmetry():
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Biharmonic(second_amplitude=0.3))
    with pytest.raises(ValueError, match="no half-period symmetry"):
        shoot(system, START, half=True)
