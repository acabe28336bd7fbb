"""SI <-> dimensionless: the definitions of docs/model.md, keys with units, and the way back."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import vibrocap as vc
from vibrocap.case.case import CaseError, case_from_text, case_text
from vibrocap.physics.catalogue import drives, law, laws, machines
from vibrocap.physics.dimensions.units import parameter_keys, suffix, written_in_si
from vibrocap.physics.parameters import parameter as vc_parameter
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.parameters import parameters as vc_parameters

EPSILON = 2.0**-52
CAPSULE = {
    "capsule_mass_kg": 0.35,
    "pendulum_mass_kg": 0.12,
    "pendulum_length_m": 0.27,
    "stiffness_N_m_per_rad": 0.9,
    "damping_N_m_s_per_rad": 0.04,
    "normal_load_N": 3.1,
    "gravity_m_per_s2": 9.81,
}
DRIVE = {"amplitude_N_m": 0.5, "frequency_rad_per_s": 7.0, "second_amplitude_N_m": 0.2, "second_phase": 0.4}
LUGRE = {
    "bristle_stiffness_N_per_m": 450.0,
    "bristle_damping_N_s_per_m": 6.0,
    "viscous_damping_N_s_per_m": 0.7,
    "coulomb_coefficient": 0.2,
    "static_coefficient": 0.5,
    "stribeck_velocity_m_per_s": 0.15,
    "stribeck_exponent": 1.7,
    "damping_velocity_m_per_s": 0.3,
}


def bench(machine=CAPSULE, friction=LUGRE, drive=DRIVE) -> vc.System:
    return vc.System(vc.PendulumCapsule.in_si(**machine), vc.LuGre.in_si(**friction), vc.Biharmonic.in_si(**drive))


def test_parameters_are_those_of_the_definitions():
    """lambda = M/m, rho = k/(m l^2 omega_n^2) and so on, with omega_n written out."""
    m, l, g = 0.12, 0.27, 9.81  # noqa: E741
    omega_n = math.sqrt(g / l)
    system = bench()
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
    assert system.parameter("machine.mass_ratio") == 0.35 / m  # to the last bit
    fast = vc.System(
        vc.PendulumCapsule.in_si(**CAPSULE),
        vc.Exponential.in_si(decay_rate_s_per_m=6.0),
        vc.Harmonic.in_si(amplitude_N_m=1, frequency_Hz=5),
    )
    assert fast.friction.decay_rate == pytest.approx(6.0 * l * omega_n, rel=8 * EPSILON)
    assert fast.drive.frequency == pytest.approx(10 * math.pi / omega_n, rel=8 * EPSILON)


def test_units_belong_together():
    """Energy = force * length = torque, momentum = force * time = mass * velocity, power = energy/time."""
    scales = vc.PendulumScales(0.12, 0.27, 9.81)
    of = vc.System(vc.PendulumCapsule(), vc.LuGre(), vc.Harmonic(), units=scales).si.factor_of
    same = (
        (of("J"), of("N") * of("m"), of("N m"), of("kg") * of("m/s") ** 2, 0.12 * 9.81 * 0.27),
        (of("N s"), of("N") * of("s"), of("kg") * of("m/s"), of("N s/m") * of("m")),
        (of("W"), of("J") / of("s"), of("N") * of("m/s")),
        (of("m/s"), of("m") / of("s"), 1 / of("s/m"), math.sqrt(9.81 * 0.27)),
        (of("N"), of("N/m") * of("m"), of("N s/m") * of("m/s"), 0.12 * 9.81),
    )
    for values in same:
        assert values == pytest.approx([values[0]] * len(values), rel=8 * EPSILON)
    assert (of("kg"), of("m"), of("1"), of("rad")) == (0.12, 0.27, 1.0, 1.0)


sizes = st.floats(1e-3, 1e3).map(lambda value: float(f"{value:.9g}"))


@settings(max_examples=50, deadline=None)
@given(values=st.lists(sizes, min_size=16, max_size=16))
def test_numbers_given_in_si_are_read_back_as_they_were(values):
    """The number with the fewest digits that gives the same parameter is the one given, and gives it exactly."""
    low, high = sorted((values[10], values[11]))
    capsule = dict(zip(CAPSULE, values[:7], strict=True))
    law_values = dict(zip(LUGRE, [*values[7:10], low, high, *values[12:15]], strict=True))
    drive = dict(zip(DRIVE, [*values[13:16], 0.4], strict=True))
    system = bench(capsule, law_values, drive)
    for given_part, part in ((capsule, system.machine), (law_values, system.friction), (drive, system.drive)):
        back = written_in_si(part, system.si)
        assert back is not None
        for key, value in back.items():
            if key in given_part:
                assert value == given_part[key]
    rewritten = [written_in_si(part, system.si) for part in (system.machine, system.friction, system.drive)]
    scales = {key: capsule[key] for key in ("pendulum_mass_kg", "pendulum_length_m", "gravity_m_per_s2")}
    assert bench(rewritten[0] | scales, rewritten[1], rewritten[2]) == system


WRAPPED = ("backlash-anisotropic-lugre", "smoothed-anisotropic-coulomb")


@pytest.mark.parametrize(
    "part", [*laws().values(), *machines().values(), *drives().values(), *map(law, WRAPPED)], ids=lambda part: part.name
)
def test_every_parameter_of_every_part_can_be_given_in_si(part):
    for effort in ("force", "torque"):
        keys = parameter_keys(part, effort)
        assert {key.name for key in keys.values()} == {info.name for info in parameter_table(part)}


@pytest.mark.parametrize("kind", [*laws().values(), *map(law, WRAPPED)], ids=lambda kind: kind.name)
def test_a_dimensional_argument_of_every_law(kind):
    """A law that is given in SI has, in SI, the force that the same law has with SI numbers for its parameters."""
    scales = vc.PendulumScales(0.2, 0.5, 9.0)
    system = vc.System(vc.PendulumCapsule(), kind(), vc.Harmonic(), units=scales)
    units = system.si
    numbers = written_in_si(system.friction, units, exactly=False)
    same = kind(**{each.name: numbers[key] for key, each in parameter_keys(kind, "torque").items() if key in numbers and each.factor == 1.0})  # fmt: skip # noqa: E501
    states = system.state_names[4:]
    inner = [0.31 * size if name not in system.friction.switched else 1.0 for name, size in zip(states, system.friction.internal_scales(1.0), strict=True)]  # fmt: skip # noqa: E501
    force, rates = system.friction.force(0.07, tuple(inner), 1, 1.0)
    in_si = [value * units.factor(name) for name, value in zip(states, inner, strict=True)]
    found, found_rates = same.force(0.07 * units.factor("velocity"), tuple(in_si), 1, units.factor_of("N"))
    assert found == pytest.approx(force * units.factor("friction"), rel=1e-13)
    expected = [rate * units.factor(f"{name}_rate") for name, rate in zip(states, rates, strict=True)]
    assert found_rates == pytest.approx(expected, rel=1e-12)


def test_a_machine_of_ones_own_counts_in_units_that_are_given():
    @vc_parameters
    class Sled(vc.Oscillator):
        name = "sled"
        si_scales = vc.FreeScales

    scales = {"mass_unit_kg": 2.0, "length_unit_m": 0.5, "time_unit_s": 0.1}
    sled = Sled.in_si(mass_kg=3.0, stiffness_N_per_m=100.0, normal_load_N=4.0, **scales)
    system = vc.System(sled, vc.Coulomb(), vc.Harmonic.in_si(amplitude_N=5.0, frequency_Hz=1.0))
    assert system.machine == Sled(mass=1.5, stiffness=100 / (2 / 0.1**2), normal_load=4 / (2 * 0.5 / 0.1**2))
    assert system.units == vc.FreeScales(**scales)


def test_a_parameter_without_a_dimension_is_named_and_the_cure_cures():
    @vc_parameters
    class Strange(vc.Coulomb):
        name = "strange"
        colour: float = vc_parameter(1.0, "c", "of no dimension that is known")

    for law_ in (Strange.in_si(colour=2.0), Strange.in_si(), Strange()):  # given, left to its default, without units
        with pytest.raises(
            ValueError, match=r"friction.colour: declares neither a role nor a unit.*unit=\"1\""
        ) as refusal:
            vc.System(vc.PendulumCapsule.in_si(**CAPSULE), law_, vc.Biharmonic.in_si(**DRIVE))
        assert str(refusal.value).count("colour") == 1

    @vc_parameters
    class Cured(vc.Coulomb):
        name = "cured"
        colour: float = vc_parameter(1.0, "c", "a pure number", unit="1")

    system = vc.System(vc.PendulumCapsule.in_si(**CAPSULE), Cured.in_si(colour=2.0), vc.Biharmonic.in_si(**DRIVE))
    assert system.friction == Cured(colour=2.0)


def test_parts_in_si_and_parts_without_units_do_not_mix():
    with pytest.raises(ValueError, match=r"friction should be in SI like the machine, LuGre.in_si"):
        vc.System(vc.PendulumCapsule.in_si(**CAPSULE), vc.LuGre(), vc.Biharmonic.in_si(**DRIVE))
    with pytest.raises(ValueError, match=r"machine should be in SI like the other parts, PendulumCapsule.in_si"):
        vc.System(vc.PendulumCapsule(), vc.LuGre.in_si(**LUGRE), vc.Harmonic())
    mixed = vc.System(vc.PendulumCapsule.in_si(**CAPSULE), vc.Coulomb(), vc.Biharmonic.in_si(**DRIVE))
    assert mixed.friction == vc.Coulomb()  # its coefficients are the same numbers with units and without
    changed = dataclasses.replace(mixed, friction=vc.LuGre.in_si(**LUGRE))
    assert changed == bench()


def test_units_as_they_stand_in_keys():
    assert [suffix(unit) for unit in ("kg", "N m/rad", "N s/m", "1/s", "m/s^2", "Hz")] == [
        "_kg", "_N_m_per_rad", "_N_s_per_m", "_per_s", "_m_per_s2", "_Hz",
    ]  # fmt: skip


# --- machines with an inner mass --------------------------------------------------------------------------------------
INNER = """
[machine]
kind = "vibro-impact-capsule"
inner_mass_kg = 0.1
capsule_mass_kg = 0.4
stiffness_N_per_m = 100
damping_N_s_per_m = 0.2
stop_stiffness_N_per_m = 1500
gap_m = 0.002
normal_load = "weight"

[friction]
law = "coulomb"
coulomb_coefficient = 0.2
static_coefficient = 0.2

[drive]
waveform = "harmonic"
amplitude_N = 1.0
frequency_Hz = 5.0
"""


@pytest.mark.plain
def test_a_vibro_impact_case_in_si_needs_no_invented_units():
    """Not a unit of length or time, nor gravity; the load is what weighs on the contact, whatever the masses become."""
    system = case_from_text(INNER).system
    weight = (0.4 + 0.1) * 9.80665
    assert system.placed.loads()[0] * system.si.factor("friction") == pytest.approx(weight, rel=1e-14)
    heavy = system.with_parameters({"machine.capsule_mass_kg": 0.8})
    assert heavy.placed.loads()[0] * heavy.si.factor("friction") == pytest.approx(0.9 * 9.80665, rel=1e-14)
    assert system.machine.normal_load == "weight"
    motion = vc.simulate(system, periods=3)
    assert np.abs(motion["friction"]).max() == pytest.approx(0.2 * weight, rel=1e-12)
    assert case_from_text(case_text(vc.Case(system))).system == system


def test_the_weight_is_normal_to_a_slope_and_gravity_is_known_in_si():
    slope = "[environment]\ninclination_deg = 10\n"
    system = case_from_text(INNER + slope).system
    load = system.placed.loads()[0] * system.si.factor("friction")
    assert load == pytest.approx(0.5 * 9.80665 * math.cos(math.radians(10)), rel=1e-13)
    assert system.parameter("environment.gravity_m_per_s2") == pytest.approx(9.80665, rel=1e-15)
    crawler = vc.System(
        vc.TwoMassCrawler.in_si(inner_mass_kg=0.1, body_mass_kg=0.3, normal_load="weight"),
        vc.Coulomb(0.2, 0.2),
        vc.Harmonic.in_si(amplitude_m=0.02, frequency_Hz=5.0),
        environment=vc.Environment.in_si(inclination_deg=-10),
    )
    load = crawler.placed.loads()[0] * crawler.si.factor("friction")
    assert load == pytest.approx(0.4 * 9.80665 * math.cos(math.radians(10)), rel=1e-13)


def test_a_weight_needs_units_in_which_it_is_the_ratio_of_masses():
    with pytest.raises(CaseError, match=r"machine.normal_load: should be .weight. with a unit of time sqrt\(l/g\)"):
        case_from_text(INNER.replace("gap_m", "time_unit_s = 0.03\ngap_m"))
    with pytest.raises(CaseError, match=r'normal_load: should be a finite number >= 0 or "weight"'):
        case_from_text(INNER.replace('"weight"', '"heavy"'))
