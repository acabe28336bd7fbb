"""`vibrocap cite`: what to cite for a case."""

from pathlib import Path

from vibrocap.cli.options import refusing, split
from vibrocap.cli.terminal import OK, Page
from vibrocap.io.motion_file import read_source


def cite(case: Path | None = None, /, *, analyses: list[str] | None = None, bibtex: bool = False) -> int:
    """What to cite for a case: vibrocap, and the sources of its machine, its laws, its drive and of the methods used.

    Without a case: vibrocap alone, and the paper from which it started.

    Parameters
    ----------
    case
        a case file (.toml), or a motion exported before (.nc, .csv)
    analyses
        what else was used: orbit, branch, fit and so on, by the name of the command, separated by commas
    bibtex
        print entries for a .bib file
    """
    from vibrocap.citations.cite import cite as cited

    given = None if case is None else read_source(case)
    with refusing("analyses", of="CASE"):
        found = cited(given, analyses=split(analyses))
    if bibtex:
        print(found.bibtex, end="")
    else:
        Page().say(str(found))
    return OK
