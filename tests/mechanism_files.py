"""Mechanism files with faults: what a stranger may write under [mechanism], drawn at random."""

import copy
import random
import tomllib
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
NAMES = (
    *("described-capsule", "clutch-slips-twice", "plates-creep", "feeder-conveys"),
    "blocks-on-a-shaken-belt",
)
TABLES = {name: tomllib.loads((EXAMPLES / f"{name}.toml").read_text("utf-8")) for name in NAMES}
JUNK = (
    *(
        "",
        " ",
        "x",
        "angle",
        "position",
        "capsule",
        "ground",
        "dynamic",
        "weight",
        "drive",
        "time",
        "pi",
        "lambda",
        "{i}",
    ),
    *(
        "__import__('os').system('touch pwned')",
        "().__class__.__bases__[0]",
        "[x for x in range(9)]",
        "lambda: 0",
        "a.b",
    ),
    *("10**10**10", "9**9**9**9", "2**999", "1e999", "-1e400", "1/0", "0/0", "sqrt(-1)", "exp(exp(9**8))", "0.5**0.5"),
    *("(" * 300, "((((" + "1" + "))))", "-" * 500 + "1", "sin(" * 60 + "1" + ")" * 60, "1 + " * 200 + "1", "x" * 5000),
    *(
        "sin(angle, 1)",
        "sin()",
        "sin",
        "f(x)",
        "angle ** angle",
        "angle ** 2.5",
        "angle if 1 else 2",
        "angle = 2",
        "1; 2",
    ),
    *(
        "(angle + position + 1) ** 8 * (angle + position + 2) ** 8",
        "angle[0]",
        "'text'",
        "f'{1}'",
        "1_000",
        "0x10",
        "1j",
    ),
    *(
        "position + angle",
        "\N{GREEK SMALL LETTER LAMDA}",
        "\N{FULLWIDTH LATIN SMALL LETTER A}",
        "a\x00b",
        "\\",
        "#",
        "1if 1",
    ),
    *(
        "distance('a', 'b')",
        "distance(capsule, bob)",
        "offset(capsule)",
        "> 0",
        "any",
        "m",
        "rad",
        "kg m^2",
        "harmonic",
    ),
    *(0, 1, -1, 0.5, 3, 10**9, 10**400, -0.0, 1e308, float("inf"), float("nan"), True, False, 64, 65, 2**31),
    *([], [1, 2], ["a", "b"], [[[]]], {}, {"a": {"b": {}}}, ["x"] * 10**4),
)


def faulty(seed: int) -> dict:
    """The tables of an example with one to three faults."""
    draw = random.Random(seed)
    tables = copy.deepcopy(TABLES[draw.choice(NAMES)])
    for _ in range(draw.choice((1, 1, 1, 2, 3))):
        places = list(_places(tables["mechanism"]))
        holder, key = draw.choice(places)
        kind = draw.random()
        if kind < 0.55:
            holder[key] = draw.choice(JUNK)
        elif kind < 0.7 and isinstance(holder[key], str):
            holder[key] = _altered(holder[key], draw)
        elif kind < 0.8:
            del holder[key]
        elif kind < 0.9 and isinstance(holder, dict):
            holder[draw.choice([str(each) for each in JUNK if isinstance(each, str)])] = holder.pop(key)
        else:
            other, at = draw.choice(places)
            holder[key] = copy.deepcopy(other[at]) if _holds(other, at) else 1
    return tables


def _holds(holder, key) -> bool:
    return key in holder if isinstance(holder, dict) else key < len(holder)


def _places(tables):
    """All (holder, key) below some tables."""
    for key, each in list(tables.items() if isinstance(tables, dict) else enumerate(tables)):
        yield tables, key
        if isinstance(each, (dict, list)):
            yield from _places(each)


def _altered(text: str, draw: random.Random) -> str:
    """A text with some letters put in, taken out or doubled."""
    for _ in range(draw.randint(1, 3)):
        i = draw.randrange(len(text) + 1)
        text = (
            text[:i]
            + draw.choice(("", "(", ")", "**", "*", "/", "-", "1", " ", ".", "_", "x", text))
            + text[i + draw.randint(0, 2) :]
        )
    return text[:3000]
