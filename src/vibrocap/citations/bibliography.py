"""The bibliography of the package: `bibliography.bib`, read into references that print as text and as BibTeX.

`python -m vibrocap.citations.bibliography` prints the page of all references, which the site holds,
`python -m vibrocap.citations.bibliography paper/paper.md > paper/paper.bib` the entries that a text cites.
"""

import dataclasses
import functools
import re
import sys
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType
from urllib.parse import quote

from vibrocap.arguments import suggestion

FILE = Path(__file__).with_name("bibliography.bib")
KEY = r"[a-z]+\d{4}[a-z]?"  # such as canudas1995; the package itself is "vibrocap"
ENTRY = re.compile(r"@(\w+)\{([\w-]+),\n(.*?)^\}$", re.MULTILINE | re.DOTALL)
FIELD = re.compile(r"  (\w+) = \{(.+)\},")
SOFTWARE = "vibrocap"
PAGE = """# References

The sources of laws, machines, drives and methods, by the keys that `vibrocap simulate --cite bibtex` prints.
A DOI stands where it was looked up.

"""
WORDS = "misc"  # kind of a reference that is given in words


@dataclasses.dataclass(frozen=True)
class Reference:
    """A published work. key: its name in the bibliography; kind, fields: those of BibTeX."""

    key: str
    kind: str
    fields: Mapping[str, str]

    @property
    def authors(self) -> tuple[str, ...]:
        """Their names, given names first."""
        return tuple(_plain(name) for name in re.split(r"\s+and\s+", self.fields.get("author", "")) if name)

    @property
    def text(self) -> str:
        """The reference in one line: authors, title, where and when, the DOI or address where it is known."""
        known = {name: _plain(value) for name, value in self.fields.items()}
        if self.kind == WORDS:
            return known["note"]
        return f"{', '.join(self.authors)}, {known['title']}{_place(known)}"

    @property
    def bibtex(self) -> str:
        """The entry, as it stands in a .bib file."""
        lines = "".join(f"  {name} = {{{value}}},\n" for name, value in self.fields.items())
        return f"@{self.kind}{{{self.key},\n{lines}}}"


def _plain(value: str) -> str:
    """A value without the braces that keep capitals and names together."""
    return re.sub(r"[{}]", "", value)


def _place(known: Mapping[str, str]) -> str:
    """Where and when it was published, such as ", Automatica 30 (1994) 1083-1138, doi 10.1016/...", of plain fields."""
    within = known.get("journal") or known.get("booktitle") or known.get("school") or known.get("institution") or ""
    before = [within, known.get("publisher", ""), known.get("number", "")]
    before += [f"{name} {known[name]}" for name in ("edition", "version") if name in known]
    place = " ".join(part for part in (", ".join(filter(None, before)), known.get("volume", "")) if part)
    place = f", {place} ({known['year']})" if place else f" ({known['year']})"
    pages = f" {known['pages']}" if "pages" in known else ""
    address = f", doi {known['doi']}" if "doi" in known else f", {known['url']}" if "url" in known else ""
    return f"{place}{pages}{address}"


@functools.cache
def bibliography() -> Mapping[str, Reference]:
    """All references of the package by key, in the order of the file; the package's own one has its version.

    Raises ValueError for a line of the file that is neither a comment nor of an entry, and for a key that occurs twice.
    """
    text = FILE.read_text(encoding="utf-8")
    entries: dict[str, Reference] = {}
    for kind, key, body in ENTRY.findall(text):
        lines = {line: FIELD.fullmatch(line) for line in body.splitlines()}
        if wrong := [line for line, match in lines.items() if match is None]:
            raise ValueError(f"{FILE.name}: {key}: should be '  name = {{value}},', got {wrong[0]!r}")
        fields = {match[1]: match[2] for match in lines.values() if match}
        if key in entries:
            raise ValueError(f"{FILE.name}: {key} occurs twice")
        if key == SOFTWARE:
            fields["version"] = version("vibrocap")
        entries[key] = Reference(key, kind, fields)
    rest = [line for line in ENTRY.sub("", text).splitlines() if line and not line.startswith("%")]
    if rest:
        raise ValueError(f"{FILE.name}: belongs to no entry: {rest[0]!r}")
    return MappingProxyType(entries)


def references(source: str, name: str = "source") -> tuple[Reference, ...]:
    """The works that the `source` of a part names, separated by semicolons: each by its key, or in words.

    name: key of the first work that is given in words (others have 2, 3, ... behind it).
    Raises ValueError for what looks like a key and is none, with the nearest one.
    """
    known, entries, words = bibliography(), [], 0
    for work in filter(None, (work.strip() for work in source.split(";"))):
        if work in known:
            entries.append(known[work])
        elif re.fullmatch(KEY, work):
            raise ValueError(f"source: {work!r} is no key of the bibliography; {suggestion(work, known)}")
        else:
            words += 1
            fields = MappingProxyType({"note": work})
            entries.append(Reference(name if words == 1 else f"{name}-{words}", WORDS, fields))
    return tuple(entries)


def cited_keys(text: str) -> tuple[str, ...]:
    """Keys that a text in Markdown cites, as in "[@canudas1995; @leine2004]", in order, each once."""
    keys = re.findall(rf"(?<![\w.])@({KEY}|{SOFTWARE})\b", text)
    return tuple(dict.fromkeys(keys))


def as_bibtex(entries: Iterable[Reference]) -> str:
    """A .bib file of these references."""
    return "\n\n".join(entry.bibtex for entry in entries) + "\n"


def bibliography_of(text: str) -> str:
    """A .bib file of what a text in Markdown cites; KeyError for a key that there is not."""
    return as_bibtex(bibliography()[key] for key in cited_keys(text))


def references_page() -> str:
    """The page of all references, in Markdown."""
    ordered = sorted(bibliography().values(), key=lambda reference: (reference.key != SOFTWARE, reference.key))
    return PAGE + "".join(f"- `{reference.key}`: {_linked(reference)}.\n" for reference in ordered)


def _linked(reference: Reference) -> str:
    """Its text with the DOI as a link; the version is left out, so that the page outlives a release."""
    fields = {name: value for name, value in reference.fields.items() if name != "version"}
    text = dataclasses.replace(reference, fields=fields).text
    address = quote(fields.get("doi", ""), safe="/")
    return re.sub(r"doi (\S+)$", rf"doi [\1](https://doi.org/{address})", text)


if __name__ == "__main__":
    arguments = sys.argv[1:]
    sys.stdout.write(
        bibliography_of(Path(arguments[0]).read_text(encoding="utf-8")) if arguments else references_page()
    )
