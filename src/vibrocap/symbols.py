"""The page docs/symbols.md: how the symbols of the literature, the names in code and their meanings belong together.

`python -m vibrocap.symbols > docs/symbols.md` writes it; a test keeps it complete. Parameters come from the parts
themselves, so a new law, machine or drive brings its own rows.
"""

import re
from collections.abc import Iterable

from vibrocap.catalogue import drives, laws, machines
from vibrocap.parameters import parameter_table
from vibrocap.scaling import MOTION_UNITS, PARTS_IN_SI, Scales

GREEK = {
    "alpha": "α",
    "delta": "δ",
    "eta": "η",
    "lambda": "λ",
    "nu": "ν",
    "omega": "ω",
    "Omega": "Ω",
    "psi": "ψ",
    "rho": "ρ",
    "sigma": "σ",
    "tau": "τ",
    "theta": "θ",
    "xi": "ξ",
}
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")

# Symbol and meaning of what a motion can be asked for, by name; the states stand first, in their order.
STATES = {
    "angle": ("theta", "angle of the pendulum from upright"),
    "angle_rate": ("theta'", "its rate"),
    "position": ("X", "position of the capsule; nothing depends on it"),
    "velocity": ("X'", "velocity of the capsule"),
    "bristle": ("xi", "mean deflection of the bristles (LuGre)"),
}
QUANTITIES = {
    "time": ("tau", "time"),
    "side": ("sgn v", "direction of sliding, +1 or -1; 0 where the contact sticks"),
    "friction": ("R", "friction force"),
    "holding_force": ("R_0", "friction force that would hold a resting contact"),
    "contact_velocity": ("v", "sliding velocity of the contact"),
    "drive": ("h cos(omega tau)", "force or torque of the drive"),
    "energy": ("H", "kinetic and potential energy of the machine"),
    "contact_energy": ("delta0 xi^2/2", "energy stored in the contact"),
    "momentum": ("p", "momentum along the line of sliding, p' = -R"),
    "bristle_rate": ("xi'", "rate of the bristles' deflection (LuGre)"),
    "drive_work": ("W_drive", "work of the drive since the start; work is positive into the system"),
    "damper_work": ("W_damper", "work of the damper since the start"),
    "contact_sliding_work": ("W_slide", "work lost by sliding since the start"),
    "bristle_loss_work": ("W_bristle", "work lost in deforming the contact since the start"),
    "impulse": ("J", "integral of the friction force since the start"),
}


def printed(symbol: str) -> str:
    """A symbol with its Greek letters and subscripts: "delta0" as "δ₀", "g_0" as "g₀"."""
    greek = re.sub(r"[A-Za-z]+", lambda word: GREEK.get(word[0], word[0]), symbol)
    return re.sub(r"(?<=\w)_?(\d)", lambda digit: digit[1].translate(SUBSCRIPTS), greek)


def page() -> str:
    """The whole page, in Markdown."""
    lines = [
        "# Symbols",
        "",
        "Written by `python -m vibrocap.symbols > docs/symbols.md`, from the parts themselves.",
        "",
        "A path such as `machine.mass_ratio` names a parameter of a system. All is dimensionless unless a unit is",
        "given; time is in units of sqrt(l/g), length in l, mass in m.",
        "",
    ]
    for title, parts in (("Machine", machines()), ("Friction law", laws()), ("Drive", drives())):
        for name, part in parts.items():
            lines += [f"## {title} `{name}`: `{part.__name__}`", "", *_parameters(part), ""]
    lines += ["## States", "", "The state vector, in this order.", "", *_quantities(STATES), ""]
    lines += ["## What else a motion can be asked for", "", *_quantities(QUANTITIES), ""]
    lines += ["## In SI", "", "`Scales` and the records whose fields carry units.", ""]
    for record in (Scales, *PARTS_IN_SI):
        lines += [f"### `{record.__name__}`", "", *_parameters(record), ""]
    return "\n".join(lines)


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> list[str]:
    found = [head, tuple("---" for _ in head), *rows]
    return ["| " + " | ".join(row) + " |" for row in found]


def _parameters(part: type) -> list[str]:
    rows = [(printed(info.symbol), f"`{info.name}`", info.meaning) for info in parameter_table(part)]
    return _table(("symbol", "name in code", "meaning"), rows)


def _quantities(quantities: dict[str, tuple[str, str]]) -> list[str]:
    rows = [
        (printed(symbol), f"`{name}`", meaning, MOTION_UNITS.get(name, ""))
        for name, (symbol, meaning) in quantities.items()
    ]
    return _table(("symbol", "name in code", "meaning", "unit in SI"), rows)


if __name__ == "__main__":
    print(page(), end="")
