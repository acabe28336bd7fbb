"""NetCDF files, written whole or not at all."""

import io
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.files import replacing

if TYPE_CHECKING:
    import xarray

IN_MEMORY = 2**28  # bytes of the values in a dataset, up to which its file is made in memory


def write_netcdf(dataset: "xarray.Dataset", path: Path) -> None:
    """Write a dataset; the same dataset gives the same bytes. WriteError where the disk does not take it.

    Every array of numbers has checksums (Fletcher 32) that each reader of HDF5 looks at: damage is an error, no number.

    HDF5, which makes the file, never meets an error of the disk: it may take the whole process down with it. The file
    of a dataset of up to 256 MiB is made in memory, which takes about as much once more, and written when it is whole.
    A larger one is written as it is made, what is held in Dask arrays block by block. Then memory does not grow with
    it, unless the disk is full: what HDF5 writes from there to the end of the block is held in memory, and lost.
    """
    with replacing(path) as temporary:
        if dataset.nbytes <= IN_MEMORY:
            memory = io.BytesIO()
            _write(dataset, memory)
            temporary.write_bytes(memory.getbuffer())
        else:
            with temporary.open("w+b", buffering=0) as file:
                disk = _Disk(file)
                try:
                    _write(dataset, disk, disk.check)
                finally:
                    disk.check()


def _write(dataset: "xarray.Dataset", target: Any, check: Callable[[], None] = lambda: None) -> None:
    """Write to a binary file that is open; check: called before each block, to end the writing with an error."""
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    arrays = {name: variable for name, variable in dataset.variables.items() if variable.dims and variable.size}
    checked = {name: {"fletcher32": True} for name, array in arrays.items() if array.dtype.kind in "biuf"}
    with h5netcdf.File(target, "w") as file:
        dataset.dump_to_store(H5NetCDFStore(file), writer=_InOrder(check), encoding=checked)


class _InOrder:
    """Writes one array after the other, each from its first block to its last, as HDF5 places them in a file.

    It stands for the ArrayWriter of xarray, which has Dask write blocks in an order that changes from run to run.
    """

    def __init__(self, check: Callable[[], None]):
        self._check = check

    def add(self, source: Any, target: Any, region: Any = None) -> None:
        """Write an array. region: the part of the target that it fills, or None, for all of it."""
        if getattr(source, "chunks", None) is None:
            self._check()
            target[... if region is None else region] = source
            return
        from dask.array.core import slices_from_chunks

        for block in slices_from_chunks(source.chunks):
            self._check()
            target[block] = source[block].compute(scheduler="synchronous")


class _Disk(io.RawIOBase):
    """A file on the disk, open and empty, that takes everything, as its user sees it.

    After the first error of the disk, which `check` raises, nothing more goes there: what is written later is kept in
    memory, and read as if it were in the file. For HDF5 holds what it could not write, tries again when a file is
    closed, and a process does not survive that it fails again, or that it reads other bytes than it wrote.
    """

    def __init__(self, file: Any):
        super().__init__()
        self._file = file
        self._error: OSError | None = None
        self._later: list[tuple[int, bytes]] = []  # (place, what was written there) since the error, in order
        self._at = self._end = 0

    def check(self) -> None:
        """Raise the first error of the disk, if there was one."""
        if self._error is not None:
            raise self._error

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Go to a place."""
        self._at = offset + {io.SEEK_SET: 0, io.SEEK_CUR: self._at, io.SEEK_END: self._end}[whence]
        return self._at

    seekable = readable = writable = lambda self: True

    def write(self, data: Any) -> int:
        """All of the data, on the disk or, after an error, in memory."""
        view = memoryview(data).cast("B")
        rest, place = view, self._at
        try:
            self._file.seek(place)
            while rest and self._error is None:
                rest = rest[self._file.write(rest) or 0 :]
        except OSError as error:
            self._error = error
        if rest:
            self._later.append((place + len(view) - len(rest), bytes(rest)))
        self._at = place + len(view)
        self._end = max(self._end, self._at)
        return len(view)

    def readinto(self, buffer: Any) -> int:
        """What was written, zeros where nothing was."""
        view = memoryview(buffer).cast("B")
        size = max(0, min(len(view), self._end - self._at))
        self._file.seek(self._at)
        content = bytearray(self._file.read(size) or b"")
        content.extend(bytes(size - len(content)))
        for place, data in self._later:
            begin, end = max(place, self._at), min(place + len(data), self._at + size)
            if begin < end:
                content[begin - self._at : end - self._at] = data[begin - place : end - place]
        view[:size] = content
        self._at += size
        return size

    def truncate(self, size: int | None = None) -> int:
        """Set the length of the file."""
        size = self._at if size is None else size
        try:
            if self._error is None:
                self._file.truncate(size)
        except OSError as error:
            self._error = error
        self._end = size
        return size
