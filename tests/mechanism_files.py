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


# Descriptions with the parts that the examples have not: points and lengths, walls, modes, imposed motions.
BRISTLE = """
name = "bristle"
parameters.mass = { default = 1.0, role = "mass" }
parameters.foot = { default = 0.05, role = "mass" }
parameters.stiffness = { default = 40.0, role = "stiffness" }
parameters.bending = { default = 25.0, role = "stiffness" }
parameters.damping = { default = 1.5, role = "viscous damping" }
parameters.lean = { default = 0.3, range = "any", role = "distance" }
coordinates.sag = { unit = "m" }
coordinates.pitch = { unit = "rad" }
coordinates.shift = { unit = "m" }
coordinates.stretch = { unit = "m" }
coordinates.position = { unit = "m" }
mass = [
  { name = "foot 1", mass = "foot", x = "position" },
  { name = "foot 2", mass = "foot", x = "position + 1 + stretch" },
  { name = "body", mass = "mass", x = "position + lean + 0.5 + shift", z = "1 - sag", inertia = 0.1, angle = "pitch" },
]
point = [{ name = "hip {i}", on = "body", x = "{i} - 1.5", repeat = 2 }]
drive = [{ path = "-sag" }]
spring = [
  { repeat = 2, stiffness = "stiffness", stretch = "distance('foot {i}', 'hip {i}')", rest = "sqrt(1 + lean**2)" },
  { repeat = 2, stiffness = "bending", stretch = "offset('foot {i}', 'hip {i}')", rest = "lean" },
]
damper = [
  { repeat = 2, damping = "damping", stretch = "distance('foot {i}', 'hip {i}')" },
  { repeat = 2, damping = "damping", stretch = "offset('foot {i}', 'hip {i}')" },
]
contact = [{ repeat = 2, body = "foot {i}" }]
"""
TUBE = """
name = "tube"
signals.shake = { unit = "m" }
parameters.way = { default = 0.6, role = "distance" }
parameters.restitution = { default = 0.7, range = [0, 1], role = "fraction" }
coordinates.offset = { unit = "m" }
support = [{ name = "tube", x = "shake" }]
mass = [{ name = "capsule", on = "tube", mass = 1, x = "offset" }]
stop = [{ between = ["tube", "capsule"], gap = "way", back_gap = "way", restitution = "restitution" }]
drive = [{ path = "offset" }]
contact = [{ body = "capsule", on = "tube", load = 1 }]
"""
BOW = """
name = "bow"
parameters.mass = { default = 0.5, role = "mass" }
parameters.frequency = { default = 1.0, role = "frequency" }
parameters.damping = { default = 0.02, range = ">= 0", role = "fraction" }
parameters.bow_speed = { default = 0.2, range = "any", role = "speed" }
parameters.beta = { default = 0.15, role = "fraction" }
coordinates.mode = { unit = "m", repeat = 3 }
support = [{ name = "bow", x = "bow_speed * time" }]
mass = [{ repeat = 3, name = "mode {i}", mass = "mass", x = "mode_{i}" }]
spring = [{ repeat = 3, stiffness = "mass * ({i} * frequency) ** 2", stretch = "mode_{i}" }]
damper = [{ repeat = 3, damping = "2 * mass * damping * {i} * frequency", stretch = "mode_{i}" }]
point = [
  { name = "one", on = "ground", x = "mode * sin(pi * beta) + mode_2 * sin(2 * pi * beta)" },
  { name = "string", on = "one", x = "mode_3 * sin(3 * pi * beta)" },
]
drive = [{ path = "mode" }]
contact = [{ body = "string", on = "bow", load = 1 }]
"""
WASHBOARD = """
name = "washboard"
parameters.depth = { default = 0.8, range = "any", role = "fraction" }
parameters.length = { default = 1.0, role = "distance" }
parameters.drag = { default = 0.7, range = ">= 0", role = "quadratic damping" }
coordinates.position = { unit = "m", rate = "velocity", repeats = 1.0 }
mass = [{ name = "block", mass = 1, x = "position" }]
drive = [{ path = "position" }]
damper = [{ damping = 0.5, stretch = "position" }]
drag = [{ drag = "drag", stretch = "position", speed = 0.1 }]
contact = [{ body = "block", load = "weight", factor = "1 + depth * cos(2 * pi * position / length)" }]
"""
CRAWLER = """
name = "crawler"
effort = "displacement"
parameters.mass_ratio = { default = 1.0, role = "mass" }
parameters.normal_load = { default = 1.0, role = "load", words = ["weight"] }
coordinates.position = { unit = "m", rate = "centre_velocity" }
mass = [{ name = "body", mass = "mass_ratio", x = "position" }, { name = "inner", on = "body", mass = 1, x = "drive" }]
contact = [{ body = "body", load = "normal_load" }]
"""
