"""The page of symbols: how the symbols of the literature, the names in code and their meanings belong together.

`python -m vibrocap.physics.symbols` prints it, and the site holds it; a test keeps it complete. Parameters come from
the parts themselves, so a new law, machine, drive or controller brings its own rows.
"""

import collections
import contextlib
import functools
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from vibrocap.physics.catalogue import controllers, drives, laws, machines, wrappers
from vibrocap.physics.closed_loop.actuator import Actuator
from vibrocap.physics.dimensions.scales import EFFORTS, PER_LOAD, FreeScales
from vibrocap.physics.dimensions.units import DRIVE_UNITS, over_seconds, parameter_keys, quantity_unit
from vibrocap.physics.dimensions.units import QUANTITIES as QUANTITY_UNITS
from vibrocap.physics.drives.scheduled import scheduled
from vibrocap.physics.environment import Environment
from vibrocap.physics.friction.law import Law
from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.names import name_and_number, state_names
from vibrocap.physics.parameters import ParameterInfo, parameter_table

LETTERS = "alpha beta delta epsilon eta gamma kappa lambda mu nu Omega omega phi psi rho sigma tau theta xi"
GREEK: dict[str, str] = dict(zip(LETTERS.split(), "αβδεηγκλμνΩωφψρστθξ", strict=True))
SUBSCRIPTS = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


HEAD = ("symbol", "name in code", "meaning", "default")
# Symbol and meaning of what a motion can be asked for, by name: states of actuators and controllers, of laws, the rest.
OF_CONTROL = {
    "actuator_output": ("u", "force or torque behind an actuator"),
    "saturated": ("s_u", "1 or -1 while the output of an actuator is at its limit"),
    "clipped": ("s_c", "1 or -1 while the command before an actuator is cut off"),
    "held_command": ("u_h", "command of a sampled controller that is held from sample to sample"),
    "pending_command": ("u_p", "command that is to act after its delay"),
    "sampling": ("s_s", "1 after a sample, -1 after its action, 0 before the first (sampled controllers)"),
    "integral_command": ("S", "part of the command of a controller that integrates its error"),
    "command_saturated": ("s_r", "1 or -1 while the command of a controller is at its limit"),
    "observed_bristle": ("z", "deflection of the bristles that an observer of friction believes in"),
}
OF_LAWS = {
    "bristle": ("xi", "mean deflection of the bristles, the elastic deflection of the contact"),
    "bristle_sign": ("sgn xi", "sign of the deflection (Bouc-Wen)"),
    "yielding": ("p_1", "1 where bristles slip, beyond the elastic range (elasto-plastic)"),
    "flowing": ("p_2", "1 where all bristles slip (elasto-plastic)"),
    **{
        name: (symbol.format(i), meaning.format(i))
        for name_of, symbol, meaning in (
            ("element_force_{}", "F_{}", "force of element {} (Maxwell-slip)"),
            ("slipping_{}", "q_{}", "1 where element {} slips (Maxwell-slip)"),
        )
        for i in range(1, 5)
        for name in (name_of.format(i),)
    },
    "log_age": ("phi", "logarithm of the state of the contact, ln(theta v0/D_c) (rate-and-state)"),
    "gap_position": ("u", "position of the joint in its gap (backlash)"),
    "engaged": ("e", "side on which the joint pushes, +1 or -1; 0 in the gap (backlash)"),
}
TOUCHING = ("s", "stop that is touched: 1 in front, -1 behind, 0 none")
QUANTITIES = {
    "time": ("tau", "time"),
    "side": ("sgn v", "direction of sliding, +1 or -1; 0 where the contact sticks"),
    "friction": ("R", "friction force"),
    "holding_force": ("R_0", "friction force that would hold a resting contact"),
    "contact_velocity": ("v", "sliding velocity of the contact"),
    "drive": ("h cos(omega tau)", "force or torque that the drive exerts; the motion that it imposes"),
    "command": ("c", "drive before the actuator, where there is one"),
    "reference": ("r", "reference that the drive gives to a controller"),
    "energy": ("H", "kinetic and potential energy of the machine"),
    "contact_energy": ("delta0 xi^2/2", "energy stored in the contact"),
    "momentum": ("p", "momentum along the line of sliding: its rate is the outer force, if any, less all friction"),
    "outer_force": (
        "F",
        "force from outside along the line of sliding, other than friction (of wall springs, of the environment)",
    ),
    "actuator_force": (
        "F_a",
        "force between body and inner mass that an imposed motion takes (two-mass crawler), or in gap 1 (worms)",
    ),
    "actuator_torque": ("T", "torque on the pendulum that an imposed motion takes (pendulum crawler)"),
    "actuator_power": ("P_a", "power of that force or torque"),
    "reaction": ("N", "normal reaction of the ground, which a load that follows the motion is"),
    "holding_limit": ("R_max", "how far the forces reach that a resting contact can hold, under such a load"),
    "holding_centre": ("R_mid", "their middle"),
    **{f"{name}_rate": (f"{symbol}'", f"rate of {name}") for name, (symbol, _) in OF_LAWS.items()},
    **{f"{name}_rate_2": (f"{symbol}_2'", f"rate of {name}_2") for name, (symbol, _) in OF_LAWS.items()},
    "controller_work": ("W_control", "work of the command of a controller since the start, in place of the drive's"),
    "drive_work": ("W_drive", "work of the drive since the start; work is positive into the system"),
    "damper_work": ("W_damper", "work of the damper since the start"),
    "impact_work": ("W_impact", "work lost in impacts since the start (machines with rigid stops)"),
    "belt_work": ("W_belt", "work since the start of bodies that move as functions of time: a belt, a table, a plate"),
    "drag_work": ("W_drag", "work of the drag since the start (environment)"),
    "outer_force_work": ("W_outer", "work of its constant force since the start (environment)"),
    "gravity_work": ("W_gravity", "work of gravity along the slope since the start (environment)"),
    "contact_sliding_work": ("W_slide", "work lost by sliding since the start"),
    "bristle_loss_work": ("W_bristle", "work lost in deforming the contact since the start"),
    "contact_storage_work": ("W_store", "work returned by bristles less work stored, under such a load"),
    "impulse": ("J", "integral of the friction force since the start"),
    **{
        f"{name}_{i}{ending}": (symbol.format(i), meaning.format(i))
        for i in (2, 3)
        for name, ending, symbol, meaning in (
            ("friction", "", "R_{}", "friction force at contact {} (crawlers, rows; so for all that belongs to it)"),
            ("holding_force", "", "R_0{}", "force that would hold it at rest"),
            ("contact_velocity", "", "v_{}", "its sliding velocity"),
            ("impulse", "", "J_{}", "integral of the friction force there since the start"),
            ("contact_sliding", "_work", "W_slide{}", "work lost by sliding there"),
            ("bristle_loss", "_work", "W_bristle{}", "work lost in deforming it"),
        )
    },
    "bristle_rate_3": ("xi_3'", "rate of bristle_3"),
    "actuator_force_2": ("F_a2", "force in gap 2 that an imposed distance takes (worms)"),
    "reaction_2": ("N_2", "normal reaction of the ground at contact 2, where loads follow the motion"),
    "holding_limit_2": ("R_max2", "how far the forces reach that contact 2 can hold, under such a load"),
    "holding_centre_2": ("R_mid2", "their middle"),
    "contact_storage_2_work": ("W_store2", "work returned by bristles there less work stored, under such a load"),
}


def printed(symbol: str) -> str:
    """A symbol with its Greek letters and subscripts: "delta0" as "δ₀", "g_0" as "g₀"."""
    greek = re.sub(r"[A-Za-z]+", lambda word: GREEK.get(word[0], word[0]), symbol)
    return re.sub(r"(?<=\w)_?(\d)", lambda digit: digit[1].translate(SUBSCRIPTS), greek)


@functools.cache
def machine_symbols(kind: type[Machine]) -> dict[str, tuple[str, str]]:
    """Symbol and meaning of each state of a class of machines, by name."""
    whole = kind.kind().whole
    shared = collections.Counter(coordinate.symbol for coordinate in kind.all_coordinates.values())
    contacts = {speed: i for i, speed in enumerate(dict.fromkeys(whole.speeds), start=1)}
    states: dict[str, tuple[str, str]] = dict.fromkeys(kind.states, TOUCHING)
    for name, coordinate in kind.all_coordinates.items():
        symbol, rate = coordinate.symbol, whole.rates[name]
        symbol = f"{symbol}_{name_and_number(name)[1]}" if shared[symbol] > 1 else symbol
        path = whole.paths[whole.pivots[name]] if name in whole.pivots else None
        speed = f"{symbol}'", "its rate"
        if whole.imposes:
            speed = "p", "velocity of the common centre of mass"
        elif path is not None and (path.slopes.keys() != {name} or path.slope(name).number != 1.0):
            body = kind.contact_names[contacts[rate] - 1]
            speed = f"v_{contacts[rate]}" if len(contacts) > 1 else "v", f"sliding velocity of {body}"
        states |= {name: (symbol, coordinate.meaning), rate: speed}
    return states


def state_symbols(parts: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Symbol and meaning of each state of the parts of a system by name, or of their classes."""
    machine = parts["machine"]
    states = machine_symbols(machine if isinstance(machine, type) else type(machine)) | OF_CONTROL
    for name in state_names(parts):
        law_state, number = name_and_number(name)
        if name not in states:
            symbol, meaning = OF_LAWS.get(law_state if name not in OF_LAWS else name, (name, name))
            further = number > 1 and name not in OF_LAWS and law_state in OF_LAWS
            states[name] = (f"{symbol}_{number}", f"{meaning}, of contact {number}") if further else (symbol, meaning)
    return states


def _all_states() -> dict[str, tuple[str, str]]:
    """Of all machines, controllers and laws; a state of several machines has all that it is there."""
    texts: dict[str, list[tuple[str, str]]] = {}
    for kind in machines().values():
        for name, text in machine_symbols(kind).items():
            texts.setdefault(name, []).append(text)
    pairs = {name: [*map(dict.fromkeys, zip(*several, strict=True))] for name, several in texts.items()}
    states = {name: (" or ".join(symbols), "; ".join(words)) for name, (symbols, words) in pairs.items()}
    return states | OF_CONTROL | OF_LAWS


def page() -> str:
    """The whole page, in Markdown."""
    lines = [
        "# Symbols",
        "",
        "A path such as `machine.mass_ratio` names a parameter of a system. All is dimensionless unless a unit is",
        "given; time is in units of sqrt(l/g), length in l, mass in m. In SI the name is followed by the unit. Laws of",
        "further contacts stand under `friction_2`, `friction_3` and so on, and their states end in that number too:",
        "`bristle_2`; `side_2` is the direction in which the second one slides.",
        "",
    ]
    for title, parts in (
        ("Machine", machines()),
        ("Friction law", laws()),
        ("Drive", drives()),
        ("Controller", controllers()),
    ):
        for name, part in parts.items():
            lines += [f"## {title} `{name}`: `{part.__name__}`", "", *_parameters(part), ""]
        if title == "Friction law":
            lines += _wrapped(title, wrappers(), laws())
        if title == "Drive":
            lines += _wrapped(title, {scheduled.__name__: scheduled}, drives())
    lines += ["## Environment: `Environment`", "", *_parameters(Environment), ""]
    lines += ["## Actuator: `Actuator`", "", *_parameters(Actuator), ""]
    lines += [
        "## States",
        "",
        "Those of machines, then of actuators and controllers, then of laws.",
        "",
        *_quantities(_all_states()),
        "",
    ]
    lines += ["## Further quantities of a motion", "", *_quantities(QUANTITIES), ""]
    lines += ["## Scales", "", "What the units of a machine are, in [machine] of a case in SI or in [scales].", ""]
    records = dict.fromkeys((*(machine.si_scales for machine in machines().values()), FreeScales))
    for record in (record for record in records if parameter_table(record)):
        lines += [f"### `{record.__name__}`", "", *_rows(parameter_table(record)), ""]
    return "\n".join(lines)


def _wrapped(title: str, around: Mapping[str, Callable[[Any], Any]], parts: Mapping[str, Any]) -> list[str]:
    lines = []
    for name, wrapper in around.items():
        rows = _rows(added_parameters(wrapper, parts))
        lines += [f"## Around a {title.lower()}: `{name}-...`, `{name}(...)`", "", *rows, ""]
    return lines


def added_parameters(wrapper: Callable[[Any], Any], parts: Mapping[str, Any]) -> tuple[ParameterInfo, ...]:
    """The parameters that a wrapper adds to those of a part, of the first part that it fits."""
    for part in parts.values():
        with contextlib.suppress(ValueError):
            return parameter_table(wrapper(part))[len(parameter_table(part)) :]
    raise ValueError(f"{wrapper} fits no part")


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> list[str]:
    table = [head, tuple("---" for _ in head), *rows]
    return ["| " + " | ".join(row) + " |" for row in table]


def _parameters(part: type) -> list[str]:
    """The table of a part, with the keys in SI of those of its parameters that have units."""
    efforts = [part.effort] if issubclass(part, Machine) else [*EFFORTS, *([PER_LOAD] if issubclass(part, Law) else [])]
    keys: dict[str, list[str]] = {}
    for effort in efforts:
        for parameter_key in parameter_keys(part, effort).values():
            if parameter_key.has_unit and parameter_key.key not in keys.setdefault(parameter_key.name, []):
                keys[parameter_key.name].append(parameter_key.key)
    rows = [
        (*row, ", ".join(f"`{key}`" for key in keys.get(row[1].strip("`"), ())))
        for row in _cells(parameter_table(part))
    ]
    return _table((*HEAD, "in SI"), rows)


def _rows(parameters: Iterable[ParameterInfo]) -> list[str]:
    return _table(HEAD, _cells(parameters))


def _cells(parameters: Iterable[ParameterInfo]) -> list[tuple[str, ...]]:
    return [(printed(info.symbol), f"`{info.name}`", info.meaning, _default(info)) for info in parameters]


def _default(info: ParameterInfo) -> str:
    """A default as it stands in a case file; nothing where the parameter must be given."""
    if info.default is None:
        return "none"
    return f"{info.default:g}" if isinstance(info.default, (int, float)) else ""


def _unit(name: str) -> str:
    """SI unit of what a motion can be asked for, of any machine and law."""
    if name == "drive":
        return " or ".join(DRIVE_UNITS.values())
    state = name.removesuffix("_rate")
    if name.endswith("_work"):
        return "J"
    units = {known: unit for machine in machines().values() for known, unit in machine.state_units.items()}
    if (own := quantity_unit(name, units)) is not None or state not in QUANTITY_UNITS:
        return own or ""
    return over_seconds(QUANTITY_UNITS[state])


def _quantities(quantities: dict[str, tuple[str, str]]) -> list[str]:
    rows = [(printed(symbol), f"`{name}`", meaning, _unit(name)) for name, (symbol, meaning) in quantities.items()]
    return _table(("symbol", "name in code", "meaning", "unit in SI"), rows)


if __name__ == "__main__":
    print(page(), end="")
