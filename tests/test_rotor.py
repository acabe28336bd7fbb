"""The rotor capsule: a motion that has turned by whole turns is where it was, in everything that asks whether it is."""

import dataclasses
import math
from typing import ClassVar

import numpy as np
import pytest

import vibrocap as vc
from independent import motion as independent_motion
from planted import planted
from thinned import exhaustive_but
from vibrocap.measures.recorded.settling import settling, stroboscopic_states
from vibrocap.motion.recording.section import brought_back, section_states
from vibrocap.numerics.linker import kernel_source
from vibrocap.orbits.maps.stroboscopic_map import state_vector

TURN = 2.0 * math.pi
LAW = vc.Coulomb(coulomb_coefficient=0.1, static_coefficient=0.15)
# One turn of a rotor (lambda 4, nu 0.75) under the torque 1.5: period and drift, computed beforehand by DOP853.
PUBLISHED = {"weight": (3.41235843634, -0.32074253582), "dynamic": (3.42870348816, 0.51782778013)}
START = {"angle": 0.1}


def rotor(load="weight", drive=None, **parameters):
    machine = vc.RotorCapsule(**({"mass_ratio": 4.0, "damping": 0.75, "normal_load": load} | parameters))
    return vc.System(machine, LAW, drive or vc.Constant(force=1.5))


def pulsed(**parameters):
    """A motor under two levels of torque in turn: two steady motions, of one turn and of two a period."""
    return rotor(drive=vc.Square(**({"amplitude": 1.6, "frequency": 0.7, "duty": 0.8} | parameters)))


def gained(orbit):
    """What the states gain in the period of an orbit, by the solver of `independent.py`."""
    end = independent_motion(orbit.system, orbit.state, orbit.period / orbit.system.drive.period)
    assert end.status == "finished"
    return {name: end.state[name] - value for name, value in orbit.state.items()}


def turn_of(orbit):
    """What they gain by a turn on an orbit that closes."""
    return dict.fromkeys(orbit.state, 0.0) | {"angle": TURN, "position": orbit.drift}


@pytest.mark.slow
@pytest.mark.parametrize("load", exhaustive_but([1], [*PUBLISHED]))
def test_a_turn_is_that_of_an_independent_solver(load):
    orbit = vc.orbit(rotor(load), initial=START, settle_periods=100)
    assert orbit.closes
    assert orbit.stable
    assert orbit.winding == {"angle": 1}
    assert (orbit.period, orbit.drift) == pytest.approx(PUBLISHED[load], abs=1e-11)
    assert gained(orbit) == pytest.approx(turn_of(orbit), abs=1e-10)
    motion = orbit.motion()
    own = [motion.state[name] - orbit.state[name] for name in ("angle", "position")]
    assert own == pytest.approx([TURN, orbit.drift], abs=1e-10)
    assert "1 turn(s) of angle" in str(orbit)


@pytest.mark.slow
def test_what_turns_by_whole_turns_has_settled():
    """One whose angle grows by 2 pi a period has settled as one that rests has; one that creeps has not."""
    motion = vc.simulate(pulsed(), periods=60, initial=START)
    verdict = settling(motion)
    assert verdict.settled
    assert verdict.period == 1
    assert vc.winding(motion) == pytest.approx({"angle": 2.0}, abs=1e-9)
    assert motion.state["angle"] > 100 * TURN
    # A planted fault: the same marks without the turns taken off never repeat.
    plain = dataclasses.replace(pulsed(), machine=Unturned(mass_ratio=4.0, damping=0.75))
    assert not settling(vc.simulate(plain, periods=60, initial=START)).settled
    marks = stroboscopic_states(motion)
    sections = motion.sections.copy()
    sections[:, 0] += TURN * np.arange(len(sections)) ** 2
    moved = stroboscopic_states(dataclasses.replace(motion, sections=sections))
    assert moved == pytest.approx(marks, abs=1e-10)
    assert np.hypot(marks[:, 0], marks[:, -1]) == pytest.approx(1.0, abs=1e-15)


@planted(vc.RotorCapsule)
class Unturned:
    """The same machine, which does not say that its angle turns."""

    name: ClassVar[str] = "unturned"
    turns: ClassVar = {}


@pytest.mark.slow
def test_orbits_close_modulo_turns_and_branches_keep_their_winding():
    one = vc.orbit(pulsed(), initial=START)
    assert one.closes
    assert one.stable
    assert one.winding == {"angle": 2}
    far = {**one.state, "angle": one.state["angle"] - 5 * TURN}
    again = vc.shoot(pulsed(), far)
    assert again.closes
    assert again.state == pytest.approx(one.state, abs=1e-9)
    branch = vc.branch(pulsed(), "drive.amplitude", (1.57, 1.66), orbit=one, points=60)
    assert len(branch) > 20
    assert set(branch.winding.ravel()) == {2}
    assert branch.certified.all()
    for point in (0, len(branch) // 2, -1):
        system = pulsed(amplitude=float(branch.parameter[point]))
        start = dict(zip(system.state_names, branch.states[point], strict=True))
        motion = vc.simulate(system, periods=1, initial=start, tolerance=1e-12)
        gained = np.array(list(motion.state.values())) - branch.states[point]
        assert gained == pytest.approx([2 * TURN, 0.0, branch.drift[point], 0.0], abs=1e-9)
    table = branch.to_xarray()
    assert set(table["winding_angle"].values) == {2}


@pytest.mark.slow
def test_a_rotor_that_has_stopped_comes_to_rest():
    """It turned seven times before: what it did on the way is no cycle, nor does it ask for more returns."""
    stopping = rotor(drive=vc.Constant(force=0.3), damping=0.2)
    for start in ({"angle": 0.1}, {"angle": 0.1, "angle_rate": 5.0}):
        orbit = vc.orbit(stopping, initial=start, settle_periods=400)
        assert orbit.status is vc.OrbitStatus.COMES_TO_REST
        assert not orbit.closes
        assert "stability" not in str(orbit) or "not known" in str(orbit)
    again = vc.orbit(rotor(drive=vc.Constant(force=0.6), damping=0.2), initial=START, settle_periods=100)
    assert (again.period, again.drift) == pytest.approx((2.368956199, -0.1710018514), abs=1e-8)


# Friction that falls with speed, and a motor whose torque hardly falls: two speeds between these torques (Sommerfeld).
@pytest.mark.slow
def test_starts_lead_to_attractors_of_one_and_two_turns():
    steady = vc.attractors(pulsed(), 60)
    assert sorted(attractor.motion.winding["angle"] for attractor in steady.attractors) == [1.0, 2.0]
    assert steady.ranges["angle"] == pytest.approx((-math.pi, math.pi))
    planes = [
        vc.basins(pulsed(), {"angle": (low, low + TURN), "angle_rate": (-1.0, 2.0)}, 8) for low in (0.0, 3 * TURN)
    ]
    assert len({*planes[0].label.ravel().tolist()}) == 2
    assert (planes[0].label == planes[1].label).all()  # starts whole turns apart are one start
    assert planes[0].drift == pytest.approx(planes[1].drift, abs=1e-9)


@pytest.mark.slow
def test_a_mirrored_motion_is_one_modulo_turns():
    """Under an odd drive a motion that swings through the top by half a turn each way is its own mirror image."""
    system = rotor(drive=vc.Harmonic(amplitude=2.2, frequency=1.0))
    orbit = vc.orbit(system, initial=START)
    assert orbit.closes
    assert orbit.symmetric
    assert orbit.drift == 0.0
    unlike = vc.shoot(system, orbit.mirrored_state)
    assert unlike.state == pytest.approx(orbit.state, abs=1e-8)


def test_states_are_brought_back_to_the_first_turn():
    system = rotor()
    state = state_vector(system, {"angle": 3 * TURN + 0.2, "position": 5.0, "velocity": 0.1})
    assert brought_back(system, state) == pytest.approx([0.2, 0.0, 0.0, 0.1], abs=1e-14)
    other = dataclasses.replace(system, machine=vc.PendulumCapsule())
    assert brought_back(other, state)[0] == state[0]


def test_a_kernel_remembers_both_coordinates_of_an_angle():
    """The mark of a run is the section of a stored motion, and differs where the angle is the other way round."""
    system = rotor()
    scales = np.array([0.5, 1.0, 2.0, 4.0])
    states = np.array([[0.7, 0.3, 9.0, 0.2], [-0.7, 0.3, 1.0, 0.2], [0.7 + 3 * TURN, 0.3, 2.0, 0.2]])
    places = {"LANES": 1, "STATES": 4, "MARK_SIZE": 5, "MARK_COUNT": 3, "STATE": 0, "SCALE": 4, "MARKS": 8, "WORK": 0}
    turning = {"CYCLIC": 2, "TURN_COUNT": 1, "TURN_STATES": (0,), "TURN_RADII": (1.0,)}
    kernel = {"math": math, **places, **turning}
    exec(kernel_source("observe.settle"), kernel)
    floats = [0.0] * 4 + scales.tolist() + [0.0] * 15
    for mark, state in enumerate(states):
        floats[:4] = state.tolist()
        kernel["remember"](floats, places["MARKS"], 0, mark)
    sections = section_states(system, states, scales)
    kept = np.array(floats[8:]).reshape(3, 5)[:, [0, 1, 3, 4]]
    assert kept == pytest.approx(sections, abs=1e-14)
    assert kernel["difference"](floats, 8, 0, 0, 1) == pytest.approx(2.0 * math.sin(0.7) / 0.5)
    assert kernel["difference"](floats, 8, 0, 0, 2) == pytest.approx(0.0, abs=1e-13)
