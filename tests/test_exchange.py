"""Cases as C: the bits of the package's kernel with every optimisation; what would change them is refused.

What the library does as a stepper (inputs, parameters, copies, ends) is asked in `test_stepper.py`.
"""

import csv
import ctypes
import functools
import importlib.util
import math
import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import vibrocap as vc
from cases import refused
from lab_motions import KINDS, motions_of_a_kind
from thinned import exhaustive_but
from vibrocap.case.case import read_case
from vibrocap.cli.main import main
from vibrocap.exchange.c_library import c_files, export_c
from vibrocap.exchange.fmu.fmu import export_fmu
from vibrocap.motion.crossings import polynomial_values
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.motion.simulate import STATUSES, event_kinds, initial_state
from vibrocap.numerics.api import Budget, Form, MotionStart, recorded_run
from vibrocap.numerics.compiler import compiled
from vibrocap.numerics.compiler.c_text import c_source
from vibrocap.physics.events import BOUNDS

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.toml"))
GCC = shutil.which("gcc") or ""
ZIG = (sys.executable, "-m", "ziglang", "cc") if importlib.util.find_spec("ziglang") else ()
COMPILERS = {name: command for name, command in {"gcc": (GCC,), "zig": ZIG}.items() if any(command)}
LEVELS = ("-O0", "-O3")
TABLE = [(kind, *which) for kind in KINDS for which in motions_of_a_kind(kind)]  # each law on a machine of each kind
FUSED = ("-O3", "-march=native", "-ffp-contract=fast")  # which the files forbid, where the processor has them
needs_gcc = pytest.mark.skipif(not GCC, reason="no gcc is installed")


def example(name):
    return read_case(next(path for path in EXAMPLES if path.stem == name), periods=6)


def built(folder, *options, sources=("main.c", "capsule.c"), out="capsule", compiler=(GCC,)):
    paths = [folder / source for source in sources]
    strict = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]
    command = [*compiler, *strict, *options, "-o", folder / out, *paths, "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / out


def printed(program):
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    return done.returncode, list(csv.reader(done.stdout.splitlines()[1:]))


def expected(case):
    """The motion of the literal kernel: its record. It goes on for a period more, as the stepper does not end."""
    system = case.system
    initial = [*initial_state(system, case.initial).values()]
    values = equations(system), parameter_values(system), initial, system.drive.period
    return recorded_run(MotionStart(*values), Budget(**case.run | {"periods": case.periods + 1}), Form(literal=True))


def states_at(record, period, times):
    """(states, sides) of a record at instants, from the series of its steps as `Trajectory` reads them."""
    begun = record.piece_instants[:, 0] * period + record.piece_instants[:, 1]
    index = np.searchsorted(begun, times, side="right") - 1
    return polynomial_values(record.series, index, times - begun[index]).T, record.piece_sides[index]


def assert_same_bits(case, rows, code):
    """Samples, events and the end that a program printed are those of the literal kernel; in SI to rounding."""
    record, period = expected(case), case.system.drive.period
    contacts, count = record.contacts, len(case.system.state_names)
    kinds = event_kinds(case.system.placed.switch_events)
    times, ended = np.array([float(row[0]) for row in rows]), code != 0
    values = np.array([row[3 : 3 + contacts + count] for row in rows], float)
    equal = np.testing.assert_array_equal
    if case.system.units is not None:
        times /= case.system.si.factor("time")
        begun = record.piece_instants[:, 0] * period + record.piece_instants[:, 1]
        nearest = begun[np.argmin(np.abs(begun - times[:, None]), axis=1)]
        times = np.where(np.abs(nearest - times) < 1e-13 * (1.0 + times), nearest, times)  # a step begins at an event
        values[:, contacts:] /= [case.system.si.factor(name) for name in case.system.state_names]
        equal = functools.partial(np.testing.assert_allclose, rtol=1e-13, atol=1e-13)  # a time moves by its rounding
    states, sides = states_at(record, period, times[: len(rows) - ended])
    decided = {*case.system.switched, *getattr(case.system.controller, "states", ())}
    smooth = [name not in decided for name in case.system.state_names]
    equal(values[0, contacts:][smooth], states[0][smooth])  # at its start nothing is decided
    equal(values[1 : len(states), contacts:], states[1:])
    np.testing.assert_array_equal(values[1 : len(states), :contacts], sides[1:])
    happened = record.event_instants[:, 0] * period + record.event_instants[:, 1]
    wanted = sorted(
        (time, str(kinds[kind]), contact)
        for time, kind, contact in zip(happened, record.event_kinds, record.event_contacts, strict=True)
        if time <= times[-1] and kinds[kind] not in ("graze", *BOUNDS)
    )
    members = {"start", "instant", "finished", *(status.value for status in STATUSES.values())}
    ordered = sorted(
        (time, row[1], int(row[2])) for time, row in zip(times, rows, strict=True) if row[1] not in members
    )
    assert [each[1:] for each in ordered] == [each[1:] for each in wanted]
    equal([each[0] for each in ordered], [each[0] for each in wanted])
    if ended:
        assert rows[-1][1] == STATUSES[record.status].value
        equal(values[-1, contacts:], record.final)
    else:
        assert rows[-1][1] == "finished"


@needs_gcc
@pytest.mark.parametrize("options", [("-O0",), FUSED], ids=" ".join)
def test_the_program_of_a_case_prints_the_bits_of_its_motion(options, tmp_path):
    case = example("travels-by-stick-slip")
    export_c(case, tmp_path)
    code, rows = printed(built(tmp_path, *options))
    assert len(rows) > 100
    assert_same_bits(case, rows, code)


@needs_gcc
@pytest.mark.slow
def test_a_drive_with_a_long_table_has_the_same_bits(tmp_path):
    times = np.linspace(0.0, 6.0, 301)
    values = 1.8 * np.sin(np.pi / 3.0 * times[:-1])
    drive = vc.DriveTable(tuple(times), (*values, values[0]), interpolation="linear")
    case = vc.Case(vc.System(vc.PendulumCapsule(), vc.Exponential(), drive), {"angle": 0.3}, periods=2)
    export_c(case, tmp_path)
    code, rows = printed(built(tmp_path, "-O1", "-fsanitize=address,undefined"))
    assert_same_bits(case, rows, code)


@needs_gcc
@pytest.mark.slow
def test_a_sampled_loop_of_1_khz_has_the_bits_of_the_kernel_and_stops_where_the_issue_says(tmp_path):
    """How many samples there are cannot be set."""
    controller = vc.SampledPositionPID(3.0, 4.0, 6.0, sample_time=1e-3, delay=5e-4)
    system = vc.System(vc.Oscillator(stiffness=0.0), vc.Coulomb(1.0, 1.5), vc.Constant(), controller=controller)
    case = vc.Case(system, {"position": -1.0}, periods=20, tolerance=1e-13)
    export_c(case, tmp_path)
    code, rows = printed(built(tmp_path, "-O2"))
    assert_same_bits(case, rows, code)
    stops = [float(row[0]) for row in rows if row[1] == "stick"]
    assert stops[:2] == pytest.approx([3.489201046246537, 8.318700544123702], abs=1e-13)
    assert [float(value) for value in rows[-1][4:6]] == pytest.approx([0.08388297959518, -0.09435168198276], abs=1e-13)
    header = (tmp_path / "capsule.c").read_text()
    settable = [name for name in system.parameter_paths if f'"{name}"' in header]
    assert "controller.integral_gain" in settable
    assert not {"controller.sample_time", "controller.delay", "drive.duration"} & {*settable}


@needs_gcc
@pytest.mark.slow
@pytest.mark.parametrize("path", exhaustive_but(range(0, len(EXAMPLES), 18), EXAMPLES), ids=lambda path: path.stem)
def test_every_example_has_the_same_bits_with_every_optimisation(path, tmp_path):
    case = read_case(path, periods=4)
    export_c(case, tmp_path)
    for options in (("-O0",), FUSED):
        code, rows = printed(built(tmp_path, *options))
        assert_same_bits(case, rows, code)


@pytest.mark.slow
@pytest.mark.skipif(not COMPILERS, reason="neither gcc nor ziglang is installed")
@pytest.mark.parametrize(("kind", "machine", "law"), exhaustive_but((7,), TABLE), ids=str)
def test_every_law_and_machine_has_the_same_bits_with_every_compiler(kind, machine, law, tmp_path):
    """With Zig at -O0 its checks of undefined behaviour, such as a shift too far, are on: a program stops at one."""
    case = motions_of_a_kind(kind)[machine, law]
    export_c(case, tmp_path)
    table = {}
    for name, compiler in COMPILERS.items():
        for level in LEVELS:
            out = f"{name}{level}"
            table[out] = printed(built(tmp_path, level, "-march=native", out=out, compiler=compiler))
    code, rows = table["gcc-O0" if "gcc" in COMPILERS else "zig-O0"]
    assert len(rows) > 100 or code != 0
    assert_same_bits(case, rows, code)
    assert [out for out, other in table.items() if other != (code, rows)] == []


PUBLIC = "\nvoid call(double *f, int64_t *i, double *t, int64_t n) { k_advance(f, i, t, n); }\n"


@needs_gcc
def test_operators_give_the_bits_of_the_literal_kernel(tmp_path):
    """Also where a function is called like a helper of the C text."""
    text = """import math

import numpy as np

TABLE = np.array([[1.5, -2.5], [0.1, 3.0]])
SCALE = (1.0, 2.0, 4.0)


def bits(x, y):
    return x + y, (x * y, x > y)


def advance(floats, ints, trace, rounds):
    n = 0
    for a in range(9):
        for b in range(9):
            x, y, i, j = floats[a], floats[b], ints[a], ints[b]
            s, (p, above) = bits(x, y)
            trace[n] = s - p / 3.0 + (1.0 if above else -0.25)
            trace[n + 1] = np.floor(x / y) if y != 0.0 else 0.0
            trace[n + 2] = abs(x) ** (j % 70000)
            trace[n + 3] = x**3 + y**-2 if y != 0.0 else -x
            trace[n + 4] = max(x, y, 0.5) - min(abs(x), y)
            trace[n + 5] = math.sqrt(abs(x)) + math.floor(y)
            trace[n + 6] = TABLE[a % 2, b % 2] * SCALE[b % 3]
            trace[n + 7] = (i // j if j != 0 else 0) + (i % j if j != 0 else 0) * 7
            trace[n + 8] = ((i & j) ^ (i | 3)) + (i << 2) + (j >> 1) + (~i) + abs(j)
            trace[n + 9] = float(int(x))
            trace[n + 10] = np.float64(x).view(np.int64) % 1000003
            k = 0
            while True:
                k += 1
                if k > 5 or (x < y and not (k < 3)):
                    break
                if k % 2 == 0:
                    continue
                trace[n + 11] += k
            n += 12
"""
    floats = np.array([0.0, -0.0, 1.0, -1.5, 3.75, 12345.678, -7.1, 0.1, 1e-60])
    ints = np.array([0, 1, -1, 5, -7, 12, -3, 1000, 2])
    (tmp_path / "kernel.c").write_text(c_source(text, ("advance",), "k") + PUBLIC)
    values, wanted = np.zeros(12 * 81), np.zeros(12 * 81)
    compiled(text, "advance", literal=True)(floats, ints, wanted, 1)
    for options in ("-O0", "-O3"):
        values[:] = 0.0
        out = built(tmp_path, options, "-fPIC", "-shared", sources=("kernel.c",), out=f"kernel{options}.so")
        call = ctypes.CDLL(str(out)).call
        call.argtypes = [ctypes.c_void_p] * 3 + [ctypes.c_int64]
        call(floats.ctypes.data, ints.ctypes.data, values.ctypes.data, 1)
        np.testing.assert_array_equal(values.view(np.int64), wanted.view(np.int64))


@needs_gcc
@pytest.mark.parametrize("option", ["-ffast-math", "-ffinite-math-only"])
def test_sources_refuse_inexact_arithmetic(option, tmp_path):
    export_c(example("travels-by-stick-slip"), tmp_path)
    command = [GCC, option, "-fsyntax-only", tmp_path / "capsule.c"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "without -ffast-math" in done.stderr


def test_bad_input_is_named(tmp_path, capsys):
    case = str(next(path for path in EXAMPLES if path.stem == "travels-by-stick-slip"))
    with pytest.raises(ValueError, match="name should be up to 31"):
        c_files(read_case(case), "Capsule-1")
    with pytest.raises(ValueError, match="input should be 'drive' or None, got 'torque'"):
        c_files(read_case(case), input="torque")
    (tmp_path / "file").write_text("")
    for options, said in (
        (["--out", str(tmp_path / "file")], "--out: "),
        (["--out", str(tmp_path / "new"), "--name", "a b"], "--name: should be"),
        (["--to", "simulink", "--out", str(tmp_path / "new")], "simulink"),
        (["--input", "torque", "--out", str(tmp_path / "new")], "torque"),
    ):
        assert said in refused(capsys, "export", case, *options)
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
@needs_gcc
@pytest.mark.parametrize("input", [None, "drive"])
def test_a_library_holds_no_memory_and_its_names_begin_with_its_own(input, tmp_path):
    """By its symbols: what it needs of others, what it offers, and no variable of any kind, only constants."""
    nm = shutil.which("nm")
    if not nm:
        pytest.skip("no nm is installed")
    export_c(example("bristles-lugre"), tmp_path, name="plant", input=input)
    command = [GCC, "-std=c99", "-O0", "-fno-pie", "-c", "-o", tmp_path / "plant.o", tmp_path / "plant.c"]
    subprocess.run(command, check=True)
    done = subprocess.run([nm, tmp_path / "plant.o"], capture_output=True, text=True, check=True)
    kinds = {row[-1]: row[-2] for row in map(str.split, done.stdout.splitlines())}
    needed = {name for name, kind in kinds.items() if kind == "U"}
    assert needed <= {"floor", "sqrt", "fabs", "memset", "memcpy", "memcmp"}
    offered = [name for name, kind in kinds.items() if kind == "T"]
    assert len(offered) > 20
    assert [name for name in offered if not name.startswith("plant_")] == []
    assert [(name, kind) for name, kind in kinds.items() if kind in "BbDdCGgSs"] == []


def test_an_export_that_was_stopped_can_be_repeated(tmp_path, monkeypatch):
    """After none, one or all but one of its files: what it leaves is seen to be its own."""
    case = str(next(path for path in EXAMPLES if path.stem == "travels-by-stick-slip"))
    whole, replace = tmp_path / "whole", os.replace
    assert main(["export", case, "--to", "c", "--out", str(whole)]) == 0
    names = sorted(path.name for path in whole.iterdir())
    for written in (0, 1, len(names) - 1):
        folder, count = tmp_path / str(written), iter(range(written))

        def stopped(*given, count=count):
            if next(count, None) is None:
                raise KeyboardInterrupt
            replace(*given)

        monkeypatch.setattr("os.replace", stopped)
        assert main(["export", case, "--to", "c", "--out", str(folder)]) == 130
        monkeypatch.setattr("os.replace", replace)
        assert len(list(folder.iterdir())) == written
        assert main(["export", case, "--to", "c", "--out", str(folder)]) == 0
        assert {path.name: path.read_bytes() for path in folder.iterdir()} == {
            name: (whole / name).read_bytes() for name in names
        }


def test_a_scale_that_follows_from_others_is_no_constant_of_an_fmu(tmp_path):
    """The unit of time of a machine with a gravity in its scales."""
    assert main(["new", "vibro-impact-capsule", "--si", "--out", str(tmp_path / "case.toml")]) == 0
    case = read_case(tmp_path / "case.toml")
    assert case.system.units.time_unit_s is None
    export_fmu(case, tmp_path / "capsule.fmu", platforms=("none",))
    with zipfile.ZipFile(tmp_path / "capsule.fmu") as file:
        root = ElementTree.fromstring(file.read("modelDescription.xml"))
    constants = {each.get("name") for each in root.find("ModelVariables") if each.get("variability") == "constant"}
    assert "machine.length_unit" in constants
    assert "machine.time_unit" not in constants


def test_every_quantity_in_si_has_the_factor_of_its_unit(tmp_path):
    """By the units that an FMU describes: kg^a m^b s^c, from the scales of the case alone. Needs no importer."""
    case = read_case(next(path for path in EXAMPLES if path.stem == "bench-in-si"))
    export_fmu(case, tmp_path / "bench.fmu", platforms=("none",))
    with zipfile.ZipFile(tmp_path / "bench.fmu") as file:
        root = ElementTree.fromstring(file.read("modelDescription.xml"))
        library = next(
            file.read(each).decode() for each in file.namelist() if each.endswith(".c") and "fmi" not in each
        )
    rows = re.findall(r'\{"([^"]+)", "([^"]+)", (0x\S+), ', library)
    factors = {(name, unit): float.fromhex(value) for name, unit, value in rows}
    bases = {letter.get("name"): dict(letter.find("BaseUnit").attrib) for letter in root.iter("Unit")}
    one = dict(zip(("kg", "m", "s"), case.system.units.units, strict=True)) | {"rad": 1.0}
    for (name, unit), factor in factors.items():
        size = math.prod(one[base] ** int(power) for base, power in bases.get(unit, {}).items())
        size /= 2.0 * math.pi if unit == "Hz" else 1.0  # cycles, where the equations count in radians
        assert factor == pytest.approx(size, rel=1e-14), name
    moving = [each for each in root.find("ModelVariables") if each.get("variability") != "constant"]  # not the scales
    assert {each.get("unit") for each in moving} - {None} == {unit for _, unit in factors} - {"1"}
    assert 0.1 < one["s"] < 0.2
    assert factors["position", "m"] != 1.0
