"""A law under an imposed motion: closed forms, an independent solver, many parameter sets, and what it refuses."""

import math
from unittest import mock

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg

import vibrocap as vc
from driven_laws import Chain, Chatter, Held, Play, on_plain_python, uneven, wandering
from thinned import slow_but
from vibrocap.laboratory.driven import driven_force, driven_forces
from vibrocap.motion.status import Status

PAPER = vc.LuGre()
FLAT = {"coulomb_coefficient": 0.3, "static_coefficient": 0.3}  # g is constant


# --- closed forms ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("velocity", [0.07, -0.2])
@pytest.mark.parametrize("stiffness", [1e2, 1e6])
def test_bristles_at_constant_velocity(velocity, stiffness):
    """xi = g sgn v + (xi0 - g sgn v) exp(-|v| t/g) (PHYSICS section 2), with the force that follows from it."""
    law = vc.LuGre(bristle_stiffness=stiffness, viscous_damping=0.3)
    g = (0.15 + 0.3 * math.exp(-((velocity / 0.1) ** 2))) / stiffness
    time = uneven(np.random.default_rng(1), 40, 6.0 * g / abs(velocity)) + 3.0
    start = -0.8 * g * np.sign(velocity)
    found = driven_force(law, time, np.full(40, velocity), internal=start, tolerance=1e-11)
    end = g * np.sign(velocity)
    decay = np.exp(-abs(velocity) * (time - 3.0) / g)
    bristle = end + (start - end) * decay
    rate = (end - start) * abs(velocity) / g * decay
    assert found.status is Status.FINISHED
    assert found.internal[:, 0] == pytest.approx(bristle, abs=1e-9 * g)
    force = stiffness * bristle + 10.0 * rate + 0.3 * velocity
    assert found.force == pytest.approx(force, abs=1e-9 * (stiffness * g + 10.0 * abs(velocity)))


def test_quasi_static_loop():
    """At constant g: |xi|max = g tanh(A/g), loop area 4 Fc [A - g tanh(A/g)] (PHYSICS section 5)."""
    law = vc.LuGre(bristle_stiffness=20.0, bristle_damping=0.0, **FLAT)
    g, cycle, cycles = 0.3 / 20.0, 4000, 8
    time = np.linspace(0.0, 2.0 * np.pi * cycles, cycle * cycles + 1)
    velocity = 0.02 * np.cos(time)
    force = driven_force(law, time, velocity, tolerance=1e-10)
    position = scipy.integrate.cumulative_trapezoid(velocity, time, initial=0.0)
    amplitude = 0.5 * np.ptp(position)  # of the motion as sampled
    last = slice(-cycle - 1, None)
    deflection = g * math.tanh(amplitude / g)
    assert np.abs(force.internal[last]).max() == pytest.approx(deflection, rel=1e-8)
    area = np.trapezoid((force.force * velocity)[last], time[last])
    assert area == pytest.approx(4.0 * 0.3 * (amplitude - deflection), rel=1e-6)


def test_switches_are_located():
    """The closed form of a spring that slips: it follows the motion, cut off at its reach, from turn to turn."""
    rng = np.random.default_rng(2)
    time = uneven(rng, 60, 10.0)
    velocity = wandering(rng, time, 0.4)
    load = 2.0 + np.sin(time)
    law = Play()
    force = driven_force(law, time, velocity, load=load, internal=(0.0, 0.05, 0.0))
    spring, slipped, slips, expected, slipping, distance = 0.05, 0.0, 0, [0.05], [0.0], [0.0]
    for i in range(1, len(time)):
        v0, v1, span = velocity[i - 1], velocity[i], time[i] - time[i - 1]
        turn = v0 / (v0 - v1) if v0 * v1 < 0.0 else 1.0
        for moved in (0.5 * turn * span * (v0 + (v1 if turn == 1.0 else 0.0)), 0.5 * (1.0 - turn) * span * v1):
            before, spring = spring, min(law.reach, max(-law.reach, spring + moved))
            slipped += moved - (spring - before)
        expected.append(spring)
        distance.append(slipped)
        slipping.append(float(abs(spring) == law.reach))
        slips += slipping[-1] > slipping[-2]
    assert slips >= 3
    assert force.internal[:, 1] == pytest.approx(np.array(expected), abs=1e-12)
    assert force.internal[:, 2] == pytest.approx(np.array(distance), abs=1e-12)
    assert force.internal[:, 0].tolist() == slipping
    assert force.force == pytest.approx(load * law.stiffness * np.array(expected), abs=1e-11)


def test_coupled_states():
    """A linear law under a velocity and a load that are linear between samples, by the matrix exponential."""
    rng = np.random.default_rng(3)
    time = uneven(rng, 30, 4.0)
    velocity, load = wandering(rng, time, 1.0), 1.0 + 0.5 * np.sin(time)
    law = Chain()
    with on_plain_python(law):
        force = driven_force(law, time, velocity, load=load, internal=(0.3, -0.2, 0.1), tolerance=1e-11)
    state, expected = np.array([0.3, -0.2, 0.1]), [0.3 - 0.2 + 0.1]
    by_signal = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    for i in range(1, len(time)):
        span = time[i] - time[i - 1]
        ints = np.zeros((7, 7))  # of the states, velocity and load, and the rates of these
        ints[:3, :3], ints[:3, 3:5], ints[3:5, 5:] = law.rate * law.matrix, by_signal, np.eye(2)
        before = np.array([velocity[i - 1], load[i - 1]])
        signals = np.concatenate((before, (np.array([velocity[i], load[i]]) - before) / span))
        state = (scipy.linalg.expm(ints * span) @ np.concatenate((state, signals)))[:3]
        expected.append(state.sum())
    assert force.force == pytest.approx(np.array(expected), abs=1e-9)


# --- an independent solver -------------------------------------------------------------------------------------------


def radau(law, time, velocity, bristle):
    """Bristle deflection at every sample by SciPy's Radau, from kink to kink."""
    values = [bristle]
    for i in range(1, len(time)):
        t0, t1, v0, v1 = time[i - 1], time[i], velocity[i - 1], velocity[i]
        turn = [t0 + (t1 - t0) * v0 / (v0 - v1)] if v0 * v1 < 0.0 else []
        for start, end in zip([t0, *turn], [*turn, t1], strict=True):
            middle = v0 + (v1 - v0) * (0.5 * (start + end) - t0) / (t1 - t0)
            side = math.copysign(1.0, middle)

            def rate(t, z, t0=t0, t1=t1, v0=v0, v1=v1, side=side):
                v = v0 + (v1 - v0) * (t - t0) / (t1 - t0)
                return law.force(v, (z[0],), side, 1.0)[1]

            scale = law.static_coefficient / law.bristle_stiffness
            run = scipy.integrate.solve_ivp(
                rate, (start, end), [bristle], method="Radau", rtol=1e-11, atol=1e-11 * scale
            )
            assert run.success
            bristle = run.y[0, -1]
        values.append(bristle)
    return np.array(values)


@pytest.mark.parametrize(("stiffness", "seed"), slow_but([0], [(1e2, 4), (1e5, 5)]))
def test_against_radau(stiffness, seed):
    """Both work to 1e-11 of the deflection, or a little worse where errors add up."""
    law = vc.LuGre(bristle_stiffness=stiffness, stribeck_velocity=0.05)
    rng = np.random.default_rng(seed)
    time = uneven(rng, 11, 3.0 if stiffness < 1e3 else 0.3)
    velocity = wandering(rng, time, 0.15)
    assert np.count_nonzero(velocity[1:] * velocity[:-1] < 0.0) >= 2
    force = driven_force(law, time, velocity, tolerance=1e-11)
    scale = law.static_coefficient / stiffness
    assert force.internal[:, 0] == pytest.approx(radau(law, time, velocity, 0.0), abs=3e-10 * scale)


# --- many parameter sets ---------------------------------------------------------------------------------------------


NAMES = ("bristle_stiffness", "coulomb_coefficient", "static_coefficient", "stribeck_velocity")


@pytest.fixture(scope="module")
def record():
    """Time, velocity and load of a noisy record that turns often."""
    rng = np.random.default_rng(7)
    time = np.arange(400) / 1024.0
    return time, wandering(rng, time, 0.2) + 0.01 * rng.normal(size=400), 1.0 + 0.1 * np.sin(30.0 * time)


def test_rows_are_single_calls(record):
    """To the bit, whatever the number of threads."""
    time, velocity, load = record
    rng = np.random.default_rng(8)
    values = np.array([1e5, 0.2, 0.4, 0.05]) * np.exp(0.5 * rng.normal(size=(7, 4)))
    values[:, 2] = values[:, 1] + 0.1
    many = driven_forces(PAPER, values, NAMES, time, velocity, load=load, threads=2)
    alone = driven_forces(PAPER, values, NAMES, time, velocity, load=load, threads=1)
    assert many.completed.all()
    assert np.array_equal(many.force, alone.force)
    for row, force in zip(values, many.force, strict=True):
        law = vc.LuGre(**dict(zip(NAMES, row.tolist(), strict=True)))
        assert np.array_equal(driven_force(law, time, velocity, load=load).force, force)
    assert not np.array_equal(many.force[0], many.force[1])


def test_a_row_that_fails_is_named(record):
    """A level of zero leaves no deflection to relax to."""
    time, velocity, _ = record
    values = [[1e5, 0.2, 0.4, 0.05], [1e5, 0.0, 0.0, 0.05], [1e4, 0.2, 0.4, 0.05]]
    forces = driven_forces(PAPER, values, NAMES, time, velocity)
    assert forces.status == (Status.FINISHED, Status.NOT_FINITE, Status.FINISHED)
    assert np.isnan(forces.force[1]).all()
    assert np.isfinite(forces.force[[0, 2]]).all()


def test_shape_parameters_can_be_varied(record):
    """A whole exponent among others takes the general formula, which is rounded off near rest only."""
    time, velocity, _ = record
    with on_plain_python(PAPER, ("stribeck_exponent",)):
        forces = driven_forces(PAPER, [[1.5], [2.0]], ("stribeck_exponent",), time, velocity)
    assert np.abs(forces.force[1] - driven_force(PAPER, time, velocity).force).max() < 1e-8
    assert np.abs(forces.force[0] - forces.force[1]).max() > 1e-3


# --- samples ---------------------------------------------------------------------------------------------------------


def test_samples_on_the_line_change_nothing(record):
    time, velocity, load = record
    law = vc.LuGre(bristle_stiffness=1e4)
    rng = np.random.default_rng(9)
    extra = np.sort(np.concatenate((time, rng.uniform(0.0, time[-1], 300))))
    few = driven_force(law, time, velocity, load=load, tolerance=1e-8)
    many = driven_force(law, extra, np.interp(extra, time, velocity), load=np.interp(extra, time, load), tolerance=1e-8)
    there = np.searchsorted(extra, time)
    assert np.abs(many.internal[there] - few.internal).max() <= 1e-7 * 0.45 / 1e4
    assert np.abs(many.force[there] - few.force).max() <= 1e-5


def test_constant_load_is_a_load_of_equal_samples(record):
    time, velocity, _ = record
    one = driven_force(PAPER, time, velocity, load=0.7)
    assert np.array_equal(one.force, driven_force(PAPER, time, velocity, load=np.full(len(time), 0.7)).force)
    assert np.abs(one.force - driven_force(PAPER, time, velocity).force).max() > 0.01


@pytest.mark.parametrize("stiffness", [1e5, 1e6, 1e7, 1e8])
def test_stiff_bristles_stay_within_bounds(record, stiffness):
    """|xi| <= g(0), and a run at a loose tolerance is near one at a tight one."""
    time, velocity, _ = record
    law = vc.LuGre(bristle_stiffness=stiffness, bristle_damping=math.sqrt(stiffness), stribeck_velocity=1e-3)
    loose, tight = (driven_force(law, time, velocity, tolerance=tolerance) for tolerance in (1e-6, 1e-12))
    scale = law.static_coefficient / stiffness
    assert np.abs(loose.internal).max() <= scale * (1 + 1e-5)
    assert np.abs(loose.internal - tight.internal).max() <= 1e-5 * scale


def test_long_samples_see_the_drop_of_friction():
    """From rest to ten Stribeck velocities in one interval: a single step has no stage where friction drops."""
    law = vc.LuGre(bristle_stiffness=1e4, stribeck_velocity=1e-3)
    time, velocity = np.array([0.0, 1e-3, 2e-3]), np.array([-1e-2, 1e-2, -1e-2])
    load = np.array([1.0, 1.4, 0.8])
    fine_time = np.linspace(0.0, 2e-3, 2001)
    fine_velocity, fine_load = (np.interp(fine_time, time, values) for values in (velocity, load))
    fine = driven_force(law, fine_time, fine_velocity, load=fine_load, tolerance=1e-12, internal=-1e-5)

    def error(**faults):
        with on_plain_python(law) as names, mock.patch.dict(names, faults):
            coarse = driven_force(law, time, velocity, load=load, tolerance=1e-4, internal=-1e-5)
        return np.abs(coarse.internal[:, 0] - fine.internal[::1000, 0]).max() / (0.45 / 1e4)

    assert error() <= 1e-5
    assert error(RESOLVED=math.inf) > 1e-4


# --- laws without internal states ------------------------------------------------------------------------------------


def test_set_valued_law_at_rest():
    """R(v) while it moves; at rest, the side of the last motion; before any motion, 0."""
    law = vc.Exponential()
    velocity = np.array([0.0, 0.0, 0.2, 0.0, -0.1, 0.0, 0.0])
    force = driven_force(law, np.arange(7.0), velocity, load=2.0)
    moving = 2.0 * (0.15 + 0.3 * np.exp(-10.0 * np.array([0.2, 0.1])))
    assert force.force == pytest.approx([0.0, 0.0, moving[0], 0.9, -moving[1], -0.9, -0.9], rel=1e-14)
    assert force.internal.shape == (7, 0)
    rows = driven_forces(law, [[10.0], [3.0]], ("decay_rate",), np.arange(7.0), velocity, load=2.0)
    assert np.array_equal(rows.force[0], force.force)
    assert rows.force[1, 2] == pytest.approx(2.0 * (0.15 + 0.3 * math.exp(-0.6)), rel=1e-14)


def test_set_valued_law_with_states_at_rest():
    """Its states are followed; its force is 0 before the first motion too."""
    law = Held()
    with on_plain_python(law):
        force = driven_force(law, np.arange(5.0), [0.0, 0.0, 0.1, 0.0, 0.0], internal=(0.0, 0.05, 0.0))
    assert force.force == pytest.approx([0.0, 0.0, 0.3, 0.45, 0.45])
    assert force.internal[:, 1] == pytest.approx([0.05, 0.05, 0.1, 0.15, 0.15])


# --- what it refuses -------------------------------------------------------------------------------------------------


def test_endless_switching_ends():
    """The part up to the interval in which it happened is kept."""
    law = Chatter(reach=0.3)
    with on_plain_python(law):
        force = driven_force(law, np.linspace(0.0, 1.0, 5), np.ones(5))
    assert force.status is Status.TOO_MANY_EVENTS
    assert force.force[:2] == pytest.approx([0.0, 0.75])
    assert np.isnan(force.force[2:]).all()
    assert np.isnan(force.internal[2:]).all()


GOOD = {"law": PAPER, "time": [0.0, 1.0, 2.0], "velocity": [0.0, 1.0, 0.5]}
BAD = {
    "law should be a friction law": {"law": "lugre"},
    "time should be finite, got nan at sample 1": {"time": [0.0, math.nan, 2.0]},
    r"time should increase from sample to sample, got 1.0 after 1.0 at sample 2": {"time": [0.0, 1.0, 1.0]},
    "time should have at least 2 samples, got 1": {"time": [0.0], "velocity": [1.0]},
    "time should be a list of numbers": {"time": 3.0},
    "velocity should be numbers": {"velocity": "fast"},
    "velocity should be finite, got inf at sample 0": {"velocity": [math.inf, 0.0, 0.0]},
    r"velocity should have as many samples as time \(3\), got 2": {"velocity": [0.0, 1.0]},
    r"load should be a number or have as many samples as time \(3\), got 2": {"load": [1.0, 1.0]},
    "load should be > 0 with the lugre law, got 0.0 at sample 1": {"load": [1.0, 0.0, 1.0]},
    "load should be >= 0, got -1.0": {"law": vc.Exponential(), "load": -1.0},
    "tolerance should be between 1e-14 and 1, got 0": {"tolerance": 0},
    r"internal should have the 1 internal states of the lugre law \(bristle\), got .* \(2,\)": {"internal": [0.0, 1.0]},
    "internal should be finite": {"internal": math.nan},
}


@pytest.mark.parametrize("message", BAD)
def test_bad_input(message):
    with pytest.raises(ValueError, match=message):
        driven_force(**{**GOOD, **BAD[message]})


BAD_SETS = {
    "got 'bristle_stifness'; did you mean 'bristle_stiffness'": {"names": ["bristle_stifness", "viscous_damping"]},
    "names should differ": {"names": ["viscous_damping", "viscous_damping"]},
    r"one column per name \(2\), got an array of shape \(1, 3\)": {"values": [[1.0, 2.0, 3.0]]},
    "values should be finite, got nan for viscous_damping in row 1": {"values": [[1.0, 2.0], [1.0, math.nan]]},
    "threads should be a whole number >= 1, got 0": {"threads": 0},
}


@pytest.mark.parametrize("message", BAD_SETS)
def test_bad_parameter_sets(message):
    good = {"values": [[1.0, 2.0]], "names": ["bristle_stiffness", "viscous_damping"]}
    with pytest.raises(ValueError, match=message):
        driven_forces(**{**GOOD, **good, **BAD_SETS[message]})
