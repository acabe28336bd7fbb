"""A store: the folder in which a study's results are kept, tile by tile, so that it can go on after anything.

    study.json      the study (enough to run it again), its identity, its tiles, and the checksums of the files without
                    tiles; the last to be written at first
    results.zarr/   the results: a Zarr group, version 3, one array per variable, one chunk per tile
    done/           a file per tile that is stored, named by its place, such as "3.0", with the checksums of its chunks
    lock            held by the process that writes
    unfinished/     files on their way; gone when no one writes
    beginning       there until study.json is: what is beside it may be begun anew
    mixed           there where some tiles were computed with something else than the study was begun with

Each file is written elsewhere, forced to the disk and then renamed to its place, and a tile's mark comes after its
chunks. So a tile either is marked and whole, or is computed again to the same bytes. Nothing in a store tells the time
or the order of writing: a store that was interrupted and resumed equals an uninterrupted one, file by file.

The Zarr files are made in memory, and are all that `zarr_form` lets in again: so little of Zarr that it is written
directly, to the bytes that Zarr 3 would write (a test compares them), as a small sweep is done before Zarr is imported.
"""

import dataclasses
import functools
import json
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.case.case import CaseError
from vibrocap.studies.plan.code_version import surroundings
from vibrocap.studies.plan.differences import code_differences, differences
from vibrocap.studies.plan.study import FORMAT, Study
from vibrocap.studies.store.checksums import checksum
from vibrocap.studies.store.marks import Index, mark_text, tile_name
from vibrocap.studies.store.record import (
    BEGINNING,
    DONE,
    LOCK,
    MIXED,
    RESULTS,
    STUDY,
    UNFINISHED,
    read_record,
    record_text,
)
from vibrocap.studies.store.verification import Verification, verified
from vibrocap.studies.store.writing import Lock, StoreError, force_names, kept, write_files
from vibrocap.studies.store.zarr_form import METADATA, checked_results
from vibrocap.studies.tile import tile_block, tile_indices
from vibrocap.studies.variables import TEXT, axis_values, coordinate_attributes, study_attributes, variables

COMPRESSION = 3  # level of zstd: measures hardly shrink further


class ZarrFiles:
    """Encodes the results of a study: `first` once, `chunks` for each tile. The same input gives the same bytes."""

    def __init__(self, study: Study, tile: tuple[int, ...]):
        self.study, self.tile = study, tile
        self._variables = variables(study)

    @property
    def names(self) -> tuple[str, ...]:
        """The arrays that are stored tile by tile."""
        return tuple(each.name for each in self._variables)

    def first(self) -> dict[str, bytes]:
        """Every file but those of the tiles, by its place in the group's folder."""
        plan = self.study.plan
        attributes = study_attributes(self.study)
        if not plan.gridded:
            attributes["coordinates"] = " ".join(plan.paths)
        found = {METADATA: _text({"attributes": attributes, "zarr_format": 3, "node_type": "group"})}
        for path, values in axis_values(self.study).items():
            described = coordinate_attributes(path, self.study.case.system)
            fill = "" if values.dtype == TEXT else np.nan
            shape = values.shape
            found[f"{path}/{METADATA}"] = _array_text(values.dtype, fill, shape, shape, (path,), described)
            found[f"{path}/c.0"] = _chunk(values)
        for each in self._variables:
            form = (plan.shape, self.tile, plan.dims, each.stored_attributes)
            found[f"{each.name}/{METADATA}"] = _array_text(each.dtype, each.fill, *form)
        return found

    def chunks(self, index: tuple[int, ...], arrays: Mapping[str, np.ndarray]) -> dict[str, bytes]:
        """The files of one tile, by their place; arrays: as `run_tile` gives them."""
        lengths = [block.stop - block.start for block in tile_block(self.study.plan.shape, self.tile, index)]
        there = tuple(slice(0, length) for length in lengths)
        found = {}
        for each in self._variables:
            chunk = each.empty(self.tile)  # whole, also where the tile is cut by the edge
            chunk[there] = arrays[each.name]
            found[f"{each.name}/c.{'.'.join(map(str, index))}"] = _chunk(chunk)
        return found


def _array_text(
    dtype: Any,
    fill: Any,
    shape: tuple[int, ...],
    chunk: tuple[int, ...],
    dims: tuple[str, ...],
    attributes: Mapping[str, Any],
) -> bytes:
    """The file that says what an array is."""
    dtype = np.dtype(dtype)
    own: dict[str, Any] = {"name": "bytes"}
    if dtype == TEXT:
        own = {"name": "vlen-utf8", "configuration": {}}
    elif dtype.itemsize > 1:
        own["configuration"] = {"endian": "little"}
    return _text(
        {
            "shape": list(shape),
            "data_type": "string" if dtype == TEXT else dtype.name,
            "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": list(chunk)}},
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
            "fill_value": "NaN" if fill != fill else fill,
            "codecs": [own, {"name": "zstd", "configuration": {"level": COMPRESSION, "checksum": True}}],
            "attributes": dict(attributes),
            "dimension_names": list(dims),
            "zarr_format": 3,
            "node_type": "array",
            "storage_transformers": [],
        }
    )


def _text(entries: Mapping[str, Any]) -> bytes:
    return json.dumps(entries, indent=2).encode()


def _chunk(values: np.ndarray) -> bytes:
    """The file of the values of a chunk."""
    from numcodecs.zstd import compress

    if values.dtype == TEXT:
        from numcodecs.vlen import VLenUTF8

        data = VLenUTF8().encode(values.astype(object))
    else:
        data = np.ascontiguousarray(values, values.dtype.newbyteorder("<")).tobytes()
    return bytes(compress(data, COMPRESSION, checksum=True))


OWN = {STUDY, RESULTS, DONE, LOCK, UNFINISHED, BEGINNING, MIXED}


class Store:
    """The folder of one study's results; `opened_for_writing` gives one to its one writer.

    study: as it was begun. made_by: with what tiles are computed now, where that is something else; each says so.
    """

    def __init__(
        self,
        path: Path,
        study: Study,
        tile: tuple[int, ...],
        lock: Lock | None = None,
        made_by: Mapping[str, str] | None = None,
    ):
        self.path, self.study, self.tile, self.made_by = path, study, tile, made_by
        self._lock = lock

    @functools.cached_property
    def _files(self) -> ZarrFiles:
        return ZarrFiles(self.study, self.tile)

    @property
    def indices(self) -> Iterator[Index]:
        """All tiles, in C order."""
        return tile_indices(self.study.plan.shape, self.tile)

    def pending(self) -> list[Index]:
        """The tiles that are not stored yet."""
        with kept(self.path):
            done = {entry.name for entry in (self.path / DONE).iterdir()}
        return [index for index in self.indices if tile_name(index) not in done]

    def is_done(self, index: Index) -> bool:
        """Whether a tile is stored."""
        return (self.path / DONE / tile_name(index)).exists()

    def check_place(self) -> None:
        """StoreError where the folder is no longer there, or another one."""
        if self._lock is not None:
            self._lock.check()

    def write(self, index: Index, arrays: Mapping[str, np.ndarray]) -> None:
        """Store a tile; StoreError, with nothing lost that was stored before, where the folder does not take it."""
        self.check_place()
        chunks = self._files.chunks(index, arrays)
        mark = mark_text(self.study.identity, index, chunks, self.made_by)
        with kept(self.path):
            write_files(self.path / RESULTS, chunks, self.path / UNFINISHED)
            write_files(self.path / DONE, {tile_name(index): mark}, self.path / UNFINISHED)

    def check_whole(self) -> None:
        """StoreError where a file of some tile is no longer there; to be asked when all are stored."""
        self.check_place()
        with kept(self.path):
            there = {name: {file.name for file in (self.path / RESULTS / name).iterdir()} for name in self._files.names}
        pending = self.pending()
        lost = [each for each in self.indices if any(f"c.{tile_name(each)}" not in names for names in there.values())]
        if gone := dict.fromkeys([*pending, *lost]):
            few = ", ".join(tile_name(index) for index in list(gone)[:5]) + (" ..." if len(gone) > 5 else "")
            raise StoreError(
                f"{self.path}: was changed by others while the study ran: files of {len(gone):,} tiles are gone "
                f"({few}). --resume (resume=True) computes these again"
            )

    def mend(self, found: Verification) -> None:
        """Let go of damaged tiles, so that they are computed again, and write anew what belongs to no tile."""
        first = self._files.first()
        record = read_record(self.path)
        with kept(self.path):
            for index in found.damaged:
                (self.path / DONE / tile_name(index)).unlink()
            if not found.others:
                return
            (self.path / DONE).mkdir(exist_ok=True)
            for name in {entry.name for entry in (self.path / DONE).iterdir()} - set(map(tile_name, self.indices)):
                (self.path / DONE / name).unlink()
            if record["files"] != _checksums(record["identity"], first):
                raise CaseError([*found.others, "this version of Zarr cannot make it anew"], str(self.path))
            for place in first:
                (self.path / RESULTS / place).parent.mkdir(parents=True, exist_ok=True)
            write_files(self.path / RESULTS, first, self.path / UNFINISHED)
        checked_results(self.path, record)

    def clean(self) -> None:
        """Remove what unfinished writing left."""
        with kept(self.path):
            if (self.path / UNFINISHED).exists():
                shutil.rmtree(self.path / UNFINISHED)
            (self.path / BEGINNING).unlink(missing_ok=True)


@dataclasses.dataclass(frozen=True)
class Opened:
    """A store to be written: the lock on it, which is to be released, and what was found damaged in it."""

    store: Store
    lock: Lock
    damage: tuple[str, ...] = ()


def opened_for_writing(path: Path, study: Study, tile: tuple[int, ...], *, resume: bool, mixed: bool = False) -> Opened:
    """The store of a study, begun or resumed.

    A store that is resumed keeps its own tiles. What is stored is compared with its checksums: damaged tiles are let
    go, and will be computed again. mixed: go on with another code, processor or library than the study was begun with;
    the tiles to come say so. Raises CaseError where the folder is not for this study, StoreError where it cannot
    be written.
    """
    _refuse_foreign(path)
    with kept(path):
        path.mkdir(parents=True, exist_ok=True)
        lock = Lock(path / LOCK)
    try:
        if not (path / STUDY).exists():
            _begin(path, study, tile)
            return Opened(Store(path, study, tile, lock), lock)
        if not resume:
            raise CaseError(["holds a study already; go on with --resume, or give another folder"], str(path))
        record = read_record(path)
        if record["format"] != FORMAT:
            reason = "which can be read but not gone on with: begin anew"
            raise CaseError([f"is of an earlier format ({record['format']!r}), {reason}"], str(path))
        begun = dataclasses.replace(study, code=record["study"]["code"])
        if record["identity"] != begun.identity:
            found = differences(record["study"], study.record()) or ["its identity"]
            raise CaseError([f"holds another study: {text}" for text in found], str(path))
        other = code_differences(begun.code, study.code)
        if other and not mixed:
            found = [f"was begun with something else: {text}" for text in other]
            ways = "begin anew, or go on with --mixed (mixed=True), which marks what is computed now"
            raise CaseError([*found, f"the rest would not have the bits that it had there; {ways}"], str(path))
        store = Store(path, begun, tuple(record["tile"]), lock, study.code if other else None)
        store.clean()
        if other:
            with kept(path):
                (path / MIXED).touch()
        with kept(path):
            verification = verified(path, record)
        if not verification.ok:
            store.mend(verification)
        return Opened(store, lock, tuple(verification.lines()))
    except BaseException:
        lock.release()
        raise


def _refuse_foreign(path: Path) -> None:
    """CaseError where a folder holds anything but a store, or what is left of one: nothing is wiped unasked."""
    if not path.exists():
        return
    if not path.is_dir():
        raise CaseError(["is a file; give a folder"], str(path))
    with kept(path):
        names = {entry.name for entry in path.iterdir()}
    if STUDY in names:
        read_record(path)
        return
    if strange := sorted(names - OWN):
        listed = ", ".join(strange[:3])
        raise CaseError([f"is not the folder of a study, it holds {listed}; give a new or empty folder"], str(path))
    if BEGINNING not in names and names - {LOCK}:
        reason = f"its {STUDY} is lost; nothing there was touched. Give another folder, or remove it"
        raise CaseError([f"holds results, but {reason}"], str(path))


def _begin(path: Path, study: Study, tile: tuple[int, ...]) -> None:
    """Write everything but the tiles; what a beginning that was interrupted left is removed first."""
    with kept(path):
        if any((path / name).exists() for name in (RESULTS, DONE, UNFINISHED)) and not (path / BEGINNING).exists():
            raise CaseError([f"its {STUDY} is lost; nothing there was touched"], str(path))  # since it was looked at
        for name in (RESULTS, DONE, UNFINISHED):
            if (path / name).exists() and (path / BEGINNING).exists():
                shutil.rmtree(path / name)
        (path / BEGINNING).touch()
        force_names(path)
        first = ZarrFiles(study, tile).first()
        for place in first:
            (path / RESULTS / place).parent.mkdir(parents=True, exist_ok=True)
        write_files(path / RESULTS, first, path / UNFINISHED)
        (path / DONE).mkdir()
        record: dict[str, Any] = {
            "format": FORMAT,
            "identity": study.identity,
            "study": study.record(),
            "tile": list(tile),
            "files": _checksums(study.identity, first),
            "made_with": surroundings(),
        }
        write_files(path, {STUDY: record_text(record)}, path / UNFINISHED)
        (path / BEGINNING).unlink()


def _checksums(identity: str, files: Mapping[str, bytes]) -> dict[str, str]:
    return {place: checksum(identity, place, data) for place, data in files.items()}
