"""The published data sets: measurements by others, as their authors published them or as re-packed arrays.

Each function takes a folder, else looks for the set's own folder in VIBROCAP_DATA and where `vibrocap list datasets
--fetch` puts it. What a set is, its licence and its authors: `vibrocap.records.fetching`.
"""

import os
import re
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.records.checks import RecordError
from vibrocap.records.preparation import prepared
from vibrocap.records.reading.matlab import mat_files
from vibrocap.records.reading.readers import read_records
from vibrocap.records.record import Record

FOLDERS = {
    "rotary-damper": "arts-rotary-damper",
    "paper-stick-slip": "paper-stick-slip",
    "basalt-velocity-step": "basalt-velocity-step",
    "emps": "emps",
}

DAMPER = "Coble 2024, Paper-Physics-Informed-Machine-Learning-for-Dry-Friction-and-Backlash, dataset-2 (CC BY-SA 4.0)"
DAMPER_RATE = 1024.0  # Hz, run_validation.py there
# Samples in which an earthquake record is not at rest: restricted_indices in run_validation.py there.
DAMPER_WINDOWS = {"Duzce": (4608, 12288), "ImperialValley": (3072, 7680), "Kocaeli": (6144, 14336)}

PAPER = "Colas et al. 2019, Nonlinear denoising for solid friction dynamics characterization, Phys. Rev. E (CeCILL-B)"
PAPER_MASS, PAPER_GRAVITY, PAPER_RATE = 30.7e-3, 9.81, 2000.0  # kg, m/s^2, Hz: ex1.m there

BASALT = "Giacomel et al. 2024, Geosphere 20, 965, doi 10.1130/GES02739.1 (MIT)"

EMPS = (
    "Janot, Gautier and Brunot 2019, Data Set and Reference Models of EMPS, Nonlinear System Identification Benchmarks"
)


def data_root() -> Path:
    """Where data sets are kept: VIBROCAP_DATA, else a folder in the user's cache, or here for a user without a home."""
    if os.environ.get("VIBROCAP_DATA"):
        return Path(os.environ["VIBROCAP_DATA"])
    try:
        return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "vibrocap" / "data"
    except RuntimeError:
        return Path("vibrocap-data")


def data_folder(name: str, folder: str | Path | None = None) -> Path:
    """The folder of a data set. FileNotFoundError, saying how to get it, where it is not there."""
    place = Path(folder) if folder is not None else data_root() / FOLDERS[name]
    if place.is_dir():
        return place
    raise FileNotFoundError(
        f"{place}: no such folder, where the data set {name!r} should be; give the folder, set VIBROCAP_DATA to the "
        f"folder that holds {FOLDERS[name]!r}, or get the originals: vibrocap list datasets --fetch {name}"
    )


def rotary_damper(folder: str | Path | None = None) -> list[Record]:
    """A banded rotary friction damper of 20 kN under harmonic and earthquake displacement, 1024 samples a second.

    Force, displacement and velocity are the authors' own. The force is asymmetric and shows backlash at reversal.
    From the re-packed file: harmonic_02, _07, _08, _11 and eq_KocaeliMCE_window. From the originals: harmonic_00 to
    harmonic_12, and the six earthquakes within the authors' windows (eq_DuzceDBE_window, ...).
    """
    place = data_folder("rotary-damper", folder)
    packed = place / "rotary_damper.npz"
    if packed.exists():
        by_name = {record.name: record for record in read_records(packed)}
        order = sorted(by_name, key=lambda name: (name.startswith("eq"), name))
        return [by_name[name].replaced(source=DAMPER) for name in order]
    records = []
    matches = [(re.search(r"test(\d+)$", path.stem), path) for path in place.glob("F/test*.npy")]
    for number, path in sorted((int(match[1]), path) for match, path in matches if match):
        columns = {quantity: np.load(place / part / path.name) for quantity, part in _DAMPER_PARTS.items()}
        records.append(_damper_record(f"harmonic_{number:02d}", columns))
    for path in sorted(place.glob("validation/*.npy")):
        first, last = DAMPER_WINDOWS[re.sub("(DBE|MCE)$", "", path.stem)]
        table = np.load(path)[first:last]
        columns = {quantity: table[:, at] for at, quantity in enumerate(("time", *_DAMPER_PARTS))}
        records.append(_damper_record(f"eq_{path.stem}_window", columns))
    return _or_none_there(records, place, "rotary_damper.npz, or F/, x/, v/ and validation/ of dataset-2")


_DAMPER_PARTS = {"force": "F", "displacement": "x", "velocity": "v"}


def _damper_record(name: str, columns: dict[str, np.ndarray]) -> Record:
    force, displacement, velocity = (columns[quantity].ravel() for quantity in _DAMPER_PARTS)
    time = np.arange(len(force)) / DAMPER_RATE
    return Record(name, time, force, velocity=velocity, displacement=displacement, source=DAMPER)


def paper_stick_slip(folder: str | Path | None = None) -> list[Record]:
    """Paper sliding on paper, pulled through a spring: k168_v42 is a spring of 168 N/m pulled at 42 um/s.

    Measured is the pull of the spring over the slider's weight, 2000 times a second. The spring ties the motion to it,
    so that the displacement of the slider needs no derivative and holds no amplified noise:

        x = V t - (F - F(0))/k        (its derivative is the slider velocity of the paper, V - (m g/k) d(F/mg)/dt)

    force is the pull in N, the friction force as long as the slider's inertia is small (stick); normal_force is the
    weight. conditions: stiffness_N_per_m, pulling_speed_m_per_s, mass_kg, gravity_m_per_s2.
    """
    place = data_folder("paper-stick-slip", folder)
    packed = place / "paper_stick_slip.npz"
    pulls: dict[tuple[int, int], np.ndarray] = {}
    if packed.exists():
        with np.load(packed) as archive:
            for name in archive.files:
                if match := re.fullmatch(r"k(\d+)_v(\d+)", name):
                    pulls[int(match[1]), int(match[2])] = archive[name]
    else:
        there = [*place.glob("*.mat"), *place.glob("data_raw/*.mat")]
        files = {path: match for path in there if (match := re.fullmatch(r"k(\d+)Nm_v(\d+)", path.stem))}
        for (path, match), variables in zip(files.items(), mat_files([*files]), strict=True):
            pulls[int(match[1]), int(match[2])] = _variable(variables, "Fnorm", path)
    records = [_paper_record(stiffness, speed, pulls[stiffness, speed]) for stiffness, speed in sorted(pulls)]
    return _or_none_there(records, place, "paper_stick_slip.npz, or files such as k168Nm_v42.mat")


def _paper_record(stiffness: int, micrometres_per_s: int, pull: np.ndarray) -> Record:
    weight, speed = PAPER_MASS * PAPER_GRAVITY, micrometres_per_s / 1e6
    time, force = np.arange(len(pull)) / PAPER_RATE, weight * np.asarray(pull, dtype=np.float64)
    conditions = {"stiffness_N_per_m": stiffness, "pulling_speed_m_per_s": speed}
    return Record(
        name=f"k{stiffness}_v{micrometres_per_s}",
        time=time,
        force=force,
        displacement=speed * time - (force - force[0]) / stiffness,
        normal_force=weight,
        source=PAPER,
        conditions=conditions | {"mass_kg": PAPER_MASS, "gravity_m_per_s2": PAPER_GRAVITY},
        notes=("displacement: from the pull of the spring, V t - (F - F(0))/k",),
    )


def basalt_velocity_step(folder: str | Path | None = None) -> list[Record]:
    """Basalt sliding at 20 MPa, its speed stepped from 3 to 10 um/s.

    force is the friction coefficient, the force for a load of 1 N (normal_force is 1); displacement in m; time begins
    at 0 and is sampled each 0.1 s for 66.5 s, then each 0.01 s; the speed steps about 1.5 s later.
    conditions: normal_stress_Pa, the mean.
    """
    place = data_folder("basalt-velocity-step", folder)
    files = [path for path in sorted(place.glob("*.txt")) if "basalt" in path.name.lower()]
    if not files:
        return _or_none_there([], place, "basalt_velocity_step.txt, or velstep4_BRAVA_expb819_basalt_... .txt")
    record = read_records(files[0])[0]
    stress = np.loadtxt(files[0], skiprows=1)[:, 3]
    assert record.displacement is not None
    begun = {"time": record.time - record.time[0], "displacement": record.displacement - record.displacement[0]}
    conditions = {"normal_stress_Pa": 1e6 * stress.mean()}
    return [record.replaced(source=BASALT, **begun, name="basalt_3_to_10", conditions=conditions)]


def emps(path: str | Path | None = None, *, cutoff: float = 100.0, mass: float | None = None) -> list[Record]:
    """The electro-mechanical positioning system: a carriage on a screw, 1000 samples a second.

    force = gtau vir, the motor's force on the carriage (N); displacement qm (m); velocity and acceleration from it,
    filtered without delay below `cutoff` (Hz). The motor's force is inertia and friction together: with `mass` the
    inertia is taken off, and the friction remains, else

        gtau vir = M q'' + friction       M = 95.1 kg in the authors' reference model (Simulation_EMPS.m)

    path: DATA_EMPS.mat or DATA_EMPS_PULSES.mat, or a folder with both (one that holds no gtau takes the other's)
    """
    place = Path(path) if path is not None and Path(path).is_file() else data_folder("emps", path)
    files = [place] if place.is_file() else sorted(place.rglob("DATA_EMPS*.mat"))
    records = []
    shared: dict[str, Any] = {}
    for file, own in zip(files, mat_files(files), strict=True):
        variables = {**shared, **own}
        time, position, voltage, gain = (_variable(variables, name, file) for name in ("t", "qm", "vir", "gtau"))
        shared["gtau"] = gain
        record = Record(
            name=file.stem.removeprefix("DATA_"),
            time=time,
            force=float(np.ravel(gain)[0]) * voltage,
            displacement=position,
            source=EMPS,
            conditions={"force_per_volt_N": float(np.ravel(gain)[0])},
            notes=("force: gtau vir, the force of the motor: inertia and friction",),
        )
        records.append(prepared(record, cutoff=cutoff, mass=mass))
    return _or_none_there(records, place, "DATA_EMPS.mat")


def _variable(variables: dict[str, Any], name: str, path: Path) -> np.ndarray:
    if name not in variables:
        raise RecordError([f"{name}: no such variable; there is {', '.join(map(repr, variables))}"], str(path))
    return np.ravel(np.asarray(variables[name], dtype=np.float64))


def _or_none_there(records: list[Record], place: Path, wanted: str) -> list[Record]:
    if records:
        return records
    raise FileNotFoundError(f"{place}: holds no such data; should hold {wanted}")
