"""A drive from a file: two columns, time and value, over one period, as they were measured."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from vibrocap.arguments import ArgumentError, Complaints
from vibrocap.inputs import read_input
from vibrocap.physics.drives.table import DriveTable

LARGEST = 2**26  # bytes


def read_drive_table(
    path: str | Path, interpolation: Literal["cubic", "linear"] = "cubic", amplitude: float = 1.0, stretch: float = 1.0
) -> DriveTable:
    """The drive of a text file with a time and a value in each line, see `DriveTable` for the rest.

    Numbers are separated by commas, semicolons or blanks; a first line of words, empty lines and what follows a # are
    passed over. Nothing is resampled, smoothed or closed.
    Raises ArgumentError for a file that cannot be read or has other lines, ParameterError for a table that does not
    close or whose times do not increase.
    """
    times, values = drive_columns(Path(path))
    return DriveTable(times, values, interpolation, amplitude, stretch)


def drive_columns(path: Path) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """(times, values) of a file, as they stand there."""
    try:
        raw = read_input(path, LARGEST + 1)
        text = raw.decode("utf-8-sig")
    except FileNotFoundError:
        raise ArgumentError("file", f"there is no file {str(path)!r}") from None
    except UnicodeDecodeError:
        raise ArgumentError("file", f"{str(path)!r} is not a text file") from None
    except OSError as error:
        raise ArgumentError("file", f"{str(path)!r} cannot be read: {error.strerror or error}") from None
    if len(raw) > LARGEST:
        raise ArgumentError("file", f"{str(path)!r} should be at most {LARGEST // 2**20} MB")
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = re.split(r"[,;\s]+", line.partition("#")[0].strip(" \t,;"))
        if words == [""]:
            continue
        try:
            time, value = map(float, words)
        except ValueError:
            if not rows and not any(map(_is_number, words)):  # names of the columns
                continue
            place = f"line {number} of {str(path)!r}"
            raise ArgumentError("file", f"{place} should be a time and a value, got {line.strip()!r:.60}") from None
        rows.append((time, value))
    if not rows:
        raise ArgumentError("file", f"{str(path)!r} holds no numbers")
    return tuple(time for time, _ in rows), tuple(value for _, value in rows)


def with_columns(
    drive: Mapping[str, Any], keys: Mapping[str, str], folder: Path, complaints: Complaints
) -> Mapping[str, Any]:
    """The section [drive] of a case with the columns of its `file` in place of that key.

    keys: under which `times` and `values` stand, in SI with their units; folder: of the case
    """
    if "file" not in drive:
        return drive
    rest = {key: value for key, value in drive.items() if key != "file"}
    twice = [key for key in (*keys, *keys.values()) if key in rest]
    name = drive["file"]
    if twice:
        complaints.add("drive.file", f"gives the table once more; give it or {twice[0]}")
    elif not isinstance(name, str):
        complaints.add("drive.file", f"should be the name of a file of two columns, got {name!r}")
    else:
        try:
            times, values = drive_columns(folder / name)
        except ArgumentError as error:
            complaints.append(error.complaint.about(f"drive.{error.complaint.field}"))
        else:
            return rest | {keys["times"]: list(times), keys["values"]: list(values)}
    return rest


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
