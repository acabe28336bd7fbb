"""Diagnosis: the fault of a record is named and no other, and none where there is none; the table of all faults."""

import dataclasses

import numpy as np
import pytest

from benchmarks.faulty_records import FAULTS, bench, coloured, errors_of, faulty, named
from benchmarks.imperfect_data import CONTACT, motion
from vibrocap.identification.fit import fit, steady_fit
from vibrocap.identification.inference.diagnosis import diagnosis
from vibrocap.identification.inference.errors import RecordErrors, resolution, saturation
from vibrocap.identification.inference.identifiability import Verdict
from vibrocap.identification.inference.patterns import (
    Pattern,
    autoregression,
    basis_of,
    explained,
    probability,
    without,
)
from vibrocap.laboratory.driven import driven_force
from vibrocap.physics.friction.curves import Coulomb, Exponential
from vibrocap.records.record import Record

STATIC = ("exponential", "stribeck", "hyperbolic-stribeck")  # laws without a kernel
KINDS = list(FAULTS)
QUICK = {"starts": 1, "start": "relaxed", "intervals": "covariance"}
FITTED = ("white", "coloured", "late", "clipped", "quantised position", "ripple of friction", "wear", "glitches")


def expected(kind):
    return (FAULTS[kind],) if FAULTS[kind] else ()


def seeds(kind, count):
    first = 1000 * KINDS.index(kind)
    return range(first, first + count)


def test_the_correlation_of_errors_takes_records_shorter_than_its_order():
    """A record of eight samples beside a long one: e_i = 0.6 e_(i-1) + noise."""
    rng, errors = np.random.default_rng(0), np.zeros(4_000)
    for i in range(1, len(errors)):
        errors[i] = 0.6 * errors[i - 1] + rng.standard_normal()
    a, time = autoregression([errors, errors[:8]])
    assert abs(a[0] - 0.6) < 0.05  # four standard errors of the estimate, sqrt((1 - a^2)/n)
    assert abs(time - (1 - 0.36) / 0.4**2) < 1.0


@pytest.mark.parametrize("kind", KINDS)
def test_the_fault_is_named_and_no_other(kind):
    """Errors of the true law, static ones; what fits leave is in the slow and the exhaustive table."""
    for seed in seeds(kind, 2):
        assert named(kind, seed, "true", largest=4_000, laws=STATIC) == expected(kind), seed


@pytest.mark.parametrize("kind", ["quantised position", "quantised velocity"])
def test_an_offset_is_named_beside_a_coarse_motion(kind):
    """Without a filter of the motion (cutoff) its steps hid every pattern, an offset of the force too.

    The offset is the root mean square of the errors that the steps make, half of all squares.
    """
    for seed in seeds(kind, 3):
        made, record = faulty(kind, seed, 4_000, STATIC)
        errors, slopes = errors_of(made, record)
        offset = float(np.sqrt(np.mean((errors.force - errors.predicted) ** 2)))
        shifted = dataclasses.replace(errors, force=errors.force + offset)
        assert {cause.kind for cause in diagnosis([shifted], slopes).causes} == {"quantisation", "direction"}, seed


@pytest.mark.parametrize("burst", [1, 2])
def test_clipping_is_named_beside_glitches(burst):
    """Glitches beyond the limit, alone or two in a row, do not hide the samples that lie on it."""
    rng = np.random.default_rng(0)
    time = np.linspace(0.0, 12.0, 12_000)
    velocity = 0.05 * np.sin(8.2 * time) + 0.03 * np.sin(3.0 * time + 1.0)
    clean = driven_force(Exponential(3.2, 4.6, 100.0), time, velocity).force
    force = np.clip(clean + 0.05 * rng.standard_normal(12_000), -np.inf, 4.0)
    clipped = int(np.sum(force == 4.0))
    at = rng.choice(11_999, 12, replace=False)
    struck = (at[:, None] + np.arange(burst)).ravel()
    force[struck] += np.repeat(rng.choice([-1.0, 1.0], 12) * rng.uniform(2.0, 6.0, 12), burst)
    place, rates = np.cumsum(velocity) * time[1], np.gradient(velocity, time)
    errors = RecordErrors(time, velocity, rates, place, force, clean, 0.05, np.ones(12_000, bool))
    cause, (touched,) = saturation([errors])
    assert cause is not None
    assert cause.words[1] == "4"
    assert abs(cause.share * 12_000 - clipped) <= 12 * burst
    assert touched[force == 4.0].all()
    if burst == 1:
        assert {cause.kind for cause in diagnosis([errors]).causes} == {"saturation", "outliers"}


def test_gravity_of_a_pendulum_with_its_inertia_is_no_delay():
    """Turned by a motor over several turns, gravity and inertia nearly cancel: each alone explains little."""
    from scipy.integrate import solve_ivp

    law, inertia, weight = Exponential(0.2, 0.7, 0.3), 0.02, 1.06
    time = np.linspace(0.0, 20.0, 4_000)

    def torque(t):
        return 1.9 * np.sin(3.3 * t) + 0.3 * np.sin(7.6 * t + 1.0)

    def rates(t, y):
        friction = law.steady_force(abs(y[1]), 1.0) * np.tanh(y[1] / 0.05)
        return [y[1], (torque(t) - weight * np.sin(y[0]) - friction) / inertia]

    angle, rate = solve_ivp(rates, (0.0, 20.0), [0.0, 0.0], t_eval=time, method="LSODA", rtol=1e-8, atol=1e-8).y
    assert np.ptp(angle) > 4.0 * np.pi
    accelerations = np.array([rates(t, y)[1] for t, y in zip(time, zip(angle, rate, strict=True), strict=True)])
    noise = 0.02 * np.random.default_rng(0).standard_normal(len(time))
    columns = {"velocity": rate, "displacement": angle, "acceleration": accelerations, "rotary": True}
    fitted = fit(Record("pendulum", time, torque(time) + noise, **columns), Exponential, **QUICK)
    assert fitted.residuals is not None
    assert "delay" not in fitted.residuals.kinds
    sizes = {finding.kind: finding.amount for finding in fitted.residuals.findings}
    assert sizes["inertia"] == pytest.approx(inertia, rel=0.05)
    assert sizes["restoring"] == pytest.approx(weight, rel=0.05)
    assert not any(parameter.verdict == Verdict.DETERMINED for parameter in fitted.parameters)


@pytest.mark.parametrize(("kind", "sign"), [("late", 1), ("early", -1)])
def test_a_delay_has_its_sign(kind, sign):
    made, record = faulty(kind, seeds(kind, 1)[0], 4_000, STATIC)
    errors, _ = errors_of(made, record)
    (cause,) = diagnosis([errors]).causes
    assert sign * cause.amount > 0.1 * record.interval


@pytest.mark.slow
@pytest.mark.parametrize("kind", FITTED)
def test_the_fault_is_named_after_a_fit_that_it_bends(kind):
    for seed in seeds(kind, 1):
        assert named(kind, seed, "fit", largest=10_000) == expected(kind), seed


@pytest.mark.exhaustive
@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_the_fault_is_named_in_95_of_100(kind):
    """Records of 10^3 to 10^6 samples, of all laws of the table, after fits."""
    assert sum(named(kind, seed) == expected(kind) for seed in seeds(kind, 100)) >= 95


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_false_alarms_are_as_rare_as_stated(memory):
    """A cubic beside a level and a slope, in noise that also grows: 400 draws at a probability of 1 %."""
    rng, n = np.random.default_rng(3), 600
    x = np.linspace(-1, 1, n)
    absorbed, pattern = basis_of(np.stack([np.ones(n), x], axis=1)), Pattern(np.stack([x**2, x**3], axis=1))
    alarms = 0
    for _ in range(400):
        error = without((0.5 + np.abs(x)) * (coloured(rng, n, memory) if memory else rng.standard_normal(n)), absorbed)
        alarms += probability(error, absorbed, pattern, explained(error, absorbed, pattern)[1], []) < 0.01
    # four are expected. The model of coloured noise is estimated from what counts as 30 samples, which may triple that
    assert alarms <= (12 if memory == 0 else 12 + 4 * 12**0.5)  # and four standard deviations of the number


@pytest.mark.slow
def test_white_noise_is_white_noise_in_long_records_too():
    """Above 40,000 samples all of them were compared with a thinned draft: a lead of 2 samples, 99 % of the squares."""
    imposed = motion()
    time = np.linspace(0.0, imposed.time[-1], 41_000)
    velocity = np.interp(time, imposed.time, imposed.velocity)
    force = driven_force(CONTACT, time, velocity).force
    force = force + 0.02 * np.std(force) * np.random.default_rng(0).standard_normal(len(time))
    one = fit(Record("long", time, force, velocity=velocity), CONTACT, **QUICK)
    assert one.residuals.findings == ()
    assert one.residuals.white


def delayed_with_mass(mass, delay):
    """A contact and a mass (kg) of which the sensor shows all a delay (s) later, with 2 % of noise."""
    imposed = motion()
    fine = np.linspace(0.0, imposed.time[-1], 8 * (len(imposed.time) - 1) + 1)
    window = np.hanning(33) / np.sum(np.hanning(33))
    velocity = np.convolve(np.pad(np.interp(fine, imposed.time, imposed.velocity), 16, mode="edge"), window, "valid")
    force = driven_force(CONTACT, fine, velocity).force + mass * np.gradient(velocity, fine)
    late = np.interp(imposed.time - delay, fine, force)
    late = late + 0.02 * np.std(late) * np.random.default_rng(0).standard_normal(len(late))
    return Record("late", imposed.time, late, velocity=velocity[::8])


def test_a_delay_shifts_the_inertia_too():
    """The law alone was shifted: 20 kg, all 6 ms late, gave a stiffness of 220,650 [215,000, 226,500] for 200,000."""
    one = fit(delayed_with_mass(20.0, 6e-3), CONTACT, terms=("mass", "delay"), **QUICK)
    assert CONTACT.bristle_stiffness in one["bristle_stiffness"]
    assert CONTACT.viscous_damping in one["viscous_damping"]
    assert one["mass"].value == pytest.approx(20.0, rel=5e-3)
    assert one["delay"].value == pytest.approx(6e-3, rel=0.02)
    assert one.residuals.findings == ()


def pendulum(inertia, weight):
    """Torque of a driven pendulum on a friction joint: of its inertia (kg m^2), weight times length (N m), friction."""
    time = np.linspace(0.0, 10.0, 4_000)
    omega = 2 * np.pi * 0.7
    angle, rate, change = 0.5 * np.sin(omega * time), 0.5 * omega * np.cos(omega * time), -0.5 * omega**2
    torque = 0.05 * driven_force(Exponential(), time, rate).force + weight * np.sin(angle)
    torque = torque + inertia * change * np.sin(omega * time)
    torque = torque + 0.02 * np.std(torque) * np.random.default_rng(1).standard_normal(len(time))
    columns = {"velocity": rate, "displacement": angle, "acceleration": change * np.sin(omega * time)}
    return Record("pendulum", time, torque, rotary=True, **columns)


def test_a_driven_pendulum_is_found_in_all_its_terms():
    """I = c = 0.15, m g l = 3.3, friction 0.03, over 12 and 24 rad, from 0.4 rad on; what is left out is named."""
    true = {"mass": 0.15, "damping": 0.15, "coulomb_coefficient": 0.03}
    true |= {"gravity": 3.3 * np.cos(0.4), "gravity_cosine": -3.3 * np.sin(0.4)}
    rng, time, records = np.random.default_rng(1), np.linspace(0.0, 20.0, 8_001), []
    for reach in (12.0, 24.0):
        waves = [
            (reach * share, 2 * np.pi * f, phase)
            for share, f, phase in ((0.6, 0.11, 0), (0.3, 0.23, 1), (0.1, 0.41, 2))
        ]
        angle = sum(a * np.sin(w * time + p) for a, w, p in waves)
        rate = sum(a * w * np.cos(w * time + p) for a, w, p in waves)
        change = -sum(a * w**2 * np.sin(w * time + p) for a, w, p in waves)
        torque = 0.15 * change + 0.15 * rate + 3.3 * np.sin(angle) + 0.03 * np.sign(rate)
        torque += 0.02 * np.std(torque) * rng.standard_normal(len(time))
        columns = {"velocity": rate, "displacement": angle + 0.4, "acceleration": change}
        records.append(Record(f"{reach:g} rad", time, torque, rotary=True, **columns))
    one = fit(records, "coulomb", terms=("mass", "damping", "gravity", "gravity_cosine"), **QUICK)
    for name, value in true.items():
        error = one[name].standard_error
        assert abs(one[name].value - value) < 4 * error
        assert error < (0.01 if name != "coulomb_coefficient" else 0.05) * abs(value)
    assert one["gravity"].unit == "N m"
    left_out = fit(records, "coulomb", terms="damping", **QUICK)
    assert {"inertia", "restoring"} <= set(left_out.residuals.kinds)


def test_a_spring_and_damping_of_each_direction_are_found_beside_a_law():
    imposed = motion()
    place = np.cumsum(imposed.velocity) * np.median(np.diff(imposed.time))
    velocity = imposed.velocity
    force = driven_force(CONTACT, imposed.time, velocity).force
    level = float(np.std(force))
    parts = {"spring": level / np.ptp(place), "damping_forward": level / velocity.max(), "offset": 0.3 * level}
    parts["damping_back"] = 2 * parts["damping_forward"]
    force = force + parts["spring"] * place + parts["offset"] + parts["damping_forward"] * np.maximum(velocity, 0)
    force = force + parts["damping_back"] * np.minimum(velocity, 0)
    force = force + 0.01 * level * np.random.default_rng(0).standard_normal(len(force))
    record = Record("beside", imposed.time, force, velocity=velocity, displacement=place)
    held = {"viscous_damping": CONTACT.viscous_damping}
    one = fit(record, CONTACT, fixed=held, terms=tuple(parts), **QUICK)
    for name, value in parts.items():
        assert abs(one[name].value - value) < 4 * one[name].standard_error < 0.1 * value
    curve = steady_fit(record, "coulomb", terms=("damping_forward", "offset"), starts=1, intervals="covariance")
    assert curve["damping_forward"].value > 0.3 * parts["damping_forward"]


def test_terms_that_are_none_of_the_contact_are_refused():
    with pytest.raises(ValueError, match="there is no term 'gravty'; did you mean 'gravity'"):
        fit(Record("a", np.arange(9.0), np.arange(9.0), velocity=np.arange(9.0)), "coulomb", terms="gravty")
    with pytest.raises(
        ValueError, match="gravity is of a contact that turns; of one that slides, gravity is an offset"
    ):
        fit(Record("a", np.arange(9.0), np.arange(9.0), velocity=np.arange(9.0)), "coulomb", terms=["gravity"])


def test_no_mass_is_negative_and_the_weight_that_would_make_it_so_is_named():
    """A driven pendulum's torque gave a mass of -0.043 kg [-0.050, -0.036] with no limit named."""
    one = fit(pendulum(0.01, 0.4), "exponential", terms="mass", **QUICK)
    assert one["mass"].value == 0.0
    assert "no mass is negative" in one.summary()
    assert not one["mass"].determined
    assert "restoring" in one.residuals.kinds
    assert "gravity" in one.summary()


def test_a_delay_at_its_limit_is_named():
    mass = delayed_with_mass(0.0, 40 * 9.0 / 1_999)
    one = fit(mass, CONTACT, terms="delay", **QUICK)
    assert any(limit.parameter == "delay" for limit in one.limits)


def test_nothing_is_determined_beside_a_fault():
    """Intervals of a percent stood beside errors of tens of percent, "determined"."""
    made, record = faulty("clipped", seeds("clipped", 1)[0], 4_000, STATIC)
    one = fit(record, made.law, terms=["mass"] * (made.mass > 0), **QUICK)
    assert one.residuals.doubtful
    assert not any(one[name].determined for name in one.free)
    assert Verdict.DOUBTED in {one[name].verdict for name in one.free}
    assert set(one.free) == set(one.identifiability.undetermined)
    assert "no interval of" in one.summary()


def test_outliers_that_the_loss_bears_are_no_doubt():
    made, record = faulty("glitches", seeds("glitches", 1)[0], 4_000, STATIC)
    table = {
        loss: fit(record, made.law, terms=["mass"] * (made.mass > 0), loss=loss, **QUICK)
        for loss in ("linear", "soft_l1")
    }
    assert table["linear"].residuals.doubtful
    assert not table["soft_l1"].residuals.doubtful
    assert "Outliers" in table["soft_l1"].summary()


def test_a_force_that_rests_on_its_level_is_not_saturated():
    """Coulomb's is constant, and without noise thousands of samples lie on the largest."""
    made, _ = bench(1, 2_000, ("exponential",))
    contact = Coulomb(coulomb_coefficient=4.0, static_coefficient=4.0)
    made = dataclasses.replace(made, law=contact, mass=0.0, noise=0.0)
    record = Record("level", made.time, made.force(made.time), velocity=made.motion(made.time, 1))
    errors, _ = errors_of(made, record)
    assert saturation([errors])[0] is None
    assert diagnosis([errors]).causes == ()


def test_the_step_of_an_encoder_is_read_from_its_values():
    rng = np.random.default_rng(0)
    place = 0.03 * np.sin(np.linspace(0, 30, 5_000))
    assert resolution(5e-6 * np.round(place / 5e-6)) == pytest.approx(5e-6, rel=1e-9)
    assert resolution(5e-6 * np.round(place / 5e-6) + 0.123) == pytest.approx(5e-6, rel=1e-6)
    assert resolution(place) == 0.0
    assert resolution(rng.standard_normal(5_000)) == 0.0
    assert resolution(np.repeat([0.1, 0.2, 0.3], 100)) == 0.0  # steps of the speed
