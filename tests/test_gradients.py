"""Gradients of steady motions: published digits, tight differences of closed orbits on many systems, what is refused.

Differences are of the sixth order over seven orbits, each closed at a tolerance of 1e-13. With steps of 2e-4 of the
parameter, rounding leaves some 1e-13/2e-4 = 5e-10 of the size of the measure, which bounds the tolerance from below.
"""

import dataclasses
import itertools
import math
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from cases import printed, printed_json, refused
from thinned import exhaustive_but
from vibrocap.case.case import read_case
from vibrocap.cli.terminal import INCOMPLETE
from vibrocap.measures.recorded.summary import motion_summary
from vibrocap.motion.recording.equations import equations
from vibrocap.numerics.codegen.source import generated_source
from vibrocap.numerics.linker import digest
from vibrocap.numerics.run.motion import motion_layout
from vibrocap.orbits.closing import gradients as module
from vibrocap.orbits.closing.gradients import measures_with_gradients
from vibrocap.orbits.maps import variations

EXAMPLES = Path(__file__).parents[1] / "examples"
STEP = 2e-4
WEIGHTS = np.array([-1 / 60, 3 / 20, -3 / 4, 3 / 4, -3 / 20, 1 / 60])
SIZE = 1e-8  # of the measure over the parameter, or of the slope where that is larger

CAPSULE = vc.PendulumCapsule(mass_ratio=2.5, stiffness=2.0, damping=1.0)
BIHARMONIC = vc.Biharmonic(amplitude=1.8, frequency=1.0, second_amplitude=0.6)


def system(machine=CAPSULE, friction=None, drive=BIHARMONIC, **more):
    return vc.System(machine, friction or vc.Exponential(), drive, **more)


FIRST = system(drive=vc.Harmonic(amplitude=1.8, frequency=1.0))
START = {"angle": math.pi / 3}
PUBLISHED = {
    "machine.mass_ratio": -0.0120632485,
    "machine.stiffness": 0.0964434249,
    "machine.damping": 0.2519074267,
    "drive.amplitude": -0.1644508501,
    "drive.frequency": 0.0729158595,
    "friction.coulomb_coefficient": 0.1286200542,
    "friction.static_coefficient": 0.0050532599,
    "friction.decay_rate": 0.0004542536,
    "machine.normal_load": 0.0215669751,
}


@pytest.fixture(scope="module")
def first():
    return vc.orbit(FIRST, initial=START, tolerance=1e-13)


def test_the_slopes_of_the_first_set_have_the_published_digits(first):
    """Nine parameters of a motion with rests and reversals; the digits are those of an independent prototype."""
    assert first.mean_velocity == pytest.approx(0.026156756270, abs=1e-12)
    gradients = first.gradients()
    assert {slope.parameter for slope in gradients.slopes} == set(PUBLISHED)
    for path, expected in PUBLISHED.items():
        assert gradients["mean_velocity", path].slope == pytest.approx(expected, abs=6e-11), (
            path
        )  # half of the last digit
        elasticity = expected * FIRST.parameter(path) / first.mean_velocity
        assert gradients["mean_velocity", path].elasticity == pytest.approx(elasticity, rel=1e-6)


def test_the_slope_below_a_change_of_the_mode_sequence():
    """Amplitude 1.9302443323: from below the slope is -0.24998, and it holds for the sequence that is there."""
    below = vc.orbit(FIRST.with_parameters({"drive.amplitude": 1.9302443}), initial=START)
    slope = below.gradients(["drive.amplitude"])["mean_velocity", "drive.amplitude"].slope
    assert slope == pytest.approx(-0.24998, abs=1e-5)


def neighbours(orbit, path):
    """Measures [6] of the orbits three steps below and three above, by name; None where a mode sequence is another."""
    at = orbit.system.parameter(path)
    step = STEP * (abs(at) or 1.0)
    rows = []
    for k in (-3, -2, -1, 1, 2, 3):
        other = orbit.system.with_parameters({path: at + k * step})
        near = vc.shoot(other, orbit.state, orbit.response_period, tolerance=1e-13)
        if not near.closes or near.mode_sequence != orbit.mode_sequence:
            return None, step
        work = vc.energy_balance(near.motion(tolerance=1e-12)).drive / near.response_period
        rows.append({"drive_work": work})
        if near.drift is not None:
            drift = near.drift / near.response_period
            cost = work / abs(drift) if drift else math.inf
            rows[-1] |= {"mean_velocity": near.mean_velocity, "drift": drift, "cost_of_transport": cost}
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}, step


def check(orbit, paths=None, measures=None):
    """Every slope is that of tight differences; the number of them that could be compared."""
    known = measures_with_gradients(orbit.system)
    gradients, compared = orbit.gradients(paths, measures or [m for m in known if m in MEASURES]), 0
    for path in dict.fromkeys(slope.parameter for slope in gradients.slopes):
        try:
            values, step = neighbours(orbit, path)
        except ValueError:  # a bound of the parameter is near
            continue
        for measure in () if values is None else dict.fromkeys(slope.measure for slope in gradients.slopes):
            one = gradients[measure, path]
            if math.isinf(one.value):  # what does not travel
                assert math.isnan(one.slope)
                continue
            expected = WEIGHTS @ values[measure] / step
            size = max(abs(expected), np.max(np.abs(values[measure])) / (abs(orbit.system.parameter(path)) or 1.0))
            assert abs(one.slope - expected) <= SIZE * size + 1e-11, (path, measure, one.slope, expected)
            compared += 1
    return compared


MEASURES = ("mean_velocity", "drift", "drive_work", "cost_of_transport")
SYSTEMS = {  # name: (system, parameters whose slopes are to be compared, at least)
    "dynamic load": system(
        dataclasses.replace(CAPSULE, normal_load="dynamic"), vc.Exponential(0.05, 0.1), vc.Biharmonic(1.2, 1.0, 0.4)
    ),
    "bristles": system(friction=vc.LuGre()),
    "one level": system(friction=vc.Coulomb(0.1, 0.1)),
    "duty": system(drive=vc.Square(amplitude=1.5, frequency=1.0)),
    "durations": system(drive=vc.Trapezoid(amplitude=1.5, frequency=1.0)),
    "slope": system(environment=vc.Environment(inclination=0.02)),
    "actuator": system(actuator=vc.Actuator(time_constant=0.1, limit=1.5)),
}
CASES = (
    "strikes-its-stop-and-travels", "pendulum-strikes-its-stops", "crawler-with-two-phases", "best-three-phases",
    "climbs-a-slope", "tracked-pendulum-crawls", "two-masses-on-a-line", "strikes-two-walls",
    "bounces-and-rests-at-a-wall", "vibration-motor-travels", "rods-raise-a-mass",
)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", exhaustive_but([0, 4, len(SYSTEMS)], [*SYSTEMS, *CASES]))
def test_slopes_are_those_of_tight_differences(name):
    """Loads, laws of every kind, moving corners, a slope, an actuator; impacts, imposed motions, contacts, a rotor."""
    if name in SYSTEMS:
        plain, initial = SYSTEMS[name], {"angle": 1.0}
    else:
        case = read_case(EXAMPLES / f"{name}.toml")
        plain, initial = dataclasses.replace(case.system, units=None), case.initial
    orbit = vc.orbit(plain, initial=initial, tolerance=1e-13)
    assert orbit.closes
    assert check(orbit) >= (4 * 5 if name in SYSTEMS else 8)


@pytest.mark.slow
def test_a_motion_of_two_periods_has_slopes_over_both():
    """The period enters twice, and so does each corner."""
    once = vc.orbit(SYSTEMS["dynamic load"], initial=START)
    orbit = vc.shoot(once.system, once.state, 2, tolerance=1e-13)
    assert orbit.response_period == 2
    assert check(orbit, ["drive.frequency", "machine.stiffness"]) == 8


# --- what a user sees -------------------------------------------------------------------------------------------------


def test_the_table_has_a_row_for_each_measure_and_parameter(first):
    gradients = first.gradients(["drive.amplitude", "drive.frequency"], ["drift", "mean_velocity"])
    rows = [(row["measure"], row["parameter"]) for row in gradients.table()]
    assert rows == list(itertools.product(["drift", "mean_velocity"], ["drive.amplitude", "drive.frequency"]))
    assert "largest elasticity" in repr(gradients)
    with pytest.raises(KeyError):
        gradients["drift", "machine.damping"]
    period = 2.0 * math.pi
    drift, velocity = (gradients[name, "drive.frequency"] for name in ("drift", "mean_velocity"))
    assert drift.slope == pytest.approx(velocity.slope * period - drift.value, rel=1e-9)  # D = V T, T = 2 pi/h at h = 1


@pytest.mark.slow
def test_the_command_prints_slopes_with_units_and_elasticities(capsys):
    case = EXAMPLES / "bench-in-si.toml"
    rows = printed_json(capsys, "orbit", case, "--gradients")["gradients"]
    orbit = vc.orbit(read_case(case).system, initial=read_case(case).initial)
    expected = orbit.gradients(measures=["mean_velocity", "cost_of_transport"]).table()
    for row, other in zip(rows, expected, strict=True):
        slope = row["slope"]["value"] if isinstance(row["slope"], dict) else row["slope"]
        assert slope == pytest.approx(other["slope"], rel=1e-9)
    text = " ".join(printed(capsys, "orbit", case, "--gradients").split())
    assert "Gradient of cost of transport" in text
    assert f"drive.frequency_Hz {expected[7]['slope']:.8g} (m/s)/Hz {expected[7]['elasticity']:.4g}" in text


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("over", "measures", "said"),
    [
        (["machine.mas_ratio"], None, "machine.mas_ratio: .* did you mean 'machine.mass_ratio'"),
        (["drive.frequency"], ["mode_sequence"], "measures: there is no gradient of 'mode_sequence'; .*mean_velocity"),
        (["drive.frequency"], ["drive_wrk"], "did you mean 'drive_work'"),
    ],
)
def test_what_has_no_gradient_is_named_before_any_work(over, measures, said, first, monkeypatch):
    monkeypatch.setattr(module, "ensemble_run", lambda *_, **__: pytest.fail("a run was begun"))
    with pytest.raises(ValueError, match=said):
        first.gradients(over, measures)


@pytest.mark.parametrize(
    ("name", "said"),
    [("worm-of-two-bodies", "turn at one instant"), ("sticks-and-slips-on-a-belt", "nothing drives it in time")],
)
def test_systems_without_gradients_are_refused_by_name(name, said, capsys):
    complaint = refused(capsys, "orbit", EXAMPLES / f"{name}.toml", "--gradients")
    assert complaint.startswith("--gradients: ")
    assert said in complaint


@pytest.mark.slow
def test_a_count_of_the_drive_has_no_slope_and_stands_in_the_way_of_none():
    """The pulses of a period are whole: their height, frequency and modulation have slopes, as differences do."""
    drive = vc.PulseWidth(amplitude=1.2, frequency=0.8, pulses=4)
    system = vc.System(vc.TwoMassCapsule(), vc.anisotropic(vc.Coulomb)(0.1, 0.2, back_ratio=1.5), drive)
    gradients = vc.orbit(system).gradients()
    assert not any(slope.parameter == "drive.pulses" for slope in gradients.slopes)
    for path in ("drive.modulation", "drive.amplitude"):
        value, step = system.parameter(path), 1e-5
        ends = [vc.orbit(system.with_parameters({path: value + sign * step})).mean_velocity for sign in (1.0, -1.0)]
        assert gradients["mean_velocity", path].slope == pytest.approx((ends[0] - ends[1]) / (2.0 * step), rel=1e-6)
    with pytest.raises(ValueError, match=r"drive\.pulses should be a number to have a gradient, it is the count 4"):
        vc.orbit(system).gradients(["drive.pulses"])


@pytest.mark.plain
def test_an_event_on_a_corner_of_the_drive_is_named():
    drive = vc.OnOff(1.2, -0.20338534, 0.99187412, 0.21071708)
    system = vc.System(vc.TwoMassCapsule(damping=0.24770982), vc.Coulomb(0.2, 0.25), drive)
    gradients = vc.orbit(system).gradients(["machine.damping"])
    assert gradients.kinks == ("reversal",)
    assert "to one side only: reversal on a corner of the drive" in str(gradients)
    assert vc.orbit(system.with_parameters({"drive.duty": 0.3})).gradients("machine.damping").kinks == ()


@pytest.mark.slow
def test_a_stop_that_opens_on_a_corner_of_the_drive_goes_with_it():
    """The mass rests at the stop exactly until the drive switches: the corner moves it only after it has left."""
    drive = vc.OnOff(amplitude=1.5, offset=-0.7, frequency=0.1, duty=0.4)
    orbit = vc.orbit(vc.System(vc.RigidStopCapsule(restitution=0.3), vc.Coulomb(0.2, 0.9), drive), tolerance=1e-13)
    assert {"stop_opened"} <= {*orbit.gradients("drive.duty").kinks}
    assert check(orbit, ["drive.duty", "drive.frequency"], ["mean_velocity"]) == 2


@pytest.mark.plain
def test_an_orbit_of_a_continuum_has_no_gradient():
    """A crawler of two equally long phases keeps whatever velocity it has: the drift is not determined."""
    even = vc.Triangle(amplitude=0.2, frequency=2.0 * math.pi, rise=0.5)
    orbit = vc.orbit(vc.System(vc.TwoMassCrawler(mass_ratio=1.0), vc.Coulomb(0.2, 0.2), even))
    assert orbit.continuum
    with pytest.raises(ValueError, match="orbit: is one of a continuum"):
        orbit.gradients(["drive.amplitude"])


@pytest.mark.slow
def test_what_does_not_travel_has_no_cost():
    """A linear machine under two harmonics: its drift is rounding, whose cost was 1e15."""
    drag = vc.Environment(linear_drag=0.3)
    linear = vc.System(vc.TwoMassCapsule(), vc.Coulomb(0.0, 0.0), vc.Biharmonic(0.5, 0.8, 0.3), environment=drag)
    steady = vc.orbit(linear)
    slopes = steady.gradients("machine.damping", ["cost_of_transport", "mean_velocity"]).slopes
    cost, velocity = sorted(slopes, key=lambda slope: slope.measure)
    assert (cost.value, velocity.value) == (math.inf, 0.0)
    assert math.isnan(cost.slope)
    assert math.isnan(velocity.elasticity)
    assert motion_summary(vc.simulate(linear, periods=60)).cost_of_transport is None


def test_tangents_do_not_depend_on_what_was_recorded_before():
    """Where no kernel is kept, writing one records more: multipliers had other digits than in the next process."""
    recorded = equations(
        system(dataclasses.replace(CAPSULE, normal_load="dynamic"), drive=vc.Biharmonic(1.2, 1.0, 0.4))
    )
    makers = [variations.variational_equations, variations.with_integrals]
    before = [digest(make.__wrapped__(recorded)) for make in makers]
    generated_source(recorded, motion_layout(recorded, 12))
    assert [digest(make.__wrapped__(recorded)) for make in makers] == before


@pytest.mark.plain
def test_a_failed_orbit_has_neither_gradients_nor_numbers(tmp_path, capsys):
    """The light capsule lifts off: it had a drift and a mean velocity of 0.0 beside "run failed"."""
    machine = vc.PendulumCapsule(mass_ratio=0.2, normal_load="dynamic")
    light = vc.System(machine, vc.Exponential(), vc.Harmonic(amplitude=3.0))
    orbit = vc.orbit(light)
    assert (orbit.status, orbit.drift, orbit.mean_velocity) == (vc.OrbitStatus.RUN_FAILED, None, None)
    assert set(orbit.facts) == {"status"}
    assert repr(orbit).startswith("<Orbit: no closed steady motion of a pendulum-capsule")
    assert "<img" not in orbit._repr_html_()  # there was an error: the last state cannot be simulated
    with pytest.raises(ValueError, match="orbit should be closed: this one is run failed"):
        orbit.gradients()
    vc.save_case(light, tmp_path / "light.toml")
    record = printed_json(capsys, "orbit", tmp_path / "light.toml", "--gradients", code=INCOMPLETE)
    assert [record[name] for name in ("period", "drift", "mean_velocity", "residual", "symmetric")] == [None] * 5
    assert not record["mode_sequence"]
    assert not record["multipliers"]
    assert "gradients" not in record


def test_integrals_along_the_tangent_leave_the_motion_alone():
    """The equations with integrals have the same rates, and one integral more for each channel."""
    recorded = equations(FIRST)
    longer = variations.with_integrals(recorded)
    assert [rate.index for rate in longer.rates[: len(recorded.rates)]] == [rate.index for rate in recorded.rates]
    assert longer.base == len(recorded.rates) + len(variations.carried(recorded))
