"""Ensembles on a graphics card: the same results on CUDA's simulator, code for a card without one, a card where it is.

numba-cuda decides at its import whether it simulates, so that whatever imports it runs in a process of its own: this
file, called with the name of one of the `RUNS` and the file for its results.
"""

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path
from unittest import mock

import numpy as np
import pytest

import vibrocap as vc
from vibrocap.motion.equations import equations, parameter_values
from vibrocap.numerics import cuda as on_card
from vibrocap.numerics.ensemble import Budget, ensemble_run
from vibrocap.numerics.lanes import DONE, RESULT_HEAD, TOO_MANY_STEPS

LAWS = {"exponential": vc.Exponential(), "lugre": vc.LuGre(), "stiff": vc.LuGre(bristle_stiffness=1e4)}
EVERYTHING = 63  # all groups of measures
CAPABILITY = (9, 0)  # of the card that PTX is written for
needs_numba_cuda = pytest.mark.skipif(
    importlib.util.find_spec("numba_cuda") is None,
    reason='numba-cuda is not installed (pip install "vibrocap[gpu]")',
)


def nvvm_found() -> bool:
    """Whether CUDA's compiler library can be loaded."""
    try:
        from cuda.pathfinder import load_nvidia_dynamic_lib

        load_nvidia_dynamic_lib("nvvm")
    except (ImportError, RuntimeError):
        return False
    return True


def ensemble_of(law: str, runs: int):
    """(equations, parameters, initial) of runs that differ in mass ratio and start."""
    system = vc.System(vc.PendulumCapsule(), LAWS[law], vc.Harmonic())
    recorded = equations(system)
    parameters = np.tile(parameter_values(system), (runs, 1))
    parameters[:, recorded.parameter_paths.index("machine.mass_ratio")] = np.linspace(0.5, 6.0, runs)
    initial = np.zeros((runs, len(recorded.rates)))
    initial[:, 0] = np.linspace(0.4, 1.2, runs)
    return recorded, parameters, initial


# --- what runs in processes of their own -----------------------------------------------------------------------------

SIMULATED = {  # law, runs, budget
    "exponential": ("exponential", 7, Budget(2, 1, 0.0, 1e-6, 1000, 75, EVERYTHING)),
    "settling": ("exponential", 3, Budget(14, 2, 0.1, 1e-4, 1000, 10**6, EVERYTHING)),
    "stiff": ("stiff", 2, Budget(1, 1, 0.0, 1e-4, 1000, 10**6, EVERYTHING)),
}


def simulate(case: str, rounds: int) -> tuple[np.ndarray, list[int]]:
    """(results, progress) on the simulator: two blocks of two threads, launches of so many steps, chunks of 4 runs."""
    law, runs, budget = SIMULATED[case]
    begun: list[int] = []
    with mock.patch.multiple(
        on_card,
        card_threads=lambda: 3,  # rounded up to whole blocks
        runs_at_a_time=lambda *_: 4,
        next_rounds=lambda before, seconds: rounds,
        BLOCK=2,
        FIRST_ROUNDS=rounds,
    ):
        _, results = on_card.cuda_ensemble_run(*ensemble_of(law, runs), budget, progress=begun.append)
    return results, begun


def save_simulation(out: str) -> None:
    """Every case in launches of several lengths."""
    found = {}
    for case, lengths in (("exponential", (7, 10_000)), ("settling", (10_000,)), ("stiff", (10_000,))):
        for rounds in lengths:
            found[f"{case} {rounds}"], begun = simulate(case, rounds)
            found[f"{case} {rounds} begun"] = np.array(begun)
    np.savez(out, **found)


def save_ptx(out: str) -> None:
    """The code of both laws for a card that is not here; only what kind it is need be known."""
    from numba import cuda, types
    from numba.cuda import cuda_paths, dispatcher
    from numba.cuda.cudadrv import nvrtc

    reals, wholes = types.float64[::1], types.int64[::1]
    kept = types.float64[:, ::1], types.int64[:, ::1]
    signature = (reals, wholes, reals, wholes, *kept, types.int64, types.int64)
    card = mock.Mock(compute_capability=CAPABILITY)
    found = {}
    with (
        mock.patch.object(dispatcher, "get_current_device", return_value=card),
        # Else a library of 90 MB is asked which cards there are.
        mock.patch.object(nvrtc, "get_supported_ccs", return_value=[CAPABILITY]),
        mock.patch.object(cuda_paths, "_get_nvrtc_path", return_value=None),
    ):
        for law in ("exponential", "lugre"):
            recorded, _, _ = ensemble_of(law, 1)
            layout, kernel = on_card.cuda_kernel(recorded, 8)
            ptx, _ = cuda.compile_ptx(kernel.py_func, signature, cc=CAPABILITY, device=False)
            found[law] = {"ptx": ptx, "lane": (layout.places["WORK"] + layout.work_size) * 8}
    Path(out).write_text(json.dumps(found))


ON_CARD = Budget(5, 2, 0.0, 1e-8, 1000, 10**6, EVERYTHING)


def save_card(out: str) -> None:
    """Results on the card that is here; nothing where there is none, and why."""
    problem = on_card.cuda_problem()
    found = {"problem": np.array(problem or "")}
    if problem is None:
        for law in LAWS:
            _, found[law] = on_card.cuda_ensemble_run(*ensemble_of(law, 1000), ON_CARD)
    np.savez(out, **found)


RUNS = {"simulation.npz": save_simulation, "ptx.json": save_ptx, "card.npz": save_card}


def result_of(name: str, folder: Path, **environment: str) -> Path:
    """The file that a process of its own has written."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith("NUMBA_")}
    kept.update(environment, PYTHONWARNINGS="default")
    done = subprocess.run(
        [sys.executable, __file__, name, str(folder / name)], env=kept, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-4000:]
    return folder / name


# --- the simulator ---------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    path = result_of("simulation.npz", tmp_path_factory.mktemp("cuda"), NUMBA_ENABLE_CUDASIM="1")
    with np.load(path) as found:
        return dict(found)


def on_the_cpu(case: str) -> np.ndarray:
    law, runs, budget = SIMULATED[case]
    order = on_card.ensemble_order(budget.tolerance)
    return ensemble_run(*ensemble_of(law, runs), budget, threads=1, order=order, lanes=1, plain=True)[1]


@needs_numba_cuda
@pytest.mark.parametrize("case", SIMULATED)
def test_the_simulator_does_what_the_cpu_does(simulated, case):
    """Threads that take run after run from a queue, in chunks: the very same bits as one lane of plain Python."""
    expected = on_the_cpu(case)
    assert np.array_equal(simulated[f"{case} 10000"], expected, equal_nan=True)
    statuses = set(expected[:, 0])
    assert statuses == ({DONE, TOO_MANY_STEPS} if case == "exponential" else {DONE})  # a failed run fails there too
    if case == "stiff":
        assert np.all(expected[:, 8] > 0)  # implicit steps
    if case == "settling":
        assert np.count_nonzero(expected[:, 3]) > 0  # response periods


@needs_numba_cuda
def test_short_launches_change_nothing(simulated):
    """All that a thread carries outlives a launch, wherever in a run that ends."""
    assert np.array_equal(simulated["exponential 7"], simulated["exponential 10000"])
    short, long = simulated["exponential 7 begun"], simulated["exponential 10000 begun"]
    assert len(short) > 5 * len(long)  # ended many times within runs
    assert short[-1] == long[-1] == 7  # all runs begun
    assert np.all(np.diff(short) >= 0)


def test_launches_take_a_quarter_of_a_second():
    assert on_card.next_rounds(1000, on_card.LAUNCH) == 1000
    assert on_card.next_rounds(1000, 10.0 * on_card.LAUNCH) == 100
    assert on_card.next_rounds(1000, 0.0) == 4000  # grows by degrees
    assert on_card.next_rounds(1, 1e3) == 1
    assert on_card.next_rounds(10**6, 1e-3) == on_card.MOST_ROUNDS


def test_chunks_fit_into_the_memory_of_the_card():
    layout, _ = on_card.cuda_text(ensemble_of("exponential", 1)[0], 8)
    bytes_per_run = 8 * (layout.run_size + layout.result_size)
    threads = 10 * on_card.RESIDENT
    empty = on_card.runs_at_a_time(layout, threads, 0.0)
    small, large = (on_card.runs_at_a_time(layout, threads, gigabytes * 1e9) for gigabytes in (4.0, 8.0))
    assert empty == 1
    assert small * bytes_per_run < 0.5 * 4e9
    assert (large - small) * bytes_per_run == pytest.approx(0.5 * 4e9, rel=1e-6)
    assert on_card.runs_at_a_time(layout, threads, float("inf")) == 2**31


# --- code for a card -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def codes(tmp_path_factory):
    return json.loads(result_of("ptx.json", tmp_path_factory.mktemp("cuda")).read_text())


@pytest.mark.slow
@needs_numba_cuda
@pytest.mark.skipif(not nvvm_found(), reason="libNVVM is not installed (pip install nvidia-cuda-nvcc-cu12)")
@pytest.mark.parametrize("law", ["exponential", "lugre"])
def test_the_kernel_compiles_for_a_card(codes, law):
    """Complete code: one entry, fused double precision, nothing left to be linked, and lanes in local memory."""
    ptx, lane = codes[law]["ptx"], codes[law]["lane"]
    assert ptx.count(".visible .entry") == 1
    assert on_card.ENTRY in ptx
    assert f".target sm_{CAPABILITY[0]}{CAPABILITY[1]}" in ptx
    assert ".extern .func" not in ptx
    assert ptx.count("fma.rn.f64") > 500
    assert "fma.rn.f32" not in ptx
    assert "atom.global.add" in ptx
    depot = int(ptx.split("__local_depot")[1].split("[")[1].split("]")[0])
    assert lane <= depot < 2 * lane


# --- a card, or none -------------------------------------------------------------------------------------------------


@needs_numba_cuda
def test_a_card_agrees_with_the_cpu_to_rounding(tmp_path):
    """The same steps, modes and statuses; numbers differ by an ulp per operation, in CUDA's sin, cos and exp and its
    fused multiply-adds, some 1e-13 per period as between compilers; a run near a grazing contact amplifies that, so
    nine of ten runs are held to it and all to the tolerance of the run."""
    with np.load(result_of("card.npz", tmp_path)) as found:
        if str(found["problem"]):
            pytest.skip(str(found["problem"]))
        for law in LAWS:
            recorded, parameters, initial = ensemble_of(law, 1000)
            layout, expected = ensemble_run(recorded, parameters, initial, ON_CARD, lanes=1)
            results = found[law]
            assert np.array_equal(results[:, 0], expected[:, 0])
            assert np.mean(results[:, 7:9] == expected[:, 7:9]) > 0.99
            numbers = slice(len(RESULT_HEAD), None)  # states and everything measured
            size = 1.0 + np.abs(expected[:, numbers])
            difference = np.max(np.abs(results[:, numbers] - expected[:, numbers]) / size, axis=1)
            assert np.quantile(difference, 0.9) <= 1e-11
            state = slice(len(RESULT_HEAD) + layout.states, len(RESULT_HEAD) + 2 * layout.states)
            assert np.max(np.abs(results[:, state] - expected[:, state])) <= 100.0 * ON_CARD.tolerance


def test_without_numba_cuda_the_message_says_what_to_install(monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if name == "numba_cuda" else found(name))
    with pytest.raises(ValueError, match=r'device: "cuda" needs an NVIDIA card.*vibrocap\[gpu\].*found: no numba-cuda'):
        on_card.cuda_ensemble_run(*ensemble_of("exponential", 1), ON_CARD)


@needs_numba_cuda
def test_without_a_card_the_message_says_what_was_found():
    """The driver is told to show no card; where there is no driver, that is what the message says."""
    call = "from vibrocap.numerics.cuda import cuda_problem; print(cuda_problem())"
    shown = {**os.environ, "CUDA_VISIBLE_DEVICES": "", "NUMBA_ENABLE_CUDASIM": "0"}
    done = subprocess.run([sys.executable, "-c", call], env=shown, capture_output=True, text=True, check=True)
    assert "found: numba-cuda " in done.stdout
    assert "but: " in done.stdout
    assert 'device="cpu"' in done.stdout


if __name__ == "__main__":
    RUNS[sys.argv[1]](sys.argv[2])
