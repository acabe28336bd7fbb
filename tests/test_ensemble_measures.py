"""Measures taken during the run: the same from the stored motion, and the same as the measures written with arrays."""

import dataclasses
import functools
import importlib
import math
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from signals import Signal, made_up_motion
from thinned import exhaustive_but, slow_but
from vibrocap.case.case import read_case
from vibrocap.measures.during_run import SYNONYMS, measure_table, resolved
from vibrocap.measures.measure import own_integrands
from vibrocap.measures.recorded.stretch import stretches
from vibrocap.measures.standard import undefined_measures
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.simulate import _trajectory
from vibrocap.motion.trajectory import Trajectory
from vibrocap.numerics.run import ensemble as devices
from vibrocap.numerics.run import ensemble as numerics
from vibrocap.numerics.run.budget import Budget, Form, MotionStart
from vibrocap.numerics.run.motion import recorded_run
from vibrocap.numerics.run.results import RunResults
from vibrocap.physics.catalogue import machines
from vibrocap.physics.parameters import parameters

BRIDGE = importlib.import_module("vibrocap.measures.ensemble")  # whose name in the package is the function's
EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.toml"))
START = {"angle": math.pi / 3}
TOLERANCE = 1e-8
ORDER = numerics.ensemble_order(TOLERANCE)


def system_with(law, ratio=2.5, drive=None):
    return vc.System(vc.PendulumCapsule(mass_ratio=ratio), law, drive or vc.Harmonic())


def stored_motion(system, periods) -> Trajectory:
    """The motion step by step as an ensemble follows it, from the plain kernel: no other one has to be compiled."""
    start = dict.fromkeys(system.state_names, 0.0) | START
    budget = Budget(periods, TOLERANCE, 10_000, 10**6)
    recorded = recorded_run(
        MotionStart(equations(system), parameter_values(system), list(start.values()), system.drive.period),
        budget,
        Form(plain=True, order=ORDER),
    )
    return _trajectory(system, (start, 0.0, 0.0), budget, 256, recorded)


# --- the same as the measures with arrays ----------------------------------------------------------------------------

MOTIONS = {
    "exponential": (vc.Exponential(), vc.Harmonic(), 2.5),
    "exponential, two tones": (vc.Exponential(), vc.Biharmonic(second_amplitude=0.9, second_phase=0.7), 2.5),
    "lugre": (vc.LuGre(), vc.Harmonic(), 2.5),
}
WINDOW = 3


@functools.cache
def motion_of(name) -> Trajectory:
    law, drive, ratio = MOTIONS[name]
    if isinstance(drive, vc.Biharmonic):
        return stored_motion(system_with(law, ratio, drive), periods=4)
    return vc.simulate(system_with(law, ratio, drive), periods=12, initial=START, tolerance=TOLERANCE)


@functools.cache
def measures_of(name):
    motion = motion_of(name)
    return vc.measured(motion, vc.measure_table(motion.system), window=WINDOW)


def window_of(motion):
    done = len(motion.sections) - 1
    return (done - WINDOW) * motion.period, done * motion.period


@pytest.mark.parametrize("name", slow_but([0], [*MOTIONS][1:]))
class TestAgainstArrays:
    """Six points per piece against twelve or sixteen, which are exact to rounding.

    Six are off by 1e-6 tolerance^(10/12) = 2e-13 of a piece (`accumulators.py`), of which a window has some hundred.
    """

    def test_travel(self, name):
        motion, found = motion_of(name), measures_of(name)
        assert found["displacement"] == pytest.approx(vc.displacement(motion, periods=WINDOW), abs=1e-13)
        assert found["mean_velocity"] == pytest.approx(vc.mean_velocity(motion, WINDOW).value, abs=1e-14)
        assert found["drift"] == pytest.approx(vc.displacement(motion, periods=WINDOW) / WINDOW, abs=1e-13)

    def test_energy(self, name):
        balance, found = vc.energy_balance(motion_of(name), periods=WINDOW).per_period, measures_of(name)
        for channel in motion_of(name).system.channels:
            assert found[f"{channel}_work"] == pytest.approx(getattr(balance, channel), abs=1e-11), channel
        assert found["drive_work"] > 0.1
        assert found["cost_of_transport"] == pytest.approx(found["drive_work"] / abs(found["drift"]), rel=1e-12)

    def test_sticking(self, name):
        motion, found = motion_of(name), measures_of(name)
        assert found["mode_sequence"] == vc.mode_sequence(motion)
        assert len(found["mode_sequence"]) > 1
        phases = vc.stick_phases(motion, periods=WINDOW)
        if phases is None:
            assert math.isnan(found["stick_fraction"])
            assert math.isnan(found["stick_phases"])
        else:
            assert found["stick_phases"] == phases.number > 0
            assert found["stick_fraction"] == pytest.approx(vc.stick_fraction(motion, periods=WINDOW), rel=1e-11)

    def test_loops(self, name):
        """One window of three periods against three loops of one period."""
        motion, found = motion_of(name), measures_of(name)
        loops = [vc.friction_loop(motion, -1 - k) for k in range(WINDOW)]
        assert found["peak_friction"] == pytest.approx(max(loop.peak_force for loop in loops), rel=1e-11)
        for area, measure in (("velocity_area", "velocity_loop_area"), ("displacement_area", "displacement_loop_area")):
            mean = sum(getattr(loop, area) for loop in loops) / WINDOW
            assert found[measure] == pytest.approx(mean, abs=2e-11)
        assert found["displacement_loop_area"] > 1e-3

    def test_mean_friction(self, name):
        """Stretches are cut at the zeros of R, located by bisection."""
        motion = motion_of(name)
        total = 0.0
        for part in stretches(motion, *window_of(motion)):
            nodes = part.nodes(part.roots(part.friction))
            total += float(np.sum(nodes.weight * np.abs(nodes.friction)))
        expected = total / (WINDOW * motion.period)
        assert measures_of(name)["mean_friction"] == pytest.approx(expected, rel=1e-11)

    def test_extremes(self, name):
        """Against a dense grid: at its best point it falls short by half the curvature times half a spacing squared."""
        motion, found = motion_of(name), measures_of(name)
        t, dt = np.linspace(*window_of(motion), 20_001, retstep=True)
        for state, values in zip(motion.state_names, motion.states(t), strict=True):
            short = np.max(np.abs(np.diff(values, 2))) / 4.0 + 1e-14
            assert dt < 1e-3
            assert 0.0 <= found[f"largest_{state}"] - values.max() + 1e-14 <= short, state
            assert 0.0 <= values.min() - found[f"least_{state}"] + 1e-14 <= short, state
            assert 0.0 <= found[f"peak_{state}"] - np.abs(values).max() + 1e-14 <= short, state
            assert 0.0 <= found[f"{state}_range"] - np.ptp(values) + 2e-14 <= 2.0 * short, state
        drive = motion.at(t, "drive")
        for name, values in (("drive", drive), ("drive_power", drive * motion.at(t, "angle_rate"))):
            short = np.max(np.abs(np.diff(values, 2))) / 4.0 + 1e-14
            assert 0.0 <= found[f"peak_{name}"] - np.abs(values).max() + 1e-14 <= short, name
        assert found["peak_drive_rate"] == pytest.approx(np.abs(np.gradient(drive, dt)).max(), rel=1e-5)

    def test_response(self, name):
        motion = motion_of(name)
        values = vc.measured(motion, ["response_period", "symmetric"], window=WINDOW, settle=1e-2)
        response = vc.response_class(motion, threshold=1e-2)
        assert (values["response_period"] or None) == response.period
        closer = vc.measured(motion, ["response_period"], window=WINDOW, settle=1e-3)["response_period"]
        assert closer in (0, vc.response_class(motion, threshold=1e-3).period)  # none where a slow mode has far to go
        if response.symmetric is None:
            assert math.isnan(values["symmetric"])
        else:
            assert values["symmetric"] == response.symmetric


@pytest.mark.slow
def test_symmetry_is_that_of_each_run_of_an_ensemble():
    """The first lifts off, the second is its own mirror image, the drive of the third has no half-period symmetry."""
    machine = vc.PendulumCapsule(normal_load="dynamic")
    system = vc.System(machine, vc.Exponential(0.05, 0.1), vc.FourierSeries(cosine_1=1.0))
    columns = {"drive.cosine_1": np.array([9.0, 0.05, 0.05]), "drive.cosine_2": np.array([0.0, 0.0, 0.02])}
    results = vc.ensemble(system, columns, measures=["symmetric"], settle=1e-6, periods=300, initial={"angle": 1.0})
    assert (results["status"] == 0).tolist() == [False, True, True]
    assert results["settled"].tolist() == [False, True, True]
    assert results["symmetric"] == pytest.approx([np.nan, 1.0, np.nan], nan_ok=True)


# --- closed forms ----------------------------------------------------------------------------------------------------


def test_closed_form_of_a_made_up_motion():
    """X = 0.3 + 0.05 t + 0.4 cos(t + 0.7), with a rest that crosses period marks and a side that changes."""
    travel, period = Signal(((0.4, 1.0, 0.7),), offset=0.3, slope=0.05), 2 * math.pi
    rest = [(5.8 * math.pi, 6.2 * math.pi)]
    motion = made_up_motion(vc.Exponential(), travel, lambda t, side: 0.0 * t, periods=6, stuck=rest)
    expected = {"drift": 0.05 * period, "largest_velocity": 0.45, "least_velocity": -0.35}
    expected |= {"stick_fraction": 0.4 * math.pi / (4 * period), "stick_phases": 1.0}
    assert vc.measured(motion, [*expected], window=4) == pytest.approx(expected, rel=1e-12, abs=1e-13)
    assert vc.measured(motion, "stick_phases", window=3) == {"stick_phases": 1.0}  # what the window cuts off counts
    assert vc.measured(motion, "stick_phases", window=2) == {"stick_phases": 0.0}


@pytest.mark.parametrize("rests", [3, 60])
def test_words_of_many_letters(rests):
    """Up to 104 letters in full; a longer word ends in dots."""
    marks = np.linspace(0.1, 6.2, 2 * rests)
    stuck = list(zip(marks[::2], marks[1::2], strict=True))
    motion = made_up_motion(vc.Exponential(), Signal(slope=1.0), lambda t, side: 0.0 * t, periods=1, stuck=stuck)
    ints = vc.mode_sequence(motion)
    assert ints == "FS" * rests
    word = vc.measured(motion, "mode_sequence", window=1)["mode_sequence"]
    assert word == (ints if rests == 3 else ints[:104] + "...")


# --- one's own -------------------------------------------------------------------------------------------------------

GRIP = vc.Measure.largest("grip", "largest holding force over its limit", lambda m: m.holding_force / 0.45)
OWN = (
    GRIP,
    vc.Measure.least("lowest", "least height of the bob", lambda m: m.angle.cos()),
    vc.Measure.mean("mean_drive_power", "mean power of the drive", lambda m: m.drive_power),
    vc.Measure.integral("path", "stiffness times angle squared", lambda m: m["machine.stiffness"] * m.angle * m.angle),
    vc.Measure.derived("share", "damper over drive", lambda a, b: -a / b, of=("damper_work", "drive_work")),
    vc.Measure.derived("twice", "of one's own", lambda share, grip: share + grip, of=("share", "grip")),
)


def test_measures_of_ones_own():
    motion = motion_of("exponential")
    values = vc.measured(motion, [*OWN, "drive_work"], window=WINDOW)
    assert list(values) == [*(measure.name for measure in OWN), "drive_work"]
    window = window_of(motion)
    t = np.linspace(*window, 20_001)
    assert values["grip"] == pytest.approx(np.max(motion.at(t, "holding_force")) / 0.45, abs=1e-6)
    assert values["grip"] >= np.max(motion.at(t, "holding_force")) / 0.45 - 1e-14
    assert values["lowest"] == pytest.approx(np.min(np.cos(motion.at(t, "angle"))), abs=1e-6)
    balance = vc.energy_balance(motion, periods=WINDOW)
    assert values["mean_drive_power"] == pytest.approx(balance.mean_power.drive, rel=1e-12)
    assert values["share"] == pytest.approx(-balance.damper / balance.drive, rel=1e-12)
    assert values["twice"] == values["share"] + values["grip"]
    height = 2.0 * motion.at(t, "angle") ** 2  # Simpson's rule on 20,000 intervals
    simpson = np.sum(height[:-2:2] + 4.0 * height[1:-1:2] + height[2::2]) * (t[1] - t[0]) / 3.0
    assert values["path"] == pytest.approx(simpson, rel=1e-9)


def test_ones_own_leaves_the_equations_alone():
    """What is recorded for a measure must not change the kernels of others."""
    recording = equations(system_with(vc.Exponential()))
    before = len(recording.graph.nodes)
    vc.measured(motion_of("exponential"), [GRIP], window=1)
    assert len(recording.graph.nodes) == before


@pytest.mark.parametrize(
    ("measures", "complaint"),
    [
        (["mean_velocty"], "no measure 'mean_velocty'; did you mean 'mean_velocity'"),
        ([vc.Measure.mean("bend", "", lambda m: m.bristle)], "bend: is not available: 'bristle' is not"),
        ([vc.Measure.mean("bend", "", lambda m: m["machine.mass"])], "'machine.mass' is not a number of this system"),
        ([vc.Measure.mean("bend", "", lambda m: m.angle if m.angle == 0 else 1)], "cannot branch"),
        ([vc.Measure.mean("drift", "", lambda m: m.angle)], "two measures of the name 'drift'"),
        ([vc.Measure.derived("a", "", abs, of=("b",))], "no measure 'b' .of which 'a' is derived"),
        ([vc.Measure.derived("a", "", abs, of=("a",))], "'a' is derived from itself"),
    ],
)
def test_measures_that_cannot_be_taken_are_refused(measures, complaint):
    with pytest.raises(ValueError, match=complaint):
        vc.measured(motion_of("exponential"), measures)


def test_names_that_measures_have_elsewhere_lead_to_them():
    assert set(SYNONYMS.values()) <= set(vc.measure_table())
    assert not set(SYNONYMS) & set(vc.measure_table())
    for name, meant in SYNONYMS.items():
        with pytest.raises(ValueError, match=f"there is no measure '{name}'; did you mean '{meant}'?"):
            resolved(name)


@pytest.mark.parametrize("kind", sorted(machines()))
def test_every_measure_that_a_system_has_can_be_asked_for(kind):
    """By name and as it stands in the table, those of further contacts and of laws of one's own included."""
    laws = [Named()] * min(2, len(machines()[kind].contact_states))
    system = vc.System(machines()[kind](), laws, vc.Harmonic())
    table = vc.measure_table(system)
    assert "largest_strain" in table
    assert ("largest_strain_2" in table) == (len(laws) == 2)
    asked, _ = resolved(list(table), system)
    assert asked == tuple(table.values()) == resolved(table.values(), system)[0]
    smooth = vc.System(machines()[kind](), vc.SmoothedTanh(), vc.Harmonic())  # of which no side is known
    needed = resolved(list(vc.measure_table(smooth)), smooth)[1]
    own_integrands(needed, equations(smooth))
    with pytest.raises(ValueError, match="no measure 'largest_strain'"):
        resolved("largest_strain")


@parameters
class Named(vc.Dahl):
    """A law whose state no law of the package has."""

    internal = ("strain",)


@pytest.mark.slow
@pytest.mark.parametrize("path", exhaustive_but(range(0, len(EXAMPLES), 8), EXAMPLES), ids=lambda path: path.stem)
def test_undefined_measures_are_those_of_which_no_motion_has_a_value(path):
    """Of a motion that settled all others have one; where not, `time_to_settle`, `period` and `symmetric` are none.

    Where nothing drives a system in time, a stored motion is not asked whether it settled.
    """
    case = read_case(path)
    motion, without = case.simulate(), undefined_measures(case.system)
    assert motion.status.ok
    travels = case.system.machine.cyclic is not None
    names = [name for name in measure_table(case.system) if travels or name not in without]
    values = vc.measured(motion, names, settle=1e-6 if equations(case.system).timed else None)
    empty = {name for name, value in values.items() if value == "" or value != value}
    not_settled = set() if values["response_period"] else {"time_to_settle", "period", "symmetric"}
    assert empty - not_settled == (without & set(values)) - not_settled


# --- the ensemble ----------------------------------------------------------------------------------------------------

SYSTEM = system_with(vc.Exponential())
ASKED = ("mean_velocity", "drive_work", "peak_friction", "largest_angle", "mode_sequence", "stick_fraction")


def small_ensemble(ratios, **settings):
    options = {"initial": START, "measures": ASKED, "periods": 6, "window": 2} | settings
    return vc.ensemble(SYSTEM, {"machine.mass_ratio": ratios}, **options)


def test_the_same_bits_however_it_is_cut(monkeypatch):
    ratios = np.linspace(0.3, 5.0, 23)
    ints = small_ensemble(ratios, threads=1)
    backwards, alone = small_ensemble(ratios[::-1], threads=2), small_ensemble(ratios[11:12])
    monkeypatch.setattr(devices, "PROCESSOR", dataclasses.replace(devices.PROCESSOR, chunk=5))
    chunks = small_ensemble(ratios)
    for name, column in ints.items():
        assert len(column) == 23
        for other in (backwards[name][::-1], chunks[name]):
            assert np.array_equal(column, other), name
        assert alone[name][0] == column[11], name


def test_the_window_fits_the_run_unless_told():
    """The last ten periods, or all where a run has fewer; a window that is asked for has to fit."""
    for periods, expected in ((2, 2), (12, 10)):
        ensemble = small_ensemble([2.5], periods=periods, window=None, measures=["drift"])
        assert ensemble["window_periods"].tolist() == [expected]
        motion = vc.simulate(SYSTEM, periods=periods, initial=START)
        assert vc.mean_velocity(motion).window == ((periods - expected) * motion.period, periods * motion.period)
        assert vc.measured(motion, "displacement") == vc.measured(motion, "displacement", window=expected)
    with pytest.raises(ValueError, match="window should be a whole number from 1 to 2, got 10"):
        small_ensemble([2.5], periods=2, window=10)


def test_failed_runs_are_shown_as_failed():
    """More events than allowed: a status, no numbers; the other runs are what they are alone."""
    asked = {"initial": {"angle": 0.05}, "measures": ASKED, "periods": 6, "window": 2, "max_events_per_period": 1}
    results = vc.ensemble(SYSTEM, {"drive.amplitude": [1.8, 0.1]}, **asked)
    statuses = [list(vc.Status)[code] for code in results["status"]]
    assert statuses == [vc.Status.TOO_MANY_EVENTS, vc.Status.FINISHED]
    assert (results["window_start"][0], results["window_periods"][0]) == (-1, 0)
    assert results["mode_sequence"].tolist() == ["", "S"]
    for name in {*ASKED} - {"mode_sequence"}:
        assert np.isnan(results[name]).tolist() == [True, False]


def test_runs_of_one_form_go_together(monkeypatch):
    """An exponent that is a whole number is part of the formula, like the word "weight"; others are parameters."""
    calls = []

    def run(start, budget, form, threads, progress):
        layout, _ = numerics.ensemble_source(start.equations, ORDER, numerics.lane_count())
        paths = start.equations.parameter_paths
        calls.append([dict(zip(paths, row, strict=True)) for row in start.parameters])
        results = np.zeros((len(start.initial), layout.result_size))
        results[:, 0], results[:, 1] = 1.0, 10.0
        return RunResults(layout, results)

    monkeypatch.setattr(devices, "PROCESSOR", dataclasses.replace(devices.PROCESSOR, run=run))
    over = {"friction.stribeck_exponent": [2.0, 1.5, 1.0, 1.7, 2.0], "machine.mass_ratio": [1.0, 2.0, 3.0, 4.0, 5.0]}
    vc.ensemble(system_with(vc.LuGre()), over)
    masses = sorted([row["machine.mass_ratio"] for row in call] for call in calls)
    assert masses == [[1.0, 5.0], [2.0, 4.0], [3.0]]
    exponents = {row["machine.mass_ratio"]: row.get("friction.stribeck_exponent") for call in calls for row in call}
    assert exponents == {1.0: None, 2.0: 1.5, 3.0: None, 4.0: 1.7, 5.0: None}
    calls.clear()
    vc.ensemble(SYSTEM, {"machine.normal_load": [2.0, "weight", 3.0]})
    loads = [[row.get("machine.normal_load") for row in call] for call in calls]
    assert sorted(loads, key=len) == [[None], [2.0, 3.0]]


def test_symmetry_is_asked_run_by_run():
    """A drive of two tones is odd only without the second."""
    system = system_with(vc.Exponential(), drive=vc.Biharmonic())
    tones = {"drive.second_amplitude": np.array([0.0, 0.1, 0.0]), "drive.second_phase": np.array([0.0, 0.3, 0.3])}
    assert BRIDGE._mirrored(system, tones).tolist() == [True, False, True]
    assert BRIDGE._mirrored(system, {"machine.damping": np.ones(2)}).tolist() == [True, True]


@pytest.mark.parametrize(
    ("over", "settings", "complaint"),
    [
        ({}, {}, "over should name at least one"),
        ({"machine.mass": [1.0]}, {}, "'machine.mass' is neither .* did you mean 'machine.mass_ratio'"),
        ({"machine.mass_ratio": 1.0}, {}, "machine.mass_ratio should be a list of values"),
        ({"machine.mass_ratio": np.ones((2, 2))}, {}, "one per run, got an array of shape"),
        ({"machine.mass_ratio": []}, {}, "machine.mass_ratio should have at least one value"),
        ({"machine.mass_ratio": [1.0, math.nan]}, {}, "should be finite numbers, got nan for run 1"),
        ({"machine.mass_ratio": [1.0, -2.0]}, {}, "machine.mass_ratio: should be greater than 0, got -2.0 for run 1"),
        ({"machine.mass_ratio": [True]}, {}, "should be numbers, got True for run 0"),
        ({"machine.mass_ratio": ["heavy"]}, {}, "machine.mass_ratio: should be a number, got 'heavy' for run 0"),
        ({"machine.normal_load": ["heavy"]}, {}, "machine.normal_load: .* for run 0"),
        ({"initial.angle": ["far"]}, {}, "initial.angle should be numbers, got 'far' for run 0"),
        ({"initial.anlge": [0.1]}, {}, "did you mean 'initial.angle'"),
        ({"initial.angle": [0.1], "machine.damping": [1.0, 2.0]}, {}, "every list should have one value per run"),
        (
            {"friction.static_coefficient": [0.5, 0.3], "friction.coulomb_coefficient": [0.4, 0.31]},
            {},
            "friction.static_coefficient: should be at least coulomb_coefficient .* for run 1",
        ),
        ({"machine.damping": [1.0]}, {"periods": 2.5}, "periods should be a whole number"),
        ({"machine.damping": [1.0]}, {"window": 61}, "window should be a whole number from 1 to 60, got 61"),
        ({"machine.damping": [1.0]}, {"settle": 0.0}, "settle should be None or a positive threshold"),
        ({"machine.damping": [1.0]}, {"threads": 0}, "threads should be a whole number from 1"),
        ({"machine.damping": [1.0]}, {"tolerance": 1.0}, "tolerance should be a number from"),
        ({"machine.damping": [1.0]}, {"measures": ["speed"]}, "there is no measure 'speed'"),
        ({"machine.damping": [1.0]}, {"initial": {"tilt": 1.0}}, "initial.tilt: no such state"),
    ],
)
def test_bad_input_is_refused_before_any_work(over, settings, complaint):
    with pytest.raises(ValueError, match=complaint):
        vc.ensemble(SYSTEM, over, **settings)


@pytest.mark.plain
def test_rate_of_the_drive_behind_an_actuator():
    """T_a u' + u = c: the rate is (c - u)/T_a."""
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic(), actuator=vc.Actuator(time_constant=0.3))
    motion = vc.simulate(system, periods=3, initial=START, tolerance=1e-12)
    times = np.linspace(2 * motion.period, 3 * motion.period, 20_001)
    rate = np.max(np.abs(motion.at(times, "command") - motion.at(times, "drive"))) / 0.3
    assert vc.measured(motion, "peak_drive_rate", window=1)["peak_drive_rate"] == pytest.approx(rate, rel=1e-6)
