"""Studies on processes and Dask clusters: the same bytes as on one process, whatever happens to the workers."""

import contextlib
import dataclasses
import importlib
import multiprocessing
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import dask
import distributed
import psutil
import pytest

import cheap_ensemble
from vibrocap import Exponential, Harmonic, PendulumCapsule, System, verify_study
from vibrocap.case.case import CaseError
from vibrocap.cli.main import main
from vibrocap.studies.dataset import stored_study
from vibrocap.studies.run import cluster, processes, tile_worker
from vibrocap.studies.run.tile_worker import run_and_store
from vibrocap.studies.store.writing import StoreError
from vibrocap.studies.sweep import sweep

SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic())
OVER = {"machine.mass_ratio": "1:4:31", "machine.stiffness": "1:2:5"}


@pytest.fixture(autouse=True)
def dask_as_before():
    """A client whose scheduler was killed leaves Dask asking for it; later tests of the process are to find none."""
    before = dask.config.get("scheduler", None)
    yield
    dask.config.set(scheduler=before)


@pytest.fixture
def cheap(monkeypatch):
    monkeypatch.setattr(importlib.import_module("vibrocap.measures.ensemble"), "ensemble", cheap_ensemble.ensemble)


def stored(out, **changes):
    return sweep(
        SYSTEM, **{"over": OVER, "measures": ("mean_velocity", "mode_sequence"), "out": out, "tile_runs": 5} | changes
    )


def files(folder):
    """Every file below a folder with its bytes."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_cluster_needs_a_folder_and_one_address(tmp_path):
    for arguments, said in (
        ({"resume": True}, "resume: needs a folder"),
        ({"mixed": True, "out": tmp_path}, "mixed: continues a stored study"),
        ({"workers": 2}, "workers: needs a folder"),
        ({"scheduler": "tcp://somewhere:8786"}, "scheduler: needs a folder"),
        ({"workers": 2, "scheduler": "tcp://somewhere:8786", "out": tmp_path}, "workers: are processes of this"),
        ({"workers": 0, "out": tmp_path}, "workers: should be a whole number"),
    ):
        with pytest.raises(CaseError, match=said):
            sweep(SYSTEM, over=OVER, **arguments)
    assert list(tmp_path.iterdir()) == []


def test_no_scheduler_answers(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 0.2)
    with pytest.raises(CaseError, match=r"no scheduler answers at 'tcp://127\.0\.0\.1:1'"):
        stored(tmp_path / "a", resume=True, scheduler="tcp://127.0.0.1:1")
    assert not (tmp_path / "a").exists()
    with pytest.raises(ValueError, match="No client"):  # nothing of Dask is left that others would take for theirs
        distributed.default_client()


@pytest.mark.parametrize(
    "address", ["foo", "", "node1:8786", "nonsense://127.0.0.1:1", "tcp://node1", "tcp://:8786", "tcp://n:99999", 8786]
)
def test_what_is_no_address_is_refused_at_once(tmp_path, monkeypatch, address, capsys):
    monkeypatch.setattr(distributed, "Client", None)  # no one is asked
    with pytest.raises(
        CaseError, match="scheduler: should be the address of a Dask scheduler, such as tcp://node1:8786"
    ):
        stored(tmp_path / "a", scheduler=address)
    if isinstance(address, str):
        case = Path(__file__).parents[1] / "examples" / "travels-by-stick-slip.toml"
        given = ["--over", "drive.amplitude=1:2:3", "--out", str(tmp_path / "a"), "--scheduler", address]
        assert main(["sweep", str(case), *given]) == 2
        assert "--scheduler: should be the address of a Dask scheduler" in capsys.readouterr().err


def test_a_worker_refuses_what_it_should_not_compute(tmp_path, cheap):
    stored(tmp_path / "a")
    study = stored_study(tmp_path / "a")
    (tmp_path / "a" / "done" / "0.0").unlink()
    other = dataclasses.replace(study, window=9)
    with pytest.raises(StoreError, match="holds another study"):
        run_and_store(other, str(tmp_path / "a"), (0, 0))
    with pytest.raises(StoreError, match="a file system that all machines share"):
        run_and_store(study, str(tmp_path / "elsewhere"), (0, 0))


def test_a_worker_with_something_else_refuses_or_says_so(tmp_path, cheap, monkeypatch):
    stored(tmp_path / "a")
    study = stored_study(tmp_path / "a")
    (tmp_path / "a" / "done" / "0.0").unlink()
    other = dict(study.code) | {"version": "0.0.9", "sources": "f" * 64, "llvm": "15.0 of another"}
    monkeypatch.setattr(tile_worker, "code_of", lambda plan: other)
    with pytest.raises(
        StoreError, match=r"here vibrocap 0\.0\.9 with sources ffffffffffff; llvm: stored .*, here 15\.0 of another"
    ):
        run_and_store(study, str(tmp_path / "a"), (0, 0))
    assert run_and_store(study, str(tmp_path / "a"), (0, 0), mixed=True)
    assert verify_study(tmp_path / "a").mixed == ((0, 0),)


def test_what_a_worker_stored_elsewhere_is_noticed(tmp_path, cheap, monkeypatch):
    stored(tmp_path / "a")
    store = cluster.Store(tmp_path / "a", stored_study(tmp_path / "a"), (1, 5))
    monkeypatch.setattr(cluster, "PATIENCE", 0.0)
    cluster._check_shown(store, (0, 0))
    with pytest.raises(StoreError, match="a file system that all machines share"):
        cluster._check_shown(store, (99, 0))


@pytest.fixture
def deadly(tmp_path, monkeypatch):
    """A cluster of two workers with the cheap ensemble, and the folder for the runs at which they are to die."""
    orders = tmp_path / "orders"
    orders.mkdir()
    monkeypatch.setenv("CHEAP_WORKER_DEATHS", str(orders))
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0", preload=["cheap_worker"]
    ) as made:
        yield made, orders


@pytest.mark.slow
def test_a_worker_that_dies_costs_its_tile_only(tmp_path, cheap, deadly):
    made, orders = deadly
    for mass_ratio in ("1", "2", "3.5"):
        (orders / mass_ratio).touch()
    stored(tmp_path / "a")
    shares = []
    stored(tmp_path / "b", scheduler=made.scheduler_address, progress=shares.append)
    assert list(orders.iterdir()) == []  # all of them died
    assert files(tmp_path / "a") == files(tmp_path / "b")
    assert shares == sorted(shares)
    assert len(shares) >= 31


@pytest.mark.exhaustive
@pytest.mark.slow
def test_a_study_begun_here_goes_on_there(tmp_path, cheap, deadly):
    made, _ = deadly
    stored(tmp_path / "a")
    stored(tmp_path / "b")
    for mark in ("3.0", "30.0", "17.0"):
        (tmp_path / "b" / "done" / mark).unlink()
    stored(tmp_path / "b", resume=True, scheduler=made.scheduler_address)
    assert files(tmp_path / "a") == files(tmp_path / "b")


SMALL = {"measures": ("mean_velocity", "mode_sequence"), "periods": 20, "settle": 1e-5, "tile_runs": 20}


@pytest.mark.slow
def test_workers_of_this_machine_run_the_engine_and_leave_no_process(tmp_path):
    sweep(SYSTEM, over=OVER, out=tmp_path / "a", **SMALL)
    sweep(SYSTEM, over=OVER, out=tmp_path / "b", workers=2, **SMALL)
    assert files(tmp_path / "a") == files(tmp_path / "b")
    assert multiprocessing.active_children() == []


@pytest.mark.slow
def test_processes_that_die_cost_their_tiles_only(tmp_path):
    """And no one else can reach them: none of them listens."""
    sweep(SYSTEM, over=OVER, out=tmp_path / "a", **SMALL)
    listening, deaths = [], []

    def kill(share):
        listening.extend(each for each in psutil.Process().net_connections() if each.status == psutil.CONN_LISTEN)
        children = multiprocessing.active_children()
        for child in children:
            with contextlib.suppress(psutil.NoSuchProcess):  # it may end just now
                found = psutil.Process(child.pid).net_connections()
                listening.extend(each for each in found if each.status == psutil.CONN_LISTEN)
        if children and len(deaths) < 2:
            os.kill(children[0].pid, signal.SIGKILL)
            deaths.append(share)

    sweep(SYSTEM, over=OVER, out=tmp_path / "b", workers=2, progress=kill, **SMALL)
    assert len(deaths) == 2
    assert listening == []
    assert files(tmp_path / "a") == files(tmp_path / "b")


def dying(*_, **__):
    os._exit(9)


@pytest.mark.exhaustive
@pytest.mark.slow
def test_processes_that_die_again_and_again_end_a_study(tmp_path, monkeypatch):
    monkeypatch.setattr(processes, "_tile", dying)
    with pytest.raises(StoreError, match=r"dies again and again.*is there enough memory.*--resume"):
        stored(tmp_path / "a", workers=1)
    assert multiprocessing.active_children() == []


@pytest.fixture
def scheduler():
    """A scheduler of no workers."""
    with distributed.LocalCluster(n_workers=0, processes=False, protocol="tcp", dashboard_address=None) as made:
        yield made


@pytest.mark.slow
def test_no_workers_are_said_and_waited_for(tmp_path, cheap, monkeypatch, scheduler):
    monkeypatch.setattr(cluster, "PATIENCE", 1.0)
    monkeypatch.setattr(cluster, "LOOK", 0.1)
    threading.Timer(4.0, lambda: scheduler.scale(1)).start()
    with pytest.warns(cluster.ClusterWarning, match="has no workers; the study waits for some"):
        stored(tmp_path / "b", scheduler=scheduler.scheduler_address)
    stored(tmp_path / "a")
    assert files(tmp_path / "a") == files(tmp_path / "b")


@pytest.mark.exhaustive
@pytest.mark.slow
def test_the_same_study_goes_into_two_folders_of_one_cluster(tmp_path, cheap, deadly):
    made, _ = deadly
    with ThreadPoolExecutor(2) as pool:
        for each in [pool.submit(stored, tmp_path / name, scheduler=made.scheduler_address) for name in ("a", "b")]:
            each.result()
    assert files(tmp_path / "a") == files(tmp_path / "b")
    assert verify_study(tmp_path / "b").finished


@pytest.mark.slow
def test_a_scheduler_that_goes_away_ends_a_study_in_words(tmp_path, monkeypatch):
    """So does a worker without the package. The scheduler is a process of its own, which is killed."""
    case = Path(__file__).parents[1] / "examples" / "travels-by-stick-slip.toml"
    many = ["--over", "drive.amplitude=1:3:200", "--over", "machine.mass_ratio=1:3:200", "--settle", "0"]
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    dask = [sys.executable, "-m"]
    begin = [*dask, "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", address.rpartition(":")[2]]
    work = [*dask, "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny"]
    blocked = tmp_path / "blocked" / "vibrocap"
    blocked.mkdir(parents=True)
    (blocked / "__init__.py").write_text("raise ModuleNotFoundError(\"No module named 'vibrocap'\")")
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": tmp_path}
    scheduler = subprocess.Popen([*begin, "--no-dashboard"], **quiet)
    workers = [subprocess.Popen(work, env=os.environ | {"PYTHONPATH": str(blocked.parent)}, **quiet)]
    try:
        monkeypatch.setattr(cluster, "PATIENCE", 60.0)  # until the scheduler is up
        with pytest.raises(CaseError, match="no vibrocap on tcp://127"):
            stored(tmp_path / "none", scheduler=address)
        workers[0].kill()
        workers[0].wait()
        workers.append(subprocess.Popen(work, **quiet))
        out = tmp_path / "a"
        sweeping = subprocess.Popen(
            [*dask, "vibrocap", "sweep", str(case), *many, "--out", str(out), "--scheduler", address],
            stderr=subprocess.PIPE,
            text=True,
        )
        while not list(out.glob("done/*")) and sweeping.poll() is None:
            time.sleep(0.1)
        scheduler.kill()
        said = sweeping.communicate(timeout=60)[1]
        assert sweeping.returncode == 3, said
        assert f"the scheduler at {address} is gone" in said
        assert "continue with --resume" in said
        assert "Traceback" not in said
        assert verify_study(out).ok
    finally:
        for process in (scheduler, *workers):
            process.kill()
            process.wait()
