"""The published data sets: measurements by others, as their authors published them or as re-packed arrays.

Each function that reads one takes a folder, else looks for the set's own folder in VIBROCAP_DATA and where `vibrocap
list datasets --fetch` puts it. Originals are fetched over the network and checked. Where the checksum of one is known,
the file must have it. Where it is not, it is trusted on first use: the checksum of what came is written to a file
SHA256SUMS beside it (as `sha256sum --check` reads it), and a file that is fetched again must have that one. In both
cases what came must be readable as records.
"""

import dataclasses
import hashlib
import os
import re
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from vibrocap.files import made_folder, replacing, write_text
from vibrocap.inputs import read_own
from vibrocap.records.preparation import prepared
from vibrocap.records.reading.matlab import mat_files
from vibrocap.records.reading.readers import read_records
from vibrocap.records.record import Record, RecordError

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
    pulls: dict[str, np.ndarray] = {}
    if packed.exists():
        with np.load(packed) as archive:
            pulls = {name: archive[name] for name in archive.files}
    else:
        there = [*place.glob("*.mat"), *place.glob("data_raw/*.mat")]
        files = [path for path in there if re.fullmatch(r"k\d+Nm_v\d+", path.stem)]
        for path, variables in zip(files, mat_files(files), strict=True):
            pulls[path.stem.replace("Nm", "")] = _variable(variables, "Fnorm", path)
    matches = [match for name in pulls if (match := re.fullmatch(r"k(\d+)_v(\d+)", name))]
    in_order = sorted((int(match[1]), int(match[2]), match[0]) for match in matches)
    records = [_paper_record(stiffness, speed, pulls[name]) for stiffness, speed, name in in_order]
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
    record: Any = read_records(files[0])[0]
    begun = {"time": record.time - record.time[0], "displacement": record.displacement - record.displacement[0]}
    conditions = {"normal_stress_Pa": 1e6 * np.loadtxt(files[0], skiprows=1)[:, 3].mean()}
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


SUMS = "SHA256SUMS"
LARGEST = 2**30  # bytes of a file in an archive; the largest published one has 3 MB
GITHUB = "https://raw.githubusercontent.com"  # at a commit, which is the checksum of a whole repository


class FetchError(Exception):
    """A data set that could not be fetched, or has other checksums; the message gives the reason and the next step."""


@dataclasses.dataclass(frozen=True)
class Original:
    """One file as published: its address, its path in the folder of the set, its checksum if that is known.

    members: the files that are taken out of it, where it is an archive
    """

    url: str
    path: str
    sha256: str | None = None
    members: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True)
class DataSet:
    """A published data set: its content, authors and files."""

    name: str
    title: str
    authors: str
    licence: str
    page: str
    originals: tuple[Original, ...]
    read: Callable[[Path], list[Record]]


@dataclasses.dataclass(frozen=True)
class Fetched:
    """What a fetch brought: the folder, its records, and how many files were checked in which way (see `_fetch`)."""

    folder: Path
    records: list[Record]
    known: int
    recorded: int
    first: int


def _damper_files() -> tuple[Original, ...]:
    repository = "ARTS-Laboratory/Paper-Physics-Informed-Machine-Learning-for-Dry-Friction-and-Backlash"
    folder = "9899471ad05d457dd2697fedc840b3c0e91c697d/training%20reproduction/datasets/dataset-2"
    paths = [f"{part}/test{number}.npy" for part in ("F", "x", "v") for number in range(13)]
    paths += [f"validation/{place}{size}.npy" for place in DAMPER_WINDOWS for size in ("DBE", "MCE")]
    return tuple(Original(f"{GITHUB}/{repository}/{folder}/{path}", path) for path in paths)


def _paper_files() -> tuple[Original, ...]:
    folder = "npusteln/stickslip/c47df6d041fca443b32aad6465c076e75454c7b9/data_raw"
    names = [f"k{stiffness}Nm_v{speed}.mat" for stiffness in (168, 1002, 2254) for speed in (42, 1100, 4300)]
    return tuple(Original(f"{GITHUB}/{folder}/{name}", f"data_raw/{name}") for name in names)


_BASALT = "velstep4_BRAVA_expb819_basalt_Giacomel_et_al_2021.txt"

_BASALT_FILE = Original(
    f"{GITHUB}/pgiacomel/steadystate/1015c78e9143eebb8db43d2612d616553a3819e9/{_BASALT}",
    _BASALT,
    sha256="0ed7d29f21a37335d8191dcb365320d449bf7e52b6557690de34165fb889c959",
)
_EMPS_FILE = Original(  # the address that the benchmark's own loader, nonlinear_benchmarks, uses
    "https://drive.google.com/uc?export=download&id=1zwoXYa9-3f8NQ0ohzmjpF7UxbNgRTHkS",
    "EMPS.zip",
    members=("DATA_EMPS.mat", "DATA_EMPS_PULSES.mat"),
)

# fmt: off
DATA_SETS = {data_set.name: data_set for data_set in (  # name, title, authors, licence, page, originals, read
    DataSet("rotary-damper", "a rotary friction damper of 20 kN, 13 harmonic and 6 earthquake records",
            "Coble 2024", "CC BY-SA 4.0",
            "https://github.com/ARTS-Laboratory/Paper-Physics-Informed-Machine-Learning-for-Dry-Friction-and-Backlash",
            _damper_files(), rotary_damper),
    DataSet("paper-stick-slip", "paper on paper, pulled through springs of three stiffnesses at three speeds",
            "Colas, Pustelnik, Oliver, Abry, Geminard and Vidal 2019, Phys. Rev. E", "CeCILL-B (cite)",
            "https://github.com/npusteln/stickslip", _paper_files(), paper_stick_slip),
    DataSet("basalt-velocity-step", "basalt at 20 MPa, sliding speed stepped from 3 to 10 um/s",
            "Giacomel, Faulkner, Lambert and Allen 2024, Geosphere, doi 10.1130/GES02739.1", "MIT",
            "https://github.com/pgiacomel/steadystate", (_BASALT_FILE,), basalt_velocity_step),
    DataSet("emps", "an electro-mechanical positioning system, a carriage on a screw with dry friction",
            "Janot, Gautier and Brunot 2019, Workshop on Nonlinear System Identification Benchmarks",
            "as on its page (cite)", "https://www.nonlinearbenchmark.org", (_EMPS_FILE,), emps),
)}
# fmt: on


def fetch(data_set: DataSet, root: str | Path | None = None, report: Callable[[float], None] | None = None) -> Fetched:
    """Fetch a data set into its folder below `root`; what is there and unchanged is not fetched again.

    root: folder for data sets [default: VIBROCAP_DATA, else a folder in the user's cache]
    report: called with the share that is done
    Returns what came. Raises FetchError: no network, a wrong checksum, a file that cannot be read as records.
    Needs pooch (the extra `fit`).
    """
    folder = (Path(root) if root is not None else data_root()) / FOLDERS[data_set.name]
    try:
        made_folder(folder)
        earlier = read_own(folder / SUMS, LARGEST) if (folder / SUMS).exists() else b""
        lines = (line.split(maxsplit=1) for line in earlier.decode("utf-8", errors="replace").splitlines())
        sums, checks = {words[1]: words[0] for words in lines if len(words) == 2}, []
        for done, original in enumerate(data_set.originals, start=1):
            checks.append(_fetch(original, folder, sums))
            _unpack(original, folder)
            if report is not None:
                report(done / len(data_set.originals))
    except OSError as error:
        raise FetchError(_no_file(error, data_set, folder)) from error
    try:
        records = data_set.read(folder)
    except (ValueError, OSError) as error:
        raise FetchError(f"What came from {data_set.page} cannot be read as records: {error}") from error
    return Fetched(folder, records, *map(checks.count, ("known", "recorded", "first")))


def _fetch(original: Original, folder: Path, sums: dict[str, str]) -> str:
    """Bring one file, and say how it was checked: against the "known" sum, the "recorded" one, or none, the "first"."""
    import pooch

    pooch.get_logger().setLevel("ERROR")
    target = folder / original.path
    wanted = original.sha256 or sums.get(original.path)
    known = None if wanted is None else f"sha256:{wanted}"
    try:
        pooch.retrieve(original.url, known_hash=known, fname=target.name, path=target.parent)
    except ValueError as error:  # what came has another checksum; what was there before is left as it was
        whose = "the published file's" if original.sha256 else f"the one in {folder / SUMS}, of an earlier fetch"
        what = "" if original.sha256 else f" If the authors changed the file, delete {target} and its line there."
        raise FetchError(f"{original.url}: its checksum is not {whose}: sha256 {wanted}.{what}") from error
    if wanted is not None:
        return "known" if original.sha256 else "recorded"
    sums[original.path] = hashlib.sha256(target.read_bytes()).hexdigest()
    lines = [f"{digest}  {path}" for path, digest in sorted(sums.items())]
    write_text(folder / SUMS, "\n".join(lines) + "\n")
    return "first"


def _unpack(original: Original, folder: Path) -> None:
    if not original.members:
        return
    try:
        with zipfile.ZipFile(folder / original.path) as archive:
            inside = {Path(name).name: name for name in archive.namelist()}
            for member in original.members:
                if member not in inside:
                    raise FetchError(f"{original.url}: {original.path} holds no {member}; {_again(original, folder)}")
                if archive.getinfo(inside[member]).file_size > LARGEST:
                    raise FetchError(f"{original.url}: {member} unpacks to more than any published record")
                with replacing(folder / member) as temporary:
                    temporary.write_bytes(archive.read(inside[member]))
    except zipfile.BadZipFile:
        raise FetchError(f"{original.url}: the download is no zip archive; {_again(original, folder)}") from None


def _again(original: Original, folder: Path) -> str:
    return f"delete {folder / original.path} and its line in {SUMS}, and get it by hand from the set's page"


def _no_file(error: OSError, data_set: DataSet, folder: Path) -> str:
    from requests.exceptions import RequestException

    if isinstance(error, RequestException):
        address = error.request.url if error.request is not None else data_set.page
        reason = "no answer; there may be no network" if error.response is None else str(error)
        return (
            f"{address}: {reason}. What came until then is kept in {folder}; the same command continues. "
            f"By hand: {data_set.page}"
        )
    return f"{error.filename or folder}: {error.strerror or error}. Nothing else was changed."
