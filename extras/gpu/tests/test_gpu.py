"""Ensembles on a GPU, without one: its threads compiled for this processor, and its code for the assembler.

The launch itself is tested where a GPU is found. Elsewhere a stand-in for the GPU runs the very same thread, built
for the processor, on the same memory and with the same launches.
"""

import ctypes
import importlib.metadata
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
from vibrocap_gpu import driver
from vibrocap_gpu import ensemble as on_gpu
from vibrocap_gpu.ptx import ARGUMENTS, LIBRARY, THREAD, thread_code

import vibrocap as vc
from vibrocap.arguments import ArgumentError
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.compiler import Compiled, host, object_code
from vibrocap.numerics.compiler.subset import with_own_functions
from vibrocap.numerics.kernel.codes import DONE, TOO_MANY_STEPS
from vibrocap.numerics.kernel.memory_layout import RESULT_HEAD
from vibrocap.numerics.linker import plain_kernel
from vibrocap.numerics.run.budget import Budget, EnsembleStart, Form
from vibrocap.numerics.run.ensemble import ensemble_run

LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre(), "stiff": vc.LuGre(bristle_stiffness=1e4)}
EVERYTHING = 63  # all groups of measures
CASES = {  # law, runs, budget
    "exponential": ("exponential", 7, Budget(2, 1e-6, 1000, 75, window=1, asked=EVERYTHING)),
    "lugre": ("lugre", 3, Budget(1, 1e-6, 1000, 10**6, asked=EVERYTHING)),
    "settling": ("exponential", 3, Budget(14, 1e-4, 1000, 10**6, window=2, threshold=0.1, asked=EVERYTHING)),
    "stiff": ("stiff", 2, Budget(1, 1e-4, 1000, 10**6, asked=EVERYTHING)),
}


def rest(*names: str) -> list:
    """Rows of a table that are left to the exhaustive tests."""
    return [pytest.param(name, marks=pytest.mark.exhaustive) for name in names]


def ensemble_of(law: str, runs: int):
    """(equations, parameters, initial) of runs that differ in mass ratio and start."""
    system = vc.System(vc.PendulumCapsule(), LAWS[law], vc.Harmonic())
    recorded = equations(system)
    parameters = np.tile(parameter_values(system), (runs, 1))
    parameters[:, recorded.parameter_paths.index("machine.mass_ratio")] = np.linspace(0.5, 6.0, runs)
    initial = np.zeros((runs, len(recorded.rates)))
    initial[:, 0] = np.linspace(0.4, 1.2, runs)
    return recorded, parameters, initial


# --- a stand-in for a GPU -------------------------------------------------------------------------------------------


class StandIn(driver.Gpu):
    """A GPU that is this processor: its threads run one after another, each launch as the driver would start it."""

    def __init__(self, thread, reals, wholes):
        self.thread = thread
        self.own = np.zeros(reals), np.zeros(wholes, dtype=np.int64)
        self.made = {}
        self.launches = 0

    def serve(self):
        assert not self.made

    def attribute(self, name):
        assert name == "MULTIPROCESSOR_COUNT"
        return 1

    def ask(self, name, *arguments):
        if name == "cuMemAlloc":
            room = np.full(-(-arguments[0] // 8), np.nan)
            self.made[room.ctypes.data] = room
            return room.ctypes.data
        if name == "cuMemFree":
            return self.made.pop(arguments[0])
        if name in ("cuMemcpyHtoD", "cuMemcpyDtoH"):
            return ctypes.memmove(*arguments)
        if name == "cuMemGetInfo":
            return 10**9, 2 * 10**9
        if name == "cuModuleLoadData":
            return arguments[0]
        if name == "cuModuleGetFunction":
            module, function = arguments
            assert b".visible .entry " + function in module
            return function
        if name == "cuModuleUnload":
            return None
        assert name == "cuLaunchKernel"
        _, blocks, _, _, threads, *_, (values, kinds), _ = arguments
        assert len(values) == len(kinds) == 8
        self.launches += 1
        *addresses, fresh, rounds = values
        for thread in range(blocks * threads):
            self.thread(self.own, addresses, thread, blocks * threads, fresh, rounds)
        return None


def built(law, order=10, exact=False):
    """(layout, one thread as machine code of this processor)."""
    layout, text = on_gpu.thread_text(ensemble_of(law, 1)[0], order)
    code = thread_code(text)
    thread = Compiled(object_code(code.replace(" contract", "") if exact else code, host()), ARGUMENTS)

    def run(own, addresses, *numbers):
        thread._call(own[0].ctypes.data, own[1].ctypes.data, *addresses, *numbers)

    return layout, run


def plain(law, order=10):
    """(layout, one thread as plain Python)."""
    layout, text = on_gpu.thread_text(ensemble_of(law, 1)[0], order)
    text = with_own_functions(text)
    for name, function in LIBRARY.items():
        text = text.replace(f"math.{name}(", f"{function}(")
    thread = plain_kernel(text)[THREAD]

    def run(own, addresses, *numbers):
        kinds = [ctypes.c_double, ctypes.c_int64] * 3
        sizes = [10**5, 3, len(own[0]), len(own[1]), 10**5, 10**4]
        pairs = zip(addresses, kinds, sizes, strict=True)
        views = [np.ctypeslib.as_array((kind * size).from_address(address)) for address, kind, size in pairs]
        with np.errstate(all="ignore"):
            thread(*own, *views, *numbers)

    return layout, run


def through_the_gpu(case, layout, thread, rounds=10_000, chunk=4):
    """(results, progress, launches): blocks of two threads, launches of so many steps, so many runs at a time."""
    law, runs, budget = CASES[case]
    begun: list[int] = []
    gpu = StandIn(thread, layout.real_size, layout.whole_size)
    with mock.patch.multiple(
        on_gpu,
        first_gpu=lambda: gpu,
        gpu_threads=lambda _: 3,  # rounded up to whole blocks
        runs_at_a_time=lambda *_: chunk,
        next_rounds=lambda before, seconds: rounds,
        WARP=2,
        RESIDENT=2,
        FIRST_ROUNDS=rounds,
    ):
        found = on_gpu.gpu_ensemble_run(
            EnsembleStart(*ensemble_of(law, runs)), budget, Form(order=10), progress=begun.append
        )
    assert found.layout == layout
    assert not gpu.made  # all memory was given back
    return found.numbers, begun, gpu.launches


@pytest.mark.slow
@pytest.mark.parametrize("case", ["exponential", "settling", *rest("lugre", "stiff")])
def test_the_threads_of_a_gpu_do_what_the_cpu_does(case):
    """The same steps, modes and statuses; numbers to the rounding of two sets of elementary functions."""
    law, runs, budget = CASES[case]
    expected = ensemble_run(EnsembleStart(*ensemble_of(law, runs)), budget, Form(order=10, lanes=1), threads=1).numbers
    results, begun, _ = through_the_gpu(case, *built(law))
    assert np.array_equal(results[:, 0], expected[:, 0])
    assert np.array_equal(results[:, 7:9], expected[:, 7:9])
    size = 1.0 + np.abs(expected[:, len(RESULT_HEAD) :])
    assert np.max(np.abs(results - expected)[:, len(RESULT_HEAD) :] / size) <= 1e-9
    assert begun[-1] == runs
    statuses = set(expected[:, 0])
    assert statuses == ({DONE, TOO_MANY_STEPS} if case == "exponential" else {DONE})  # a failed run fails there too
    if case == "stiff":
        assert np.all(expected[:, 8] > 0)  # implicit steps
    if case == "settling":
        assert np.count_nonzero(expected[:, 3]) > 0  # response periods


@pytest.mark.slow
def test_short_launches_and_small_chunks_change_nothing():
    """All that a thread carries outlives a launch, wherever in a run that ends."""
    layout, thread = built("exponential")
    long, long_begun, few = through_the_gpu("exponential", layout, thread)
    short, short_begun, many = through_the_gpu("exponential", layout, thread, rounds=7)
    assert np.array_equal(short, long)
    assert many > 5 * few
    assert short_begun[-1] == long_begun[-1] == 7  # all runs begun
    assert np.all(np.diff(short_begun) >= 0)
    ints, _, one = through_the_gpu("exponential", layout, thread, chunk=100)
    assert np.array_equal(ints, long)
    assert one < few


@pytest.mark.slow
def test_a_thread_without_fused_operations_is_that_of_plain_python():
    """What is compiled for GPUs is the text, to the last bit."""
    exact, _, _ = through_the_gpu("exponential", *built("exponential", exact=True))
    python, _, _ = through_the_gpu("exponential", *plain("exponential"))
    assert np.array_equal(exact, python)


def test_launches_take_a_quarter_of_a_second():
    assert on_gpu.next_rounds(1000, on_gpu.LAUNCH) == 1000
    assert on_gpu.next_rounds(1000, 10.0 * on_gpu.LAUNCH) == 100
    assert on_gpu.next_rounds(1000, 0.0) == 4000  # grows by degrees
    assert on_gpu.next_rounds(1, 1e3) == 1
    assert on_gpu.next_rounds(10**6, 1e-3) == on_gpu.MOST_ROUNDS


def test_chunks_fit_into_the_memory_of_the_gpu():
    layout, _ = on_gpu.thread_text(ensemble_of("exponential", 1)[0], 8)
    bytes_per_run = 8 * (layout.run_size + layout.result_size)
    threads = 10 * on_gpu.RESIDENT
    empty = on_gpu.runs_at_a_time(layout, threads, 0.0)
    small, large = (on_gpu.runs_at_a_time(layout, threads, gigabytes * 1e9) for gigabytes in (4.0, 8.0))
    assert empty == 1
    assert small * bytes_per_run < 0.5 * 4e9
    assert (large - small) * bytes_per_run == pytest.approx(0.5 * 4e9, rel=1e-6)
    assert on_gpu.runs_at_a_time(layout, threads, float("inf")) == 2**31


def test_few_runs_are_spread_over_all_multiprocessors():
    threads = 10 * on_gpu.RESIDENT
    assert on_gpu.threads_per_block(threads, 1) == 32
    assert on_gpu.threads_per_block(threads, 10 * 32) == 32
    assert on_gpu.threads_per_block(threads, 10 * 32 + 1) == 64
    assert on_gpu.threads_per_block(threads, threads) == on_gpu.RESIDENT
    assert on_gpu.threads_per_block(threads, 10**6) == on_gpu.RESIDENT


# --- code for a GPU -------------------------------------------------------------------------------------------------


def assembler() -> str | None:
    """NVIDIA's assembler (pip install nvidia-cuda-nvcc-cu12)."""
    with_package = importlib.util.find_spec("nvidia")
    for folder in with_package.submodule_search_locations or () if with_package else ():
        for name in ("ptxas", "ptxas.exe"):
            if (Path(folder) / "cuda_nvcc" / "bin" / name).exists():
                return str(Path(folder) / "cuda_nvcc" / "bin" / name)
    return shutil.which("ptxas")


@pytest.mark.slow
@pytest.mark.parametrize("law", ["exponential", *rest("lugre", "stiff")])
def test_the_code_for_gpus_is_complete(law, tmp_path):
    """One entry, fused double precision, nothing left to be linked, lanes in local memory; the assembler takes it."""
    layout, code = on_gpu.gpu_code(ensemble_of(law, 1)[0], 8)
    assert code.count(".visible") == 1
    assert f".visible .entry {on_gpu.ENTRY}(" in code
    assert ".target sm_70" in code
    assert ".extern" not in code
    assert code.count("fma.rn.f64") > 500
    assert ".f32" not in code
    assert code.count("atom.global.add.u64") == 2
    lane = 8 * (layout.places["WORK"] + layout.work_size)
    depot = max(int(part.split("[")[1].split("]")[0]) for part in code.split("__local_depot")[1:] if "[" in part[:9])
    assert lane <= depot < 2 * lane
    if assembler() is None:
        pytest.skip("there is no assembler (pip install nvidia-cuda-nvcc-cu12)")
    (tmp_path / "code.ptx").write_text(code)
    for gpu in ("sm_80", "sm_90"):
        command = [assembler(), f"-arch={gpu}", "code.ptx", "-o", "code.cubin"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "code.cubin").stat().st_size > 10_000


# --- a GPU, or none -------------------------------------------------------------------------------------------------

ON_GPU = Budget(5, 1e-8, 1000, 10**6, window=2, asked=EVERYTHING)


def test_a_gpu_agrees_with_the_cpu_to_rounding():
    """The same steps, modes and statuses; numbers differ by an ulp per operation, in sin, cos and exp and in what is
    fused, some 1e-13 per period as between compilers; a run near a grazing contact amplifies that, so nine of ten runs
    are held to it and all to the tolerance of the run."""
    problem = driver.gpu_problem()
    if problem is not None:
        pytest.skip(problem)
    for law in LAWS:
        recorded, parameters, initial = ensemble_of(law, 1000)
        on_cpu = ensemble_run(EnsembleStart(recorded, parameters, initial), ON_GPU, Form(lanes=1))
        with_gpu = on_gpu.gpu_ensemble_run(EnsembleStart(recorded, parameters, initial), ON_GPU)
        results, expected = with_gpu.numbers, on_cpu.numbers
        assert np.array_equal(results[:, 0], expected[:, 0])
        assert np.mean(results[:, 7:9] == expected[:, 7:9]) > 0.99
        numbers = slice(len(RESULT_HEAD), None)  # states and everything measured
        size = 1.0 + np.abs(expected[:, numbers])
        difference = np.max(np.abs(results[:, numbers] - expected[:, numbers]) / size, axis=1)
        assert np.quantile(difference, 0.9) <= 1e-11
        assert np.max(np.abs(with_gpu.state - on_cpu.state)) <= 100.0 * ON_GPU.tolerance


def test_without_a_gpu_the_message_says_what_is_here(monkeypatch):
    def nothing(name):
        raise ModuleNotFoundError(f"No module named {name!r}")

    driver.first_gpu.cache_clear()
    monkeypatch.setattr(importlib, "import_module", nothing)
    with pytest.raises(
        ArgumentError, match=r"device: cuda needs an NVIDIA GPU.*bindings; here: No module named 'cuda.*choose cpu"
    ):
        on_gpu.device()


def test_the_package_finds_the_device(monkeypatch):
    """By the entry point of this package's pyproject.toml, which is checked in place of an installed one."""
    project = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]
    ((group, points),) = project["entry-points"].items()
    entries = [importlib.metadata.EntryPoint(name, value, group) for name, value in points.items()]
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda group: [e for e in entries if e.group == group])
    monkeypatch.setattr(on_gpu, "gpu_problem", lambda: None)
    ran = []
    monkeypatch.setattr(on_gpu, "gpu_ensemble_run", lambda *given, **more: ran.append(given) or ensemble_run(*given))
    system = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic())
    given = {"over": {"machine.mass_ratio": [1.0, 2.0]}, "periods": 2}
    assert np.array_equal(*(vc.ensemble(system, **given, device=name)["mean_velocity"] for name in ("cuda", "cpu")))
    assert len(ran) == 1


def bindings_found() -> bool:
    """Whether NVIDIA's bindings are installed."""
    return importlib.util.find_spec("cuda") is not None and importlib.util.find_spec("cuda.bindings") is not None


@pytest.mark.skipif(not bindings_found(), reason="cuda-bindings is not installed (pip install cuda-bindings)")
def test_with_the_bindings_the_driver_says_why_there_is_no_gpu():
    """The driver is told to show no GPU; where there is no driver, that is what the message says."""
    call = "from vibrocap_gpu.driver import gpu_problem; print(gpu_problem())"
    shown = {**os.environ, "CUDA_VISIBLE_DEVICES": "", "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    done = subprocess.run([sys.executable, "-c", call], env=shown, capture_output=True, text=True, check=True)
    assert "cuda-bindings; here: " in done.stdout
    assert "No module" not in done.stdout


@pytest.mark.skipif(not bindings_found(), reason="cuda-bindings is not installed (pip install cuda-bindings)")
def test_the_driver_has_what_is_asked_of_it():
    """All functions and properties by name."""
    source = "".join(path.read_text() for path in Path(driver.__file__).parent.glob("*.py"))
    bindings = importlib.import_module("cuda.bindings.driver")
    asked = set(re.findall(r'ask\("(\w+)"', source))
    assert len(asked) > 12
    assert all(hasattr(bindings, name) for name in asked)
    assert hasattr(bindings.CUdevice_attribute, "CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT")
