"""Verification: whether a store is as it was written, tile by tile."""

import dataclasses
import functools
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

from vibrocap.case.case import CaseError
from vibrocap.studies.store.places import DONE, LOCK, RESULTS, STRANGE, STUDY, names, strange_places, why_strange
from vibrocap.studies.store.record import (
    DamagedRecord,
    DamageError,
    Index,
    is_finished,
    plan_of,
    read_chunk,
    read_first,
    read_mark,
    read_record,
    tile_name,
)
from vibrocap.studies.store.zarr_form import checked_results, expected_arrays, first_places, strange_names
from vibrocap.studies.tile import tile_indices

READERS = 8  # threads: reading waits for the disk, and checksums are made side by side


@dataclasses.dataclass(frozen=True)
class Verification:
    """What was found of a store.

    tiles: how many the study has; stored: how many of them have a mark
    damaged: what is wrong with a stored tile, by its place, such as (3, 0); `sweep` with `resume` computes them again
    others: what is wrong with files that belong to no tile
    mixed: tiles that were computed with something else than the study was begun with
    """

    path: Path
    tiles: int
    stored: int
    damaged: Mapping[Index, str]
    others: tuple[str, ...] = ()
    mixed: tuple[Index, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether all that is stored is as it was written; a study need not be finished for that."""
        return not self.damaged and not self.others

    @property
    def finished(self) -> bool:
        """Whether all is stored and as it was written."""
        return self.ok and self.stored == self.tiles

    def lines(self, most: int = 20) -> list[str]:
        """What is damaged, a line each; beyond so many their number."""
        lines = [*self.others, *(f"tile {tile_name(index)}: {what}" for index, what in self.damaged.items())]
        rest = len(lines) - most
        return lines if rest <= 0 else [*lines[:most], f"and {rest:,} more"]


def verify_study(path: str | Path) -> Verification:
    """Compare everything that a stored study holds with its checksums, finished or not.

    path: the folder of a study, as `sweep` writes it to `out`. A chunk that is missing, cut short, altered, or in the
    place of another one is found, and so is a lost or altered study.json.

    Raises CaseError (a ValueError) where there is no study, or one that this package did not write; OSError where
    something cannot be read.
    """
    path = Path(path)
    try:
        record = read_record(path)
    except DamagedRecord as error:
        return Verification(path, 0, 0, {}, tuple(error.complaints))
    except CaseError:
        if not (path / STUDY).exists() and (path / RESULTS).is_dir() and (path / LOCK).exists():
            return Verification(path, 0, 0, {}, (f"its {STUDY} is missing",))
        raise
    return verified(path, record)


def verified(path: Path, record: Mapping[str, Any]) -> Verification:
    """The same of a store whose study.json was read."""
    arrays = expected_arrays(record)
    if strange := strange_names(path, arrays):
        raise CaseError(strange, str(path))
    others, finished, marked = list[str](), False, set[str]()
    looks = [functools.partial(read_first, path, record, place) for place in first_places(record)]
    for look in (*looks, functools.partial(is_finished, path, record)):
        try:
            finished = look() is True
        except DamageError as error:
            others.append(str(error))
    if not others:
        checked_results(path, record)  # as it was written, but perhaps not by this package
    shape, measured = plan_of(record).shape, [name for name, array in arrays.items() if array.along_runs]
    indices = list(tile_indices(shape, tuple(record["tile"])))
    try:
        marked = set(names(path, DONE))
    except FileNotFoundError:
        others.append(f"{DONE} is missing")
    except OSError as error:
        if error.errno not in STRANGE:
            raise
        others.append(f"{DONE} {why_strange(error)}")
    strange = marked - {tile_name(index) for index in indices}
    others += [f"{DONE}/{name} does not belong to the study" for name in sorted(strange)]
    others += [place for place in strange_places(path) if place not in others]
    stored = [index for index in indices if tile_name(index) in marked]
    looked_at = indices if finished else stored
    damaged: dict[Index, str] = {}
    mixed: list[Index] = []
    with ThreadPoolExecutor(READERS) as pool:
        looks = pool.map(lambda index: _tile(path, record, measured, index), looked_at)
        for index, (what, other) in zip(looked_at, looks, strict=True):
            if what:
                damaged[index] = what
            elif other:
                mixed.append(index)
    return Verification(path, len(indices), len(stored), damaged, tuple(others), tuple(mixed))


def _tile(path: Path, record: Mapping[str, Any], names: Sequence[str], index: Index) -> tuple[str, bool]:
    """(what is wrong with a stored tile, whether it was computed with something else)."""
    wrong = []
    try:
        mark = read_mark(path, record, index)
    except DamageError as error:
        return str(error), False
    if mark is None:
        return "its mark is missing", False
    for name in names:
        try:
            read_chunk(path, record, name, index, mark)
        except DamageError as error:
            wrong.append(str(error))
    return ", ".join(wrong), mark.made_by is not None
