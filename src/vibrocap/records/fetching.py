"""The published originals of the data sets, fetched over the network and checked.

Where the checksum of an original is known, the file must have it. Where it is not, it is trusted on first use: the
checksum of what came is written to a file SHA256SUMS beside it (as `sha256sum --check` reads it), and a file that is
fetched again must have that one. In both cases what came must be readable as records.
"""

import dataclasses
import hashlib
import zipfile
from collections.abc import Callable
from pathlib import Path

from vibrocap.files import made_folder, replacing, write_text
from vibrocap.inputs import read_own
from vibrocap.records import published
from vibrocap.records.record import Record

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
    paths += [f"validation/{place}{size}.npy" for place in published.DAMPER_WINDOWS for size in ("DBE", "MCE")]
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
            _damper_files(), published.rotary_damper),
    DataSet("paper-stick-slip", "paper on paper, pulled through springs of three stiffnesses at three speeds",
            "Colas, Pustelnik, Oliver, Abry, Geminard and Vidal 2019, Phys. Rev. E", "CeCILL-B (cite)",
            "https://github.com/npusteln/stickslip", _paper_files(), published.paper_stick_slip),
    DataSet("basalt-velocity-step", "basalt at 20 MPa, sliding speed stepped from 3 to 10 um/s",
            "Giacomel, Faulkner, Lambert and Allen 2024, Geosphere, doi 10.1130/GES02739.1", "MIT",
            "https://github.com/pgiacomel/steadystate", (_BASALT_FILE,), published.basalt_velocity_step),
    DataSet("emps", "an electro-mechanical positioning system, a carriage on a screw with dry friction",
            "Janot, Gautier and Brunot 2019, Workshop on Nonlinear System Identification Benchmarks",
            "as on its page (cite)", "https://www.nonlinearbenchmark.org", (_EMPS_FILE,), published.emps),
)}
# fmt: on


def fetch(data_set: DataSet, root: str | Path | None = None, report: Callable[[float], None] | None = None) -> Fetched:
    """Fetch a data set into its folder below `root`; what is there and unchanged is not fetched again.

    root: folder for data sets [default: VIBROCAP_DATA, else a folder in the user's cache]
    report: called with the share that is done
    Returns what came. Raises FetchError: no network, a wrong checksum, a file that cannot be read as records.
    Needs pooch (the extra `fit`).
    """
    folder = (Path(root) if root is not None else published.data_root()) / published.FOLDERS[data_set.name]
    try:
        made_folder(folder)
        sums = _sums(folder)
        checks = []
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


def _sums(folder: Path) -> dict[str, str]:
    """The checksums that earlier fetches wrote down, by path."""
    if not (folder / SUMS).exists():
        return {}
    text = read_own(folder / SUMS, LARGEST).decode("utf-8", errors="replace")
    lines = (line.split(maxsplit=1) for line in text.splitlines())
    return {words[1]: words[0] for words in lines if len(words) == 2}


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
