"""Writes `jet`: the series of one system's equations, of all lanes or of a motion alone."""

from collections.abc import Sequence

from vibrocap.numerics.codegen.guard_polynomial import guard_source
from vibrocap.numerics.codegen.jets import JetWriter
from vibrocap.numerics.codegen.slow_manifold import (
    bounding_decays,
    pair,
    series_writer,
    settled_coefficient,
    store_reach,
)
from vibrocap.numerics.codegen.straight_line import ADDING, CALLING, ZERO, Code, Formula, indented, literal
from vibrocap.numerics.expressions.equations import Equations
from vibrocap.numerics.expressions.graph import Expression, reachable
from vibrocap.numerics.expressions.structure import decay_rates
from vibrocap.numerics.kernel.memory_layout import Layout

TAIL = 4.0  # times the last term: with those that follow it, if each is at most three quarters of the one before
NO_MANIFOLD = ["def slow_jet(floats, lane):", '    """There is none."""']


def jet_source(equations: Equations, layout: Layout, loop: str) -> str:
    """`jet`: Taylor coefficients of states, contact velocity and guards for all lanes.

    `slow_jet`: the same on a slow manifold, of a motion alone or of all lanes that are on one
    """
    if loop == "simd":
        sticks = any(contact.sticks for contact in equations.contacts)
        switched, constant = bool(equations.switches), limits_are_constant(equations)
        guard = guard_source(layout.order, sticks, constant, equations.several, switched)
        slow = range(len(layout.slow))
        body = _series(equations, layout, loop, slow if equations.several else ())
        one = ["def jet(floats):", "    align_stack()", "    lane = all_lanes()", *indented(body), ""]
        other = NO_MANIFOLD
        if layout.slow and not equations.several:
            other = ["def slow_jet(floats, lane):", "    align_stack()", "    slow = floats[SLOW + lane] > 0.0"]
            other += indented(_series(equations, layout, loop, slow))
        return "\n".join([*one, *other, "", guard])
    head = ["def jet(floats):", "    for lane in range(LANES):"]
    lines = [*head, *indented(_series(equations, layout, loop, ()), 8), ""]
    calls = []
    if equations.several and layout.slow:  # of which any may be on theirs, as lanes
        body = _series(equations, layout, loop, range(len(layout.slow)))
        return "\n".join([*lines, "def slow_jet(floats, lane):", *indented(body), ""])
    if pair(layout):
        body = _series(equations, layout, loop, (0, 1))
        lines += ["def slow_jet_pair(floats, lane):", *indented(body), ""]
        calls += ["    if floats[SLOW + lane] > 0.0 and floats[SLOW + LANES + lane] > 0.0:"]
        calls += ["        slow_jet_pair(floats, lane)", "        return"]
    for number in range(len(layout.slow)):
        body = _series(equations, layout, loop, (number,))
        lines += [f"def slow_jet_{number}(floats, lane):", *indented(body), ""]
        calls += [f"    if floats[SLOW + {number} * LANES + lane] > 0.0:", f"        slow_jet_{number}(floats, lane)"]
    return "\n".join([*lines, *(["def slow_jet(floats, lane):", *calls] if calls else NO_MANIFOLD), ""])


def _series(equations: Equations, layout: Layout, loop: str, slow: Sequence[int]) -> list[str]:
    """Lines of the series; slow: numbers of the manifolds on which lanes may be."""
    order = layout.order
    # All lanes share few registers, so that what is read is read late.
    simd = loop == "simd"
    lanes = "slow" if simd and slow and not equations.several else ""
    code = Code(CALLING + ADDING if simd else 0, polynomials=loop != "ensemble", lanes=lanes)
    writer = series_writer(equations, layout, code, slow)
    loads = equations.true_loads.values() if layout.watched else ()
    watched = [LoadSeries(equations.by_momenta(load), writer, order) for load in loads]
    states = layout.states
    code.name("time", code.entry("TIME"))
    for i in range(layout.contacts):
        code.name(f"sliding_{i}", code.entry(f"SIDE + {i} * LANES"))
    imposed_from = states + 1 + layout.switches
    shifts_from = imposed_from + layout.imposed
    held_from = shifts_from + layout.shifts
    located = (*(True for _ in equations.switches), *equations.located)  # of the guards: those that need a series

    def keep(row: int, k: int, value: Formula) -> None:
        """Write a coefficient to its place in the series at once: values wait in registers, of which there are few."""
        code.store(f"SERIES + {row * (order + 1) + k} * LANES", value)

    for k in range(order + 1):
        for i in range(states):
            keep(i, k, settled_coefficient(writer, i, k))
        for i, contact in enumerate(equations.imposed, start=imposed_from):
            keep(i, k, settled_coefficient(writer, contact.state, k, contact.velocity))
        for i, shift in enumerate(equations.shifts[: layout.shifts], start=shifts_from):
            keep(i, k, writer.coefficient(shift.index, k))
        if k < order:
            for i, value in enumerate(equations.holding, start=held_from):
                keep(i, k, writer.coefficient(value.index, k))
        for i, true_load in enumerate(watched, start=held_from + 2 * layout.held):
            for number, term in true_load.at_order(k):
                keep(i, number, term)
        if k == 1 and equations.maybe_stiff:
            first, *others = bounding_decays(equations, layout, writer, decay_rates(equations))
            decay = code.name("decay", first)
            for i, other in enumerate(others):
                decay = code.larger(f"decay_{i}", other, decay)
            code.store("DECAY_RATE", decay)
            store_reach(writer)
        for i, guard in enumerate(equations.guards):
            moves = k == 0 or (located[i] and k < order + (equations.law_switches <= i < len(equations.switches)))
            slope = k == order and bool(equations.loads) and i == len(equations.switches)  # see `law_branches.py`
            if moves or slope or (located[i] and k == order):
                keep(states + 1 + i, k, writer.coefficient(guard.index, 1 if slope else k) if moves or slope else ZERO)
    return code.lines


def limits_are_constant(equations: Equations) -> bool:
    """Whether no contact's limit ever changes along a motion."""
    limits = [contact.limit for contact in equations.contacts if contact.limit is not None]
    return bool(limits) and all(equations.graph.is_constant_in_time(limit.index) for limit in limits)


class LoadSeries:
    """The series of the true load: where it may go within a step."""

    def __init__(self, load: Expression, writer: JetWriter, order: int):
        self.load, self.writer, self.last = load, writer, order - 2
        writer.needed.update(reachable(load.graph, [load.index]))

    def at_order(self, k: int) -> list[tuple[int, Formula]]:
        """(number, value) of the coefficients that are known with the coefficients k of the states."""
        numbers = {0: [], 1: [], 2: [0]}.get(k, [k - 2])
        return [(number, self._term(number)) for number in numbers]

    def _term(self, k: int) -> Formula:
        """The coefficient k; of the last one a bound of itself and of all that follow."""
        value = self.writer.coefficient(self.load.index, k)
        return value * literal(TAIL) if k == self.last else value
