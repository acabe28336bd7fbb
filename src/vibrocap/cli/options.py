"""Options: each is declared once, as the value of a request's field; those that several commands share.

Below: whether the files and folders that a command is to write can be written, before any work.
"""

import dataclasses
import functools
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from vibrocap.arguments import Refusal, lacking
from vibrocap.cli import completers
from vibrocap.cli.completers import Offered
from vibrocap.files import other_place
from vibrocap.io.spreadsheets import BESIDE, HEADED, ROWS, beside


@dataclasses.dataclass(frozen=True)
class Option:
    """An option of a command, as a request declares it: `points: int = option("of a branch", 100)`.

    words: its help; default: of the field; place: it is given by its place on the line, without a name
    sets: arguments of functions that it sets, besides that of the field's own name: complaints name the option instead
    offers: what a shell completes; check: complains of (option, value) before any work
    needs: the field of the option without which it means nothing, where the request has it; advanced: few need it
    """

    words: str
    default: Any = None
    place: bool = False
    sets: tuple[str, ...] = ()
    offers: Callable[[Any], Offered] | None = None
    check: Callable[[str, Any], Any] | None = None
    needs: str = ""
    advanced: bool = False


def option(words: str, default: Any = None, **more: Any) -> Any:
    """An `Option` as the value of the field that it declares."""
    return Option(words, default, **more)


REQUIRED: Any = dataclasses.MISSING  # as a default
required = functools.partial(option, default=REQUIRED)


def flag(field: str, option: Option | None = None) -> str:
    """The name of an option on the command line: --settle-periods, or CASE for one that is given by its place."""
    name = field.strip("_").replace("_", "-")
    return name.upper() if option is not None and option.place else f"--{name}"


def picture(words: str, **more: Any) -> Any:
    """A picture to draw; words: what it shows."""
    return option(f"FILE.png, .svg or .pdf: {words}", check=writable_picture, **more)


def file(words: str, *kinds: str, **more: Any) -> Any:
    """A file to write, with one of these endings."""
    return option(words, check=lambda name, path: writable_file(name, path, kinds), **more)


def folder(words: str, *names: str, **more: Any) -> Any:
    """A folder to write into; names: of files in it that are written anew."""
    return option(words, check=lambda name, path: writable_folder(name, path, *names), **more)


# The type of each stands in the requests.
CASE = required("a case file (.toml), or an exported motion (.nc, .csv)", place=True, sets=("system",))
JSON = option("print one JSON object in full precision", False)
OVER = required(
    "PATH=LEAST:LARGEST, such as drive.amplitude=1:3, or drive.frequency_Hz=0.5:2 of a case in SI",
    sets=("between",),
    offers=completers.paths_of_case,
)
FOR = option(
    "the measure; `vibrocap list measures` lists them",
    "mean_velocity",
    sets=("measure", "objective", "objectives[0]"),
    offers=completers.measure_names,
)
UNCERTAIN = functools.partial(
    option,
    "PATH=LOW:HIGH, PATH=normal:MEAN:DEVIATION or PATH=lognormal:MEDIAN:SIGMA; PATH,PATH=factor:LOW:HIGH for one factor"
    " of the values of the case; friction=fit:FOLDER/fit.json for the uncertainty of a fit; may be repeated",
    offers=completers.paths_of_case,
)
COLUMNS = option("QUANTITY=NAME, such as force=F1,velocity=v, for columns with unusual names")
COLUMN_UNITS = option("QUANTITY=UNIT, such as force=kN or 'force=35.15 N' (of one volt)")
SAMPLING_RATE = option("samples per second (Hz), where there is no column of time", sets=("dt, sampling_rate",))
SEED = option("of random numbers; the same seed gives the same results", 0, advanced=True)
SETTLE_PERIODS = functools.partial(option, "drive periods in which a motion has to settle", advanced=True)
TOLERANCE = functools.partial(
    option, "error per step, relative to the states' natural size [default: the case's]", advanced=True
)


PICTURES, TABLES, FILMS = (".png", ".svg", ".pdf"), (".nc", ".csv", ".xlsx", ".mat"), (".mp4", ".gif")


def writable_file(option: str, path: Path | None, kinds: Iterable[str]) -> None:
    """Refusal for a file that cannot be written, or whose folder is not there. None is no file."""
    if path is None:
        return
    if path.suffix.lower() not in kinds:
        text = f"ends in {path.suffix!r}" if path.suffix else "has no ending"
        raise Refusal(f"{option}: should end in {' or '.join(kinds)}, but {str(path)!r} {text}")
    if path.is_dir():
        raise Refusal(f"{option}: {str(path)!r} is a folder; give the name of a file in it")
    if not path.parent.exists():
        raise Refusal(f"{option}: there is no folder {str(path.parent)!r}; make it first, or give another name")
    writable_folder(option, path.parent)
    if reason := other_place(path):
        raise Refusal(f"{option}: {str(path)!r} cannot be written: {reason}")
    if path.exists() and not os.access(path, os.W_OK):
        raise Refusal(f"{option}: {str(path)!r} exists and cannot be overwritten; give another name")


def writable_picture(option: str, path: Path | None) -> None:
    """Refusal for a picture that cannot be drawn or written. None is no picture."""
    if path is not None:
        writable_file(option, path, PICTURES)
        needs(option, "matplotlib")


def writable_film(option: str, path: Path | None) -> None:
    """Refusal for a film that cannot be made or written. None is no film."""
    if path is not None:
        writable_file(option, path, FILMS)
        needs(option, "matplotlib")
        if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
            needed = "an .mp4 film needs ffmpeg, which is not found; install it, or give a name in .gif"
            raise Refusal(f"{option}: {needed}")


def with_headings(path: Path | None, wanted: bool, option: str) -> None:
    """Refusal for units in headings of a file that has none."""
    if wanted and (path is None or path.suffix.lower() not in HEADED):
        raise Refusal(f"--unit-headings: is for {option} FILE.csv and FILE.xlsx, which have headings")


def writable_table(option: str, path: Path | None, *packages: str, rows: int = 0) -> None:
    """Refusal for numbers that cannot be written, such as NetCDF without its packages. None is no file.

    packages: that NetCDF takes here besides its own; rows: of the table, where that is known
    """
    writable_file(option, path, TABLES)
    if path is None:
        return
    kind = path.suffix.lower()
    if kind == ".nc":
        needs(option, *packages, "h5netcdf", "h5py")
    if kind == ".csv":
        writable_file(option, beside(path), (BESIDE,))
    if kind == ".xlsx":
        needs(option, "openpyxl")
        if rows >= ROWS:
            raise Refusal(f"{option}: {rows:,} rows are more than a sheet of Excel holds; write a .csv or .nc")


def writable_folder(option: str, folder: Path, *names: str) -> None:
    """Refusal for a folder that cannot be written into, or made; names: of files in it that are written anew."""
    for path in (folder / name for name in names):
        if refusal := other_place(path):
            raise Refusal(f"{option}: {str(path)!r} cannot be written: {refusal}")
    there = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    if not there.is_dir():
        raise Refusal(f"{option}: {str(there)!r} is a file; give a folder")
    try:
        with tempfile.TemporaryFile(dir=there):
            pass
    except OSError as error:
        reason = f"cannot write into {str(there)!r} ({error.strerror or error})"
        raise Refusal(f"{option}: {reason}; give a folder that can be written") from None


def own_names(option: str, folder: Path, *names: str) -> None:
    """Refusal for a folder with files of the names that a command gives to its own, but not the first of them.

    A command that writes files of its own names overwrites those that it wrote before, and nobody else's.
    """
    there = [name for name in names if os.path.lexists(folder / name)]
    if there and not (folder / names[0]).is_file():
        reason = f"holds {there[0]}, but no {names[0]}, so that was not written by this command"
        raise Refusal(f"{option}: {str(folder)!r} {reason}; give another folder")


def needs(option: str, *packages: str) -> None:
    """Refusal if packages that the core does not need are not installed."""
    if refusal := lacking(*packages):
        raise Refusal(f"{option}: {refusal}")
