"""Options: how their texts are read, and the checks of what a command is to write, all of it before any work."""

import contextlib
import inspect
import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vibrocap.arguments import ArgumentError, Complaint, Complaints, lacking, suggestion
from vibrocap.case.sections import SECTIONS, is_section
from vibrocap.files import other_place
from vibrocap.io.spreadsheets import BESIDE, HEADED, ROWS, beside
from vibrocap.physics.dimensions.conversion import Quantity, quantity
from vibrocap.physics.names import split_path
from vibrocap.physics.system import System

PICTURES, TABLES, FILMS = (".png", ".svg", ".pdf"), (".nc", ".csv", ".xlsx", ".mat"), (".mp4", ".gif")


Settings = Annotated[list[str] | None, Parameter(name="--set")]


class Refusal(ValueError):
    """Input that cannot be used: each complaint names an option and what would be right. The exit code is 2."""

    def __init__(self, *complaints: str):
        super().__init__("\n".join(complaints))
        self.complaints = complaints


@contextlib.contextmanager
def refusing(*arguments: str, **options: str) -> Iterator[None]:
    """ValueErrors in the `with` block are about what was asked for: they are refusals that name the option.

    arguments: those of Python that an option of the same name sets; options: other names of options, by argument
    """
    known = {name: f"--{name.replace('_', '-')}" for name in arguments} | options
    try:
        yield
    except ValueError as error:
        if several := getattr(error, "complaints", None):
            raise Refusal(*by_option(several, known)) from None
        named = re.match(rf"({'|'.join(known) or '(?!)'})(?::| (?=should))\s*(.*)", str(error), re.DOTALL)
        raise Refusal(f"{known[named[1]]}: {named[2]}" if named else str(error)) from None


def by_option(complaints: Iterable[str], options: Mapping[str, str]) -> list[str]:
    """The same complaints, with options in place of the fields that they set; options: their names by field."""
    return [
        each.about(options[each.field]) if isinstance(each, Complaint) and each.field in options else each
        for each in complaints
    ]


# --- texts ------------------------------------------------------------------------------------------------------------
def split(texts: "list[str] | None") -> list[str]:
    """Texts, each of which may be several with commas between."""
    return [piece.strip() for text in texts or () for piece in text.split(",") if piece.strip()]


def pairs(option: str, texts: "list[str] | None", complaints: Complaints, wanted: str) -> dict[str, str]:
    """KEY=VALUE pairs; wanted: what a complaint says they should be."""
    found: dict[str, str] = {}
    for text in texts or ():
        key, equals, value = (part.strip() for part in text.partition("="))
        if not (key and equals and value):
            complaints.add(f"--{option} {text}", f"should be {wanted}")
        elif key in found:
            complaints.add(f"--{option} {key}", "is given twice")
        else:
            found[key] = value
    return found


def changes(
    set_: "list[str] | None", initial: "list[str] | None", complaints: Complaints
) -> dict[str, tuple[str, Any]]:
    """What --set PATH=VALUE and --initial NAME=VALUE change in a case, by path: (the option, the value)."""
    found = {}
    for path, text in pairs("set", split(set_), complaints, "PATH=VALUE, such as machine.mass_ratio=2.0").items():
        section, name = split_path(path)
        if not is_section(section):
            complaints.add(f"--set {path}", f"no such section of a case; {suggestion(section, SECTIONS)}")
        elif not name:
            complaints.add(f"--set {path}", f"should be a path such as {section}.NAME")
        else:
            found[path] = f"--set {path}", value_of(text)
    for name, text in pairs("initial", split(initial), complaints, "NAME=VALUE, such as angle=0.5").items():
        if f"initial.{name}" in found:
            complaints.add(f"--initial {name}", "is given by --set too")
        found[f"initial.{name}"] = f"--initial {name}", value_of(text)
    return found


def value_of(text: str) -> int | float | str:
    """A whole number, a number or a word."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text.strip("\"'")


def range_of(
    text: str, option: str = "--over", example: str = "machine.mass_ratio=0.2:8.1"
) -> tuple[str, float, float]:
    """PATH=LEAST:LARGEST."""
    path, _, ends = text.partition("=")
    try:
        low, high = (float(end) for end in ends.split(":"))
    except ValueError:
        raise Refusal(f"{option} should be PATH=LEAST:LARGEST, such as {example}, got {text!r}") from None
    return path, low, high


def quantity_range(text: str, system: System) -> tuple[Quantity, float, float]:
    """PATH=LEAST:LARGEST of a system, the path in SI or not: (the quantity, the range without units)."""
    path, low, high = range_of(text)
    try:
        found = quantity(path, system)
    except ArgumentError as error:
        raise Refusal(f"--over {error}") from None
    return found, low / found.scale, high / found.scale


# --- what is written --------------------------------------------------------------------------------------------------
def writable_file(option: str, path: Path | None, kinds: Iterable[str]) -> None:
    """Refusal for a file that cannot be written, or whose folder is not there. None is no file."""
    if path is None:
        return
    if path.suffix.lower() not in kinds:
        given = f"ends in {path.suffix!r}" if path.suffix else "has no ending"
        raise Refusal(f"{option}: should end in {' or '.join(kinds)}, but {str(path)!r} {given}")
    if path.is_dir():
        raise Refusal(f"{option}: {str(path)!r} is a folder; give the name of a file in it")
    if not path.parent.exists():
        raise Refusal(f"{option}: there is no folder {str(path.parent)!r}; make it first, or give another name")
    writable_folder(option, path.parent)
    if said := other_place(path):
        raise Refusal(f"{option}: {str(path)!r} cannot be written: {said}")
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
            raise Refusal(
                f"{option}: an .mp4 film needs ffmpeg, which is not found; install it, or give a name in .gif"
            )


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
        if said := other_place(path):
            raise Refusal(f"{option}: {str(path)!r} cannot be written: {said}")
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


def also_taking(
    command: Callable[..., int], run: Callable[..., int], options: Mapping[str, tuple[Any, Any]], words: str
) -> Callable[..., int]:
    """`run`, which takes what the command takes and further options, with the signature and the help that this makes.

    options: by name, (annotation, default); words: what their help says
    """
    signature = inspect.signature(command)
    further = [
        inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
        for name, (annotation, default) in options.items()
    ]
    run.__signature__ = signature.replace(parameters=[*signature.parameters.values(), *further])  # type: ignore[attr-defined]
    run.__annotations__ = {**command.__annotations__, **{name: kind for name, (kind, _) in options.items()}}
    said = inspect.cleandoc(command.__doc__ or "")
    heading = "" if "\nParameters\n---" in said else "\n\nParameters\n----------"
    run.__doc__ = said + heading + "\n" + inspect.cleandoc(words) + "\n"
    return run


def needs(option: str, *packages: str) -> None:
    """Refusal if packages that the core does not need are not installed."""
    if said := lacking(*packages):
        raise Refusal(f"{option}: {said}")
