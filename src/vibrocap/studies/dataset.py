"""Results as labelled arrays: of a study, in memory or from a store, and of any result whose types state dimensions."""

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.case.case import Case, CaseError, case_text
from vibrocap.inputs import require_plain_file
from vibrocap.measures.measure import Measure
from vibrocap.physics.dimensions.conversion import INITIAL
from vibrocap.quantities.declared import AlongTurns, Context, Over, WithUnit, without_unit
from vibrocap.quantities.dimensional import computed, member_hints, member_view
from vibrocap.quantities.hints import declaration, over_of
from vibrocap.results import Rows
from vibrocap.studies.plan.study import Study, code_version
from vibrocap.studies.store.places import MIXED
from vibrocap.studies.store.record import measure_names, read_record
from vibrocap.studies.store.zarr_form import checked_results
from vibrocap.studies.variables import ALWAYS, axis_values, coordinate_attributes, study_attributes, variables

if TYPE_CHECKING:
    import xarray

READ_AT_ONCE = 2**28  # bytes of the values in a NetCDF file


def open_study(path: str | Path, *, chunks: Any = None) -> "xarray.Dataset":
    """The results of a stored study, read as they are needed; or those that `write_study` put into a NetCDF file.

    Runs to come of a study that is not finished have the status "not run" (-1). A folder may come from anyone: it is
    looked at before anything in it is opened, and each chunk is compared with its checksum when it is read.

    chunks: None reads on demand; {} or "auto" gives Dask arrays, for studies that do not fit into memory.
    Raises CaseError where a folder holds no study of this package, or a file no results; while results are read,
    StoreError (an OSError) where they are damaged.
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

    A file whose own attributes cannot be read is refused before h5netcdf opens it, which would complain once more when
    it is forgotten.
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
    """The study whose results are in a folder, to be run again; measures: those of one's own. CaseError where none."""
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


PHASE_ATTRIBUTES = {"long_name": "phase of the drive at the start, as a share of its period", "symbol": "t_0/T"}
Variable = tuple[tuple[str, ...], np.ndarray, dict[str, Any]]  # dimensions, values, attributes


def labelled_result(result: Any) -> "xarray.Dataset":
    """The arrays of a result along the dimensions that their types state (`Over`), as a dataset with its case."""
    import xarray

    data, coordinates = labelled_arrays(result)
    plain = computed(result)
    known = {name: var for name, var in vars(plain).items() if isinstance(var, (int, float, str, type(None)))}
    attributes = {name: str(x) if x is None or isinstance(x, bool) else x for name, x in known.items()}
    attributes |= dict(zip(("begins", "ends"), (end.value for end in getattr(plain, "ends", ())), strict=False))
    case = case_text(Case(plain.system, dict(getattr(plain, "initial", {}))))
    source = {"source": f"vibrocap {code_version()['version']}", "case": case}
    return xarray.Dataset(data, coordinates, {"title": result.heading} | attributes | source)


def labelled_arrays(result: Any) -> tuple[dict[str, Variable], dict[str, Variable]]:
    """(arrays, coordinates) of a result by name, in SI where it is; empty for one whose types state no dimension.

    Quantities in a matrix have an array each; so has each member of the records in a list ("special_kind").
    """
    context, record = result.si_context() or Context(None), computed(result)
    arrays: tuple[dict[str, Variable], dict[str, Variable]] = {}, {}
    for member, hint in member_hints(type(record)).items():
        if (over := over_of(hint)) is None:
            continue
        dims = tuple(_named(result, dim) for dim in over.dims)
        if isinstance(getattr(record, member), tuple):
            arrays[0].update(_of_records(getattr(result, member), dims[0]))
            continue
        seen, name = member_view(record, member, context), _named(result, over.name) or member
        split = {name: seen}
        if isinstance(seen, dict):
            counts = isinstance(declaration(hint), AlongTurns)  # of states, beside these
            states = not counts and set(seen) <= set(record.system.state_names)
            split = {key if states else f"{member}_{key}": value for key, value in seen.items()}
        for key, value in split.items():
            values, attributes = np.asarray(without_unit(value)), _attributes(key, value, over, record)
            if np.iscomplexobj(values):
                arrays[0][f"{dims[-1]}_real"] = (dims, np.real(values), attributes)
                arrays[0][f"{dims[-1]}_imag"] = (dims, np.imag(values), attributes)
            else:
                values = values.astype(str) if values.dtype == object else values
                arrays[bool(over.name)][key] = (dims, values, attributes)
    return arrays


def _named(result: Any, name: str) -> str:
    """The name that a member of a result holds, or the name itself."""
    held = getattr(result, name, name) if name else ""
    return held if isinstance(held, str) else name


def _of_records(records: tuple[Any, ...], dim: str) -> dict[str, Variable]:
    rows, variables = Rows(records).table(), {}
    for name in rows[0] if rows else ():
        values = [row[name] for row in rows]
        kind = str if any(isinstance(value, str) for value in values) else float
        unit = {} if kind is str else {"units": records[0].unit_of(name)}
        variables[f"{dim}_{name}"] = ((dim,), np.array(values, dtype=kind), unit)
    return variables


def _attributes(name: str, seen: Any, over: Over, record: Any) -> dict[str, Any]:
    from vibrocap.orbits.attractors.basins import PHASE  # only here: a sweep needs no attractors

    if over.flags:
        flags = {"flag_values": list(over.flags.values()), "flag_meanings": " ".join(over.flags)}
        return {"long_name": over.words} | flags
    if name == PHASE:
        return PHASE_ATTRIBUTES
    unit = {"units": seen.unit if isinstance(seen, WithUnit) else "1"}
    if name in record.system.state_names:
        return coordinate_attributes(f"{INITIAL}{name}", record.system) | {"long_name": name} | unit
    known = coordinate_attributes(name, record.system) if "." in name else {}
    return {"long_name": over.words} | known | unit
