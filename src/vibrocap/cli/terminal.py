"""The terminal: exit codes, complaints on stderr, pages and tables for people, progress and the time left."""

import contextlib
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table
from rich.text import Text

from vibrocap.progress import bar

OK, WRONG_INPUT, INCOMPLETE, INTERRUPTED, BROKEN_PIPE = 0, 2, 3, 130, 141
MINUTE, HOUR, DAY = 60.0, 3600.0, 86_400.0
FIRST_ESTIMATE = 1.0  # seconds of work before an estimate of the time left is worth showing

progress = bar  # as the functions of the package show it in Python


def visible(text: str) -> str:
    """The same with what a terminal would obey (escape sequences, marks of direction) as codes that can be read.

    Names in files are the words of others.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c in "\n\t\xa0" else c.encode("unicode_escape").decode() for c in text)


def complain(message: str) -> None:
    """Print a message to stderr."""
    print(visible(message), file=sys.stderr)


class Page(Console):
    """Where summaries are printed; a reader of a pipe who has seen enough is left to `main`."""

    def __init__(self):
        super().__init__(highlight=False, markup=False, emoji=False)

    def render_str(self, text: str, **options: Any) -> Text:
        """Text without marks of its own, in lines and in the cells of tables."""
        return super().render_str(visible(text), **options)

    def on_broken_pipe(self):
        """Raise the error on, where rich would end the program."""
        raise BrokenPipeError

    def say(self, text: str = "", style: str | None = None) -> None:
        """A line as it is, however long."""
        self.print(text, style=style, soft_wrap=True)

    def rows(self, rows: Iterable[tuple[str, str | None]], width: int) -> None:
        """Names and what is to be said of them, below each other; a row without words is left out."""
        for name, words in rows:
            if words:
                self.say(f"  {name:<{width}}{words}")


def part(heading: str, rows: Iterable[tuple[str, str | None]], width: int) -> Callable[[Page], None]:
    """What prints a heading and rows below it on a page."""

    def printed(page: Page) -> None:
        page.say(heading, style="bold")
        page.rows(rows, width)

    return printed


def table(title: str | None, *columns: str, no_wrap: int = 2) -> Table:
    """An empty table; columns called "value" are set to the right, the first `no_wrap` are not broken."""
    listing = Table(title=title, title_justify="left", title_style="bold", header_style="dim", box=SIMPLE_HEAD)
    for index, column in enumerate(columns):
        listing.add_column(column, justify="right" if column == "value" else "left", no_wrap=index < no_wrap)
    return listing


def parameters_in_words(part: Any, name: str = "", system: Any = None) -> Table:
    """The parameters of a part with their symbols, values and meanings; in SI as the part of this name of a system."""
    from vibrocap.physics.dimensions.stated import parameters_stated
    from vibrocap.physics.parameters import parameter_table
    from vibrocap.physics.symbols import printed

    in_si = {} if system is None or system.units is None else {own.name: own for own in parameters_stated(name, system)}
    listing = Table(box=None, pad_edge=False)
    for title in ("parameter", "symbol", "value", "meaning"):
        listing.add_column(title, justify="right" if title == "value" else "left")
    for info in parameter_table(part):
        value, called, meaning = getattr(part, info.name), info.name, info.meaning
        unit = ""
        if own := in_si.get(info.name):
            value, called, meaning = own.value, own.stem, info.in_si
            unit = "" if own.unit == "1" else f" {own.unit}"
        shown = f"{value:g}{unit}" if isinstance(value, (int, float)) else "none" if value is None else str(value)
        listing.add_row(called, printed(info.symbol), shown, meaning)
    return listing


@contextlib.contextmanager
def notes() -> Iterator[None]:
    """Warnings within this context are lines on stderr, each of them once."""
    with warnings.catch_warnings():
        warnings.simplefilter("once", UserWarning)
        warnings.showwarning = lambda message, *_: complain(f"Note: {message}")
        yield


class TimeLeft:
    """The time that work still takes, from the first share reported on (above 0 for work that was resumed)."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._begun: tuple[float, float] | None = None  # (when, share done) of the first report

    def words(self, share: float) -> str:
        """Such as "about 3 min left"; empty while nothing can be said."""
        now = self._clock()
        if self._begun is None:
            self._begun = (now, share)
        start, before = self._begun
        if share <= before or now - start < FIRST_ESTIMATE:
            return ""
        return f"about {duration((now - start) * (1.0 - share) / (share - before))} left"


def duration(seconds: float) -> str:
    """A time in the unit that suits it, to two digits or so."""
    if seconds < 9.5:
        return f"{seconds:.1f} s"
    for limit, length, unit in ((99.5, 1.0, "s"), (99.5 * MINUTE, MINUTE, "min"), (47.5 * HOUR, HOUR, "h")):
        if seconds < limit:
            return f"{seconds / length:.0f} {unit}"
    return f"{seconds / DAY:.1f} days"


def said(value: float, unit: str, digits: int = 10) -> str:
    """A number with its unit, if it has one."""
    return f"{value:.{digits}g}" + (f" {unit}" if unit not in ("", "1") else "")
