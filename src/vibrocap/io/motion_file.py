"""Motions as files, NetCDF and CSV, that carry their case: such a file can be run again."""

import tomllib
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vibrocap.arguments import lacking
from vibrocap.case.case import Case, CaseError, case_from_text, case_text, read_case
from vibrocap.files import replacing
from vibrocap.inputs import require_plain_file
from vibrocap.io.json_text import json_text
from vibrocap.io.netcdf import write_netcdf

if TYPE_CHECKING:
    import xarray

    from vibrocap.motion.trajectory import Trajectory

UNITS = "dimensionless"
SCALES = "lengths over l, time over sqrt(l/g), masses over m, forces over m g"
IN_SI = "SI; a value over the dimensionless_unit of its column is the value without units"
MEANINGS = {
    "time": "time",
    "angle": "pendulum angle [rad]",
    "angle_rate": "angular velocity of the pendulum",
    "position": "capsule position",
    "velocity": "capsule velocity",
    "bristle": "mean bristle deflection",
    "friction": "friction force on the capsule",
    "drive": "drive torque",
    "impulse": "integral of the friction force from the start",
    "side": "contact: 1 slides forward, -1 slides back, 0 stuck",
}


def columns(motion: "Trajectory") -> dict[str, np.ndarray]:
    """What is exported, by name, on the motion's time grid; in SI where the system knows its scales."""
    if not len(motion.piece_start):  # nothing but the start was computed
        found = {"time": np.zeros(1)} | {name: np.array([value]) for name, value in motion.state.items()}
    else:
        names = (*motion.state_names, *motion.integral_names)
        found = {"time": motion.time, **dict(zip(names, motion.values(motion.time), strict=True))}
        found |= {name: motion[name] for name in ("friction", "drive", "side")}
    if motion.system.units is None:
        return found
    return {name: values * _scale(motion, name) if name != "side" else values for name, values in found.items()}


def _unit(motion: "Trajectory", name: str) -> str:
    return UNITS if motion.system.units is None else motion.system.si.unit(name)


def _scale(motion: "Trajectory", name: str) -> float:
    """What one dimensionless unit of a column is in the column's unit."""
    return 1.0 if motion.system.units is None else motion.system.si.factor(name)


def write_motion(motion: "Trajectory", case: Case, path: Path) -> Path:
    """Write a motion, with its case, to a file ending in .nc or .csv, whole or not at all.

    Raises ValueError for another ending, WriteError where it cannot be written.
    """
    writers: dict[str, Callable[[Trajectory, Case, Path], None]] = {".nc": _write_netcdf, ".csv": _write_csv}
    if path.suffix.lower() not in writers:
        raise ValueError(f"a motion is written to {' or '.join(writers)}, not to {str(path)!r}")
    writers[path.suffix.lower()](motion, case, path)
    return path


def read_source(path: Path, changes: Mapping[str, Any] | None = None, **run: Any) -> Case:
    """The case in a case file, or the one that an exported motion carries; CaseError with every complaint at once.

    changes, run: what replaces values of the case, see `case_from_text`
    """
    kind = path.suffix.lower()
    if kind not in (".nc", ".csv") or not path.is_file():
        return read_case(path, changes, **run)
    text = _case_in_netcdf(path) if kind == ".nc" else _case_in_csv(path)
    return case_from_text(text, str(path), changes, **run)


def _meaning(name: str) -> str:
    return MEANINGS.get(name) or f"{name.removesuffix('_work').replace('_', ' ')}: work into the system from the start"


def motion_dataset(motion: "Trajectory", case: Case, certificate: str | None = None) -> "xarray.Dataset":
    """A motion on its time grid, with its events, as labelled arrays that carry its case.

    certificate: as text, where it is known
    """
    import xarray

    known = {} if certificate is None else {"certificate": certificate}
    table = columns(motion)
    variables = {
        name: ("time", values.astype(np.int8) if name == "side" else values, _attributes(motion, name))
        for name, values in table.items()
        if name != "time"
    }
    variables["event_kind"] = ("event", motion.event_kinds.astype(object), {"long_name": "kind of event"})
    return xarray.Dataset(
        variables,
        coords={
            "time": ("time", table["time"], _attributes(motion, "time")),
            "event_time": (
                "event",
                motion.event_times * _scale(motion, "time"),
                _attributes(motion, "time") | {"long_name": "time of event"},
            ),
        },
        attrs={
            "title": "Motion of a vibro-driven capsule",
            "source": f"vibrocap {version('vibrocap')}",
            "units": f"{UNITS}: {SCALES}" if motion.system.units is None else IN_SI,
            **known,
            "status": motion.status.value,
            "status_text": motion.status.text,
            "case": case_text(case),
        },
    )


def _write_netcdf(motion: "Trajectory", case: Case, path: Path) -> None:
    certificate = _certificate_text(motion)  # before the status, which it may change
    write_netcdf(motion_dataset(motion, case, certificate), path)


def _attributes(motion: "Trajectory", name: str) -> dict[str, Any]:
    found: dict[str, Any] = {"long_name": _meaning(name), "units": _unit(motion, name)}
    if motion.system.units is None:
        return found
    found["long_name"] = found["long_name"].removesuffix(" [rad]")
    return found | {"dimensionless_unit": _scale(motion, name)}


def _certificate_text(motion: "Trajectory") -> str:
    return json_text(motion.certificate.record()) if len(motion.piece_start) else "null"


def _write_csv(motion: "Trajectory", case: Case, path: Path) -> None:
    """A header of comments, which without their `# ` are the case and the section [result] in TOML, then the table."""
    table = columns(motion)
    result = {
        "source": f"vibrocap {version('vibrocap')}",
        "certificate": " ".join(_certificate_text(motion).split()),
        "status": motion.status.value,
        "status_text": motion.status.text,
        "scales": SCALES if motion.system.units is None else IN_SI,
    }
    header = case_text(case).splitlines()
    header += ["", "[result]", *(f"{key} = '''{value}'''" for key, value in result.items())]
    header += ["", "[result.units]", *(f'{name} = "{_unit(motion, name)}"' for name in table)]
    if motion.system.units is not None:
        header += ["", "[result.dimensionless_unit]", *(f"{name} = {_scale(motion, name)!r}" for name in table)]
    header += ["", "[result.meaning]", *(f'{name} = "{_meaning(name)}"' for name in table)]
    numbers = {name: values.tolist() for name, values in table.items()}
    lists = [map(str, map(int, each)) if name == "side" else map(repr, each) for name, each in numbers.items()]
    with replacing(path) as temporary, temporary.open("w", encoding="utf-8", newline="\n") as file:
        file.writelines(f"# {line}".rstrip() + "\n" for line in header)
        file.write(",".join(table) + "\n")
        file.writelines(",".join(row) + "\n" for row in zip(*lists, strict=True))


def _case_in_csv(path: Path) -> str:
    header = []
    require_plain_file(path)
    try:
        with path.open(encoding="utf-8-sig") as file:
            for line in file:
                if not line.startswith("#"):
                    break
                header.append(line.removeprefix("#").removeprefix(" "))
    except UnicodeDecodeError:
        raise CaseError(["is not a text file in UTF-8"], str(path)) from None
    text = "".join(header)
    case, _, _ = text.partition("\n[result]\n")
    try:
        if tomllib.loads(case):
            return case
    except (ValueError, RecursionError):
        pass
    raise CaseError(["carries no case: a CSV file of vibrocap begins with it, as comments"], str(path))


def _case_in_netcdf(path: Path) -> str:
    if said := lacking("h5netcdf", "h5py"):
        raise CaseError([said], str(path))
    import h5netcdf

    try:
        require_plain_file(path)
        with h5netcdf.File(path, "r") as file:
            if "case" in file.attrs:
                return str(file.attrs["case"])
    except OSError:
        raise CaseError(["is not a NetCDF 4 file"], str(path)) from None
    raise CaseError(["carries no case: it was not written by vibrocap"], str(path))
