"""Pictures for a page: `--width`, `--no-header` and `--style`, which every command takes that draws one."""

import contextlib
import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

from vibrocap.arguments import ArgumentError
from vibrocap.cli.options import Refusal, also_taking, needs
from vibrocap.plotting.look.page import inches, on_page

OPTIONS: dict[str, tuple[Any, Any]] = {
    "width": (str | None, None),
    "no_header": (bool, False),
    "style": (Path | None, None),
}
HELP = """
    width
        of the picture, for a paper: column (3.4 inches), page (7) or a number of inches
    no_header
        leave out of the picture what stands in its caption: title, parameters, small print
    style
        a style sheet of Matplotlib (.mplstyle), whose settings hold over those of the package
"""


def taking_page(command: Callable[..., int]) -> Callable[..., int]:
    """The command with the options of its picture."""

    @functools.wraps(command)
    def run(
        *given: Any, width: str | None = None, no_header: bool = False, style: Path | None = None, **options: Any
    ) -> int:
        if width is not None:
            try:
                inches(width)
            except ArgumentError as error:
                raise Refusal(f"--width: {error.complaint.text}") from None
        with on_page(width, not no_header), _styled(style):
            return command(*given, **options)

    return also_taking(command, run, OPTIONS, HELP)


def _styled(path: Path | None) -> contextlib.AbstractContextManager:
    """A context with the settings of a style sheet; Refusal for a file that is none."""
    if path is None:
        return contextlib.nullcontext()
    needs("--style", "matplotlib")
    from vibrocap.plotting.look.style import read_style_sheet, with_settings

    if not path.is_file():
        raise Refusal(f"--style: {str(path)!r} is no file")
    try:
        return with_settings(read_style_sheet(path))
    except ValueError as error:
        raise Refusal(f"--style: {error}") from None
