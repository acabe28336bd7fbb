"""The pages of the repository laid out as sources of the site, with links that lead from place to place.

`docs/index.md` says how they are arranged: a heading above a table of pages is a section of the site.
"""

import dataclasses
import functools
import os
import re
import runpy
import shutil
from collections.abc import Mapping
from pathlib import Path

from vibrocap.citations.bibliography import references_page
from vibrocap.paper.errata import errata_page
from vibrocap.physics import symbols

ROOT = Path(__file__).resolve().parents[1]
INDEX = ROOT / "docs" / "index.md"
LINK = re.compile(r"(?<=\]\()(?!\w+:)([^)#\s]*)(#[^)\s]*)?(?=\))")
FENCE = re.compile(r"(^ *```.*?^ *```$)", re.MULTILINE | re.DOTALL)
GALLERY = "gallery/index"


@functools.cache
def published_page(*names: str) -> str:
    """The page that `examples/published/published.py` prints: it runs all cases, or those that are named."""
    return runpy.run_path(str(ROOT / "examples" / "published" / "published.py"))["page"](names)


# Pages that are printed; in the repository a few lines stand in their place.
PRINTED = {
    "symbols.md": symbols.page,
    "references.md": references_page,
    "errata.md": errata_page,
    "published.md": published_page,
}
WIDE = "---\nhtml_theme.sidebar_secondary.remove: true\n---\n\n"  # a page without the list of its headings
ROW = re.compile(r"^\| \[([^\]]+)\]\(([^)]+)\) \| (.+) \|$", re.MULTILINE)

Card = tuple[str, str, str]  # the title of a page, the page, what it answers


@dataclasses.dataclass(frozen=True)
class Entry:
    """A row of the index: a page, where it stands in the repository, and what it answers."""

    title: str
    page: Path
    answer: str


def sections() -> dict[str, list[Entry]]:
    """The sections of `docs/index.md` with their pages, in order."""
    contents = {}
    for part in re.split(r"^## ", INDEX.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]:
        rows = ROW.findall(part)
        if rows:
            entries = [Entry(title, (INDEX.parent / target).resolve(), answer) for title, target, answer in rows]
            contents[part.partition("\n")[0]] = entries
    return contents


def places() -> dict[Path, str]:
    """Where every page of the repository stands among the sources of the site."""
    pages = {path: path.relative_to(ROOT / "docs").as_posix() for path in sorted((ROOT / "docs").rglob("*.md"))}
    pages |= {path: path.relative_to(ROOT / "docs").as_posix() for path in sorted((ROOT / "docs").rglob("*.ipynb"))}
    pages |= {ROOT / f"{name}.md": f"{name.lower()}.md" for name in ("README", "CONTRIBUTING", "CHANGELOG")}
    pages |= {path: f"gallery/{path.stem}.md" for path in sorted((ROOT / "examples").glob("*.toml"))}
    pages[ROOT / "examples" / "README.md"] = "gallery/index.md"
    return pages


def relinked(text: str, page: Path, place: str, known: Mapping[Path, str]) -> str:
    """The text of a page with its links changed to where their targets stand; a file without a page keeps its path."""

    def target(match: re.Match) -> str:
        path, anchor = match[1], match[2] or ""
        if not path:
            return anchor
        there = known.get((page.parent / path).resolve())
        if there is None:
            there = (page.parent / path).resolve().relative_to(ROOT).as_posix().removeprefix("docs/")
        return os.path.relpath(there, Path(place).parent).replace(os.sep, "/") + anchor

    pieces = FENCE.split(text)
    return "".join(piece if i % 2 else LINK.sub(target, piece) for i, piece in enumerate(pieces))


def stage(folder: Path) -> None:
    """Write the pages, their pictures and the files that they link to into a folder."""
    known = places()
    for page, place in known.items():
        if page.suffix == ".toml":
            continue  # a page of the gallery
        copy = folder / place
        copy.parent.mkdir(parents=True, exist_ok=True)
        text = PRINTED[place]() if place in PRINTED else page.read_text(encoding="utf-8")
        copy.write_text(relinked(text, page, place, known), encoding="utf-8")
    shutil.copytree(ROOT / "docs" / "images", folder / "images", ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    for name in ("exchange", "own_parts", "published"):
        ignored = shutil.ignore_patterns("__pycache__")
        shutil.copytree(ROOT / "examples" / name, folder / "examples" / name, ignore=ignored)
    scripts = (path.relative_to(ROOT) for path in (ROOT / "examples").glob("*.py"))
    for name in ("LICENSE", "CITATION.cff", *scripts):
        (folder / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, folder / name)


def cards(entries: list[Card], pictures: Mapping[str, str] | None = None) -> str:
    """A grid of cards, with pictures above where there are any."""
    grid = []
    for title, page, text in entries:
        picture = f":img-top: {pictures[page]}\n:img-alt: {title}\n" if pictures and page in pictures else ""
        grid.append(f":::{{grid-item-card}} {title}\n:link: {page}\n:link-type: doc\n{picture}\n{text}\n:::\n")
    return "::::{grid} 1 2 2 3\n:gutter: 3\n\n" + "\n".join(grid) + "::::\n"


def toctree(pages: list[str]) -> str:
    """A hidden table of contents, for the navigation."""
    lines = ["```{toctree}", ":hidden:", "", *pages, "```"]
    return "\n" + "\n".join(lines) + "\n"


def stage_sections(folder: Path, generated: Mapping[str, list[Card]]) -> list[Card]:
    """Write a page of cards for each section; returns the cards of these pages, the gallery among them.

    generated: by section, the pages that are generated for the site alone
    """
    known, pages = places(), []
    for section, entries in sections().items():
        rows = [(entry.title, known[entry.page].rpartition(".")[0], entry.answer) for entry in entries]
        gallery = [row for row in rows if row[1] == GALLERY]  # a section of its own
        rows = [row for row in rows if row not in gallery] + generated.get(section, [])
        name = section.lower().replace(" ", "-")
        text = f"# {section}\n\n{cards(rows)}{toctree([page for _, page, _ in rows])}"
        (folder / f"{name}.md").write_text(text, encoding="utf-8")
        pages += [*gallery, (section, name, ", ".join(title for title, _, _ in rows))]
    return pages


def stage_first_page(folder: Path, head: str, below: list[Card]) -> None:
    """Write index.md anew: a head, cards in the place of the tables, and the text below them."""
    page = folder / "index.md"
    text = page.read_text(encoding="utf-8")
    text = text[text.index("## The idea") :]
    page.write_text(f"{WIDE}{head}\n{cards(below)}\n{text}{toctree([page for _, page, _ in below])}", encoding="utf-8")
