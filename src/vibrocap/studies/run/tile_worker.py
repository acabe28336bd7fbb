"""What a helper of a study does, on this machine or another: compute one tile, store it, and answer with counts."""

import functools
import os
import socket
from pathlib import Path

import numpy as np

from vibrocap.case.case import CaseError
from vibrocap.motion.status import Status
from vibrocap.studies.plan.differences import code_differences
from vibrocap.studies.plan.study import Study, code_of
from vibrocap.studies.run.sent_study import SentStudy
from vibrocap.studies.store.places import STUDY
from vibrocap.studies.store.record import read_record
from vibrocap.studies.store.store import Store
from vibrocap.studies.store.writing import StoreError
from vibrocap.studies.tile import run_tile

Index = tuple[int, ...]


def run_and_store(
    study: Study | SentStudy, path: str, index: Index, threads: int | None = 1, mixed: bool = False
) -> dict[str, int]:
    """Compute one tile and store it; how many runs ended how, by the words of their status.

    A tile that is stored already is left as it is, and nothing is counted. mixed: with whatever there is here, which
    the tile then says; else StoreError where it is not with what the study was begun with.
    """
    study = study.study() if isinstance(study, SentStudy) else study
    store = _store_of(study, Path(path), mixed)
    if store.is_done(index):
        return {}
    arrays = run_tile(study, store.tile, index, threads=threads)
    store.write(index, arrays)
    codes, counts = np.unique(arrays["status"], return_counts=True)
    statuses = list(Status)
    return {statuses[int(code)].value: int(count) for code, count in zip(codes, counts, strict=True)}


def _store_of(study: Study, path: Path, mixed: bool) -> Store:
    """The store of a study as it shows here."""
    try:
        seen = os.stat(path / STUDY)
        identity, tile = _identity_and_tile(path, seen.st_ino, seen.st_mtime_ns)
    except (OSError, CaseError) as error:
        reason = error.complaints[0] if isinstance(error, CaseError) else error.strerror
        raise StoreError(
            f"{path}: a worker on {socket.gethostname()} does not see the study there ({reason}); the folder should be "
            "on a file system that all machines share"
        ) from None
    if identity != study.identity:
        raise StoreError(f"{path}: holds another study than the one that a worker was sent")
    own = code_of(study.plan)
    if own == study.code:
        return Store(path, study, tile)
    if not mixed:
        found = "; ".join(code_differences(study.code, own))
        raise StoreError(
            f"{path}: a worker on {socket.gethostname()} computes with something else than the study was begun with: "
            f"{found}. Give all workers the same, or continue with --mixed (mixed=True)"
        )
    return Store(path, study, tile, made_by=own)


@functools.lru_cache(maxsize=4)
def _identity_and_tile(path: Path, _inode: int, _changed: int) -> tuple[str, tuple[int, ...]]:
    record = read_record(path)
    return record["identity"], tuple(record["tile"])
