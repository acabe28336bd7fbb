"""Destinations: whether the files and folders that a command is to write can be written, before any work."""

import os
import shutil
import tempfile
from collections.abc import Iterable
from pathlib import Path

from vibrocap.arguments import Refusal, lacking
from vibrocap.files import other_place
from vibrocap.io.spreadsheets import BESIDE, HEADED, ROWS, beside

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
