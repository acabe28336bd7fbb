"""Writes the proof that a step sees all that its equations hold, from the recorded graph of any law.

A Taylor series knows of a function what its first derivatives at the start of the step tell. From far away those of
exp[-(v/v_s)^2] are below rounding, and the series passes a dip of the speed without friction ever rising there. So for
every *sharp* node of the graph, a function that is no polynomial of the contact velocity or of an internal state of the
law, it is asked over the whole step:

    negligible  G h (largest - least value over the step) <= tolerance      the step cannot notice it at all
    resolved    G h (its size at the start)  >= theta tolerance             its own terms tell, and bound the step
    smooth      x changes by a factor of 2 (1/x, sqrt) or 3 (log, power)    the series converges, whatever it is

Where the contact velocity vanishes, a power that is not whole may only be negligible; of a whole one from the third on
what the first power of its argument beyond the order would add is held to the tolerance besides (`structure.py`).

G is the largest |derivative of a rate by the node| over the step, over the natural size of the state. A guard of the
law's branches is asked like a state, with its derivative itself for G h: it decides even where no rate knows the node
yet (a level that a stuck element will reach). All values over the step are enclosures by interval arithmetic, from
those of the states: |y(s) - y(0)| <= sum of |c_k| h^k. That of G may be far too large, which is safe for "negligible"
only: for "resolved" G is at most BEYOND times as large as at the start. Where a node is none of the three, the step is
too long.

theta: with the size f of an exponential at the start, the terms that a series of order p shows are f r^k/k!, r the
change of the exponent over the step. Where the last is held to the tolerance, what is left out is less than 10 times
that as long as f >= 1e-3 tolerance. The terms of algebraic functions and logarithms fall like a power of the ratio of
step and distance to the singularity: they need a size of 10 tolerances. A logarithm never counts as resolved: in a
power, exp(a log x), the terms of both all but cancel, so that the last ones tell nothing.
"""

import dataclasses
import functools
import math
from collections.abc import Sequence

import numpy as np

from vibrocap.numerics.codegen.enclosures import Enclosures, Interval, Lines, same
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, Graph, evaluate, operands_of, reachable, sensitivity
from vibrocap.numerics.expressions.structure import Speed, gaps, speeds, zero_of_base

SHARP_FUNCTIONS = ("exp", "tanh", "log", "sqrt", "atan", "div", "power")
STEEP = {"exp": 25.0, "tanh": 10.0}  # change of the argument beyond which these change no more
SECANTS = 6
BEYOND = 10.0  # times the slopes at the start of a step: how large its slopes are taken to be for what is resolved
VISIBLE = {"exp": 1e-3, "tanh": 1e-3, "log": math.inf, "sqrt": 10.0, "atan": 10.0, "div": 10.0, "power": 10.0}  # theta


@dataclasses.dataclass(frozen=True)
class SharpArgument:
    """What a sharp exponential or hyperbolic tangent of the contact velocity is a function of."""

    op: str
    argument: Expression


@dataclasses.dataclass(frozen=True)
class Sharpness:
    """The sharp nodes of some rates and guards.

    internal: whether any of them depends on an internal state of the law, or on the velocity of another contact
    arguments: of those exponentials and hyperbolic tangents that depend on the contact velocity alone
    """

    nodes: tuple[int, ...]
    internal: bool
    arguments: tuple[SharpArgument, ...]


def sharpness(
    graph: Graph,
    rates: Sequence[Expression],
    contact: Expression,
    internal: Sequence[Expression],
    divisors: Sequence[Expression] = (),
) -> Sharpness:
    """What in these rates could hide within a step.

    contact: the contact velocity; internal: the internal states of the law, and velocities of other contacts
    divisors: those that are watched elsewhere: no quotient by one of these is asked
    """
    on_contact, on_internal = {contact.index}, {state.index for state in internal}
    bounded = {divisor.index for divisor in divisors}
    sharp, arguments, of_internal = [], [], False
    for index in reachable(graph, [rate.index for rate in rates]):
        op, *operands = graph.nodes[index]
        varying = operands[1:] if op == "div" else operands_of(graph, index)
        by_internal = any(i in on_internal for i in varying)
        watched = op == "div" and operands[1] in bounded
        if op in SHARP_FUNCTIONS and not watched and (by_internal or any(i in on_contact for i in varying)):
            sharp.append(index)
            of_internal = of_internal or by_internal
            if op in STEEP and not by_internal:
                arguments.append(SharpArgument(op, Expression(graph, varying[0])))
        for group in (on_contact, on_internal):
            if any(i in group for i in operands_of(graph, index)):
                group.add(index)
    return Sharpness(tuple(sharp), of_internal, tuple(arguments))


def system_sharpness(equations: Equations) -> tuple[Sharpness, int]:
    """What in the equations of a system could hide within a step, and the contact on which it depends, if on one."""
    velocities = [contact.velocity for contact in equations.contacts]
    internal = [equations.graph.node("state", i) for contact in equations.contacts for i in contact.internal]
    rates = (*equations.rates, *equations.switches)
    # Before a divisor of the forces at contacts vanishes these grow without end, and shorten the steps. So do their
    # derivatives along a tangent, by the same divisor.
    sharpnesses = [
        sharpness(equations.graph, rates, own, [*internal, *velocities[:i], *velocities[i + 1 :]], equations.divisors)
        for i, own in enumerate(velocities)
    ]
    number = next((i for i, sharp in enumerate(sharpnesses) if not sharp.internal), 0)
    return sharpnesses[number], number


def visible_speed(arguments: Sequence[SharpArgument], states: int, parameters: np.ndarray, load: float) -> np.ndarray:
    """Speed from which on none of the exponentials and hyperbolic tangents of a driven law changes any more [runs].

    An exponential is then e^-25 of what it is at rest, a hyperbolic tangent within e^-20 of 1. The secant method on
    logarithms, which finds it at once where the argument is a power of the speed. Limit: an argument for which it does
    not settle within 10 % of the exponent counts as one that does not change.
    """
    largest = np.zeros(len(parameters))

    def size(which: SharpArgument, speed: np.ndarray) -> np.ndarray:
        symbols = [*([0.0] * states), speed, load, 0.0, 0.0]
        (value,) = evaluate([which.argument], 0.0, symbols, 1.0, parameters.T)
        return value

    with np.errstate(all="ignore"):  # a parameter set out of its bounds shows in its run
        for which in arguments:
            rest = size(which, np.zeros(len(parameters)))
            wanted = np.log(STEEP[which.op])
            low, high = np.full(len(parameters), -20.0), np.full(len(parameters), 0.0)  # logarithms of the speed
            below, above = (np.log(np.abs(size(which, np.exp(x)) - rest)) - wanted for x in (low, high))
            for _ in range(SECANTS):
                following = high - above * (high - low) / (above - below)
                following = np.where(np.isfinite(following), following, high)
                low, below, high = high, above, following
                above = np.log(np.abs(size(which, np.exp(high)) - rest)) - wanted
            largest = np.fmax(largest, np.where(np.abs(above) < 0.1, np.exp(high), 0.0))
    return largest


def resolution_source(equations: Equations, order: int, polynomials: bool) -> str:
    """`unresolved`, of a lane or of all.

    order: of the series
    """
    sharp, number = system_sharpness(equations)
    head = "def unresolved(floats, lane, h, lasting, start_low, start_high, low, high, widened):"
    if not sharp.nodes:
        return "\n".join([head, "    return 0.0 * h", ""])
    text = Lines(polynomials)
    graph, contacts = equations.graph, {contact.velocity.index: i for i, contact in enumerate(equations.contacts)}
    for name, place in (("tolerance", "TOLERANCE"), ("time", "TIME")):
        text.lines.append(f"{name} = {text.entry(place)}")
    lost = {node: gap for node, gap in gaps(equations, sharp.nodes).items() if gap[1] > 2}  # two: see `taylor_step`

    def around(place: str, row: str, state: int, over: bool) -> Interval:
        """A value, with how far it may go over the step and by how much it may be off in a proof that is to last."""
        value, parts = text.name(text.entry(place)), [text.excursion(row)] if over else []
        half_width = text.name(" + ".join([*parts, f"widened * {text.entry(f'SCALE + {state} * LANES')}"]))
        return text.name(f"{value} - {half_width}"), text.name(f"{value} + {half_width}")

    def leaf(index: int, over: bool, velocity: Interval) -> Interval | None:
        """What is given, at the start or over the step, with the contact velocity in between."""
        op, *operands = graph.nodes[index]
        if index in contacts and contacts[index] == number:
            return velocity
        if index in contacts:  # as the difference of rates that nearly cancel its enclosure would be far too wide
            row, contact = f"VELOCITY_OF[{contacts[index]}]", equations.contacts[contacts[index]]
            low, high = around(row, row, contact.state, over)
            if over and contact.kind != "smooth":  # its side lasts the step
                side = text.name(text.entry(f"SIDE + {contacts[index]} * LANES"))
                low = text.name(text.conditional(f"{side} > 0.0", f"max({low}, 0.0)", low))
                high = text.name(text.conditional(f"{side} < 0.0", f"min({high}, 0.0)", high))
            return low, high
        if op == "state":
            row = f"SERIES + {operands[0]} * (ORDER + 1) * LANES"
            return around(f"STATE + {operands[0]} * LANES", row, operands[0], over)
        return ("time", text.name("time + h") if over else "time") if op == "time" else None

    def enclosures(velocity: Interval, over: bool = False) -> Enclosures:
        """Enclosures of all nodes, at the start or over the step."""
        inverses = _inverses(equations, text, 2.0 if over else 1.0)
        return Enclosures(graph, text, functools.partial(leaf, over=over, velocity=velocity), inverses)

    step, start = enclosures(("low", "high"), over=True), enclosures(("start_low", "start_high"))
    ends = [enclosures(same(velocity)) for velocity in ("start_low", "start_high")]
    inverses = [f"inverse_scale(floats, {i}, lane)" for i in range(len(equations.rates))]
    text.lines.append("worst = 0.0 * h")

    def near_rest(speed: Speed | None) -> str:
        """The tolerance, or the less to which a contact that leaves rest is held, see `taylor.leaving`."""
        if speed is None or not speed.sticks:
            return "tolerance"
        scale = text.entry(f"SCALE + {speed.state} * LANES")
        return text.name(f"tolerance * leaving({text.size(step.of(speed.expression.index))} / {scale})")

    def weight(slopes: Sequence[Sequence[Expression]], values: Enclosures) -> str:
        """Largest of the slopes of rates, over the step and in natural sizes of the states, and of guards."""
        of_rates = [
            text.name(f"{text.size(values.of(slope.index))} * {inverse}")
            for slope, inverse in zip(slopes[0], inverses, strict=True)
            if slope.value != 0.0
        ]
        of_rates = [text.name(f"{line} * lasting") for line in _largest(text, of_rates)]
        of_guards = [text.size(values.of(slope.index)) for slope in slopes[1] if slope.value != 0.0]
        return _largest(text, of_rates + of_guards)[0]

    for node in sharp.nodes:
        slopes = [[sensitivity(value, node) for value in values] for values in (equations.rates, equations.switches)]
        felt = [slope.index for some in slopes for slope in some if slope.value != 0.0]
        if not felt:
            continue
        least = most = weight(slopes, step)
        if not contacts.keys().isdisjoint(reachable(graph, felt)):
            # A bound that is much too large is safe for what is negligible, and not for what is resolved.
            at_ends = [text.name(f"{BEYOND!r} * {weight(slopes, values)}") for values in ends]
            least = text.smaller(most, text.larger(*at_ends))
        varies, size, smooth = _node(graph, node, text, step, start)
        op, base, *_ = graph.nodes[node]
        theta = VISIBLE[op]
        either = [f"({least} * {size} >= {theta!r} * tolerance)"] if theta < math.inf else []
        either += [f"({smooth})"] if smooth else []
        shown = text.name(" | ".join(either))
        under = reachable(graph, [base]) if op == "power" else ()
        if op == "power":  # without a series nothing of it is shown
            shown = text.name(f"({text.size(start.of(base))} > {zero_of_base(graph, base)!r}) & ({shown})")
        speed = next((speed for speed in speeds(equations) if speed.sticks and speed.expression.index in under), None)
        # Not a number (0 times infinity) is no proof.
        negligible = text.name(f"{most} * {varies} <= {near_rest(speed)}")
        text.lines.append(f"worst = {text.conditional(f'{shown} | {negligible}', 'worst', 'worst + 1.0')}")
        if node in lost:
            speed, m = lost[node]
            first, second, third = (text.entry(f"{speed.row} + {k} * LANES") for k in range(3))
            line, square = (_missed(graph, node, text, step, start, (order - 1) // (k * m)) for k in (1, 2))
            linear = f"abs({second}) >= abs({third}) * h"
            rest = f"(abs({first}) <= FAINT * (abs({second}) + abs({third}) * h) * h)"
            visible = f"{least} * {text.conditional(linear, line, square)} <= {near_rest(speed)}"
            missed = text.conditional("widened == 0.0", text.conditional(visible, "worst", "worst + 1.0"), "worst")
            text.lines.append(f"worst = {text.conditional(rest, missed, 'worst')}")
    return "\n".join([head, *(f"    {line}" for line in text.lines), "    return worst", ""])


def _inverses(equations: Equations, text: Lines, factor: float) -> dict[int, Interval]:
    """One over the divisor of a load that follows the motion, which is the first bound: within a factor of its start.

    What would change it more shortens the step, as it does the load. Of a whole range of states nothing is known.
    """
    if not equations.loads or equations.graph.nodes[equations.loads[0].index][0] != "div":
        return {}
    start = text.name(f"1.0 / {text.entry('SWITCH + BRANCHES * (ORDER + 1) * LANES')}")
    ends = [(f"{start} * {1.0 / factor!r}", "-1e+300"), (f"{start} * {factor!r}", "1e+300")]
    least, most = (text.name(text.conditional("widened == 0.0", near, far)) for near, far in ends)
    return {equations.graph.nodes[equations.loads[0].index][2]: (least, most)}


def _largest(text: Lines, sizes: Sequence[str]) -> list[str]:
    """The largest of some sizes, alone in a list; none of none."""
    largest = list(sizes[:1])
    for other in sizes[1:]:
        largest = [text.larger(largest[0], other)]
    return largest


def _missed(graph: Graph, node: int, text: Lines, step: Enclosures, start: Enclosures, kept: int) -> str:
    """How much of a sharp node is not in its series from rest, which holds this many powers of its argument's change.

    By the next power: of an exponential over its factorial, else over that of the argument at the start.
    """
    op, *operands = graph.nodes[node]
    least, most = step.of(node)
    varies = text.name(f"{most} - {least}")
    if op == "exp":
        return " * ".join([varies] * (kept + 1) + [repr(1.0 / math.factorial(kept + 1))])
    below, above = step.of(operands[-1])
    ratio = text.name(f"({above} - {below}) / ({text.size(start.of(operands[-1]))} + 1e-300)")
    return " * ".join([varies] + [text.smaller(ratio, "1.0")] * kept)


def _node(graph: Graph, node: int, text: Lines, step: Enclosures, start: Enclosures) -> tuple[str, str, str]:
    """(by how much a sharp node varies over the step, its size at the start, condition under which it is smooth)."""
    op, *operands = graph.nodes[node]
    least, most = step.of(node)
    varies = text.name(f"{most} - {least}")
    if op == "exp":
        return varies, start.of(node)[0], ""
    if op == "tanh":
        far = text.size(start.of(node))
        return varies, text.name(f"1.0 - {far} * {far}"), ""
    argument = operands[1 if op == "div" else 0]
    below, above = step.of(argument)
    width = text.name(f"{above} - {below}")
    first_low, first_high = start.of(argument)
    if op == "atan":
        far = text.size((first_low, first_high))
        return varies, text.name(f"{width} / (1.0 + {far} * {far})"), f"{width} <= 1.0"
    nearest = text.larger(below, text.name(f"-{above}"))  # of zero; negative where the divisor passes it
    smooth = f"{width} <= {nearest}"
    if op in ("log", "power"):
        return varies, start.of(node)[0] if op == "power" else "0.0", f"{width} <= 2.0 * {nearest}"
    if op == "sqrt":
        return varies, text.name(f"{width} / (2.0 * {text.function('sqrt', first_high)} + 1e-300)"), smooth
    numerator = text.size(step.of(operands[0]))
    inverse_low, inverse_high = step.inverse(operands[1])
    far = text.size((first_low, first_high))
    varies = text.name(f"{numerator} * ({inverse_high} - {inverse_low})")
    return varies, text.name(f"{numerator} * {width} / ({far} * {far} + 1e-300)"), smooth
