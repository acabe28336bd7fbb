"""Words of pictures: symbols as they are set in print, units, and the parameters of a system in a few lines."""

import re
from collections.abc import Iterable, Mapping
from typing import Any

from vibrocap.case.case import Case
from vibrocap.case.sections import kind_path
from vibrocap.physics.dimensions.conversion import path_in_si
from vibrocap.physics.dimensions.stated import Stated, parameters_stated, stated
from vibrocap.physics.dimensions.units import state_keys, written
from vibrocap.physics.names import name_and_number, owner_of
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.symbols import GREEK, machine_symbols, printed, state_symbols
from vibrocap.physics.system import System

LABELS = {
    "time": r"time $\tau$",
    "periods": r"time in drive periods $\tau/T$",
    "bristle": r"bristle deflection $\xi$",
    "bristle_rate": r"bristle rate $\xi'$",
    "friction": r"friction force $R$",
    "reaction": r"normal load $N$",
    "drive": "drive",
}
LETTERS_PER_INCH = 14.5  # of the type of a title, roughly
EQUALS = "\N{NO-BREAK SPACE}=\N{NO-BREAK SPACE}"


def symbol_text(symbol: str) -> str:
    """A symbol for a picture: "eta_c" and "delta0" with Greek letters and subscripts, as mathematics."""
    text = re.fullmatch(r"([A-Za-z]+)_?([A-Za-z0-9]*)('*)", symbol)
    if text is None:
        return printed(symbol)
    name, below, primes = text.groups()
    letter = rf"\{name}" if name in GREEK else name if len(name) == 1 else rf"\mathrm{{{name}}}"
    upright = below if len(below) < 2 or below.isdigit() else rf"\mathrm{{{below}}}"
    return f"${letter}{f'_{{{upright}}}' if below else ''}{primes}$"


def value_text(value: Any, digits: int = 4) -> str:
    """A value as it stands in a title: a word, a number, or of a table how many they are, from where to where."""
    if isinstance(value, str):
        return value
    if isinstance(value, (tuple, list)):
        ends = f"{value_text(min(value), digits)} to {value_text(max(value), digits)}"
        return whole(f"{len(value)} values from {ends}")
    return f"{float(value):.{digits}g}".replace("-", "\N{MINUS SIGN}")


def letters_seen(text: str) -> int:
    """How many letters of a text are seen: mathematics without its commands."""
    return len(re.sub(r"\$([^$]*)\$", lambda match: re.sub(r"\\[A-Za-z]+|[_{}]", "", match[1]) + "x", text))


def filled(text: str, letters: int, indent: str = "") -> str:
    """A text in lines of at most so many letters, as they are seen; lines after the first are set in.

    It is broken at spaces, and not within mathematics.
    """
    lines, used = [""], 0
    for word in re.findall(r"(?:\$[^$]*\$|[^ $\n])+", text):
        length = letters_seen(word)
        if lines[-1] and used + 1 + length > letters:
            lines.append(indent)
            used = len(indent)
        gap = "" if not lines[-1].strip() else " "
        lines[-1] += gap + word
        used += len(gap) + length
    return "\n".join(lines)


def parts_title(parts: Iterable[Any] | Mapping[str, Any], width: float, more: str = "", without: str = "") -> str:
    """The parameters of some parts, each on lines of its own, for the head of a picture of that width in inches.

    parts: by name those of a system, whose signals and contacts are named
    more: what else is said at the end; without: the name of a parameter that is left out, as it varies
    """
    named = parts if isinstance(parts, Mapping) else dict(enumerate(parts))
    lines = [_part_line(name, named, _by_symbol("", x, {f".{without}"}, {})) for name, x in named.items()]
    lines[-1] += f"; {more}" if more else ""
    return "\n".join(filled(line, round(LETTERS_PER_INCH * width), "    ") for line in lines)


def _part_line(name: Any, parts: Mapping[Any, Any], numbers: Iterable[str]) -> str:
    """A part in words with its numbers, after its owner if it has one: "Clamp, harmonic"."""
    kind, owner = parts[name].name, owner_of(str(name), parts).replace("_", " ")
    words = f"{law_words(owner)}, {law_words(kind, first=False)}" if owner else law_words(kind)
    return f"{words}: {', '.join(numbers)}".rstrip(": ")


def percent(share: float) -> str:
    """A share in percent, to a tenth."""
    return f"{100.0 * share:.1f} %"


def law_words(name: str, first: bool = True) -> str:
    """The name of a part in words: "LuGre", "Maxwell slip" where it stands first in a title."""
    words = re.sub(r"\blugre\b", "LuGre", name.replace("-", " "))
    words = re.sub(r"\bpid?\b", lambda match: match[0].upper(), words)
    return words[0].upper() + words[1:] if first else words


def _state_label(name: str, system: System) -> str:
    """A state of a machine, or the place of another body of it, in words with its symbol (`physics/symbols.py`)."""
    machine, symbols = system.machine, machine_symbols(type(system.machine))
    stem, number = name_and_number(name)
    if name in symbols:
        symbol, _ = symbols[name]
        if name in machine.contact_states and re.fullmatch(r"v(_\d+)?", symbol):
            # over a support that moves, or along a path: the rate of no place
            return f"sliding velocity {symbol_text(symbol)}"
    elif stem in symbols:
        symbol = f"{symbols[stem][0]}_{number}"
    else:
        return name.replace("_", " ")
    words = stem.replace("_", " ").replace("angle rate", "angular velocity")
    if name in ("position", "velocity") and machine.cyclic is not None and len(machine.contact_states) == 1:
        words = f"{machine.contact_names[0]} {words}"
    return f"{words} {symbol_text(symbol)}"


def quantity_label(name: str, system: System) -> str:
    """A quantity of a motion in words with its symbol, its name where there are none."""
    machine, (stem, number) = system.machine, name_and_number(name)
    if stem == "contact_velocity":
        contact, state = machine.derived.contacts[0], machine.contact_states[0]
        if len(machine.contact_states) > 1:
            return f"sliding velocity $v_{number}$"
        if not (contact.on is contact.path is None):
            return "sliding velocity $v$"
        if machine.imposes_motion:
            symbol, _ = machine_symbols(type(machine))[machine.place]
            return f"{contact.body.name} velocity {symbol_text(symbol + chr(39))}"
        return f"sliding velocity {_state_label(state, system).rsplit(' ', 1)[1]}"
    if name == "drive" and system.controller is not None:
        return "command $u$"
    if name == "drive":
        imposed = "imposed displacement $z$" if machine.effort == "displacement" else "imposed motion"
        return imposed if machine.imposes_motion else f"drive {machine.effort}"
    if stem == "friction" and len(machine.contact_states) > 1:
        return f"friction $R_{number}$"
    return LABELS.get(name) or _state_label(name, system)


IN_SI = "In SI units."


def with_unit(label: str, name: str, system: System) -> str:
    """A label with the SI unit of a quantity, of a system that knows its scales."""
    return label + bracketed(system.result_units.unit(name))


def bracketed(unit: str) -> str:
    """A unit as it stands behind what has it, in one piece: " [N m s/rad]"; nothing where there is none."""
    return "" if unit == "1" else f" [{whole(unit)}]"


def whole(words: str) -> str:
    """Words between which no line is broken, such as a number and its unit."""
    return words.replace(" ", "\N{NO-BREAK SPACE}")


def scale(name: str, system: System) -> float:
    """By what values of a quantity are multiplied for a picture: to SI, of a system that knows its scales."""
    return system.result_units.factor(name)


def parts_in_si(system: System, width: float, without: str = "") -> str:
    """The parts of a system in SI, each on lines of its own, for the head of a picture of that width in inches.

    without: the path (without units) of a parameter that is left out, as it varies
    """
    lines = []
    for name in system.parts:
        numbers = _worded(name, parameters_stated(name, system), {without}, {})
        if name == "environment" and not numbers:  # level ground, in which nothing else acts
            continue
        lines.append(filled(_part_line(name, system.parts, numbers), round(0.85 * LETTERS_PER_INCH * width), "    "))
    return "\n".join(lines)


def case_words(case: Case, varied: set[str], fixed: Mapping[str, str]) -> str:
    """The kinds of the parts of a case, and what a study left as it is, in SI where the case is.

    Of the environment that is what is not as usual: a slope, a drag, a force.
    varied: paths that vary. fixed: values of paths at which a picture is fixed
    """
    system, si = case.system, case.system.units is not None
    varied = varied | {place[0] for path in varied if si and (place := path_in_si(path, system.parts)) is not None}
    kinds, numbers = [], []
    for name, part in system.parts.items():
        path = kind_path(name)
        kind = fixed.get(path, part.name)
        owner = owner_of(name, system.parts).replace("_", " ")
        if path and path not in varied:
            what = f"friction of {owner}" if owner and path.endswith(".law") else owner or name
            kinds.append(kind if name == "machine" else f"{kind} {what}")
        own = (
            _worded(name, parameters_stated(name, system), varied, fixed)
            if si
            else _by_symbol(name, part, varied, fixed)
        )
        if kind == part.name:
            numbers += [whole(f"{owner} {text}".strip()) for text in own]
    if si:
        states = state_keys(system.si.states)
        starts = stated(written(case.initial, states, system.si, exactly=False) or {}, states)
        numbers += [whole(f"initial {text}") for text in _worded("initial", starts, varied, fixed)]
    else:
        values = {name: value_text(fixed.get(f"initial.{name}", start)) for name, start in case.initial.items()}
        moved = {x: value for x, value in values.items() if value != "0" and f"initial.{x}" not in varied}
        symbols = state_symbols(system.parts)
        numbers += [f"{symbol_text(symbols[name][0])}(0){EQUALS}{value}" for name, value in moved.items()]
    return f"{', '.join(kinds)}; {', '.join(numbers)}"


def _by_symbol(name: str, part: Any, varied: set[str], fixed: Mapping[str, str]) -> list[str]:
    """The parameters of a part, symbol and value; of the environment those that are not as usual."""
    lines = []
    for info in parameter_table(part):
        path = f"{name}.{info.name}"
        value = fixed.get(path, getattr(part, info.name))
        if value is not None and path not in varied and not (name == "environment" and value == info.default):
            is_word = isinstance(getattr(part, info.name), str)  # a word says nothing beside a symbol
            name_in_print = info.name.replace("_", " ") if is_word else symbol_text(info.symbol or info.name)
            lines.append(f"{name_in_print}{EQUALS}{value_text(value)}")
    return lines


def _worded(name: str, statements: Iterable[Stated], varied: set[str], fixed: Mapping[str, str]) -> list[str]:
    """Values of a part that are not zero, in words, with their units; no line is broken within one."""
    lines = []
    for statement in statements:
        if statement.value and not {f"{name}.{statement.key}", f"{name}.{statement.name}"} & varied:
            number = fixed.get(f"{name}.{statement.key}", value_text(statement.value))
            words = f"{statement.stem.replace('_', ' ')}{EQUALS}{number} {statement.unit.removeprefix('1')}"
            lines.append(whole(words.strip()))
    return lines
