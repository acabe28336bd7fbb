"""A store: the folder in which a study's results are kept, tile by tile, so that it can resume after anything.

    study.json      the study (enough to run it again), its identity, its tiles, and the checksums of the files without
                    tiles; the last to be written at first
    results.zarr/   the results: a Zarr group, version 3, one array per variable, one chunk per tile
    done/           a file per tile that is stored, named by its place, such as "3.0", with the checksums of its chunks
    lock            held by the process that writes
    unfinished/     files on their way; gone when no one writes
    beginning       study.json before all that it tells of is there; what it tells of may be begun anew
    finished        there since all tiles were stored: from then on, a tile without a mark has lost it
    mixed           there where some tiles were computed with other sources, libraries or processor than the first

Each file is written elsewhere, forced to the disk and then renamed to its place, and a tile's mark comes after its
chunks. So a tile either is marked and whole, or is computed again to the same bytes. Nothing in a store tells the time
or the order of writing: a store that was interrupted and resumed equals an uninterrupted one, file by file.
"""

import dataclasses
import functools
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.case.case import CaseError
from vibrocap.studies.plan.study import FORMAT, Study, code_differences, differences, surroundings
from vibrocap.studies.store import places
from vibrocap.studies.store.chunks import ZarrFiles
from vibrocap.studies.store.places import BEGINNING, DONE, FILE, FINISHED, FOLDER, LOCK, MIXED, RESULTS, STUDY
from vibrocap.studies.store.record import (
    LARGEST,
    Index,
    checksum,
    finished_text,
    is_mark,
    mark_text,
    read_record,
    record_text,
    tile_name,
)
from vibrocap.studies.store.verification import Verification, verified
from vibrocap.studies.store.zarr_form import checked_results
from vibrocap.studies.tile import tile_indices


class Store:
    """The folder of one study's results; `opened_for_writing` gives one to its one writer. study: as it was begun."""

    def __init__(self, path: Path, study: Study, tile: tuple[int, ...], lock: places.Lock):
        self.path, self.study, self.tile, self._lock = path, study, tile, lock

    @functools.cached_property
    def _files(self) -> ZarrFiles:
        return ZarrFiles(self.study, self.tile)

    @property
    def indices(self) -> Iterator[Index]:
        return tile_indices(self.study.plan.shape, self.tile)

    def pending(self) -> list[Index]:
        with places.kept(self.path):
            done = places.names(self.path, DONE)
        return [index for index in self.indices if tile_name(index) not in done]

    def write(self, index: Index, arrays: Mapping[str, np.ndarray], made_by: Mapping[str, str] | None = None) -> None:
        """Store a tile; StoreError, with nothing lost that was stored before, where the folder does not take it.

        made_by: with what it was computed, where that is not with what the study was begun; the tile says so
        """
        self._lock.check()
        chunks = self._files.chunks(index, arrays)
        mark = mark_text(self.study.identity, index, chunks, made_by)
        with places.kept(self.path):
            if made_by and places.kind(self.path, MIXED) is None:
                places.write(self.path, {MIXED: b""})
            places.write(self.path, _among_results(chunks))
            places.write(self.path, {f"{DONE}/{tile_name(index)}": mark})

    def finish(self) -> None:
        """Say in the store that all tiles are there; StoreError where a file of one is not."""
        self._lock.check()
        with places.kept(self.path):
            there = {name: places.names(self.path, f"{RESULTS}/{name}") for name in self._files.names}
        pending = self.pending()
        lost = [index for index in self.indices if any(f"c.{tile_name(index)}" not in kept for kept in there.values())]
        if gone := dict.fromkeys([*pending, *lost]):
            few = ", ".join(tile_name(index) for index in list(gone)[:5]) + (" ..." if len(gone) > 5 else "")
            raise places.StoreError(
                f"{self.path}: was changed by others while the study ran: files of {len(gone):,} tiles are gone "
                f"({few}). --resume (resume=True) computes these again"
            )
        with places.kept(self.path):
            if places.kind(self.path, FINISHED) is None:
                places.write(self.path, {FINISHED: finished_text(self.study.identity, sum(1 for _ in self.indices))})
        self.clean()

    def mend(self, verification: Verification) -> None:
        """Let go of damaged tiles, so that they are computed again, and write anew what belongs to no tile."""
        first = self._files.first()
        record = read_record(self.path)
        with places.kept(self.path):
            for tile in map(tile_name, verification.damaged):
                places.remove(self.path, f"{DONE}/{tile}")
                self._remove_folders(f"{name}/c.{tile}" for name in self._files.names)
            if not verification.others:
                return
            if record["files"] != _checksums(record["identity"], first):
                raise CaseError([*verification.others, "this version of Zarr cannot make it anew"], str(self.path))
            places.make_folder(self.path, DONE)
            for name in places.names(self.path, DONE).keys() - set(map(tile_name, self.indices)):
                places.remove(self.path, f"{DONE}/{name}")
            places.remove(self.path, FINISHED)
            self._remove_folders(first)
            _write_first(self.path, first)
        checked_results(self.path, record)

    def _remove_folders(self, files: Iterable[str]) -> None:
        """Remove empty folders in the places of files of the results."""
        for place in (f"{RESULTS}/{file}" for file in files):
            if places.kind(self.path, place) == FOLDER:
                places.remove(self.path, place)

    def refuse_strange(self) -> None:
        """CaseError where the folder holds what this package has not written; damaged files of its own are none."""
        with places.kept(self.path):
            marks = places.names(self.path, DONE) if places.kind(self.path, DONE) == FOLDER else {}
            others = [name for name in marks.keys() - set(map(tile_name, self.indices)) if not is_mark(self.path, name)]
        _refuse_strange(self.path, [f"{DONE}/{name} does not belong to the study" for name in sorted(others)])

    def clean(self) -> None:
        """Remove what unfinished writing left."""
        with places.kept(self.path):
            places.remove_unfinished(self.path)


@dataclasses.dataclass(frozen=True)
class Opened:
    """A store to be written: the lock on it, which is to be released, and what was found damaged in it.

    made_by: with what tiles are computed here, where that is not with what the study was begun
    """

    store: Store
    lock: places.Lock
    damage: tuple[str, ...] = ()
    made_by: Mapping[str, str] | None = None


def opened_for_writing(path: Path, study: Study, tile: tuple[int, ...], *, resume: bool, mixed: bool = False) -> Opened:
    """The store of a study, begun or resumed.

    A store that is resumed keeps its own tiles. What is stored is compared with its checksums: damaged tiles are let
    go, and will be computed again. mixed: continue with another code, processor or library than the study began with;
    the tiles to come say so. Raises CaseError where the folder is not for this study, StoreError where it cannot
    be written.
    """
    _refuse_foreign(path)
    with places.kept(path):
        path.mkdir(parents=True, exist_ok=True)
        lock = places.Lock(path / LOCK)
    try:
        if places.kind(path, STUDY) is None:
            _begin(path, study, tile)
            return Opened(Store(path, study, tile, lock), lock)
        if not resume:
            raise CaseError(["holds a study already; continue with --resume, or give another folder"], str(path))
        record = read_record(path)
        begun = dataclasses.replace(study, code=record["study"]["code"])
        if record["identity"] != begun.identity:
            reasons = differences(record["study"], study.record()) or ["its identity"]
            raise CaseError([f"holds another study: {text}" for text in reasons], str(path))
        other = code_differences(begun.code, study.code)
        if other and not mixed:
            reasons = [f"has other sources, libraries or processor: {text}" for text in other]
            ways = "begin anew, or continue with --mixed (mixed=True), which marks the new tiles"
            raise CaseError([*reasons, f"the rest would not have the bits that it had there; {ways}"], str(path))
        store = Store(path, begun, tuple(record["tile"]), lock)
        store.refuse_strange()
        store.clean()
        with places.kept(path):
            verification = verified(path, record)
        if not verification.ok:
            store.mend(verification)
        return Opened(store, lock, tuple(verification.lines()), study.code if other else None)
    except BaseException:
        lock.release()
        raise


def _refuse_foreign(path: Path) -> None:
    """CaseError where a folder holds anything but a store, or what is left of one: nothing is wiped unasked."""
    if path.is_symlink() and not path.exists():
        raise CaseError(["is a link that leads nowhere; give a folder"], str(path))
    if path.exists() and not path.is_dir():
        raise CaseError(["is a file; give a folder"], str(path))
    with places.kept(path):
        try:
            there = places.names(path)
        except FileNotFoundError:
            return
    if there.get(LOCK, FILE) != FILE:
        raise CaseError([f"its {LOCK} is {there[LOCK]}, where a file belongs; nothing was touched"], str(path))
    if STUDY in there:
        read_record(path)
        return
    if strange := sorted(there.keys() - places.FORM.keys()):
        listed = ", ".join(strange[:3])
        raise CaseError([f"is not the folder of a study, it holds {listed}; give a new or empty folder"], str(path))
    if BEGINNING not in there and there.keys() - {LOCK, places.UNFINISHED}:
        reason = f"its {STUDY} is lost; nothing there was touched. Give another folder, or remove it"
        raise CaseError([f"holds results, but {reason}"], str(path))


def _refuse_strange(path: Path, others: Iterable[str] = ()) -> None:
    """CaseError where a folder holds what this package has not written and would have to pass, remove or overwrite."""
    with places.kept(path):
        strange = [*places.strange_places(path), *others]
    if strange:
        few = strange if len(strange) < 6 else [*strange[:5], f"and {len(strange) - 5:,} more"]
        raise CaseError([*few, "vibrocap wrote no such thing; nothing was touched. Remove it and continue"], str(path))


def _begin(path: Path, study: Study, tile: tuple[int, ...]) -> None:
    """Write everything but the tiles; what a beginning that was interrupted left is removed first."""
    _refuse_strange(path)
    with places.kept(path):
        there = places.names(path)
        if BEGINNING in there:
            _remove_begun(path)
        elif {RESULTS, DONE} & there.keys():
            raise CaseError([f"its {STUDY} is lost; nothing there was touched"], str(path))  # since it was looked at
        places.remove_unfinished(path)
        first = ZarrFiles(study, tile).first()
        record: dict[str, Any] = {
            "format": FORMAT,
            "identity": study.identity,
            "study": study.record(),
            "tile": list(tile),
            "files": _checksums(study.identity, first),
            "made_with": surroundings(),
        }
        places.write(path, {BEGINNING: record_text(record)})
        _write_first(path, first)
        places.make_folder(path, DONE)
        places.rename(path, BEGINNING, STUDY)


def _remove_begun(path: Path) -> None:
    """Remove what a beginning wrote, after a look at all of it; CaseError where anything else is there."""
    record = read_record(path, BEGINNING)
    files, folders = [], [f"{RESULTS}/{name}" for name, place in _in(path, RESULTS).items() if place == FOLDER]
    strange = [f"{DONE}/{name}" for name in _in(path, DONE)]
    for folder in (RESULTS, *folders):
        for name in (name for name, place in _in(path, folder).items() if place == FILE):
            place = f"{folder}/{name}".removeprefix(f"{RESULTS}/")
            data = places.read_plain(path, f"{folder}/{name}", LARGEST)
            own = record["files"].get(place) == checksum(record["identity"], place, data)
            (files if own else strange).append(f"{folder}/{name}")
    _refuse_strange(path, [f"{place} does not belong to this study" for place in strange])
    for place in (*files, *folders, RESULTS, DONE):
        places.remove(path, place)


def _in(path: Path, place: str) -> dict[str, str]:
    return places.names(path, place) if places.kind(path, place) == FOLDER else {}


def _write_first(path: Path, first: Mapping[str, bytes]) -> None:
    """Write the files that belong to no tile, and the folders of all."""
    places.make_folder(path, RESULTS)
    for place in first:
        if "/" in place:
            places.make_folder(path, f"{RESULTS}/{place.partition('/')[0]}")
    places.write(path, _among_results(first))


def _among_results(files: Mapping[str, bytes]) -> dict[str, bytes]:
    return {f"{RESULTS}/{place}": data for place, data in files.items()}


def _checksums(identity: str, files: Mapping[str, bytes]) -> dict[str, str]:
    return {place: checksum(identity, place, data) for place, data in files.items()}
