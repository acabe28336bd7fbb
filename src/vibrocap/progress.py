"""Progress of long work: a bar on a terminal or in a notebook, also during compilation."""

import contextlib
import functools
import threading
from collections.abc import Callable, Iterator
from typing import Any, ParamSpec, TypeVar

from vibrocap.arguments import ArgumentError, shown

# True: a bar; a function: called now and then with the share done, from 0 to 1
Progress = bool | Callable[[float], None] | None

SHOWN_AFTER = 2.0  # seconds; what takes less needs no progress bar


class _Bar:
    """A bar that is shown: its words, and the stage of the work if that is a special one."""

    def __init__(self, what: str, console: Any):
        from rich.progress import BarColumn, Progress, SpinnerColumn, TaskProgressColumn, TextColumn, TimeElapsedColumn

        words = TextColumn("{task.description}", markup=False)
        columns = (SpinnerColumn(), words, BarColumn(), TaskProgressColumn(), TimeElapsedColumn())
        self.shown = Progress(*columns, console=console, transient=True)
        self.task = self.shown.add_task(what, total=None)  # until a share is known the bar only shows that it lives
        self.what, self.words, self.stage = what, what, ""

    def report(self, share: float, now: str | None = None) -> None:
        """The share done and, if it changes, the present work."""
        self.words = now or self.what
        self.shown.update(self.task, completed=share, total=1.0, description=self._description())

    def enter(self, stage: str) -> None:
        """Say what is done besides the work itself; nothing with ""."""
        self.stage = stage
        self.shown.update(self.task, description=self._description())

    def _description(self) -> str:
        return f"{self.words}: {self.stage}" if self.stage else self.words


_bars: list[_Bar] = []  # that are there now


@contextlib.contextmanager
def bar(what: str) -> Iterator[Callable[..., None]]:
    """A bar for work that takes more than two seconds: on the terminal (stderr, and never in a pipe) or in a notebook.

    Yields a function to be called now and then with the share done and, if it changes, what is being done.
    """
    from rich.console import Console

    console = Console(stderr=True)
    if not (console.is_terminal or console.is_jupyter):
        yield lambda share, now=None: None
        return
    new = _Bar(what, console)
    begin = threading.Timer(SHOWN_AFTER, new.shown.start)
    begin.daemon = True
    begin.start()
    _bars.append(new)
    try:
        yield new.report
    finally:
        _bars.remove(new)
        begin.cancel()
        begin.join()
        new.shown.stop()


@contextlib.contextmanager
def reporting(progress: Progress, what: str) -> Iterator[Callable[..., Any] | None]:
    """The receiver of the progress of long work, by its argument `progress`: a bar, a function, or nothing.

    Raises ArgumentError for an argument that is none of these.
    """
    if progress is None or progress is False:
        yield None
    elif progress is True:
        with bar(what) as report:
            yield report
    elif callable(progress):
        yield progress
    else:
        raise ArgumentError("progress", f"should be True or a function of the share done, got {shown(progress)}")


@contextlib.contextmanager
def stage(words: str) -> Iterator[None]:
    """All bars that are there say so as long as this lasts, such as "compiling"."""
    bars = tuple(_bars)
    for bar in bars:
        bar.enter(words)
    try:
        yield
    finally:
        for line in bars:
            line.enter("")


Given = ParamSpec("Given")
Found = TypeVar("Found")


def shows_progress(what: str, counted: bool = False) -> Callable[[Callable[Given, Found]], Callable[Given, Found]]:
    """A decorator of a function with the keyword argument `progress`: for True it is given what reports to a bar.

    counted: it reports what is done and how much there is, instead of a share
    """

    def decorate(function: Callable[Given, Found]) -> Callable[Given, Found]:
        @functools.wraps(function)
        def run(*args: Given.args, **kwargs: Given.kwargs) -> Found:
            progress: Any = kwargs.get("progress")
            with reporting(progress, what) as report:
                if counted and progress is True and report is not None:
                    kwargs["progress"] = functools.partial(_count, report)
                else:
                    kwargs["progress"] = report
                return function(*args, **kwargs)

        return run

    return decorate


def _count(report: Callable[..., Any], done: float, total: float) -> None:
    report(done / total)


def told(progress: Any) -> Callable[..., Any] | None:
    """The function to report to, within one that `shows_progress`, where there is no truth value any more."""
    return None if isinstance(progress, bool) else progress
