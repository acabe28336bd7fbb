"""FMUs in FMPy: valid descriptions, bits of the literal kernel, inputs, states, events, bad input."""

import concurrent.futures
import dataclasses
import functools
import shutil
import subprocess
import tempfile
import zipfile
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import vibrocap as vc
from test_exchange import expected, states_at
from thinned import exhaustive_but, slow_but
from vibrocap.case.case import Case, read_case
from vibrocap.cli.main import main
from vibrocap.exchange.fmu import fmu as fmus
from vibrocap.exchange.fmu.fmu import export_fmu
from vibrocap.files import WriteError

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed (extra `exchange`)")
from fmpy.fmi2 import FMU2Slave  # noqa: E402
from fmpy.fmi3 import FMU3Slave  # noqa: E402
from fmpy.validation import validate_fmu  # noqa: E402

EXAMPLES = {path.stem: path for path in sorted((Path(__file__).parents[1] / "examples").glob("*.toml"))}
README = read_case(EXAMPLES["travels-by-stick-slip"])
STATES = ("angle", "angle_rate", "position", "velocity")
# units, bristles, several contacts, stops, corners, a load that follows the motion
VALIDATED = [
    *("bench-in-si", "bristles-lugre", "worm-of-three-bodies", "strikes-two-walls"),
    *("square-wave-travels", "weight-as-load"),
]
NAMES = sorted(EXAMPLES)
RUN = [NAMES.index(name) for name in ("bench-in-si", "bristles-lugre", "square-wave-travels", "strikes-two-walls")]
VERSIONS = ["3.0", "2.0"]
compiled = [pytest.mark.slow, pytest.mark.skipif(not fmus.compiler(), reason="no C compiler is installed")]


def square_wave():
    """The capsule of the README under a square wave, of which a held input can be exactly the same."""
    system = dataclasses.replace(README.system, drive=vc.Square(1.8, 2.0 * np.pi / 6.0))
    return Case(system, README.initial, periods=20, tolerance=1e-10)


def light_capsule():
    """It lifts off in its second period."""
    machine = vc.PendulumCapsule(mass_ratio=0.5, stiffness=2.0, damping=1.0, normal_load="dynamic")
    law = vc.Exponential(coulomb_coefficient=0.15, static_coefficient=0.45)
    return Case(vc.System(machine, law, vc.Harmonic(1.8, 1.0)), {"angle": np.pi / 3}, periods=40)


@functools.cache
def folder():
    return tempfile.mkdtemp()


@functools.cache
def fmu(name, **options):
    """The FMU of a case of this module, made once."""
    case = {"readme": README, "square": square_wave(), "light": light_capsule()}.get(name) or read_case(EXAMPLES[name])
    path = Path(folder()) / f"{name}-{'-'.join(map(str, options.values()))}.fmu"
    export_fmu(case, path, **options)
    return str(path)


@functools.cache
def unpacked(path):
    return fmpy.extract(path)


class Slave:
    """An instance for co-simulation, by names of variables."""

    def __init__(self, path, event_mode=False):
        self.description = fmpy.read_model_description(path)
        self.references = {each.name: each.valueReference for each in self.description.modelVariables}
        self.newer = self.description.fmiVersion != "2.0"
        settings = {"guid": self.description.guid, "unzipDirectory": unpacked(path), "modelIdentifier": "capsule"}
        self.fmu = (FMU3Slave if self.newer else FMU2Slave)(instanceName="one", **settings)
        self.said = []
        if self.newer:
            self.fmu.instantiate(
                eventModeUsed=event_mode,
                earlyReturnAllowed=event_mode,
                logMessage=lambda _, status, category, message: self.said.append(message.decode()),
            )
        else:
            self.fmu.instantiate()

    def set(self, **values):
        names = [name.replace("__", ".") for name in values]
        call = self.fmu.setFloat64 if self.newer else self.fmu.setReal
        call([self.references[name] for name in names], list(values.values()))
        return self

    def begin(self, **values):
        if self.newer:
            self.fmu.enterInitializationMode()
        else:
            self.fmu.setupExperiment()
            self.fmu.enterInitializationMode()
        self.set(**values)
        self.fmu.exitInitializationMode()
        return self

    def get(self, *names):
        call = self.fmu.getFloat64 if self.newer else self.fmu.getReal
        return call([self.references[name] for name in names])

    def whole(self, *names):
        call = self.fmu.getInt64 if self.newer else self.fmu.getInteger
        return call([self.references[name] for name in names])

    def run(self, count, length, first=0):
        """States after each of so many steps."""
        results = []
        for i in range(first, first + count):
            self.fmu.doStep(i * length, length)
            results.append(self.get(*STATES))
        return np.array(results)


def at(motion, time, name):
    return float(np.ravel(motion.at([time], name))[0])


def literal(case, times):
    """States of the literal kernel at instants."""
    return states_at(expected(case), case.system.drive.period, times)[0]


# --- descriptions -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", slow_but([0], VALIDATED))
def test_the_validator_of_fmpy_is_silent(name):
    for fmi, given in zip(VERSIONS, (None, "drive"), strict=True):
        assert validate_fmu(fmu(name, fmi=fmi, input=given, platforms=("none",))) == []


def test_variables_carry_units_starts_and_meanings():
    case = read_case(EXAMPLES["bench-in-si"])
    description = fmpy.read_model_description(fmu("bench-in-si", platforms=("none",)))
    variables = {each.name: each for each in description.modelVariables}
    assert variables["time"].unit == "s"
    assert (variables["position"].unit, variables["friction"].unit, variables["energy"].unit) == ("m", "N", "J")
    mass = variables["machine.capsule_mass"]
    assert (mass.unit, float(mass.start), mass.causality) == ("kg", 0.5, "parameter")
    assert mass.description
    assert float(variables["angle"].start) == case.initial["angle"]
    scales = [variables[f"machine.{name}"] for name in ("pendulum_mass", "pendulum_length", "gravity")]
    assert [(scale.unit, float(scale.start)) for scale in scales] == [("kg", 0.2), ("m", 0.25), ("m/s^2", 9.80665)]
    assert {(scale.causality, scale.variability) for scale in scales} == {("local", "constant")}
    torque = next(unit for unit in description.unitDefinitions if unit.name == "N m")
    assert (torque.baseUnit.kg, torque.baseUnit.m, torque.baseUnit.s) == (1, 2, -2)
    assert float(description.defaultExperiment.stopTime) == pytest.approx(40.0, rel=1e-15)


@pytest.mark.parametrize("fmi", VERSIONS)
def test_sides_counts_and_status_are_declared(fmi):
    description = fmpy.read_model_description(fmu("readme", fmi=fmi, platforms=("none",)))
    variables = {each.name: each for each in description.modelVariables}
    side = variables["side"]
    assert (side.type, side.declaredType.name, side.variability) == ("Enumeration", "Side", "discrete")
    items = {each.name: int(each.value) for each in side.declaredType.items}
    assert items == {"slides back": -1, "rests": 0, "slides forward": 1}
    for name in ("stick", "slip_forward", "slip_back", "reversal"):
        assert variables[f"events.{name}"].type in ("Int64", "Integer")
        assert variables[f"events.{name}"].causality == "output"
    assert variables["status"].type == "String"
    assert {"friction", "reaction", "energy"} <= variables.keys()
    assert description.modelExchange is None
    about = description.coSimulation
    assert about.canGetAndSetFMUstate
    assert about.canSerializeFMUstate
    assert about.canHandleVariableCommunicationStepSize
    assert fmi == "2.0" or (about.hasEventMode and about.mightReturnEarlyFromDoStep)


def test_an_fmu_is_the_same_bytes_again(tmp_path):
    for i in range(2):
        export_fmu(README, tmp_path / f"{i}.fmu", input="drive", platforms=("none",))
    assert (tmp_path / "0.fmu").read_bytes() == (tmp_path / "1.fmu").read_bytes()
    export_fmu(dataclasses.replace(README, tolerance=1e-9), tmp_path / "2.fmu", platforms=("none",))
    tokens = {fmpy.read_model_description(str(tmp_path / f"{i}.fmu")).guid for i in range(3)}
    assert len(tokens) == 2


def test_without_a_compiler_there_are_sources_only_and_it_is_said(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fmus, "compiler", lambda: None)
    monkeypatch.setattr(fmus, "lacking", lambda *packages: "needs ziglang")
    out = tmp_path / "capsule.fmu"
    assert main(["export", str(EXAMPLES["travels-by-stick-slip"]), "--to", "fmu", "--out", str(out)]) == 0
    assert "No C compiler was found" in capsys.readouterr().out
    names = zipfile.ZipFile(out).namelist()
    assert "sources/capsule.c" in names
    assert "sources/buildDescription.xml" in names
    assert not any(name.startswith("binaries") for name in names)


# --- co-simulation ----------------------------------------------------------------------------------------------------


class TestCompiled:
    """With machine code."""

    pytestmark = compiled

    @pytest.mark.parametrize("fmi", ["3.0", "2.0"])
    def test_the_own_drive_gives_the_bits_of_the_literal_kernel(self, fmi):
        length = README.periods * README.system.drive.period / 2500
        slave = Slave(fmu("readme", fmi=fmi)).begin()
        results, times = [], []
        for i in range(2500):
            slave.fmu.doStep(i * length, length)
            *states, time = slave.get(*STATES, "time")
            results.append(states)
            times.append(time)
        np.testing.assert_array_equal(results, literal(README, np.array(times)))
        np.testing.assert_allclose(times, length * np.arange(1, 2501), rtol=4e-16)
        motion, inside = README.simulate(), np.minimum(times, README.simulate().end)
        exact = np.column_stack([motion.at(inside, name) for name in STATES])
        off = np.max(np.abs(exact - results), axis=0)  # `simulate` fuses
        resolved = np.spacing(motion.end) * np.max(
            np.abs(exact[:, 1])
        )  # by which the angle turns in a last bit of time
        assert np.all(off[2:] < 2.5e-14)  # position, velocity
        assert np.all(off[:2] < 2.5e-14 + resolved)  # measured: 4.7e-14, 2.9e-14
        kinds = Counter(event.kind for event in motion.events)
        assert slave.whole(*(f"events.{kind}" for kind in kinds)) == list(kinds.values())

    @pytest.mark.parametrize("fmi", ["3.0", "2.0"])
    @pytest.mark.parametrize(("length", "bound"), [(3.0, 1e-13), (0.3, 5e-10), (0.01, 5e-10)])
    def test_a_held_input_is_the_square_wave(self, fmi, length, bound):
        case, count = square_wave(), round(120.0 / length)
        motion, per = case.simulate(), round(6.0 / length)
        time = length * np.arange(count + 1)
        value = np.where(np.arange(count + 1) % per < per // 2, 1.8, -1.8)
        signal = np.array(list(zip(time, value, strict=True)), dtype=[("time", float), ("drive", float)])
        path = fmu("square", fmi=fmi, input="drive")
        kinds = ("stick", "slip_forward", "slip_back", "reversal")
        settings = {"stop_time": 120.0, "output_interval": length, "input": signal}
        settings["output"] = [*STATES, *(f"events.{kind}" for kind in kinds)]
        for event_mode in (False, True)[: 1 + (fmi == "3.0")]:
            found = fmpy.simulate_fmu(path, use_event_mode=event_mode, early_return_allowed=event_mode, **settings)
            assert max(abs(found[name][-1] - motion.state[name]) for name in STATES) < bound
            counts = [int(found[f"events.{kind}"][-1]) for kind in kinds]
            assert (counts[0], counts[1] + counts[2], counts[3]) == (38, 38, 78)
            if event_mode:  # it returned at every event
                at_events = {event.time for event in motion.events if event.kind != "graze"}
                np.testing.assert_array_less([np.min(np.abs(found["time"] - event)) for event in at_events], 1e-9)

    @pytest.mark.parametrize("fmi", ["3.0", "2.0"])
    def test_an_input_has_slope_and_curvature(self, fmi):
        """Of a machine whose inner motion the drive imposes, which feels nothing else: the bits of the stepper."""
        case = read_case(EXAMPLES["worm-of-two-bodies"])
        motion = vc.stepper(case, input="drive")
        slave = Slave(fmu("worm-of-two-bodies", fmi=fmi, input="drive")).begin()
        for k in range(60):
            slope, curvature = 0.8 * np.cos(0.4 * k), -0.3 * np.sin(0.4 * k)
            slave.set(drive=0.1, drive_slope=slope, drive_curvature=curvature)
            slave.fmu.doStep(0.25 * k, 0.25)
            motion.step(0.1, 0.25, slope, curvature)
            assert slave.get(*case.system.state_names) == motion.states.tolist()
            assert slave.whole("side", "side_2") == list(motion.sides)
        assert abs(motion["position"]) > 0.01
        assert slave.whole("events.stick", "events.stick_2") == [motion.events["stick"], motion.events["stick_2"]]

    @pytest.mark.parametrize("fmi", ["3.0", "2.0"])
    def test_restored_serialised_second_and_in_threads_it_has_the_same_bits(self, fmi):
        path, length = fmu("readme", fmi=fmi), 0.31
        slave = Slave(path).begin()
        slave.run(100, length)
        get, put = ("FMUState", "FMUState") if slave.newer else ("FMUstate", "FMUstate")
        state = getattr(slave.fmu, f"get{get}")()
        size_of = getattr(slave.fmu, f"serialize{get}" if slave.newer else "serializeFMUstate")
        content = size_of(state)
        ahead = slave.run(300, length, 100)
        getattr(slave.fmu, f"set{put}")(state)
        np.testing.assert_array_equal(slave.run(300, length, 100), ahead)
        other = Slave(path).begin()
        loaded = (other.fmu.deserializeFMUState if other.newer else other.fmu.deSerializeFMUstate)(content)
        getattr(other.fmu, f"set{put}")(loaded)
        np.testing.assert_array_equal(other.run(300, length, 100), ahead)
        slave.fmu.reset()
        np.testing.assert_array_equal(slave.begin().run(400, length)[100:], ahead)
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            runs = list(pool.map(lambda _: Slave(path).begin().run(400, length), range(4)))
        for run in runs:
            np.testing.assert_array_equal(run[100:], ahead)

    def test_parameters_and_starts_are_those_of_another_case(self):
        slave = Slave(fmu("bench-in-si", fmi="3.0")).begin(machine__capsule_mass=0.6, angle=0.4, drive__frequency=1.1)
        case = read_case(EXAMPLES["bench-in-si"], {"machine.capsule_mass_kg": 0.6, "drive.frequency_Hz": 1.1})
        motion = vc.simulate(case.system, initial={"angle": 0.4}, periods=10, tolerance=case.tolerance)
        slave.fmu.doStep(0.0, 9.0)
        assert slave.get("machine.pendulum_mass", "machine.pendulum_length", "machine.gravity") == [0.2, 0.25, 9.80665]
        for name in (*STATES, "energy", "friction", "reaction"):
            assert slave.get(name)[0] == pytest.approx(at(motion, 9.0, name), rel=1e-11, abs=1e-11)

    @pytest.mark.parametrize("fmi", ["3.0", "2.0"])
    def test_the_importer_asks_for_a_tolerance(self, fmi):
        """The bits of a stepper with that tolerance and the order of the case."""
        settings = {"stop_time": 60.0, "output_interval": 60.0, "output": STATES}
        off = {}
        for tolerance in (1e-6, README.tolerance, None):
            found = fmpy.simulate_fmu(fmu("readme", fmi=fmi), relative_tolerance=tolerance, **settings)
            off[tolerance] = abs(found["position"][-1] - at(README.simulate(), 60.0, "position"))
        assert off[None] == off[README.tolerance] < 1e-9 < off[1e-6] < 1e-4
        for refused in (1e-15, 0.1):
            with pytest.raises(Exception, match=r"nitializ|etupExperiment"):
                fmpy.simulate_fmu(fmu("readme", fmi=fmi), relative_tolerance=refused, **settings)

    @pytest.mark.parametrize("name", exhaustive_but(RUN, NAMES))
    def test_every_example_moves_as_its_motion(self, name, tmp_path):
        case = read_case(EXAMPLES[name], periods=5)
        export_fmu(case, tmp_path / "own.fmu")
        slave, motion = Slave(str(tmp_path / "own.fmu")).begin(), case.simulate()
        end = 0.999 * motion.end
        slave.fmu.doStep(0.0, end)
        names = case.system.state_names
        found = slave.get(*names)
        exact = [at(motion, end, key) for key in names]
        np.testing.assert_allclose(found, exact, rtol=1e-9, atol=1e-9)

    # --- what is refused ----------------------------------------------------------------------------------------------

    def test_bad_values_are_refused_by_name(self):
        slave = Slave(fmu("square", fmi="3.0", input="drive"))
        for values, said in (
            ({"machine__mass_ratio": -1.0}, "machine.mass_ratio should be greater than 0, got -1"),
            ({"machine__stiffness": np.nan}, "machine.stiffness should be a finite number, got nan"),
            ({"drive": np.inf}, "drive should be a finite number, got inf"),
            ({"friction": 1.0}, "friction is no input, parameter or start value and cannot be set"),
        ):
            with pytest.raises(Exception, match="SetFloat64"):
                slave.set(**values)
            assert said in slave.said[-1]
        with pytest.raises(Exception, match="SetFloat64"):
            slave.fmu.setFloat64([999], [1.0])
        assert "value reference 999" in slave.said[-1]
        slave.begin(drive=1.8)
        with pytest.raises(Exception, match="SetFloat64"):
            slave.set(machine__stiffness=2.0)
        assert "machine.stiffness can be set before the end of initialization only" in slave.said[-1]
        for length in (0.0, -1.0, np.nan, np.inf):
            with pytest.raises(Exception, match="DoStep"):
                slave.fmu.doStep(0.0, length)
            assert "communicationStepSize should be a finite number greater than 0" in slave.said[-1]
        with pytest.raises(Exception, match="DoStep"):
            slave.fmu.doStep(5.0, 1.0)
        assert "currentCommunicationPoint should be 0, where the motion stands, got 5" in slave.said[-1]
        before = slave.get(*STATES)
        slave.fmu.doStep(0.0, 1.0)
        assert slave.get(*STATES) != before
        now = slave.get(*STATES)
        slave.fmu.doStep(1.0, 1e-20)  # lost in the rounding of the time
        assert slave.get(*STATES) == now

    def test_lift_off_within_a_step_says_when(self):
        motion = light_capsule().simulate()
        slave = Slave(fmu("light", fmi="3.0")).begin()
        slave.fmu.doStep(0.0, 1.0)
        with pytest.raises(Exception, match="DoStep"):
            slave.fmu.doStep(1.0, 20.0)
        assert f"the motion cannot continue at {motion.end:.9g}: lift off" in slave.said[-1]
        assert slave.get("time")[0] == pytest.approx(motion.end, abs=1e-12)
        assert slave.fmu.getString([slave.references["status"]]) == ["lift off"]
        older = Slave(fmu("light", fmi="2.0")).begin()
        with pytest.raises(Exception, match="DoStep"):
            older.fmu.doStep(0.0, 20.0)
        assert older.fmu.getBooleanStatus(3)  # fmi2Terminated
        assert older.fmu.getRealStatus(2) == pytest.approx(motion.end, abs=1e-12)  # fmi2LastSuccessfulTime

    def test_the_sources_compile_without_a_warning(self, tmp_path):
        gcc = shutil.which("gcc")
        if gcc is None:
            pytest.skip("no gcc is installed")
        for fmi in VERSIONS:
            folder = Path(unpacked(fmu("readme", fmi=fmi, platforms=("none",)))) / "sources"
            strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]
            done = subprocess.run([gcc, *strict, *folder.glob("*.c")], capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr

    @pytest.mark.exhaustive
    def test_zig_gives_the_same_bits_and_other_platforms(self, tmp_path, monkeypatch):
        pytest.importorskip("ziglang", reason="zig is not installed (extra `exchange`)")
        own = Slave(fmu("readme", fmi="3.0")).begin().run(200, 0.5)
        monkeypatch.setattr(fmus, "compiler", lambda: None)
        export_fmu(README, tmp_path / "zig.fmu", platforms=("all",))
        np.testing.assert_array_equal(Slave(str(tmp_path / "zig.fmu")).begin().run(200, 0.5), own)
        file = zipfile.ZipFile(tmp_path / "zig.fmu")
        magic = {name.split("/")[1]: file.read(name)[:4] for name in file.namelist() if name.startswith("binaries")}
        assert {name: head[:2] for name, head in magic.items() if "windows" in name} == {"x86_64-windows": b"MZ"}
        assert all(head == b"\x7fELF" for name, head in magic.items() if "linux" in name)
        assert all(head == b"\xcf\xfa\xed\xfe" for name, head in magic.items() if "darwin" in name)
        assert set(magic) == set(fmus.PLATFORMS)


def test_what_cannot_be_exported_is_named(tmp_path, capsys):
    case = str(EXAMPLES["bristles-lugre"])
    out = ["--out", str(tmp_path / "a.fmu")]
    for options, said in (
        (["--to", "fmu", "--name", "A b", *out], "--name: should be"),
        (["--to", "fmu", "--platforms", "vax", *out], "--platforms: should be"),
        (["--to", "fmu", "--platforms", "aarch64-linux", "--fmi", "2.0", *out], "--platforms: should be"),
        (["--to", "fmu", "--out", str(tmp_path / "a.zip")], "--out: should end in .fmu"),
        (["--to", "fmu", "--out", str(tmp_path / "new" / "a.fmu")], "--out: there is no folder"),
        (["--fmi", "2.0", "--out", str(tmp_path / "new")], "--fmi: should be left out without --to fmu"),
    ):
        assert main(["export", case, *options]) == 2
        assert said in capsys.readouterr().err
    with pytest.raises(ValueError, match="fmi should be one of"):
        export_fmu(README, tmp_path / "a.fmu", fmi="1.0")
    with pytest.raises(ValueError, match="input should be 'drive' or None"):
        export_fmu(README, tmp_path / "a.fmu", input="torque")
    with pytest.raises(WriteError, match="there is no folder"):
        export_fmu(README, tmp_path / "new" / "a.fmu", platforms=("none",))
    assert list(tmp_path.iterdir()) == []


def test_a_compiler_that_fails_is_quoted(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(fmus, "OPTIONS", ("-no-such-option",))
    monkeypatch.setattr(fmus, "compiler", lambda: shutil.which("gcc") or pytest.skip("no gcc is installed"))
    out = tmp_path / "a.fmu"
    assert main(["export", str(EXAMPLES["travels-by-stick-slip"]), "--to", "fmu", "--out", str(out)]) == 3
    assert "-no-such-option" in capsys.readouterr().err
    assert not out.exists()
