"""What the command line shares: refusals, progress, and the check of what it is to write, before any work."""

import contextlib
import importlib.util
import os
import shutil
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from rich.console import Console

PICTURES = (".png", ".svg", ".pdf")
SHOWN_AFTER = 2.0  # seconds; what takes less needs no progress bar


class Refusal(ValueError):
    """Input that cannot be used; the message names the field and what would be right. The command ends with code 2."""


class Page(Console):
    """Where summaries are printed; a reader of a pipe who has seen enough is left to `main`."""

    def __init__(self):
        super().__init__(highlight=False)

    def on_broken_pipe(self):
        """Raise the error on, where rich would end the program."""
        raise BrokenPipeError


@contextlib.contextmanager
def progress(what: str) -> Iterator[Callable[[float, str | None], None]]:
    """A bar on the terminal (stderr, and never in a pipe) for work that takes more than two seconds.

    Yields a function to be called now and then with the share done and, if it changes, what is being done.
    """
    from rich.progress import BarColumn, Progress, SpinnerColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda share, now=None: None
        return
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        TaskProgressColumn(),
        TimeElapsedColumn(),
    )
    bar = Progress(*columns, console=console, transient=True)
    task = bar.add_task(what, total=None)  # until the first share is known the bar only shows that it lives
    begin = threading.Timer(SHOWN_AFTER, bar.start)
    begin.daemon = True
    begin.start()
    try:
        yield lambda share, now=None: bar.update(task, completed=share, total=1.0, description=now or what)
    finally:
        begin.cancel()
        begin.join()
        bar.stop()


def writable_file(option: str, path: Path, kinds: Iterable[str]) -> Path:
    """The path, if such a file can be written there, its folder being made when it comes to that. Refusal otherwise."""
    if path.suffix.lower() not in kinds:
        given = f"ends in {path.suffix!r}" if path.suffix else "has no ending"
        raise Refusal(f"{option}: should end in {' or '.join(kinds)}, but {str(path)!r} {given}")
    if path.is_dir():
        raise Refusal(f"{option}: {str(path)!r} is a folder; give the name of a file in it")
    writable_folder(option, path.parent)
    if path.exists() and not os.access(path, os.W_OK):
        raise Refusal(f"{option}: {str(path)!r} exists and cannot be overwritten; give another name")
    return path


def writable_picture(option: str, path: Path | None) -> None:
    """Refusal for a picture that cannot be drawn or written. None is no picture."""
    if path is not None:
        writable_file(option, path, PICTURES)
        needs(option, "plot", "matplotlib")


def writable_folder(option: str, folder: Path) -> Path:
    """The folder, if it can be written into, or made. Refusal otherwise."""
    there = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    if not there.is_dir():
        raise Refusal(f"{option}: {str(there)!r} is a file; give a folder")
    try:
        with tempfile.TemporaryFile(dir=there):
            return folder
    except OSError as error:
        reason = f"cannot write into {str(there)!r} ({error.strerror or error})"
        raise Refusal(f"{option}: {reason}; give a folder that can be written") from None


def needs(option: str, extra: str, *packages: str) -> None:
    """Refusal if packages of an optional extra are not installed."""
    missing = [package for package in packages if importlib.util.find_spec(package) is None]
    if missing:
        raise Refusal(f"{option}: needs {' and '.join(missing)}; install it with: pip install 'vibrocap[{extra}]'")


def needs_film(option: str, path: Path) -> None:
    """Refusal if a film of this kind cannot be made here."""
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise Refusal(f"{option}: an .mp4 film needs ffmpeg, which is not found; install it, or give a name in .gif")
