"""Docstrings of the package, plain text, as the reStructuredText that Sphinx reads.

Plain text here means: paragraphs; indented blocks, which are equations; and lines `name: meaning`, which tell of an
argument or a field and go on indented.
"""

import enum
import inspect
import re
from collections.abc import Collection, Iterable
from typing import Any

from vibrocap.physics.parameters import Part, parameter_table

FIELD = re.compile(r"([a-z_]\w*(?:, [a-z_]\w*)*): (.+)")
SPECIAL = re.compile(r"([\\*|_`])")
CODE = re.compile(r"(`[^`]+`)")
COLUMNS = re.compile(r"(?<=\S) {3,}(?=[a-z_]\w*(?:, [a-z_]\w*)*: |Returns )")  # several fields in a line
SENTENCE_END = (".", ":", ";", ")")


def blocks(lines: Iterable[str]) -> list[list[str]]:
    """Lines without the blank ones, as blocks that stood between them."""
    blocks: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            blocks[-1].append(line.rstrip())
        elif blocks[-1]:
            blocks.append([])
    return [block for block in blocks if block]


def inline(text: str, public: Collection[str]) -> str:
    """A line of text; names between backticks become code, or links where they are public."""
    pieces: list[str] = []
    for piece in CODE.split(text):
        if CODE.fullmatch(piece):
            name = piece.strip("`")
            pieces.append(f":py:obj:`{name} <vibrocap.{name}>`" if name in public else f"``{name}``")
        else:
            plural = "\\ " if pieces and piece[:1].isalnum() else ""  # of a name
            pieces.append(plural + SPECIAL.sub(r"\\\1", piece))
    return "".join(pieces)


def entries(block: list[str]) -> list[tuple[str | None, str]]:
    """A block as paragraphs (None, text) and fields (name, meaning)."""
    fields: list[tuple[str | None, str]] = []
    for line in (part for row in block for part in COLUMNS.split(row)):
        before = fields[-1][1] if fields else "."
        in_field = bool(fields) and fields[-1][0] is not None
        field = FIELD.fullmatch(line) if in_field or before.endswith(SENTENCE_END) else None
        ended = in_field and (before.endswith(".") or line.startswith(("Returns ", "Raises ")))
        if field:
            fields.append((field[1], field[2]))
        elif fields and (line.startswith(" ") or not (ended and line[0].isupper())):
            fields[-1] = (fields[-1][0], f"{before} {line.strip()}")
        else:
            fields.append((None, line.strip()))
    return fields


def as_rst(text: str, public: Collection[str] = ()) -> list[str]:
    """The lines of a docstring in reStructuredText."""
    lines: list[str] = []
    for block in blocks(inspect.cleandoc(text).splitlines()):
        if all(line.startswith("  ") for line in block):
            lines += ["::", "", *(f"  {line}" for line in block), ""]
            continue
        for name, words in entries(block):
            if name is None:
                lines += [inline(words, public), ""]
            else:
                lines += [f"- **{inline(name, public)}**: {inline(words, public)}", ""]
    return lines


def members(thing: Any) -> list[str]:
    """The parameters of a part, or the members of an enumeration, as reStructuredText."""
    if not isinstance(thing, type):
        return []
    if issubclass(thing, enum.Enum):
        return [line for member in thing for line in (f"- ``{member.name}``: {inline(str(member.value), ())}", "")]
    if not issubclass(thing, Part):
        return []
    lines = []
    for info in parameter_table(thing):
        symbol = f" ({inline(info.symbol, ())})" if info.symbol else ""
        lines += [f"- **{inline(info.name, ())}**{symbol}: {inline(info.meaning, ())}", ""]
    return lines
