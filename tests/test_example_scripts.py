"""Programs of `examples/`: a path steered by a schedule of the drive, and an environment of Gymnasium.

A schedule arrives by motions of the case's own drive, one for each phase. An episode is the stepper under its actions,
and its measures are those of the stepper's motion.
"""

import importlib.util
import warnings
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc

EXAMPLES = Path(__file__).parents[1] / "examples"
BENCH = EXAMPLES / "bench-in-si.toml"


def program(name):
    """A program of the examples, as a module."""
    specification = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


@pytest.fixture
def steering():
    return program("steering")


@pytest.fixture(scope="module")
def travel():
    pytest.importorskip("gymnasium", reason="gymnasium is not installed")
    return program("travel_environment")


# --- steering --------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_schedule_passes_its_waypoints_by_motions_of_the_own_drive(steering, tmp_path):
    case, out, waypoints, tolerance = vc.read_case(BENCH), tmp_path / "path.toml", (0.25, 0.1), 0.005
    asked = [str(BENCH), "--tolerance", str(tolerance), "--out", str(out), "--", *map(str, waypoints)]
    paths = [path for path in case.system.parameter_paths if path.startswith("drive.") and path.endswith("amplitude")]
    amplitudes = {path: case.system.parameter(path) for path in paths}
    legs, state, time = steering.main(asked), dict(case.initial), 0.0
    for leg, waypoint in zip(legs, waypoints, strict=True):
        for periods, factor in ((leg.periods, leg.factor), (4.0, 0.0)):
            part = case.system.with_parameters({path: factor * value for path, value in amplitudes.items()})
            motion = vc.simulate(part, periods=int(periods), initial=state, tolerance=1e-12)
            assert motion.certificate.ok
            state, time = motion.state, time + motion.end
        assert abs(state["position"] - waypoint) <= tolerance
        assert state["velocity"] == 0.0
    path = vc.read_case(out)
    whole = vc.simulate(path.system, initial=path.initial, **path.run)
    assert whole.state["position"] == pytest.approx(state["position"], abs=1e-7)
    assert whole.end == pytest.approx(time)


@pytest.mark.slow
def test_a_waypoint_that_no_schedule_holds_is_refused(steering, monkeypatch):
    monkeypatch.setattr(steering, "LONGEST", 3)
    case = vc.read_case(EXAMPLES / "travels-by-stick-slip.toml")
    steep = vc.System(**case.system.parts, environment=vc.Environment(inclination=0.5))
    for system, waypoint in ((case.system, 5.0), (steep, -3.0)):  # too far; it slides down while its drive pauses
        with pytest.raises(SystemExit, match=r"no burst of at most 3 periods .* the nearest end is .* away"):
            steering.steered(vc.Case(system, case.initial), [waypoint], 0.01)
    with pytest.raises(SystemExit, match="one to 3 waypoints, got 4"):
        steering.steered(case, [1.0, 2.0, 3.0, 4.0], 0.01)


# --- Gymnasium -------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_the_environment_passes_the_check_of_gymnasium(travel):
    from gymnasium.utils.env_checker import check_env

    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        check_env(travel.TravelEnvironment(BENCH, length=0.05, limit=0.7, spread={"angle": 0.5}))
    texts = [str(each.message) for each in warned]
    allowed = ("Box observation space", "not having a spec")  # states are unbounded; made without `gymnasium.make`
    assert [text for text in texts if not any(part in text for part in allowed)] == []


@pytest.mark.plain
def test_an_episode_is_the_stepper_under_its_actions_in_si_with_its_measures(travel):
    measures = ["displacement", "mean_velocity", "stick_fraction"]
    environment = travel.TravelEnvironment(BENCH, length=0.05, limit=0.7, effort_cost=0.1, steps=40, measures=measures)
    motion, total = vc.stepper(vc.read_case(BENCH), input="drive", tolerance=1e-10), 0.0
    observation, info = environment.reset(seed=3)
    assert observation.tolist() == pytest.approx([np.pi / 6, 0.0, 0.0, *motion.sides])
    for k, action in enumerate(np.random.default_rng(7).uniform(-1.0, 1.0, 40)):
        observation, reward, terminated, truncated, info = environment.step([action])
        motion.step(0.7 * action, 0.05)
        total += reward + 0.1 * (0.7 * action) ** 2 * 0.05
        assert observation.tolist() == [*np.delete(motion.states, 2), *motion.sides]
        assert (terminated, truncated) == (False, k == 39)
    assert (info["time"], info["events"]) == (motion.time, motion.events)
    assert total == pytest.approx(motion["position"], abs=1e-12)
    assert abs(motion["position"]) > 1e-3
    assert info["measures"]["displacement"] == pytest.approx(motion["position"], abs=1e-9)  # metres
    assert info["measures"]["mean_velocity"] == pytest.approx(motion["position"] / 2.0, abs=1e-9)


@pytest.mark.slow
def test_a_lift_off_ends_an_episode_with_its_status(travel, tmp_path):
    light = vc.PendulumCapsule(mass_ratio=0.2, normal_load="dynamic")
    path = vc.save_case(vc.System(light, vc.Coulomb(), vc.Harmonic()), tmp_path / "light.toml")
    environment = travel.TravelEnvironment(path, length=0.2, limit=3.0, measures=["displacement"])
    environment.reset(seed=0)
    for _ in range(100):
        _, _, terminated, truncated, info = environment.step([1.0])
        if terminated:
            break
    assert (terminated, truncated, info["status"]) == (True, False, "lift off")
    assert "measures" not in info


@pytest.mark.parametrize("name", ["crawler-with-two-phases", "sticks-and-slips-on-a-belt", "tracks-its-best-stroke"])
def test_a_case_that_no_policy_drives_is_refused(travel, name):
    with pytest.raises(ValueError, match="should have a machine that travels, driven by a force or torque"):
        travel.TravelEnvironment(EXAMPLES / f"{name}.toml", length=0.1, limit=1.0)
