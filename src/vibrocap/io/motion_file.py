"""Motions as files: NetCDF and CSV, which carry their case and can be run again, Excel workbooks and MATLAB files."""

import functools
import tomllib
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.arguments import lacking
from vibrocap.case.case import Case, CaseError, case_from_text, case_text, read_case
from vibrocap.inputs import require_plain_file
from vibrocap.io.spreadsheets import Export, beside
from vibrocap.physics.names import name_and_number
from vibrocap.quantities.declared import ByName, Shown
from vibrocap.quantities.dimensional import computed, walked
from vibrocap.quantities.json_text import json_text

if TYPE_CHECKING:
    import xarray

    from vibrocap.motion.trajectory import Trajectory

UNITS = "dimensionless"
SCALES = "lengths over l, time over sqrt(l/g), masses over m, forces over m g"
IN_SI = "SI; a value over the dimensionless_unit of its column is the value without units"
OBSERVED = ("friction", "drive", "reaction")
ROWS_AT_A_TIME = 10_000


def columns(motion: "Trajectory") -> dict[str, np.ndarray]:
    """What is exported, by name, on the motion's time grid; in SI where the motion is."""
    context, motion = motion.si_context(), computed(motion)
    if not len(motion.piece_start):  # nothing but the start was computed
        table = {"time": np.zeros(1)} | {name: np.array([value]) for name, value in motion.state.items()}
    else:
        names = (*motion.state_names, *motion.integral_names)
        table = {"time": motion.time, **dict(zip(names, motion.values(motion.time), strict=True))}
        index = motion.piece_at(motion.time)
        observed = tuple(name for name in motion.observable_names if name_and_number(name)[0] in OBSERVED)
        values = motion.piece_observables(observed, index, motion.time - motion.piece_start[index])
        sides = zip(motion.side_names, motion.sides(index), strict=True)
        table |= {**dict(zip(observed, values, strict=True)), **dict(sides)}
    return table if context is None else walked(table, ByName, context)


def _unit(motion: "Trajectory", name: str) -> str:
    return UNITS if motion.si_context() is None else motion.unit_of(name)


def write_motion(motion: Shown, path: str | Path, case: Case | None = None, *, unit_headings: bool = False) -> Path:
    """Write a motion on its time grid to a file ending in .nc, .csv, .xlsx or .mat, whole or not at all.

    Units and meanings go along, and the case that makes it again (by default that of the motion itself): of a CSV file
    in a file of TOML beside it, with `.toml` behind the whole name.

    unit_headings: whether the columns of a .csv or .xlsx are headed by name and unit, "position [m]", in place of names

    Raises ValueError for another ending, WriteError where it cannot be written.
    """
    return MotionExport(motion, case_of(motion) if case is None else case).write(path, unit_headings)


def case_of(motion: "Trajectory") -> Case:
    """The case that makes a motion again, but for a start at another time than 0, see `start_of`."""
    return Case(motion.system, dict(computed(motion).initial), periods=motion.periods, tolerance=motion.tolerance)


def start_of(motion: "Trajectory") -> dict[str, float]:
    """What a case does not say of the start of a motion: nothing where it starts with its drive, at time 0."""
    motion = computed(motion)
    return {"start_time": motion.start_time, "start_phase": motion.start_phase} if motion.start_time else {}


def read_source(path: Path, changes: Mapping[str, Any] | None = None, **run: Any) -> Case:
    """The case in a case file, or the one that an exported motion carries; CaseError with every complaint at once.

    changes, run: what replaces values of the case, see `case_from_text`
    """
    kind = path.suffix.lower()
    if kind not in (".nc", ".csv") or not path.is_file():
        return read_case(path, changes, **run)
    text = _case_in_netcdf(path) if kind == ".nc" else _case_in_csv(path)
    return case_from_text(text, str(path), changes, **run)


def _meaning(motion: "Trajectory", name: str) -> str:
    """What a column holds, as the page of symbols tells it."""
    from vibrocap.physics.symbols import QUANTITIES, state_symbols

    states, work = state_symbols(motion.system.parts), "_work" * name.endswith("_work")
    stem, number = (name.removesuffix(work), 1) if name in states else name_and_number(name.removesuffix(work))
    _, meaning = (states | QUANTITIES).get(stem + work, ("", ""))
    words = name.removesuffix(work).replace("_", " ")
    if not meaning or meaning.startswith(("its ", "their ")):
        return f"work of {words} since the start" if work else words
    return f"{meaning}, of contact {number}" if number > 1 else meaning


def motion_dataset(
    motion: "Trajectory", case: Case, certificate: str | None = None, table: Mapping[str, np.ndarray] | None = None
) -> "xarray.Dataset":
    """A motion on its time grid, with its events, as labelled arrays that carry its case.

    certificate: as text, and table: its `columns`, where they are known
    """
    import xarray

    known = {} if certificate is None else {"certificate": certificate}
    known |= start_of(motion)
    table = table or columns(motion)
    variables = {
        name: ("time", values.astype(np.int8) if name in motion.side_names else values, _attributes(motion, name))
        for name, values in table.items()
        if name != "time"
    }
    variables["event_kind"] = ("event", motion.event_kinds.astype(object), {"long_name": "kind of event"})
    return xarray.Dataset(
        variables,
        coords={
            "time": ("time", table["time"], _attributes(motion, "time")),
            "event_time": ("event", motion.event_times, _attributes(motion, "time") | {"long_name": "time of event"}),
        },
        attrs={
            "title": "Motion of a vibro-driven capsule",
            "source": f"vibrocap {version('vibrocap')}",
            "units": f"{UNITS}: {SCALES}" if motion.si_context() is None else IN_SI,
            **known,
            "status": motion.status.value,
            "status_text": motion.status.text,
            "case": case_text(case),
        },
    )


def _attributes(motion: "Trajectory", name: str) -> dict[str, Any]:
    attributes: dict[str, Any] = {"long_name": _meaning(motion, name), "units": _unit(motion, name)}
    context = motion.si_context()
    return attributes if context is None else attributes | {"dimensionless_unit": context.units.factor(name)}


def _certificate_text(motion: "Trajectory") -> str:
    return json_text(motion.certificate) if len(motion.piece_start) else "null"


class MotionExport(Export):
    """A motion on its time grid, with its events."""

    what = sheet = "motion"

    def __init__(self, motion: "Trajectory", case: Case):
        self.motion, self.own, self.case = motion, case, case_text(case)
        self.table = columns(motion)
        self.units = {name: _unit(motion, name) for name in self.table}
        self.meanings = {name: _meaning(motion, name) for name in self.table}
        self.size = max(len(self.table["time"]), len(motion.event_times))
        if (context := motion.si_context()) is not None:
            self.scales = {name: context.units.factor(name) for name in self.table}

    @functools.cached_property
    def facts(self) -> dict[str, str]:  # type: ignore[override]
        """What is known of the motion as a whole."""
        motion = self.motion
        certificate = " ".join(_certificate_text(motion).split())  # before the status, which it may change
        return {
            "source": f"vibrocap {version('vibrocap')}",
            "certificate": certificate,
            "status": motion.status.value,
            "status_text": motion.status.text,
            "scales": SCALES if motion.si_context() is None else IN_SI,
            **{name: repr(value) for name, value in start_of(motion).items()},
        }

    def parts(self):
        """For each time."""
        sides = {name: self.table[name].astype(int) for name in self.motion.side_names if name in self.table}
        table = self.table | sides
        for first in range(0, len(table["time"]), ROWS_AT_A_TIME):
            yield [values[first : first + ROWS_AT_A_TIME].tolist() for values in table.values()]

    @property
    def events(self) -> dict[str, np.ndarray]:
        """Columns of the events."""
        motion = self.motion
        return {"time": motion.event_times, "kind": motion.event_kinds, "contact": motion.event_contacts}

    def sheets(self):
        """The events."""
        rows = zip(*(values.tolist() for values in self.events.values()), strict=True)
        return {"events": (tuple(self.events), rows)}

    def arrays(self):
        """The columns, and a struct with the events."""
        return {**self.table, "events": self.events}

    def dataset(self):
        """With the certificate."""
        certificate = _certificate_text(self.motion)  # before the status, which it may change
        return motion_dataset(self.motion, self.own, certificate, self.table)


def _case_in_csv(path: Path) -> str:
    require_plain_file(path)
    about = beside(path)
    if not about.is_file():
        raise CaseError([f"carries no case: a CSV file of vibrocap has it beside it, in {about.name}"], str(path))
    require_plain_file(about)
    try:
        text = about.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        raise CaseError(["is not a text file in UTF-8"], str(about)) from None
    case, _, _ = text.partition("\n[result]\n")
    try:
        if tomllib.loads(case):
            return case
    except (ValueError, RecursionError):
        pass
    raise CaseError(["carries no case: it was not written by vibrocap"], str(about))


def _case_in_netcdf(path: Path) -> str:
    if refusal := lacking("h5py"):
        raise CaseError([refusal], str(path))
    from vibrocap.studies.dataset import netcdf_attributes

    with netcdf_attributes(path) as attributes:
        if isinstance(case := attributes.get("case"), str):
            return case
    raise CaseError(["carries no case: it was not written by vibrocap"], str(path))
