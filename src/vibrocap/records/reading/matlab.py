"""MATLAB files .mat, which a process of their own reads: a damaged one may end whatever process reads it.

The child is this module, run as a script. It is told the files and answers with one message for each: arrays as NumPy
stores them, or what is wrong. Nothing that it says is run.
"""

import io
import json
import subprocess
import sys
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.arguments import lacking
from vibrocap.records.reading import arrays
from vibrocap.records.reading.columns import Table
from vibrocap.records.record import RecordError

DEEPEST = 8  # structures in structures
LONGEST = 120.0  # seconds that a file may take
COMMAND = ("-P", "-m", __name__)  # -P: no modules of the working folder
WANTED = "cannot be read as .mat; should be written by `save` in MATLAB"
_COMPRESSED = 15  # type of a data element of MATLAB 5 to 7.2 that is compressed by zlib
_CONTENT, _REFUSAL = b"C", b"R"


def mat_tables(path: Path) -> list[Table]:
    """The tables of a MATLAB file .mat; see `tables_of`."""
    return arrays.tables_of(mat_files([path])[0], path)


def mat_files(paths: Sequence[Path]) -> list[dict[str, Any]]:
    """The variables of each of several files, which one process reads: arrays without axes of length 1, structures as
    dicts, None for what is neither.

    Versions 4 to 7.2 are read by SciPy, version 7.3 (which is HDF5) by h5py.
    Raises RecordError for one that cannot be read, that ends the process, or that it does not get through in time.
    """
    if not paths:
        return []
    for path in paths:
        arrays.check_plain(path)
    names = [str(Path(path).resolve()) for path in paths]
    command = [sys.executable, *COMMAND, str(arrays.MOST_BYTES), *names]
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, timeout=LONGEST * len(names), check=False
        )
        output, late = done.stdout, False
    except subprocess.TimeoutExpired as error:
        output, late = error.stdout or b"", True
    files, at = [], 0
    for path in paths:
        kind, size = output[at : at + 1], int.from_bytes(output[at + 1 : at + 9], "little")
        content, at = output[at + 9 : at + 9 + size], at + 9 + size
        if kind == _REFUSAL and len(content) == size:
            raise RecordError(json.loads(content), str(path))
        if kind != _CONTENT or len(content) < size:
            reason = f"was not read within {LONGEST:g} s" if late else "ends the program that reads it"
            raise RecordError([f"{reason}, so it is damaged; write it anew by `save` in MATLAB"], str(path))
        files.append(_unpacked(content))
    return files


def _unpacked(content: bytes) -> dict[str, Any]:
    """What the child found in a file."""
    variables: dict[str, Any] = {}
    with np.load(io.BytesIO(content), allow_pickle=False) as stored:
        for number, place in enumerate(json.loads(str(stored["places"]))):
            group = variables
            for name in place[:-1]:
                group = group.setdefault(name, {})
            group[place[-1]] = stored.get(str(number))
    return variables


# --- in the child -----------------------------------------------------------------------------------------------------
def _answer(path: Path) -> bytes:
    """The message on one file."""
    try:
        kind, content = _CONTENT, _packed(content_of(path))
    except RecordError as error:
        kind, content = _REFUSAL, json.dumps(error.complaints).encode()
    return kind + len(content).to_bytes(8, "little") + content


def _packed(variables: Mapping[str, Any]) -> bytes:
    """Variables as NumPy stores arrays: numbers and text, by their number among the places."""
    places, stored = [], {}
    for place, value in _leaves(variables, ()):
        array = None if isinstance(value, list) else np.asarray(value)
        if array is not None and (array.dtype.kind in "fiuU" or (array.dtype.names and not array.dtype.hasobject)):
            stored[str(len(places))] = array
        places.append(place)
    file = io.BytesIO()
    np.savez(file, places=json.dumps(places), **stored)
    return file.getvalue()


def _leaves(values: Mapping[str, Any], place: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any]]:
    for name, value in values.items():
        if isinstance(value, Mapping) and value:
            yield from _leaves(value, (*place, name))
        else:
            yield (*place, name), value


def content_of(path: Path) -> dict[str, Any]:
    """The variables of a MATLAB file, read here."""
    from scipy.io import loadmat

    try:
        arrays.check_size(_unpacked_size(path), path)
        content = loadmat(path, squeeze_me=True, simplify_cells=True)
    except NotImplementedError:
        return _variables_7_3(path)
    except RecordError:
        raise
    except Exception:  # whatever a reader raises on damage
        raise RecordError([WANTED], str(path)) from None
    return {name: value for name, value in content.items() if not name.startswith("__")}


def _variables_7_3(path: Path) -> dict[str, Any]:
    if advice := lacking("h5py"):
        wanted = f"is a .mat of version 7.3 (HDF5), which {advice}, or save it in MATLAB with the option '-v7'"
        raise RecordError([wanted], str(path))
    import h5py

    size = 0

    def content(group: Any, depth: int) -> dict[str, Any]:
        nonlocal size
        members: dict[str, Any] = {}
        for name in group:
            if not isinstance(group.get(name, getlink=True), h5py.HardLink):
                raise RecordError([f"{name}: is a link to elsewhere; should be stored in the file itself"], str(path))
            item = group[name]
            if isinstance(item, h5py.Group) and not name.startswith("#"):
                if depth == DEEPEST:
                    raise RecordError([f"{name}: should not be nested deeper than {DEEPEST} structures"], str(path))
                members[name] = content(item, depth + 1)
            elif isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu":
                if item.external or item.is_virtual:
                    raise RecordError([f"{name}: should be stored in the file itself, not in another"], str(path))
                size += item.nbytes
                arrays.check_size(size, path)
                members[name] = np.squeeze(np.asarray(item).T)  # MATLAB stores columns first
        return members

    try:
        with h5py.File(path, "r") as file:
            return content(file, 0)
    except RecordError:
        raise
    except Exception:  # whatever a reader raises on damage
        raise RecordError(["cannot be read as .mat of version 7.3 (HDF5)"], str(path)) from None


def _unpacked_size(path: Path) -> int:
    """Bytes to which a .mat file of versions 5 to 7.2 unpacks, counted as far as is allowed."""
    size = path.stat().st_size
    with path.open("rb") as file:
        order = {b"IM": "little", b"MI": "big"}.get(file.read(128)[126:128])
        while order and len(tag := file.read(8)) == 8:
            kind, length = (int.from_bytes(part, order) for part in (tag[:4], tag[4:]))  # type: ignore[arg-type]
            if kind != _COMPRESSED:
                file.seek(length, 1)
                continue
            end, unpacker = file.tell() + length, zlib.decompressobj()
            while (
                size <= arrays.MOST_BYTES and not unpacker.eof and (piece := file.read(min(65_536, end - file.tell())))
            ):
                while piece and size <= arrays.MOST_BYTES:
                    size += len(unpacker.decompress(piece, 2**24))
                    piece = unpacker.unconsumed_tail
            file.seek(end)
    return size


if __name__ == "__main__":
    arrays.MOST_BYTES = int(sys.argv[1])
    for path in sys.argv[2:]:
        sys.stdout.buffer.write(_answer(Path(path)))
        sys.stdout.buffer.flush()
