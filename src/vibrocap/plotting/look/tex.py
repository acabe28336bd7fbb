"""Figures as .tex: drawing commands of PGF, whose letters TeX sets in the fonts of the document.

A document takes one in by \\input{figure.tex}, after \\usepackage{pgf}; it loads nothing else.
"""

import contextlib
import shutil
from collections.abc import Iterator
from pathlib import Path

import matplotlib
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from matplotlib.text import Text

from vibrocap.arguments import ArgumentError

SYSTEMS = (
    "pdflatex",
    "xelatex",
    "lualatex",
)  # in the order in which they are asked for; the first has no fonts of ours
MOST_CELLS = 5000  # of a map: TeX reads a command for each corner
OWN = "% Made by vibrocap. In the preamble: \\usepackage{pgf}\n\\providecommand{\\mathdefault}[1]{#1}%\n"
# What stands in our texts and is no letter of TeX's own.
COMMANDS = {
    "⟨": r"\langle ", "⟩": r"\rangle ", "′": r"{}'", "²": "{}^2", "ₙ": "{}_n", "ω": r"\omega ", "Δ": r"\Delta ",
    "λ": r"\lambda ", "μ": r"\mu ", "ϵ": r"\epsilon ", "∮": r"\oint ", "≤": r"\leq ", "≥": r"\geq ", "−": "-",
    "₀": "{}_0", "°": r"{}^\circ ", "·": r"\cdot ", "×": r"\times ", "π": r"\pi ", "→": r"\to ", "±": r"\pm ",
}  # fmt: skip
LETTERS = {"\N{NO-BREAK SPACE}": "~", "–": "--", "…": r"\dots{}", "“": "``", "”": "''"}
SPECIAL = {"_": r"\_", "&": r"\&", "#": r"\#"} | {
    each: rf"\ensuremath{{{each}}}" for each in "|<>"
}  # outside of mathematics; Matplotlib sees to % and ^


def tex_system() -> str:
    """The TeX that measures texts: that of `matplotlib.rcParams["pgf.texsystem"]` where it is there, else another.

    Raises ArgumentError where there is none.
    """
    asked = matplotlib.rcParams["pgf.texsystem"]
    wanted = SYSTEMS if asked == matplotlib.rcParamsDefault["pgf.texsystem"] else (asked, *SYSTEMS)
    for name in wanted:
        if shutil.which(name) is not None:
            return name
    listed = ", ".join(SYSTEMS[:-1])
    raise ArgumentError(
        "path",
        f"a picture as .tex needs TeX, which measures its texts: none of {listed} and {SYSTEMS[-1]} is found; "
        "install TeX Live, with the package pgf, or give a name in .pdf",
    )


def write_tex(fig: Figure, path: Path) -> None:
    """Write a figure as commands of PGF.

    Raises ArgumentError where there is no TeX and for a map of more cells than it can read, OSError where it refuses a
    text.
    """
    system = tex_system()
    cells = sum(each.get_array().size for each in fig.findobj(QuadMesh))  # type: ignore[union-attr]
    if cells > MOST_CELLS:
        raise ArgumentError(
            "path", f"a map of {cells:,} cells is too large for TeX ({MOST_CELLS:,} at most); give a name in .pdf"
        )
    from matplotlib.backends.backend_pgf import LatexError

    with _for_tex(fig), matplotlib.rc_context({"pgf.rcfonts": False, "pgf.texsystem": system}):
        try:
            fig.savefig(path, format="pgf", backend="pgf")
        except (LatexError, BrokenPipeError) as error:  # the pipe breaks where TeX ends before it is asked
            said = " ".join(str(error).split())[:300]
            raise OSError(f"{system} cannot measure the texts (has it the package pgf?): {said}") from None
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text(OWN + "".join(line for line in lines if not line.startswith("%%")), encoding="utf-8")


def tex_text(text: str) -> str:
    """A text of a picture as TeX writes it; mathematics stays as it is."""
    parts = text.split("$")
    for place, part in enumerate(parts):
        inside = place % 2 == 1
        table = {key: value if inside else rf"\ensuremath{{{value}}}" for key, value in COMMANDS.items()}
        parts[place] = part.translate(str.maketrans(table | LETTERS | ({} if inside else SPECIAL)))
    return "$".join(parts)


@contextlib.contextmanager
def _for_tex(fig: Figure) -> Iterator[None]:
    """The figure with texts that TeX can set, and nothing drawn as an image; afterwards as it was."""
    texts = [(text, text.get_text()) for text in fig.findobj(Text)]
    images = list(fig.findobj(lambda artist: bool(artist.get_rasterized())))
    for text, words in texts:
        text.set_text(tex_text(words))
    for each in images:
        each.set_rasterized(False)
    try:
        yield
    finally:
        for text, words in texts:
            text.set_text(words)
        for each in images:
            each.set_rasterized(True)
