"""What holds for all tests: how a worker begins."""

import contextlib
import gc
import importlib
import os
import pathlib

import pytest

# Before NumPy is loaded: two workers whose BLAS has two threads each wait for one another on two cores.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


def pytest_sessionstart(session: pytest.Session) -> None:
    """Each worker of several imports another share of the files first, so that each file is made ready once.

    To write the asserts of a file anew, so that they say what they compared, costs as much as to collect it; what one
    worker has made ready, the others read.
    """
    worker, workers = os.environ.get("PYTEST_XDIST_WORKER"), os.environ.get("PYTEST_XDIST_WORKER_COUNT")
    if worker and workers:
        names = sorted(path.stem for path in pathlib.Path(__file__).parent.glob("test_*.py"))
        for name in names[int(worker.removeprefix("gw")) :: int(workers)]:
            with contextlib.suppress(Exception, pytest.skip.Exception):  # said where the file is collected
                importlib.import_module(name)


@pytest.fixture(autouse=True, scope="session")
def kernels_are_found_by_their_text():
    """In the tests' own processes no kernel is found by its equations alone: faults are planted in what writes it.

    A kernel with a fault would be noted for equations that lead to the right one elsewhere.
    """
    from plain_kernels import in_either_form
    from vibrocap.numerics import compiler

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(compiler, "noted", lambda key: None)
        patch.setattr(compiler, "note", lambda key, text, entry, literal: None)
        in_either_form(patch)
        yield


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item):
    """A test marked `plain`, with its fixtures of any scope, runs kernels as plain Python; a slow one compiles them.

    They are one source (`test_parity.py`). A test of a file so marked is compiled where it is marked `plain(False)`.
    """
    from plain_kernels import EitherKernel

    slow, longer, plain = (item.get_closest_marker(name) for name in ("slow", "exhaustive", "plain"))
    EitherKernel.plain = plain is not None and plain.args != (False,) and not (slow or longer)
    return (yield)


@pytest.fixture(autouse=True)
def parts_are_forgotten():
    """No part that a test loads stays registered: tables of all laws and machines in its process would have it."""
    from vibrocap.physics.catalogue import registered, unregister

    before = registered()
    yield
    for part in registered():
        if part not in before:
            unregister(part)


@pytest.fixture
def cheap(monkeypatch):
    """A cheap ensemble in place of the engine, and files not forced to the disk; the list of what it was asked for."""
    from cheap_ensemble import ensemble

    calls = []

    def counted(system, over, **settings):
        calls.append(over)
        return ensemble(system, over, **settings)

    monkeypatch.setattr(importlib.import_module("vibrocap.measures.ensemble"), "ensemble", counted)
    monkeypatch.setattr(os, "fsync", lambda handle: None)  # takes most of the time of these tests
    return calls


@pytest.hookimpl(wrapper=True)
def pytest_collection(session: pytest.Session):
    """What is imported and collected stays to the end: it is not looked through again and again for what may go."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(20_000, 20, 50)  # what tests make is gone soon, most of it without being looked for
        gc.enable()
