"""Studies on processes and executors: the same bytes as on one process, whatever happens to the workers."""

import contextlib
import multiprocessing
import os
import signal
from concurrent.futures import BrokenExecutor, ThreadPoolExecutor
from pathlib import Path

import distributed
import psutil
import pytest

from stored_files import files
from vibrocap import Exponential, Harmonic, PendulumCapsule, System, verify_study
from vibrocap.case.case import CaseError
from vibrocap.studies import workers
from vibrocap.studies.store.places import StoreError
from vibrocap.studies.sweep import sweep

SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic())
OVER = {"machine.mass_ratio": "1:4:13", "machine.stiffness": "1:2:5"}


def stored(out, **changes):
    return sweep(
        SYSTEM, **{"over": OVER, "measures": ("mean_velocity", "mode_sequence"), "out": out, "tile_runs": 5} | changes
    )


def test_workers_need_a_folder(tmp_path):
    for arguments, said in (
        ({"resume": True}, "resume: needs a folder"),
        ({"mixed": True, "out": tmp_path}, "mixed: continues a stored study"),
        ({"workers": 2}, "workers: needs a folder"),
        ({"workers": ThreadPoolExecutor(1)}, "workers: needs a folder"),
        ({"workers": 0, "out": tmp_path}, "workers: should be a whole number"),
        ({"workers": "two", "out": tmp_path}, "workers: should be a whole number"),
    ):
        with pytest.raises(CaseError, match=said):
            sweep(SYSTEM, over=OVER, **arguments)
    assert list(tmp_path.iterdir()) == []


class Breaking(ThreadPoolExecutor):
    """An executor that breaks after so many tasks."""

    left = 12

    def submit(self, *given):
        self.left -= 1
        if self.left < 0:
            raise BrokenExecutor
        return super().submit(*given)


def test_an_executor_that_breaks_costs_the_tiles_in_work(tmp_path, cheap, monkeypatch):
    """What is stored is kept, and another executor continues, to the bytes of one process."""
    stored(tmp_path / "a")
    monkeypatch.setattr(workers, "IN_FLIGHT", 3)
    with Breaking(2) as executor, pytest.raises(StoreError, match=r"dies again and again.*--resume"):
        stored(tmp_path / "b", workers=executor)
    assert verify_study(tmp_path / "b").ok
    assert 8 <= len(list((tmp_path / "b" / "done").iterdir())) <= 11
    shares = []
    with ThreadPoolExecutor(2) as executor:
        stored(tmp_path / "b", workers=executor, resume=True, progress=shares.append)
    assert files(tmp_path / "a") == files(tmp_path / "b")
    assert shares == sorted(shares)
    assert len(shares) >= 3


def test_a_worker_with_something_else_is_refused_or_its_tiles_say_so(tmp_path, cheap, monkeypatch):
    stored(tmp_path / "a")
    for place in ("finished", "done/0.0"):
        (tmp_path / "a" / place).unlink()
    code = workers.code_of
    monkeypatch.setattr(
        workers, "code_of", lambda *what: {**code(*what), "version": "0.0.9", "sources": "f" * 64, "llvm": "15.0"}
    )
    with ThreadPoolExecutor(1) as executor:
        with pytest.raises(
            StoreError, match=r"here vibrocap 0\.0\.9 with sources ffffffffffff; llvm: stored .*, here 15\.0"
        ):
            stored(tmp_path / "a", workers=executor, resume=True)
        found = stored(tmp_path / "a", workers=executor, resume=True, mixed=True)
    assert verify_study(tmp_path / "a").mixed == ((0, 0),)
    assert "computed with other sources" in found.attrs["mixed"]


@pytest.mark.slow
def test_a_worker_of_dask_that_dies_costs_its_tile_only(tmp_path, cheap, monkeypatch):
    orders = tmp_path / "orders"
    orders.mkdir()
    for mass_ratio in ("1", "2", "3.5"):
        (orders / mass_ratio).touch()
    monkeypatch.setenv("CHEAP_WORKER_DEATHS", str(orders))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]))
    stored(tmp_path / "a")
    how = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0", "preload": ["cheap_worker"]}
    with distributed.LocalCluster(processes=True, **how) as cluster, distributed.Client(cluster) as client:
        stored(tmp_path / "b", workers=client.get_executor())
    assert list(orders.iterdir()) == []  # all of them died
    assert files(tmp_path / "a") == files(tmp_path / "b")


SMALL = {"measures": ("mean_velocity", "mode_sequence"), "periods": 20, "settle": 1e-5, "tile_runs": 5}


@pytest.mark.slow
def test_processes_that_die_cost_their_tiles_only(tmp_path):
    """No one else can reach them, as none of them listens, and none is left. They run the engine."""
    sweep(SYSTEM, over=OVER, out=tmp_path / "a", **SMALL)
    listening, deaths = [], []

    def kill(share):
        listening.extend(
            connection for connection in psutil.Process().net_connections() if connection.status == psutil.CONN_LISTEN
        )
        children = multiprocessing.active_children()
        for child in children:
            with contextlib.suppress(psutil.NoSuchProcess):  # it may end just now
                connections = psutil.Process(child.pid).net_connections()
                listening.extend(connection for connection in connections if connection.status == psutil.CONN_LISTEN)
        if children and len(deaths) < 2:  # none are left where tiles done before the last death are told behind it
            os.kill(children[0].pid, signal.SIGKILL)
            deaths.append(share)

    sweep(SYSTEM, over=OVER, out=tmp_path / "b", workers=2, progress=kill, **SMALL)
    assert len(deaths) == 2
    assert listening == []
    assert multiprocessing.active_children() == []
    assert files(tmp_path / "a") == files(tmp_path / "b")
