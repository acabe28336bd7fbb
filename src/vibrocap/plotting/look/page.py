"""The page for which pictures are drawn: how wide they are, and whether their parameters stand above them."""

import contextlib
import contextvars
import dataclasses
import math
from collections.abc import Iterator

from vibrocap.arguments import ArgumentError, shown

COLUMN, PAGE = 3.4, 7.0  # inches: a column, and both, of a journal in two columns
LEAST, MOST = 2.5, 40.0  # inches
NARROW = 5.0  # inches: panels of a narrower sheet stand one below the other
WIDTHS = {"column": COLUMN, "page": PAGE}


@dataclasses.dataclass(frozen=True)
class PrintedPage:
    """A page. width: of a figure in inches, or None for the one that suits its panels; header: whether there is one."""

    width: float | None = None
    header: bool = True

    @property
    def narrow(self) -> bool:
        """Whether panels have no room side by side."""
        return self.width is not None and self.width < NARROW

    def width_or(self, usual: float) -> float:
        """The width of a figure that is usually so wide, in inches."""
        return usual if self.width is None else self.width


_PAGE = contextvars.ContextVar("page", default=PrintedPage())  # noqa: B039 (frozen)


def page() -> PrintedPage:
    """The page for which is drawn."""
    return _PAGE.get()


@contextlib.contextmanager
def on_page(width: str | float | None = None, header: bool = True) -> Iterator[None]:
    """A context in which figures are drawn for a page.

    width: "column" (3.4 inches), "page" (7 inches) or a number of inches; by default what suits the panels
    header: whether title and parameters stand above the panels, and small print below
    """
    token = _PAGE.set(PrintedPage(None if width is None else inches(width), header))
    try:
        yield
    finally:
        _PAGE.reset(token)


def inches(width: str | float) -> float:
    """A width in inches; ArgumentError for what is none."""
    try:
        width_in_inches = WIDTHS[width] if isinstance(width, str) and width in WIDTHS else float(width)
    except (TypeError, ValueError):
        width_in_inches = math.nan
    if not LEAST <= width_in_inches <= MOST:
        wanted = f'"column", "page" or a number of inches from {LEAST:g} to {MOST:g}'
        raise ArgumentError("width", f"should be {wanted}, got {shown(width)}")
    return width_in_inches
