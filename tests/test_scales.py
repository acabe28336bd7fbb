"""SI <-> dimensionless: the definitions of docs/model.md, the equations in SI, and the way back."""

import dataclasses
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibrocap as vc
from vibrocap.physics import scales as si
from vibrocap.physics.catalogue import drives, laws, machines
from vibrocap.physics.parameters import ParameterError
from vibrocap.physics.scales import Scales

EPSILON = 2.0**-52
CAPSULE = si.PendulumCapsuleInSI(
    capsule_mass_kg=0.35,
    pendulum_mass_kg=0.12,
    pendulum_length_m=0.27,
    torsional_stiffness_N_m_rad=0.9,
    torsional_damping_N_m_s_rad=0.04,
    normal_load_N=3.1,
    gravity_m_s2=9.81,
)
DRIVE = si.BiharmonicInSI(amplitude_N_m=0.5, frequency_rad_s=7.0, second_amplitude_N_m=0.2, second_phase=0.4)
LUGRE = si.LuGreInSI(
    bristle_stiffness_N_m=450.0,
    bristle_damping_N_s_m=6.0,
    viscous_damping_N_s_m=0.7,
    coulomb_coefficient=0.2,
    static_coefficient=0.5,
    stribeck_velocity_m_s=0.15,
    stribeck_exponent=1.7,
    damping_velocity_m_s=0.3,
)
EXPONENTIAL = si.ExponentialInSI(coulomb_coefficient=0.2, static_coefficient=0.5, decay_rate_s_m=6.0)


def test_parameters_are_those_of_the_definitions():
    """lambda = M/m, rho = k/(m l^2 omega_n^2) and so on, typed from docs/model.md with omega_n written out."""
    m, l, g = 0.12, 0.27, 9.81  # noqa: E741
    omega_n = math.sqrt(g / l)
    system = si.SystemInSI(CAPSULE, LUGRE, DRIVE).dimensionless()
    expected = {
        "machine.mass_ratio": 0.35 / m,
        "machine.stiffness": 0.9 / (m * l**2 * omega_n**2),
        "machine.damping": 0.04 / (m * l**2 * omega_n),
        "machine.normal_load": 3.1 / (m * l * omega_n**2),
        "drive.amplitude": 0.5 / (m * l**2 * omega_n**2),
        "drive.frequency": 7.0 / omega_n,
        "drive.second_amplitude": 0.2 / (m * l**2 * omega_n**2),
        "drive.second_phase": 0.4,
        # R/(m l omega_n^2) = delta0 (z/l) + delta1 d(z/l)/d(omega_n t) + ...
        "friction.bristle_stiffness": 450.0 * l / (m * l * omega_n**2),
        "friction.bristle_damping": 6.0 * l * omega_n / (m * l * omega_n**2),
        "friction.viscous_damping": 0.7 * l * omega_n / (m * l * omega_n**2),
        "friction.coulomb_coefficient": 0.2,
        "friction.static_coefficient": 0.5,
        "friction.stribeck_velocity": 0.15 / (l * omega_n),
        "friction.stribeck_exponent": 1.7,
        "friction.damping_velocity": 0.3 / (l * omega_n),
    }
    assert set(expected) == set(system.parameter_paths)
    for path, value in expected.items():
        assert system.parameter(path) == pytest.approx(value, rel=8 * EPSILON), path
    assert EXPONENTIAL.dimensionless(CAPSULE.scales).decay_rate == pytest.approx(6.0 * l * omega_n, rel=8 * EPSILON)


def lagrangian_rates_in_si(t, y, force):
    """theta'', x'' of the capsule in SI, from the paper's (2) and (3), solved by Cramer's rule."""
    theta, rate = y[0], y[1]
    c, d = CAPSULE, DRIVE
    m, l, total = c.pendulum_mass_kg, c.pendulum_length_m, c.capsule_mass_kg + c.pendulum_mass_kg  # noqa: E741
    torque = d.amplitude_N_m * math.cos(d.frequency_rad_s * t)
    torque += d.second_amplitude_N_m * math.cos(2 * d.frequency_rad_s * t + d.second_phase)
    torque += m * c.gravity_m_s2 * l * math.sin(theta)
    torque -= c.torsional_stiffness_N_m_rad * theta + c.torsional_damping_N_m_s_rad * rate
    push = -force - m * l * math.sin(theta) * rate**2
    coupling = -m * l * math.cos(theta)
    determinant = m * l**2 * total - coupling**2
    return (total * torque - coupling * push) / determinant, (m * l**2 * push - coupling * torque) / determinant


def test_equations_agree_in_si_and_without_units():
    """The same state has the same accelerations, the friction force computed in SI from LuGre's formula."""
    scales, law = CAPSULE.scales, LUGRE
    system = si.SystemInSI(CAPSULE, LUGRE, DRIVE).dimensionless()
    t, y = 0.83, (0.7, 3.1, 0.2, -0.11, 2e-4)  # s, then rad, rad/s, m, m/s, m
    velocity, deflection = y[3], y[4]
    drop = law.static_coefficient - law.coulomb_coefficient
    shape = math.exp(-(abs(velocity / law.stribeck_velocity_m_s) ** law.stribeck_exponent))
    level = CAPSULE.normal_load_N * (law.coulomb_coefficient + drop * shape)
    deflection_rate = velocity - law.bristle_stiffness_N_m * abs(velocity) * deflection / level
    fading = math.exp(-((velocity / law.damping_velocity_m_s) ** 2))
    force = (
        law.bristle_stiffness_N_m * deflection
        + fading * law.bristle_damping_N_s_m * deflection_rate
        + law.viscous_damping_N_s_m * velocity
    )
    names = system.state_names
    flow = system.flow(t / scales.time_s, [v / scales.of(name) for name, v in zip(names, y, strict=True)], -1)
    assert flow.friction * scales.of("friction") == pytest.approx(force, rel=64 * EPSILON)
    turn, push = lagrangian_rates_in_si(t, y, force)
    found = [rate * scales.of(name) / scales.time_s for name, rate in zip(names, flow.rates, strict=True)]
    assert found == pytest.approx([y[1], turn, y[3], push, deflection_rate], rel=64 * EPSILON)
    power = flow.powers[0] * scales.power_W
    drive = flow.drive * scales.of("drive")
    assert power == pytest.approx(drive * y[1], rel=64 * EPSILON)


def test_units_belong_together():
    """Energy = force * length = torque, momentum = force * time = mass * velocity, power = energy/time."""
    s = Scales(0.12, 0.27, 9.81)
    same = (
        (s.energy_J, s.force_N * s.length_m, s.torque_N_m, s.mass_kg * s.velocity_m_s**2),
        (s.momentum_N_s, s.force_N * s.time_s, s.mass_kg * s.velocity_m_s, s.damping_N_s_m * s.length_m),
        (s.power_W, s.energy_J / s.time_s, s.force_N * s.velocity_m_s),
        (s.velocity_m_s, s.length_m / s.time_s, 1 / s.inverse_velocity_s_m),
        (s.force_N, s.stiffness_N_m * s.length_m, s.damping_N_s_m * s.velocity_m_s),
        (s.torsional_damping_N_m_s, s.torque_N_m * s.time_s, s.torque_N_m / s.frequency_rad_s),
    )
    for values in same:
        assert values == pytest.approx([values[0]] * len(values), rel=8 * EPSILON)


sizes = st.floats(1e-3, 1e3)


@settings(max_examples=50, deadline=None)
@given(values=st.lists(sizes, min_size=13, max_size=13), phase=st.floats(-3, 3))
def test_round_trip_is_exact_to_rounding(values, phase):
    """field/F and then * F: one rounding each, with the same F both ways, so at most 2 * 2^-53 = EPSILON, relative."""
    capsule = si.PendulumCapsuleInSI(*values[:7])
    drive = si.BiharmonicInSI(values[7], values[8], values[9], phase)
    low, high = sorted((values[10], values[11]))
    law = si.LuGreInSI(values[12], values[0], values[1], low, high, values[2], values[3], values[4])
    given_system = si.SystemInSI(capsule, law, drive)
    returned = si.SystemInSI.of(given_system.dimensionless(), given_system.scales)
    for part in ("machine", "friction", "drive"):
        before, after = dataclasses.asdict(getattr(given_system, part)), dataclasses.asdict(getattr(returned, part))
        assert after == pytest.approx(before, rel=EPSILON, abs=0.0)
    # the other way round: dimensionless -> SI -> dimensionless
    system = vc.System(
        vc.PendulumCapsule(*values[:4]), vc.Exponential(low, high, values[4]), vc.Harmonic(values[5], values[6])
    )
    again = si.SystemInSI.of(system, capsule.scales).dimensionless()
    for path in system.parameter_paths:
        assert again.parameter(path) == pytest.approx(system.parameter(path), rel=EPSILON, abs=0.0), path


def test_weight_stays_a_word():
    bench = si.PendulumCapsuleInSI(0.35, 0.12, 0.27, 0.9, 0.04)
    machine = bench.dimensionless(bench.scales)
    assert machine.normal_load == "weight"
    # (M + m) g, counted in m g
    assert machine.load() * bench.scales.force_N == pytest.approx((0.35 + 0.12) * 9.80665, rel=4 * EPSILON)
    system = vc.System(machine, vc.Exponential(), vc.Harmonic())
    assert si.SystemInSI.of(system, bench.scales).machine == bench


def test_every_part_has_a_record_in_si_and_every_parameter_a_field():
    """Of the paper's machine, its laws and its drives; the others serve in any units."""
    records = {record.dimensionless_part: record for record in si.PARTS_IN_SI}
    assert {part.name for part in records} == {"pendulum-capsule", "harmonic", "biharmonic", "exponential", "lugre"}
    for part in (*laws().values(), *machines().values(), *drives().values()):
        if part not in records:
            continue
        fields = {parameter for parameter, _ in records[part].quantities.values()}
        assert fields == {field.name for field in dataclasses.fields(part)}, part


@pytest.mark.parametrize("law", [vc.Exponential(), vc.LuGre()], ids=lambda law: law.name)
def test_every_quantity_of_a_motion_has_a_scale(law):
    motion = vc.simulate(vc.System(vc.PendulumCapsule(), law, vc.Harmonic()), periods=0.1)
    scales = CAPSULE.scales
    assert all(scales.of(name) > 0 for name in (*motion.names, "time") if name != "side")


def test_what_has_no_scale_is_refused():
    @dataclasses.dataclass(frozen=True)
    class Unknown(vc.Harmonic):
        pass

    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), Unknown())
    with pytest.raises(TypeError, match="Unknown has no record in SI"):
        si.SystemInSI.of(system, CAPSULE.scales)
    with pytest.raises(KeyError):
        CAPSULE.scales.of("colour")


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("pendulum_mass_kg", 0.0),
        ("pendulum_mass_kg", -1.0),
        ("capsule_mass_kg", math.nan),
        ("pendulum_length_m", math.inf),
        ("torsional_damping_N_m_s_rad", -0.1),
        ("normal_load_N", "heavy"),
        ("gravity_m_s2", "9.81"),
    ],
)
def test_wrong_values_are_refused_by_name(field, value):
    with pytest.raises(ParameterError, match=field):
        dataclasses.replace(CAPSULE, **{field: value})


def test_static_below_coulomb_level_is_refused():
    with pytest.raises(ParameterError, match="static_coefficient"):
        dataclasses.replace(LUGRE, static_coefficient=0.1)
    with pytest.raises(ParameterError, match="static_coefficient"):
        dataclasses.replace(EXPONENTIAL, static_coefficient=0.1)
