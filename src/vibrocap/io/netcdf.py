"""NetCDF files, written whole or not at all."""

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vibrocap.files import replacing

if TYPE_CHECKING:
    import xarray


def write_netcdf(dataset: "xarray.Dataset", path: Path) -> None:
    """Write a dataset; the same dataset gives the same bytes. WriteError where the disk does not take it.

    What is held in Dask arrays is computed and written block by block.
    """
    import h5netcdf
    from xarray.backends import H5NetCDFStore

    with replacing(path) as temporary:
        with _Disk(temporary) as disk, h5netcdf.File(disk, "w") as file:
            dataset.dump_to_store(H5NetCDFStore(file), writer=_InOrder())
        if disk.error is not None:
            raise disk.error


class _InOrder:
    """Writes one array after the other, each from its first block to its last, as HDF5 places them in a file.

    It stands for the ArrayWriter of xarray, which has Dask write blocks in an order that changes from run to run.
    """

    def add(self, source: Any, target: Any, region: Any = None) -> None:
        """Write an array. region: the part of the target that it fills, or None, for all of it."""
        if getattr(source, "chunks", None) is None:
            target[... if region is None else region] = source
            return
        from dask.array.core import slices_from_chunks

        for block in slices_from_chunks(source.chunks):
            target[block] = source[block].compute(scheduler="synchronous")


class _Disk(io.FileIO):
    """A file whose first error is kept for its owner and hidden from the library that writes it.

    HDF5 holds what it could not write in its caches, tries again when a file is closed, and takes the whole process
    down when that fails too. After an error it goes on writing to nowhere.
    """

    error: OSError | None = None

    def __init__(self, path: Path):
        super().__init__(path, "w+")

    def write(self, data: Any) -> int:
        """All of the data, on the disk or, after an error, nowhere."""
        rest = memoryview(data).cast("B")
        size = len(rest)
        try:
            while rest and self.error is None:
                rest = rest[super().write(rest) :]
        except OSError as error:
            self.error = error
        return size

    def truncate(self, size: int | None = None) -> int:
        """Set the length of the file, unless there was an error."""
        try:
            if self.error is None:
                return super().truncate(size)
        except OSError as error:
            self.error = error
        return self.tell() if size is None else size
