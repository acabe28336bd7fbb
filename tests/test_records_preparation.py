"""Preparing a record: derivatives and integrals against closed forms, noise against the filter's own theory."""

import numpy as np
import pytest

from vibrocap.records.preparation import prepared
from vibrocap.records.record import Record

RATE, SECONDS, FREQUENCY, AMPLITUDE = 1000.0, 20.0, 1.5, 0.02
OMEGA = 2.0 * np.pi * FREQUENCY
TIME = np.arange(int(RATE * SECONDS)) / RATE
UNEVEN = np.sort(TIME + 0.4 / RATE * np.random.default_rng(7).uniform(-1.0, 1.0, len(TIME)))
MASS = 12.0


def position(time):
    return 0.7 + AMPLITUDE * np.sin(OMEGA * time)


def velocity(time):
    return AMPLITUDE * OMEGA * np.cos(OMEGA * time)


def acceleration(time):
    return -AMPLITUDE * OMEGA**2 * np.sin(OMEGA * time)


def friction(time):
    return 30.0 * np.tanh(velocity(time) / 0.01)


def record(time=TIME, **columns) -> Record:
    fields = {"time": time, "force": friction(time), "displacement": position(time)}
    return Record("sine", **{**fields, **columns})


def inner(values, margin=1.0):
    """Away from the ends by a second: many periods of each cut-off used here."""
    return values[int(margin * RATE) : -int(margin * RATE)]


def rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.mark.parametrize("time", [TIME, UNEVEN], ids=["even", "uneven"])
def test_spline_derivative_of_clean_displacements(time):
    """A cubic spline's derivative errs by h^3/24 times the fourth derivative, inside; h is at most 1.8 intervals."""
    made = prepared(record(time))
    bound = (1.8 / RATE) ** 3 / 24.0 * AMPLITUDE * OMEGA**4
    assert np.max(np.abs(inner(made.velocity - velocity(time)))) < 1.1 * bound
    assert made.acceleration is None
    np.testing.assert_array_equal(made.displacement, position(time))
    assert made.notes == ("velocity: derivative of the displacement",)


@pytest.mark.parametrize("time", [TIME, UNEVEN], ids=["even", "uneven"])
def test_displacement_is_the_integral_of_velocity(time):
    """The trapezoidal rule errs by the sum of h^3/12 v'' over the steps; at most h^2 (1 + jitter) T/12 max|v''|."""
    made = prepared(record(time, displacement=None, velocity=velocity(time)))
    largest = np.max(np.diff(time))
    bound = largest**2 * SECONDS / 12.0 * AMPLITUDE * OMEGA**3
    error = made.displacement - (position(time) - position(time[0]))
    assert made.displacement[0] == 0.0
    assert np.max(np.abs(error)) < bound
    np.testing.assert_array_equal(made.velocity, velocity(time))


@pytest.mark.parametrize("cutoff", [15.0, 40.0])
@pytest.mark.parametrize("time", [TIME, UNEVEN], ids=["even", "uneven"])
def test_noise_of_the_velocity_is_what_the_filter_lets_through(time, cutoff):
    """White noise s gives 0.729 s (2 pi fc) sqrt(fc/fs); its estimate from 2 fc T independent values spreads.

    The spread of an rms of n values is 1/sqrt(2 n) of it; four times that is allowed. Uneven samples carry
    more or less weight than even ones, by the jitter of 0.23 intervals (rms): the power changes by its square, 5 %.
    """
    noise = 2e-5
    rng = np.random.default_rng(3)
    made = prepared(record(time, displacement=position(time) + noise * rng.standard_normal(len(time))), cutoff=cutoff)
    gain = 1.0 / (1.0 + (FREQUENCY / cutoff) ** 8)
    error = rms(inner(made.velocity - gain * velocity(time)))
    expected = 0.7289 * noise * 2.0 * np.pi * cutoff * np.sqrt(cutoff / RATE)
    allowed = 4.0 / np.sqrt(2.0 * 2.0 * cutoff * (SECONDS - 2.0))
    assert error == pytest.approx(expected, rel=allowed + (0.05 if time is UNEVEN else 0.01))
    raw = rms(inner(np.gradient(position(time) + noise * rng.standard_normal(len(time)), time) - velocity(time)))
    assert error < 0.25 * raw


def test_filtering_delays_nothing_and_keeps_the_motion():
    """Forward and backward: the phase is 0, the gain 1/(1 + (f/fc)^8), also for velocity and acceleration.

    The bilinear transform warps the frequency by (pi f/fs)^2/3, 1e-3 at 15 Hz: far below 1e-6 in the gain at 1.5 Hz.
    """
    for columns in ({}, {"velocity": velocity(TIME)}):
        made = prepared(record(**columns), cutoff=15.0)
        gain = 1.0 / (1.0 + (FREQUENCY / 15.0) ** 8)
        for values, exact in ((made.velocity, velocity), (made.acceleration, acceleration)):
            error = inner(values - gain * exact(TIME), 2.0)
            assert np.max(np.abs(error)) < 1e-6 * np.max(np.abs(exact(TIME)))
    for share, gain in ((0.75, 1.0 / (1.0 + 0.75**8)), (1.0, 0.5), (1.5, 1.0 / (1.0 + 1.5**8))):
        fast = Record("fast", time=TIME, force=TIME, displacement=np.sin(2.0 * np.pi * share * 15.0 * TIME))
        middle = inner(prepared(fast, cutoff=15.0).displacement, 5.0)
        assert np.max(middle) == pytest.approx(gain, abs=2e-3)


def test_a_steady_slide_stays_one_up_to_the_ends():
    """A straight line passes the filter as it is."""
    made = prepared(Record("slide", time=TIME, force=np.sin(TIME), displacement=3e-6 * TIME + 5.0), cutoff=2.0)
    assert np.max(np.abs(made.velocity - 3e-6)) < 1e-8 * 3e-6
    assert np.max(np.abs(made.displacement - 3e-6 * TIME - 5.0)) < 1e-12


def test_sampling_that_changes_within_a_record():
    """As in a velocity step: slow before, a hundred times in a second after."""
    time = np.concatenate((np.arange(0.0, 20.0, 0.1), np.arange(20.0, 40.0, 0.01)))
    moved = np.where(time < 25.0, 3.0 * time, 75.0 + 10.0 * (time - 25.0))
    made = prepared(Record("step", time=time, force=np.sin(time), displacement=moved), cutoff=1.0)
    assert np.max(np.abs(made.velocity[(time > 2) & (time < 22)] - 3.0)) < 1e-3
    assert np.max(np.abs(made.velocity[(time > 28) & (time < 38)] - 10.0)) < 1e-3
    at_step = made.velocity[np.argmin(np.abs(time - 25.0))]
    assert at_step == pytest.approx(6.5, abs=0.02)  # half way: no delay


def test_inertia_and_offset_are_taken_off_the_force():
    total = friction(TIME) + MASS * acceleration(TIME) + 5.0
    made = prepared(record(force=total), cutoff=40.0, mass=MASS, offset=5.0)
    scale = MASS * np.max(np.abs(acceleration(TIME)))
    assert np.max(np.abs(inner(made.force - friction(TIME)))) < 1e-5 * scale
    assert made.notes[-2:] == ("force: less an offset of 5 N", "force: less the inertia of 12 kg")
    whole = TIME < 18.0  # 27 periods: friction and inertia have no mean
    part = record(force=total).between(0.0, TIME[whole][-1])
    assert np.mean(prepared(part, offset="mean").force) == pytest.approx(0.0, abs=1e-12 * 30.0)


def test_a_measured_acceleration_needs_no_cutoff():
    made = prepared(
        record(force=MASS * acceleration(TIME) + friction(TIME), acceleration=acceleration(TIME)), mass=MASS
    )
    np.testing.assert_allclose(made.force, friction(TIME), atol=1e-12 * 30.0)


def test_the_force_is_filtered_only_where_asked():
    rng = np.random.default_rng(4)
    force = np.sin(OMEGA * TIME) + 0.1 * rng.standard_normal(len(TIME))
    made = prepared(record(force=force), cutoff=40.0)
    np.testing.assert_array_equal(made.force, force)
    smooth = prepared(record(force=force), cutoff=40.0, filter_force=True).force
    expected = 0.1 * np.sqrt(2.0 * 40.0 / RATE * 0.8980)  # integral of 1/(1 + u^8)^2 from 0: (7/8) (pi/8)/sin(pi/8)
    assert rms(inner(smooth - np.sin(OMEGA * TIME))) == pytest.approx(expected, rel=4.0 / np.sqrt(2.0 * 80.0 * 18.0))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"cutoff": 0}, "cutoff: should be a number greater than 0, got 0"),
        ({"cutoff": "fast"}, "cutoff: should be a number greater than 0, got 'fast'"),
        ({"cutoff": 495.0}, r"cutoff: should be at least 0.05\d* Hz .* and below 490 Hz .* got 495"),
        ({"cutoff": 0.01}, r"cutoff: should be at least .* got 0.01"),
        ({"mass": -1.0, "cutoff": 10.0}, "mass: should be a number greater than 0, got -1"),
        ({"mass": 1.0}, "cutoff: is missing; mass needs an acceleration"),
        ({"offset": "median"}, "offset: should be a number of newtons or 'mean', got 'median'"),
        ({"offset": float("nan")}, "offset: should be a finite number"),
    ],
)
def test_settings_that_make_no_sense(settings, said):
    with pytest.raises(ValueError, match=said):
        prepared(record(), **settings)


def test_a_record_with_a_gap_of_days_is_refused():
    time = np.concatenate((TIME, TIME + 1e6))
    with pytest.raises(ValueError, match="time: has gaps of up to 1e\\+06 s"):
        prepared(record(time), cutoff=10.0)
