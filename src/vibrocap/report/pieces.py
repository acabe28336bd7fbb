"""Small pieces of HTML (numbers to read, tables, pictures, links to data), and a page of a result made of them."""

import base64
import math
import struct
from collections.abc import Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path

from vibrocap.files import write_text

DIGITS = 4  # that are shown; all of them stand in the title
FEW = 6  # numbers, shown at once; more are folded away
LAWS = {
    "LM": "LuGre model: friction of bristles that bend before they slip (eqs 6, 7, 10)",
    "EM": "exponential model: friction that holds at rest and falls as sliding gets faster (eq. 8)",
}


def number(value: float) -> str:
    """A number with as many digits as are read; all its digits stand in the title. "none" for one that is none."""
    if not math.isfinite(value):
        return "none"
    whole = value == round(value) and abs(value) < 1e6
    shown = str(int(value)) if whole else f"{value:.{DIGITS}g}"
    mantissa, _, power = shown.partition("e")
    text = (mantissa + (f"·10<sup>{int(power)}</sup>" if power else "")).replace("-", "\N{MINUS SIGN}")
    if float(shown) == value:
        return f'<span class="n">{text}</span>'
    return f'<data class="n" value="{value!r}" title="{value!r}">{text}</data>'


def law(short: str) -> str:
    """LM or EM, with what it stands for."""
    return f'<abbr title="{escape(LAWS[short])}">{short}</abbr>'


def table(head: Iterable[str], rows: Iterable[Iterable[str]], names: int = 1) -> str:
    """An HTML table; its cells are HTML already. names: columns at the left that name the row."""
    top = "".join(f'<th scope="col">{cell}</th>' for cell in head)
    body = ""
    for row in rows:
        cells = (f'<th scope="row">{cell}</th>' if i < names else f"<td>{cell}</td>" for i, cell in enumerate(row))
        body += f"<tr>{''.join(cells)}</tr>"
    return (
        f'<div class="scroll" tabindex="0" role="group" aria-label="table"><table><thead><tr>{top}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def numbers(values: Mapping[str, float]) -> str:
    """Named numbers, folded away where they are many."""
    if not values:
        return ""
    cells = ((escape(name), number(float(value))) for name, value in values.items())
    rows = "".join(f"<tr><th scope='row'>{name}</th><td>{value}</td></tr>" for name, value in cells)
    inner = f"<table class='numbers'>{rows}</table>"
    return inner if len(values) <= FEW else f"<details><summary>{len(values)} numbers</summary>{inner}</details>"


def picture(path: Path, alternative: str) -> str:
    """A PNG file as part of the page."""
    content = path.read_bytes()
    width, height = struct.unpack(">II", content[16:24])  # of the header that every PNG begins with
    data = base64.b64encode(content).decode("ascii")
    return (
        f'<img alt="{escape(alternative)}" width="{width}" height="{height}" decoding="async" '
        f'src="data:image/png;base64,{data}">'
    )


def data_link(path: str) -> str:
    """A link to a file beside the page."""
    return f'<a href="{escape(path)}"><code>{escape(path)}</code></a>'


def titled(level: int, key: str, title: str) -> str:
    """A heading that is a link to itself."""
    return f'<h{level} id="{key}"><a class="self" href="#{key}">{escape(title)}</a></h{level}>'


def links(titles: Iterable[Sequence[str]], below: str = "") -> str:
    """Items of a list of contents, of (anchor, title); below: what stands in each"""
    return "".join(f'<li><a href="#{key}">{escape(title)}</a>{below}</li>' for key, title in titles)


def page_part(name: str) -> str:
    """A file of this folder that goes into a page."""
    return (files("vibrocap.report") / name).read_text(encoding="utf-8")


def figure(key: str, title: str, path: Path, caption: str, before: str = "") -> str:
    """A figure with its heading, what is said before it, its caption, and its data."""
    return (
        f'<figure id="{key}"><h3><a class="self" href="#{key}">{escape(title)}</a></h3>{before}'
        f'<a href="figures/{key}.png">{picture(path, title)}</a>'
        f"<figcaption>{escape(caption)} Data: {data_link(f'figures/{key}.csv')}.</figcaption>"
        "</figure>"
    )


def facts(values: Mapping[str, str]) -> str:
    """Words by name."""
    return table(["", ""], [[escape(name), escape(text)] for name, text in values.items()])


def listed(heading: str, lines: Sequence[str]) -> str:
    """Lines below a heading; nothing where there is none."""
    if not lines:
        return ""
    return f"<p>{escape(heading)}:</p><ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>"


def write_page(folder: Path, heading: str, parts: Iterable[tuple[str, str]], commands: Sequence[str]) -> Path:
    """Write `report.html` into a folder: parts (title, HTML), and the commands that make all this again."""
    again = "".join(f"<p><code>{escape(command)}</code></p>" for command in commands)
    keyed = [(f"part-{i}", title, inner) for i, (title, inner) in enumerate((*parts, ("How to run this again", again)))]
    body = "".join(f"<section>{titled(2, key, title)}{inner}</section>" for key, title, inner in keyed)
    contents = links((key, title) for key, title, _ in keyed)
    page = (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<meta name="color-scheme" content="light dark"><link rel="icon" href="data:,">'
        f"<title>{escape(heading)}</title><style>{page_part('page.css')}</style></head><body>"
        f'<nav aria-label="Contents"><details open><summary>Contents</summary><ul>{contents}</ul></details></nav>'
        f'<main id="main"><h1>{escape(heading)}</h1>{body}</main></body></html>\n'
    )
    return write_text(folder / "report.html", page)
