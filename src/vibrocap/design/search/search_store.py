"""The store of a search: every population that was evaluated, so that an interrupted search continues where it was.

A search is deterministic, so it is resumed by going through it again: populations that are stored are read, the others
are run. The bytes are the same as those of a search that nothing interrupted.
"""

import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import ArgumentError
from vibrocap.files import made_folder, replacing, write_text
from vibrocap.inputs import read_own
from vibrocap.records.reading.arrays import UNREADABLE_NPZ

RECORD, POPULATIONS = "search.json", "populations"
LARGEST = 2**28  # bytes of a file that is read


@dataclasses.dataclass(frozen=True)
class SearchStore:
    """A folder with the record of a search and its populations, `populations/00000.npz` and so on."""

    folder: Path

    def _file(self, number: int) -> Path:
        return self.folder / POPULATIONS / f"{number:05d}.npz"

    def read(self, number: int, like: Mapping[str, np.ndarray]) -> dict[str, np.ndarray] | None:
        """The arrays of a population, if it is stored, whole, and of the same designs in the form of `like`."""
        try:
            with self._file(number).open("rb") as stream, np.load(stream, allow_pickle=False) as stored:
                arrays = {name: stored[name] for name in stored.files}
        except UNREADABLE_NPZ:  # not there, or damaged: it is run again
            return None
        form, wanted = ({name: (x.shape, x.dtype) for name, x in of.items()} for of in (arrays, like))
        return arrays if form == wanted and np.array_equal(arrays["shares"], like["shares"]) else None

    def write(self, number: int, arrays: dict[str, np.ndarray]) -> None:
        """Store the arrays of a population, whole or not at all."""
        with replacing(self._file(number)) as temporary, temporary.open("wb") as stream:
            np.savez(stream, allow_pickle=False, **arrays)  # type: ignore[arg-type]


def opened_store(folder: str | Path, record: dict[str, Any], resume: bool) -> SearchStore:
    """The store in a folder, made where there is none; record: all that decides the populations of the search.

    Raises ArgumentError where the folder holds a search and `resume` is False, or another search.
    """
    folder = Path(folder)
    path, advice = folder / RECORD, "give another folder"
    if path.exists():
        if not resume:
            raise ArgumentError("store", f"{str(folder)!r} holds a search; resume it, or {advice}")
        try:
            before = json.loads(read_own(path, LARGEST))
        except (OSError, ValueError) as error:
            raise ArgumentError("store", f"{str(path)!r} cannot be read as the record of a search ({error})") from None
        if other := [name for name in record if not isinstance(before, dict) or before.get(name) != record[name]]:
            raise ArgumentError("store", f"{str(folder)!r} holds another search (another {', '.join(other)}); {advice}")
    made_folder(folder / POPULATIONS)
    write_text(path, json.dumps(record, indent=2, ensure_ascii=False) + "\n")
    return SearchStore(folder)
