"""The equations of motion of a described machine, written out from its description: plain text, LaTeX, MathML.

    q' = B u + b,     M u' = h - sum of R ds/dq,     N = ... of each contact whose load is no parameter,     H = T + V

as `mechanics/derivation.py` states them, before they are solved: the form in which papers print them.
"""

import collections
import dataclasses
import re
from collections.abc import Iterable, Mapping
from typing import Any, Literal

from vibrocap.physics.machines.machine import Machine
from vibrocap.physics.mechanics.derivation import Derivation
from vibrocap.physics.mechanics.formulas import FUNCTIONS, Formula, mul
from vibrocap.physics.mechanics.parts import Contact, is_word
from vibrocap.physics.mechanics.quantities import Quantity
from vibrocap.physics.mechanics.sums import Sum, total, written
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.symbols import GREEK, machine_symbols, printed

SYMBOL = re.compile(r"([A-Za-z]+)_?(\w*)('*)")


@dataclasses.dataclass(frozen=True)
class Equations:
    """What follows from a description, an equation a line.

    kinematics: rates of coordinates whose speeds are those of contacts   motion: a row of M u' = h - R for each speed
    loads: on contacts   actuator: force along each motion that the drive imposes   energy: kinetic and potential
    """

    kinematics: tuple[str, ...]
    motion: tuple[str, ...]
    loads: tuple[str, ...]
    actuator: tuple[str, ...]
    energy: str

    @property
    def lines(self) -> tuple[str, ...]:
        return (*self.kinematics, *self.motion, *self.loads, *self.actuator, self.energy)


def equations_of(machine: Machine, form: Literal["text", "latex", "mathml"] = "text") -> Equations:
    """The equations of a machine in the symbols of its parameters and coordinates, on level ground.

    A prime is a rate; R is friction, N a load, d the motion that a drive imposes, s a stop that is touched. Parameters
    that are words, such as normal_load = "dynamic", are those of this machine.
    """
    of, _ = machine._form()
    derived = of.derived
    symbols = _symbols(machine, derived)
    write = FORMS[form](symbols, (parameter.operands[0] for parameter in derived.inputs.parameters))
    speeds = [derived.rates[name] for name in derived.names]
    first = derived.inputs.count  # inputs beyond those there are stand for the accelerations
    rises = {name: derived.inputs.tape.input(first + i) for i, name in enumerate(derived.names)}
    for i, rate in enumerate(speeds):
        symbols[first + i] = symbols[_number(of.states, derived, rate)] + "'"

    def line(left: Any, right: Any) -> str:
        return (left if isinstance(left, str) else write.sum(left)) + write.equal + write.sum(right)

    def inertia(direction: Any) -> Sum:
        return total(Sum.of(mul(written(derived.inertia(direction, name)), rises[name])) for name in derived.names)

    def push(direction: Any) -> Sum:
        """h; of the common centre, whose speed it is where the drive imposes a motion, without what cancels."""
        return derived.applied(direction) + derived.weight(direction) if derived.imposes else derived.push(direction)

    def rubbed(direction: Any) -> Sum:
        pairs = zip(derived.paths, derived.inputs.frictions, strict=True)
        return total(path.slope(direction) * Sum.of(friction) for path, friction in pairs)

    def force(direction: Any) -> Sum:
        """What it takes along a direction in which nothing moves by itself."""
        return inertia(direction) - derived.push(direction)

    def load(contact: Contact) -> Sum:
        if is_word(contact.load) and contact.load == "dynamic" and derived._pressed_on(contact):
            return force(contact.body.lift)
        return derived.load_at_rest(contact)

    loads = [f"N_{c}" if len(derived.contacts) > 1 else "N" for c in range(1, len(derived.contacts) + 1)]
    loads = [write.name(load.replace("N", "load") if load in symbols.values() else load) for load in loads]
    constants = [Sum.of(parameter) for parameter in derived.inputs.parameters]
    pressed = list(zip(loads, map(load, derived.contacts), strict=True))
    along = [derived.along[name] for name in derived.names]
    slid = [x for x, rate in zip(along, speeds, strict=True) if x.rate != derived.states[rate]]
    return Equations(
        tuple(line(write.name(symbols[_atom(x)] + "'"), x.rate) for x in slid),
        tuple(line(inertia(name), push(name) - rubbed(name)) for name in derived.names),
        tuple(line(name, value) for name, value in pressed if value not in constants),
        tuple(
            line(write.name("F_a" if k == 0 else f"F_a{k + 1}"), force(("imposed", k)) + rubbed(("imposed", k)))
            for k in range(len(derived.imposed))
        ),
        line(write.name("H"), derived.energy()),
    )


def _atom(x: Quantity) -> int:
    """The number of the input that a coordinate is."""
    ((((atom, _),), _),) = x.value.terms.items()
    return atom.operands[0]


def _number(states: tuple[str, ...], derived: Derivation, name: str) -> int:
    return derived.inputs.states[states.index(name)].operands[0]


def _symbols(machine: Machine, derived: Derivation) -> dict[int, str]:
    """The symbol of each input, by its number; of two with one symbol the second is called by its name."""
    kind, inputs = type(machine), derived.inputs
    numbers = [info for info in parameter_table(kind) if isinstance(getattr(machine, info.name), (int, float))]
    states = {name: symbol for name, (symbol, _) in machine_symbols(kind).items()}
    rubs = ["R"] if len(inputs.frictions) == 1 else [f"R_{i}" for i in range(1, len(inputs.frictions) + 1)]
    named = [
        *zip((inputs.t, inputs.drive, *inputs.gravity), *2 * [("t", "drive", "g_n", "g_t")], strict=True),
        *zip(inputs.frictions, rubs, rubs, strict=True),
        *((parameter, info.symbol, info.name) for parameter, info in zip(inputs.parameters, numbers, strict=True)),
        *zip(inputs.states, states.values(), states, strict=True),
    ]
    for name, derivatives in inputs.signals.items():
        symbol = kind.signals[name].symbol if name in kind.signals else "d"
        named += (
            (derivative, symbol + primes, name + primes)
            for derivative, primes in zip(derivatives, ("", "'", "''"), strict=True)
        )
    taken: set[str] = set()
    symbols = {}
    for formula, symbol, name in named:
        symbols[formula.operands[0]] = name if symbol in taken else symbol
        taken.add(symbol)
    return symbols


class _Text:
    """Writes formulas as plain text, "(lambda + 1) X'' - cos(theta) theta''", in Greek letters."""

    times, function, power, group = " ", "{}({})", "{}^{}", "({})"
    equal, plus, minus, negative = " = ", " + ", " - ", "-"

    def __init__(self, symbols: Mapping[int, str], parameters: Iterable[int]):
        self.symbols, self.parameters = symbols, {*parameters}

    def name(self, symbol: str) -> str:
        return printed(symbol)

    def over(self, above: str, below: str, single: bool) -> str:
        return f"{above}/{below if single else f'({below})'}"

    def sum(self, x: Any) -> str:
        """A sum or whatever else, its positive terms first."""
        factors = [(sign, _factors(term)) for sign, term in _terms(written(x))]
        terms = [(sign * number, above, below) for sign, (number, above, below) in factors]
        text = ""
        for number, above, below in sorted(terms, key=lambda term: term[0] < 0):
            sign = (self.minus if text else self.negative) if number < 0 else self.plus if text else ""
            text += sign + self.product(abs(number), above, below)
        return text or self.number(0.0)

    def number(self, x: float) -> str:
        return f"{x:.12g}"

    def product(self, number: float, above: list[Formula], below: list[Formula]) -> str:
        """A product, over what divides it; equal factors above and below are left out."""
        for factor in [*below]:
            if factor in above:
                above.remove(factor)
                below.remove(factor)
        shown = self.times.join([*([self.number(number)] if number != 1.0 or not above else []), *self.powers(above)])
        over = self.powers(below)
        return self.over(shown, self.times.join(over), len(over) == 1) if over else shown

    def powers(self, factors: Iterable[Formula]) -> list[str]:
        """Factors, equal ones as a power: parameters, sums, states and accelerations, functions."""
        counts = collections.Counter(factors)
        ordered = sorted(counts, key=lambda x: (self.place(x), x.index))
        return [self.atom(x) if (n := counts[x]) == 1 else self.power.format(self.atom(x), n) for x in ordered]

    def place(self, x: Formula) -> int:
        """Where a factor stands among others."""
        return 3 if x.op in FUNCTIONS else 1 if x.op != "input" else 0 if x.operands[0] in self.parameters else 2

    def atom(self, x: Formula) -> str:
        if x.op == "input":
            return self.name(self.symbols[x.operands[0]])
        return (
            self.function.format(x.op, self.sum(x.operands[0])) if x.op in FUNCTIONS else self.group.format(self.sum(x))
        )


class _Latex(_Text):
    """The same as LaTeX."""

    times, function, power, group = r"\,", r"\{}\left({}\right)", "{{{}}}^{{{}}}", r"\left({}\right)"

    def name(self, symbol: str) -> str:
        stem, index, primes = SYMBOL.fullmatch(symbol).groups()  # type: ignore[union-attr]
        stem = f"\\{stem}" if stem in GREEK else stem if len(stem) == 1 else rf"\mathrm{{{stem}}}"
        return stem + (f"_{{{index}}}" if index else "") + primes

    def over(self, above: str, below: str, single: bool) -> str:
        return rf"\frac{{{above}}}{{{below}}}"

    def atom(self, x: Formula) -> str:
        """Roots and arcs have names of their own."""
        if x.op == "sqrt":
            return rf"\sqrt{{{self.sum(x.operands[0])}}}"
        return super().atom(x).replace(r"\atan", r"\arctan")


class _MathML(_Text):
    """The same as MathML, which browsers show."""

    times, function = "<mspace width='0.17em'/>", "<mi>{}</mi><mrow><mo>(</mo>{}<mo>)</mo></mrow>"
    power, group = "<msup><mrow>{}</mrow><mn>{}</mn></msup>", "<mrow><mo>(</mo>{}<mo>)</mo></mrow>"
    equal, plus, minus, negative = (f"<mo>{sign}</mo>" for sign in "=+\N{MINUS SIGN}\N{MINUS SIGN}")

    def name(self, symbol: str) -> str:
        """A symbol, its index below and its primes above."""
        stem, index, primes = SYMBOL.fullmatch(symbol).groups()  # type: ignore[union-attr]
        name = f"<mi>{printed(stem)}</mi>"
        below = f"<mn>{index}</mn>" if index.isdecimal() else f"<mi>{index}</mi>"
        above = f"<mo>{primes}</mo>".replace("'", "\N{PRIME}")
        if index and primes:
            return f"<msubsup>{name}{below}{above}</msubsup>"
        return f"<msub>{name}{below}</msub>" if index else f"<msup>{name}{above}</msup>" if primes else name

    def number(self, x: float) -> str:
        return f"<mn>{super().number(x)}</mn>"

    def over(self, above: str, below: str, single: bool) -> str:
        return f"<mfrac><mrow>{above}</mrow><mrow>{below}</mrow></mfrac>"


FORMS = {"text": _Text, "latex": _Latex, "mathml": _MathML}


def _terms(x: Any, sign: int = 1) -> list[tuple[int, Any]]:
    if not isinstance(x, Formula):
        return [(sign if x > 0 else -sign, abs(x))] if x else []
    if x.op == "neg":
        return _terms(x.operands[0], -sign)
    if x.op in ("add", "sub"):
        a, b = x.operands
        return [*_terms(a, sign), *_terms(b, sign if x.op == "add" else -sign)]
    return [(sign, x)]


def _factors(x: Any) -> tuple[float, list[Formula], list[Formula]]:
    """(number, factors, divisors) of a formula."""
    if not isinstance(x, Formula):
        return float(x), [], []
    if x.op == "neg":
        number, above, below = _factors(x.operands[0])
        return -number, above, below
    if x.op not in ("mul", "div"):
        all_negative = x.op in ("add", "sub") and all(sign < 0 for sign, _ in _terms(x))
        return (-1.0, [-x], []) if all_negative else (1.0, [x], [])
    (c, above, below), (d, more, others) = map(_factors, x.operands)
    return (c * d, above + more, below + others) if x.op == "mul" else (c / d, above + others, below + more)
