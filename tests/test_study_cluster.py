"""Studies on a Dask cluster: the same bytes as on one process, whatever happens to the workers."""

import dataclasses
import importlib
from pathlib import Path

import distributed
import pytest

import cheap_ensemble
from vibrocap import Exponential, Harmonic, PendulumCapsule, System
from vibrocap.case.case import CaseError
from vibrocap.studies import cluster
from vibrocap.studies.dataset import stored_study
from vibrocap.studies.store.writing import StoreError
from vibrocap.studies.sweep import sweep

SYSTEM = System(PendulumCapsule(), Exponential(), Harmonic())
OVER = {"machine.mass_ratio": "1:4:31", "machine.stiffness": "1:2:5"}


@pytest.fixture
def cheap(monkeypatch):
    monkeypatch.setattr(importlib.import_module("vibrocap.measures.ensemble"), "ensemble", cheap_ensemble.ensemble)


def stored(out, **changes):
    return sweep(SYSTEM, **{"over": OVER, "measures": ("mean_velocity", "word"), "out": out, "tile_runs": 5} | changes)


def files(folder):
    """Every file below a folder with its bytes."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_cluster_needs_a_folder_and_one_address(tmp_path):
    for arguments, said in (
        ({"workers": 2}, "workers: needs a folder"),
        ({"scheduler": "tcp://somewhere:8786"}, "scheduler: needs a folder"),
        ({"workers": 2, "scheduler": "tcp://somewhere:8786", "out": tmp_path}, "workers: are of a local cluster"),
        ({"workers": 0, "out": tmp_path}, "workers: should be a whole number"),
    ):
        with pytest.raises(CaseError, match=said):
            sweep(SYSTEM, over=OVER, **arguments)
    assert list(tmp_path.iterdir()) == []


def test_no_scheduler_answers(tmp_path, monkeypatch):
    monkeypatch.setattr(cluster, "PATIENCE", 0.2)
    for address in ("tcp://127.0.0.1:1", "nonsense://127.0.0.1:1"):
        with pytest.raises(CaseError, match=f"no scheduler answers at '{address}'"):
            stored(tmp_path / "a", resume=True, scheduler=address)
    with pytest.raises(ValueError, match="No client"):  # nothing of Dask is left that others would take for theirs
        distributed.default_client()


def test_a_worker_refuses_what_it_should_not_compute(tmp_path, cheap):
    stored(tmp_path / "a")
    study = stored_study(tmp_path / "a")
    (tmp_path / "a" / "done" / "0.0").unlink()
    other = dataclasses.replace(study, window=9)
    with pytest.raises(StoreError, match="holds another study"):
        cluster.run_and_store(other, str(tmp_path / "a"), (0, 0))
    with pytest.raises(StoreError, match="a file system that all machines share"):
        cluster.run_and_store(study, str(tmp_path / "elsewhere"), (0, 0))


def test_a_worker_of_another_version_refuses(tmp_path, cheap, monkeypatch):
    stored(tmp_path / "a")
    study = stored_study(tmp_path / "a")
    (tmp_path / "a" / "done" / "0.0").unlink()
    monkeypatch.setattr(cluster, "code_version", lambda: {"version": "0.0.9", "sources": "f" * 64})
    with pytest.raises(StoreError, match=r"has vibrocap 0\.0\.9 with sources ffffffffffff, the study needs"):
        cluster.run_and_store(study, str(tmp_path / "a"), (0, 0))


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


@pytest.mark.slow
def test_a_study_begun_here_goes_on_there(tmp_path, cheap, deadly):
    made, _ = deadly
    stored(tmp_path / "a")
    stored(tmp_path / "b")
    for mark in ("3.0", "30.0", "17.0"):
        (tmp_path / "b" / "done" / mark).unlink()
    stored(tmp_path / "b", resume=True, scheduler=made.scheduler_address)
    assert files(tmp_path / "a") == files(tmp_path / "b")


@pytest.mark.slow
def test_workers_of_this_machine_run_the_engine(tmp_path):
    settings = {"measures": ("mean_velocity", "word"), "periods": 20, "settle": 1e-5, "tile_runs": 20}
    sweep(SYSTEM, over=OVER, out=tmp_path / "a", **settings)
    sweep(SYSTEM, over=OVER, out=tmp_path / "b", workers=2, **settings)
    assert files(tmp_path / "a") == files(tmp_path / "b")
