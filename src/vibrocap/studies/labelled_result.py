"""Results as labelled arrays and tables: what the declarations of their fields state, with the case they belong to."""

from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.case.case import Case, case_text
from vibrocap.orbits.attractors.basins import PHASE
from vibrocap.physics.dimensions.conversion import INITIAL
from vibrocap.quantities.declared import AlongTurns, Context, Over, WithUnit, without_unit
from vibrocap.quantities.dimensional import computed, member_hints, member_view
from vibrocap.quantities.hints import declaration, over_of
from vibrocap.results import Rows
from vibrocap.studies.plan.code_version import code_version
from vibrocap.studies.variables import coordinate_attributes

if TYPE_CHECKING:
    import xarray

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

    States and other quantities in a matrix have an array each; so has each member of the records in a list, under the
    name of the dimension and its own ("special_kind").
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
    """An array for each member of some records."""
    rows, variables = Rows(records).table(), {}
    for name in rows[0] if rows else ():
        values = [row[name] for row in rows]
        kind = str if any(isinstance(value, str) for value in values) else float
        unit = {} if kind is str else {"units": records[0].unit_of(name)}
        variables[f"{dim}_{name}"] = ((dim,), np.array(values, dtype=kind), unit)
    return variables


def _attributes(name: str, seen: Any, over: Over, record: Any) -> dict[str, Any]:
    """What an array is, its symbol and its unit."""
    if over.flags:
        flags = {"flag_values": list(over.flags.values()), "flag_meanings": " ".join(over.flags)}
        return {"long_name": over.words} | flags
    if name == PHASE:
        return PHASE_ATTRIBUTES
    unit = {"units": seen.unit if isinstance(seen, WithUnit) else "1"}
    if name in record.system.state_names:
        return coordinate_attributes(f"{INITIAL}{name}") | {"long_name": name} | unit
    known = coordinate_attributes(name, record.system) if "." in name else {}
    return {"long_name": over.words} | known | unit
