"""Results of a study as a labelled dataset: in memory while they are computed, or opened from a store."""

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.case.case import CaseError
from vibrocap.inputs import require_plain_file
from vibrocap.measures.measure import Measure
from vibrocap.studies.plan.study import Study
from vibrocap.studies.store.places import MIXED
from vibrocap.studies.store.record import measure_names, read_record
from vibrocap.studies.store.zarr_form import checked_results
from vibrocap.studies.variables import ALWAYS, axis_values, coordinate_attributes, study_attributes, variables

if TYPE_CHECKING:
    import xarray
READ_AT_ONCE = 2**28  # bytes of the values in a NetCDF file


def open_study(path: str | Path, *, chunks: Any = None) -> "xarray.Dataset":
    """The results of a stored study, read as they are needed; or those that `write_study` put into a NetCDF file.

    Of a study that is not finished, the runs to come have the status "not run" (-1). A folder may come from anyone: it
    is looked at before anything in it is opened, and each chunk is compared with its checksum when it is read.

    chunks: None reads on demand; {} or "auto" gives Dask arrays, for studies that do not fit into memory.
    Raises CaseError where a folder holds no study, or one that this package did not write, or a file no results; while
    results are read, StoreError (an OSError) where they are damaged.
    """
    import xarray

    path = Path(path)
    if path.suffix.lower() == ".nc" and not path.is_dir():
        return _exported(path, chunks)
    record = read_record(path)
    results = checked_results(path, record)
    from vibrocap.studies.store.checked_store import CheckedStore

    store: Any = CheckedStore(path, record, results)
    study = xarray.open_zarr(store, consolidated=False, chunks=chunks, decode_times=False)
    if (path / MIXED).exists():
        study.attrs["mixed"] = "some tiles were computed with other sources, libraries or processor than the first"
    return study[list(dict.fromkeys((*ALWAYS, *measure_names(record))))]


@contextlib.contextmanager
def netcdf_attributes(path: Path) -> Iterator[dict[str, Any]]:
    """The attributes of a NetCDF file; within the block, whatever its reader raises is a CaseError about the file.

    On damage h5py and what is built on it raise KeyError, RuntimeError and others. A file whose own attributes cannot
    be read is refused before h5netcdf opens it, which would complain once more when it is forgotten.
    """
    import h5py

    try:
        require_plain_file(path)
        with h5py.File(path, "r") as file:
            attributes = dict(file.attrs)
        yield attributes
    except FileNotFoundError:
        raise CaseError(["no such file"], str(path)) from None
    except Exception as error:
        raise CaseError([f"cannot be read as NetCDF, or is damaged: {error}"], str(path)) from None


def _exported(path: Path, chunks: Any) -> "xarray.Dataset":
    import xarray

    with netcdf_attributes(path):
        dataset = xarray.open_dataset(path, engine="h5netcdf", chunks=chunks)
        if chunks is None and dataset.nbytes <= READ_AT_ONCE:
            dataset.load()  # damage is found here, before anything is made of it
    if "status" not in dataset:
        raise CaseError(["is no study: it has no variable status"], str(path))
    return dataset


def stored_study(path: str | Path, measures: Iterable[Measure] = ()) -> Study:
    """The study whose results are in a folder, to be run again; measures: those of one's own among its measures.

    Raises CaseError where there is none.
    """
    return Study.from_record(read_record(Path(path))["study"], measures)


def empty_results(study: Study) -> dict[str, np.ndarray]:
    """Arrays for all results, in which nothing was run."""
    return {variable.name: variable.empty(study.plan.shape) for variable in variables(study)}


def labelled(study: Study, results: Mapping[str, np.ndarray]) -> "xarray.Dataset":
    """The results as a dataset, the same as a store of this study gives."""
    import xarray

    dims = study.plan.dims
    data: dict[str, Any] = {}
    coordinates: dict[str, Any] = {}
    for path, values in axis_values(study).items():
        coordinates[path] = path, values, coordinate_attributes(path, study.case.system)
    for variable in variables(study):
        entry = dims, variable.shown(results[variable.name]), variable.attributes
        (data if variable.measured else coordinates)[variable.name] = entry
    return xarray.Dataset(data, coordinates, study_attributes(study))
