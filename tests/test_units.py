"""Results in SI: cases there and back, motions, files, and sweeps whose numbers are those without units."""

import dataclasses
import math
import re
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from test_case import complaints
from vibrocap.arguments import ArgumentError
from vibrocap.case.case import CaseError, case_from_text, case_text, read_case
from vibrocap.cli import main as cli
from vibrocap.io.motion_file import read_source, write_motion
from vibrocap.io.spreadsheets import beside
from vibrocap.physics.dimensions.conversion import quantity_in_si
from vibrocap.physics.dimensions.scales import SIScales
from vibrocap.physics.dimensions.units import parameter_keys
from vibrocap.physics.parameters import Positive, parameter, parameters

CASE = """\
[machine]
kind = "pendulum-capsule"
capsule_mass_kg = 0.5
pendulum_mass_kg = 0.2
pendulum_length_m = 0.25
stiffness_N_m_per_rad = 0.98
damping_N_m_s_per_rad = 0.08
normal_load = "weight"

[friction]
law = "exponential"
decay_rate_s_per_m = 6.5

[drive]
waveform = "harmonic"
amplitude_N_m = 0.9
frequency_Hz = 1.1

[initial]
angle = 1.0
velocity_m_per_s = 0.1

[run]
periods = 12
"""
PRESSED = CASE.replace('normal_load = "weight"', "normal_load_N = 6.864655")  # as the weight presses, in one number


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("si.toml").write_text(CASE, encoding="utf-8")
    return tmp_path


def without(text, case=CASE):
    return "".join(line for line in case.splitlines(keepends=True) if text not in line)


# --- cases ------------------------------------------------------------------------------------------------------------
def test_a_case_in_si_is_the_system_of_its_parts():
    machine = vc.PendulumCapsule.in_si(
        capsule_mass_kg=0.5,
        pendulum_mass_kg=0.2,
        pendulum_length_m=0.25,
        stiffness_N_m_per_rad=0.98,
        damping_N_m_s_per_rad=0.08,
        normal_load="weight",
    )
    drive = vc.Harmonic.in_si(amplitude_N_m=0.9, frequency_Hz=1.1)
    system = vc.System(machine, vc.Exponential.in_si(decay_rate_s_per_m=6.5), drive)
    case = case_from_text(CASE)
    assert case.system == system
    assert case.initial == {"angle": 1.0, "velocity": 0.1 / math.sqrt(9.80665 * 0.25)}


def test_units_si_makes_bare_keys_si():
    bare = CASE
    for unit in ("_kg", "_N_m_per_rad", "_N_m_s_per_rad", "_s_per_m", "_N_m", "_m_per_s"):
        bare = bare.replace(f"{unit} =", " =")
    bare = 'units = "SI"\n' + bare.replace("pendulum_mass =", "pendulum_mass_kg =")
    assert case_from_text(bare) == case_from_text(CASE)
    (said,) = complaints(bare.replace("frequency_Hz", "frequency"))
    assert said == "drive.frequency: has no unit in a case in SI; give frequency_Hz or frequency_rad_per_s"


def test_the_text_in_si_has_the_numbers_that_were_given():
    case = case_from_text(CASE)
    text = case_text(case)
    assert case_from_text(text) == case
    assert set(CASE.splitlines()) <= set(text.splitlines())


SCALES = {  # of one size for each kind
    vc.PendulumScales: vc.PendulumScales(0.2, 0.25),
    vc.InnerMassScales: vc.InnerMassScales(0.2, 0.25, 0.16),
    vc.FreeScales: vc.FreeScales(0.2, 0.25, 0.16),
    vc.WeightScales: vc.WeightScales(0.2, 0.25),
    SIScales: None,  # these machines count in any units
}


@pytest.mark.parametrize("path", sorted(Path("examples").glob("*.toml")), ids=lambda path: path.stem)
def test_every_example_there_and_back(path):
    """To SI to rounding (4 ulp: a product and a quotient by the same factor), and then exactly."""
    case = read_case(path)
    known = dataclasses.replace(case, scales=None if case.system.units else SCALES[case.system.machine.si_scales])
    in_si = case_from_text(case_text(known, "SI"))
    for name in case.system.parameter_paths:
        before, after = case.system.parameter(name), in_si.system.parameter(name)
        assert before == after or before == pytest.approx(after, rel=2**-50), name
    assert in_si.initial == pytest.approx(case.initial, rel=2**-50)
    back = case_from_text(case_text(in_si, "dimensionless"))
    assert back.system == dataclasses.replace(in_si.system, units=None)
    assert case.system.machine.si_scales is SIScales or back.scales == in_si.system.units
    assert case_from_text(case_text(back, "SI")) == in_si


def test_a_case_without_units_that_knows_its_scales_has_results_in_si():
    plain = '[machine]\nkind = "pendulum-capsule"\n[friction]\nlaw = "coulomb"\n[drive]\nwaveform = "harmonic"\n'
    scales = "[scales]\npendulum_mass_kg = 0.2\npendulum_length_m = 0.25\n"
    known = case_from_text(plain + scales)
    assert known.system == dataclasses.replace(case_from_text(plain).system, units=vc.PendulumScales(0.2, 0.25))
    kept = case_from_text('units = "dimensionless"\n' + plain + scales)
    assert kept.system == case_from_text(plain).system
    assert kept.scales == vc.PendulumScales(0.2, 0.25)


def test_the_default_load_without_units_stays_the_weight_of_the_pendulum():
    plain = '[machine]\nkind = "pendulum-capsule"\n[friction]\nlaw = "coulomb"\n[drive]\nwaveform = "harmonic"\n'
    assert case_from_text(plain).system.machine.loads() == (1.0,)
    (said,) = complaints(without("normal_load"))
    assert said.startswith('machine.normal_load_N: is missing; give the load on the contact in N, or "weight"')
    assert "the one without units, 1, is the weight of the pendulum alone" in said


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("stiffness_N_m_per_rad = 0.98", "stiffness = 2.0"),
         "machine.stiffness: has no unit in a case in SI; give stiffness_N_m_per_rad"),
        (("capsule_mass_kg = 0.5", "mass_ratio = 2.5"),
         "machine.mass_ratio: has no unit in a case in SI; give capsule_mass_kg"),
        (("capsule_mass_kg = 0.5", "capsule_mass_kg = -0.5"),
         "machine.capsule_mass_kg: should be greater than 0, got -0.5"),
        (("capsule_mass_kg = 0.5", 'capsule_mass_kg = "1"'), "machine.capsule_mass_kg: should be a number, got '1'"),
        (("pendulum_length_m = 0.25", ""), "machine.pendulum_length_m: is missing"),
        (("[friction]", "[friction]\ncoulomb_coefficient = 0.2"),
         "friction.static_coefficient: is missing; it has no default in SI"),
        (("frequency_Hz = 1.1", "frequency_Hz = 1.1\nfrequency_rad_per_s = 7"),
         "drive.frequency_rad_per_s: is frequency_Hz once more; give one of them"),
        (("velocity_m_per_s = 0.1", "velocity = 0.1"),
         "initial.velocity: has no unit in a case in SI; give velocity_m_per_s"),
        (("angle = 1.0", "angel_deg = 1.0"), "initial.angel_deg: no such key in SI; did you mean 'angle_deg'?"),
        (("[run]", "[scales]\npendulum_mass_kg = 1\n[run]"),
         "scales: belongs to a case without units; in SI [machine] has to give its units: "
         "pendulum_mass_kg, pendulum_length_m, gravity_m_per_s2"),
        (('"exponential"', '"exponential2"'),
         "friction.law: no law is called 'exponential2'; did you mean 'exponential'?"),
        (('"harmonic"', '"harmonc"'), "drive.waveform: no waveform is called 'harmonc'; did you mean 'harmonic'?"),
        (("[machine]", 'units = "si"\n[machine]'), """units: should be "SI" or "dimensionless", got 'si'"""),
    ],
)  # fmt: skip
def test_what_is_wrong_in_si_is_named_as_it_was_given(change, said):
    assert complaints(CASE.replace(*change)) == (said,)


def test_a_case_is_saved_from_python(place):
    system = case_from_text(CASE).system
    vc.save_case(system, "saved.toml", initial={"angle": 0.5, "position_m": 0.1}, periods=7)
    case = read_case("saved.toml")
    assert case.system == system
    assert case.periods == 7
    assert case.initial == {"angle": 0.5, "position": 0.1 / 0.25}
    plain = vc.System(vc.PendulumCapsule(mass_ratio=1 / 3), vc.LuGre(), vc.Harmonic())
    vc.Case(plain).save("plain.toml")
    assert read_case("plain.toml").system == plain
    with pytest.raises(ValueError, match=r"units: SI needs to know .* pendulum_mass_kg"):
        vc.save_case(plain, "no.toml", "SI")


# --- motions ----------------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def motions():
    """The same motion in SI and without units."""
    case = case_from_text(CASE)
    return case.simulate(), dataclasses.replace(case, system=dataclasses.replace(case.system, units=None)).simulate()


@pytest.mark.parametrize("ending", ["csv", "nc"])
def test_files_carry_si_with_units_and_their_case(motions, ending, tmp_path):
    import xarray

    known, plain = motions
    case = case_from_text(CASE)
    path = write_motion(known, tmp_path / f"motion.{ending}", case)
    assert read_source(path) == case
    if ending == "nc":
        with xarray.open_dataset(path) as found:
            assert found["velocity"].attrs["units"] == "m/s"
            assert found["time"].attrs["units"] == "s"
            assert np.array_equal(found["velocity"], known["velocity"])
            scale = found["velocity"].attrs["dimensionless_unit"]
            assert found["velocity"].values / scale == pytest.approx(plain["velocity"], rel=1e-15)
        return
    assert '\nvelocity = "m/s"\n' in beside(path).read_text(encoding="utf-8")
    rows = np.genfromtxt(path, delimiter=",", names=True)
    assert np.array_equal(rows["drive"], known["drive"])


def test_convert_writes_the_other_form_and_back(place, capsys):
    assert cli.main(["new", "--from", "si.toml", "--out", "plain.toml"]) == 0
    assert cli.main(["new", "--from", "plain.toml", "--out", "again.toml"]) == 0
    assert read_case("again.toml") == read_case("si.toml")
    assert read_case("plain.toml").system.units is None
    example = "plain.toml"
    lines = Path(example).read_text().replace('units = "dimensionless"', "").replace("[scales]", "")
    Path(example).write_text(without("gravity", without("pendulum_", lines)))
    assert cli.main(["new", "--from", example]) == 2
    assert "--scales: is missing" in capsys.readouterr().err
    assert cli.main(["new", "--from", example, "--scales", "pendulum_mass_kg=0.2,pendulum_length_m=x"]) == 2
    said = capsys.readouterr().err
    assert "--scales pendulum_length_m: should be a number, got 'x'" in said


# --- sweeps -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("over", "said"),
    [
        ({"machine.capsule_mass_kg": [-0.5, 0.5]}, "machine.capsule_mass_kg: should be greater than 0, got -0.5"),
        ({"machine.capsule_mas_kg": [0.5]}, "did you mean 'machine.capsule_mass_kg'"),
        ({"drive.frequency_Hz": [1.0], "drive.frequency_rad_per_s": [6.0]}, "is given in two ways; give one of them"),
        ({"machine.kind": ["oscillator"]}, "machine.kind: machines count in units of their own"),
        ({"friction.law": ["lugre", "dahl"], "friction.stribeck_velocity_m_per_s": [0.1]}, "not all kinds have it"),
    ],
)
def test_wrong_axes_in_si_are_named_as_they_were_given(over, said):
    with pytest.raises(CaseError) as caught:
        vc.sweep(case_from_text(CASE).system, over, periods=4, tolerance=1e-8, settle=0)
    assert said in "\n".join(caught.value.complaints)


def test_axes_in_si_need_scales():
    plain = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    with pytest.raises(CaseError, match=r"drive.frequency_Hz: the case does not give .*; add drive.frequency, or"):
        vc.sweep(plain, {"drive.frequency_Hz": [1.0, 2.0]}, periods=4, tolerance=1e-8, settle=0)


def test_a_system_is_changed_in_si():
    system = case_from_text(CASE).system
    path = next(quantity_in_si(path, system).path for path in system.parameter_paths if path == "drive.frequency")
    faster = system.with_parameters({path: 2.0 * system.parameter(path)})
    assert faster.parameter(path) == pytest.approx(2.0 * system.parameter(path), rel=1e-15)
    assert faster.drive.period == pytest.approx(0.5 * system.drive.period, rel=1e-15)
    assert faster.units == system.units
    assert system.with_parameters({"drive.frequency": 1.25}).drive.frequency == 1.25  # without units by the plain path
    with pytest.raises(ArgumentError, match=f"did you mean '{path}'"):
        system.with_parameters({path.replace("qu", "q"): 1.0})
    with pytest.raises(ArgumentError, match="is given in two ways"):
        system.with_parameters({path: 1.0, "drive.frequency": 1.0})
    with pytest.raises(ArgumentError, match="the case does not give its units; add drive"):
        dataclasses.replace(system, units=None).with_parameters({path: 1.0})


@pytest.mark.plain
def test_friction_between_bodies_that_turn_is_a_torque():
    """In the units of a case, of results and of laws, and in their sizes where length is counted in 3 m."""
    scales = vc.FreeScales(mass_unit_kg=2.0, length_unit_m=3.0, time_unit_s=0.5)
    own = read_case("examples/clutch-slips-twice.toml", {"friction.law": "lugre"}, periods=2).system.machine
    system = vc.System(own, vc.LuGre(viscous_damping=0.1), vc.Harmonic(1.2), units=scales)
    text = case_text(vc.Case(system), "SI")
    torque = 2.0 * 3.0**2 / 0.5**2
    for key, value in (
        *(("bristle_stiffness_per_rad", 100.0), ("viscous_damping_s_per_rad", 0.1 * 0.5)),
        *(("stribeck_velocity_rad_per_s", 0.1 / 0.5), ("preload_N_m", torque), ("amplitude_N_m", 1.2 * torque)),
    ):
        assert float(re.search(rf"^{key} = (.+)$", text, re.MULTILINE)[1]) == pytest.approx(value, rel=1e-12), key
    assert case_from_text(text).system == system
    motion = vc.simulate(system, periods=2)
    units = ("friction", "reaction", "bristle", "contact_velocity", "slip_rate", "energy")
    assert [motion.unit_of(name) for name in units] == ["N m", "N m", "rad", "rad/s", "rad/s", "J"]
    plain = motion.dimensionless
    assert motion["friction"] == pytest.approx(torque * plain["friction"], rel=1e-14)
    assert motion["bristle"] == pytest.approx(plain["bristle"], rel=1e-14)
    line = vc.System(vc.TwoBodyCrawler(), vc.LuGre(), vc.Harmonic(), units=SIScales())
    assert [line.si.unit(name) for name in ("friction", "friction_2", "bristle_2")] == ["N", "N", "m"]
    drill = vc.System(vc.DrillString(), vc.LuGre(), vc.Harmonic(0.3, 0.5), units=SIScales())
    assert drill.with_parameters({"friction.stribeck_velocity_rad_per_s": 0.2}).friction.stribeck_velocity == 0.2
    fed = vc.System(vc.Clutch(), vc.Exponential(), vc.Harmonic(), units=SIScales())
    assert vc.mean_velocity(vc.simulate(fed, periods=60)).unit_of("value") == "rad/s"


def test_a_declared_unit_and_a_role_give_one_key():
    """Radians of a declared unit stand in the key, as those of a role do; before, its dimension had lost them."""

    @parameters
    class Part:
        stiffness: Positive = parameter(1.0, "k", "of a role", "torsional stiffness")
        stiffness_2: Positive = parameter(1.0, "k", "declared", unit="N m/rad")
        damping: Positive = parameter(1.0, "c", "of a role", "torsional damping")
        damping_2: Positive = parameter(1.0, "c", "declared", unit="N m s/rad")
        rate_2: Positive = parameter(1.0, "w", "declared", unit="rad/s")
        friction_2: Positive = parameter(1.0, "c", "along a line", unit="N s/m")

    keys = ["stiffness_N_m_per_rad", "stiffness_2_N_m_per_rad", "damping_N_m_s_per_rad", "damping_2_N_m_s_per_rad"]
    for effort in ("force", "torque"):
        assert list(parameter_keys(Part, effort)) == [*keys, "rate_2_rad_per_s", "friction_2_N_s_per_m"]


DYNAMIC = CASE.replace('normal_load = "weight"', 'normal_load = "dynamic"')
REFUSALS = {
    "initial: the normal load is negative at the start, -73.* N: .*angle_rate 40 rad/s": (
        lambda motion: vc.simulate(case_from_text(DYNAMIC).system, initial={"angle_rate": 40.0})
    ),
    r"between: drive\.frequency_Hz cannot be -1 Hz: should be greater than 0": (
        lambda motion: vc.crossing(motion.system, "mean_velocity", "drive.frequency_Hz", (-1.0, 2.0))
    ),
    "between should be .*, got 2 Hz to 1 Hz$": (
        lambda motion: vc.crossing(motion.system, "mean_velocity", "drive.frequency_Hz", (2.0, 1.0))
    ),
    "times should lie between start_time and end of the motion": lambda motion: motion.at(2.0 * motion.end, "angle"),
    "modulo should be .*, got -3.0$": lambda motion: motion.crossings("velocity", 0.1, modulo=-3.0),
    "window should be .* end of the motion, got \\(0.5, 30.0\\)$": lambda motion: vc.displacement(motion, (0.5, 30.0)),
    "below should be .*, got -0.5$": lambda motion: vc.stick_fraction(motion, below=-0.5),
    "ranges: velocity should be .*, got 0.1 m/s to -0.1 m/s$": (
        lambda motion: vc.attractors(motion.system, ranges={"velocity_m_per_s": (0.1, -0.1)})
    ),
    "drive.frequency_Hz: should be greater than 0, got -2.0$": (
        lambda motion: motion.system.with_parameters({"drive.frequency_Hz": -2.0})
    ),
    "integration, .* m/s, got 1e-30 m/s": (
        lambda motion: vc.width_for(motion.system, "mean_velocity", 1e-30, relative=False, periods=1)
    ),
    "sample_time should be a whole part of the period 0.909091 s .*, at least .* s, got 0.5 s": (
        lambda motion: vc.System(
            motion.system.machine,
            motion.system.friction,
            motion.system.drive,
            motion.system.units,
            controller=vc.SampledVelocityPI(sample_time=0.5 / motion.system.si.factor("time")),
        )
    ),
}


@pytest.mark.parametrize("words", REFUSALS)
def test_refusals_of_a_system_in_si_are_in_si(words, motions):
    with pytest.raises(ValueError, match=words):
        REFUSALS[words](motions[0])
