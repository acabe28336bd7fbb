"""A store: the folder in which a study's results are kept, tile by tile, so that it can go on after anything.

    study.json      the study (enough to run it again), its identity and its tiles; the last to be written at first
    results.zarr/   the results: a Zarr group, version 3, one array per variable, one chunk per tile
    done/           an empty file per tile that is stored, named by its place, such as "3.0"
    lock            held by the process that writes
    unfinished/     files on their way; gone when no one writes

Each file is written elsewhere, forced to the disk and then renamed to its place, and a tile's mark comes after its
chunks. So a tile either is marked and whole, or is computed again to the same bytes. Nothing in a store tells the time
or the order of writing: a store that was interrupted and resumed equals an uninterrupted one, file by file.
"""

import functools
import json
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.case.case import CaseError
from vibrocap.studies.code_version import surroundings
from vibrocap.studies.differences import differences
from vibrocap.studies.study import FORMAT, Study
from vibrocap.studies.tile import tile_indices
from vibrocap.studies.writing import Lock, kept, write_files
from vibrocap.studies.zarr_files import ZarrFiles

STUDY, RESULTS, DONE, LOCK, UNFINISHED = "study.json", "results.zarr", "done", "lock", "unfinished"
OWN = {STUDY, RESULTS, DONE, LOCK, UNFINISHED}


class Store:
    """The folder of one study's results; `opened_for_writing` gives one to its one writer."""

    def __init__(self, path: Path, study: Study, tile: tuple[int, ...]):
        self.path, self.study, self.tile = path, study, tile

    @functools.cached_property
    def _files(self) -> ZarrFiles:
        return ZarrFiles(self.study, self.tile)

    @property
    def indices(self) -> Iterator[tuple[int, ...]]:
        """All tiles, in C order."""
        return tile_indices(self.study.plan.shape, self.tile)

    def pending(self) -> list[tuple[int, ...]]:
        """The tiles that are not stored yet."""
        with kept(self.path):
            done = {entry.name for entry in (self.path / DONE).iterdir()}
        return [index for index in self.indices if _name(index) not in done]

    def is_done(self, index: tuple[int, ...]) -> bool:
        """Whether a tile is stored."""
        return (self.path / DONE / _name(index)).exists()

    def write(self, index: tuple[int, ...], arrays: Mapping[str, np.ndarray]) -> None:
        """Store a tile; StoreError, with nothing lost that was stored before, where the folder does not take it."""
        with kept(self.path):
            write_files(self.path / RESULTS, self._files.chunks(index, arrays), self.path / UNFINISHED)
            write_files(self.path / DONE, {_name(index): b""}, self.path / UNFINISHED)

    def clean(self) -> None:
        """Remove what unfinished writing left."""
        with kept(self.path):
            if (self.path / UNFINISHED).exists():
                shutil.rmtree(self.path / UNFINISHED)


def opened_for_writing(path: Path, study: Study, tile: tuple[int, ...], *, resume: bool) -> tuple[Store, Lock]:
    """The store of a study, begun or resumed, and the lock on it, which is to be released.

    A store that is resumed keeps its own tiles. Raises CaseError where the folder is not for this study, StoreError
    where it cannot be written.
    """
    _refuse_foreign(path)
    with kept(path):
        path.mkdir(parents=True, exist_ok=True)
        lock = Lock(path / LOCK)
    try:
        if not (path / STUDY).exists():
            _begin(path, study, tile)
            return Store(path, study, tile), lock
        if not resume:
            raise CaseError(["holds a study already; go on with --resume, or give another folder"], str(path))
        record = read_record(path)
        if record["identity"] != study.identity:
            found = differences(record["study"], study.record()) or ["its identity"]
            raise CaseError([f"holds another study: {text}" for text in found], str(path))
        stored = Store(path, study, tuple(record["tile"]))
        stored.clean()
        return stored, lock
    except BaseException:
        lock.release()
        raise


def read_record(path: Path) -> dict[str, Any]:
    """What study.json says; CaseError where a folder holds no store of this program."""
    try:
        record = json.loads((path / STUDY).read_text(encoding="utf-8"))
        if record["format"] == FORMAT:
            return record
        complaint = f"is of another format ({record['format']!r}) than this version reads ({FORMAT!r})"
    except FileNotFoundError:
        complaint = "no such folder" if not path.exists() else f"holds no study: there is no {STUDY} in it"
    except NotADirectoryError:
        complaint = "is a file, not the folder of a study"
    except OSError as error:
        complaint = f"cannot be read: {error.strerror or error}"
    except (ValueError, KeyError, TypeError):
        complaint = f"holds no study: its {STUDY} is of another kind"
    raise CaseError([complaint], str(path))


def _refuse_foreign(path: Path) -> None:
    """CaseError where a folder holds anything but a store, so that nothing of others is touched."""
    if not path.exists():
        return
    if not path.is_dir():
        raise CaseError(["is a file; give a folder"], str(path))
    with kept(path):
        names = {entry.name for entry in path.iterdir()}
    if STUDY in names:
        read_record(path)
    elif names and (LOCK not in names or names - OWN):
        strange = ", ".join(sorted(names - OWN)[:3] or sorted(names)[:3])
        raise CaseError([f"is not the folder of a study, it holds {strange}; give a new or empty folder"], str(path))


def _begin(path: Path, study: Study, tile: tuple[int, ...]) -> None:
    """Write everything but the tiles; what a beginning that was interrupted left is removed first."""
    with kept(path):
        for name in (RESULTS, DONE, UNFINISHED):
            if (path / name).exists():
                shutil.rmtree(path / name)
        write_files(path / RESULTS, ZarrFiles(study, tile).first(), path / UNFINISHED)
        (path / DONE).mkdir()
        record = {
            "format": FORMAT,
            "identity": study.identity,
            "study": study.record(),
            "tile": list(tile),
            "made_with": surroundings(),
        }
        lines = [f"{json.dumps(key)}: {json.dumps(record[key], ensure_ascii=False, allow_nan=False)}" for key in record]
        text = "{\n" + ",\n".join(lines) + "\n}\n"
        write_files(path, {STUDY: text.encode()}, path / UNFINISHED)


def _name(index: tuple[int, ...]) -> str:
    return ".".join(map(str, index))
