"""Words of pictures: symbols as they are set in print, and the parameters of a system in a few lines."""

import re
from collections.abc import Iterable
from typing import Any

from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.symbols import GREEK, printed

LETTERS_PER_INCH = 14.5  # of the type of a title, roughly
EQUALS = "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"


def symbol_text(symbol: str) -> str:
    """A symbol for a picture: "eta_c" and "delta0" with Greek letters and subscripts, as mathematics."""
    found = re.fullmatch(r"([A-Za-z]+)_?([A-Za-z0-9]*)('*)", symbol)
    if found is None:
        return printed(symbol)
    name, below, primes = found.groups()
    letter = rf"\{name}" if name in GREEK else name if len(name) == 1 else rf"\mathrm{{{name}}}"
    upright = below if len(below) < 2 or below.isdigit() else rf"\mathrm{{{below}}}"
    return f"${letter}{f'_{{{upright}}}' if below else ''}{primes}$"


def part_items(record: Any, digits: int = 4, without: str = "") -> list[str]:
    """A machine, law or drive by its name, then "symbol = value" for each of its parameters, but for one of them."""
    items = [f"{law_words(record.name)}:"]
    for info in parameter_table(record):
        value = getattr(record, info.name)
        if value is not None and info.name != without:
            shown = value if isinstance(value, str) else f"{value:.{digits}g}".replace("-", "\N{MINUS SIGN}")
            items.append(f"{symbol_text(info.symbol or info.name)}{EQUALS}{shown},")
    items[-1] = items[-1].rstrip(",:")
    return items


def filled(text: str, letters: int, indent: str = "") -> str:
    """A text in lines of at most so many letters, as they are seen; lines after the first are set in.

    It is broken at spaces, and not within mathematics.
    """
    lines, used = [""], 0
    for word in re.findall(r"(?:\$[^$]*\$|[^ $\n])+", text):
        length = len(re.sub(r"\$([^$]*)\$", lambda found: re.sub(r"\\[A-Za-z]+|[_{}]", "", found[1]) + "x", word))
        if lines[-1] and used + 1 + length > letters:
            lines.append(indent)
            used = len(indent)
        gap = "" if not lines[-1].strip() else " "
        lines[-1] += gap + word
        used += len(gap) + length
    return "\n".join(lines)


def parts_title(parts: Iterable[Any], width: float, more: str = "", without: str = "") -> str:
    """The parameters of some parts, each on lines of its own, for the head of a picture of that width in inches.

    more: what else is said at the end; without: the name of a parameter that is left out, as it varies
    """
    given = [part_items(part, without=without) for part in parts]
    if more:
        given[-1][-1] += ";"
        given[-1].append(more)
    return "\n".join(filled(" ".join(items), round(LETTERS_PER_INCH * width), "    ") for items in given)


def percent(share: float) -> str:
    """A share in percent, to a tenth."""
    return f"{100.0 * share:.1f} %"


def law_words(name: str) -> str:
    """The name of a part in words, as a title begins: "Maxwell slip", "LuGre"."""
    words = re.sub(r"\blugre\b", "LuGre", name.replace("-", " "))
    return words[0].upper() + words[1:]
