"""On which numbers the equations of a machine are their own mirror image.

The half-period symmetry reverses all states, the drive and friction. Rates and forces along a speed are odd under it,
masses and loads are even. Terms of the other parity must vanish at all states: their factors are conditions.
"""

import math
from collections.abc import Callable, Iterator
from typing import Any

from vibrocap.physics.mechanics.formulas import Formula, Program
from vibrocap.physics.mechanics.parts import Stop, as_sum
from vibrocap.physics.mechanics.quantities import Quantity
from vibrocap.physics.mechanics.sums import Product, Sum, written

ODD, EVEN, NEITHER = -1, 1, math.nan
ODD_FUNCTIONS = ("sin", "tanh", "atan", "neg")


def conditions(motion: Any) -> tuple:
    """What must be zero, of parameters: none where all mirror images are motions, (1.0,) where none is."""
    own = [motion.states[name] for name in motion.own]
    turned = {motion.inputs.drive.operands[0], *(x.operands[0] for x in motion.inputs.states if x not in own)}
    turned |= {quantity.operands[0] for quantity in motion.inputs.signals.get("drive", ())}
    parities, needed = Parities(turned, motion.inputs.changing), []
    for quantity, parity in _quantities(motion.at(motion.states, touching={})):
        needed += parities.factors(Sum.of(quantity), lambda product, own=parity: parities.parity(product) != own)
    for stop in motion.stops:
        needed += _stop_conditions(stop)
    return _zero(needed)


def free_conditions(motion: Any) -> tuple:
    """What must be zero, so that nothing depends on the place: none where nothing ever does."""
    ((place, _),) = next(iter(motion.states[motion.place].terms))
    parities = Parities({place.operands[0]}, motion.inputs.changing)

    def depends(product: Product) -> bool:
        return any(place.operands[0] in Program((atom,), 0).inputs for atom, _ in product)

    quantities = [Sum.of(quantity) for quantity, _ in _quantities(motion)]
    return _zero([factor for quantity in quantities for factor in parities.factors(quantity, depends)])


def _zero(sums: list[Sum]) -> tuple:
    """Conditions, written, without those that follow from others."""
    sums = sorted((sum_found for sum_found in sums if sum_found), key=lambda sum_found: sum(map(len, sum_found.terms)))
    if any(sum_found.number is not None for sum_found in sums):
        return (1.0,)
    zero: set[Formula] = set()
    rest = []
    for sum_found in sums:
        if not all(zero & {atom for atom, _ in product} for product in sum_found.terms):
            rest.append(written(sum_found))
            zero |= {rest[-1]} if len(sum_found.terms) == 1 and isinstance(rest[-1], Formula) else set()
    return tuple(rest)


def _quantities(motion: Any) -> Iterator[tuple[Any, int]]:
    """What follows for a motion, each with its parity."""
    yield from ((quantity.rate, ODD) for quantity in motion.along.values())
    for i in motion.names:
        yield motion.push(i), ODD
        yield from ((motion.inertia(i, j), EVEN) for j in motion.names)
    for path in motion.paths:
        yield from ((path.rate, ODD), (path.curvature, ODD))
        yield from ((slope, EVEN) for i, slope in path.slopes.items() if i in motion.names)
    yield from ((stop.way.value, ODD) for stop in motion.stops)
    for contact in motion.contacts:
        yield Quantity.of(contact.factor).value, EVEN
        if motion.moving_loads:
            yield motion.load_at_rest(contact), EVEN
        if motion.moving_loads and isinstance(contact.load, str):
            yield motion.push(contact.body.lift), EVEN
            yield from ((motion.inertia(contact.body.lift, i), ODD) for i in motion.names)


def _stop_conditions(stop: Stop) -> list[Sum]:
    """The stop behind is as far and as hard as the one in front."""
    if stop.back_gap is None:
        return [Sum.of(1.0)]
    pairs = [(stop.gap, stop.back_gap)]
    pairs += [(stop.stiffness, stop.back_stiffness)] if stop.back_stiffness is not None else []
    pairs += [(stop.damping or 0.0, stop.back_damping)] if stop.back_damping is not None else []
    return [as_sum(front) - as_sum(back) for front, back in pairs]


class Parities:
    """Of formulas, by the inputs that change their sign; the others that change, time and signals, are neither."""

    def __init__(self, turned: set[int], changing: set[int]):
        self.turned, self.changing = turned, changing | turned
        self._known: dict[Any, tuple[float, bool]] = {}

    def parity(self, product: Product) -> float:
        return math.prod(self.of(atom)[0] ** n for atom, n in product)

    def factors(self, whole: Sum, wrong: Callable[[Product], bool]) -> list[Sum]:
        """The factors, of parameters alone, of terms that are wrong in a sum."""
        factors: dict[Product, Sum] = {}
        for product, c in whole.terms.items():
            if wrong(product):
                moving = tuple(pair for pair in product if self.of(pair[0])[1])
                fixed = tuple(pair for pair in product if not self.of(pair[0])[1])
                factors[moving] = factors.get(moving, Sum()) + Sum({fixed: c})
        return list(factors.values())

    def of(self, x: Any) -> tuple[float, bool]:
        """(parity, whether it changes during a motion) of a formula."""
        if not isinstance(x, Formula):
            return EVEN, False
        if x not in self._known:
            self._known[x] = self._of(x)
        return self._known[x]

    def _of(self, x: Formula) -> tuple[float, bool]:
        if x.op == "input":
            (number,) = x.operands
            moves = number in self.changing
            return ODD if number in self.turned else NEITHER if moves else EVEN, moves
        own = [self.of(operand) for operand in x.operands]
        moves, (first, *others) = any(moving for _, moving in own), (parity for parity, _ in own)
        if x.op in ("mul", "div"):
            return first * others[0], moves
        if x.op in ("add", "sub"):
            return first if first == others[0] else NEITHER, moves
        if x.op == "cos":
            return first * first, moves
        return first if x.op in ODD_FUNCTIONS or first == EVEN else NEITHER, moves
